# SPDX-License-Identifier: LGPL-2.1-or-later
"""Rigid bodies around surfaces, to which functions are tied that a scene calls."""
import Sofa
import Sofa.Core
from Sofa import _libraries
from stlib3.visuals import VisualModel

_libraries.same_module(__name__, "RigidObject", "rigidobject")


def RigidObject(name="RigidObject", surfaceMeshFileName=None, translation=[0., 0., 0.], rotation=[0., 0., 0.], uniformScale=1.,
                totalMass=1., volume=1., inertiaMatrix=[1., 0., 0., 0., 1., 0., 0., 0., 1.], color=[1., 1., 1., 1.],
                collisionGroup="", isAStaticObject=False, parent=None):
    """A node that hangs below `parent`, or nowhere yet; a static one has no solver."""
    thing = Sofa.Core.Node(name)
    if parent is not None:
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
    if surfaceMeshFileName is not None:
        thing.addCollisionModel()
        thing.addVisualModel()
    return thing


def _of_file(name, mesh):
    def make(node, **kwargs):
        return RigidObject(parent=node, **{"name": name, "surfaceMeshFileName": mesh, **kwargs})

    make.__name__ = name
    return make


Cube, Sphere, Floor = _of_file("Cube", "mesh/cube.obj"), _of_file("Sphere", "mesh/ball.obj"), _of_file("Floor", "mesh/floor.obj")
