# SPDX-License-Identifier: LGPL-2.1-or-later
"""A force field written in Python, in SOFA's way: springs to where the nodes are at the start."""
import Sofa


class Springs(Sofa.Core.ForceFieldVec3d):
    def __init__(self, *args, **kwargs):
        Sofa.Core.ForceFieldVec3d.__init__(self, *args, **kwargs)
        self.addData("stiffness", type="double", value=kwargs["k"], help="of each spring")

    def init(self):
        self.start = self.mstate.rest_position.array().copy()

    def addForce(self, m, out_force, position, velocity):
        with out_force.writeableArray() as force:
            force[:] += self.stiffness.value * (self.start - position.value)

    def addDForce(self, m, out_force, displacement):
        with out_force.writeableArray() as force:
            force[:] -= self.stiffness.value * displacement.value * m["kFactor"]


def createScene(root):
    root.gravity = [0, 0, 0]
    root.dt = 0.01
    root.addObject("DefaultAnimationLoop")
    body = root.addChild("body")
    body.addObject("EulerImplicitSolver")
    body.addObject("CGLinearSolver", iterations=20, tolerance=1e-14, threshold=1e-14)
    body.addObject("MechanicalObject", name="dofs", position=[0.5, 0, 0], rest_position=[0, 0, 0])
    body.addObject("UniformMass", totalMass=2)
    body.addObject(Springs(name="springs", k=100.0))
