# SPDX-License-Identifier: LGPL-2.1-or-later
"""A node that is switched off in the run, with the load that it holds; stresses of cells are read."""
import Sofa


class Switch(Sofa.Core.Controller):
    def __init__(self, *args, **kwargs):
        Sofa.Core.Controller.__init__(self, *args, **kwargs)
        self.body = kwargs["body"]

    def onAnimateBeginEvent(self, event):
        if self.body.getRoot().time.value > 0.25 and self.body.marks.activated.value:
            self.body.marks.activated = False


def createScene(root):
    root.gravity = [0, 0, 0]
    root.dt = 0.1
    root.addObject("DefaultAnimationLoop")
    body = root.addChild("body")
    body.addObject("EulerImplicitSolver")
    body.addObject("CGLinearSolver", iterations=200, tolerance=1e-14, threshold=1e-14)
    body.addObject("RegularGridTopology", name="grid", n=[2, 2, 2], min=[0, 0, 0], max=[1, 1, 1])
    body.addObject("MechanicalObject", name="dofs")
    body.addObject("UniformMass", totalMass=8)
    body.addObject("HexahedronFEMForceField", name="fem", youngModulus=1000, poissonRatio=0.3, method="large")
    marks = body.addChild("marks")
    marks.addObject("MechanicalObject", name="points", position=[[0.5, 0.5, 0.5]])
    marks.addObject("BarycentricMapping")
    marks.addObject("ConstantForceField", indices=[0], totalForce=[0, 0, 4])
    root.addObject(Switch(name="switch", body=body))
