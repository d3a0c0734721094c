# SPDX-License-Identifier: LGPL-2.1-or-later
"""Cables and cavities."""
import Sofa
from Sofa import _libraries

_libraries.same_module(__name__, "cable", "pneumatic")
_LOADERS = {".stl": "MeshSTLLoader", ".obj": "MeshOBJLoader"}


def PullingCable(attachedTo=None, name="Cable", cableGeometry=[[1.0, 0.0, 0.0], [0.0, 0.0, 0.0]], rotation=[0.0, 0.0, 0.0],
                 translation=[0.0, 0.0, 0.0], uniformScale=1.0, pullPointLocation=None, initialValue=0.0, valueType="displacement"):
    """Through the points of cableGeometry, pulled from pullPointLocation where it is given."""
    cable = attachedTo.addChild(name)
    cable.addObject("MechanicalObject", position=cableGeometry, rotation=rotation, translation=translation, scale=uniformScale)
    pulled = {} if pullPointLocation is None else {"pullPoint": pullPointLocation}
    cable.addObject("CableConstraint", indices=list(range(len(cableGeometry))), value=initialValue, valueType=valueType,
                    hasPullPoint=bool(pulled), **pulled)
    cable.addObject("BarycentricMapping", name="Mapping", mapForces=False, mapMasses=False)
    return cable


def _cavity(what, surfaceMeshFileName, attachedAsAChildOf, attachedTo, name, rotation, translation, uniformScale):
    """A node with the surface and its state."""
    if attachedAsAChildOf is None and attachedTo is None:
        Sofa.msg_error(f"a {what} needs attachedTo or attachedAsAChildOf")
        return None
    loader = _LOADERS.get(str(surfaceMeshFileName)[-4:])
    if loader is None:
        Sofa.msg_error(f"a {what} needs a surface of an .stl or .obj file: {surfaceMeshFileName}")
        return None
    node = attachedTo if attachedTo is not None else attachedAsAChildOf.addChild(name)
    node.addObject(loader, name="MeshLoader", filename=surfaceMeshFileName, rotation=rotation, translation=translation, scale=uniformScale)
    node.addObject("MeshTopology", name="topology", src="@MeshLoader")
    node.addObject("MechanicalObject", src="@topology")
    return node


def PneumaticCavity(surfaceMeshFileName=None, attachedAsAChildOf=None, attachedTo=None, name="PneumaticCavity",
                    rotation=[0.0, 0.0, 0.0], translation=[0.0, 0.0, 0.0], uniformScale=1, initialValue=0, valueType="volumeGrowth"):
    cavity = _cavity("PneumaticCavity", surfaceMeshFileName, attachedAsAChildOf, attachedTo, name, rotation, translation, uniformScale)
    if cavity is not None:
        cavity.addObject("SurfacePressureConstraint", value=initialValue, valueType=valueType)
        cavity.addObject("BarycentricMapping", name="Mapping", mapForces=False, mapMasses=False)
    return cavity
