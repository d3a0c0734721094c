# SPDX-License-Identifier: LGPL-2.1-or-later
"""Elastic bodies around meshes."""
import Sofa
import Sofa.Core
from Sofa import _libraries
from stlib3.visuals import VisualModel

_libraries.same_module(__name__, "elasticmaterialobject")
_LOADERS = {"msh": "MeshGmshLoader", "gidmsh": "GIDMeshLoader"}


class ElasticMaterialObject(Sofa.Prefab):
    """Solvers, loader, container, state, mass, force field and correction; a prefab, which may hang nowhere while it is filled.

    Of old, a function: ElasticMaterialObject(attachedTo, volumeMeshFileName, name, ...), whose `node` it is itself here."""

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
        if args and isinstance(args[0], Sofa.Core.Node):
            kwargs = {**dict(zip(("attachedTo", "volumeMeshFileName", "name", "rotation", "translation"), args)), **kwargs}
            args = ()
        if kwargs.get("attachedTo") is not None:
            kwargs["parent"] = kwargs["attachedTo"]
        if kwargs.get("solver") is not None:
            kwargs["solverName"] = str(kwargs["solver"])
        kept = {name: value for name, value in kwargs.items() if value is not None and name not in ("attachedTo", "solver")}
        Sofa.Prefab.__init__(self, *args, **{"name": "ElasticMaterialObject", **kept} if not args else kept)

    @property
    def node(self):
        return self

    def init(self):
        if self.solverName.value == "":
            self.integration = self.addObject("EulerImplicitSolver", name="integration")
            self.solver = self.addObject("SparseLDLSolver", name="solver")
        mesh = self.volumeMeshFileName.value
        if mesh == "":
            Sofa.msg_error(self, "there is no volume mesh")
            return
        place = dict(rotation=list(self.rotation.value), translation=list(self.translation.value))
        scale = list(self.scale.value)
        kind = _LOADERS.get(mesh.rsplit(".", 1)[-1], "MeshVTKLoader")
        self.loader = self.addObject(kind, name="loader", filename=mesh, scale3d=scale, **place)
        self.container = self.addObject("TetrahedronSetTopologyContainer", src=self.loader.getLinkPath(), name="container")
        self.dofs = self.addObject("MechanicalObject", template="Vec3", name="dofs")
        self.mass = self.addObject("UniformMass", totalMass=self.totalMass.value, name="mass")
        self.forcefield = self.addObject("TetrahedronFEMForceField", template="Vec3", method="large", name="forcefield",
                                         poissonRatio=self.poissonRatio.value, youngModulus=self.youngModulus.value)
        if self.withConstrain.value:
            self.correction = self.addObject("LinearSolverConstraintCorrection", name="correction")
        if self.collisionMesh.value:
            self.addCollisionModel(self.collisionMesh.value, scale=scale, **place)
        if self.surfaceMeshFileName.value:
            self.addVisualModel(self.surfaceMeshFileName.value, list(self.surfaceColor.value), scale=scale, **place)

    def addCollisionModel(self, collisionMesh, rotation=[0.0, 0.0, 0.0], translation=[0.0, 0.0, 0.0], scale=[1., 1., 1.]):
        self.collisionmodel = self.addChild("CollisionModel")
        self.collisionmodel.addObject("MeshSTLLoader", name="loader", filename=collisionMesh, rotation=rotation, translation=translation,
                                      scale3d=scale)
        self.collisionmodel.addObject("TriangleSetTopologyContainer", src="@loader", name="container")
        self.collisionmodel.addObject("MechanicalObject", template="Vec3", name="dofs")
        for kind in ("TriangleCollisionModel", "LineCollisionModel", "PointCollisionModel"):
            self.collisionmodel.addObject(kind)
        self.collisionmodel.addObject("BarycentricMapping")

    def addVisualModel(self, filename, color, rotation, translation, scale=[1., 1., 1.]):
        self.visualmodel = self.addChild(VisualModel(visualMeshPath=filename, color=color, rotation=rotation, translation=translation,
                                                     scale=scale))
        self.visualmodel.addObject("BarycentricMapping", name="mapping")
