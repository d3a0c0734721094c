# SPDX-License-Identifier: LGPL-2.1-or-later
"""Sofa.constants: keys."""
from . import Key  # noqa: F401
