# SPDX-License-Identifier: LGPL-2.1-or-later
"""createScene() files of many years and hands: ways to say what others say otherwise. Many check themselves against closed forms in
their controllers, where what they assert ends the run; test_numbers.py has numbers of the others."""
import os
import re
import subprocess
import sys

import numpy as np
import pytest
import Sofa
from playing import PATIENCE, SCENES, animate, run, run_many, runs_ten_steps, started, tells_all_that_is_missing

RUNS = ["tutorial_floor", "contact_forces", "liver_keys", "cube_prefab", "cosserat_beam", "cosserat_controller", "tripod", "gym_cartpole",
        "gym_loop", "topology_read", "hand_loop", "finger_steps", "tentacle", "pneumatic_pid", "gripper_cube", "motors_keytimes",
        "ties_and_attachments", "cloth_floor", "old_python_script", "old_names", "paths_and_params", "plain_helpers", "rigid_joystick",
        "matrices_asked", "spring_force_python", "threads_and_waits", "everything_drawn", "deformed_by_engines", "instances_everywhere",
        "script_events", "typed_scene", "fit_by_scipy", "worker_threads", "sparse_grid", "introspection", "time_json", "static_load",
        "sliding_old_names", "class_of_scene", "moving_target", "arm_of_python2", "beam_argparse", "robot_class", "env_inside",
        "two_materials", "calls_of_libraries", "joints_kinematics", "pid_data", "springs_in_python", "spline_follow", "state_machine",
        "hexa_loops"]
LACKS = {"missing_many": ["softrobots.inverse", "SofaCUDA_of_nobody", "pyDOE_of_nobody", "QPInverseProblemSolver",
                          "AsyncSparseLDLSolverOfNobody", "PositionEffector", "CableActuator"]}


@pytest.mark.parametrize("name", RUNS)
def test_runs_ten_steps(name, folder):
    assert "changes its tree" not in runs_ten_steps(name, folder), "no controller of these makes a new engine"


@pytest.mark.parametrize("name", LACKS)
def test_all_that_is_missing_is_one_message(name, folder):
    tells_all_that_is_missing(name, LACKS[name], folder)


@pytest.mark.parametrize("name", RUNS[::4] + list(LACKS))
def test_checked_by_the_command(name, folder):
    """It may warn, and never ends otherwise than with a sentence."""
    done = run_many("check", SCENES / f"{name}.py", folder=folder)
    assert done.returncode == (2 if name in LACKS else 0) and "Traceback" not in done.stderr, done.stderr


def falling(node, name, **values):
    node.addObject("EulerExplicitSolver")
    state = node.addObject("MechanicalObject", name=name, **values)
    node.addObject("UniformMass", totalMass=1)
    return state


def test_links_by_names_with_blanks(capsys):
    """One, several, of data, relative and absolute, with numbers behind them: they lead where they lead without blanks."""
    root = Sofa.Core.Node("root")
    root.addObject("DefaultAnimationLoop")
    body = root.addChild("my body")
    state = falling(body, "my dofs", position=[[0, 0, 0], [1, 0, 0]])
    rider = body.addChild("a rider")
    rider.addObject("MechanicalObject", name="its dofs", position="@../my dofs.position")
    mapping = rider.addObject("IdentityMapping", input="@../my dofs", output="@its dofs")
    assert state.getLinkPath() == "@/my body/my dofs" and mapping.findData("input").getLinkedBase() is state
    assert mapping.findData("output").getLinkedBase() is rider.getObject("its dofs")
    two = root.addChild("two")
    springs = two.addObject("SpringForceField", object1="@/my body/my dofs", object2=state.getLinkPath(), spring=[0, 1, 0.0, 0.0, 1.0])
    data = root.addData("lists", value="@/my body/my dofs.position", type="string")
    assert data.getParent() is state.position and springs.findData("object2").getLinkedBase() is state
    assert root._s_linked("@/my body/my dofs.position 3") is None
    Sofa.Simulation.init(root)
    animate(root, 3)
    fall = -9.81 * 1e-4 * 6
    assert state.position.value[:, 1] == pytest.approx([fall, fall]), "three steps of symplectic Euler"
    assert np.array_equal(rider.getObject("its dofs").position.value, state.position.value)
    assert "leads nowhere" not in capsys.readouterr().err


