# SPDX-License-Identifier: LGPL-2.1-or-later
"""Animations: functions of a factor from 0 to 1 over a time."""
