# SPDX-License-Identifier: LGPL-2.1-or-later
"""A guide wire in a catheter of BeamAdapter, pushed against a wall by a script: the points of contact come out with them."""
import Sofa


class Pusher(Sofa.Core.Controller):
    def __init__(self, *args, **kwargs):
        Sofa.Core.Controller.__init__(self, *args, **kwargs)
        self.controller, self.points = kwargs['controller'], kwargs['points']

    def onAnimateBeginEvent(self, event):
        with self.controller.xtip.writeable() as tips:
            tips[1] += 0.5
        with self.controller.rotationInstrument.writeable() as turns:
            turns[0] += 0.01

    def onAnimateEndEvent(self, event):
        places = self.points.position.value
        assert len(places) == 31
        assert max(place[0] - 40 - 0.1 * (place[2] + 50) for place in places) < 0, "no point is behind the wall"


def instrument(root, name, length, edges, radius):
    shape = root.addChild('topoLines_' + name)
    shape.addObject('RodStraightSection', name='section', length=length, radius=radius, nbEdgesCollis=edges, nbEdgesVisu=2 * edges,
                    youngModulus=10000, massDensity=1.55e-6, poissonRatio=0.3)
    shape.addObject('WireRestShape', template='Rigid3d', name='shape', wireMaterials='@section')
    shape.addObject('EdgeSetTopologyContainer', name='lines')
    shape.addObject('EdgeSetTopologyModifier', name='modifier')
    shape.addObject('MechanicalObject', template='Rigid3d', name='dofs')


def createScene(rootNode):
    rootNode.gravity = [0, 0, 0]
    rootNode.dt = 0.01
    rootNode.addObject('RequiredPlugin', name='BeamAdapter')
    rootNode.addObject('FreeMotionAnimationLoop')
    rootNode.addObject('LCPConstraintSolver', mu=0.1, tolerance=1e-6, maxIt=1000)
    rootNode.addObject('CollisionPipeline')
    rootNode.addObject('BruteForceBroadPhase')
    rootNode.addObject('BVHNarrowPhase')
    rootNode.addObject('LocalMinDistance', alarmDistance=3, contactDistance=0.5)
    rootNode.addObject('CollisionResponse', response='FrictionContactConstraint')
    instrument(rootNode, 'cath', 100., 10, 1.)
    instrument(rootNode, 'guide', 150., 30, 0.5)
    combined = rootNode.addChild('InstrumentCombined')
    combined.addObject('EulerImplicitSolver', rayleighStiffness=0.2, rayleighMass=0.1)
    combined.addObject('BTDLinearSolver')
    combined.addObject('RegularGridTopology', name='mesh', nx=60, ny=1, nz=1, xmin=0., xmax=1., ymin=0, ymax=0, zmin=1, zmax=1)
    combined.addObject('MechanicalObject', template='Rigid3d', name='DOFs')
    for name in ('cath', 'guide'):
        combined.addObject('WireBeamInterpolation', name='Interpol_' + name, WireRestShape='@../topoLines_' + name + '/shape')
        combined.addObject('AdaptiveBeamForceFieldAndMass', name='Force_' + name, interpolation='@Interpol_' + name)
    controller = combined.addObject('InterventionalRadiologyController', template='Rigid3d', name='m_ircontroller', xtip=[20, 44.4],
                                    rotationInstrument=[0, 0], startingPos=[0, 0, 0, 0, 0, 0, 1], speed=0,
                                    instruments='Interpol_cath Interpol_guide')
    combined.addObject('LinearSolverConstraintCorrection', wire_optimization=True)
    combined.addObject('FixedProjectiveConstraint', name='fixed', indices=0)
    combined.addObject('RestShapeSpringsForceField', points='@m_ircontroller.indexFirstNode', angularStiffness=1e8, stiffness=1e8)
    collision = combined.addChild('Collis')
    collision.addObject('EdgeSetTopologyContainer', name='collisEdgeSet')
    collision.addObject('EdgeSetTopologyModifier', name='colliseEdgeModifier')
    points = collision.addObject('MechanicalObject', name='CollisionDOFs')
    collision.addObject('MultiAdaptiveBeamMapping', name='multimapp', ircontroller='../m_ircontroller', useCurvAbs=1)
    collision.addObject('LineCollisionModel', proximity=0.0)
    collision.addObject('PointCollisionModel', proximity=0.0)
    picture = collision.addChild('picture')
    picture.addObject('MechanicalObject', name='same')
    picture.addObject('IdentityMapping')
    wall = rootNode.addChild('wall')
    wall.addObject('MeshTopology', name='mesh', position=[[40, -100, -50], [40, 100, -50], [60, 0, 150]], triangles=[[0, 2, 1]])
    wall.addObject('MechanicalObject', name='dofs')
    wall.addObject('TriangleCollisionModel', moving=False, simulated=False)
    rootNode.addObject(Pusher(name='pusher', controller=controller, points=points))