def test_a_contact_listener_of_names_with_blanks():
    root = Sofa.Core.Node("root")
    body = root.addChild("my body")
    body.addObject("MechanicalObject", name="mo", position=[[0, 0, 0]])
    model = body.addObject("PointCollisionModel", name="my points")
    listener = root.addObject("ContactListener", collisionModel1="@my body/my points", collisionModel2="@/my body/my points")
    assert listener._s_model("collisionModel1") is model is listener._s_model("collisionModel2")


@pytest.mark.parametrize("where", ["here", "below"])
def test_rows_of_forces_are_those_of_the_state(where):
    """Without a template: of frames six numbers, as SOFA has it from the state; a moment turns what it turns."""
    root = Sofa.Core.Node("root")
    root.gravity = [0, 0, 0]
    root.addObject("DefaultAnimationLoop")
    body = root.addChild("body")
    body.addObject("EulerExplicitSolver")
    state = body.addObject("MechanicalObject", template="Rigid3", position=[[0, 0, 0, 0, 0, 0, 1], [1, 0, 0, 0, 0, 0, 1]])
    body.addObject("UniformMass", vertexMass="2 1 1 0 0 0 1 0 0 0 1")
    node = body if where == "here" else body.addChild("below")
    load = node.addObject("ConstantForceField", indices=[0, 1], forces=[[4, 0, 0, 0, 0, 0], [0, 0, 0, 0, 0, 3]],
                          **({} if where == "here" else {"mstate": state.getLinkPath()}))
    assert load.forces.value.shape == (2, 6)
    load.forces[1][5] = 6.0
    Sofa.Simulation.init(root)
    assert load.forces.value.tolist() == [[4, 0, 0, 0, 0, 0], [0, 0, 0, 0, 0, 6]]
    animate(root, 1)
    assert state.velocity.value == pytest.approx(np.array([[0.02, 0, 0, 0, 0, 0], [0, 0, 0, 0, 0, 0.03]]))
    points = root.addChild("points")
    points.addObject("MechanicalObject")
    assert points.addObject("ConstantForceField").forces.value.shape == (0, 3)


def test_a_cavity_comes_to_its_target():
    """The pressure that the controller has found grows while the effector is below its target, and swells the cavity."""
    root = started("pneumatic_pid")
    animate(root, 10)
    cavity = root.body.cavity.SurfacePressureConstraint
    assert root.body.effector.MechanicalObject.position.value[0][1] < 21 and (np.diff(root.controller.pressures) > 0).all()
    assert cavity.cavityVolume.value > cavity.initialCavityVolume.value and cavity.pressure.value > 0


def test_nodes_in_with_blocks():
    """A tree as indented blocks; what is raised within one comes out."""
    root = Sofa.Core.Node("root")
    with root.addChild("a") as a:
        with a.addChild("b") as b:
            b.addObject(Sofa.Components.RegularGridTopology, name="grid", n=[2, 2, 2], min=[0, 0, 0], max=[1, 1, 1])
            roi = b.addObject("BoxROI", name="low", box=[[-1, -1, -1], [0.5, 2, 2]], position=b.grid.position)
    assert root.a.b is b and sorted(roi.indices.value.tolist() + roi.indicesOut.value.tolist()) == list(range(8))
    assert roi.pointsInROI.value.shape == roi.pointsOutROI.value.shape == (4, 3)
    with pytest.raises(KeyError):
        with root.addChild("c"):
            raise KeyError("out")


