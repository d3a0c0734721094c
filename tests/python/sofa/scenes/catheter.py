# SPDX-License-Identifier: LGPL-2.1-or-later
"""A guide wire of BeamAdapter whose tip a script pushes out before the run."""
import Sofa


def createScene(rootNode):
    rootNode.addObject('RequiredPlugin', name='BeamAdapter')
    rootNode.addObject('FreeMotionAnimationLoop')
    topo = rootNode.addChild('topoLines')
    topo.addObject('WireRestShape', name='restShape', template='Rigid3d', straightLength=600.0, length=1000.0,
                   spireDiameter=300.0, youngModulus=20000.0)
    topo.addObject('EdgeSetTopologyContainer', name='meshLines')
    rebuild = rootNode.addChild('InstrumentCombined')
    rebuild.addObject('EulerImplicitSolver', rayleighStiffness=0.2)
    rebuild.addObject('BTDLinearSolver', verification=False)
    rebuild.addObject('RegularGridTopology', name='MeshLines', nx=61, ny=1, nz=1, xmin=0.0, xmax=1.0, ymin=0, ymax=0, zmin=1, zmax=1)
    rebuild.addObject('MechanicalObject', name='DOFs', template='Rigid3d')
    rebuild.addObject('WireBeamInterpolation', name='Interpol', WireRestShape='@../topoLines/restShape')
    rebuild.addObject('AdaptiveBeamForceFieldAndMass', name='FF', interpolation='@Interpol')
    ircontroller = rebuild.addObject('InterventionalRadiologyController', name='m_ircontroller', instruments='Interpol', xtip=[1.0],
                                     step=0.5)
    ircontroller.xtip.value = [2.0]
    print(ircontroller.rotationInstrument, len(rebuild.MeshLines.position))
