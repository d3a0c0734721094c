#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""An environment as Gymnasium has them, in sixty lines: a soft finger is pulled by a thread, and its tip is to reach a place.
reset() goes back to the start to the bit. Run it with: python3 scenes/python/gym_like.py"""
import time

import numpy
import stroma


def finger():
    root = stroma.Node("root", dt=0.02, gravity=(0, -9.81, 0))
    root.add("EulerImplicitSolver", rayleighStiffness=0.05)
    root.add("SparseLDLSolver")
    root.add("RegularGridTopology", n=(11, 3, 3), min=(0, 0, 0), max=(0.1, 0.02, 0.02))
    root.add("MechanicalObject", name="dofs")
    root.add("UniformMass", totalMass=0.04)
    root.add("HexahedronFEMForceField", youngModulus="1 MPa", poissonRatio=0.45, method="polar")
    root.add("BoxROI", name="base", box=(-0.001, -1, -1, 0.001, 1, 1))
    root.add("FixedProjectiveConstraint", indices="@base.indices")
    return root


class Finger:
    """observation: tip and its velocity, goal (9 numbers); action: the force on the tip [N] (3); reward: minus the distance [m]."""

    limit, steps_of_an_action, actions = 1.0, 5, 60

    def __init__(self):
        self.simulation = stroma.load(finger())
        self.state = self.simulation.state()
        self.tip = [node for node in range(self.state.nodes) if self.state.start[node, 0] > 0.0999]
        self.thread = None

    def observe(self):
        return numpy.concatenate([self.state.x[self.tip].mean(axis=0), self.state.v[self.tip].mean(axis=0), self.goal])

    def reset(self, seed=None):
        self.simulation.reset()
        self.thread, self.count = self.simulation.add_force(self.state, self.tip), 0
        self.goal = numpy.array([0.099, *numpy.random.default_rng(seed).uniform(-0.01, 0.02, 2)])
        return self.observe(), {}

    def step(self, action):
        self.thread.change(force=numpy.clip(action, -self.limit, self.limit) / len(self.tip))
        self.simulation.run(self.steps_of_an_action)
        self.count += 1
        observation = self.observe()
        distance = float(numpy.linalg.norm(observation[:3] - self.goal))
        return observation, -distance, distance < 0.002, self.count >= self.actions, {}


environment, returns, made, start = Finger(), [], 0, time.process_time()
for episode in range(4):
    observation, _ = environment.reset(seed=episode % 2)
    done, total, integral = False, 0.0, numpy.zeros(3)
    while not done:
        away = observation[6:] - observation[:3]
        integral += away
        observation, reward, reached, too_long, _ = environment.step(5 * away + 2 * integral - observation[3:6])
        total, done = total + reward, reached or too_long
    returns.append((total, -reward))
    made += environment.count * environment.steps_of_an_action
print(", ".join(f"return {total:.3f}, {away * 1000:.1f} mm away" for total, away in returns))
print(f"{made / (time.process_time() - start):.0f} steps per second of one core")


def check():
    assert returns[0] == returns[2] and returns[1] == returns[3], "an episode is repeated to the bit"
    assert all(away < 0.002 for _, away in returns), "the tip reaches each place"
