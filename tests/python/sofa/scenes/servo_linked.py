# SPDX-License-Identifier: LGPL-2.1-or-later
"""A servo motor as libraries of robots have it: the wanted angle is data of a prefab, and the rest position of a hinge a link to
it. Beside it a body whose force, stiffness and goal are links to such data."""
import math

import Sofa


class Servo(Sofa.Prefab):
    prefabData = [{"name": "angleIn", "group": "S90", "help": "wanted angle in rad", "type": "float", "default": 0}]

    def __init__(self, *arguments, **values):
        Sofa.Prefab.__init__(self, *arguments, **values)

    def init(self):
        base = self.addChild("Base")
        base.addObject("MechanicalObject", name="dofs", template="Rigid3", position=[0, 0, 0, 0, 0, 0, 1])
        base.addObject("FixedProjectiveConstraint", indices=0)
        base.addObject("UniformMass", totalMass=0.01)
        angle = self.addChild("Articulation")
        angle.addObject("MechanicalObject", name="dofs", template="Vec1", position=[[0]],
                        rest_position=self.getData("angleIn").getLinkPath())
        angle.addObject("RestShapeSpringsForceField", points=0, stiffness=1e9)
        angle.addObject("UniformMass", totalMass=0.01)
        wheel = angle.addChild("Wheel")
        wheel.addObject("MechanicalObject", name="dofs", template="Rigid3", position=[[0, 0, 0, 0, 0, 0, 1]] * 2)
        wheel.addObject("ArticulatedSystemMapping", input1=angle.dofs.getLinkPath(), input2=base.dofs.getLinkPath(), output="@./")
        angle.addObject("ArticulatedHierarchyContainer")
        centre = angle.addChild("ArticulationCenter")
        centre.addObject("ArticulationCenter", parentIndex=0, childIndex=1, posOnParent=[0, 0, 0], posOnChild=[0, 0, 0])
        centre.addChild("Articulations").addObject("Articulation", translation=False, rotation=True, rotationAxis=[1, 0, 0],
                                                   articulationIndex=0)


class Pulled(Sofa.Prefab):
    prefabData = [{"name": "force", "type": "Vec3d", "help": "", "default": [0.0, 0.0, 0.0]},
                  {"name": "goal", "type": "vector<Vec3d>", "help": "", "default": [[0.0, 0.0, 0.0]]},
                  {"name": "speed", "type": "vector<Vec3d>", "help": "", "default": [[0.0, 0.0, 0.0]]}]

    def __init__(self, *arguments, **values):
        Sofa.Prefab.__init__(self, *arguments, **values)

    def init(self):
        self.addObject("EulerImplicitSolver")
        self.addObject("SparseLDLSolver")
        self.addObject("MechanicalObject", name="dofs", position=[[0, 0, 0]], velocity=self.speed.getLinkPath())
        self.addObject("UniformMass", totalMass=2)
        self.addObject("ConstantForceField", totalForce=self.force.getLinkPath(), indices=0)
        self.addChild("Goal").addObject("MechanicalObject", name="dofs", position=self.goal.getLinkPath())


class Driver(Sofa.Core.Controller):
    def __init__(self, *arguments, **values):
        Sofa.Core.Controller.__init__(self, *arguments, **values)
        self.servo, self.pulled, self.steps = values["servo"], values["pulled"], 0

    def onAnimateBeginEvent(self, event):
        self.steps += 1
        self.servo.angleIn.value = 0.5 * math.sin(0.1 * self.steps)
        self.pulled.force.value = [0, self.steps, 0]
        self.pulled.goal.value = [[0.25 * self.steps, 0, 0]]
        if self.steps == 6:
            self.pulled.speed.value = [[0, 0, 1]]

    def onAnimateEndEvent(self, event):
        if self.steps == 10:
            print("angle", self.servo.Articulation.dofs.position.value[0][0], "goal", self.pulled.Goal.dofs.position.value[0][0],
                  "place", *self.pulled.dofs.position.value[0])


def createScene(root):
    root.dt = 0.01
    root.gravity = [0, 0, 0]
    root.addObject("DefaultAnimationLoop")
    robot = root.addChild("Robot")
    robot.addObject("EulerImplicitSolver", rayleighStiffness=0.1)
    robot.addObject("SparseLDLSolver", template="CompressedRowSparseMatrixd")
    servo = robot.addChild(Servo(name="Servo"))
    pulled = root.addChild(Pulled(name="Pulled"))
    root.addObject(Driver(name="Driver", servo=servo, pulled=pulled))
