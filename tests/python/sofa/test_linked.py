# SPDX-License-Identifier: LGPL-2.1-or-later
"""Links from components to data of Python that change while a scene runs."""
import math
import re

import numpy as np
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


WAYS = ["objects", "paths", "tuple", "text", "relative", "assigned paths", "assigned values", "assigned text", "assigned objects", "set"]


@pytest.mark.parametrize("place", ("below", "deep", "second parent"))
@pytest.mark.parametrize("way", WAYS)
def test_links_made_before_a_node_has_a_parent(way, place):
    """Two bodies and points that follow both, in a part that is put into the tree, or of which a node alone is, when all is there."""
    root, part = Sofa.Core.Node("root"), Sofa.Core.Node("part")
    root.gravity, root.dt = [0, 0, -5], 0.01
    sim = part.addChild("sim")
    sim.addObject("EulerImplicitSolver")
    sim.addObject("SparseLDLSolver")
    a, b = (sim.addChild(name) for name in "ab")
    first = a.addObject("MechanicalObject", name="dofs", position=[[0, 0, 0], [1, 0, 0]])
    second = b.addObject("MechanicalObject", name="dofs", position=[[2, 0, 0]])
    for node in (a, b):
        node.addObject("UniformMass", totalMass=1)
    both = a.addChild("both")
    b.addChild(both)
    dofs = both.addObject("MechanicalObject", name="dofs", position=[[0, 0, 0], [1, 0, 0], [2, 0, 0]])
    paths, own = [first.getLinkPath(), second.getLinkPath()], dofs.getLinkPath()
    given = {"objects": dict(input=[first, second], output=dofs), "paths": dict(input=paths, output=own),
             "tuple": dict(input=tuple(paths), output=[own]), "text": dict(input=" ".join(paths), output="@./dofs"),
             "relative": dict(input=["@../../a/dofs", "@../../b/dofs"], output="@dofs")}.get(way, {})
    mapping = both.addObject("SubsetMultiMapping", template="Vec3,Vec3", indexPairs=[0, 0, 0, 1, 1, 0], **given)
    if way == "assigned paths":
        mapping.input, mapping.output = paths, own
    elif way == "assigned values":
        mapping.input.value, mapping.output.value = paths, own
    elif way == "assigned text":
        mapping.input, mapping.output = " ".join(paths), own
    elif way == "assigned objects":
        mapping.input, mapping.output = [first, second], dofs
    elif way == "set":
        mapping.setDataValues(input=paths, output=own)
    both.addObject("ConstantForceField", indices=[2], totalForce=[0, 0, 8])
    {"below": root, "deep": root.addChild("x").addChild("y"), "second parent": root.addChild("z")}[place].addChild(
        sim if place == "second parent" else part)
    Sofa.Simulation.init(root)
    for _ in range(3):
        Sofa.Simulation.animate(root, root.dt.value)
    fallen = 0.01**2 * 6
    assert np.array(first.position.value)[:, 2] == pytest.approx([-5 * fallen] * 2)
    assert np.array(second.position.value)[0, 2] == pytest.approx(3 * fallen)
    assert np.array(dofs.position.value)[:, 2] == pytest.approx([-5 * fallen, -5 * fallen, 3 * fallen])


def test_paths_and_parents_stay_in_the_order_of_the_scene():
    """A node below a part that is in no tree, and then below one that is: it runs there, and its first parent is still the first."""
    root, part = Sofa.Core.Node("root"), Sofa.Core.Node("part")
    root.gravity, root.dt = [0, 0, -5], 0.01
    body = part.addChild("sim").addChild("body")
    root.addChild("other").addChild(body)
    body.addObject("EulerImplicitSolver")
    body.addObject("SparseLDLSolver")
    state = body.addObject("MechanicalObject", name="dofs", position=[[0, 0, 0]])
    body.addObject("UniformMass", totalMass=1)

    def told():
        return body.getPathName(), state.getLinkPath(), [parent.name.value for parent in body.parents], body.getParents()[0].name.value
    before = told()
    assert before == ("/sim/body", "@/sim/body/dofs", ["sim", "other"], "sim")
    animate(root, 2)
    assert told() == before
    assert state.position.value[0, 2] == pytest.approx(-5 * 0.01**2 * 3) and body.getRoot() is root


def test_what_a_node_has_of_a_role_tells_its_paths():
    """Scenes look for the type of a force field in it."""
    root = Sofa.Core.Node("root")
    leg = root.addChild("leg")
    leg.addObject("MechanicalObject", position=[[0, 0, 0], [1, 0, 0]])
    leg.addObject("RestShapeSpringsForceField", stiffness=1)
    leg.addObject("ConstantForceField", name="load", forces=[[0, 1, 0]])
    assert leg.forceField.getValueString() == "@/leg/RestShapeSpringsForceField @/leg/load" and leg.forceField.getSize() == 2
    assert "RestShapeSprings" in leg.forceField.getValueString()
