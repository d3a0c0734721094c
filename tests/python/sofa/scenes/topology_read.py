# SPDX-License-Identifier: LGPL-2.1-or-later
"""Topological data in callbacks: tetrahedra, edges, triangles, volumes and neighbours computed by NumPy in each step."""
import itertools

import numpy as np
import Sofa


class Volume(Sofa.Core.Controller):
    def __init__(self, node, *args, **kwargs):
        super().__init__(*args, **kwargs)
        self.node, self.container = node, node.topology
        self.volumes = []

    def onSimulationInitDoneEvent(self, event):
        self.edges = {tuple(sorted(pair)) for tet in self.container.tetrahedra.value for pair in itertools.combinations(tet, 2)}
        assert len(self.edges) == len(self.container.edges.value) or len(self.container.edges.value) == 0
        self.neighbours = [set() for _ in range(self.container.nbPoints.value if self.container.findData("nbPoints") else 81)]

    def onAnimateEndEvent(self, event):
        p = self.node.dofs.position.value
        t = self.container.findData("tetrahedra").value
        a, b, c, d = (p[t[:, i]] for i in range(4))
        self.volumes.append(np.abs(np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a)).sum() / 6)
        tri = self.node.surface.container.triangles.value
        normals = np.cross(p[tri[:, 1]] - p[tri[:, 0]], p[tri[:, 2]] - p[tri[:, 0]])
        assert np.abs(normals.sum(axis=0)).max() < 1e-6 * np.abs(normals).sum()
        for i, quad in enumerate(self.container.tetrahedra.value.tolist()[:5]):
            for j in quad:
                self.neighbours[j].add(i)
        print(f"{self.volumes[-1]:.3f}", self.container.getNbTetrahedra(), len(t))


def createScene(root):
    root.gravity = "0 -981 0"
    root.addObject("DefaultAnimationLoop")
    body = root.addChild("body")
    body.addObject("EulerImplicitSolver")
    body.addObject("CGLinearSolver", iterations=60, tolerance=1e-9, threshold=1e-9)
    body.addObject("MeshVTKLoader", name="loader", filename="mesh/finger.vtk")
    body.addObject("TetrahedronSetTopologyContainer", name="topology", src="@loader")
    body.addObject("TetrahedronSetTopologyModifier")
    body.addObject("TetrahedronSetGeometryAlgorithms", template="Vec3", drawTetrahedra=True)
    body.addObject("MechanicalObject", name="dofs")
    body.addObject("MeshMatrixMass", massDensity=1e-6, topology="@topology")
    body.addObject("TetrahedronFEMForceField", youngModulus=600, poissonRatio=0.45)
    body.addObject("BoxROI", name="roi", box="-1 -1 -1 1 21 21")
    body.addObject("FixedProjectiveConstraint", indices="@roi.indices")
    surface = body.addChild("surface")
    surface.addObject("TriangleSetTopologyContainer", name="container")
    surface.addObject("TriangleSetTopologyModifier")
    surface.addObject("Tetra2TriangleTopologicalMapping", input="@../topology", output="@container")
    surface.addObject("TrianglePressureForceField", pressure=[0, 0.01, 0], triangleList=[0, 1])
    root.addObject(Volume(body, name="Volume"))
    x = body.loader.position.value
    lowest = x[x[:, 1] == x[:, 1].min()]
    assert len(lowest) and len(body.loader.tetrahedra.value) == 192
