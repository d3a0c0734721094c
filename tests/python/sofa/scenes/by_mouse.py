# SPDX-License-Identifier: LGPL-2.1-or-later
"""The mouse drags a node: its force is the way of the pointer while the left button is down; the wheel turns it off."""
import Sofa


class Mouse(Sofa.Core.Controller):
    def __init__(self, *args, **kwargs):
        Sofa.Core.Controller.__init__(self, *args, **kwargs)
        self.load = kwargs["load"]
        self.start = None

    def onMouseEvent(self, event):
        if event["State"] == 1:
            self.start = event["mouseX"], event["mouseY"]
        elif event["State"] == 2:
            self.start = None
        elif event["State"] == 0 and self.start is not None:
            self.load.totalForce.value = [event["mouseX"] - self.start[0], self.start[1] - event["mouseY"], 0]
        elif event["State"] == 5:
            self.load.totalForce.value = [0, 0, event["wheelDelta"]]


class Older(Sofa.PythonScriptController):
    """What it hears, as the older names have it."""

    def onMouseMove(self, x, y):
        self.tell("move", x, y)

    def onMouseButtonRight(self, x, y, pressed):
        self.tell("right", x, y, pressed)

    def onMouseButtonLeft(self, x, y, pressed):
        self.tell("left", x, y, pressed)

    def onMouseWheel(self, x, y, delta):
        self.tell("wheel", x, y, delta)

    def tell(self, *what):
        print("heard", *what, flush=True)


def createScene(root):
    root.gravity = [0, 0, 0]
    root.addObject("DefaultAnimationLoop")
    body = root.addChild("body")
    body.addObject("EulerImplicitSolver")
    body.addObject("CGLinearSolver", iterations=10, tolerance=1e-14, threshold=1e-14)
    body.addObject("MechanicalObject", name="dofs", position=[0, 0, 0])
    body.addObject("UniformMass", totalMass=1)
    body.addObject("ConstantForceField", name="load", indices=[0], totalForce=[0, 0, 0])
    root.addObject(Mouse(name="mouse", load=body.load))
    Older(root)
