# SPDX-License-Identifier: LGPL-2.1-or-later
"""Points and cells that a controller takes away or adds while a scene runs."""
import os
import sys

import numpy as np
import pytest
import Sofa
from playing import COMMAND, HERE, animate, run

sys.path.insert(0, str(HERE.parents[1] / "view"))  # pages that need no browser

#: three tetrahedra in a row; the last one has a point of its own
POSITION = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1], [2, 1, 1]]
CELLS = [[0, 1, 2, 3], [1, 2, 3, 4], [1, 2, 4, 5]]


class Each(Sofa.Core.Controller):
    def __init__(self, begin=None, end=None, **values):
        super().__init__(**values)
        self.begin, self.end, self.step = begin, end, 0

    def onAnimateBeginEvent(self, event):
        self.step += 1
        if self.begin:
            self.begin(self.step)

    def onAnimateEndEvent(self, event):
        if self.end:
            self.end(self.step)


def body(root, position=POSITION, cells=CELLS):
    node = root.addChild("body")
    node.addObject("EulerImplicitSolver", rayleighMass=0.1)
    node.addObject("SparseLDLSolver")
    node.addObject("TetrahedronSetTopologyContainer", name="mesh", position=position, tetrahedra=cells)
    node.addObject("TetrahedronSetTopologyModifier", name="modifier")
    node.addObject("MechanicalObject", name="state")
    node.addObject("MeshMatrixMass", massDensity=100)
    node.addObject("FixedProjectiveConstraint", name="fixed", indices=[0, 1, 2])
    node.addObject("TetrahedronFEMForceField", youngModulus=1e5, poissonRatio=0.3, method="large")
    return node


def scene(**options):
    root = Sofa.Core.Node("root")
    root.dt = 0.01
    return root, body(root, **options)


def test_a_point_goes_with_its_last_cell_as_by_a_component_of_the_scene():
    """To the bit what a TopologicalChangeProcessor makes of it in the same step."""
    root, node = scene()
    node.addObject("TopologicalChangeProcessor", useDataInputs=True, timeToRemove=0.025, tetrahedraToRemove=[1])
    Sofa.Simulation.init(root)
    animate(root, 6)
    reference = node.state.position.value
    root, node = scene()
    counts = []

    def begin(step):
        if step == 4:
            node.modifier.removeTetrahedra([1], True)
            counts.append((node.mesh.getNbTetrahedra(), node.mesh.getNbPoints(), len(node.state.position.value), len(node.state.velocity.value)))
    root.addObject(Each(begin))
    Sofa.Simulation.init(root)
    animate(root, 6)
    assert len(reference) == 6 and counts == [(2, 6, 6, 6)], "all points have other cells"
    assert np.array_equal(node.state.position.value, reference)
    root, node = scene()
    node.addObject("TopologicalChangeProcessor", useDataInputs=True, timeToRemove=0.025, tetrahedraToRemove=[2])
    Sofa.Simulation.init(root)
    animate(root, 6)
    reference = node.state.position.value
    root, node = scene()
    node.addObject("BoxROI", name="region", box=[-1, -1, -1, 5, 5, 5])

    def last(step):
        if step == 4:
            node.modifier.removeTetrahedra(np.array([2]))
            counts.append((node.mesh.getNbTetrahedra(), node.mesh.getNbPoints(), len(node.state.position.value)))
    root.addObject(Each(last))
    Sofa.Simulation.init(root)
    animate(root, 6)
    assert counts[-1] == (2, 5, 5) and np.array_equal(node.state.position.value, reference)
    assert node.state.rest_position.value.tolist() == POSITION[:5] and node.mesh.tetrahedra.value.tolist() == CELLS[:2]
    Sofa.Simulation.reset(root)
    assert len(node.state.position.value) == 6 and node.mesh.getNbTetrahedra() == 3, "back to the start, with all cells"


def test_cells_go_on_after_points_have_gone():
    root, node = scene()
    log = []

    def begin(step):
        if step == 2:
            node.modifier.removeTetrahedra([2])
        if step == 3:
            node.modifier.removeTetrahedra([1])
        if step == 4:
            node.modifier.addTetrahedra([[0, 1, 2, 3]])
        log.append((node.mesh.getNbTetrahedra(), len(node.state.position.value)))
    root.addObject(Each(begin))
    Sofa.Simulation.init(root)
    animate(root, 4)
    assert log == [(3, 6), (2, 5), (1, 4), (2, 4)]
    root.addChild("later").addObject("MechanicalObject", position=[[0, 0, 0]])
    with pytest.raises(RuntimeError, match="meshes have changed in the run"):
        animate(root, 1)


