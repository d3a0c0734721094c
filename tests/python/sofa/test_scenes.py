# SPDX-License-Identifier: LGPL-2.1-or-later
"""createScene() files, one for each way in which public scenes use SOFA's calls, against closed forms."""
import importlib.machinery
import importlib.util
import random
import re
import sys

import numpy as np
import pytest
import Sofa
from playing import SCENES, animate, scene, started


def fall(height, steps, h, g=-10.0):
    """Implicit Euler under gravity: v_n = n g h, x_n = x_0 + g h^2 n (n + 1) / 2."""
    return height + g * h * h * steps * (steps + 1) / 2


def swing(x, v, k, m, h, steps):
    """Implicit Euler on a spring: (m + h^2 k) v' = m v - h k x, x' = x + h v'."""
    for _ in range(steps):
        v = (m * v - h * k * x) / (m + h * h * k)
        x += h * v
    return x


def test_bodies_fall():
    root = started("free_fall")
    animate(root, 20)
    for name, height in (("low", 1.0), ("high", 2.5)):
        assert root[name].dofs.position.value[0] == pytest.approx([0, 0, fall(height, 20, 0.05)], abs=1e-12)
        assert root[name].dofs.velocity.value[0][2] == pytest.approx(-10 * 0.05 * 20, abs=1e-12)
    assert root.time.value == pytest.approx(1.0) and root.getTime() == root.time.value


def test_energies():
    root = started("free_fall")
    assert root.computeEnergy()[0] == 0
    start = root.computeEnergy()[1]
    animate(root, 20)
    speed, height = 10.0, sum(fall(each, 20, 0.05) - each for each in (1.0, 2.5))
    assert root.computeEnergy() == pytest.approx((2 * 0.5 * 2 * speed**2, start + 2 * 10 * height), rel=1e-12)


def test_contact_beside_a_controller():
    """k = k1 k2 / d in one implicit step each, while the point is nearer than d where the step starts."""
    root = started("contact")
    h, g, d, y, v, lowest = 0.01, 10, 0.2, 1.0, 0.0, 1.0
    k = 10 * 10 / d
    for _ in range(150):
        animate(root, 1)
        stiffness = k if y < d else 0
        v += (h * (-g + stiffness * (d - y)) - h * h * stiffness * v) / (1 + h * h * stiffness)
        y += h * v
        lowest = min(lowest, y)
    assert root.ball.dofs.position.value[0] == pytest.approx([0, y, 0], abs=1e-9)
    assert root.watch.lowest == pytest.approx(lowest, abs=1e-9) and lowest < d


def test_what_is_not_computed_is_told_once(capsys):
    root = Sofa.Core.Node("root")
    root.addObject("EulerImplicitSolver")
    root.addObject("SparseLDLSolver")
    dofs = root.addObject("MechanicalObject", name="dofs", position=[0, 0, 0])
    root.addObject("UniformMass", totalMass=1)
    Sofa.Simulation.initRoot(root)
    assert len(dofs.derivX.value) == len(dofs.derivX.value) == 0
    assert capsys.readouterr().err.count("/dofs.derivX: is read, and not computed here") == 1


def test_a_step_of_another_length():
    """animate(root, dt) is of that step alone, as in SOFA."""
    root = started("free_fall")
    Sofa.Simulation.animate(root, 0.02)
    Sofa.Simulation.animate(root)
    assert root.dt.value == 0.05 and root.time.value == pytest.approx(0.07)
    root.dt = 0.1
    animate(root, 1)
    v = [-10 * 0.02, -10 * 0.07, -10 * 0.17]
    assert root.low.dofs.position.value[0][2] == pytest.approx(1 + 0.02 * v[0] + 0.05 * v[1] + 0.1 * v[2], abs=1e-12)


def test_values_of_every_kind():
    root = scene("value_kinds")
    beam = root.beam
    assert root.dt.value == 0.02 and list(beam.gravity.value) == [0, -9.81, 0]
    assert beam.grid.n.value.tolist() == [5, 3, 3] and beam.fem.youngModulus.value == pytest.approx(5000)
    assert beam.EulerImplicitSolver.rayleighStiffness.value == 0.1 and beam.CGLinearSolver.iterations.value == 200
    assert beam.load.forces.value.shape == (2, 3) and beam.load.indices.value.tolist() == [4, 9]
    assert beam.fem.method.value == "large" and beam.dofs.showObject.value is True
    assert beam.clamp.box.value.size == 6
    Sofa.Simulation.init(root)
    animate(root, 10)
    assert len(beam.clamp.indices.value) == 9 and beam.dofs.position.value.shape == (45, 3)
    start, now = beam.grid.position.value, beam.dofs.position.value
    held = beam.clamp.indices.value
    assert np.abs(now[held] - start[held]).max() == 0 and now[4][1] < start[4][1]


