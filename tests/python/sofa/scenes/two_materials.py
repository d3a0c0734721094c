# SPDX-License-Identifier: LGPL-2.1-or-later
"""A modulus for each tetrahedron, from the places of a loader; a point that follows, and a table that is written on the way."""
import numpy as np
import Sofa


def createScene(root):
    root.addObject("DefaultAnimationLoop")
    n = root.addChild("n")
    n.addObject("EulerImplicitSolver")
    n.addObject("SparseLDLSolver")
    n.addObject("MeshVTKLoader", name="loader", filename="mesh/finger.vtk")
    n.addObject("TetrahedronSetTopologyContainer", src="@loader", name="topo")
    n.addObject("MechanicalObject", name="mo")
    n.addObject("UniformMass", totalMass=0.1)
    tets = n.topo.tetrahedra.value if len(n.topo.tetrahedra.value) else n.loader.tetrahedra.value
    centre = n.loader.position.value[tets].mean(axis=1)
    young = np.where(centre[:, 0] < 40, 1000., 5000.)
    n.addObject("TetrahedronFEMForceField", name="fem", youngModulus=young.tolist(), poissonRatio=0.3, method="svd")
    n.addObject("BoxROI", name="b", box="-1 -1 -1 1 100 100")
    n.addObject("FixedConstraint", indices="@b.indices")
    m = n.addChild("monitor")
    m.addObject("MechanicalObject", position=[[80, 10, 10]], name="tip")
    m.addObject("BarycentricMapping")

    class Log(Sofa.Core.Controller):
        def __init__(self, *a, **k):
            super().__init__(*a, **k)
            self.rows = []

        def onAnimateEndEvent(self, e):
            self.rows.append([root.getTime(), *m.tip.position.value[0]])
            np.savetxt("rows.csv", self.rows, delimiter=",")
    root.addObject(Log(name="log"))
