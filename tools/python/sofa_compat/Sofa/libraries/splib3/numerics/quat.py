# SPDX-License-Identifier: LGPL-2.1-or-later
"""Quaternions (x, y, z, w) of rotations. Angles of Euler about axes in the order of a word: s about those of the world, r about those
that turn with it: "sxyz" is R = R_z R_y R_x."""
import itertools
import math
from math import pi, sqrt  # noqa: F401

import numpy

AXES = [frame + "".join(axes) for frame in "sr" for axes in itertools.product("xyz", repeat=3) if axes[0] != axes[1] != axes[2]]
_EPSILON = 4 * numpy.finfo(float).eps


class Quat(numpy.ndarray):
    """Quat(), Quat(x, y, z, w), Quat([x, y, z, w])."""

    def __new__(cls, *args):
        values = args[0] if len(args) == 1 else args or (0.0, 0.0, 0.0, 1.0)
        if len(values) != 4:
            raise ValueError(f"a quaternion has four numbers, not {len(values)}")
        return numpy.array(values, dtype=float).view(cls)

    def __eq__(self, other):
        return bool(numpy.all(numpy.asarray(self) == numpy.asarray(other)))

    def __ne__(self, other):
        return not self == other

    __hash__ = None

    # ---- parts ----

    def getNorm(self):
        return float(numpy.linalg.norm(numpy.asarray(self)))

    def getRe(self):
        return float(self[3])

    def getIm(self):
        return numpy.array(self[:3])

    def getConjugate(self):
        return Quat(*-self.getIm(), self.getRe())

    def getInverse(self):
        return self.getConjugate() / self.getNorm()**2

    def getAxisAngle(self):
        """[axis, angle] with an angle up to pi."""
        q = Quat(self).flip()
        length = float(numpy.linalg.norm(q.getIm()))
        angle = 2 * math.atan2(length, q.getRe())
        return [q.getIm() / length if length > _EPSILON else numpy.zeros(3), angle]

    def getMatrix(self):
        """With the rotation's columns, of a unit quaternion."""
        (x, y, z), w = self.getIm(), self.getRe()
        return numpy.array([[2 * (x * x + w * w) - 1, 2 * (x * y - z * w), 2 * (x * z + y * w)],
                            [2 * (x * y + z * w), 2 * (y * y + w * w) - 1, 2 * (y * z - x * w)],
                            [2 * (x * z - y * w), 2 * (y * z + x * w), 2 * (z * z + w * w) - 1]])

    def getEulerAngles(self, axes="sxyz"):
        """In radians, about the axes of the word."""
        first, second, third = _order(axes)
        m = self.getMatrix()
        sign = -1.0 if (second - first) % 3 == 2 else 1.0
        last = third if third != first else 3 - first - second
        if third == first:
            across = math.hypot(m[first, second], m[first, last])
            turns = [math.atan2(m[first, second], sign * m[first, last]), math.atan2(across, m[first, first]),
                     math.atan2(m[second, first], -sign * m[last, first])]
            if across <= _EPSILON:
                turns[0], turns[2] = math.atan2(-sign * m[second, last], m[second, second]), 0.0
        else:
            across = math.hypot(m[first, first], m[second, first])
            turns = [math.atan2(sign * m[last, second], m[last, last]), math.atan2(-sign * m[last, first], across),
                     math.atan2(sign * m[second, first], m[first, first])]
            if across <= _EPSILON:
                turns[0], turns[2] = math.atan2(-sign * m[second, last], m[second, second]), 0.0
        return numpy.array(turns[::-1] if axes[0] == "r" else turns)

    def toString(self):
        return " ".join(str(float(each)) for each in self)

    # ---- changes ----

    def normalize(self, *args):
        self /= self.getNorm()
        return self

    def flip(self):
        """Of the two quaternions of the rotation that with w >= 0."""
        if self.getRe() < 0:
            self *= -1
        return self

    def rotateFromQuat(self, qb):
        self[:] = Quat.product(self, qb)
        return self

    def rotateFromEuler(self, v, axes="sxyz"):
        return self.rotateFromQuat(Quat.createFromEuler(v))  # the library does not read axes here

    def rotate(self, v):
        """A vector, by the unit quaternion in this direction."""
        return Quat(self).normalize().getMatrix() @ numpy.asarray(v, float)

    # ---- made ----

    @staticmethod
    def createFromVectors(v1, v2):
        """That turns v2 into the direction of v1."""
        q = Quat(*numpy.cross(v2, v1), float(numpy.linalg.norm(v1) * numpy.linalg.norm(v2) + numpy.dot(v1, v2)))
        return q.normalize()

    @staticmethod
    def createFromAxisAngle(axis, angle):
        return Quat(*(math.sin(angle / 2) * each for each in axis), math.cos(angle / 2)).normalize()

    @staticmethod
    def createFromEuler(v, axes="sxyz", inDegree=False):
        turns = [math.radians(each) if inDegree else float(each) for each in v]
        if axes[0] == "r":
            turns.reverse()
        q = Quat()
        for axis, turn in zip(_order(axes), turns):
            q = Quat.product(Quat.createFromAxisAngle(numpy.eye(3)[axis], turn), q)
        return q

    @staticmethod
    def product(qa, qb):
        """The rotation qb and then qa."""
        a, b, wa, wb = Quat(qa).getIm(), Quat(qb).getIm(), float(qa[3]), float(qb[3])
        return Quat(*(wa * b + wb * a + numpy.cross(a, b)), wa * wb - float(numpy.dot(a, b)))


def _order(axes):
    """The axes in the order of turns about those of the world: turns about moving axes are the same, the other way round."""
    if axes not in AXES:
        raise KeyError(f"'{axes}' is no order of axes (expected s or r and three of xyz, as sxyz)")
    numbers = ["xyz".index(each) for each in axes[1:]]
    return numbers[::-1] if axes[0] == "r" else numbers
