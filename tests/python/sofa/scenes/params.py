# SPDX-License-Identifier: LGPL-2.1-or-later
"""Numbers of a scene."""
import math

YOUNG = {"soft": 1e3, "stiff": 5e3}
LENGTH, ANGLE = 2.0, math.pi / 4
boxes = [[-0.01, -1, -1, 0.01, 2, 2]]
