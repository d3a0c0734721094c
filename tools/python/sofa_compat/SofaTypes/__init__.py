# SPDX-License-Identifier: LGPL-2.1-or-later
"""SofaTypes: vectors as arrays, as scenes make them."""
import re

import numpy as np


def _vector(size):
    def make(*values):
        found = np.array(values[0] if len(values) == 1 else values, dtype=float).ravel()
        return np.concatenate([found, np.zeros(size)])[:size]

    return make


Vec1d, Vec2d, Vec3d, Vec4d, Vec6d = (_vector(size) for size in (1, 2, 3, 4, 6))


def __getattr__(name):
    """Vec2f, Vec3i, Vec7d and the others."""
    found = re.fullmatch("Vec([1-9]|10|11|12)([dfiu])", name)
    if found is None:
        raise AttributeError(f"module 'SofaTypes' has no attribute '{name}'")
    make = _vector(int(found.group(1)))
    return make if found.group(2) in "df" else lambda *values: make(*values).astype(int)


def Quat(*values):
    return _vector(4)(*values) if values else np.array([0.0, 0, 0, 1])


def _matrix(size):
    return lambda *values: np.array(values, dtype=float).reshape(size, size)


Mat2x2, Mat3x3, Mat4x4 = (_matrix(size) for size in (2, 3, 4))
