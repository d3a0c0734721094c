# SPDX-License-Identifier: LGPL-2.1-or-later
"""What holds bodies, and parts of them in another material."""
import re

import Sofa
from Sofa import _libraries

_libraries.same_module(__name__, "fixedbox", "partiallyfixedbox", "subTopology")


def FixedBox(applyTo=None, atPositions=[-1.0, -1.0, -1.0, 1.0, 1.0, 1.0], name="FixedBox", doVisualization=False, position=None,
             constraintStrength=1e12, doRecomputeDuringSimulation=False):
    """By stiff springs; constraintStrength is not read, as in the library."""
    held = applyTo.addChild(name)
    given = {} if position is None else {"position": position}
    held.addObject("BoxROI", name="BoxROI", box=atPositions, drawBoxes=doVisualization, doUpdate=doRecomputeDuringSimulation, **given)
    held.addObject("RestShapeSpringsForceField", points="@BoxROI.indices", stiffness=1e12)
    return held


def PartiallyFixedBox(attachedTo=None, box=[-1.0, -1.0, -1.0, 1.0, 1.0, 1.0], fixedAxis=[1, 1, 1], name="PartiallyFixedBox",
                      drawBoxes=False, fixAll=False, doUpdate=False):
    held = attachedTo.addChild(name)
    held.addObject("BoxROI", name="BoxROI", box=box, drawBoxes=drawBoxes, doUpdate=doUpdate)
    held.addObject("PartialFixedConstraint", indices="@BoxROI.indices", fixedDirections=fixedAxis, fixAll=fixAll)
    return held


def SubTopology(attachedTo=None, containerLink=None, boxRoiLink=None, linkType="tetrahedron", name="modelSubTopo", poissonRatio=0.3,
                youngModulus=18000):
    """Cells of a region, boxRoiLink as "@../roi.tetrahedraInROI", in a container of their own."""
    if attachedTo is None or containerLink is None or boxRoiLink is None:
        Sofa.msg_error("a SubTopology needs attachedTo, containerLink and boxRoiLink")
        return None
    kind = linkType[0].upper() + linkType[1:]
    cells = re.search(r"\.(\w+)InROI$", boxRoiLink)
    part = attachedTo.addChild(name)
    part.addObject(kind + "SetTopologyContainer", name="container", position=containerLink, **{cells[1]: boxRoiLink})
    part.addObject(kind + "FEMForceField", name="FEM", method="large", poissonRatio=poissonRatio, youngModulus=youngModulus)
    return part