def test_a_grid_that_is_cut_into_tetrahedra_loses_them_one_after_the_other():
    root = Sofa.Core.Node("root")
    root.dt = 0.01
    node = root.addChild("body")
    node.addObject("EulerImplicitSolver")
    node.addObject("SparseLDLSolver")
    node.addObject("RegularGridTopology", name="grid", n=[5, 2, 2], min=[0, 0, 0], max=[4, 1, 1])
    node.addObject("TetrahedronSetTopologyContainer", name="mesh", position="@grid.position")
    node.addObject("TetrahedronSetTopologyModifier", name="modifier")
    node.addObject("Hexa2TetraTopologicalMapping", input="@grid", output="@mesh")
    node.addObject("MechanicalObject", name="state")
    node.addObject("DiagonalMass", massDensity=1)
    node.addObject("BoxROI", name="region", box=[-0.1, -1, -1, 0.1, 2, 2])
    node.addObject("FixedProjectiveConstraint", indices="@region.indices")
    node.addObject("TetrahedronFEMForceField", youngModulus=1e4, poissonRatio=0.3)
    seen = []

    def begin(step):
        places, cells = np.array(node.state.position.value), np.array(node.mesh.tetrahedra.value)
        if step in (2, 4, 5):
            node.modifier.removeTetrahedra(np.flatnonzero(places[cells].mean(axis=1)[:, 0] > 4.5 - 0.7 * step))
        seen.append((node.mesh.getNbTetrahedra(), len(node.state.position.value)))
    root.addObject(Each(begin))
    Sofa.Simulation.init(root)
    animate(root, 6)
    assert seen == sorted(seen, reverse=True) and len(set(seen)) == 4 and np.isfinite(node.state.position.value).all()
    assert node.mesh.tetrahedra.value.max() == len(node.state.position.value) - 1


def test_lists_of_points_follow():
    root, node = scene()
    node.fixed.indices = [5, 0, 1, 2]
    load = node.addObject("ConstantForceField", indices=[3, 5], forces=[[0, 1, 0], [0, 2, 0]])
    root.addObject(Each(lambda step: step == 2 and node.modifier.removeTetrahedra([2])))
    Sofa.Simulation.init(root)
    animate(root, 3)
    assert sorted(node.fixed.indices.value.tolist()) == [0, 1, 2]
    assert load.indices.value.tolist() == [3] and load.forces.value.ravel().tolist() == [0, 1, 0]


def loose_points(root):
    root.gravity = [0, -9.81, 0]
    mesh = root.addObject("PointSetTopologyContainer", name="mesh", position=[[0, 0, 0], [1, 0, 0]])
    modifier = root.addObject("PointSetTopologyModifier", name="modifier")
    return mesh, modifier, root.addObject("MechanicalObject", name="state", template="Vec3d")


def test_points_come_and_are_placed():
    root = Sofa.Core.Node("root")
    mesh, modifier, state = loose_points(root)
    seen = []

    def begin(step):
        if step == 2:
            modifier.addPoints(3, True)
            seen.append(state.position.value[2:].tolist())
            with state.position.writeable() as x:
                for i in range(len(x)):
                    x[i] = [i, 0, 2]
        if step == 4:
            modifier.removePoints(np.array([0]), True)
        seen.append((mesh.getNbPoints(), len(state.position.value)))
    root.addObject(Each(begin))
    Sofa.Simulation.init(root)
    animate(root, 5)
    assert seen == [(2, 2), [[0, 0, 0]] * 3, (5, 5), (5, 5), (4, 4), (4, 4)]
    assert state.position.value.tolist() == [[4, 0, 2], [1, 0, 2], [2, 0, 2], [3, 0, 2]], "the last takes the number that is free"


