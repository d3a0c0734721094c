# SPDX-License-Identifier: LGPL-2.1-or-later
"""Vectors, quaternions (x, y, z, w) and frames."""
from math import *  # noqa: F401,F403

import numpy

from splib3.numerics.quat import *  # noqa: F401,F403
from splib3.numerics.quat import Quat
from splib3.numerics.vec3 import *  # noqa: F401,F403
from splib3.numerics.vec3 import Vec3, vadd  # noqa: F401

RigidDofZero = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]


def to_radians(v):
    """Of degrees, or of a list of them."""
    return [each * numpy.pi / 180 for each in v] if isinstance(v, list) else v * numpy.pi / 180


def TRS_to_matrix(translation, rotation=None, scale=None, eulerRotation=None):
    """4x4, of x -> translation + R (scale x); eulerRotation in degrees."""
    turn = Quat(*([] if rotation is None else [rotation]))
    if eulerRotation is not None:
        turn = Quat.createFromEuler(eulerRotation, inDegree=True)
    matrix = numpy.eye(4)
    matrix[:3, :3] = turn.getMatrix() * numpy.asarray(scale if scale is not None else [1.0, 1.0, 1.0], float)
    matrix[:3, 3] = translation
    return matrix


def transformPosition(point, matrixTRS):
    if len(point) != 3:
        raise Exception(f"a point has three coordinates: {point}")
    return numpy.matmul(matrixTRS, numpy.append(point, 1.0))[:3]


def transformPositions(position, translation=[0.0, 0.0, 0.0], rotation=[0.0, 0.0, 0.0, 1.0], eulerRotation=None, scale=[1.0, 1.0, 1.0]):
    matrix = TRS_to_matrix(translation=translation, rotation=rotation, eulerRotation=eulerRotation, scale=scale)
    return [transformPosition(point, matrix).tolist() for point in position]


def getOrientedBoxFromTransform(translation=[0.0, 0.0, 0.0], rotation=[0.0, 0.0, 0.0, 1.0], eulerRotation=None, scale=[1.0, 1.0, 1.0]):
    """A unit box about the origin, moved: three corners and the depth, as BoxROI.orientedBox has it."""
    corners = [[-0.5, 0.0, -0.5], [-0.5, 0.0, 0.5], [0.5, 0.0, 0.5]]
    return transformPositions(corners, translation, rotation, eulerRotation, scale) + [scale[1]]


class Transform:
    """A place and an orientation."""

    def __init__(self, translation, orientation=None, eulerRotation=None):
        self.translation = translation
        self.orientation = [0, 0, 0, 1] if orientation is None else orientation
        if eulerRotation is not None:
            self.orientation = Quat.createFromEuler(to_radians(list(eulerRotation)))

    def translate(self, v):
        self.translation = vadd(self.translation, v)
        return self

    def toSofaRepr(self):
        return [*self.translation, *self.orientation]

    def getForward(self):
        return numpy.append(Quat(self.orientation).getMatrix()[:, 2], 1.0)

    forward = property(getForward)


class RigidDof:
    """A frame of a state: `position` and `orientation`, to read and to write; `forward`, `left`, `up` are its axes z, x, y."""

    def __init__(self, rigidobject):
        self.__dict__["rigidobject"] = rigidobject

    def _rows(self, field):
        return [[float(number) for number in row] for row in self.rigidobject.getData(field).value]

    def _write(self, field, rows):
        self.rigidobject.getData(field).value = rows

    def getPosition(self, index=0, field="position"):
        return self.rigidobject.getData(field).value[index][:3]

    def setPosition(self, v, index=0, field="position"):
        rows = self._rows(field)
        rows[index][:3] = [float(each) for each in v]
        self._write(field, rows)

    def getOrientation(self, field="position"):
        return self.rigidobject.getData(field).value[0][3:]

    def setOrientation(self, q, field="position"):
        rows = self._rows(field)
        rows[0][3:] = [float(each) for each in q]
        self._write(field, rows)

    def _axis(self, number, field="position"):
        return Quat(self.getOrientation(field)).getMatrix()[:, number]

    def getForward(self, field="position"):
        return self._axis(2, field)

    def getLeft(self, field="position"):
        return self._axis(0, field)

    def getUp(self, field="position"):
        return self._axis(1, field)

    def copyFrom(self, t, field="position"):
        self._write(field, t._rows(field))

    def translate(self, v, field="position"):
        self.setPosition(vadd(self.getPosition(0, field), v), 0, field)

    def rotateAround(self, axis, angle, field="position"):
        self.setOrientation(Quat.product(Quat.createFromAxisAngle(axis, angle), self.getOrientation(field)), field)

    _FIELDS = {"position": ("Position", "position"), "rest_position": ("Position", "rest_position"),
               "orientation": ("Orientation", "position"), "rest_orientation": ("Orientation", "rest_position")}

    def __getattr__(self, key):
        if key in self._FIELDS:
            part, field = self._FIELDS[key]
            return getattr(self, "get" + part)(field=field)
        if key in ("forward", "left", "up"):
            return self._axis({"forward": 2, "left": 0, "up": 1}[key])
        return self.rigidobject.getData(key).value

    def __setattr__(self, key, value):
        if key in self._FIELDS:
            part, field = self._FIELDS[key]
            getattr(self, "set" + part)(value, field=field)
        else:
            self.rigidobject.getData(key).value = list(value)
