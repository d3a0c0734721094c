# SPDX-License-Identifier: LGPL-2.1-or-later
"""createScene() files in the manner of public ones: robots with cables and cavities, libraries, prefabs, controllers of all kinds.
Each runs ten steps by the command, or says in one message all that is missing; closed forms are checked where they are at hand."""
import random
import re
import sys

import numpy as np
import pytest
import Sofa
from playing import HERE, SCENES, animate, run, runs_ten_steps, scene, started, tells_all_that_is_missing
from Sofa import _events
from Sofa.constants import Key

sys.path.insert(0, str(HERE))
RUNS = ["finger", "gripper", "trunk", "pneunet", "cavity_of_library", "rigidified", "liver_like", "rest_shape_force", "all_events",
        "spheres_by_keys", "matrices", "springs_by_script", "recorder", "episodes", "cloth", "beam_needle", "exporters", "drawn",
        "of_sofapython2", "engines", "of_two_files", "folders", "values_in_place", "switches", "attached", "arm_of_joints", "hyperelastic",
        "loop_of_program", "two_grippers", "dropped", "catheter", "catheter_contact",
        "three_instruments"]
LACKS = {
    "haptic": ["GeomagicDriver"],
    "needs_more": ["gym_of_nobody", "sofa_of_nobody", "FluidGridOfNobody", "ShellOfNobody"],
}


@pytest.mark.parametrize("name", RUNS)
def test_runs_ten_steps(name, folder):
    runs_ten_steps(name, folder)


@pytest.mark.parametrize("name", LACKS)
def test_all_that_is_missing_is_one_message(name, folder):
    tells_all_that_is_missing(name, LACKS[name], folder)


def test_points_that_cells_still_have_stay(folder):
    done = run("run", SCENES / "topology_cut.py", "-n", 10, "--no-record", folder=folder)
    assert done.returncode == 3 and re.search(r"topology_cut.py:\d+: .*point [01] cannot be removed: one of the edges still uses it", done.stderr), done.stderr


def test_instruments_that_are_drawn_back_have_a_matrix_with_a_solution(folder):
    """Where a step starts the beam at the opening is far too short or too long: its exact stiffness has none."""
    done = run("run", SCENES / "three_instruments.py", "-n", 100, "--no-record", folder=folder)
    assert done.returncode == 0 and "not positive definite" not in done.stdout + done.stderr, done.stdout + done.stderr


# ---- robots ----

def test_keys_pull_a_cable():
    """The cable is as much shorter as the keys say, whatever the body does."""
    root = started("finger")
    cable = root.finger.cable.aCableActuator
    for _ in range(3):
        _events.key(root, Key.plus)
    _events.key(root, Key.minus)
    assert cable.value.value.tolist() == [2]
    animate(root, 5)
    assert cable.displacement.value == pytest.approx(2, abs=1e-3)
    assert cable.cableInitialLength.value == pytest.approx(70) and cable.cableLength.value == pytest.approx(68, abs=1e-3)
    assert cable.force.value > 0


def test_fingers_of_a_library_close():
    root = started("gripper")
    animate(root, 1)
    fingers = [root.Finger1.ElasticMaterialObject, root.Finger2.ElasticMaterialObject]
    start = [finger.dofs.position.array() for finger in fingers]
    for _ in range(4):
        _events.key(root, Key.uparrow)
    animate(root, 3)
    for finger, before in zip(fingers, start):
        assert finger.PullingCable.CableConstraint.displacement.value == pytest.approx(4, abs=1e-2)
        assert np.abs(finger.dofs.position.value - before).max() > 0.5
        assert len(finger.FixedBox.BoxROI.indices.value) == 9
    assert root.Cube.mstate.position.value.shape == (1, 7)


