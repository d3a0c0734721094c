# SPDX-License-Identifier: LGPL-2.1-or-later
"""Elastic bodies around meshes."""
import Sofa
from stlib3.visuals import VisualModel


def ElasticBlock(attachedTo, name="ElasticBlock", n=(2, 2, 2), low=(0, 0, 0), high=(1, 1, 1), totalMass=1.0, youngModulus=1e3,
                          poissonRatio=0.3):
    body = attachedTo.addChild(name) if attachedTo is not None else None
    body.addObject("RegularGridTopology", name="loader", n=list(n), min=list(low), max=list(high))
    body.addObject("HexahedronSetTopologyContainer", src=body.loader.getLinkPath(), name="container")
    body.addObject("MechanicalObject", template="Vec3", name="dofs", showObject=False, showObjectScale=5.0)
    body.addObject("UniformMass", totalMass=totalMass, name="mass")
    body.addObject("HexahedronFEMForceField", template="Vec3", method="large", name="forcefield", poissonRatio=poissonRatio,
                   youngModulus=youngModulus)
    return body


class ElasticMaterialObject(Sofa.Prefab):
    """A body around a file, as a prefab that may hang nowhere while it is filled."""

    properties = [
        {"name": "volumeMeshFileName", "type": "string", "help": "file", "default": ""},
        {"name": "name", "type": "string", "help": "of the node", "default": "ElasticMaterialObject"},
        {"name": "rotation", "type": "Vec3d", "help": "degrees", "default": [0.0, 0.0, 0.0]},
        {"name": "translation", "type": "Vec3d", "help": "", "default": [0.0, 0.0, 0.0]},
        {"name": "scale", "type": "Vec3d", "help": "", "default": [1.0, 1.0, 1.0]},
        {"name": "surfaceMeshFileName", "type": "string", "help": "file", "default": ""},
        {"name": "collisionMesh", "type": "string", "help": "file", "default": ""},
        {"name": "withConstrain", "type": "bool", "help": "", "default": True},
        {"name": "surfaceColor", "type": "Vec4d", "help": "", "default": [1., 1., 1., 1.]},
        {"name": "poissonRatio", "type": "double", "help": "", "default": 0.3},
        {"name": "youngModulus", "type": "double", "help": "", "default": 18000},
        {"name": "totalMass", "type": "double", "help": "", "default": 1.0},
        {"name": "solverName", "type": "string", "help": "", "default": ""}]

    def __init__(self, *args, **kwargs):
        Sofa.Prefab.__init__(self, *args, **kwargs)

    def init(self):
        plugins = []
        if self.solverName.value == "":
            self.integration = self.addObject("EulerImplicitSolver", name="integration")
            self.solver = self.addObject("SparseLDLSolver", name="solver")
        if self.volumeMeshFileName.value == "":
            Sofa.msg_error(self, "there is no volume mesh")
            return None
        place = dict(filename=self.volumeMeshFileName.value, rotation=list(self.rotation.value), translation=list(self.translation.value),
                     scale3d=list(self.scale.value))
        kind = "MeshGmshLoader" if self.volumeMeshFileName.value.endswith(".msh") else "MeshVTKLoader"
        self.loader = self.addObject(kind, name="loader", **place)
        self.container = self.addObject("TetrahedronSetTopologyContainer", src=self.loader.getLinkPath(), name="container")
        self.dofs = self.addObject("MechanicalObject", template="Vec3", name="dofs")
        self.mass = self.addObject("UniformMass", totalMass=self.totalMass.value, name="mass")
        plugins.append("SofaSimpleFem")
        self.forcefield = self.addObject("TetrahedronFEMForceField", template="Vec3", method="large", name="forcefield",
                                         poissonRatio=self.poissonRatio.value, youngModulus=self.youngModulus.value)
        if self.withConstrain.value:
            self.correction = self.addObject("LinearSolverConstraintCorrection", name="correction")
        if self.collisionMesh:
            self.addCollisionModel(self.collisionMesh.value, list(self.rotation.value), list(self.translation.value))
        if self.surfaceMeshFileName:
            self.addVisualModel(self.surfaceMeshFileName.value, list(self.surfaceColor.value))
        self.addObject("RequiredPlugin", pluginName=plugins)

    def addCollisionModel(self, collisionMesh, rotation=[0.0, 0.0, 0.0], translation=[0.0, 0.0, 0.0]):
        self.collisionmodel = self.addChild("CollisionModel")
        self.collisionmodel.addObject("MeshSTLLoader", name="loader", filename=collisionMesh, rotation=rotation, translation=translation)
        self.collisionmodel.addObject("TriangleSetTopologyContainer", src="@loader", name="container")
        self.collisionmodel.addObject("MechanicalObject", template="Vec3", name="dofs")
        self.collisionmodel.addObject("TriangleCollisionModel")
        self.collisionmodel.addObject("LineCollisionModel")
        self.collisionmodel.addObject("PointCollisionModel")
        self.collisionmodel.addObject("BarycentricMapping")

    def addVisualModel(self, filename, color):
        visual = self.addChild(VisualModel(visualMeshPath=filename, color=color, rotation=list(self.rotation.value),
                                           translation=list(self.translation.value), scale=list(self.scale.value)))
        visual.addObject("BarycentricMapping", name="mapping")
