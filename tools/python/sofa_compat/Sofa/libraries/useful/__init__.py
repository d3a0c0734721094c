# SPDX-License-Identifier: LGPL-2.1-or-later
"""What scenes of SOFA's plugin Cosserat share: parameters of rods, headers of scenes, points along a rod."""
from Sofa import _libraries

_libraries.told(__name__)
