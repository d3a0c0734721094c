# SPDX-License-Identifier: LGPL-2.1-or-later
"""A pneumatic finger with a stiff layer: a part of the mesh has a second force field, keys change the pressure."""
import Sofa
from Sofa.constants import *


class PressureController(Sofa.Core.Controller):
    def __init__(self, *args, **kwargs):
        Sofa.Core.Controller.__init__(self, args, kwargs)
        self.node = args[0]
        self.constraint = self.node.cavity.getObject('SurfacePressureConstraint')
        self.steps = 0

    def onAnimateBeginEvent(self, event):
        self.steps += 1
        pressureValue = self.constraint.value.value[0]
        pressureValue += 0.01
        if pressureValue > 1.5:
            pressureValue = 1.5
        self.constraint.value.value = [pressureValue]

    def onKeypressedEvent(self, e):
        if e["key"] == Key.minus:
            self.constraint.value.value = [max(0, self.constraint.value.value[0] - 0.01)]


def createScene(rootNode):
    rootNode.addObject('VisualStyle', displayFlags='showForceFields')
    rootNode.addObject('RequiredPlugin', pluginName='SoftRobots SofaPython3 SofaLoader SofaSimpleFem SofaEngine')
    rootNode.findData('gravity').value = [0, -9810, 0]
    rootNode.addObject('FreeMotionAnimationLoop')
    rootNode.addObject('GenericConstraintSolver', tolerance=1e-12, maxIterations=10000)

    finger = rootNode.addChild('finger')
    finger.addObject('EulerImplicitSolver', name='odesolver', rayleighStiffness=0.1, rayleighMass=0.1)
    finger.addObject('SparseLDLSolver', name='directSolver')
    finger.addObject('MeshVTKLoader', name='loader', filename='mesh/finger.vtk')
    finger.addObject('MeshTopology', src='@loader', name='container')
    finger.addObject('MechanicalObject', name='tetras', template='Vec3', showObject=True, showObjectScale=1)
    finger.addObject('TetrahedronFEMForceField', template='Vec3', name='FEM', method='large', poissonRatio=0.3, youngModulus=500)
    finger.addObject('UniformMass', totalMass=0.0008)
    finger.addObject('BoxROI', name='boxROISubTopo', box=[-1, -1, -1, 81, 11, 21], strict=False)
    finger.addObject('BoxROI', name='boxROI', box=[-1, -1, -1, 1, 21, 21], drawBoxes=True)
    finger.addObject('RestShapeSpringsForceField', points='@boxROI.indices', stiffness=1e12, angularStiffness=1e12)
    finger.addObject('LinearSolverConstraintCorrection', linearSolver='@directSolver')

    modelSubTopo = finger.addChild('modelSubTopo')
    modelSubTopo.addObject('MeshTopology', position='@loader.position', tetrahedra='@boxROISubTopo.tetrahedraInROI', name='container')
    modelSubTopo.addObject('TetrahedronFEMForceField', template='Vec3', name='FEM', method='large', poissonRatio=0.3,
                           youngModulus=1500)

    cavity = finger.addChild('cavity')
    cavity.addObject('MeshSTLLoader', name='loader', filename='mesh/cavity.stl')
    cavity.addObject('MeshTopology', src='@loader', name='topo')
    cavity.addObject('MechanicalObject', name='cavity')
    cavity.addObject('SurfacePressureConstraint', name='SurfacePressureConstraint', template='Vec3', value=0.0001, triangles='@topo.triangles',
                     valueType='pressure')
    cavity.addObject('BarycentricMapping', name='mapping', mapForces=False, mapMasses=False)
    rootNode.addObject(PressureController(finger))
