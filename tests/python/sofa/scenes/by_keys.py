# SPDX-License-Identifier: LGPL-2.1-or-later
"""Keys, with the names of Sofa.constants."""
import Sofa
import Sofa.constants.Key as Key


class Keys(Sofa.Core.Controller):
    def __init__(self, *args, **kwargs):
        Sofa.Core.Controller.__init__(self, *args, **kwargs)
        self.load = kwargs["load"]
        self.seen = []

    def onKeypressedEvent(self, event):
        key = event["key"]
        self.seen.append(key)
        if key == Key.uparrow or ord(key) == 19:
            self.load.totalForce.value = [0, 0, 1]
        if key == Key.minus:
            self.load.totalForce = [0, 0, -1]

    def onKeyreleasedEvent(self, event):
        self.seen.append("released " + event["key"])


def createScene(root):
    root.gravity = [0, 0, 0]
    root.addObject("DefaultAnimationLoop")
    body = root.addChild("body")
    body.addObject("EulerImplicitSolver")
    body.addObject("CGLinearSolver", iterations=10, tolerance=1e-14, threshold=1e-14)
    body.addObject("MechanicalObject", name="dofs", position=[0, 0, 0])
    body.addObject("UniformMass", totalMass=1)
    body.addObject("ConstantForceField", name="load", indices=[0], totalForce=[0, 0, 0])
    root.addObject(Keys(name="keys", load=body.load))
