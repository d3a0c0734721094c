# SPDX-License-Identifier: LGPL-2.1-or-later
"""An environment that makes, runs and resets a tree of its own while the scene is created."""
import numpy as np
import Sofa
import Sofa.Simulation
import SofaRuntime


class Env:
    def __init__(self):
        SofaRuntime.importPlugin("Sofa.Component")
        self.root = Sofa.Core.Node("myroot")
        build(self.root)
        Sofa.Simulation.initRoot(self.root) if hasattr(Sofa.Simulation, "initRoot") else Sofa.Simulation.init(self.root)

    def reset(self):
        Sofa.Simulation.reset(self.root)
        return self.obs()

    def obs(self):
        return np.array(self.root.n.mo.position.value).ravel().copy()

    def step(self, a):
        self.root.n.cff.totalForce.value = [a, 0, 0]
        for _ in range(5):
            Sofa.Simulation.animate(self.root, 0.01)
        return self.obs(), -abs(self.obs()[0] - 1), False, {}


def build(root):
    root.gravity.value = [0, 0, 0]
    root.addObject("DefaultAnimationLoop")
    n = root.addChild("n")
    n.addObject("EulerImplicitSolver")
    n.addObject("CGLinearSolver", iterations=10, tolerance=1e-12, threshold=1e-12)
    n.addObject("MechanicalObject", name="mo", position=[0., 0., 0.])
    n.addObject("UniformMass", totalMass=1)
    n.addObject("ConstantForceField", name="cff", totalForce=[0., 0., 0.], indices=[0])


def createScene(root):
    env = Env()
    env.reset()
    for _ in range(3):
        seen, *_ = env.step(1.0)
    assert abs(seen[0] - 1e-4 * 15 * 16 / 2) < 1e-12, seen
    assert (env.reset() == 0).all()
    build(root)
