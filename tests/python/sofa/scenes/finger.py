# SPDX-License-Identifier: LGPL-2.1-or-later
"""A finger that a cable bends, with the controller in a module beside it."""
import os

from FingerController import FingerController

path = os.path.dirname(os.path.abspath(__file__)) + '/mesh/'


def createScene(rootNode):
    rootNode.addObject("RequiredPlugin", name='SoftRobots')
    rootNode.addObject('RequiredPlugin', pluginName=["Sofa.Component.AnimationLoop", "Sofa.Component.IO.Mesh"])
    rootNode.addObject('VisualStyle', displayFlags='showVisualModels hideBehaviorModels showCollisionModels hideWireframe')
    rootNode.addObject('FreeMotionAnimationLoop')
    rootNode.addObject('DefaultVisualManagerLoop')
    rootNode.addObject('GenericConstraintSolver', tolerance=1e-5, maxIterations=100)
    rootNode.gravity = [0, -9810, 0]
    rootNode.dt = 0.01

    finger = rootNode.addChild('finger')
    finger.addObject('EulerImplicitSolver', name='odesolver', rayleighMass=0.1, rayleighStiffness=0.1)
    finger.addObject('SparseLDLSolver', template='CompressedRowSparseMatrixMat3x3d')
    finger.addObject('MeshVTKLoader', name='loader', filename=path + 'finger.vtk')
    finger.addObject('MeshTopology', src='@loader', name='container')
    finger.addObject('MechanicalObject', name='tetras', template='Vec3', showIndices=False, showIndicesScale=4e-5)
    finger.addObject('UniformMass', totalMass=0.075)
    finger.addObject('TetrahedronFEMForceField', template='Vec3', name='FEM', method='large', poissonRatio=0.45, youngModulus=600)
    finger.addObject('BoxROI', name='roi', box=[-1, -1, -1, 1, 21, 21], drawBoxes=True)
    finger.addObject('RestShapeSpringsForceField', points=finger.roi.indices.getLinkPath(), stiffness=1e12)
    finger.addObject('GenericConstraintCorrection')

    cable = finger.addChild('cable')
    cable.addObject('MechanicalObject', position=[[10, 18, 10], [30, 18, 10], [50, 18, 10], [70, 18, 10]])
    cable.addObject('CableConstraint', name="aCableActuator", indices=list(range(0, 4)), minForce=0, pullPoint=[0.0, 18, 10])
    cable.addObject('BarycentricMapping')
    cable.addObject(FingerController(name="FingerController", node=cable))

    fingerVisu = finger.addChild('visu')
    fingerVisu.addObject('MeshSTLLoader', filename=path + "finger.stl", name="loader")
    fingerVisu.addObject('OglModel', src="@loader", color=[0.0, 0.7, 0.7, 1])
    fingerVisu.addObject('BarycentricMapping')
    return rootNode
