# SPDX-License-Identifier: LGPL-2.1-or-later
"""Surfaces that touch others."""
import Sofa
from Sofa import _libraries

_libraries.same_module(__name__, "collision")
_LOADERS = {".obj": "MeshOBJLoader", ".stl": "MeshSTLLoader", ".vtk": "MeshVTKLoader"}


def loaderFor(name):
    return _LOADERS.get(name[-4:])


def CollisionMesh(attachedTo=None, surfaceMeshFileName=None, name="collision", rotation=[0.0, 0.0, 0.0], translation=[0.0, 0.0, 0.0],
                  collisionGroup=None, mappingType="BarycentricMapping"):
    if attachedTo is None:
        Sofa.msg_error("a CollisionMesh needs a node")
        return None
    model = attachedTo.addChild(name)
    if surfaceMeshFileName is None:
        Sofa.msg_error(model, "a CollisionMesh needs a surface mesh")
        return None
    model.addObject(loaderFor(surfaceMeshFileName), name="loader", filename=surfaceMeshFileName, rotation=rotation, translation=translation)
    model.addObject("MeshTopology", src="@loader")
    model.addObject("MechanicalObject")
    group = {"group": collisionGroup} if collisionGroup else {}
    for kind in ("PointCollisionModel", "LineCollisionModel", "TriangleCollisionModel"):
        model.addObject(kind, **group)
    if mappingType is not None:
        model.addObject(mappingType)
    return model
