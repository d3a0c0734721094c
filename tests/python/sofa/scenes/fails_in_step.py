# SPDX-License-Identifier: LGPL-2.1-or-later
"""A controller that fails in its third step."""
import Sofa


class Failing(Sofa.Core.Controller):
    steps = 0

    def onAnimateBeginEvent(self, event):
        self.steps += 1
        if self.steps == 3:
            [].pop()


def createScene(root):
    root.addObject("DefaultAnimationLoop")
    root.gravity = [0, 0, -10]
    root.addObject(Failing(name="failing"))
    body = root.addChild("body")
    body.addObject("EulerImplicitSolver")
    body.addObject("CGLinearSolver", iterations=10, tolerance=1e-14, threshold=1e-14)
    body.addObject("MechanicalObject", name="dofs", position=[0, 0, 0])
    body.addObject("UniformMass", totalMass=1)