def test_links():
    root = started("links")
    body = root.body
    assert len(body.container.hexahedra.value) == 3 and len(body.roi.indices.value) == 4
    assert sorted(body.clamp.indices.value.tolist()) == sorted(body.roi.indices.value.tolist())
    animate(root, 2)
    assert body.other.points.position.value[0] == pytest.approx([1.5, 0.5, 0.5], abs=1e-9)
    assert body.clamp.indices.getParent() is body.roi.indices


def test_controller_drives():
    root = started("driven")
    animate(root, 10)
    drive = root.drive
    assert (drive.begins, drive.ends) == (10, 10)
    x = v = 0.0
    for n in range(1, 11):  # the force of the step is that set before it
        v += 0.1 * 3.0 * n / 1.5
        x += 0.1 * v
        assert drive.heights[n - 1] == pytest.approx(x, rel=1e-12)


def test_positions_are_written():
    root = started("writeable")
    dofs = root.body.dofs
    expected = [[1, 0, 0], [1, 1, 0], [5, 5, 5], [5.5, 5, 5], [6, 5, 7]]
    for place in expected:
        animate(root, 1)
        assert dofs.position.value[0] == pytest.approx(place, abs=1e-12)


def test_values_before_init():
    root = scene("before_init")
    body = root.body
    assert body.corners.tolist() == [[0, 0, 0], [2, 0, 0], [0, 2, 0], [0, 0, 2]] and body.faces == 4
    assert body.chosen == [0, 3, 6, 9, 12, 15, 18, 21, 24] and body.nodes == (27, 3)
    Sofa.Simulation.init(root)
    assert body.dofs.position.value[:, 2].tolist() == [1, 1, 1, 3]


def test_data_of_the_scene():
    root = started("user_data")
    assert root.material.names.value == ["a", "b"] and root.material.on.value is True
    assert root.body.dofs.position.value.tolist() == [[0.5, 0, 0]]
    animate(root, 30)
    assert root.body.dofs.position.value[0][0] == pytest.approx(swing(0.5, 0, 50, 2, 0.01, 30), abs=1e-10)
    root.material.stiffness.value = 200.0  # the spring takes its value from there
    x, v = root.body.dofs.position.value[0][0], root.body.dofs.velocity.value[0][0]
    animate(root, 5)
    assert root.body.dofs.position.value[0][0] == pytest.approx(swing(x, v, 200, 2, 0.01, 5), abs=1e-10)


def test_keys():
    from Sofa import _events
    from Sofa.constants import Key

    root = started("by_keys")
    h = root.dt.value
    _events.key(root, Key.uparrow)
    animate(root, 1)
    assert root.body.dofs.velocity.value[0][2] == pytest.approx(h)
    _events.key(root, "-")
    _events.key(root, "A", False)
    animate(root, 2)
    assert root.body.dofs.velocity.value[0][2] == pytest.approx(-h)
    assert root.getObject("keys").seen == [Key.uparrow, "-", "released A"]


def test_events():
    root = started("any_event")
    ear = root.ear
    assert ear.initialised and ear.heard[-1] == "SimulationInitDoneEvent"
    ear.heard.clear()
    animate(root, 1)
    assert ear.heard == ["PythonScriptEvent", "AnimateBeginEvent", "AnimateEndEvent"]
    assert root.deaf.heard == []


def test_tree_changes_in_the_run():
    root = started("released")
    dofs = root.body.dofs
    h, x, v = 0.1, 0.0, 0.0
    for step in range(1, 9):
        animate(root, 1)
        if step >= 3:  # free from this step on; the load from the fifth
            v += h * (-10 + (20 if step >= 5 else 0))
            x += h * v
        assert dofs.position.value[0][2] == pytest.approx(x, abs=1e-12), step
        assert root.time.value == pytest.approx(step * h)


