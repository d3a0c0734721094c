# SPDX-License-Identifier: LGPL-2.1-or-later
"""Training: episodes with resets, observations and random actions of a class like an environment, started from createScene()."""
import numpy as np
import Sofa


class Space:
    def __init__(self, low, high, shape, dtype):
        self.low, self.high, self.shape, self.dtype = low, high, shape, dtype

    def sample(self):
        return np.random.default_rng(1).uniform(self.low, self.high, self.shape).astype(self.dtype)


class BeamEnv:
    metadata = {"render.modes": ["human", "rgb_array"]}
    action_space = Space(-1, 1, (2,), np.float32)

    def __init__(self):
        self.root = Sofa.Core.Node("root")
        self.root.dt.value = 0.02
        self.root.gravity.value = [0, 0, 0]
        self.root.addObject("DefaultAnimationLoop")
        self.root.addObject("BackgroundSetting", color=[0.8, 0.8, 0.8])
        n = self.root.addChild("beam")
        n.addObject("EulerImplicitSolver", rayleighStiffness=0.01, rayleighMass=0.01)
        n.addObject("SparseLDLSolver", template="CompressedRowSparseMatrixMat3x3d")
        n.addObject("RegularGridTopology", nx=6, ny=3, nz=3, xmin=0, xmax=5, ymin=0, ymax=1, zmin=0, zmax=1)
        self.mo = n.addObject("MechanicalObject", name="mo")
        n.addObject("UniformMass", totalMass=1)
        n.addObject("HexahedronFEMForceField", youngModulus=2000, poissonRatio=0.3, method="large")
        n.addObject("BoxROI", name="box", box=[-0.1, -1, -1, 0.1, 2, 2])
        n.addObject("FixedConstraint", indices="@box.indices")
        self.tip = [i for i, p in enumerate(n.box.position.value) if p[0] > 4.9] if len(n.box.position.value) else [5]
        self.load = n.addObject("ConstantForceField", indices=self.tip, totalForce=[0, 0, 0])
        Sofa.Simulation.init(self.root)

    def reset(self, seed=None, options=None):
        Sofa.Simulation.reset(self.root)
        self.load.totalForce.value = [0, 0, 0]
        self.steps = 0
        return self.observe(), {}

    def observe(self):
        return np.asarray(self.mo.position.value[self.tip].mean(axis=0), dtype=np.float32)

    def step(self, action):
        self.load.totalForce.value = [0, *np.asarray(action, dtype=np.float64)]
        for _ in range(5):
            Sofa.Simulation.animate(self.root, self.root.dt.value)
        self.steps += 1
        obs = self.observe()
        return obs, -float(np.linalg.norm(obs - self.goal)), False, self.steps >= 3, {}

    goal = np.array([4.5, 1, 1])

    def render(self, mode="human"):
        return None

    def close(self):
        Sofa.Simulation.unload(self.root)


def train(env, episodes=4):
    returns, first = [], None
    for _ in range(episodes):
        obs, info = env.reset()
        truncated, total = False, 0.0
        while not truncated:
            obs, reward, terminated, truncated, info = env.step(env.action_space.sample())
            total += reward
        first = obs if first is None else first
        assert np.array_equal(obs, first)
        returns.append(total)
    env.close()
    return returns


def createScene(root):
    root.addObject("DefaultAnimationLoop")
    returns = train(BeamEnv())
    assert len(set(returns)) == 1
    root.addData("returns", value=returns, type="vector<double>")


if __name__ == "__main__":
    print(train(BeamEnv()))
