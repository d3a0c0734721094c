# SPDX-License-Identifier: LGPL-2.1-or-later
"""SofaPython: print statements, texts as values, the old alias `points` of a load, a controller that is given its node."""
import Sofa
import os


class Arm(Sofa.PythonScriptController):
    def initGraph(self, node):
        self.node = node
        self.total = 0

    def onBeginAnimationStep(self, dt):
        self.total += dt
        self.row = self.node.getObject('load').findData('indices').value[0][0]
        self.node.getObject('load').findData('totalForce').value = [1.0, 0, 0]

    def onKeyPressed(self, k):
        if ord(k) == 19:
            print 'up'


def createScene(rootNode):
    print 'creating', os.path.basename(__file__)
    rootNode.createObject('RequiredPlugin', pluginName='SoftRobots')
    rootNode.findData('gravity').value = '0 0 0'
    rootNode.findData('dt').value = 0.01
    node = rootNode.createChild('arm')
    node.createObject('EulerImplicit', rayleighMass='0.0')
    node.createObject('CGLinearSolver', iterations='20', tolerance='1e-12', threshold='1e-24')
    node.createObject('MechanicalObject', name='dofs', position='0 0 0  1 0 0')
    node.createObject('UniformMass', totalmass='2')
    node.createObject('ConstantForceField', name='load', totalForce='0 0 0', points='1')
    Arm(node)
    return rootNode
