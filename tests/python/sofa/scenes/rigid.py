# SPDX-License-Identifier: LGPL-2.1-or-later
"""Frames: seven numbers each, read and written; points on them by a RigidMapping."""
import Sofa


class Turner(Sofa.Core.Controller):
    def __init__(self, *args, **kwargs):
        Sofa.Core.Controller.__init__(self, *args, **kwargs)
        self.frame = kwargs["frame"]
        self.steps = 0

    def onAnimateBeginEvent(self, event):
        self.steps += 1
        if self.steps == 2:
            with self.frame.position.writeable() as frames:
                assert frames.shape == (1, 7)
                frames[0][0:3] = [1, 2, 3]
                frames[0][3:7] = [0, 0, 2 ** -0.5, 2 ** -0.5]


def createScene(root):
    root.gravity = [0, 0, 0]
    root.dt = 0.1
    root.addObject("DefaultAnimationLoop")
    body = root.addChild("body")
    body.addObject("EulerImplicitSolver")
    body.addObject("CGLinearSolver", iterations=10, tolerance=1e-14, threshold=1e-14)
    body.addObject("MechanicalObject", name="frame", template="Rigid3d", position=[0, 0, 0, 0, 0, 0, 1])
    body.addObject("UniformMass", totalMass=1)
    points = body.addChild("points")
    points.addObject("MechanicalObject", name="dofs", position=[[1, 0, 0], [0, 1, 0]])
    points.addObject("RigidMapping")
    root.addObject(Turner(frame=body.frame))