def test_what_is_removed():
    root = started("removed_before")
    animate(root, 3)
    assert root.body.dofs.position.value[0][2] == pytest.approx(fall(0, 3, root.dt.value), abs=1e-12)
    assert root.getChild("body").getChild("gone") is None and len(root.body.objects) == 4


def test_prefabs():
    root = started("prefab")
    animate(root, 2)
    assert root.pair.one.dofs.position.value[0][2] == pytest.approx(fall(1.0, 2, 0.1), abs=1e-12)
    assert root.pair.two.dofs.position.value[0][2] == pytest.approx(fall(0.0, 2, 0.1), abs=1e-12)
    assert root.pair.one.mass.value == 2.0 and root.raw.uniform.totalMass.value == 3.0


def test_parameters_change_in_the_run():
    root = started("reinit")
    animate(root, 10)
    assert root.body.spring.stiffness.value.tolist() == [100]
    x, v = root.body.dofs.position.value[0][0], root.body.dofs.velocity.value[0][0]
    assert x == pytest.approx(swing(0.5, 0, 100, 2, 0.01, 10), abs=1e-10)
    animate(root, 10)
    assert root.body.dofs.position.value[0][0] == pytest.approx(swing(x, v, 50, 2, 0.01, 10), abs=1e-10)


@pytest.mark.parametrize("name", ["older_python", "python_two"])
def test_older_python(name):
    root = started(name)
    h = root.dt.value
    animate(root, 4)
    assert root.body.dofs.position.value[0][2] == pytest.approx(fall(0, 4, h), abs=1e-12)
    if name == "older_python":
        assert root.counter.count == 4 and root.counter.last == pytest.approx(fall(0, 3, h), abs=1e-12)


def test_reset_is_the_start():
    root = started("free_fall")
    animate(root, 7)
    first = root.high.dofs.position.array()
    Sofa.Simulation.reset(root)
    assert root.high.dofs.position.value.tolist() == [[0, 0, 2.5]] and root.time.value == 0
    animate(root, 7)
    assert (root.high.dofs.position.array() == first).all(), "the same bits"


def test_two_parents():
    root = started("two_parents")
    animate(root, 3)
    points = root.one.both.points
    assert points.position.value[:, 0].tolist() == [0, 1]
    assert points.position.value[:, 2] == pytest.approx([fall(0, 3, 0.1)] * 2, abs=1e-12)
    assert root.two.both is root.one.both


def test_a_library_on_the_same_calls():
    root = started("with_library")
    body = root.Simulation.body
    start = body.dofs.position.array()
    animate(root, 6)
    v = x = 0.0
    for step in range(6):  # the force grows over 0.4 s, from the first step on; all nodes alike, so nothing is strained
        v += 0.1 * 8 * min(step * 0.1 / 0.4, 1) / 4.0
        x += 0.1 * v
    assert body.dofs.position.value - start == pytest.approx(np.tile([x, 0, 0], (8, 1)), abs=1e-9)
    assert root.VisualStyle.displayFlags.value == "showBehavior"


def test_modules_and_files_of_the_scene():
    root = started("with_module")
    assert root.body.dofs.position.value.shape == (4, 3)


def test_names():
    root = started("names")
    animate(root, 1)
    h = root.dt.value
    assert root.body.MechanicalObject.velocity.value == pytest.approx(np.array([[2 * h, 0, 2 * h], [0, 2 * h, 2 * h]]))


def test_frames():
    root = started("rigid")
    animate(root, 1)
    assert root.body.frame.position.value.tolist() == [[0, 0, 0, 0, 0, 0, 1]]
    animate(root, 2)
    assert root.body.frame.position.value[0] == pytest.approx([1, 2, 3, 0, 0, 2 ** -0.5, 2 ** -0.5])
    assert root.body.points.dofs.position.value == pytest.approx(np.array([[1, 3, 3], [0, 2, 3]]))
    assert root.body.frame.velocity.value.shape == (1, 6)


def test_a_body_is_led():
    root = started("follower")
    x = v = rest = 0.0
    for _ in range(10):
        rest += 0.1
        v = (v - 0.1 * 100 * (x - rest)) / (1 + 0.01 * 100)
        x += 0.1 * v
        animate(root, 1)
        assert root.body.dofs.position.value[0][0] == pytest.approx(x, abs=1e-10)
    assert root.body.dofs.rest_position.value[0][0] == pytest.approx(1.0)


