# SPDX-License-Identifier: LGPL-2.1-or-later
"""A parameter that a key of the scene changes takes effect in the run."""
import Sofa


class Softer(Sofa.Core.Controller):
    def __init__(self, *args, **kwargs):
        Sofa.Core.Controller.__init__(self, *args, **kwargs)
        self.spring = kwargs["spring"]

    def onAnimateBeginEvent(self, event):
        if self.getContext().getRoot().getTime() > 0.099 and self.spring.stiffness.value[0] > 60:
            self.spring.findData("stiffness").value = 50
            self.spring.reinit()


def createScene(root):
    root.addObject("DefaultAnimationLoop")
    root.gravity = [0, 0, 0]
    root.dt = 0.01
    body = root.addChild("body")
    body.addObject("EulerImplicitSolver")
    body.addObject("CGLinearSolver", iterations=20, tolerance=1e-14, threshold=1e-14)
    body.addObject("MechanicalObject", name="dofs", position=[0.5, 0, 0], rest_position=[0, 0, 0])
    body.addObject("UniformMass", totalMass=2)
    spring = body.addObject("RestShapeSpringsForceField", name="spring", stiffness=100, points=[0])
    root.addObject(Softer(spring=spring))
