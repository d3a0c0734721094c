# SPDX-License-Identifier: LGPL-2.1-or-later
"""Positions written between steps: by an array of every entry, by value, and by a list."""
import numpy as np

import Sofa


class Mover(Sofa.Core.Controller):
    def __init__(self, *args, **kwargs):
        Sofa.Core.Controller.__init__(self, *args, **kwargs)
        self.state = kwargs["state"]
        self.step = 0

    def onAnimateBeginEvent(self, event):
        self.step += 1
        if self.step == 1:
            with self.state.position.writeable() as positions:
                positions[0][0] += 1
        elif self.step == 2:
            self.state.position.value = self.state.position.array() + np.array([0, 1, 0])
        elif self.step == 3:
            self.state.position = [[5, 5, 5]]
        elif self.step == 4:
            with self.state.velocity.writeableArray() as velocities:
                velocities[:] = [[1, 0, 0]]
        elif self.step == 5:
            self.state.position.value[0][2] = 7


def createScene(root):
    root.gravity = [0, 0, 0]
    root.dt = 0.5
    root.addObject("DefaultAnimationLoop")
    body = root.addChild("body")
    body.addObject("EulerImplicitSolver")
    body.addObject("CGLinearSolver", iterations=10, tolerance=1e-14, threshold=1e-14)
    body.addObject("MechanicalObject", name="dofs", position="0 0 0")
    body.addObject("UniformMass", totalMass=1)
    root.addObject(Mover(state=body.dofs))