def test_what_cannot_be_changed_is_told():
    root, node = scene()
    with pytest.raises(RuntimeError, match="/body/modifier: points come and go while the scene runs"):
        node.modifier.addPoints(1)
    with pytest.raises(ValueError, match="point 5 would lose its last cell"):
        node.modifier.removeTetrahedra([2])
    Sofa.Simulation.init(root)
    with pytest.raises(RuntimeError, match="/body/mesh: point 0 cannot be removed: one of the tetrahedra still uses it"):
        node.modifier.removePoints([0])
    with pytest.raises(IndexError, match="there are 3 tetrahedra, and 7 is none"):
        node.modifier.removeTetrahedra([7])
    with pytest.raises(TypeError, match="takes how many points come"):
        node.modifier.addPoints([[0, 0, 0]])


# ---- CarvingManager ----

CARVING = """import Sofa

class Tool(Sofa.Core.Controller):
    def __init__(self, root):
        super().__init__()
        self.root, self.step = root, 0

    def onAnimateBeginEvent(self, event):
        self.step += 1
        if self.step == 4:
            self.root.carving.active.value = True
        with self.root.tool.state.position.writeable() as x:
            x[0] += [0, 0.0707, -0.0707]
        print("cells", self.step, self.root.body.mesh.getNbTetrahedra(), len(self.root.body.state.position.value))

def createScene(root):
    root.dt, root.gravity = 0.01, [0, 0, 0]
    root.addObject("CollisionPipeline")
    root.addObject("BruteForceBroadPhase")
    root.addObject("BVHNarrowPhase")
    root.addObject("MinProximityIntersection", alarmDistance=0.5, contactDistance=0.01)
    root.addObject("CollisionResponse", response="PenalityContactForceField")
    root.addObject("CarvingManager", name="carving", active=False, carvingDistance=0.2)
    body = root.addChild("body")
    body.addObject("EulerImplicitSolver")
    body.addObject("SparseLDLSolver")
    body.addObject("TetrahedronSetTopologyContainer", name="mesh", tetrahedra=[[0, 1, 2, 3], [1, 2, 3, 4], [1, 2, 4, 5]],
                   position=[[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1], [2, 1, 1]])
    body.addObject("TetrahedronSetTopologyModifier")
    body.addObject("MechanicalObject", name="state")
    body.addObject("MeshMatrixMass", massDensity=1e5)
    body.addObject("TetrahedronFEMForceField", youngModulus=1e5, poissonRatio=0.3)
    body.addObject("FixedProjectiveConstraint", indices=[0, 1, 2])
    surface = body.addChild("surface")
    surface.addObject("TriangleSetTopologyContainer", name="faces")
    surface.addObject("TriangleSetTopologyModifier")
    surface.addObject("Tetra2TriangleTopologicalMapping", input="@../mesh", output="@faces")
    surface.addObject("TriangleCollisionModel", contactStiffness=0.01, tags="CarvingSurface")
    tool = root.addChild("tool")
    tool.addObject("MechanicalObject", name="state", position=[[1.33, 0.2457, 1.0943]])
    tool.addObject("SphereCollisionModel", radius=0.1, tags="CarvingTool", contactStiffness=0.01)
    root.addObject(Tool(root))
"""


def test_a_carving_tool_takes_cells_while_it_is_active(tmp_path):
    """It is near a face of the last cell from step 3 on, and active from step 4 on."""
    (tmp_path / "carving.py").write_text(CARVING)
    root = Sofa.Simulation.load(str(tmp_path / "carving.py"))
    Sofa.Simulation.init(root)
    counts = []
    for _ in range(8):
        animate(root, 1)
        counts.append(root.body.mesh.getNbTetrahedra())
    assert counts[:4] == [3, 3, 3, 2] and sorted(counts, reverse=True) == counts, counts
    assert len(root.body.state.position.value) == len(np.unique(root.body.mesh.tetrahedra.value))
    done = run("run", tmp_path / "carving.py", "-n", 8, "--no-record", folder=tmp_path)
    assert done.returncode == 0 and "is run again" not in done.stderr, done.stderr
    assert f"cells 8 {counts[6]} " in done.stdout, done.stdout


