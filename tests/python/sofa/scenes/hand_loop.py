# SPDX-License-Identifier: LGPL-2.1-or-later
"""A script with a main: it is built by with-less functions, stepped by hand, plotted and saved where a library is there."""
import csv
import os
import sys
import tempfile
import time

import numpy as np
import Sofa.Core
import Sofa.Simulation
import SofaRuntime

try:
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
except ImportError:
    plt = None


def createScene(root, young=1000.0):
    SofaRuntime.importPlugin("Sofa.Component.LinearSolver.Iterative")
    root.dt = 0.02
    root.gravity = (0, 0, -9.81)
    root.addObject("DefaultAnimationLoop", computeBoundingBox="0")
    node = root.addChild("rod")
    node.addObject("EulerImplicitSolver", rayleighMass=.1)
    node.addObject("CGLinearSolver", iterations=1e2, tolerance=1e-9, threshold=1e-9)
    node.addObject("RegularGridTopology", n="2 2 5", min="0 0 0", max="1 1 4")
    node.addObject("MechanicalObject", name="state", src="@RegularGridTopology")
    node.addObject("UniformMass", totalMass=0.5)
    node.addObject("HexahedronFEMForceField", name="fem", youngModulus=young, poissonRatio=0)
    node.addObject("FixedProjectiveConstraint", indices=range(4))
    return root


def run(young, steps):
    root = Sofa.Core.Node("root")
    createScene(root, young=young)
    Sofa.Simulation.initRoot(root)
    start = time.time()
    lowest = []
    while len(lowest) < steps:
        Sofa.Simulation.animate(root, root.dt.value)
        Sofa.Simulation.updateVisual(root)
        lowest += [root.rod.state.position.value[:, 2].min()]
    elapsed = time.time() - start
    assert elapsed >= 0 and abs(root.time.value - steps * 0.02) < 1e-9
    return np.array(lowest)


def main(argv=sys.argv):
    results = {young: run(young, 10) for young in (500., 1000.)}
    assert (results[500.0] <= results[1000.0] + 1e-12).all()
    folder = tempfile.mkdtemp()
    with open(os.path.join(folder, "out.csv"), "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(results.keys())
        writer.writerows(zip(*results.values()))
    if plt is not None:
        plt.plot(np.arange(10), results[500.])
        plt.savefig(os.path.join(folder, "out.png"))
        plt.close("all")
    print(folder)


if __name__ == "__main__":
    main()