def test_another_scene_is_imported(folder, capsys):
    """Beside the scene, wherever the program runs; what is none says so."""
    (folder / "part.py").write_text("def createScene(node):\n    node.addObject('MechanicalObject', name='dofs')\n")
    root = Sofa.Core.Node("root")
    Sofa.import_sofa_python_scene("part.py").createScene(root.addChild("part"))
    assert root.part.dofs.getClassName() == "MechanicalObject"
    (folder / "none.py").write_text("x = 1\n")
    with pytest.raises(RuntimeError, match=r"none.py:1: error: there is no function createScene"):
        Sofa.import_sofa_python_scene("none.py")
    with pytest.raises(FileNotFoundError, match="nothing.py"):
        Sofa.import_sofa_python_scene("nothing.py")
    try:
        raise ValueError("told")
    except ValueError as error:
        Sofa.sendMessageFromException(error)
    assert "told" in capsys.readouterr().err and Sofa.getPythonCallingPoint()[0] == __file__ and "test_ways.py" in Sofa.getStackForSofa()


def test_timers_say_that_they_measure_nothing():
    import SofaRuntime

    SofaRuntime.Timer.setEnabled("Animate", True)
    records = SofaRuntime.Timer.getRecords("Animate")
    assert len(records) == 0 and records.get("solve") is None
    with pytest.raises(KeyError, match="SOFA's timers measure nothing here"):
        records["solve"]


FALLBACK = """
def createScene(root):
    root.addObject("DefaultAnimationLoop")
    for name in ("ParallelThingOfNobody", "MeshTopology"):
        try:
            found = root.addObject(name, name="first")
            break
        except {caught}:
            print("without", name)
    assert found.getClassName() == "MeshTopology"
"""


@pytest.mark.parametrize("caught, runs", [("ValueError as error", True), ("Exception", True), ("(KeyError, ValueError)", True),
                                          ("KeyError", False)])
def test_a_scene_that_has_another_answer_to_a_missing_component(folder, caught, runs):
    """As in SOFA a ValueError, where the scene catches it; else it is told with all that is missing."""
    (folder / "scene.py").write_text(FALLBACK.format(caught=caught))
    done = run("run", "scene.py", "-n", 2, "--no-record", folder=folder)
    assert (done.returncode == 0) == runs and ("without ParallelThingOfNobody" in done.stdout) == runs, done.stderr
    for done in (done, run("check", "scene.py", folder=folder)):
        assert re.search(("scene.py:6: .*" if runs else "") + "there is no component 'ParallelThingOfNobody'", done.stderr)


NO_ANSWERS = {"all of it": """
    try:
        root.addObject("DefaultAnimationLoop")
        n = root.addChild("n")
        n.addObject("MeshTopology")
        n.addObject("ShellOfNobody")
        n.addObject("MechanicalObject")
    except Exception:
        root.addObject("MeshTopology")
""", "nothing instead": """
    try:
        root.addObject("ShellOfNobody")
    except ValueError:
        pass
""", "on it goes": """
    try:
        root.addObject("ShellOfNobody")
    except Exception as error:
        root.addObject("MeshTopology")
        raise
"""}


@pytest.mark.parametrize("how", NO_ANSWERS)
def test_a_scene_that_would_go_on_without_a_part_is_not_run(folder, how):
    """It catches, and has nothing for what is missing: that would be other physics in silence."""
    (folder / "scene.py").write_text("def createScene(root):" + NO_ANSWERS[how])
    for words in (("run", "scene.py", "-n", 2, "--no-record"), ("check", "scene.py")):
        done = run(*words, folder=folder)
        assert done.returncode == 2 and "there is no component 'ShellOfNobody'" in done.stderr, done.stderr


