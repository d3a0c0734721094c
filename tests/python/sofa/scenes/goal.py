# SPDX-License-Identifier: LGPL-2.1-or-later
"""A goal in a node of its own, which nothing moves but the scene: a spring follows it."""
import Sofa


class Goal(Sofa.Core.Controller):
    def __init__(self, goal):
        Sofa.Core.Controller.__init__(self)
        self.goal = goal

    def onAnimateBeginEvent(self, event):
        self.goal.position = self.goal.position.value + [[0, 0.2, 0]]


def createScene(root):
    root.gravity = [0, 0, -10]
    root.dt = 0.1
    root.addObject("DefaultAnimationLoop")
    goal = root.addChild("goal").addObject("MechanicalObject", name="place", template="Vec3", position="0 0 0")
    body = root.addChild("body")
    body.addObject("EulerImplicitSolver")
    body.addObject("CGLinearSolver", iterations=100, tolerance=1e-14, threshold=1e-14)
    body.addObject("MechanicalObject", name="dofs", position=[0, 0, 0])
    body.addObject("UniformMass", totalMass=2)
    body.addObject("RestShapeSpringsForceField", stiffness=50, points=[0], external_rest_shape="@../goal/place")
    body.addObject("PartialFixedConstraint", indices=[0], fixedDirections=[1, 0, 1])
    root.addObject(Goal(goal))
