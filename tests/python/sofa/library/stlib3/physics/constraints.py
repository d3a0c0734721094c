# SPDX-License-Identifier: LGPL-2.1-or-later
"""What holds bodies."""


def FixedBox(applyTo=None, atPositions=[-1.0, -1.0, -1.0, 1.0, 1.0, 1.0], name="FixedBox", doVisualization=False, position=None,
             constraintStrength=1e12, doRecomputeDuringSimulation=False):
    c = applyTo.addChild(name)
    given = {} if position is None else {"position": position}
    c.addObject("BoxROI", name="BoxROI", box=atPositions, drawBoxes=doVisualization, doUpdate=doRecomputeDuringSimulation, **given)
    c.addObject("RestShapeSpringsForceField", points="@BoxROI.indices", stiffness=constraintStrength)
    return c
