# SPDX-License-Identifier: LGPL-2.1-or-later
"""A force in Python that fails when it is asked for the third time, and one whose matrix takes other values than SOFA gives."""
import Sofa


class Failing(Sofa.Core.ForceFieldVec3d):
    asked = 0

    def addForce(self, params, force, position, velocity):
        self.asked += 1
        if self.asked == 3:
            [].pop()


class OtherValues(Sofa.Core.ForceFieldVec3d):
    def addForce(self, params, force, position, velocity):
        pass

    def addKToMatrix(self, size):
        return []


def createScene(root, kind=Failing, solver="EulerExplicitSolver"):
    root.addObject("DefaultAnimationLoop")
    body = root.addChild("body")
    body.addObject(solver)
    if solver == "EulerImplicitSolver":
        body.addObject("SparseLDLSolver")
    body.addObject("MechanicalObject", name="dofs", position=[0, 0, 0])
    body.addObject("UniformMass", totalMass=1)
    body.addObject(kind(name="force"))
