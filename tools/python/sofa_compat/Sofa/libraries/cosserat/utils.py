# SPDX-License-Identifier: LGPL-2.1-or-later
"""The same as useful.utils, and what builds a rod's edges."""
from useful.utils import *  # noqa: F401,F403

from cosserat.usefulFunctions import BuildCosseratGeometry, buildEdges  # noqa: F401
