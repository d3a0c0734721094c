# SPDX-License-Identifier: LGPL-2.1-or-later
"""Regions whose box is turned."""
from splib3.numerics import getOrientedBoxFromTransform


def addOrientedBoxRoi(parentNode, position, translation=[0.0, 0.0, 0.0], eulerRotation=[0.0, 0.0, 0.0], scale=[1.0, 1.0, 1.0],
                      name="BoxROI", drawBoxes=True):
    box = getOrientedBoxFromTransform(translation=translation, eulerRotation=eulerRotation, scale=scale)
    corners = [each for corner in box[:3] for each in corner]
    return parentNode.addObject("BoxROI", name=name, position=position, orientedBox=corners + box[3:], drawBoxes=drawBoxes)


OrientedBoxRoi = addOrientedBoxRoi