def test_animations_pull_and_end():
    root = started("trunk")
    animate(root, 10)
    assert root.trunk.done == [1.0]
    assert [cable.CableConstraint.value.value[0] for cable in root.trunk.cables] == [2, 0, 0, 0]
    assert root.trunk.cables[0].CableConstraint.displacement.value == pytest.approx(2, abs=1e-2)
    assert len(root.Simulation.Trunk.children) == 5


def test_a_pressure_that_a_controller_raises():
    root = started("pneunet")
    cavity = root.finger.cavity.SurfacePressureConstraint
    pressures = []
    for _ in range(6):
        animate(root, 1)
        pressures.append(cavity.pressure.value)
    assert np.diff(pressures) == pytest.approx([pressures[1] - pressures[0]] * 5, rel=1e-9) and pressures[1] > pressures[0] > 0
    assert cavity.initialCavityVolume.value == pytest.approx(64 * 8 * 8) and cavity.cavityVolume.value > 64 * 8 * 8
    assert len(root.finger.modelSubTopo.container.tetrahedra.value) == 96, "half of the mesh"


def test_a_volume_that_an_animation_lets_grow():
    root = started("cavity_of_library")
    animate(root, 4)
    cavity = root.bunny.PneumaticCavity.SurfacePressureConstraint
    assert cavity.volumeGrowth.value == pytest.approx(30, rel=1e-3) and cavity.pressure.value > 0  # 3 steps of 10


def test_forces_of_constraint_along_walls_that_bulge_come_to_rest(folder):
    """Where the cavity has grown by 100, each round of forces takes less than 1 % of what is left."""
    done = run("run", SCENES / "cavity_of_library.py", "-n", 14, "--no-record", folder=folder)
    assert done.returncode == 0 and "done after 14 steps" in done.stdout, done.stdout + done.stderr


def test_ends_that_are_rigid():
    root = started("rigidified")
    rigid = root.Modelling.RigidifiedStructure.RigidParts
    start = rigid.dofs.position.array()
    assert start[:, 0].tolist() == pytest.approx([0, 80]) and start[:, 1:3] == pytest.approx(10)
    animate(root, 3)
    now = rigid.dofs.position.value
    assert now[0] == pytest.approx(start[0], abs=1e-12) and now[1][0] > 80.1
    body = root.Modelling.RigidifiedStructure.body if root.Modelling.RigidifiedStructure.hasChild("body") else rigid.RigidifiedParticules.body
    particles = rigid.RigidifiedParticules.dofs.position.value
    whole = body.dofs.position.value
    assert len(whole) == 81 and min(np.linalg.norm(whole - particles[0], axis=1)) < 1e-9


def lagging(targets, h=0.01, damping=0.1):
    """What a stiff spring with stiffness-proportional damping leads: (h + b) v = x_target - x."""
    x = 0.0
    for target in targets:
        x += h * (target - x) / (h + damping)
    return x


def test_an_angle_that_a_controller_writes():
    root = started("arm_of_joints")
    animate(root, 10)
    servo = root.Simulation.Servo
    angle = servo.dofs.position.value[0][0]
    assert angle == pytest.approx(lagging(np.sin(0.01 * np.arange(1, 11))), rel=0.01)
    wheel = servo.ServoWheel.dofs.position.value[1]
    assert wheel[3:] == pytest.approx([np.sin(angle / 2), 0, 0, np.cos(angle / 2)], abs=1e-9)


def test_a_needle_follows_its_base():
    root = started("beam_needle")
    animate(root, 10)
    assert root.base.dofs.position.value[0][0] == pytest.approx(0.1)
    first = root.needle.dofs.position.value[0]
    assert first[0] == pytest.approx(lagging(0.01 * np.arange(1, 11)), rel=0.01)
    assert root.needle.collision.points.position.value[0] == pytest.approx(first[:3], abs=1e-9)