def test_what_the_end_of_a_step_tells_is_of_that_step(tmp_path):
    (tmp_path / "carving.py").write_text("from Sofa import SofaLinearSolver\n" + CARVING)
    root = Sofa.Simulation.load(str(tmp_path / "carving.py"))
    seen = []
    root.addObject(Each(end=lambda step: seen.append((root.body.SparseLDLSolver.A().shape[0], len(root.body.state.position.value)))), name="last")
    Sofa.Simulation.init(root)
    animate(root, 6)
    assert all(rows == 3 * points for rows, points in seen) and len(set(seen)) > 1, seen


def test_a_carving_manager_is_not_left_out_in_silence(tmp_path):
    (tmp_path / "carving.py").write_text(CARVING)
    done = run("migrate", tmp_path / "carving.py", "-o", tmp_path / "carving.xml", folder=tmp_path)
    assert "/carving: CarvingManager is written in Python, and not in the scene that is made" in done.stderr, done.stderr


def test_keys_switch_the_tool(tmp_path):
    from Sofa import _events

    (tmp_path / "carving.py").write_text(CARVING)
    root = Sofa.Simulation.load(str(tmp_path / "carving.py"))
    heard = []
    for key, pressed in (("1", True), ("1", False), ("4", True), ("4", False), ("4", True)):
        _events.key(root, key, pressed)
        heard.append(root.carving.active.value)
    assert heard == [True, False, True, True, False]


# ---- surfaces that nothing moves and a scene places ----

def pushed_ball(placed):
    """A plate on its own state, which the controller lifts, under a ball that falls."""
    root = Sofa.Core.Node("root")
    root.dt, root.gravity = 0.01, [0, -9.81, 0]
    for word in ("CollisionPipeline", "BruteForceBroadPhase", "BVHNarrowPhase"):
        root.addObject(word)
    root.addObject("MinProximityIntersection", alarmDistance=0.5, contactDistance=0.01)
    root.addObject("CollisionResponse", response="PenalityContactForceField")
    ball = root.addChild("ball")
    ball.addObject("EulerImplicitSolver")
    ball.addObject("SparseLDLSolver")
    ball.addObject("MechanicalObject", name="state", position=[[0, 1, 0]])
    ball.addObject("UniformMass", totalMass=1)
    ball.addObject("SphereCollisionModel", radius=0.5, contactStiffness=100)
    plate = root.addChild("plate")
    plate.addObject("MeshTopology", position=[[-9, 0, -9], [9, 0, -9], [0, 0, 9]], triangles=[[0, 2, 1]])
    plate.addObject("MechanicalObject", name="state")
    plate.addObject("TriangleCollisionModel", contactStiffness=100)
    made = []

    def begin(step):
        with plate.state.position.writeable() as x:
            x[:, 1] += 0.02
        if not placed:
            root._s_engine().edited()
        made.append(root._s_engine().sim)
    root.addObject(Each(begin))
    Sofa.Simulation.init(root)
    return root, ball, plate, made


def test_a_surface_that_a_scene_places_takes_no_new_simulation():
    """The bits are those of a scene that is made anew in every step, and it goes back to the start."""
    ends = []
    for placed in (True, False):
        root, ball, plate, made = pushed_ball(placed)
        animate(root, 30)
        assert (len(set(map(id, made))) == 1) == placed
        assert plate.state.position.value[:, 1].tolist() == pytest.approx([0.6] * 3, abs=1e-12)
        ends.append(np.array([ball.state.position.value, ball.state.velocity.value]))
    assert np.array_equal(*ends) and ends[0][0, 0, 1] > 1, "it is lifted"
    root, ball, plate, made = pushed_ball(True)
    forces = []
    for _ in range(2):
        animate(root, 17)
        forces.append(np.array(ball.state.force.value))
        animate(root, 13)
        assert np.array_equal(ball.state.position.value, ends[0][0])
        Sofa.Simulation.reset(root)
        assert plate.state.position.value[:, 1].tolist() == [0, 0, 0]
    assert forces[0] == pytest.approx(forces[1]) and forces[0][0, 1] == pytest.approx(-7.98647, abs=1e-4), "the plate pushes where it is"


