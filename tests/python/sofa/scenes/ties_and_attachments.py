# SPDX-License-Identifier: LGPL-2.1-or-later
"""Old names of constraints between bodies: bilateral interactions, attachments, springs between nodes; links that go up and down."""


def grid(parent, name, x, young):
    n = parent.addChild(name)
    n.addObject("RegularGrid", name="grid", nx="3", ny="2", nz="2", xmin=x, xmax=x + 2, ymin="0", ymax="1", zmin="0", zmax="1")
    n.addObject("MechanicalObject", name="mo", template="Vec3d", src="@grid")
    n.addObject("UniformMass", name="mass", mass=0.1)
    n.addObject("HexahedronFEMForceField", youngModulus=young, poissonRatio="0.3", method="large")
    return n


def createScene(root):
    root.gravity = [0, -1, 0]
    root.addObject("FreeMotionAnimationLoop")
    root.addObject("GenericConstraintSolver", maxIterations="1000", tolerance=1e-12)
    for k, name in enumerate(("left", "right")):
        part = root.addChild(name)
        part.addObject("EulerImplicitSolver", rayleighStiffness=0.05)
        part.addObject("SparseLDLSolver")
        part.addObject("GenericConstraintCorrection")
        body = grid(part, "body", 2 * k, 1e3 * (k + 1))
        if k == 0:
            body.addObject("FixedConstraint", indices=[0, 3, 6, 9])
    ties = root.addObject("BilateralInteractionConstraint", template="Vec3d", object1="@left/body/mo", object2="@/right/body/mo",
                          first_point=[2, 5, 8, 11], second_point="0 3 6 9")
    tip = root.right.addChild("tip")
    tip.addObject("MechanicalObject", position="4.5 0 0")
    tip.addObject("UniformMass", totalMass=.1)
    root.right.addObject("StiffSpringForceField", template="Vec3d", object1="@body/mo", object2="@tip", spring="2 0 50 1 0.5")
    assert ties.getName() == "BilateralInteractionConstraint" and root.left.body.mo.getLinkPath() == "@/left/body/mo"
