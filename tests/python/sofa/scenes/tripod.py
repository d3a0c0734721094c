# SPDX-License-Identifier: LGPL-2.1-or-later
"""Motors with arms under a soft body: classes of objects that hold nodes, an angle as data, a key that starts animations."""
import math

import Sofa
from Sofa.constants import Key
from splib3.animation import AnimationManager, animate
from splib3.numerics import Quat, to_radians


class ServoMotor(Sofa.Prefab):
    prefabParameters = [
        {'name': 'rotation', 'type': 'Vec3d', 'help': 'Rotation', 'default': [0.0, 0.0, 0.0]},
        {'name': 'translation', 'type': 'Vec3d', 'help': 'Translation', 'default': [0.0, 0.0, 0.0]}]

    def init(self):
        self.addData(name='angle', group='S90Properties', help='angle of rotation', type='float', value=0)
        self.addData(name='angleIn', group='S90Properties', help='angle that is wanted', type='float', value=0)
        base = self.addChild('ServoBody')
        base.addObject('MechanicalObject', name='dofs', template='Rigid3', position=[[*self.translation.value, 0., 0., 0., 1.]])
        base.addObject('FixedConstraint', indices=0)
        wheel = base.addChild('ServoWheel')
        wheel.addObject('MechanicalObject', name='dofs', template='Rigid3', position=[[0., 0., 0., 0., 0., 0., 1.]])
        wheel.addObject('RigidRigidMapping', name='mapping', input='@..', output='@./')


class TripodController(Sofa.Core.Controller):
    def __init__(self, *args, **kwargs):
        Sofa.Core.Controller.__init__(self, *args, **kwargs)
        self.actuators = args[0]
        self.stepsize = 0.1
        self.name = 'TripodController'
        self.started = False

    def onKeypressedEvent(self, event):
        self.initTripod(event['key'])

    def initTripod(self, key):
        if key == Key.A and not self.started:
            self.started = True

            def setAngle(actuator, factor):
                actuator.angleIn.value = 0.3 * factor
            for actuator in self.actuators:
                animate(setAngle, {'actuator': actuator}, duration=0.05)

    def onAnimateBeginEvent(self, event):
        self.initTripod(Key.A)
        for actuator in self.actuators:
            with actuator.ServoBody.ServoWheel.dofs.rest_position.writeable() as rest:
                rest[0] = [0, 0, 0] + list(Quat.createFromAxisAngle([1., 0., 0.], actuator.angleIn.value))


def createScene(rootNode):
    from stlib3.scene import Scene
    scene = Scene(rootNode, gravity=[0., -9810., 0.], dt=0.01, plugins=['SofaSparseSolver', 'SoftRobots'])
    scene.addMainHeader()
    AnimationManager(rootNode)
    motors = []
    for i in range(0, 3):
        angle = math.radians(120 * i)
        assert abs(to_radians(120 * i) - angle) < 1e-12
        motor = ServoMotor(name='ActuatedArm' + str(i), translation=[60 * math.cos(angle), 0, 60 * math.sin(angle)])
        scene.Simulation.addChild(motor)
        motors.append(motor)
    rootNode.addObject(TripodController(motors))