def test_a_target_without_mass():
    root = started("target")
    x = v = 0.0
    for step in range(1, 11):  # the spring sees the target where it was put before the step
        v = (v - 0.1 * 100 * (x - 0.1 * step)) / (1 + 0.01 * 100)
        x += 0.1 * v
        animate(root, 1)
        assert root.tool.dofs.position.value[0][0] == pytest.approx(x, abs=1e-10)
        assert root.tool.target.goal.position.value[0].tolist() == pytest.approx([0.1 * step, 0, 0]), "gravity does not pull it"


def test_a_goal_that_nothing_else_moves():
    root = started("goal")
    y = v = 0.0
    for step in range(1, 11):
        v = (2 * v - 0.1 * 50 * (y - 0.2 * step)) / (2 + 0.01 * 50)
        y += 0.1 * v
        animate(root, 1)
        assert root.body.dofs.position.value[0][1] == pytest.approx(y, abs=1e-10)
        assert root.goal.place.position.value[0] == pytest.approx([0, 0.2 * step, 0])


def test_prefabs_that_are_made_detached():
    root = scene("detached")
    block = root.Modelling.Elastic
    assert block.getName() == "Elastic" and block.middle == [1.0, 0.5, 0.5]
    assert block.totalMass.value == 5.0 and block.mass.totalMass.value == 5.0 and len(block.objects) == 5
    Sofa.Simulation.init(root)
    assert len(block.container.hexahedra.value) == 1
    animate(root, 3)
    assert block.Elastic.marks.position.value[0] == pytest.approx([1.0, 0.5, fall(0.5, 3, 0.1)], abs=1e-9)


def test_forces_are_read():
    root = started("forces_read")
    animate(root, 3)
    for force in root.getObject("Reader").forces:
        assert force == pytest.approx([0, 0, 12 - 30], abs=1e-9)


def test_inactive_nodes_and_engines():
    root = started("deactivated")
    assert root.getObject("engine").double.value == 4.0
    animate(root, 10)
    assert root.body.dofs.position.value[0][0] == pytest.approx(swing(0.5, 0, 4, 1, 0.1, 10), abs=1e-10)


def test_force_field_of_the_scene():
    root = started("own_force")
    animate(root, 20)
    assert root.body.dofs.position.value[0][0] == pytest.approx(swing(0.5, 0, 100, 2, 0.01, 20), abs=1e-9)


def test_a_tree_of_xml(tmp_path):
    file = tmp_path / "scene.scn"
    file.write_text('<Node name="root" gravity="0 0 -10" dt="0.1"><DefaultAnimationLoop/><Node name="body"><EulerImplicitSolver/>'
                    '<CGLinearSolver iterations="10" tolerance="1e-14" threshold="1e-14"/><MechanicalObject name="dofs" position="0 0 1"/>'
                    '<UniformMass totalMass="1"/></Node></Node>')
    root = Sofa.Simulation.load(str(file))
    Sofa.Simulation.init(root)
    animate(root, 5)
    assert root.body.dofs.position.value[0][2] == pytest.approx(fall(1, 5, 0.1), abs=1e-12)


def test_held_nodes_are_put_elsewhere():
    """SOFA's constraints take velocities away; positions that a scene writes stay."""
    root = started("value_kinds")
    dofs, held = root.beam.dofs, root.beam.clamp.indices.value
    start = dofs.position.array()
    with dofs.position.writeable() as positions:
        positions[held] += [0, 0.1, 0]
    animate(root, 2)
    assert dofs.position.value[held] == pytest.approx(start[held] + [0, 0.1, 0], abs=1e-15)


def test_what_a_mapping_places_is_not_written(capsys):
    root = started("links")
    root.body.other.points.position.value = [[7, 7, 7]]
    animate(root, 1)
    assert root.body.other.points.position.value[0] == pytest.approx([1.5, 0.5, 0.5], abs=1e-9)
    assert "a mapping places it" in capsys.readouterr().err


def test_orientations_of_a_few_digits():
    root = started("rigid")
    root.body.frame.position.value = [[0, 0, 0, 0, 0, 0.7, 0.7]]
    assert root.body.frame.position.value[0] == pytest.approx([0, 0, 0, 0, 0, 2 ** -0.5, 2 ** -0.5])


