# SPDX-License-Identifier: LGPL-2.1-or-later
"""Frames at joints, moved by an angle that a controller writes."""
import math

import Sofa


class Servo(Sofa.Prefab):
    prefabParameters = [
        {"name": "angle", "type": "float", "help": "of the wheel", "default": 0.0},
        {"name": "position", "type": "vector<double>", "help": "of the servo", "default": [0, 0, 0, 0, 0, 0, 1]},
    ]

    def __init__(self, *args, **kwargs):
        Sofa.Prefab.__init__(self, *args, **kwargs)

    def init(self):
        self.addObject("MechanicalObject", name="dofs", template="Vec1", position=[[self.angle.value]])
        self.addObject("ArticulatedHierarchyContainer")
        center = self.addChild("articulationCenters").addChild("articulationCenter")
        center.addObject("ArticulationCenter", parentIndex=0, childIndex=1, posOnParent=[0., 0., 0.], posOnChild=[0., 0., 0.])
        articulation = center.addChild("articulations")
        articulation.addObject("Articulation", translation=False, rotation=True, rotationAxis=[1, 0, 0], articulationIndex=0)
        rigid = self.addChild("ServoWheel")
        rigid.addObject("MechanicalObject", template="Rigid3", name="dofs", position=[[0., 0., 0., 0., 0., 0., 1.]] * 2)
        rigid.addObject("UniformMass", totalMass=0.1)
        rigid.addObject("ArticulatedSystemMapping", input1=self.dofs.getLinkPath(), output=rigid.dofs.getLinkPath())


class Drive(Sofa.Core.Controller):
    def __init__(self, *args, **kwargs):
        Sofa.Core.Controller.__init__(self, *args, **kwargs)
        self.servo, self.t = kwargs["servo"], 0.0

    def onAnimateBeginEvent(self, event):
        self.t += event["dt"]
        self.servo.dofs.rest_position.value = [[math.sin(self.t)]]


def createScene(root):
    root.gravity = [0, 0, 0]
    root.addObject("DefaultAnimationLoop")
    simulation = root.addChild("Simulation")
    simulation.addObject("EulerImplicitSolver", rayleighStiffness=0.1)
    simulation.addObject("SparseLDLSolver", template="CompressedRowSparseMatrixd")
    servo = simulation.addChild(Servo(name="Servo"))
    servo.dofs.showObject = True
    servo.addObject("RestShapeSpringsForceField", points=0, stiffness=1e4)
    root.addObject(Drive(name="drive", servo=servo))
