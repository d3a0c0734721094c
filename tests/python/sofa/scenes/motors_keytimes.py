# SPDX-License-Identifier: LGPL-2.1-or-later
"""Prescribed motions with lists of times, constraints on rigid frames by directions, forces that grow."""
import numpy as np
import Sofa


def createScene(rootNode):
    rootNode.dt = 0.05
    rootNode.gravity = [0, 0, 0]
    rootNode.addObject("DefaultAnimationLoop")
    times = np.linspace(0, 1, 5)
    n = rootNode.addChild("points")
    n.addObject("EulerImplicitSolver")
    n.addObject("CGLinearSolver", iterations=50, tolerance=1e-10, threshold=1e-10)
    n.addObject("MechanicalObject", name="mo", position=[[0, 0, 0], [1, 0, 0], [2, 0, 0]])
    n.addObject("UniformMass", totalMass=3)
    n.addObject("LinearMovementConstraint", template="Vec3d", indices=0, keyTimes=times, movements=[[0, t, 0] for t in times])
    n.addObject("LinearForceField", points=[1], times=[0, 1], forces=[[0, 0, 0], [0, 0, 3]])
    n.addObject("StiffSpringForceField", spring=[[1, 2, 100., 1., 1.]])
    f = rootNode.addChild("frames")
    f.addObject("EulerImplicitSolver")
    f.addObject("SparseLDLSolver", template="CompressedRowSparseMatrixMat3x3d")
    f.addObject("MechanicalObject", name="mo", template="Rigid3", position=[[0, 0, 0, 0, 0, 0, 1], [2, 0, 0, 0, 0, 0, 1]])
    f.addObject("UniformMass", totalMass=2)
    f.addObject("PartialFixedProjectiveConstraint", indices=[0], fixedDirections=[1, 1, 1, 0, 1, 1])
    f.addObject("ConstantForceField", name="torque", indices=[0, 1], forces=[[0, 0, 0, 1, 0, 0], [0, 1, 0, 0, 0, 0]])
    f.addObject("ConstantForceField", name="one", indices=[1], force=[0, 0, 1, 0, 0, 0])
    assert f.torque.forces.value.shape == (2, 6), f.torque.forces.value.shape
    f.torque.forces[0][3] = 2.0
    assert f.torque.forces.value[0][3] == 2

    class Check(Sofa.Core.Controller):
        def onAnimateEndEvent(self, event):
            t = rootNode.time.value
            assert abs(n.mo.position.value[0][1] - (t - rootNode.dt.value)) < 1e-9, "movements are those of the start of a step"
            assert abs(f.mo.position.value[0][0]) < 1e-12 and f.mo.velocity.value[0][3] > 0
            assert f.torque.forces.value.shape == (2, 6)
            f.torque.forces.value = [[0, 0, 0, 2 + t, 0, 0], [0, 1, 0, 0, 0, 0]]
    rootNode.addObject(Check())
