# SPDX-License-Identifier: LGPL-2.1-or-later
"""A catheter, a hooked guide wire and a coil, which a script pushes out one in the other and draws back."""
import Sofa


class Hand(Sofa.Core.Controller):
    def __init__(self, *args, **kwargs):
        super().__init__(*args, **kwargs)
        self.controller, self.steps = kwargs['controller'], 0

    def onAnimateBeginEvent(self, event):
        self.steps += 1
        ways = [2, 0, 0] if self.steps <= 30 else [1, 2, 0] if self.steps <= 50 else [0, 0, 1] if self.steps <= 70 else [-2, 0, 0]
        self.controller.xtip.value = [tip + way for tip, way in zip(self.controller.xtip.value, ways)]


def instrument(root, name, length, radius, young, hook=None):
    shape = root.addChild('shape_' + name)
    shape.addObject('RodStraightSection', name='straight', youngModulus=young, nbEdgesCollis=int(length / 20), nbEdgesVisu=20, length=length,
                    radius=radius, massDensity=1.55e-6, poissonRatio=0.3)
    if hook:
        shape.addObject('RodSpireSection', name='hook', youngModulus=young, nbEdgesCollis=10, nbEdgesVisu=20, length=hook, spireDiameter=25,
                        spireHeight=0, radius=radius, massDensity=1.55e-6, poissonRatio=0.3)
    shape.addObject('WireRestShape', name='shape', template='Rigid3d', wireMaterials='@straight' + (' @hook' if hook else ''))
    shape.addObject('EdgeSetTopologyContainer', name='lines')


def createScene(rootNode):
    rootNode.gravity = [0, 0, 0]
    rootNode.dt = 0.05
    rootNode.addObject('FreeMotionAnimationLoop')
    rootNode.addObject('LCPConstraintSolver', mu=0.1, tolerance=1e-10, maxIt=1000)
    instrument(rootNode, 'catheter', 400., 1., 10000.)
    instrument(rootNode, 'guide', 500., 0.9, 10000., 25.)
    instrument(rootNode, 'coil', 600., 0.1, 168000.)
    tools = rootNode.addChild('tools')
    tools.addObject('EulerImplicitSolver', rayleighStiffness=0.2, rayleighMass=0.1)
    tools.addObject('BTDLinearSolver')
    tools.addObject('RegularGridTopology', name='mesh', nx=100, ny=1, nz=1, xmin=0, xmax=1, ymin=0, ymax=0, zmin=1, zmax=1)
    tools.addObject('MechanicalObject', template='Rigid3d', name='dofs')
    for name in ('catheter', 'guide', 'coil'):
        tools.addObject('WireBeamInterpolation', name='beams_' + name, WireRestShape='@../shape_' + name + '/shape')
        tools.addObject('AdaptiveBeamForceFieldAndMass', name='force_' + name, interpolation='@beams_' + name)
    controller = tools.addObject('InterventionalRadiologyController', template='Rigid3d', name='controller', xtip=[1, 0, 0], speed=0,
                                 rotationInstrument=[0, 0, 0], startingPos=[0, 0, 0, 0, 0, 0, 1],
                                 instruments='beams_catheter beams_guide beams_coil')
    tools.addObject('LinearSolverConstraintCorrection', wire_optimization=True)
    tools.addObject('FixedConstraint', indices=0)
    tools.addObject('RestShapeSpringsForceField', points='@controller.indexFirstNode', angularStiffness=1e8, stiffness=1e8)
    rootNode.addObject(Hand(name='hand', controller=controller))
