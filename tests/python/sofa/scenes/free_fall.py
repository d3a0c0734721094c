# SPDX-License-Identifier: LGPL-2.1-or-later
"""Types by name, children, gravity and dt of the root: two bodies fall."""


def createScene(root):
    root.gravity = [0, 0, -10]
    root.dt = 0.05
    root.addObject("RequiredPlugin", pluginName=["Sofa.Component.StateContainer", "Sofa.Component.Mass"])
    root.addObject("DefaultAnimationLoop")
    for name, height in (("low", 1.0), ("high", 2.5)):
        body = root.addChild(name)
        body.addObject("EulerImplicitSolver", name="ode")
        body.addObject("CGLinearSolver", iterations=10, tolerance=1e-12, threshold=1e-12)
        body.addObject("MechanicalObject", name="dofs", template="Vec3d", position=[[0, 0, height]])
        body.addObject("UniformMass", totalMass=2)
    return root
