# SPDX-License-Identifier: LGPL-2.1-or-later
"""Cables and cavities."""
import Sofa


def PullingCable(attachedTo=None, name="Cable", cableGeometry=[[1.0, 0.0, 0.0], [0.0, 0.0, 0.0]], rotation=[0.0, 0.0, 0.0],
                 translation=[0.0, 0.0, 0.0], uniformScale=1.0, pullPointLocation=None, initialValue=0.0, valueType="displacement"):
    cable = attachedTo.addChild(name)
    cable.addObject("MechanicalObject", position=cableGeometry, rotation=rotation, translation=translation, scale=uniformScale)
    pulled = dict(pullPoint=pullPointLocation) if pullPointLocation is not None else {}
    cable.addObject("CableConstraint", indices=list(range(len(cableGeometry))), value=initialValue, valueType=valueType,
                    hasPullPoint=bool(pulled), **pulled)
    cable.addObject("BarycentricMapping", name="Mapping", mapForces=False, mapMasses=False)
    return cable


def PneumaticCavity(surfaceMeshFileName=None, attachedAsAChildOf=None, attachedTo=None, name="PneumaticCavity",
                    rotation=[0.0, 0.0, 0.0], translation=[0.0, 0.0, 0.0], uniformScale=1, initialValue=0, valueType="volumeGrowth"):
    if attachedAsAChildOf is None and attachedTo is None:
        Sofa.msg_error("a PneumaticCavity needs attachedTo or attachedAsAChildOf")
        return None
    pneumatic = attachedTo if attachedTo is not None else attachedAsAChildOf.addChild(name)
    kind = "MeshSTLLoader" if surfaceMeshFileName.endswith(".stl") else "MeshOBJLoader"
    pneumatic.addObject(kind, name="MeshLoader", filename=surfaceMeshFileName, rotation=rotation, translation=translation,
                        scale=uniformScale)
    pneumatic.addObject("MeshTopology", name="topology", src="@MeshLoader")
    pneumatic.addObject("MechanicalObject", src="@topology")
    pneumatic.addObject("SurfacePressureConstraint", value=initialValue, valueType=valueType)
    pneumatic.addObject("BarycentricMapping", name="Mapping", mapForces=False, mapMasses=False)
    return pneumatic
