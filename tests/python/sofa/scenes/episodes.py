# SPDX-License-Identifier: LGPL-2.1-or-later
"""An environment for learning: a class with reset() and step(), which its scene does not know."""
import numpy as np
import Sofa
import Sofa.Core
import Sofa.Simulation
import SofaRuntime


class Env:
    def __init__(self, config=None):
        self.config = {"dt": 0.01, **(config or {})}
        self.root = None

    def reset(self):
        if self.root is None:
            SofaRuntime.importPlugin("Sofa.Component")
            self.root = Sofa.Core.Node("rootNode")
            createScene(self.root, self.config)
            Sofa.Simulation.init(self.root)
        else:
            Sofa.Simulation.reset(self.root)
        return self._observation()

    def step(self, action):
        self.root.cart.load.totalForce = [float(action), 0, 0]
        for _ in range(2):
            Sofa.Simulation.animate(self.root, self.config["dt"])
        observation = self._observation()
        return observation, -abs(observation[0]), bool(abs(observation[0]) > 1), {}

    def _observation(self):
        return np.concatenate([self.root.cart.dofs.position.value[0, :1], self.root.cart.dofs.velocity.value[0, :1]])

    def close(self):
        Sofa.Simulation.unload(self.root)


def createScene(root, config={"dt": 0.01}):
    root.dt.value = config["dt"]
    root.gravity.value = [0, 0, 0]
    root.addObject("DefaultAnimationLoop")
    cart = root.addChild("cart")
    cart.addObject("EulerImplicitSolver", rayleighMass=0., rayleighStiffness=0.)
    cart.addObject("CGLinearSolver", iterations=10, tolerance=1e-12, threshold=1e-12)
    cart.addObject("MechanicalObject", name="dofs", template="Vec3d", position=[[0.1, 0., 0.]])
    cart.addObject("UniformMass", totalMass=1)
    cart.addObject("ConstantForceField", name="load", indices=[0], totalForce=[0, 0, 0])
    return root
