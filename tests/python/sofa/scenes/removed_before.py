# SPDX-License-Identifier: LGPL-2.1-or-later
"""What is taken out again before the run takes no part; a node that was made alone is put in."""
import Sofa


def createScene(root):
    root.addObject("DefaultAnimationLoop")
    root.gravity = [0, 0, -10]
    body = Sofa.Core.Node("body")
    body.addObject("EulerImplicitSolver")
    body.addObject("CGLinearSolver", iterations=10, tolerance=1e-14, threshold=1e-14)
    body.addObject("MechanicalObject", name="dofs", position=[0, 0, 0])
    body.addObject("UniformMass", name="mass", totalMass=1)
    clamp = body.addObject("FixedProjectiveConstraint", name="clamp", indices=[0])
    body.removeObject(clamp)
    gone = body.addChild("gone")
    gone.addObject("NoSuchComponent")
    body.removeChild("gone")
    root.addChild(body)
    assert root.body.hasObject("dofs") and not root.body.hasObject("clamp")
