# SPDX-License-Identifier: LGPL-2.1-or-later
"""A library in the ways of SOFA's plugin for soft robots."""
