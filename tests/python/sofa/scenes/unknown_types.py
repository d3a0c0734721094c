# SPDX-License-Identifier: LGPL-2.1-or-later
"""Two components that Stroma does not have, and a link that leads nowhere."""


def createScene(root):
    root.addObject("DefaultAnimationLoop")
    root.addObject("CarvingNothing", name="first")
    body = root.addChild("body")
    body.addObject("EulerImplicitSolver")
    body.addObject("CGLinearSolver")
    body.addObject("FluidGridSolver9", name="second", position="@nowhere.position")
    body.addObject("MechanicalObject", name="dofs", position=[0, 0, 0])
    body.addObject("UniformMass", totalMass=1)
