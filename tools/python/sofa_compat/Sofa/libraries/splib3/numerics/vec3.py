# SPDX-License-Identifier: LGPL-2.1-or-later
"""Vectors of three numbers."""
import math

import numpy


class Vec3(numpy.ndarray):
    """Vec3(), Vec3(1.0) for three equal ones, Vec3(x, y, z), Vec3([x, y, z])."""

    def __new__(cls, *args):
        values = numpy.array(args[0] if len(args) == 1 else args or (0.0, 0.0, 0.0), dtype=float)
        return (numpy.full(3, float(values)) if values.ndim == 0 else values).view(cls)

    def __eq__(self, other):
        return bool(numpy.all(numpy.asarray(self) == numpy.asarray(other)))

    def __ne__(self, other):
        return not self == other

    __hash__ = None

    def getNorm(self):
        return math.sqrt(Vec3.dot(self, self))

    def toString(self):
        return " ".join(str(float(each)) for each in self)

    def toList(self):
        return [float(each) for each in self]

    def normalize(self, *args):
        self /= self.getNorm()
        return self

    def translate(self, *args):
        self += Vec3(*args)
        return self

    def scale(self, *args):
        self *= Vec3(*args)
        return self

    def rotateFromQuat(self, q):
        self[:] = q.rotate(numpy.array(self))
        return self

    def rotateFromEuler(self, v, axis="sxyz"):
        from splib3.numerics.quat import Quat

        return self.rotateFromQuat(Quat.createFromEuler(v, axis))

    def rotateFromAxisAngle(self, axis, angle):
        from splib3.numerics.quat import Quat

        return self.rotateFromQuat(Quat.createFromAxisAngle(axis, angle))

    @staticmethod
    def dot(v1, v2):
        return float(numpy.dot(numpy.asarray(v1, float), numpy.asarray(v2, float)))

    @staticmethod
    def cross(v1, v2):
        return Vec3(numpy.cross(numpy.asarray(v1, float), numpy.asarray(v2, float)))


def vadd(a, b):
    return [x + y for x, y in zip(a, b)]


def vsub(a, b):
    return [x - y for x, y in zip(a, b)]


def sadd(a, b):
    return [x + b for x in a]


def ssub(a, b):
    return [x - b for x in a]


def smul(a, b):
    return [x * b for x in a]


def sdiv(a, b):
    return [x / b for x in a]
