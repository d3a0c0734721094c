# SPDX-License-Identifier: LGPL-2.1-or-later
"""SofaPython of 2016: sys.path by the file, controllers by file and class, prints without brackets, xrange."""
import Sofa
import os, sys
path = os.path.dirname(os.path.abspath(__file__))
sys.path.append(path)


class MyController(Sofa.PythonScriptController):
    def onLoaded(self, node):
        print 'Controller script loaded from node %s' % node.findData('name').value
        self.counter = 0
        return 0

    def createGraph(self, node):
        self.rootNode = node.getRoot()
        return 0

    def initGraph(self, node):
        print 'initGraph'
        sys.stdout.flush()
        return 0

    def onBeginAnimationStep(self, dt):
        self.counter += 1
        state = self.rootNode.getChild('a').getObject('DOFs')
        if self.counter == 2:
            state.position = [[0.0, 1.0, 0.0]]
        positions = state.position
        for i in xrange(len(positions)):
            assert len(positions[i]) == 3
        if not self.rootNode.hasObject('later'): print 'nothing has come'
        return 0

    def onKeyPressed(self, k):
        if ord(k) == 19: print 'up'
        return 0

    def onGUIEvent(self, controlID, valueName, value):
        return 0


def createScene(node):
    node.createObject('RequiredPlugin', name='SofaPython', pluginName='SofaPython')
    a = node.createChild('a')
    a.createObject('EulerImplicit')
    a.createObject('CGLinearSolver', iterations=25, tolerance=1e-5, threshold=1e-5)
    a.createObject('MechanicalObject', name='DOFs', template='Vec3d', position='0 2 0')
    a.createObject('UniformMass', totalmass=str(1))
    node.createObject('PythonScriptController', name='ctrl', filename=__file__, classname='MyController')
    return node
