# SPDX-License-Identifier: LGPL-2.1-or-later
"""Values of every kind: bool, int, float, text, lists, nested lists, arrays, tuples, None."""
import numpy as np


def createScene(root):
    root.dt.value = 0.02
    root.gravity.value = (0, -9.81, 0)
    root.addObject("DefaultAnimationLoop")
    beam = root.addChild("beam")
    beam.addObject("EulerImplicitSolver", firstOrder=False, rayleighMass=0.1, rayleighStiffness="0.1")
    beam.addObject("CGLinearSolver", iterations=np.int64(200), tolerance=1e-9, threshold=np.float32(1e-9))
    beam.addObject("RegularGridTopology", name="grid", n=[5, 3, 3], min=(0.0, 0.0, 0.0), max=np.array([4.0, 1.0, 1.0]))
    beam.addObject("MechanicalObject", name="dofs", template="Vec3d", translation="0 0 0", showObject=True, src=None)
    beam.addObject("UniformMass", totalMass=1.0)
    beam.addObject("HexahedronFEMForceField", name="fem", youngModulus="5000", poissonRatio=0.3, method="large")
    beam.addObject("BoxROI", name="clamp", box=[[-0.1, -0.1, -0.1], [0.1, 1.1, 1.1]], drawBoxes=True)
    beam.addObject("FixedProjectiveConstraint", indices="@clamp.indices")
    beam.addObject("ConstantForceField", name="load", indices=np.array([4, 9]), forces=[[0, 0, 1], [0, 0, 1]])