def test_edges_and_sides_that_a_topology_is_asked_for():
    """SOFA makes them of the cells: two tetrahedra with a side in common have 9 edges and 7 sides. Those of a grid are as a link to
    its edges has them: a cube of 27 has 108 sides, and beside its 144 edges a diagonal in each."""
    root = Sofa.Core.Node("root")
    pair = root.addObject("TetrahedronSetTopologyContainer", position=[[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]],
                          tetrahedra=[[0, 1, 2, 3], [1, 4, 2, 3]])
    assert (pair.getNbEdges(), pair.getNbTriangles(), pair.getNbTetrahedra()) == (9, 7, 2)
    assert pair.getTetrahedron(1) == [1, 4, 2, 3] and pair.getLocalEdgesInTetrahedron(3) == [1, 2]
    edges = [pair.getEdge(i) for i in pair.getEdgesInTetrahedron(1)]
    assert edges == [[1, 4], [1, 2], [1, 3], [2, 4], [3, 4], [2, 3]]
    cube = root.addChild("cube").addObject("RegularGridTopology", n=[4, 4, 4], min=[0, 0, 0], max=[1, 1, 1])
    assert (cube.getNbEdges(), cube.getNbQuads(), cube.getNbHexahedra()) == (144 + 108, 108, 27)
    both = root.addChild("both").addObject("MeshTopology", position=[[i & 1, i >> 1 & 1, i >> 2] for i in range(8)], quads=[[0, 1, 3, 2]],
                                           hexahedra=[[0, 1, 3, 2, 4, 5, 7, 6]])
    assert (both.getNbEdges(), both.getNbQuads()) == (12, 1) and both.getEdge(1) == [0, 2]
    given = root.addChild("given").addObject("MeshTopology", position=[[0, 0, 0], [1, 0, 0], [0, 1, 0]], edges=[[2, 0]], triangles=[[0, 1, 2]])
    assert given.getNbEdges() == 1 and given.getEdge(0) == [2, 0] and given.getNbQuads() == 0


def test_names_that_are_completed():
    """Data of objects, and what is in a node, as editors ask for them."""
    root = Sofa.Core.Node("root")
    body = root.addChild("body")
    state = body.addObject("MechanicalObject", name="dofs")
    body.addObject("UniformMass", name="no identifier")
    assert {"body", "gravity", "addObject"} <= set(dir(root)) and {"dofs", "dt"} <= set(dir(body)) and "no identifier" not in dir(body)
    assert {"position", "velocity", "getLinkPath"} <= set(dir(state))
    assert state.addData("mine", value=1) is state.mine and "mine" in dir(state)


@pytest.mark.parametrize("head, whole", [("", True), ("from __future__ import division\n", False)])
def test_python_2_divides_whole_numbers_as_there(head, whole):
    from Sofa import _python_2

    text = head + """print "of before"
class Grid:
    half = 7 / 2
    def __init__(self, n): self.n = n; self.n /= 2
rows, parts = np.arange(6), [9, 9.0]
kept, rows = rows / 4, rows / 4.0
parts[0] /= -2; parts[1] /= 2
found = (Grid.half, -7 / 2, 7 / 2.0, 7 // 2, Grid(5).n, list(kept), list(rows[:2]), parts, 1 / 2 * 3)
"""
    space = {"np": np}
    exec(_python_2.compiled(text.encode(), "old.py"), space)
    if whole:
        assert space["found"] == (3, -4, 3.5, 3, 2, [0, 0, 0, 0, 1, 1], [0, 0.25], [-5, 4.5], 0)
    else:
        assert space["found"] == (3.5, -3.5, 3.5, 3, 2.5, [0, 0.25, 0.5, 0.75, 1, 1.25], [0, 0.25], [-4.5, 4.5], 1.5)


def test_a_step_of_no_length_is_told(capsys):
    root = Sofa.Core.Node("root")
    root.addObject("DefaultAnimationLoop")
    falling(root, "mo", position=[0, 0, 0])
    root.dt = 0.25
    for dt in (-0.1, float("nan"), 0):
        Sofa.Simulation.animate(root, dt)
    told = capsys.readouterr().err
    assert told.count("a step of the root's dt is made, 0.25") == 2 and root.time.value == 0.75, told


def falling_body(root):
    body = root.addChild("body")
    falling(body, "dofs", position=[[0, 0, 0]])
    return body


class Follower(Sofa.Core.DataEngine):
    """Twice its input."""

    def __init__(self, *arguments, **values):
        Sofa.Core.DataEngine.__init__(self, *arguments, **values)
        self.addData("x", type="vector<Vec3d>", value=values.get("x", [[0, 0, 0]]))
        self.addData("y", type="vector<Vec3d>", value=[[0, 0, 0]])
        self.addInput(self.x)
        self.addOutput(self.y)

    def update(self):
        self.y.value = 2 * np.array(self.x.value)


