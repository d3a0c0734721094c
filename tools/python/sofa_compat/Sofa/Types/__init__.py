# SPDX-License-Identifier: LGPL-2.1-or-later
"""Sofa.Types: colours and boxes."""
import numpy as np

from .._data import DataBox as BoundingBox  # noqa: F401


class RGBAColor(np.ndarray):
    """Four numbers from 0 to 1, or a name."""

    _names = {"white": (1, 1, 1, 1), "black": (0, 0, 0, 1), "red": (1, 0, 0, 1), "green": (0, 1, 0, 1), "blue": (0, 0, 1, 1),
              "yellow": (1, 1, 0, 1), "cyan": (0, 1, 1, 1), "magenta": (1, 0, 1, 1), "gray": (0.5, 0.5, 0.5, 1)}

    def __new__(cls, *values, name=None):
        if name is None and len(values) == 1 and isinstance(values[0], str):
            name, values = values[0], ()
        if name is not None:
            values = cls._names.get(name.lower(), (1, 1, 1, 1))
        found = np.array(values[0] if len(values) == 1 else values, dtype=float).ravel()
        return np.concatenate([found, np.ones(4)])[:4].view(cls)

    def r(self):
        return float(self[0])

    def g(self):
        return float(self[1])

    def b(self):
        return float(self[2])

    def a(self):
        return float(self[3])
