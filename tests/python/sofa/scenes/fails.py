# SPDX-License-Identifier: LGPL-2.1-or-later
"""Fails on the way, after a component that Stroma does not have."""


def createScene(root):
    root.addObject("DefaultAnimationLoop")
    root.addObject("CarvingNothing", name="first")
    body = root.addChild("body")
    body.addObject("MechanicalObject", name="dofs", position=[0, 0, 0])
    count = len(root.first.position.value)
    body.addObject("UniformMass", totalMass=count)
