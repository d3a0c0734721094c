# SPDX-License-Identifier: LGPL-2.1-or-later
"""Keys."""
import sys

from Sofa.constants import Key

sys.modules[f"{__name__}.Key"] = Key
