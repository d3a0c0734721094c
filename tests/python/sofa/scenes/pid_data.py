# SPDX-License-Identifier: LGPL-2.1-or-later
"""A PID controller with its target as data, a load that is written in place, events that nobody needs."""
import Sofa


class PID(Sofa.Core.Controller):
    kp, ki, kd = 20., 1., 2.

    def __init__(self, state, load, *args, **kwargs):
        Sofa.Core.Controller.__init__(self, *args, **kwargs)
        self.addData(name="target", type="double", value=1.0, help="where to go", group="Properties")
        self.state, self.load, self.i, self.last = state, load, 0., None

    def onAnimateBeginEvent(self, e):
        error = self.target.value - self.state.position.value[0][0]
        self.i += error * e['dt']
        d = 0 if self.last is None else (error - self.last) / e['dt']
        self.last = error
        with self.load.forces.writeable() as w:
            w[0] = [self.kp * error + self.ki * self.i + self.kd * d, 0, 0]

    def onEvent(self, e):
        pass


def createScene(root):
    root.bbox = [[-1] * 3, [1] * 3]
    root.gravity = [0] * 3
    root.addObject('DefaultAnimationLoop')
    n = root.addChild('n')
    n.addObject('EulerExplicitSolver', symplectic=True)
    s = n.addObject('MechanicalObject', name='s', position=[[0, 0, 0]])
    n.addObject('UniformMass', totalMass=1.)
    load = n.addObject('ConstantForceField', name='l', indices=[0], forces=[[0, 0, 0]])
    root.addObject(PID(s, load, name='pid'))
