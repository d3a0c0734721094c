# SPDX-License-Identifier: LGPL-2.1-or-later
"""What programs do with soft robots: episodes that begin anew, control by their own Jacobian, parameters that an optimiser looks for,
processes that share the work, days of steps."""
import multiprocessing
import resource

import numpy as np
import pytest
import Sofa
from playing import animate

CABLES = ((4, 0), (0, 4), (-4, 0), (0, -4))


def trunk(young=300.0):
    """A beam along x with four cables."""
    root = Sofa.Core.Node("root")
    root.gravity, root.dt = [0, 0, 0], 0.02
    root.addObject("FreeMotionAnimationLoop")
    root.addObject("GenericConstraintSolver", tolerance=1e-8, maxIterations=500)
    body = root.addChild("body")
    body.addObject("EulerImplicitSolver", rayleighMass=5, rayleighStiffness=0.1)
    body.addObject("SparseLDLSolver")
    body.addObject("RegularGridTopology", n=[6, 3, 3], min=[0, -5, -5], max=[80, 5, 5])
    body.addObject("MechanicalObject", name="state")
    body.addObject("UniformMass", totalMass=0.05)
    body.addObject("HexahedronFEMForceField", name="elastic", youngModulus=young, poissonRatio=0.3)
    body.addObject("FixedProjectiveConstraint", indices=list(range(0, 54, 6)))
    body.addObject("LinearSolverConstraintCorrection")
    for number, (y, z) in enumerate(CABLES):
        cable = body.addChild(f"cable{number}")
        cable.addObject("MechanicalObject", position=[[x, y, z] for x in (10, 30, 50, 78)])
        cable.addObject("CableConstraint", name="cable", indices=[0, 1, 2, 3], pullPoint=[0, y, z], value=[0.0], minForce=0)
        cable.addObject("BarycentricMapping")
    tip = body.addChild("tip")
    tip.addObject("MechanicalObject", name="point", position=[[80, 0, 0]])
    tip.addObject("BarycentricMapping")
    return root


def pull(root, values):
    for number, value in enumerate(values):
        root.body.getChild(f"cable{number}").cable.value = [float(value)]


def tip_of(root):
    return np.array(root.body.tip.point.position.value[0])


class Environment:
    """As a learner has it."""

    def __init__(self):
        self.root = trunk()
        Sofa.Simulation.init(self.root)

    def reset(self):
        Sofa.Simulation.reset(self.root)
        self.pulled = np.zeros(4)
        pull(self.root, self.pulled)
        return tip_of(self.root)

    def step(self, action):
        self.pulled = np.clip(self.pulled + action, 0, 10)
        pull(self.root, self.pulled)
        animate(self.root, 2)
        return tip_of(self.root)


def test_episodes_are_the_same_to_the_bit_and_take_no_memory():
    environment, ways, memory = Environment(), [], []
    for episode in range(200):
        random = np.random.default_rng(0)
        ways.append([environment.reset(), *(environment.step(random.uniform(0, 0.5, 4)) for _ in range(3))])
        memory.append(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
    assert np.ptp(ways[0], axis=0).max() > 1e-3
    assert all(np.array_equal(way, ways[0]) for way in ways)
    assert memory[-1] - memory[20] < 6000  # KB


def test_days_of_steps_take_no_memory():
    """What a controller writes and reads in each step of them leaves nothing behind."""
    class Controls(Sofa.Core.Controller):
        step = 0

        def onAnimateBeginEvent(self, event):
            self.step += 1
            state = self.getContext().body.state
            self.getContext().body.load.forces.value = [[0, 0.1 * np.sin(0.1 * self.step), 0]]
            self.read = state.position.value[-1, 1], state.velocity.value.max(), state.force.value.max()

    root = Sofa.Core.Node("root")
    root.gravity, root.dt = [0, 0, 0], 0.01
    body = root.addChild("body")
    body.addObject("EulerImplicitSolver")
    body.addObject("SparseLDLSolver")
    body.addObject("MechanicalObject", name="state", position=[[0, 0, 0], [1, 0, 0]])
    body.addObject("UniformMass", totalMass=1)
    body.addObject("SpringForceField", spring="0 1 100 1 1")
    body.addObject("ConstantForceField", name="load", indices=[1], forces=[[0, 0, 0]])
    root.addObject(Controls())
    Sofa.Simulation.init(root)
    for number in range(30_000):  # by now the record of the run is given up
        body.load.forces.value = [[0, 1e-5 * number, 0]]
    animate(root, 500)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    animate(root, 10_000)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 2500  # KB


def test_a_loop_closed_by_its_own_jacobian_comes_to_the_goal():
    jacobian = np.zeros((3, 4))
    for number in range(4):
        root = trunk()
        Sofa.Simulation.init(root)
        pull(root, np.eye(4)[number])
        animate(root, 40)
        jacobian[:, number] = tip_of(root) - [80, 0, 0]
        Sofa.Simulation.unload(root)
    # by the symmetry of the beam, but for the axes that its cells turn with
    assert np.abs(jacobian[1:] - jacobian[1, 0] * np.array([[1, 0, -1, 0], [0, 1, 0, -1]])).max() < 2e-3 and jacobian[1, 0] > 1

    class Closed(Sofa.Core.Controller):
        pulled = np.zeros(4)

        def onAnimateBeginEvent(self, event):
            self.error = np.array([8.0, 6.0]) - tip_of(self.getContext())[1:]
            self.pulled = np.clip(self.pulled + 0.1 * np.linalg.pinv(jacobian[1:]) @ self.error, 0, 30)
            pull(self.getContext(), self.pulled)

    root = trunk()
    control = root.addObject(Closed())
    Sofa.Simulation.init(root)
    animate(root, 400)
    assert np.linalg.norm(control.error) < 0.02


def sag(young):
    root = trunk(young)
    root.gravity = [0, -981, 0]
    Sofa.Simulation.init(root)
    animate(root, 60)
    found = tip_of(root)[1]
    Sofa.Simulation.unload(root)
    return float(found)


def test_an_optimiser_finds_the_material():
    optimize = pytest.importorskip("scipy.optimize")
    measured = sag(2000.0)
    found = optimize.minimize_scalar(lambda power: (sag(10 ** power) - measured) ** 2, bounds=(3, 4), method="bounded",
                                     options={"xatol": 1e-4})
    assert abs(10 ** found.x - 2000) < 2


@pytest.mark.parametrize("way", ["fork", "spawn"])
def test_processes_find_the_same_bits(way):
    materials = [1500.0, 2000.0, 3000.0]
    alone = [sag(young) for young in materials]
    with multiprocessing.get_context(way).Pool(2) as pool:
        assert pool.map(sag, materials) == alone
    assert len(set(alone)) == 3
