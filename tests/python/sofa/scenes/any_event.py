# SPDX-License-Identifier: LGPL-2.1-or-later
"""onEvent() hears what has no method of its own; events of the scene itself."""
import Sofa


class Ear(Sofa.Core.Controller):
    def __init__(self, *args, **kwargs):
        Sofa.Core.Controller.__init__(self, *args, **kwargs)
        self.heard = []
        self.initialised = False

    def init(self):
        self.initialised = True

    def onEvent(self, event):
        self.heard.append(event["type"])


class Mouth(Sofa.Core.Controller):
    def onAnimateBeginEvent(self, event):
        self.sendEvent("hello", 3)

    def onEvent(self, event):
        pass


class Deaf(Ear):
    pass


def createScene(root):
    root.addObject("DefaultAnimationLoop")
    root.gravity = [0, 0, 0]
    root.addObject(Mouth(name="mouth"))
    root.addObject(Ear(name="ear"))
    root.addObject(Deaf(name="deaf", listening=False))
    body = root.addChild("body")
    body.addObject("EulerImplicitSolver")
    body.addObject("CGLinearSolver", iterations=10, tolerance=1e-14, threshold=1e-14)
    body.addObject("MechanicalObject", name="dofs", position=[0, 0, 0])
    body.addObject("UniformMass", totalMass=1)
