# SPDX-License-Identifier: LGPL-2.1-or-later
"""A hyperelastic body in a coarse grid around its surface, with pressure and material data that are computed before."""
import numpy as np
import Sofa

E, nu = 5000., 0.45
mu, K0 = E / (2 * (1 + nu)), E / (3 * (1 - 2 * nu))


def createScene(root):
    root.gravity = [0, -9.81, 0]
    root.dt = 0.01
    root.addObject("DefaultAnimationLoop")
    body = root.addChild("body")
    body.addObject("EulerImplicitSolver", rayleighMass=0.1, rayleighStiffness=0.1)
    body.addObject("SparseLDLSolver", template="CompressedRowSparseMatrixd")
    body.addObject("MeshVTKLoader", name="loader", filename="mesh/finger.vtk", translation=[0, 0, 0], scale3d=[0.001] * 3)
    body.addObject("TetrahedronSetTopologyContainer", name="Container", position=body.loader.position.getLinkPath(),
                   tetrahedra=body.loader.tetrahedra.getLinkPath())
    body.addObject("MechanicalObject", name="mstate")
    body.addObject("UniformMass", totalMass=np.float64(0.05))
    body.addObject("TetrahedronHyperelasticityFEMForceField", materialName="NeoHookean", ParameterSet=[mu, K0])
    body.addObject("BoxROI", name="fixed", box=[[-0.001, -1, -1, 0.001, 1, 1]], doUpdate=False)
    body.addObject("FixedConstraint", indices="@fixed.indices")
    surface = body.addChild("surface")
    surface.addObject("TriangleSetTopologyContainer", name="Container")
    surface.addObject("TriangleSetTopologyModifier", name="Modifier")
    surface.addObject("Tetra2TriangleTopologicalMapping", input="@../Container", output="@Container")
    surface.addObject("TrianglePressureForceField", name="pressure", pressure=[0, -5, 0], triangleList=list(range(4)))
