# SPDX-License-Identifier: LGPL-2.1-or-later
"""SofaTypes: vectors as arrays, as scenes make them."""
import numpy as np


def _vector(size):
    def make(*values):
        found = np.array(values[0] if len(values) == 1 else values, dtype=float).ravel()
        return np.concatenate([found, np.zeros(size)])[:size]

    return make


Vec1d, Vec2d, Vec3d, Vec4d, Vec6d = (_vector(size) for size in (1, 2, 3, 4, 6))


def Quat(*values):
    return _vector(4)(*values) if values else np.array([0.0, 0, 0, 1])


def Mat3x3(*values):
    return np.array(values, dtype=float).reshape(3, 3)