def test_frames_without_a_solver_lead_a_sheet():
    root = started("two_grippers")
    animate(root, 10)
    t = 0.1
    for name, held, y, sign in (("gripper", "defConstraint", 1 - 0.2 * t, -1), ("gripper2", "defConstraint2", 0.2 * t, 1)):
        frame = root.system[name].gripperMO.position.value[0]
        assert frame[:3] == pytest.approx([0, y, 0], abs=1e-12)
        points = root.system[name].gripConstraint.constraintMO.position.value
        angle = -0.5 * t * sign
        expected = [[x, y + 0.1 * sign * np.cos(angle), 0.1 * sign * np.sin(angle)] for x in (-0.1, 0.1)] + [[x, y, 0] for x in (-0.1, 0.1)]
        assert points == pytest.approx(np.array(expected), abs=1e-9)
        assert root.system.deformable[held].constraintMO.position.value == pytest.approx(points, abs=2e-3), "held to them"


def test_a_ball_that_falls_on_a_block():
    """Free fall of implicit Euler until it is near, then slower."""
    root = started("dropped")
    block, ball = root.Phantom.dofs, root.Sphere.mstate
    start = block.position.array()
    animate(root, 10)
    assert ball.position.value[0][1] == pytest.approx(26 - 9.81 * 0.002 ** 2 * 55, abs=1e-6)
    ball.velocity.value = [[0, -200, 0, 0, 0, 0]]
    lowest = 26
    for _ in range(30):
        animate(root, 1)
        lowest = min(lowest, ball.position.value[0][1])
    assert 20 < lowest < 25 and ball.velocity.value[0][1] > 0, "it came back"
    assert np.abs(block.position.value - start).max() > 1e-5


# ---- calls ----

def test_a_force_with_a_matrix_of_rows():
    """Implicit Euler with damping: (m (1 + h a) + (h^2 + h b) k) dv = h (m g - a m v - k u - (h + b) k v)."""
    root = started("rest_shape_force")
    h, k, m, g, a, b = 0.02, 20.0, 1.0, -9.81, 0.1, 0.1
    u = v = 0.0
    for _ in range(8):
        dv = h * (m * g - a * m * v - k * u - (h + b) * k * v) / (m * (1 + h * a) + (h * h + h * b) * k)
        v += dv
        u += h * v
        animate(root, 1)
        assert root.py_implicit.MO.position.value[:, 1] == pytest.approx([u, u], abs=1e-9)


def test_events_in_their_order(capsys):
    root = started("all_events")
    ear = root.MyEmptyController
    assert ear.calls == ["other SimulationInitDoneEvent"]
    ear.calls.clear()
    animate(root, 2)
    assert ear.calls == ["begin", "collided", "integrate", "end"] * 2
    told = capsys.readouterr().err
    for name in ("onHapticDeviceEvent", "onScriptEvent"):
        assert told.count(f"{name}() is not called") == 1
    assert "onKeypressedEvent" not in told and "onEvent()" not in told


def test_bodies_that_come_while_it_runs():
    root = started("spheres_by_keys")
    heights = []
    for _ in range(10):
        animate(root, 1)
        heights.append([child.objects[2].position.value[0][1] for child in root.children])
    assert [len(each) for each in heights] == [0, 0, 1, 1, 1, 2, 2, 2, 2, 2]
    assert heights[-1][0] == pytest.approx(10 - 9.81 * 1e-4 * 8 * 9 / 2, abs=1e-9), "eight steps of free fall"


def test_matrices_that_exist():
    root = started("matrices")
    animate(root, 1)
    access = root.matrixAccessor
    stiffness, mass, matrix, right = access.found
    assert stiffness.shape == mass.shape == matrix.shape == (48, 48) and right.shape == (48,) and access.missing == 0
    held = [3 * node + axis for node in (0, 4, 8, 12) for axis in range(3)]
    assert np.array_equal(matrix.toarray()[held], np.eye(48)[held]) and not right[held].any() and right.any()
    assert mass.sum() == pytest.approx(3 * 1.0)
    assert abs(stiffness - stiffness.T).max() < 1e-9 * abs(stiffness).max() and np.linalg.eigvalsh(stiffness.toarray()).max() < 1e-6
    moved = np.tile([1.0, 2.0, 3.0], 16)
    assert abs(stiffness @ moved).max() < 1e-8 * abs(stiffness).max(), "no force of a body that is only moved"


