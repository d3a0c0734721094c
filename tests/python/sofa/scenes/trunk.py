# SPDX-License-Identifier: LGPL-2.1-or-later
"""A trunk as a class that holds its node, with four cables that an animation pulls."""
from math import cos, pi, sin

import numpy as np
import Sofa
from splib3.animation import AnimationManager, animate
from splib3.numerics import Quat, Vec3
from stlib3.scene import MainHeader


def SetAnimation(trunk):
    def animation(target, factor):
        target.cables[0].CableConstraint.value = [factor * 2]

    animate(animation, {"target": trunk}, duration=0.05, onDone=lambda target, factor: target.done.append(factor))


class Trunk:
    def __init__(self, parentNode, youngModulus=450, poissonRatio=0.45, totalMass=0.042, inverseMode=False):
        self.node = parentNode.addChild('Trunk')
        self.done = []
        self.node.addObject('MeshVTKLoader', name='loader', filename='mesh/finger.vtk')
        self.node.addObject('TetrahedronSetTopologyContainer', src='@loader', name='container')
        self.node.addObject('TetrahedronSetTopologyModifier')
        self.node.addObject('TetrahedronSetGeometryAlgorithms')
        self.node.addObject('MechanicalObject', name='dofs', template='Vec3', showIndices='false', showIndicesScale='4e-5')
        self.node.addObject('UniformMass', totalMass=totalMass)
        self.node.addObject('TetrahedronFEMForceField', template='Vec3', name='FEM', method='large', poissonRatio=poissonRatio,
                            youngModulus=youngModulus)
        self.cables = []
        self.__addCables()

    def __addCables(self):
        length1, radius = 70., 8.
        nbCables = 4
        for i in range(0, nbCables):
            theta = 2 * pi * i / nbCables
            q = Quat(sin(theta / 2.), 0., 0., cos(theta / 2.))
            position = [[0, 0, 0]] * 4
            for k in range(0, 4):
                v = Vec3(10. + 20. * k, radius, 0.)
                position[k] = list(np.array(q.rotate(v)) + [0, 10, 10])
            pull = list(np.array(q.rotate(Vec3(0., radius, 0.))) + [0, 10, 10])
            cable = self.node.addChild('cableL' + str(i))
            cable.addObject('MechanicalObject', name='meca', position=pull + [c for p in position for c in p])
            cable.addObject('CableConstraint', template='Vec3', name='CableConstraint', hasPullPoint=False, indices=list(range(5)),
                            maxPositiveDisp=length1, maxDispVariation=1, minForce=0)
            cable.addObject('BarycentricMapping', name='mapping', mapForces=False, mapMasses=False)
            self.cables.append(cable)

    def addVisualModel(self, color=[1., 1., 1., 1.]):
        trunkVisu = self.node.addChild('VisualModel')
        trunkVisu.addObject('MeshSTLLoader', filename='mesh/finger.stl', name='loader')
        trunkVisu.addObject('OglModel', template='Vec3', color=color, src='@loader')
        trunkVisu.addObject('BarycentricMapping')

    def fixExtremity(self):
        self.node.addObject('BoxROI', name='boxROI', box=[[-1, -1, -1], [1, 21, 21]], drawBoxes=False)
        self.node.addObject('PartialFixedConstraint', fixedDirections="1 1 1", indices="@boxROI.indices")


def createScene(rootNode):
    rootNode.addObject('RequiredPlugin', pluginName='SoftRobots SofaSparseSolver SofaPreconditioner SofaPython3')
    AnimationManager(rootNode)
    rootNode.addObject("VisualStyle", displayFlags="showBehaviorModels")
    rootNode.gravity.value = [0., -9810., 0.]
    rootNode.addObject('FreeMotionAnimationLoop')
    rootNode.addObject('GenericConstraintSolver', maxIterations=100, tolerance=1e-5)
    simulation = rootNode.addChild("Simulation")
    simulation.addObject('EulerImplicitSolver', name='odesolver', firstOrder=False, rayleighMass=0.1, rayleighStiffness=0.1)
    simulation.addObject('ShewchukPCGLinearSolver', name='linearSolver', iterations=500, tolerance=1.0e-18, preconditioner="precond")
    simulation.addObject('SparseLDLSolver', name='precond')
    simulation.addObject('GenericConstraintCorrection', linearSolver='@precond')
    trunk = Trunk(simulation, inverseMode=False)
    rootNode.trunk = trunk
    trunk.addVisualModel(color=[1., 1., 1., 0.8])
    trunk.fixExtremity()
    SetAnimation(trunk)
    return rootNode