def test_nodes_are_switched_off_in_the_run():
    root = started("switched")
    dofs, start, v, z = root.body.dofs, root.body.dofs.position.array(), 0.0, 0.0
    for step in range(1, 7):
        v += 0.1 * (4 if step <= 3 else 0) / 8  # the load is in the middle: all nodes alike
        z += 0.1 * v
        animate(root, 1)
        assert dofs.position.value - start == pytest.approx(np.tile([0, 0, z], (8, 1)), abs=1e-9), step
    assert len(root.body.fem.vonMisesPerElement.value) == 1 and root.body.fem.vonMisesPerElement.value[0] == pytest.approx(0, abs=1e-6)
    assert root.body.fem.vonMisesPerNode.value == pytest.approx(np.zeros(8), abs=1e-6)


def test_stresses_at_nodes_are_means_over_cells():
    root = started("stressed")
    animate(root, 3)
    fem, cells = root.body.fem, root.body.grid.tetrahedra.array()
    of_cells, of_nodes = fem.vonMisesPerElement.value, fem.vonMisesPerNode.value
    assert len(of_cells) == len(cells) and of_cells.max() > 1
    for node, value in enumerate(of_nodes):
        assert value == pytest.approx(of_cells[(cells == node).any(axis=1)].mean(), rel=1e-12)


def test_controllers_come_and_go():
    root = started("late_controller")
    simulation = root._s_running.sim
    animate(root, 4)
    assert root.starter.late.steps == 2 and root.getObject("late") is None
    assert root._s_running.sim is simulation, "no part of it has changed"


def test_many_episodes():
    root = started("free_fall")
    for _ in range(200):
        Sofa.Simulation.reset(root)
        animate(root, 2)
    assert root.low.dofs.position.value[0][2] == pytest.approx(fall(1, 2, 0.05), abs=1e-12)


def test_what_is_not_there():
    root = scene("free_fall")
    with pytest.raises(AttributeError, match="did you mean 'position'"):
        root.low.dofs.positon
    with pytest.raises(AttributeError, match="no child, object or data"):
        root.middle
    with pytest.raises(KeyError):
        root["low.nothing"]
    assert root.getChild("middle") is None and root.low.getObject("nothing") is None
    with pytest.raises(TypeError):
        root.addObject(3)
    with pytest.raises(TypeError, match="totalMass"):
        root.low.addObject("UniformMass", totalMass={"a": 1})


def test_wrong_sizes_are_refused():
    root = started("writeable")
    with pytest.raises(ValueError, match="numbers for"):
        root.body.dofs.position.value = [1, 2]


# ---- whatever is called ----

VALUES = [None, True, -1, 3.5, float("nan"), "", "abc", "1 2 3", "@/nowhere.x", "@../dofs", [], [1], [1, 2, 3], [[0, 0, 0], [1, 1, 1]],
          [[1, 2], [3]], np.zeros(3), np.zeros((2, 3)), np.ones((45, 3)), np.array([]), np.array([[0, 0, 0, 0, 0, 0, 1.0]]), {}, object(),
          b"x", 10 ** 30, [None]]


def random_call(root, chance):
    """One of the calls of scenes, on anything, with any value."""
    nodes, objects = list(root._s_all_nodes()), list(root._s_all_objects())
    thing, value, node = chance.choice(nodes + objects), chance.choice(VALUES), chance.choice(nodes)
    data = chance.choice(thing.getDataList())
    calls = {
        "assign": lambda: setattr(data, "value", value),
        "attribute": lambda: setattr(thing, data.getName(), value),
        "read": lambda: (data.value, len(data), str(data), data.getValueString(), data.getLinkPath(), data.toList()),
        "item": lambda: data.__setitem__(chance.choice([0, -1, 5, "a", slice(0, 2)]), value),
        "link": lambda: data.setParent(chance.choice(chance.choice(objects).getDataList())),
        "animate": lambda: Sofa.Simulation.animate(root, chance.choice([0, 0.01, -1])),
        "reset": lambda: Sofa.Simulation.reset(root),
        "add": lambda: node.addObject(chance.choice(["MechanicalObject", "UniformMass", "BoxROI", "OglModel", "Nope", 3]),
                                      **{chance.choice(["name", "position", "indices", "src", "template"]): value}),
        "child": lambda: node.addChild(chance.choice(["a", Sofa.Core.Node("n"), chance.choice(nodes), None])),
        "remove": lambda: node.removeObject(chance.choice(objects)),
        "call": lambda: getattr(thing, chance.choice(["getPathName", "init", "getMechanicalState", "getSize", "getNbTriangles", "zzz"]))(),
        "event": lambda: root.sendEvent(value, "x"),
        "path": lambda: root[chance.choice(["body.dofs", "", "..", "body.dofs.position", "@x"])],
    }
    calls[chance.choice(list(calls))]()


