# SPDX-License-Identifier: LGPL-2.1-or-later
"""Cables, cavities and what measures them, as scenes of SOFA's plugin SoftRobots build them."""
from Sofa import _libraries

_libraries.told(__name__)
