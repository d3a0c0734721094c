# SPDX-License-Identifier: LGPL-2.1-or-later
"""A surface in a sparse grid of hexahedra, mapped points, a probe that reads a moved surface."""
import numpy as np
import Sofa


def createScene(root):
    root.gravity = [0, 0, -981]
    root.addObject("DefaultAnimationLoop")
    n = root.addChild("n")
    n.addObject("EulerImplicitSolver", rayleighStiffness=0.1)
    n.addObject("CGLinearSolver", iterations=100, tolerance=1e-8, threshold=1e-8)
    n.addObject("MeshSTLLoader", name="loader", filename="mesh/finger.stl")
    grid = n.addObject("SparseGridTopology", name="grid", n="8 3 3", position="@loader.position", triangles="@loader.triangles")
    n.addObject("MechanicalObject", name="mo", src="@grid")
    n.addObject("UniformMass", totalMass=0.1)
    n.addObject("HexahedronFEMForceField", youngModulus=1e4, poissonRatio=0.4, method="large")
    n.addObject("BoxROI", name="box", box=[-1, -1, -1, 1, 30, 30])
    n.addObject("FixedConstraint", indices="@box.indices")
    s = n.addChild("skin")
    s.addObject("MeshTopology", src="@../loader", name="topo")
    s.addObject("MechanicalObject", name="mo", src="@topo")
    s.addObject("BarycentricMapping")
    assert len(grid.hexahedra.value) > 0 and s.mo.position.value.shape[1] == 3

    class Probe(Sofa.Core.Controller):
        def onAnimateEndEvent(self, event):
            now = s.mo.position.value
            assert np.isfinite(now).all() and (now[:, 2] - s.topo.position.value[:, 2]).min() < 0
    root.addObject(Probe(name="probe"))
