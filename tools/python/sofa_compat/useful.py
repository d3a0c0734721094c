# SPDX-License-Identifier: LGPL-2.1-or-later
"""useful, also where a program imports it before Sofa: the library of this name on the path, else what stands in for it."""
from Sofa import _libraries

_libraries.open_library(__name__)
