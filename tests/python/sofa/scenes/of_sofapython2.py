# SPDX-License-Identifier: LGPL-2.1-or-later
"""The older SofaPython: createObject, texts as values, a script as a controller."""
import Sofa


class Wind(Sofa.PythonScriptController):
    def initGraph(self, node):
        self.node = node
        self.MechanicalState = node.getObject('dofs')
        self.t = 0

    def onBeginAnimationStep(self, dt):
        self.t += dt
        self.node.getObject('wind').findData('totalForce').value = '%f 0 0' % (0.1 * self.t)

    def onKeyPressed(self, k):
        return 0


def createScene(rootNode):
    rootNode.createObject('RequiredPlugin', pluginName='SoftRobots SofaPython')
    rootNode.findData('gravity').value = '0 -9.81 0'
    rootNode.createObject('VisualStyle', displayFlags='showVisualModels')
    rootNode.createObject('DefaultAnimationLoop')
    body = rootNode.createChild('body')
    body.createObject('EulerImplicit', name='odesolver', rayleighStiffness='0.1')
    body.createObject('CGLinearSolver', iterations='25', tolerance='1e-9', threshold='1e-9')
    body.createObject('Mesh', name='mesh', position='0 0 0 1 0 0 0 1 0 0 0 1', tetrahedra='0 1 2 3')
    body.createObject('MechanicalObject', name='dofs', template='Vec3d', rx='0', dz='0')
    body.createObject('UniformMass', totalmass='0.1')
    body.createObject('TetrahedronFEMForceField', template='Vec3d', name='FEM', method='large', poissonRatio='0.3', youngModulus='500')
    body.createObject('RestShapeSpringsForceField', points='0', stiffness='1e12')
    body.createObject('ConstantForceField', name='wind', indices='3', totalForce='0 0 0')
    Wind(body)
