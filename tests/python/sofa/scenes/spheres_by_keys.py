# SPDX-License-Identifier: LGPL-2.1-or-later
"""New bodies while the scene runs, pushed by forces that change."""
import random

import Sofa
from Sofa.constants import Key


class KeyPressedController(Sofa.Core.Controller):
    def __init__(self, *args, **kwargs):
        Sofa.Core.Controller.__init__(self, *args, **kwargs)
        self.iteration = kwargs["iteration"] if "iteration" in kwargs else 0
        self.root = kwargs["root"]
        self.steps = 0

    def onAnimateBeginEvent(self, event):
        self.steps += 1
        if self.steps in (3, 6):
            self.createNewSphere()

    def onKeypressedEvent(self, event):
        key = event['key']
        if ord(key) == 19:
            print("up")
        if key == Key.L:
            self.createNewSphere()

    def createNewSphere(self):
        newSphere = self.root.addChild('FallingSphere-' + str(self.iteration))
        newSphere.addObject('EulerImplicitSolver')
        newSphere.addObject('CGLinearSolver', threshold='1e-09', tolerance='1e-09', iterations='200')
        MO = newSphere.addObject('MechanicalObject', showObject=True, position=[5 * self.iteration, 10, 0, 0, 0, 0, 1], name=f'Particle-{self.iteration}',
                                 template='Rigid3d')
        newSphere.addObject('UniformMass', totalMass=1)
        newSphere.addObject('ConstantForceField', name="CFF", totalForce=[round(random.uniform(-4, 4), 2), 0, 0, 0, 0, 0])
        newSphere.addObject('SphereCollisionModel', name="SCM", radius=1.0)
        newSphere.init()
        self.iteration = self.iteration + 1
        assert MO.position.value.shape == (1, 7)
        print(MO.name.value, len(MO.position.value))


def createScene(root):
    root.gravity = [0, -9.81, 0]
    root.addObject('DefaultAnimationLoop')
    root.addObject('CollisionPipeline', depth="6", verbose="0", draw="0")
    root.addObject('BruteForceBroadPhase')
    root.addObject('BVHNarrowPhase')
    root.addObject('MinProximityIntersection', name="Proximity", alarmDistance="0.5", contactDistance="0.3")
    root.addObject('CollisionResponse', name="Response", response="PenalityContactForceField")
    root.addObject(KeyPressedController(name="SphereCreator", root=root))
