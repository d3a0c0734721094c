# SPDX-License-Identifier: LGPL-2.1-or-later
"""Points and edges along a rod that touch others, slide or are held."""
import numpy as np


def _points(parent, name, container, places, edges, state):
    node = parent.addChild(name)
    node.addObject("EdgeSetTopologyContainer", name=container, position=places, edges=edges)
    node.addObject("EdgeSetTopologyModifier")
    node.addObject("MechanicalObject", name=state)
    return node


def addEdgeCollision(parentNode, position3D, edges, group="2"):
    node = _points(parentNode, "collisInstrumentCombined", "collisEdgeSet", position3D, edges, "CollisionDOFs")
    node.addObject("LineCollisionModel", bothSide=True, group=group)
    node.addObject("PointCollisionModel", group=group)
    node.addObject("IdentityMapping", name="mapping")
    return node


def addPointsCollision(parentNode, position3D, edges, nodeName="collisInstrumentCombined", group="2"):
    node = _points(parentNode, nodeName, "beamContainer", position3D, edges, "collisionStats")
    node.addObject("PointCollisionModel", name="beamColMod", group=group)
    node.addObject("IdentityMapping", name="beamMapping")
    return node


def addSlidingPoints(parentNode, frames3D, showVisual=False):
    node = parentNode.addChild("slidingPoint")
    node.addObject("MechanicalObject", name="slidingPointMO", position=frames3D, showObject=showVisual)
    node.addObject("IdentityMapping")
    return node


def create_rigid_node(parent_node, name, translation, rotation, positions=None):
    node = parent_node.addChild(name)
    node.addObject("MechanicalObject", template="Rigid3d", name=f"{name}MO", position=positions or [[0, 0, 0, 0, 0, 0, 1]],
                   translation=translation, rotation=rotation)
    return node


def getLastConstraintPoint(constraintPointsNode):
    return constraintPointsNode.getObject("constraintPointsMo").position[-1]


def _between(points, others, counts=lambda ahead: True):
    """Of the last ones; 0 where there is none, or where it does not count."""
    if len(points) == 0:
        return 0.0
    way = np.subtract(points[-1], others[-1])
    return float(np.linalg.norm(way)) if counts(way[0]) else 0.0


def computeDistanceBetweenPoints(constraintPointPos, slidingPointPos):
    return _between(constraintPointPos, slidingPointPos)


def computePositiveAlongXDistanceBetweenPoints(constraintPointPos, slidingPointPos):
    return _between(constraintPointPos, slidingPointPos, lambda ahead: ahead > 0)


def computeNegativeAlongXDistanceBetweenPoints(constraintPointPos, slidingPointPos):
    return _between(constraintPointPos, slidingPointPos, lambda ahead: ahead < 0)
