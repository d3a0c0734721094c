# SPDX-License-Identifier: LGPL-2.1-or-later
"""Headers of scenes with rods."""
from stlib3.physics.constraints import FixedBox
from stlib3.physics.deformable import ElasticMaterialObject


def addHeader(parent, multithreading=False, inverse=False, isConstrained=False, isContact=False, params=None, **values):
    """A node Settings, and where they are asked for the loop of constraints and contacts."""
    is_constrained, is_contact = values.get("is_constrained", isConstrained), values.get("is_contact", isContact)
    settings = parent.addChild("Settings")
    settings.addObject("BackgroundSetting", color=[1, 1, 1, 1])
    parent.addObject("VisualStyle", displayFlags="showVisualModels showBehaviorModels")
    if is_constrained:
        parent.addObject("FreeMotionAnimationLoop")
        parent.addObject("QPInverseProblemSolver" if inverse else "GenericConstraintSolver", name="ConstraintSolver", tolerance=1e-8,
                         maxIterations=100)
    if is_contact:
        contactHeader(parent, None if params is None else params.contact_params)
    return settings


def contactHeader(parent, _contact_params=None):
    given = _contact_params
    parent.addObject("CollisionPipeline")
    parent.addObject("BruteForceBroadPhase")
    parent.addObject("BVHNarrowPhase")
    parent.addObject("RuleBasedContactManager", responseParams=given.response_params if given else "mu=0.1",
                     response="FrictionContactConstraint")
    parent.addObject("LocalMinDistance", alarmDistance=given.alarm_distance if given else 0.05,
                     contactDistance=given.contact_distance if given else 0.01)


def addVisual(node):
    node.addObject("VisualStyle", displayFlags="showVisualModels showBehaviorModels")
    return node


def addSolverNode(parent, name="solverNode", template="CompressedRowSparseMatrixd", rayleighMass=0.0, rayleighStiffness=0.0, firstOrder=False,
                  iterative=False, isConstrained=False, **values):
    node = parent.addChild(name)
    node.addObject("EulerImplicitSolver", firstOrder=values.get("first_order", firstOrder),
                   rayleighStiffness=values.get("rayleigh_stiffness", rayleighStiffness), rayleighMass=values.get("rayleigh_mass", rayleighMass))
    solver = node.addObject("CGLinearSolver" if iterative else "SparseLDLSolver", name="Solver", template=template)
    if values.get("is_constrained", isConstrained):
        node.addObject("GenericConstraintCorrection", linearSolver=solver.getLinkPath())
    return node


def addMappedPoints(parentNode, name="pointsInFEM", position=None, showObject="1", showIndices="1",
                    femPos="0.0 0 0 15 0 0 30 0 0 45 0 0 60 0 0 66 0 0 81 0.0 0.0"):
    points = parentNode.addChild(name)
    points.addObject("MechanicalObject", name=f"{name}Mo", position=femPos if position is None else position, template="Vec3d",
                     showObject=showObject, showIndices=showIndices)
    points.addObject("BarycentricMapping")
    return points


def Finger(parentNode=None, name="Finger", rotation=None, translation=None, fixingBox=None, path="", femPos=None):
    """(node, points in it), of finger.vtk and finger.stl in the folder `path`."""
    finger = parentNode.addChild(name)
    body = ElasticMaterialObject(finger, volumeMeshFileName=f"{path}finger.vtk", poissonRatio=0.48, youngModulus=500, totalMass=0.075,
                                 surfaceColor=[0.0, 0.7, 0.7, 0.5], surfaceMeshFileName=f"{path}finger.stl",
                                 rotation=rotation or [0.0, 180.0, 0.0], translation=translation or [-17.5, -12.5, 7.5])
    FixedBox(body, doVisualization=True, atPositions=fixingBox or [-18, -15, -8, 2, -3, 8])
    points = addMappedPoints(body) if femPos is None else addMappedPoints(body, femPos=femPos)
    finger.addChild(body)
    return finger, points
