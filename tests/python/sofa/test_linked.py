# SPDX-License-Identifier: LGPL-2.1-or-later
"""Links from components to data of Python that change while a scene runs."""
import math
import re

import pytest
import Sofa
from playing import SCENES, animate, run, started


def lagging(steps, h=0.01, damping=0.1):
    """A hinge whose spring and its damping outweigh its inertia: (h + damping) v = wanted - angle."""
    angle = 0
    for k in range(steps):
        angle += h * (0.5 * math.sin(0.1 * (k + 1)) - angle) / (h + damping)
    return angle


def pulled(steps, h=0.01, mass=2):
    """Backward Euler of a force that grows by 1 N a step, and of a velocity that is written once, before step 6."""
    places, speeds = [0, 0, 0], [0, 0, 0]
    for k in range(1, steps + 1):
        if k == 6:
            speeds = [0, 0, 1]
        speeds[1] += h * k / mass
        places = [place + h * speed for place, speed in zip(places, speeds)]
    return places


def test_states_follow_the_data_that_they_are_linked_to():
    root = started("servo_linked")
    animate(root, 10)
    servo = root.Robot.Servo
    # a spring of 1e9 N m/rad leaves h^2 I / (h + damping) k of the way, which is 1e-8 of it
    assert servo.Articulation.dofs.position.value[0][0] == pytest.approx(lagging(10), rel=1e-6)
    turned = servo.Articulation.Wheel.dofs.position.value[1]
    assert 2 * math.asin(turned[3]) == pytest.approx(lagging(10), rel=1e-6)
    assert root.Pulled.dofs.position.value[0] == pytest.approx(pulled(10), abs=1e-12)
    assert root.Pulled.Goal.dofs.position.value[0] == pytest.approx([2.5, 0, 0], abs=1e-12)


def test_the_command_runs_it_in_one_go(folder):
    done = run("run", SCENES / "servo_linked.py", "-n", 10, "--no-record", folder=folder)
    assert done.returncode == 0 and "changes its tree" not in done.stderr, done.stderr
    angle, goal, *place = map(float, re.search(r"angle (\S+) goal (\S+) place (\S+) (\S+) (\S+)", done.stdout).groups())
    assert angle == pytest.approx(lagging(10), rel=1e-6) and goal == 2.5 and place == pytest.approx(pulled(10), abs=1e-12)


@pytest.mark.parametrize("region", ["linked", "itself"])
def test_a_region_that_a_load_has_taken_may_change(folder, region):
    """Two masses of 1 kg under 1 N: the one from the start, the other from step 5 on."""
    done = run("run", SCENES / "region_moved.py", "-n", 8, "--no-record", folder=folder, REGION=region)
    assert done.returncode == 0 and "Traceback" not in done.stderr, done.stderr
    first, second = map(float, re.search(r"heights (\S+) (\S+)", done.stdout).groups())
    assert first == pytest.approx(0.01 ** 2 * 8 * 9 / 2, abs=1e-12) and second == pytest.approx(0.01 ** 2 * 4 * 5 / 2, abs=1e-12)


def test_data_that_a_program_adds_to_a_component_are_its_own(capfd):
    """They are no attribute that the component lacks, and others follow them."""
    root = Sofa.Core.Node("root")
    root.gravity, root.dt = [0, 0, 0], 0.01
    root.addObject("EulerImplicitSolver")
    root.addObject("SparseLDLSolver")
    state = root.addObject("MechanicalObject", position=[[0, 0, 0]])
    root.addObject("UniformMass", totalMass=2)
    state.addData(name="pull", type="Vec3d", value=[2, 0, 0], help="", group="")
    root.addObject("ConstantForceField", indices=[0], totalForce=state.pull.getLinkPath())
    Sofa.Simulation.init(root)
    animate(root, 1)
    state.pull.value = [0, 4, 0]
    animate(root, 1)
    assert state.velocity.value[0] == pytest.approx([0.01, 0.02, 0], abs=1e-15)
    assert "pull" not in capfd.readouterr().err


def test_data_of_another_component_that_are_added_whole_are_the_programs_own(capfd):
    """addData(data): what is added follows the data that were given, and is no attribute either."""
    root = Sofa.Core.Node("root")
    root.gravity, root.dt = [0, 0, 0], 0.01
    root.addObject("EulerImplicitSolver")
    root.addObject("SparseLDLSolver")
    state = root.addObject("MechanicalObject", position=[[0, 0, 0]])
    mass = root.addObject("UniformMass", totalMass=2)
    state.addData(name="pull", type="Vec3d", value=[2, 0, 0], help="", group="")
    mass.addData(state.pull)
    root.addObject("ConstantForceField", indices=[0], totalForce=mass.pull.getLinkPath())
    Sofa.Simulation.init(root)
    animate(root, 1)
    assert state.velocity.value[0] == pytest.approx([0.01, 0, 0], abs=1e-15)
    assert "pull" not in capfd.readouterr().err
