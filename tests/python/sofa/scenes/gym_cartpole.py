# SPDX-License-Identifier: LGPL-2.1-or-later
"""A scene of a gym: configuration, goals and rewards as controllers of the root, and a toolbox that starts commands."""
import os
import pathlib
import sys

import numpy as np
import Sofa
import Sofa.Core
import Sofa.Simulation

sys.path.insert(0, str(pathlib.Path(__file__).parent.absolute()) + "/../")
sys.path.insert(0, str(pathlib.Path(__file__).parent.absolute()))


class rewardShaper(Sofa.Core.Controller):
    """Compute the reward."""

    def __init__(self, *args, **kwargs):
        Sofa.Core.Controller.__init__(self, *args, **kwargs)
        self.rootNode = None
        if kwargs["rootNode"]:
            self.rootNode = kwargs["rootNode"]
        if kwargs["pole_length"]:
            self.pole_length = kwargs["pole_length"]

    def getReward(self):
        done, theta = self.calculateDone()
        return done, {"theta": theta}

    def calculateDone(self):
        cart = self.rootNode.Modeling.Cart.MechanicalObject.position.value.tolist()[0]
        return abs(cart[0]) > 24, cart[0]

    def update(self):
        pass


class goalSetter(Sofa.Core.Controller):
    def __init__(self, *args, **kwargs):
        Sofa.Core.Controller.__init__(self, *args, **kwargs)

    def update(self, goal):
        pass

    def set_mo_pos(self, goal):
        pass


class applyAction(Sofa.Core.Controller):
    def __init__(self, *args, **kwargs):
        Sofa.Core.Controller.__init__(self, *args, **kwargs)
        self.root = kwargs["root"]
        self.cart = self.root.Modeling.Cart
        self.incr = 1000

    def apply(self, action):
        with self.cart.force.forces.writeable() as forces:
            forces[0] = [self.incr * (1 if action == 0 else -1), 0, 0, 0, 0, 0]


def getState(root):
    cs = 3
    cart = root.Modeling.Cart.MechanicalObject.position.value.tolist()[0][0]
    vel = round(float(root.Modeling.Cart.MechanicalObject.velocity[0][0]), cs)
    return [cart, vel]


def getReward(root):
    return root.Reward.getReward()


def startCmd(root, action, duration):
    root.applyAction.apply(action)


def createScene(rootNode, config={"source": [0, 0, 160], "target": [0, 0, 0], "goalPos": [7, 0, 20]}, mode='simu_and_visu'):
    visu, simu = mode in ('visu', 'simu_and_visu'), mode in ('simu', 'simu_and_visu')
    if visu:
        rootNode.addObject("InteractiveCamera", name="camera", position=config["source"], lookAt=config["target"], distance=37,
                           fieldOfView=63, zNear=0.63, zFar=55.69)
        rootNode.addObject('OglSceneFrame', style="Arrows", alignment="TopRight")
    if simu:
        rootNode.addObject('DefaultAnimationLoop')
        rootNode.addObject('GenericConstraintSolver', tolerance="1e-6", maxIterations="1000")
        rootNode.addObject('FreeMotionAnimationLoop')
    rootNode.dt.value = 0.01
    model = rootNode.addChild("Modeling")
    model.addObject('EulerImplicitSolver', name='TimeIntegrationSchema')
    model.addObject('SparseLDLSolver', name='LinearSolver', template="CompressedRowSparseMatrixd")
    model.addObject('GenericConstraintCorrection')
    cart = model.addChild("Cart")
    cart.addObject("MechanicalObject", name="MechanicalObject", template="Rigid3d", position=np.array([0., 0., 0., 0., 0., 0., 1.]))
    cart.addObject('UniformMass', totalMass=5)
    cart.addObject('ConstantForceField', name='force', indices=[0], forces=[1000., 0, 0, 0, 0, 0])
    cart.addObject('PartialFixedConstraint', fixedDirections="0 1 1 1 1 1", indices=0)
    rootNode.addObject(rewardShaper(name="Reward", rootNode=rootNode, pole_length=4))
    rootNode.addObject(goalSetter(name="GoalSetter"))
    rootNode.addObject(applyAction(name="applyAction", root=rootNode))
    assert os.environ.get("NOTHING_OF_THIS", "") == "" and cart.force.forces.value.shape == (1, 6)
    return rootNode
