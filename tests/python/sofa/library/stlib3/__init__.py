# SPDX-License-Identifier: LGPL-2.1-or-later
"""A library in the ways of SOFA's own: functions that fill nodes by addObject() and addChild()."""