def test_components_change_meshes_under_the_command_too(tmp_path):
    """A controller sees what a TopologicalChangeProcessor leaves; the bits are those of a loop."""
    (tmp_path / "scene.py").write_text("""import Sofa
from test_live_meshes import Each, body

def createScene(root):
    root.dt = 0.01
    node = body(root)
    node.addObject("TopologicalChangeProcessor", useDataInputs=True, timeToRemove=0.025, tetrahedraToRemove=[2])

    def end(step):
        print("cells", step, node.mesh.getNbTetrahedra(), node.state.position.value.shape, repr(node.state.position.value.sum()))
        if step == 5:
            node.state.velocity.value = node.state.velocity.value * 0
    root.addObject(Each(end=end, name="end"))
""")
    root = Sofa.Simulation.load(str(tmp_path / "scene.py"))
    Sofa.Simulation.init(root)
    animate(root, 8)
    done = run("run", tmp_path / "scene.py", "-n", 8, "--no-record", folder=tmp_path, PYTHONPATH=str(HERE))
    assert done.returncode == 0 and "is run again" not in done.stderr, done.stderr
    lines = [line for line in done.stdout.splitlines() if line.startswith("cells")]
    assert lines[2].startswith("cells 3 3 (6, 3)") and lines[3].startswith("cells 4 2 (5, 3)") and len(lines) == 8
    assert lines[-1].endswith(repr(root.body.state.position.value.sum()))


def test_a_tool_stays_where_it_was_put_when_a_mesh_changes():
    root, node = scene()
    for word in ("CollisionPipeline", "BruteForceBroadPhase", "BVHNarrowPhase"):
        root.addObject(word)
    root.addObject("MinProximityIntersection", alarmDistance=0.5, contactDistance=0.01)
    root.addObject("CollisionResponse", response="PenalityContactForceField")
    tool = root.addChild("tool")
    tool.addObject("MechanicalObject", name="state", position=[[5, 5, 5]])
    tool.addObject("PointCollisionModel", moving=True, simulated=False)
    Sofa.Simulation.init(root)
    animate(root, 1)
    tool.state.position.value = [[4, 4, 4]]
    animate(root, 1)
    node.modifier.removeTetrahedra([2])
    assert tool.state.position.value.tolist() == [[4, 4, 4]]
    animate(root, 1)
    assert tool.state.position.value.tolist() == [[4, 4, 4]] and len(node.state.position.value) == 5
    tool.state.position.value = [[3, 3, 3]]
    animate(root, 1)
    for _ in range(2):
        Sofa.Simulation.reset(root)
        assert tool.state.position.value.tolist() == [[5, 5, 5]] and len(node.state.position.value) == 6
        animate(root, 1)


def touched(root, node):
    """A tool of a point that presses on the body, and a solver that finds the forces."""
    for word in ("FreeMotionAnimationLoop", "CollisionPipeline", "BruteForceBroadPhase", "BVHNarrowPhase"):
        root.addObject(word)
    root.addObject("GenericConstraintSolver", name="solver", tolerance=1e-9, maxIterations=500)
    root.addObject("MinProximityIntersection", alarmDistance=0.3, contactDistance=0.02)
    root.addObject("CollisionResponse", response="FrictionContactConstraint", responseParams="mu=0.3")
    node.addObject("LinearSolverConstraintCorrection")
    surface = node.addChild("surface")
    surface.addObject("TriangleSetTopologyContainer", name="tri")
    surface.addObject("TriangleSetTopologyModifier")
    surface.addObject("Tetra2TriangleTopologicalMapping", input="@../mesh", output="@tri")
    for word in ("TriangleCollisionModel", "LineCollisionModel", "PointCollisionModel"):
        surface.addObject(word)
    tool = root.addChild("tool")
    tool.addObject("MechanicalObject", name="state", position=[[5, 5, 5]])
    tool.addObject("PointCollisionModel", simulated=False, moving=True)
    return tool


def test_a_placed_tool_touches_in_the_step_in_which_another_mesh_changes():
    forces = []
    for changes in (False, True):
        root, node = scene()
        root.gravity = [0, 0, 0]
        tool = touched(root, node)
        other = root.addChild("other")
        other.addObject("EulerImplicitSolver")
        other.addObject("SparseLDLSolver")
        other.addObject("TetrahedronSetTopologyContainer", name="mesh", position=[[20 + x, y, z] for x, y, z in POSITION], tetrahedra=CELLS)
        other.addObject("TetrahedronSetTopologyModifier")
        other.addObject("MechanicalObject", name="state")
        other.addObject("UniformMass", totalMass=1)
        other.addObject("LinearSolverConstraintCorrection")
        if changes:
            other.addObject("TopologicalChangeProcessor", useDataInputs=True, timeToRemove=0.025, tetrahedraToRemove=[2])
        Sofa.Simulation.init(root)
        animate(root, 3)
        tool.state.position.value = [[2.008, 1.006, 1.006]]
        found = []
        for _ in range(4):
            animate(root, 1)
            found.append(np.array(root.solver.constraintForces.value))
        forces.append(found)
        assert len(other.state.position.value) == 6 - changes
    assert forces[0][0].max() > 0.1, "it presses in the step of the change"
    for before, after in zip(*forces):
        assert after == pytest.approx(before, rel=1e-6, abs=1e-9)


