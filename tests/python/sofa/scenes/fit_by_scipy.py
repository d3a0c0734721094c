# SPDX-License-Identifier: LGPL-2.1-or-later
"""Young's modulus is found by SciPy: every evaluation makes a scene, ten steps, and lets it go."""
import gc

import numpy as np
import Sofa
import Sofa.Simulation
from scipy.optimize import minimize_scalar


def deflection(young, steps=10):
    root = Sofa.Core.Node("root")
    root.gravity = [0, 0, -10.]
    root.dt = 0.01
    root.addObject("DefaultAnimationLoop")
    n = root.addChild("n")
    n.addObject("EulerImplicitSolver", rayleighStiffness=0.1)
    n.addObject("SparseLDLSolver", template="CompressedRowSparseMatrixMat3x3d")
    n.addObject("RegularGridTopology", n=[6, 2, 2], min=[0, 0, 0], max=[5, 1, 1])
    n.addObject("MechanicalObject", name="mo")
    n.addObject("UniformMass", totalMass=1)
    n.addObject("HexahedronFEMForceField", youngModulus=float(young), poissonRatio=0.3)
    n.addObject("FixedConstraint", indices=[0, 6, 12, 18])
    Sofa.Simulation.init(root)
    for _ in range(steps):
        Sofa.Simulation.animate(root, 0.01)
    found = n.mo.position.value[:, 2].min()
    Sofa.Simulation.unload(root)
    return found


def createScene(rootNode):
    target = deflection(500.)
    found = minimize_scalar(lambda log_e: (deflection(np.exp(log_e)) - target) ** 2, bounds=(np.log(100), np.log(2000)), method="bounded",
                            options={"maxiter": 25, "xatol": 1e-6})
    gc.collect()
    assert abs(np.exp(found.x) / 500 - 1) < 0.02, np.exp(found.x)
    rootNode.addObject("DefaultAnimationLoop")
    rootNode.addData("young", value=float(np.exp(found.x)), type="float")
