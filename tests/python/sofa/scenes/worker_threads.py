# SPDX-License-Identifier: LGPL-2.1-or-later
"""Several roots in a pool of threads, each with its own loop: what they compute is what one alone computes."""
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import Sofa


def simulate(young):
    root = Sofa.Core.Node("root")
    root.addObject("DefaultAnimationLoop")
    root.dt = 0.02
    n = root.addChild("n")
    n.addObject("EulerImplicitSolver")
    n.addObject("CGLinearSolver", iterations=40, tolerance=1e-10, threshold=1e-10)
    n.addObject("RegularGridTopology", n=[4, 3, 3], min=[0, 0, 0], max=[3, 2, 2])
    n.addObject("MechanicalObject", name="mo")
    n.addObject("UniformMass", totalMass=1)
    n.addObject("HexahedronFEMForceField", youngModulus=young, poissonRatio=0.3)
    n.addObject("FixedConstraint", indices=[0, 4, 8])
    Sofa.Simulation.init(root)
    for _ in range(10):
        Sofa.Simulation.animate(root, root.dt.value)
    return n.mo.position.array()


def createScene(root):
    root.addObject("DefaultAnimationLoop")
    youngs = [500., 1000., 500., 2000.]
    with ThreadPoolExecutor(max_workers=3) as pool:
        found = list(pool.map(simulate, youngs))
    assert np.array_equal(found[0], found[2]) and not np.array_equal(found[0], found[1])
    assert np.array_equal(found[3], simulate(2000.))
