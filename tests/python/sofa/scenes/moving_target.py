# SPDX-License-Identifier: LGPL-2.1-or-later
"""A goal without mass, moved on a circle through an array that may be written; the controller checks where it was."""
import math

import numpy as np
import Sofa


class Goal(Sofa.Core.Controller):
    def __init__(self, *a, **k):
        super().__init__(*a, **k)
        self.mo = k["mo"]
        self.t = 0.
        self.history = []

    def onAnimateBeginEvent(self, e):
        self.t += e["dt"]
        with self.mo.position.writeableArray() as w:
            w[0, 0] = 10 * math.cos(self.t)
            w[0][1] = 10 * math.sin(self.t)

    def onAnimateEndEvent(self, e):
        self.history.append(self.mo.position.value.copy())
        assert np.allclose(self.history[-1][0][:2], [10 * math.cos(self.t), 10 * math.sin(self.t)])


def createScene(root):
    root.addObject("RequiredPlugin", name="Sofa.Component.StateContainer")
    root.addObject("FreeMotionAnimationLoop")
    root.addObject("GenericConstraintSolver", tolerance=1e-6, maxIterations=1000)
    goal = root.addChild("goal")
    goal.addObject("EulerImplicitSolver", firstOrder=True)
    goal.addObject("CGLinearSolver", iterations=100, tolerance=1e-5, threshold=1e-5)
    mo = goal.addObject("MechanicalObject", name="goalMO", position=[[10, 0, 0]], showObject=True)
    goal.addObject("SphereCollisionModel", radius=5, group=1)
    goal.addObject("UncoupledConstraintCorrection")
    root.addObject(Goal(name="Goal", mo=mo))
