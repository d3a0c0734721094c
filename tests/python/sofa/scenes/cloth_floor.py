# SPDX-License-Identifier: LGPL-2.1-or-later
"""A cloth on a ball: triangles and bending, penalties by contact stiffness, a plane that is a force."""


def createScene(rootNode):
    rootNode.findData('gravity').value = [0, -9.81, 0]
    rootNode.findData('dt').value = 0.005
    rootNode.addObject('DefaultPipeline', name='CollisionPipeline', verbose='0')
    rootNode.addObject('BruteForceBroadPhase')
    rootNode.addObject('BVHNarrowPhase')
    rootNode.addObject('DefaultContactManager', name='collision response', response='PenalityContactForceField')
    rootNode.addObject('NewProximityIntersection', alarmDistance=.1, contactDistance=.05)
    rootNode.addObject('DefaultAnimationLoop')
    cloth = rootNode.addChild('cloth node')
    cloth.addObject('EulerImplicitSolver', name='implicit solver', rayleighStiffness=0.01, rayleighMass=0.1)
    cloth.addObject('CGLinearSolver', name='cg', iterations=100, tolerance=1e-8, threshold=1e-8)
    cloth.addObject('RegularGridTopology', name='grid', n=[8, 1, 8], min=[-1, 1, -1], max=[1, 1, 1])
    cloth.addObject('MechanicalObject', name='my dofs')
    cloth.addObject('TriangleSetTopologyContainer', name='tri', position='@grid.position', triangles=cloth.grid.triangles.value)
    cloth.addObject('UniformMass', totalMass=0.2)
    cloth.addObject('TriangularFEMForceField', template='Vec3d', youngModulus=100, poissonRatio=0.3, method='large')
    cloth.addObject('TriangularBendingSprings', stiffness=5, damping=0.1)
    cloth.addObject('PlaneForceField', normal=[0, 1, 0], d=-0.5, stiffness=300, showPlane=True)
    touch = cloth.addChild('touch')
    touch.addObject('MechanicalObject', position='@../my dofs.position')
    touch.addObject('PointCollisionModel', contactStiffness=50, group='1')
    touch.addObject('IdentityMapping', input='@../my dofs', output='@./')
    ball = rootNode.addChild('ball')
    ball.addObject('MechanicalObject', position=[0, 0.4, 0], name='centre')
    ball.addObject('SphereModel', radius=0.5, moving='0', simulated='0', contactStiffness=50)
    path = cloth.getObject('my dofs').getLinkPath()
    assert path == '@/cloth node/my dofs' and len(cloth.getObject('my dofs').position.value) == 64
    springs = rootNode.addChild('springs')
    springs.addObject('StiffSpringForceField', object1=path, object2='@/cloth node/my dofs', spring='0 7 10 0 2')
