# SPDX-License-Identifier: LGPL-2.1-or-later
"""All the ways in which controllers read and write values."""
import numpy as np
import Sofa


class Ways(Sofa.Core.Controller):
    def __init__(self, *args, **kwargs):
        super(Ways, self).__init__(*args, **kwargs)
        self.node = kwargs.get("node")
        self.step = 0

    def onAnimateBeginEvent(self, event):
        self.step += 1
        dofs, load = self.node.dofs, self.node.load
        if self.step == 1:
            load.findData("forces").value = [[1, 0, 0], [0, 1, 0]]
        elif self.step == 2:
            load.forces = np.ones((2, 3))
        elif self.step == 3:
            load.forces.value = "1 2 3 4 5 6"
        elif self.step == 4:
            with load.forces.writeable() as f:
                f *= 2
        elif self.step == 5:
            with dofs.velocity.writeable() as v:
                v[:] = 0
        elif self.step == 6:
            dofs.position = dofs.position.value + np.array([0, 0, 1])
        elif self.step == 7:
            dofs.position.value = list(map(list, dofs.position.value))
        elif self.step == 8:
            dofs.findData("position").value[0] = [1.0, 2.0, 3.0]
        elif self.step == 9:
            dofs.position[1] = [4.0, 5.0, 6.0]
        elif self.step == 10:
            self.node.mass.findData("totalMass").value += 1.0
            dofs.position.value[:, 1] += 1
        if dofs.position.value[0][0] != None and len(dofs.position) == 2:  # noqa: E711
            self.last = dofs.position.value.tolist()
        assert dofs.findData("nothing") is None and dofs.findData("position") != None  # noqa: E711
        assert float(self.node.mass.totalMass.value) > 0 and dofs.getSize() == 2


def createScene(root):
    root.dt = 0.1
    root.gravity = [0, 0, 0]
    root.addObject("DefaultAnimationLoop")
    node = root.addChild("node")
    node.addObject("EulerImplicitSolver")
    node.addObject("CGLinearSolver", iterations=10, tolerance=1e-12, threshold=1e-12)
    node.addObject("MechanicalObject", name="dofs", position=np.zeros((2, 3)))
    node.addObject("UniformMass", name="mass", totalMass=2)
    node.addObject("ConstantForceField", name="load", indices=range(2), forces=[[0, 0, 0], [0, 0, 0]])
    node.addObject(Ways(name="ways", node=node))
