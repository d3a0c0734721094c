# SPDX-License-Identifier: LGPL-2.1-or-later
"""The older name of Sofa.Types."""
from .Types import BoundingBox, RGBAColor  # noqa: F401
