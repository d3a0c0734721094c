# SPDX-License-Identifier: LGPL-2.1-or-later
"""Constraints by the names before 2024: sliding, stopper, uniform, attach; a rigid body that slides on a rail."""


def createScene(root):
    root.gravity = [0, -1, 0]
    root.addObject("FreeMotionAnimationLoop")
    root.addObject("GenericConstraintSolver", tolerance=1e-12, maxIterations=1000)
    rail = root.addChild("rail")
    rail.addObject("EulerImplicitSolver")
    rail.addObject("SparseLDLSolver")
    rail.addObject("MechanicalObject", name="mo", template="Vec3d", position=[[-5, 0, 0], [5, 0, 0]])
    rail.addObject("UniformMass", totalMass=1)
    rail.addObject("LinearSolverConstraintCorrection")
    rail.addObject("FixedConstraint", indices=[0, 1])
    bead = root.addChild("bead")
    bead.addObject("EulerImplicitSolver")
    bead.addObject("SparseLDLSolver")
    bead.addObject("MechanicalObject", name="mo", position=[[0.5, 0, 0]], velocity=[[1, 0, 0]])
    bead.addObject("UniformMass", totalMass=1)
    bead.addObject("LinearSolverConstraintCorrection")
    root.addObject("SlidingConstraint", object1="@bead/mo", object2="@rail/mo", sliding_point=0, axis_1=0, axis_2=1)
    stop = root.addChild("stop")
    stop.addObject("EulerImplicitSolver")
    stop.addObject("SparseLDLSolver")
    stop.addObject("MechanicalObject", name="mo", template="Vec1d", position=[0.0])
    stop.addObject("UniformMass", totalMass=1)
    stop.addObject("StopperConstraint", index=0, min=-0.01, max=0.01)
    stop.addObject("ConstantForceField", forces=[[5.0]], indices=[0])
    stop.addObject("UncoupledConstraintCorrection")
