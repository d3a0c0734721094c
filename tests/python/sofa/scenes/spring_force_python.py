# SPDX-License-Identifier: LGPL-2.1-or-later
"""A force field as the plugin's example: addForce with value, addDForce with factors of kFactor, a data of stiffness."""
import numpy as np
import Sofa


class RestShapeForceField(Sofa.Core.ForceFieldVec3d):
    def __init__(self, ks=1.0, kd=1.0, *args, **kwargs):
        Sofa.Core.ForceFieldVec3d.__init__(self, *args, **kwargs)
        self.addData("ks", type="float", value=ks, help="stiffness", group="Material")
        self.addData("kd", type="double", value=kd)

    def init(self):
        mstate = self.getContext().getMechanicalState()
        self.initpos = mstate.position.array().copy()
        self.ks.value *= 2

    def addForce(self, m, out_force, pos, vel):
        with out_force.writeableArray() as wa:
            wa[:] += self.ks.value * (self.initpos - pos.value) - self.kd.value * vel.value

    def addDForce(self, params, df, dx):
        with df.writeableArray() as wdf:
            wdf[:] -= dx.value * (self.ks.value * params['kFactor'] + self.kd.value * params['bFactor'])

    def getPotentialEnergy(self, *args):
        return 0.0


def createScene(root):
    root.gravity = [0, -10, 0]
    root.dt = 0.1
    root.addObject("DefaultAnimationLoop")
    n = root.addChild("n")
    n.addObject("EulerImplicitSolver")
    n.addObject("CGLinearSolver", iterations=30, tolerance=1e-12, threshold=1e-12)
    n.addObject("MechanicalObject", name="mo", position=np.random.default_rng(0).random((4, 3)))
    n.addObject("UniformMass", totalMass=4)
    field = n.addObject(RestShapeForceField(ks=50.0, kd=0.0, name="RestShape"))
    root.field = field

    class Look(Sofa.Core.Controller):
        def onAnimateEndEvent(self, event):
            assert field.ks.value == 100
            x = n.mo.position.value[:, 1] - n.mo.rest_position.value[:, 1]
            assert np.ptp(x) < 1e-9 and x.max() < 0, "all alike, and down"
    root.addObject(Look())
