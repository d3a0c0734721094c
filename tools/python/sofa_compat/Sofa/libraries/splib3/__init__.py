# SPDX-License-Identifier: LGPL-2.1-or-later
"""Animations, numbers and files, as scenes of SOFA's plugin STLIB use them."""
from Sofa import _libraries

_libraries.told(__name__)
