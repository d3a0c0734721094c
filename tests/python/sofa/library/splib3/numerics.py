# SPDX-License-Identifier: LGPL-2.1-or-later
"""Vectors and quaternions (x, y, z, w)."""
import math

import numpy as np


def to_radians(degrees):
    return degrees * math.pi / 180.0


class Vec3(np.ndarray):
    def __new__(cls, *values):
        return np.array(values[0] if len(values) == 1 else values or (0, 0, 0), dtype=float).view(cls)

    def getNorm(self):
        return float(np.linalg.norm(self))


class Quat(np.ndarray):
    def __new__(cls, *values):
        return np.array(values[0] if len(values) == 1 else values or (0, 0, 0, 1), dtype=float).view(cls)

    @staticmethod
    def createFromAxisAngle(axis, angle):
        return Quat(*(math.sin(angle / 2) * component for component in axis), math.cos(angle / 2))

    def rotate(self, v):
        u, w = np.array(self[:3]), float(self[3])
        return 2 * np.dot(u, v) * u + (w * w - np.dot(u, u)) * np.array(v) + 2 * w * np.cross(u, v)


class RigidDof:
    """The place and the orientation of a frame."""

    def __init__(self, rigidobject):
        self.__dict__["rigidobject"] = rigidobject

    def getPosition(self, index=0, field="position"):
        return self.rigidobject.getData(field).value[index][:3]

    def setPosition(self, v, index=0, field="position"):
        value = [list(float(y) for y in i) for i in self.rigidobject.getData(field).value]
        value[index] = [float(i) for i in v] + value[index][3:]
        self.rigidobject.position = value

    position = property(getPosition, setPosition)
