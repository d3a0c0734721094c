# SPDX-License-Identifier: LGPL-2.1-or-later
"""A region that a load has its nodes from grows while the scene runs: by a link to data, or written by itself."""
import os

import Sofa


class Grower(Sofa.Core.Controller):
    def __init__(self, *arguments, **values):
        Sofa.Core.Controller.__init__(self, *arguments, **values)
        self.body, self.steps = values["body"], 0

    def onAnimateBeginEvent(self, event):
        self.steps += 1
        if self.steps == 5:
            region = self.body.region if os.environ.get("REGION") == "itself" else self.body
            region.box.value = [-1, -1, -1, 2, 1, 1]

    def onAnimateEndEvent(self, event):
        if self.steps == 8:
            print("heights", *self.body.dofs.position.value[:, 1])


def createScene(root):
    root.dt = 0.01
    root.gravity = [0, 0, 0]
    root.addObject("DefaultAnimationLoop")
    body = root.addChild("Body")
    body.addData(name="box", type="vector<double>", value=[-1, -1, -1, 0.5, 1, 1], help="where the load is", group="")
    body.addObject("EulerImplicitSolver")
    body.addObject("SparseLDLSolver")
    body.addObject("MechanicalObject", name="dofs", position=[[0, 0, 0], [1, 0, 0]])
    body.addObject("UniformMass", totalMass=2)
    body.addObject("BoxROI", name="region", box=body.box.getLinkPath())
    body.addObject("ConstantForceField", forces=[0, 1, 0], indices="@region.indices")
    root.addObject(Grower(name="Grower", body=body))
