# SPDX-License-Identifier: LGPL-2.1-or-later
"""A bar of tetrahedra under its weight; stresses of cells and of nodes are read."""


def createScene(root):
    root.gravity = [0, -10, 0]
    root.dt = 0.1
    root.addObject("DefaultAnimationLoop")
    body = root.addChild("body")
    body.addObject("EulerImplicitSolver")
    body.addObject("CGLinearSolver", iterations=200, tolerance=1e-14, threshold=1e-14)
    body.addObject("TetrahedronSetTopologyContainer", name="grid",
                   position=[[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1], [2, 0, 0]],
                   tetrahedra=[[0, 1, 2, 3], [1, 2, 3, 4], [1, 2, 4, 5]])
    body.addObject("MechanicalObject", name="dofs")
    body.addObject("UniformMass", totalMass=8)
    body.addObject("TetrahedronFEMForceField", name="fem", youngModulus=1000, poissonRatio=0.3, method="large", computeVonMisesStress=1)
    body.addObject("FixedProjectiveConstraint", indices=[0, 2, 3])