def test_engines_follow_what_steps_change():
    """By the path of data, by data, and an engine that follows an engine."""
    root = Sofa.Core.Node("root")
    body = falling_body(root)
    by_path = root.addObject(Follower(name="by_path", x=body.dofs.position.getLinkPath()))
    by_data = root.addObject(Follower(name="by_data", x=body.dofs.position))
    second = root.addObject(Follower(name="second", x=by_path.y.getLinkPath()))
    Sofa.Simulation.init(root)
    for _ in range(3):
        animate(root, 1)
        now = body.dofs.position.array()
        assert (by_path.y.array() == 2 * now).all() and (by_data.y.array() == 2 * now).all() and (second.y.array() == 4 * now).all()
    body.dofs.position.value = [[7, 0, 0]]
    assert by_path.y.array().tolist() == [[14, 0, 0]]


def test_a_reset_leads_to_where_the_scene_was_placed():
    """As SOFA, which keeps what a reset leads to when it has told that the scene is initialised."""

    class Placing(Sofa.Core.Controller):
        def onSimulationInitDoneEvent(self, event):
            with self.getContext().dofs.position.writeableArray() as position:
                position[0] = [5, 0, 0]

    root = Sofa.Core.Node("root")
    body = falling_body(root)
    body.addObject(Placing(name="placing"))
    Sofa.Simulation.init(root)
    animate(root, 3)
    first = body.dofs.position.array()
    Sofa.Simulation.reset(root)
    assert body.dofs.position.array().tolist() == [[5, 0, 0]]
    animate(root, 3)
    assert (body.dofs.position.array() == first).all(), "the same bits"


def test_a_controller_may_have_a_reset_of_its_own():
    """Environments for learning do: SOFA calls none of SofaPython 3's classes."""

    class Environment(Sofa.Core.Controller):
        episodes = 0

        def reset(self):
            self.episodes += 1
            Sofa.Simulation.reset(self.getContext().getRoot())

    root = Sofa.Core.Node("root")
    body = falling_body(root)
    environment = body.addObject(Environment(name="environment"))
    Sofa.Simulation.init(root)
    animate(root, 1)
    environment.reset()
    assert environment.episodes == 1 and root.time.value == 0


def test_a_program_is_told_what_takes_the_place_of_a_component():
    """The sentence of `stroma check`."""
    root = Sofa.Core.Node("root")
    falling_body(root).addObject("QPSlidingConstraint", name="sliding")
    with pytest.raises(RuntimeError, match="there is no component 'QPSlidingConstraint' .*plug-in Cosserat there are Discrete.*Sliding"):
        Sofa.Simulation.init(root)


@pytest.mark.parametrize("given, told", [("Rigid3", "Rigid3d"), ("Rigid3d", "Rigid3d"), ("Vec3", "Vec3d"), ("Rigid", "Rigid3d"),
                                         (None, "Vec3d")])
def test_templates_have_the_names_that_sofa_tells(given, told):
    """Scenes ask whether a state `is "Rigid3d"`; a force field has the template of its state, a mapping both of its own."""
    node = Sofa.Core.Node("root").addChild("body")
    state = node.addObject("MechanicalObject", template=given)
    assert state.getTemplateName() == told
    state.position = [0, 0, 5, 0, 0, 0, 1] if told == "Rigid3d" else [0, 0, 5]
    assert len(state.position.value) == 1, "a row of the template's columns"
    assert node.addObject("RestShapeSpringsForceField").getTemplateName() == told
    assert node.addObject("RigidMapping", template="Rigid3,Vec3").getTemplateName() == "Rigid3d,Vec3d"
    assert node.addObject(Sofa.Core.Controller(name="keys")).getTemplateName() == ""


