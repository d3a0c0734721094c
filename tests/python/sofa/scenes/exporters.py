# SPDX-License-Identifier: LGPL-2.1-or-later
"""Files of a run: exporters, a monitor, written states."""
import os

import Sofa

OUT = os.path.join(os.getcwd(), "out_of_exporters")


def createScene(rootNode):
    os.makedirs(OUT, exist_ok=True)
    rootNode.addObject('RequiredPlugin', name='SofaExporter')
    rootNode.addObject('RequiredPlugin', name='SofaValidation')
    rootNode.addObject('DefaultAnimationLoop')
    body = rootNode.addChild('body')
    body.addObject('EulerImplicitSolver')
    body.addObject('CGLinearSolver', iterations=50, tolerance=1e-9, threshold=1e-9)
    body.addObject('MeshVTKLoader', name='loader', filename='mesh/finger.vtk')
    body.addObject('TetrahedronSetTopologyContainer', name='topo', src='@loader')
    body.addObject('MechanicalObject', name='dofs')
    body.addObject('UniformMass', totalMass=0.1)
    body.addObject('TetrahedronFEMForceField', youngModulus=3000, poissonRatio=0.3)
    body.addObject('FixedConstraint', indices=[0, 9, 18])
    body.addObject('VTKExporter', filename=OUT + '/body', listening=True, edges=0, triangles=0, quads=0, tetras=1, pointsDataFields=['dofs.velocity'],
                   exportEveryNumberOfSteps=5, XMLformat=True)
    body.addObject('Monitor', name="Monitor-finger", indices=80, template="Vec3", showPositions=1, PositionsColor=[0.0, 1.0, 0.0, 1.0],
                   ExportPositions=True, fileName=OUT + "/tip")
    body.addObject('WriteState', filename=OUT + '/state.data', writeX=True, writeV=False, period=0.02)
    surface = body.addChild('surface')
    surface.addObject('TriangleSetTopologyContainer', name='triangles')
    surface.addObject('TriangleSetTopologyModifier')
    surface.addObject('Tetra2TriangleTopologicalMapping', input='@../topo', output='@triangles')
    surface.addObject('STLExporter', filename=OUT + '/surface', exportEveryNumberOfSteps=5, listening=True)
