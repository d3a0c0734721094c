# SPDX-License-Identifier: LGPL-2.1-or-later
"""Calls of the older SofaPython: createObject, createChild, a script as a controller by its file."""
import Sofa


class Counter(Sofa.PythonScriptController):
    def initGraph(self, node):
        self.node = node
        self.count = 0
        self.last = None

    def onBeginAnimationStep(self, dt):
        self.count += 1
        self.last = self.node.getChild("body").getObject("dofs").findData("position").value[0][2]

    def onKeyPressed(self, key):
        self.key = key
        return 0


def createSceneAndController(rootNode):
    rootNode.findData("dt").value = 0.1
    rootNode.findData("gravity").value = "0 0 -10"
    rootNode.createObject("DefaultAnimationLoop")
    body = rootNode.createChild("body")
    body.createObject("EulerImplicit", name="odesolver")
    body.createObject("CGLinearSolver", iterations="10", tolerance="1e-14", threshold="1e-14")
    body.createObject("MechanicalObject", name="dofs", template="Vec3d", position="0 0 0")
    body.createObject("UniformMass", totalmass="1")
    rootNode.createObject("PythonScriptController", name="counter", filename=__file__, classname="Counter")
    return rootNode
