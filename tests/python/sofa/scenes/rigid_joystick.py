# SPDX-License-Identifier: LGPL-2.1-or-later
"""Frames that are moved entry by entry in every step by quaternion algebra of the scene's own; what they carry is checked."""
import math

import numpy as np
import Sofa


def quat_mult(a, b):
    x1, y1, z1, w1 = a
    x2, y2, z2, w2 = b
    return [w1 * x2 + x1 * w2 + y1 * z2 - z1 * y2, w1 * y2 - x1 * z2 + y1 * w2 + z1 * x2, w1 * z2 + x1 * y2 - y1 * x2 + z1 * w2,
            w1 * w2 - x1 * x2 - y1 * y2 - z1 * z2]


class Joystick(Sofa.Core.Controller):
    def __init__(self, *args, **kwargs):
        Sofa.Core.Controller.__init__(self, *args, **kwargs)
        self.frame = kwargs.get("frame")
        self.points = kwargs["points"]
        self.angle = 0

    def onAnimateBeginEvent(self, event):
        self.angle += 0.1
        with self.frame.position.writeable() as p:
            p[0][3:7] = quat_mult([0, 0, math.sin(0.05), math.cos(0.05)], p[0][3:7])
            p[0, 0] += 0.5
        self.frame.velocity.value = np.zeros((1, 6))

    def onAnimateEndEvent(self, event):
        x = self.frame.position.value[0][0]
        found = self.points.position.value[0]
        assert np.allclose(found, [x + math.cos(self.angle), math.sin(self.angle), 0], atol=1e-9), (found, self.angle)


def createScene(root):
    root.addObject("DefaultAnimationLoop")
    root.gravity = [0.0, 0.0, 0.0]
    tool = root.addChild("tool")
    frame = tool.addObject("MechanicalObject", template="Rigid3d", name="frame", position=[[0, 0, 0, 0, 0, 0, 1]], showObject=1)
    rider = tool.addChild("rider")
    points = rider.addObject("MechanicalObject", template="Vec3d", name="points", position=[[1, 0, 0]])
    rider.addObject("RigidMapping", rigidIndexPerPoint=[0], globalToLocalCoords=False)
    root.addObject(Joystick(name="Joystick", frame=frame, points=points))
