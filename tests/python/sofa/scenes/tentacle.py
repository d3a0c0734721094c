# SPDX-License-Identifier: LGPL-2.1-or-later
"""A tentacle with eight cables in a circle, a beam of tetrahedra cut from a grid, and a target that nothing simulates."""
from math import cos, pi, sin

import numpy as np
import Sofa


class Circle(Sofa.Core.Controller):
    def __init__(self, name, cables, target, **kwargs):
        super().__init__(name=name, **kwargs)
        self.cables, self.target, self.time = cables, target, 0.0

    def onAnimateBeginEvent(self, event):
        self.time += event['dt']
        for k, cable in enumerate(self.cables):
            cable.value = [max(0.0, 0.5 * self.time * 10 * cos(2 * pi * k / len(self.cables)))]
        self.target.position.value = [[30 * cos(self.time), 30 * sin(self.time), 100]]


def createScene(root):
    root.addObject('VisualStyle', displayFlags='showForceFields showInteractionForceFields')
    root.gravity.value = np.array([0, 0, -9810.])
    root.dt.value = 1e-2
    root.addObject('FreeMotionAnimationLoop')
    root.addObject('GenericConstraintSolver', tolerance=1e-5, maxIterations=500)
    goal = root.addChild('goal')
    target = goal.addObject('MechanicalObject', name='goalMO', position=[0., 0., 100.], showObject=True, drawMode=1)
    goal.addObject('SphereCollisionModel', radius=5)
    body = root.addChild('tentacle')
    body.addObject('EulerImplicitSolver', rayleighMass=0.1, rayleighStiffness=0.1)
    body.addObject('SparseLDLSolver', name='solver', template='CompressedRowSparseMatrixMat3x3d')
    body.addObject('GenericConstraintCorrection', linearSolver='@solver')
    grid = body.addObject('RegularGridTopology', name='grid', n=[4, 4, 9], min=[-8, -8, 0], max=[8, 8, 90])
    body.addObject('TetrahedronSetTopologyContainer', name='container', position=grid.position.getLinkPath())
    body.addObject('TetrahedronSetTopologyModifier')
    body.addObject('Hexa2TetraTopologicalMapping', input='@grid', output='@container')
    body.addObject('MechanicalObject', name='tetras', template='Vec3')
    body.addObject('UniformMass', totalMass=0.05)
    body.addObject('TetrahedronFEMForceField', poissonRatio=0.4, youngModulus=450, method='large')
    held = np.flatnonzero(grid.position.value[:, 2] < 1e-9)
    body.addObject('RestShapeSpringsForceField', points=held.tolist(), stiffness=1e10)
    cables = []
    for k in range(8):
        angle = k * pi / 4
        line = [[6 * cos(angle), 6 * sin(angle), z] for z in np.linspace(10, 85, 6)]
        node = body.addChild(f'cable_{k}')
        node.addObject('MechanicalObject', position=line)
        cables.append(node.addObject('CableConstraint', indices=np.arange(6), pullPoint=[line[0][0], line[0][1], 0],
                                     value=np.zeros(1), valueType='displacement', minForce=0))
        node.addObject('BarycentricMapping')
    root.addObject(Circle('circle', cables, target))
