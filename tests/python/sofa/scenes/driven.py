# SPDX-License-Identifier: LGPL-2.1-or-later
"""A controller that sets the force of a load before each step, and reads the state after it."""
import Sofa


class Drive(Sofa.Core.Controller):
    def __init__(self, *args, **kwargs):
        Sofa.Core.Controller.__init__(self, *args, **kwargs)
        self.node = kwargs["node"]
        self.load = self.node.load
        self.begins, self.ends, self.heights = 0, 0, []

    def onAnimateBeginEvent(self, event):
        self.begins += 1
        self.load.totalForce.value = [0, 0, 3.0 * self.begins]

    def onAnimateEndEvent(self, event):
        assert event["dt"] == self.node.getRoot().dt.value
        self.ends += 1
        self.heights.append(float(self.node.dofs.position.value[0][2]))


def createScene(root):
    root.gravity = [0, 0, 0]
    root.dt = 0.1
    root.addObject("DefaultAnimationLoop")
    body = root.addChild("body")
    body.addObject("EulerImplicitSolver")
    body.addObject("CGLinearSolver", iterations=10, tolerance=1e-14, threshold=1e-14)
    body.addObject("MechanicalObject", name="dofs", position=[0, 0, 0])
    body.addObject("UniformMass", totalMass=1.5)
    body.addObject("ConstantForceField", name="load", indices=[0], totalForce=[0, 0, 0])
    root.addObject(Drive(name="drive", node=body))