def test_values_that_were_recorded():
    root = started("recorder")
    animate(root, 4)
    rows = np.loadtxt(root.body.Recorder.folder + "/out.csv", delimiter=",")
    assert rows[:, 0] == pytest.approx([0.005, 0.01, 0.015, 0.02])
    assert (np.diff(rows[:, 1]) > 0).all() and rows[-1, 3] > 0
    assert np.load(root.body.Recorder.folder + "/x.npy").shape == (81, 3)


def test_an_environment():
    sys.path.insert(0, str(SCENES))
    import episodes

    env = episodes.Env()
    first = env.reset()
    assert first.tolist() == [0.1, 0]
    seen = [env.step(2.0)[0] for _ in range(5)]
    v = x = 0.0
    for _ in range(10):
        v += 0.01 * 2.0
        x += 0.01 * v
    assert seen[-1] == pytest.approx([0.1 + x, v], abs=1e-12)
    assert env.reset().tolist() == [0.1, 0]
    assert np.array_equal([env.step(2.0)[0] for _ in range(5)], seen), "the same bits"
    env.close()


def test_all_ways_of_writing():
    root = started("values_in_place")
    node = root.node
    animate(root, 4)
    assert node.load.forces.value.tolist() == [[2, 4, 6], [8, 10, 12]]
    animate(root, 5)
    dofs = node.dofs.position.value
    assert node.ways.step == 9 and np.isfinite(dofs).all()
    before = node.dofs.position.array()
    animate(root, 1)
    assert node.mass.totalMass.value == 3
    assert (node.dofs.position.value[:, 1] - before[:, 1] > 1).all(), "moved by one, and on by its speed"


def test_nothing_below_what_is_switched_off_hears():
    root = started("switches")
    animate(root, 3)
    assert (root.never.count, root.always.count) == (0, 3)


def test_folders_and_two_files():
    assert scene("folders").body.loader.position.value.shape == (81, 3)
    root = started("of_two_files")
    assert root.number == 2 and len(root.solver.layer_1_soft.box.indices.value) == 4
    assert root.solver.layer_2_stiff.grid.position.value[:, 2].tolist() == [2] * 8 + [3] * 8


def test_files_of_exporters(folder):
    done = run("run", SCENES / "exporters.py", "-n", 10, "--no-record", folder=folder)
    assert done.returncode == 0, done.stderr
    names = [each.name for each in (folder / "out_of_exporters").iterdir()]
    for part in ("body", "tip", "state", "surface"):
        assert any(name.startswith(part) for name in names), names


@pytest.mark.parametrize("name", RUNS)
def test_ten_thousand_calls_on_anything_with_any_value(name, folder):
    """Each returns or raises an exception of Python."""
    from test_scenes import random_call

    chance, refused = random.Random(name), 0
    root = started(name)
    for _ in range(360):
        try:
            random_call(root, chance)
        except Exception:
            refused += 1
    assert refused > 50


def test_trees_that_nobody_has_are_gone():
    """Each holds a simulation; arrays that a program reads hold themselves not."""
    import gc
    import weakref

    from Sofa import _engine

    def one():
        root = started("pneunet")
        animate(root, 1)
        values = root.finger.tetras.position.value
        return weakref.ref(values), weakref.ref(root)
    gc.collect()
    gc.disable()
    try:
        values, _ = one()
        assert values() is None, "an array is no ring"
        roots = [one()[1] for _ in range(12)]
        assert len(_engine._alive) <= 6 and sum(root() is not None for root in roots) <= 6
    finally:
        gc.enable()
