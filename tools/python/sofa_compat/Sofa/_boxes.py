# SPDX-License-Identifier: LGPL-2.1-or-later
"""Boxes around what a scene has: SOFA's `bbox`."""
import numpy as np

from . import _values

_IN_SPACE = {"", "Vec3", "Rigid3"}  # templates of which the first three columns are a place


def around(things):
    """[lower corner, upper corner] of the places of objects that have some; None: there are none."""
    places = [each.findData("position").value for each in things if _values.plain_template(each._s_template()) in _IN_SPACE]
    places = [rows[:, :3] for rows in places if isinstance(rows, np.ndarray) and rows.ndim == 2 and len(rows)]
    return np.array([np.min([rows.min(axis=0) for rows in places], axis=0),
                     np.max([rows.max(axis=0) for rows in places], axis=0)]) if places else None
