# SPDX-License-Identifier: LGPL-2.1-or-later
"""The rest positions of a spring are moved in the run, as scenes do that lead a body."""
import Sofa


class Leader(Sofa.Core.Controller):
    def __init__(self, *args, **kwargs):
        Sofa.Core.Controller.__init__(self, *args, **kwargs)
        self.state = kwargs["state"]

    def onAnimateBeginEvent(self, event):
        with self.state.rest_position.writeable() as rest:
            rest[0][0] += 0.1


def createScene(root):
    root.gravity = [0, 0, 0]
    root.dt = 0.1
    root.addObject("DefaultAnimationLoop")
    body = root.addChild("body")
    body.addObject("EulerImplicitSolver")
    body.addObject("CGLinearSolver", iterations=10, tolerance=1e-14, threshold=1e-14)
    body.addObject("MechanicalObject", name="dofs", position=[0, 0, 0])
    body.addObject("UniformMass", totalMass=1)
    body.addObject("RestShapeSpringsForceField", name="spring", stiffness=100, points=[0])
    root.addObject(Leader(state=body.dofs))
