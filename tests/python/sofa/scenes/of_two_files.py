# SPDX-License-Identifier: LGPL-2.1-or-later
"""Numbers of a module beside it, paths by sys.path, class attributes, loops and formatted names."""
import os
import sys

import Sofa

sys.path.append(os.path.dirname(os.path.abspath(__file__)))
from params import *  # noqa: E402 F403


class Layer:
    count = 0

    def __init__(self, parent, kind):
        Layer.count += 1
        self.node = parent.addChild(f"layer_{Layer.count}_{kind}")
        self.node.addObject("RegularGridTopology", name="grid", n=[4, 2, 2], min=[0, 0, Layer.count], max=[LENGTH, 1, Layer.count + 1])
        self.node.addObject("MechanicalObject", name="dofs", rotation=[0, 0, math.degrees(ANGLE) * 0])
        self.node.addObject("UniformMass", totalMass=1)
        self.node.addObject("HexahedronFEMForceField", youngModulus=YOUNG[kind], poissonRatio=0.3)
        for box in boxes:
            roi = self.node.addObject("BoxROI", name="box", box=box)
            self.node.addObject("FixedProjectiveConstraint", indices=roi.indices.getLinkPath())


def createScene(root):
    root.addObject("DefaultAnimationLoop")
    root.dt = 0.01
    solver = root.addChild("solver")
    solver.addObject("EulerImplicitSolver")
    solver.addObject("CGLinearSolver", iterations=50, tolerance=1e-8, threshold=1e-8)
    layers = [Layer(solver, kind) for kind in ("soft", "stiff")]
    root.number = Layer.count
    return layers[0].node
