# SPDX-License-Identifier: LGPL-2.1-or-later
"""Headers, bodies, surfaces and what holds them, as scenes of SOFA's plugin STLIB build them."""
from Sofa import _libraries

_libraries.told(__name__)
