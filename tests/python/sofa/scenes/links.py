# SPDX-License-Identifier: LGPL-2.1-or-later
"""Links as text, as objects and as data; of a node; by getLinkPath()."""


def createScene(root):
    root.addObject("DefaultAnimationLoop")
    root.gravity = "0 0 0"
    meshes = root.addChild("meshes")
    grid = meshes.addObject("RegularGridTopology", name="grid", n="4 2 2", min="0 0 0", max="3 1 1")
    body = root.addChild("body")
    body.addObject("EulerImplicitSolver")
    body.addObject("CGLinearSolver", name="solver", iterations=100, tolerance=1e-10, threshold=1e-10)
    body.addObject("HexahedronSetTopologyContainer", name="container", position=grid.position, hexahedra="@/meshes/grid.hexahedra")
    state = body.addObject("MechanicalObject", name="dofs", position="@../meshes/grid.position")
    body.addObject("UniformMass", totalMass=1)
    body.addObject("HexahedronFEMForceField", youngModulus=1000, poissonRatio=0.2)
    roi = body.addObject("BoxROI", name="roi", box="-0.1 -0.1 -0.1 0.1 1.1 1.1", position=state.position.getLinkPath())
    body.addObject("FixedProjectiveConstraint", name="clamp", indices=roi.indices.getLinkPath())
    other = body.addChild("other")
    other.addObject("MechanicalObject", name="points", position=[[1.5, 0.5, 0.5]])
    other.addObject("BarycentricMapping", input=body.dofs, output=other.points.getLinkPath())
