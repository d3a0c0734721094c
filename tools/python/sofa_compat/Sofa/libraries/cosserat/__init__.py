# SPDX-License-Identifier: LGPL-2.1-or-later
"""Rods of sections with constant strains, as scenes of SOFA's plugin Cosserat build them."""
from Sofa import _libraries

_libraries.told(__name__)
