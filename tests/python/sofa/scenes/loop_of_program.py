# SPDX-License-Identifier: LGPL-2.1-or-later
"""A program without createScene() in its middle: two roots after each other, a tree that is printed, and steps of other lengths."""
import Sofa
import Sofa.Core
import Sofa.Simulation


def build(mass):
    root = Sofa.Core.Node("root", gravity=[0, 0, -10], dt=0.1)
    root.addObject("DefaultAnimationLoop")
    body = root.addChild(Sofa.Core.Node("body"))
    body.addObject("EulerImplicitSolver")
    body.addObject("CGLinearSolver", iterations=10, tolerance=1e-12, threshold=1e-12)
    body.addObject("MechanicalObject", name="dofs", position=[0, 0, 0])
    body.addObject("UniformMass", totalMass=mass)
    return root


def createScene(root):
    for mass in (1, 2):
        other = build(mass)
        Sofa.Simulation.init(other)
        Sofa.Simulation.animateNSteps(other, 3)
        assert abs(other.body.dofs.position.value[0][2] + 0.6) < 1e-9
        Sofa.Simulation.reset(other)
        Sofa.Simulation.print(other)
        Sofa.Simulation.unload(other)
    root.addChild(build(1).body)
    root.addObject("DefaultAnimationLoop")