def test_a_program_reads_files_of_the_current_folder(tmp_path):
    """It may lie elsewhere: SOFA looks where the program was started, and so does a program that changes its folder."""
    (tmp_path / "programs").mkdir()
    (tmp_path / "data" / "mesh").mkdir(parents=True)
    (tmp_path / "data" / "mesh" / "one.obj").write_text("v 0 0 0\nv 2 0 0\nv 0 3 0\nf 1 2 3\n")
    for first in ("", f"import os; os.chdir({str(tmp_path / 'data')!r})\n"):
        program = tmp_path / "programs" / "run.py"
        program.write_text(f"""{first}import Sofa
root = Sofa.Core.Node("root")
loader = root.addObject("MeshOBJLoader", name="l", filename="mesh/one.obj")
print(len(loader.position.value))
root.addObject("EulerImplicitSolver")
root.addObject("CGLinearSolver", iterations=5, tolerance=1e-9, threshold=1e-9)
dofs = root.addObject("MechanicalObject", position="@l.position")
root.addObject("UniformMass", totalMass=1)
Sofa.Simulation.init(root)
print(len(dofs.position.value))
""")
        done = subprocess.run([sys.executable, str(program)], capture_output=True, text=True, cwd=tmp_path if first else tmp_path / "data",
                              env=dict(os.environ), timeout=PATIENCE)
        assert done.stdout.split() == ["3", "3"], done.stderr


def test_a_program_that_changes_its_folder_reads_there(tmp_path):
    """Files of one name in two folders: each load has that of the folder the program is in, and none leaves a folder behind."""
    for folder, last in (("a", ""), ("b", "v 2 3 0\n")):
        (tmp_path / folder / "mesh").mkdir(parents=True)
        (tmp_path / folder / "mesh" / "one.obj").write_text(f"v 0 0 0\nv 2 0 0\nv 0 3 0\n{last}f 1 2 3\n")
    (tmp_path / "run.py").write_text("""
import os, sys, Sofa, SofaRuntime

def load():
    root = Sofa.Core.Node("root")
    loader = root.addObject("MeshOBJLoader", name="l", filename="mesh/one.obj")
    root.addObject("EulerImplicitSolver")
    root.addObject("CGLinearSolver", iterations=5, tolerance=1e-9, threshold=1e-9)
    dofs = root.addObject("MechanicalObject", position="@l.position")
    root.addObject("UniformMass", totalMass=1)
    Sofa.Simulation.init(root)
    return len(loader.position.value), len(dofs.position.value)

for folder in "aba":
    os.chdir(os.path.join(sys.argv[1], folder))
    print(*load())
print(os.environ["STROMA_DATA_PATH"].count(sys.argv[1]))
SofaRuntime.DataRepository.addFirstPath(os.path.join(sys.argv[1], "b"))  # of the user: it stays, and comes first
print(*load())
os.chdir(os.path.join(sys.argv[1], "b"))
print(*load())
os.chdir(sys.argv[1])
print(*load())
""")
    done = subprocess.run([sys.executable, str(tmp_path / "run.py"), str(tmp_path)], capture_output=True, text=True, cwd=tmp_path,
                          env=dict(os.environ), timeout=PATIENCE)
    assert done.stdout.split("\n")[:-1] == ["3 3", "4 4", "3 3", "1", "4 4", "4 4", "4 4"], done.stdout + done.stderr


class Row(Sofa.Prefab):
    prefabParameters = [{"name": "count", "type": "int", "help": "of nodes", "default": 3},
                        {"name": "place", "type": "Vec3d", "help": "of all", "default": [0.0, 0.0, 0.0]}]

    def init(self):
        for number in range(self.count.value):
            self.addChild(f"part{number}").addObject("MechanicalObject", name="state", position=[self.place.value])


def test_a_prefab_follows_the_data_that_give_its_parameters():
    root = Sofa.Core.Node("root")
    root.addData("many", type="int", value=2)
    row = root.addChild(Row("row", count=root.many, place=[1, 2, 3]))
    assert len(row.children) == 2 and row.part1.state.position.value.tolist() == [[1, 2, 3]]
    root.many.value = 4
    assert len(row.children) == 4
    row.count.value = 1
    assert len(row.children) == 1
    row.count.setParent(root.many)
    assert len(row.children) == 4


def test_a_wrong_argument_of_a_prefab_is_told(capfd):
    Row(name="row", cuont=4)
    assert "Row has no parameter 'cuont'; did you mean 'count'?" in capfd.readouterr().err
    with pytest.raises(ValueError, match="'many' is no int"):
        Row(name="row", count="many")
