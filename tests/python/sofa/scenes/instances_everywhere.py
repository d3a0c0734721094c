# SPDX-License-Identifier: LGPL-2.1-or-later
"""Objects and data as arguments: states, topologies, indices, loaders, node paths with and without @, lists of links, self links."""
import Sofa


def createScene(root):
    root.addObject("DefaultAnimationLoop")
    n = root.addChild("n")
    solver = n.addObject("EulerImplicitSolver")
    linear = n.addObject("CGLinearSolver", name="cg", iterations=40, tolerance=1e-9, threshold=1e-9)
    loader = n.addObject("MeshVTKLoader", filename="mesh/finger.vtk")
    topology = n.addObject("TetrahedronSetTopologyContainer", position=loader.position, tetrahedra=loader.tetrahedra)
    state = n.addObject("MechanicalObject", position=topology.position)
    n.addObject("MeshMatrixMass", totalMass=0.1, topology=topology, lumping=True)
    n.addObject("TetrahedronFEMForceField", topology=topology, mstate=state, youngModulus=500, poissonRatio=0.4)
    box = n.addObject("BoxROI", box=[-1, -1, -1, 1, 21, 21], position=state.rest_position)
    n.addObject("RestShapeSpringsForceField", points=box.indices, external_rest_shape=state, stiffness=1e6, mstate=state.linkpath)
    m = n.addChild("m")
    other = m.addObject("MechanicalObject", position=[[40., 10., 10.]])
    m.addObject("BarycentricMapping", input=state, output=other, topology=topology.getLinkPath())
    k = m.addChild("k")
    last = k.addObject("MechanicalObject", name="last")
    k.addObject("IdentityMapping", input=other.getLinkPath(), output=last.getLinkPath())
    k.addObject("ConstantForceField", indices=[0], totalForce=(0, -1, 0))
    assert solver.getContext() is n and linear.getName() == "cg" and other.getContext().getPathName() == "/n/m"
    assert n.addChild(Sofa.Core.Node("later")).getRoot() is root and last.position.getLinkPath() == "@/n/m/k/last.position"