@pytest.mark.parametrize("name", ["value_kinds", "links", "driven", "rigid", "two_parents", "detached", "target"])
def test_any_call_ends(name):
    """In an exception of Python, or well: never in a fault of the engine, and never in an endless walk."""
    chance, ended = random.Random(name), {"well": 0, "refused": 0}
    root = started(name)
    for _ in range(80):
        try:
            random_call(root, chance)
            ended["well"] += 1
        except Exception:
            ended["refused"] += 1
    assert min(ended.values()) > 5


def test_cycles_are_refused():
    root = scene("links")
    with pytest.raises(ValueError, match="cannot be its child"):
        root.body.other.addChild(root.body)
    first, second = root.body.roi.indices, root.body.clamp.indices
    with pytest.raises(ValueError, match="takes its own from there"):
        first.setParent(second)


def test_every_scene_has_a_test():
    with open(__file__, encoding="utf-8") as file:
        text = file.read()
    for other in ("test_command.py", "test_public.py", "test_ways.py", "test_linked.py"):
        with open(SCENES.parent / other, encoding="utf-8") as file:
            text += file.read()
    parts = ("parts_of_scene", "params", "FingerController", "helper_of_two")
    named = [each.stem for each in SCENES.glob("*.py") if each.stem not in parts]
    assert len(named) >= 60
    assert [name for name in named if not re.search(rf"\b{name}\b", text)] == []


def test_compiled_modules_beside_a_scene_are_found(folder, monkeypatch):
    (folder / "scene.py").write_text("def createScene(root):\n    pass\n")
    (folder / f"beside{importlib.machinery.EXTENSION_SUFFIXES[0]}").write_bytes(b"")
    monkeypatch.syspath_prepend(folder)
    Sofa.Simulation.load(str(folder / "scene.py"))
    hooks = len(sys.path_hooks)
    Sofa.Simulation.load(str(folder / "scene.py"))
    assert importlib.util.find_spec("beside") is not None and len(sys.path_hooks) == hooks


def drawn_root():
    """A grid and a turning frame fall freely, with visual models that follow by three kinds of mapping."""
    root = Sofa.Core.Node("root")
    root.gravity = [0, 0, -10]
    soft, frame = root.addChild("soft"), root.addChild("frame")
    for node in (soft, frame):
        node.addObject("EulerImplicitSolver")
        node.addObject("CGLinearSolver", iterations=20, tolerance=1e-14, threshold=1e-14)
    soft.addObject("RegularGridTopology", n=[2, 2, 2], min=[0, 0, 0], max=[1, 1, 1])
    soft.addObject("MechanicalObject", name="dofs")
    frame.addObject("MechanicalObject", name="dofs", template="Rigid3", position=[0, 0, 5, 0, 0, 0, 1], velocity=[0, 0, 0, 0, 0, 2])
    for node in (soft, frame):
        node.addObject("UniformMass", totalMass=1)
    shown = [(soft, "inside", "BarycentricMapping", {"position": [[0.5, 0.25, 0.5]], "translation": [0.1, 0, 0]}),
             (soft, "same", "IdentityMapping", {}), (frame, "turned", "RigidMapping", {"position": [[1, 0, 0]]})]
    for node, name, mapping, values in shown:
        child = node.addChild(name)
        child.addObject("OglModel", name="shown", **values)
        child.addObject(mapping)
    return root


