# SPDX-License-Identifier: LGPL-2.1-or-later
"""Forces of a state and of a body that rests are read after a step."""
import Sofa


class Reader(Sofa.Core.Controller):
    def __init__(self, *args, **kwargs):
        Sofa.Core.Controller.__init__(self, *args, **kwargs)
        self.state, self.forces = kwargs["state"], []

    def onAnimateEndEvent(self, event):
        self.forces.append([float(each) for each in self.state.force.value[0]])


def createScene(root):
    root.gravity = [0, 0, -10]
    root.dt = 0.1
    root.addObject("DefaultAnimationLoop")
    body = root.addChild("body")
    body.addObject("EulerImplicitSolver")
    body.addObject("CGLinearSolver", iterations=10, tolerance=1e-14, threshold=1e-14)
    body.addObject("MechanicalObject", name="dofs", position=[0, 0, 0])
    body.addObject("UniformMass", totalMass=3)
    body.addObject("ConstantForceField", indices=[0], totalForce=[0, 0, 12])
    root.addObject(Reader(state=body.dofs))
