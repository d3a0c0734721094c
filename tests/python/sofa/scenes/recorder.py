# SPDX-License-Identifier: LGPL-2.1-or-later
"""Positions, energies and fields are read in each step, and written as files by NumPy at the end."""
import os
import tempfile

import numpy as np
import Sofa


class Recorder(Sofa.Core.Controller):
    def __init__(self, *args, **kwargs):
        super().__init__(*args, **kwargs)
        self.dofs, self.fem, self.rows = kwargs["dofs"], kwargs["fem"], []
        self.folder = tempfile.mkdtemp()

    def onAnimateEndEvent(self, event):
        positions = self.dofs.position.array()
        displacement = positions - self.dofs.rest_position.array()
        speeds = np.linalg.norm(self.dofs.velocity.value, axis=1)
        stress = self.fem.vonMisesPerElement.value
        forces = self.dofs.force.value
        self.rows.append([self.getContext().time.value, np.abs(displacement).max(), speeds.max(), float(np.max(stress)), forces.sum()])
        np.savetxt(os.path.join(self.folder, "out.csv"), np.array(self.rows), delimiter=",", header="t,u,v,s,f")
        np.save(os.path.join(self.folder, "x.npy"), positions)


def createScene(root):
    root.gravity = [0, -9.81, 0]
    root.dt = 0.005
    root.addObject("DefaultAnimationLoop")
    body = root.addChild("body")
    body.addObject("EulerImplicitSolver", rayleighStiffness=0.01)
    body.addObject("SparseLDLSolver", template="CompressedRowSparseMatrixd")
    body.addObject("MeshVTKLoader", name="loader", filename="mesh/finger.vtk", scale=0.001)
    body.addObject("TetrahedronSetTopologyContainer", src="@loader", name="topology")
    dofs = body.addObject("MechanicalObject", name="dofs", src="@loader")
    body.addObject("MeshMatrixMass", massDensity=1000, lumping=False)
    fem = body.addObject("TetrahedronFEMForceField", youngModulus=20e3, poissonRatio=0.4, method="large", computeVonMisesStress=1)
    body.addObject("BoxROI", name="roi", box=[-1e-4, -1, -1, 1e-4, 1, 1])
    body.addObject("FixedProjectiveConstraint", indices="@roi.indices")
    body.addObject(Recorder(name="Recorder", dofs=dofs, fem=fem))
    assert len(body.roi.indices) == 9 and len(body.topology.tetrahedra.value) == 192
