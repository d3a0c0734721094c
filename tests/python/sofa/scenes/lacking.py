# SPDX-License-Identifier: LGPL-2.1-or-later
"""Names a library, two components and an attribute that nothing here has: all are told at once."""
import nosuchlibrary


def createScene(root):
    root.addObject("DefaultAnimationLoop")
    root.addObject("CarvingNothing", name="first")
    body = root.addChild("body")
    body.addObject("FluidGridSolver9", name="second")
    body.addObject("MechanicalObject", name="dofs", position=nosuchlibrary.points)
