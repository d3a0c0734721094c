# SPDX-License-Identifier: LGPL-2.1-or-later
"""Inverse control and CUDA: everything that is missing is told in one message, also what functions below would need."""
import Sofa
import numpy as np
from softrobots.inverse.actuators import PullingCable as InverseCable
import SofaCUDA_of_nobody
from pyDOE_of_nobody import lhs


def createScene(rootNode):
    rootNode.addObject('RequiredPlugin', pluginName='SoftRobots.Inverse')
    rootNode.addObject('FreeMotionAnimationLoop')
    rootNode.addObject('QPInverseProblemSolver', printLog=0, epsilon=1e-1)
    body = rootNode.addChild('body')
    body.addObject('EulerImplicitSolver')
    body.addObject('AsyncSparseLDLSolverOfNobody')
    body.addObject('MechanicalObject', template='CudaVec3f', position=[[0, 0, 0]])
    body.addObject('PositionEffector', indices=[0], effectorGoal=[0, 0, 0])
    body.addObject('CableActuator', indices=[0])
    InverseCable(body)
