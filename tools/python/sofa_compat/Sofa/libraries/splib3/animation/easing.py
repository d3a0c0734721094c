# SPDX-License-Identifier: LGPL-2.1-or-later
"""Values between two others."""


def LinearRamp(beginValue=0.0, endValue=1.0, scale=0.5):
    return beginValue + scale * (endValue - beginValue)
