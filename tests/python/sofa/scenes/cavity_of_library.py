# SPDX-License-Identifier: LGPL-2.1-or-later
"""A cavity by the function of a library, whose volume an animation lets grow until its walls bulge."""
from softrobots.actuators import PneumaticCavity
from splib3.animation import animate
from stlib3.physics.constraints import FixedBox
from stlib3.physics.deformable import ElasticMaterialObject
from stlib3.scene import ContactHeader, MainHeader


def inflate(target, factor):
    with target.value.writeable() as value:
        value[0] = 100.0 * factor


def createScene(rootNode):
    MainHeader(rootNode, gravity=[0.0, -9810, 0.0], plugins=['SofaPython3', 'SoftRobots'])
    ContactHeader(rootNode, alarmDistance=5, contactDistance=1, frictionCoef=0.7)
    rootNode.VisualStyle.displayFlags = 'showBehavior'
    bunny = rootNode.addChild(ElasticMaterialObject(name='bunny', volumeMeshFileName='mesh/finger.vtk', youngModulus=18000,
                                                    poissonRatio=0.4, totalMass=0.1, surfaceMeshFileName='mesh/finger.stl'))
    FixedBox(bunny, atPositions=[-1, -1, -1, 1, 21, 21], doVisualization=True)
    cavity = PneumaticCavity(surfaceMeshFileName='mesh/cavity.stl', attachedAsAChildOf=bunny, valueType='volumeGrowth')
    animate(inflate, {'target': cavity.SurfacePressureConstraint}, duration=0.1, mode='loop')
    return rootNode
