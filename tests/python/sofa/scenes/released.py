# SPDX-License-Identifier: LGPL-2.1-or-later
"""The tree changes in the run: a clamp goes, and later a load comes."""
import Sofa


class Release(Sofa.Core.Controller):
    def __init__(self, *args, **kwargs):
        Sofa.Core.Controller.__init__(self, *args, **kwargs)
        self.body = kwargs["body"]
        self.steps = 0

    def onAnimateBeginEvent(self, event):
        self.steps += 1
        if self.steps == 3:
            self.body.removeObject(self.body.clamp)
        if self.steps == 5:
            self.body.addObject("ConstantForceField", name="load", indices=[0], totalForce=[0, 0, 20])


def createScene(root):
    root.gravity = [0, 0, -10]
    root.dt = 0.1
    root.addObject("DefaultAnimationLoop")
    body = root.addChild("body")
    body.addObject("EulerImplicitSolver")
    body.addObject("CGLinearSolver", iterations=10, tolerance=1e-14, threshold=1e-14)
    body.addObject("MechanicalObject", name="dofs", position=[0, 0, 0])
    body.addObject("UniformMass", totalMass=1)
    body.addObject("FixedProjectiveConstraint", name="clamp", indices=[0])
    root.addObject(Release(name="release", body=body))
