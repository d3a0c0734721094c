# SPDX-License-Identifier: LGPL-2.1-or-later
"""Names and attributes of SOFA 20 and before: old loaders, mappings, masses, a mesh with its own position, file attributes."""


def createScene(rootNode):
    rootNode.addObject('RequiredPlugin', name='SofaMiscCollision')
    rootNode.addObject('DefaultVisualManagerLoop')
    rootNode.addObject('CollisionPipeline')
    rootNode.addObject('BruteForceDetection')
    rootNode.addObject('MinProximityIntersection', alarmDistance=0.8, contactDistance=0.5)
    rootNode.addObject('DefaultContactManager')
    n = rootNode.addChild('n')
    n.addObject('EulerImplicit', vdamping='0.0')
    n.addObject('CGSolver', iterations='25', tolerance='1e-9', threshold='1e-9')
    n.addObject('MeshVTKLoader', name='meshLoader', filename='mesh/finger.vtk')
    n.addObject('TetrahedronSetTopologyContainer', src='@meshLoader')
    n.addObject('MechanicalObject', template='Vec3d', src='@meshLoader')
    n.addObject('UniformMass', totalmass='1.0')
    n.addObject('TetrahedronFEMForceField', name='FEM', youngModulus='100', poissonRatio='0.45', method='large',
                updateStiffnessMatrix=False, listening='true', drawHeterogeneousTetra='1')
    n.addObject('FixedConstraint', indices='0 1 2 3')
    v = n.addChild('Visual')
    v.addObject('OglModel', name='Visual', fileMesh='mesh/finger.stl', color='red')
    v.addObject('BarycentricMapping', object1='../..', object2='Visual')
    s = n.addChild('Surf')
    s.addObject('MeshSTLLoader', name='l', filename='mesh/finger.stl')
    s.addObject('Mesh', src='@l')
    s.addObject('MechanicalObject', src='@l')
    s.addObject('TTriangleModel', template='Vec3d')
    s.addObject('BarycentricMapping')