def test_visual_models_are_where_their_mappings_place_them(capsys):
    """z = z_0 + fall; a frame that turns about z carries its point round."""
    root = drawn_root()
    Sofa.Simulation.init(root)
    animate(root, 5)
    z = fall(0, 5, 0.01)
    assert root.soft.inside.shown.position.value.tolist() == [pytest.approx([0.6, 0.25, 0.5 + z], abs=1e-9)]
    assert root.soft.same.shown.position.value == pytest.approx(root.soft.dofs.position.value, abs=1e-12)
    assert root.frame.turned.shown.position.value.tolist() == [pytest.approx([np.cos(0.1), np.sin(0.1), 5 + z], abs=1e-4)]
    animate(root, 1)
    assert root.soft.inside.shown.position.value[0][2] == pytest.approx(0.5 + fall(0, 6, 0.01), abs=1e-9), "not as it was read first"
    Sofa.Simulation.reset(root)
    assert root.soft.inside.shown.position.value[0][2] == pytest.approx(0.5, abs=1e-12)
    assert "not computed here" not in capsys.readouterr().err


def test_a_visual_model_of_a_node_that_is_switched_off_stays():
    root = drawn_root()
    Sofa.Simulation.init(root)
    animate(root, 5)
    root.soft.activated = False
    animate(root, 5)
    assert root.soft.inside.shown.position.value[0] == pytest.approx([0.6, 0.25, 0.5 + fall(0, 5, 0.01)], abs=1e-9)
    assert root.frame.turned.shown.position.value[0][2] == pytest.approx(5 + fall(0, 10, 0.01), abs=1e-9)


def test_a_visual_model_that_reads_a_file_says_that_it_stays(capsys):
    root = drawn_root()
    shown = root.soft.inside.addChild("of_file").addObject("OglModel", filename="mesh/finger.stl")
    Sofa.Simulation.init(root)
    animate(root, 1)
    assert len(shown.position.value) == 0 and "is read, and not computed here" in capsys.readouterr().err
    assert len(root.soft.inside.shown.position.value) == 1


def test_a_visual_model_has_what_its_source_gives_before_init(folder):
    """SOFA links its data to those of the loader as it is made; what translation does to them comes with init."""
    (folder / "tetrahedron.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 2 0\nv 0 0 3\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
    root = drawn_root()
    child = root.frame.addChild("of_loader")
    loader = child.addObject("MeshOBJLoader", name="loader", filename=str(folder / "tetrahedron.obj"))
    shown = child.addObject("OglModel", name="shown", src="@loader", translation=[0, 0, 1])
    child.addObject("RigidMapping")
    places = loader.position.value
    assert len(places) == 4 and shown.position.value.tolist() == places.tolist()
    assert shown.triangles.value.tolist() == loader.triangles.value.tolist() and len(shown.quads.value) == 0
    own = child.addObject("OglModel", name="own", src=loader, position=[[1, 2, 3]])
    assert own.position.value.tolist() == [[1, 2, 3]] and len(own.triangles.value) == len(loader.triangles.value)
    child.removeObject(own)
    Sofa.Simulation.init(root)
    assert shown.position.value == pytest.approx(places + [0, 0, 6], abs=1e-9)
    assert shown.triangles.value.tolist() == loader.triangles.value.tolist()


def test_boxes_of_nodes_and_states():
    """What a scene writes counts until it runs; then the box is that of the places, which fall. Angles and strains are none."""
    root = drawn_root()
    root.addObject("MechanicalObject", name="strains", template="Vec1", position=[[100.0]])
    assert root.soft.bbox.value.tolist() == [[0, 0, 0], [1, 1, 1]] and root.frame.bbox.getMax() == [0, 0, 5]
    root.bbox = [[-9, -9, -9], [9, 9, 9]]
    assert root.bbox.value.tolist() == [[-9, -9, -9], [9, 9, 9]] and root.bbox.getCenter() == [0, 0, 0]
    Sofa.Simulation.init(root)
    animate(root, 5)
    z = fall(0, 5, 0.01)
    assert root.soft.bbox.getMin() == pytest.approx([0, 0, z], abs=1e-9)
    assert root.soft.dofs.bbox.value[1] == pytest.approx([1, 1, 1 + z], abs=1e-9)
    assert root.bbox.getMax() == pytest.approx([1, 1, 5 + z], abs=1e-9)
    assert root.soft.inside.shown.bbox.value[0] == pytest.approx([0.6, 0.25, 0.5 + z], abs=1e-9)
    assert Sofa.Core.Node("empty").bbox.value is None
