# SPDX-License-Identifier: LGPL-2.1-or-later
"""A node that is not activated takes no part, nor do its controllers; numbers of engines feed a component."""
import Sofa


class Silent(Sofa.Core.Controller):
    def onAnimateBeginEvent(self, event):
        raise RuntimeError("not to be called")


class Double(Sofa.Core.DataEngine):
    def __init__(self, *args, **kwargs):
        Sofa.Core.DataEngine.__init__(self, *args, **kwargs)
        self.addData("single", type="float", value=2.0)
        self.addData("double", type="float", value=0.0)
        self.addInput(self.single)
        self.addOutput(self.double)

    def update(self):
        self.double.value = 2 * self.single.value


def createScene(root):
    root.gravity = [0, 0, 0]
    root.dt = 0.1
    root.addObject("DefaultAnimationLoop")
    off = root.addChild("off", activated=False)
    off.addObject("MechanicalObject", position=[0, 0, 0])
    off.addObject(Silent())
    engine = root.addObject(Double(name="engine"))
    body = root.addChild("body")
    body.addObject("EulerImplicitSolver")
    body.addObject("CGLinearSolver", iterations=10, tolerance=1e-14, threshold=1e-14)
    body.addObject("MechanicalObject", name="dofs", position=[0.5, 0, 0], rest_position=[0, 0, 0])
    body.addObject("UniformMass", totalMass=1)
    body.addObject("RestShapeSpringsForceField", name="spring", stiffness="@/engine.double", points=[0])
