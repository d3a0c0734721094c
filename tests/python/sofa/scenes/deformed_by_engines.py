# SPDX-License-Identifier: LGPL-2.1-or-later
"""Engines in a chain, of which arrays are read before init and in the run: regions, subsets, values at points, merges."""
import numpy as np
import Sofa


def createScene(root):
    root.addObject("DefaultAnimationLoop")
    root.gravity = [0, 0, -1]
    n = root.addChild("n")
    n.addObject("EulerImplicitSolver")
    n.addObject("SparseLDLSolver", template="CompressedRowSparseMatrixMat3x3d")
    loader = n.addObject("MeshVTKLoader", name="loader", filename="mesh/finger.vtk", rotation="0 0 90", scale3d="0.1 0.1 0.1")
    topo = n.addObject("TetrahedronSetTopologyContainer", name="topo", src="@loader")
    n.addObject("MechanicalObject", name="mo", src="@loader")
    low = n.addObject("BoxROI", name="low", template="Vec3d", box=[-3, -0.1, -1, 1, 0.1, 3], position="@mo.rest_position",
                      tetrahedra="@topo.tetrahedra")
    ball = n.addObject("SphereROI", name="ball", centers=[[-1, 8, 1]], radii=[1.5], position="@mo.rest_position",
                      tetrahedra="@topo.tetrahedra")
    plane = n.addObject("PlaneROI", name="plane", plane=[-1, 4, 1, -1, 5, 1, 0, 4, 1, 0.5], position="@mo.rest_position")
    n.addObject("MergeSets", name="both", in1="@low.indices", in2="@ball.indices", op="union")
    n.addObject("IndexValueMapper", name="m1", indices="@ball.indices", value=5000, defaultValue=1000)
    assert len(low.indices.value) == 9, low.indices.value
    assert set(ball.indices.value) <= set(range(81)) and n.both.out.value.size >= len(low.indices.value)
    assert len(plane.indices.value) >= 0 and topo.tetrahedra.value.max() == 80
    n.addObject("UniformMass", totalMass=1)
    young = np.full(len(loader.tetrahedra.value), 1000.0)
    young[ball.tetrahedronIndices.value if ball.findData("tetrahedronIndices") is not None else []] = 5000
    n.addObject("TetrahedronFEMForceField", youngModulus=young.tolist(), poissonRatio=0.3)
    n.addObject("FixedProjectiveConstraint", indices="@low.indices")
    n.addObject("AverageCoord", name="mean", indices="@ball.indices", position="@mo.position")

    class Watch(Sofa.Core.Controller):
        def onAnimateEndEvent(self, event):
            assert n.ball.pointsInROI.value.shape[1] == 3 and len(n.low.indices) == 9
    root.addObject(Watch())
