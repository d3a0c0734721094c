# SPDX-License-Identifier: LGPL-2.1-or-later
"""Two frames without a solver, which a controller places, hold a sheet by bilateral constraints between mapped points."""
import numpy as np
import Sofa


class Motion(Sofa.Core.Controller):
    def __init__(self, *args, **kwargs):
        Sofa.Core.Controller.__init__(self, *args, **kwargs)
        self.first, self.second = kwargs.get("first"), kwargs.get("second")
        self.root = kwargs.get("root")
        self.time = 0.0

    def onAnimateBeginEvent(self, event):
        self.time += self.root.dt.value
        angle = 0.5 * self.time
        with self.first.position.writeableArray() as wa:
            wa[0] = [0, 1 - 0.2 * self.time, 0, np.sin(angle / 2), 0, 0, np.cos(angle / 2)]
        with self.second.position.writeableArray() as wa:
            wa[0] = [0, 0.2 * self.time, 0, -np.sin(angle / 2), 0, 0, np.cos(angle / 2)]
        return 0


def createScene(node):
    node.addObject("VisualStyle", displayFlags="hideBehaviorModels showForceFields")
    node.addObject("FreeMotionAnimationLoop")
    node.addObject("GenericConstraintSolver", maxIterations="1000", tolerance="0.001")
    node.gravity = [0, 0, -9.81]
    system = node.addChild("system")
    sheet = system.addChild("deformable")
    sheet.addObject("EulerImplicitSolver", name="odeSolver", rayleighStiffness="0.1", rayleighMass="0.1", vdamping="1.0")
    sheet.addObject("SparseLDLSolver", template="CompressedRowSparseMatrixd")
    sheet.addObject("RegularGridTopology", name="topology", n=[6, 6, 2], min=[-0.5, 0.0, -0.05], max=[0.5, 1.0, 0.05])
    sheet.addObject("MeshTopology", name="foamMesh", src="@topology")
    sheet.addObject("MechanicalObject", template="Vec3d", name="deformableMO")
    sheet.addObject("LinearSolverConstraintCorrection", template="Vec3d")
    sheet.addObject("MeshMatrixMass", massDensity="50")
    sheet.addObject("HexahedronFEMForceField", name="HexaFF", src="@foamMesh", poissonRatio=0.3, youngModulus=10000, method="polar")
    for name, positions in (("defConstraint", "-0.1 0.9 0 0.1 0.9 0 -0.1 1 0 0.1 1 0"),
                            ("defConstraint2", "-0.1 0.1 0 0.1 0.1 0 -0.1 0 0 0.1 0 0")):
        held = sheet.addChild(name)
        held.addObject("MechanicalObject", name="constraintMO", template="Vec3d", position=positions)
        held.addObject("BarycentricMapping", input="@..", output="@constraintMO")
    for name, height, sign in (("gripper", 1.0, -1), ("gripper2", 0.0, 1)):
        gripper = system.addChild(name)
        gripper.addObject("MechanicalObject", template="Rigid3d", name="gripperMO", position=f"0 {height} 0 0 0 0 1", showObject="1")
        points = gripper.addChild("gripConstraint")
        points.addObject("MechanicalObject", name="constraintMO", template="Vec3d",
                         position=[[-0.1, 0.1 * sign, 0], [0.1, 0.1 * sign, 0], [-0.1, 0, 0], [0.1, 0, 0]])
        points.addObject("RigidMapping")
    for one, other in (("gripper", "defConstraint"), ("gripper2", "defConstraint2")):
        system.addObject("BilateralInteractionConstraint", template="Vec3d", object1=f"@{one}/gripConstraint/constraintMO",
                         object2=f"@deformable/{other}/constraintMO", first_point="0 1 2 3", second_point="0 1 2 3")
    system.gripper.addObject(Motion(name="Motion", first=system.gripper.gripperMO, second=system.gripper2.gripperMO, root=node))
    return 0
