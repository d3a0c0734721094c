# SPDX-License-Identifier: LGPL-2.1-or-later
"""A static solver with a load that a controller raises; convergence is read; nearest nodes by NumPy; totalForce as text."""
import numpy as np
import Sofa


class Raise(Sofa.Core.Controller):
    def __init__(self, node, last, **kw):
        super().__init__(**kw)
        self.node, self.last, self.rows = node, last, []

    def onAnimateBeginEvent(self, event):
        k = len(self.rows) + 1
        self.node.load.totalForce.value = "0 %f 0" % (-0.05 * k)

    def onAnimateEndEvent(self, event):
        self.rows.append(self.node.mo.position.value[self.last, 1].mean())
        if len(self.rows) > 1:
            assert self.rows[-1] < self.rows[-2]


def createScene(root):
    root.gravity.value = "0 0 0"
    root.addObject("DefaultAnimationLoop")
    n = root.addChild("n")
    n.addObject("StaticSolver", name="static", newtonSolver="@newton")
    n.addObject("NewtonRaphsonSolver", name="newton", maxNbIterationsNewton=25, absoluteResidualStoppingThreshold=1e-9)
    n.addObject("SparseLDLSolver", template="CompressedRowSparseMatrixMat3x3d")
    grid = n.addObject("RegularGridTopology", name="grid", n=[7, 3, 3], min=[0, 0, 0], max=[6, 1, 1])
    n.addObject("MechanicalObject", name="mo", src="@grid")
    n.addObject("HexahedronFEMForceField", youngModulus=500, poissonRatio=0.3, method="large")
    x = grid.position.value
    distance = np.linalg.norm(x - [6, 0.5, 0.5], axis=1)
    last = np.argsort(distance)[:5]
    n.addObject("FixedConstraint", indices=np.nonzero(x[:, 0] == 0)[0])
    n.addObject("ConstantForceField", name="load", indices=last, totalForce="0 0 0")
    root.addObject(Raise(n, last, name="raise"))
