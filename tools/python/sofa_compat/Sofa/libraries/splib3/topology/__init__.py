# SPDX-License-Identifier: LGPL-2.1-or-later
"""Points of tubes in rings, and cells by other numbers."""
import sys

from splib3.topology import remeshing

sys.modules[f"{__name__}.Remeshing_functions"] = Remeshing_functions = remeshing
