# SPDX-License-Identifier: LGPL-2.1-or-later
"""A controller that comes in the run, and takes itself out again."""
import Sofa


class Late(Sofa.Core.Controller):
    steps = 0
    initialised = False

    def init(self):
        self.initialised = True

    def onAnimateEndEvent(self, event):
        self.steps += 1
        if self.steps == 2:
            self.getContext().removeObject(self)


class Starter(Sofa.Core.Controller):
    def __init__(self, *args, **kwargs):
        Sofa.Core.Controller.__init__(self, *args, **kwargs)
        self.late = Late(name="late")

    def onAnimateBeginEvent(self, event):
        if not self.late.initialised:
            self.getContext().addObject(self.late)


def createScene(root):
    root.addObject("DefaultAnimationLoop")
    root.gravity = [0, 0, -10]
    root.addObject(Starter(name="starter"))
    body = root.addChild("body")
    body.addObject("EulerImplicitSolver")
    body.addObject("CGLinearSolver", iterations=10, tolerance=1e-14, threshold=1e-14)
    body.addObject("MechanicalObject", name="dofs", position=[0, 0, 0])
    body.addObject("UniformMass", totalMass=1)
