# SPDX-License-Identifier: LGPL-2.1-or-later
"""Rigid bodies, to which functions are tied that a scene calls."""
import Sofa
from stlib3.visuals import VisualModel


def RigidObject(name="RigidObject", surfaceMeshFileName=None, translation=[0., 0., 0.], rotation=[0., 0., 0.], uniformScale=1.,
                totalMass=1., volume=1., inertiaMatrix=[1., 0., 0., 0., 1., 0., 0., 0., 1.], color=[1., 1., 1., 1.],
                collisionGroup="", isAStaticObject=False, parent=None):
    thing = Sofa.Core.Node(name)
    if parent != None:  # noqa: E711
        parent.addChild(thing)
    thing.addObject("MechanicalObject", name="mstate", template="Rigid3", translation2=translation, rotation2=rotation,
                    showObjectScale=uniformScale)
    thing.addObject("UniformMass", name="mass", vertexMass=[totalMass, volume, inertiaMatrix[:]])
    if not isAStaticObject:
        thing.addObject("UncoupledConstraintCorrection")
        thing.addObject("EulerImplicitSolver", name="odesolver")
        thing.addObject("CGLinearSolver", name="Solver", iterations=25, tolerance=1e-5, threshold=1e-5)

    def addCollisionModel(inputMesh=surfaceMeshFileName):
        collision = thing.addChild("collision")
        collision.addObject("MeshOBJLoader", name="loader", filename=inputMesh, triangulate=True, scale=uniformScale)
        collision.addObject("MeshTopology", src="@loader")
        collision.addObject("MechanicalObject")
        fixed = dict(moving=False, simulated=False) if isAStaticObject else {}
        for kind in ("TriangleCollisionModel", "LineCollisionModel", "PointCollisionModel"):
            collision.addObject(kind, group=collisionGroup, **fixed)
        collision.addObject("RigidMapping")

    def addVisualModel(inputMesh=surfaceMeshFileName):
        visual = VisualModel(name="visual", visualMeshPath=inputMesh, color=color, scale=[uniformScale] * 3)
        thing.addChild(visual)
        visual.addObject("RigidMapping")

    thing.addCollisionModel = addCollisionModel
    thing.addVisualModel = addVisualModel
    if surfaceMeshFileName != None:  # noqa: E711
        thing.addCollisionModel()
        thing.addVisualModel()
    return thing


def Cube(node, **kwargs):
    if "surfaceMeshFileName" not in kwargs:
        kwargs["surfaceMeshFileName"] = "mesh/cube.obj"
    if "name" not in kwargs:
        kwargs["name"] = "Cube"
    return node.addChild(RigidObject(**kwargs))


Floor = Cube