def test_places_that_are_no_numbers_are_refused():
    root, node = scene()
    tool = touched(root, node)
    Sofa.Simulation.init(root)
    with pytest.raises(RuntimeError, match="/tool/state.position: node 0 is put at .nan, 4, 4."):
        tool.state.position.value = [[np.nan, 4, 4]]
    assert tool.state.position.value.tolist() == [[5, 5, 5]]


CUT = """import Sofa
from test_live_meshes import Each, body

def createScene(root):
    root.dt = 0.01
    node = body(root)

    class Cut(Each):
        def onKeypressedEvent(self, event):
            if event["key"] == "X":
                node.modifier.removeTetrahedra([1, 2])

    def end(step):
        if step == 3:
            node.modifier.removeTetrahedra([2])
            assert node.mesh.getNbTetrahedra() == 2
        if step == 5:
            node.modifier.addTetrahedra([[0, 2, 3, 4]])
        print("cells", step, node.mesh.getNbTetrahedra(), node.state.position.value.shape, repr(node.state.position.value.sum()), flush=True)
    root.addObject(Cut(end=end, name="end"))
"""


@pytest.mark.parametrize("recorded", [False, True])
def test_a_controller_changes_meshes_under_the_command(recorded, tmp_path, capsys):
    """With the bits of a loop, and not run again; a recording has the mesh of each instant."""
    (tmp_path / "scene.py").write_text(CUT)
    root = Sofa.Simulation.load(str(tmp_path / "scene.py"))
    Sofa.Simulation.init(root)
    animate(root, 8)
    lines = [line for line in capsys.readouterr().out.splitlines() if line.startswith("cells")]
    assert [line.split(" (")[0] for line in lines] == [f"cells {step} {2 if step in (3, 4) else 3}" for step in range(1, 9)]
    words = ["--record", tmp_path / "kept"] if recorded else ["--no-record"]
    done = run("run", tmp_path / "scene.py", "-n", 8, *words, folder=tmp_path, PYTHONPATH=str(HERE))
    assert done.returncode == 0 and "is run again" not in done.stderr, done.stderr
    assert [line for line in done.stdout.splitlines() if line.startswith("cells")] == lines
    if recorded:
        assert len(list((tmp_path / "kept").glob("meshes.*.checkpoint"))) == 2
        drawn = run("picture", tmp_path / "kept", "--at", "start,0.03,0.05,end", "-o", tmp_path / "kept.png", folder=tmp_path,
                    PYTHONPATH=str(HERE))
        assert drawn.returncode == 0 and (tmp_path / "kept.png").exists(), drawn.stderr


def test_a_controller_changes_meshes_in_the_view(tmp_path, monkeypatch):
    """At the end of a step and by a key; a reset brings all points back."""
    from server import Server

    (tmp_path / "scene.py").write_text(CUT)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(HERE), os.environ["PYTHONPATH"]]))
    with Server(COMMAND, str(tmp_path / "scene.py"), "--paused") as server:
        page = server.page()
        page.do("control")
        for step, count, nodes in ((2, 2, 6), (4, 2, 5), (5, 1, 5)):
            page.do("step", count=count)
            page.picture(step)
            assert len(page.positions()) == nodes
        page.do("key", key="x", pressed=True)
        page.do("key", key="x", pressed=False)
        page.do("step", count=1)
        page.picture(6)
        assert len(page.positions()) == 4 and page.status["ended"] == ""
        page.do("reset")
        page.picture(0)
        assert len(page.positions()) == 6
        page.do("step", count=2)
        page.picture(2)
        assert len(page.positions()) == 6 and page.status["ended"] == ""
