# SPDX-License-Identifier: LGPL-2.1-or-later
"""A target without mass below the integrator of the body that it leads by a spring: it is where the scene puts it."""
import Sofa


class Leader(Sofa.Core.Controller):
    def __init__(self, tool):
        Sofa.Core.Controller.__init__(self)
        self.name = f"{tool.getName()}_leader"
        self.goal = tool.target.goal

    def onAnimateBeginEvent(self, event):
        with self.goal.position.writeable() as position:
            position[0] += [0.1, 0, 0]


def createScene(root):
    root.gravity.value = [0, -10, 0]
    root.dt.value = 0.1
    root.addObject("DefaultAnimationLoop")
    tool = root.addChild("tool")
    tool.addObject("EulerImplicitSolver")
    tool.addObject("CGLinearSolver", iterations=100, tolerance=1e-14, threshold=1e-14)
    tool.addObject("MechanicalObject", name="dofs", position=[0, 0, 0])
    tool.addObject("UniformMass", totalMass=1)
    tool.addObject("PartialFixedProjectiveConstraint", indices=[0], fixedDirections=[0, 1, 1])
    target = tool.addChild("target")
    goal = target.addObject("MechanicalObject", name="goal", position=[0, 0, 0])
    tool.addObject("RestShapeSpringsForceField", stiffness=100, points=[0], external_rest_shape=goal.getLinkPath(), external_points=0)
    root.addObject(Leader(tool))
    return {"root": root, "tool": tool}
