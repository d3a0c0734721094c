# SPDX-License-Identifier: LGPL-2.1-or-later
"""A force field in Python with data of its own, as SofaPython3 shows it: a force, its derivative, a matrix that is not made."""
import Sofa


class RestShape(Sofa.Core.ForceFieldVec3d):
    def __init__(self, ks=10.0, kd=0.1, *args, **kwargs):
        Sofa.Core.ForceFieldVec3d.__init__(self, *args, **kwargs)
        self.addData("ks", type="double", value=ks, help="stiffness", group="Spring")
        self.addData("kd", type="double", value=kd)

    def init(self):
        self.rest = self.getContext().mo.rest_position.value.copy()

    def addForce(self, m, out_force, position, velocity):
        with out_force.writeableArray() as wa:
            wa[:] += (self.rest - position.value) * self.ks.value - velocity.value * self.kd.value

    def addDForce(self, df, dx, params, bFactor=1.0):
        with df.writeableArray() as wa:
            wa[:] -= dx.value * self.ks.value * params["kFactor"]


def createScene(root):
    root.gravity = [0, -10, 0]
    root.addObject("DefaultAnimationLoop")
    n = root.addChild("n")
    n.addObject("EulerImplicitSolver")
    n.addObject("CGLinearSolver", iterations=30, tolerance=1e-12, threshold=1e-20)
    n.addObject("MechanicalObject", name="mo", position=[[0, 0, 0], [1, 0, 0]])
    n.addObject("UniformMass", totalMass=2)
    n.addObject(RestShape(ks=100.0, name="ff"))
