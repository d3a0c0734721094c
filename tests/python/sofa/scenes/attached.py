# SPDX-License-Identifier: LGPL-2.1-or-later
"""Two bodies that are tied: AttachConstraint, a bilateral constraint, springs between objects of two nodes."""
import Sofa


def body(root, name, at):
    node = root.addChild(name)
    node.addObject("RegularGridTopology", name="grid", n=[2, 2, 3], min=[at, 0, 0], max=[at + 1, 1, 2])
    node.addObject("MechanicalObject", name="dofs")
    node.addObject("UniformMass", totalMass=1)
    node.addObject("HexahedronFEMForceField", youngModulus=2000, poissonRatio=0.3, method="large")
    return node


def createScene(root):
    root.gravity = [0, 0, -10]
    root.addObject("DefaultAnimationLoop")
    root.addObject("EulerImplicitSolver")
    root.addObject("CGLinearSolver", iterations=200, tolerance=1e-10, threshold=1e-10)
    one, two = body(root, "one", 0), body(root, "two", 1)
    one.addObject("FixedConstraint", indices=[0, 4, 8])
    root.addObject("AttachConstraint", object1="@one/dofs", object2="@two/dofs", indices1="1 3", indices2="0 2", twoWay=True)
    root.addObject("SpringForceField", object1=one.dofs.getLinkPath(), object2=two.dofs.getLinkPath(),
                   spring=[[9, 8, 1000, 1, 0], [11, 10, 1000, 1, 0]])
