# SPDX-License-Identifier: LGPL-2.1-or-later
"""A robot as a class that is no prefab, forwards what it does not know to its node, and is made twice; createScene by assignment."""
import numpy as np
import Sofa


class Robot:
    count = 0

    def __init__(self, parent, where=(0, 0, 0), **params):
        Robot.count += 1
        self.node = parent.addChild(f"robot_{Robot.count}")
        self.where = np.asarray(where, float)
        self.params = {"young": 3000., "mass": 0.1, **params}
        self.__build()

    def __getattr__(self, name):
        return getattr(self.__dict__["node"], name)

    def __build(self):
        self.node.addObject("EulerImplicitSolver", rayleighStiffness=.1)
        self.node.addObject("SparseLDLSolver", template="CompressedRowSparseMatrixMat3x3d")
        self.node.addObject("MeshVTKLoader", name="loader", filename="mesh/finger.vtk", translation=list(self.where))
        self.node.addObject("TetrahedronSetTopologyContainer", src="@loader", name="topology")
        self.node.addObject("MechanicalObject", name="dofs")
        self.node.addObject("UniformMass", totalMass=self.params["mass"])
        self.node.addObject("TetrahedronFEMForceField", youngModulus=self.params["young"], poissonRatio=0.4)
        low, high = self.where + [-1, -1, -1], self.where + [1, 21, 21]
        self.node.addObject("BoxROI", name="box", box=[*low, *high])
        self.node.addObject("FixedConstraint", indices=self.node.box.indices.linkpath)

    @property
    def tip(self):
        return self.node.dofs.position.value[np.argmax(self.node.loader.position.value[:, 0])]

    @staticmethod
    def make(root):
        root.addObject("DefaultAnimationLoop")
        robots = [Robot(root, (0, 0, 0)), Robot(root, [0, 50, 0], young=6000.)]

        class Compare(Sofa.Core.Controller):
            def onAnimateEndEvent(self, event):
                down = [r.dofs.position.value[:, 1] - r.loader.position.value[:, 1] for r in robots]
                assert down[0].min() <= down[1].min() <= 0 and robots[0].tip.shape == (3,)
        root.addObject(Compare())
        return root


createScene = Robot.make
