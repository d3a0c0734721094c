# SPDX-License-Identifier: LGPL-2.1-or-later
"""Lists of cells that SOFA's topologies have whatever a scene writes, what constraint solvers tell, and events of a scene as a whole."""
import numpy as np
import pytest
import Sofa
import stroma
from playing import SCENES, animate, run

CUBE = [[x, y, z] for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]
TETRAHEDRON = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
SQUARE = CUBE[:4]
#: (type, what is written, numbers of points, edges, triangles, quads, tetrahedra, hexahedra)
TOPOLOGIES = [
    ("RegularGridTopology", dict(n=[3, 3, 3], min=[0, 0, 0], max=[1, 1, 1]), (27, 90, 72, 36, 0, 8)),
    ("SparseGridTopology", dict(n=[3, 3, 3], fileTopology=str(SCENES / "tetrahedron.obj")), None),
    ("MeshTopology", dict(position=TETRAHEDRON, tetrahedra=[[0, 1, 2, 3]]), (4, 6, 4, 0, 1, 0)),
    ("TetrahedronSetTopologyContainer", dict(position=TETRAHEDRON, tetrahedra=[[0, 1, 2, 3]]), (4, 6, 4, 0, 1, 0)),
    ("TriangleSetTopologyContainer", dict(position=SQUARE, triangles=[[0, 1, 2], [0, 2, 3]]), (4, 5, 2, 0, 0, 0)),
    ("QuadSetTopologyContainer", dict(position=SQUARE, quads=[[0, 1, 2, 3]]), (4, 4, 0, 1, 0, 0)),
    ("HexahedronSetTopologyContainer", dict(position=CUBE, hexahedra=[list(range(8))]), (8, 12, 0, 6, 0, 1)),
    ("EdgeSetTopologyContainer", dict(position=SQUARE, edges=[[0, 1], [1, 2]]), (4, 2, 0, 0, 0, 0)),
    ("PointSetTopologyContainer", dict(position=SQUARE), (4, 0, 0, 0, 0, 0)),
]
LISTS = {"edges": 2, "triangles": 3, "quads": 4, "tetrahedra": 4, "hexahedra": 8}
COUNTS = ("getNbEdges", "getNbTriangles", "getNbQuads", "getNbTetrahedra", "getNbHexahedra")


@pytest.mark.parametrize("initialised", (False, True))
@pytest.mark.parametrize("word, written, numbers", TOPOLOGIES, ids=[each[0] for each in TOPOLOGIES])
def test_every_topology_lists_its_cells(word, written, numbers, initialised):
    root = Sofa.Core.Node("root")
    body = root.addChild("body")
    mesh = body.addObject(word, name="mesh", **written)
    body.addObject("MechanicalObject", name="dofs")
    if initialised:
        body.addObject("EulerImplicitSolver")
        body.addObject("SparseLDLSolver")
        body.addObject("UniformMass", totalMass=1)
        Sofa.Simulation.init(root)
    found = [len(mesh.findData(name).value) for name in LISTS]
    for (name, nodes), count in zip(LISTS.items(), found):
        value = mesh[name].value
        assert value.shape == (count, nodes) and value.dtype.kind == "i"
        assert len({frozenset(cell) for cell in value.tolist()}) == count, f"{name} come twice"
        assert np.all((value >= 0) & (value < mesh.getNbPoints()))
    assert found == [getattr(mesh, name)() for name in COUNTS] and mesh.nbPoints.value == mesh.getNbPoints() == len(mesh.position.value)
    if numbers is None:
        corners, edges, faces, cells = mesh.getNbPoints(), found[0], found[2], found[4]
        assert corners - edges + faces - cells == 1  # Euler's: a grid without holes
    else:
        assert (mesh.getNbPoints(), *found) == numbers


def test_cells_have_the_order_of_sofa():
    """An edge has its lower node first; of the sides of a tetrahedron the outer one is that which turns to the left."""
    root = Sofa.Core.Node("root")
    mesh = root.addObject("TetrahedronSetTopologyContainer", position=[*TETRAHEDRON, [1, 1, 1]], tetrahedra=[[3, 1, 2, 0], [1, 2, 3, 4]])
    assert mesh.edges.value.tolist() == [[1, 3], [2, 3], [0, 3], [1, 2], [0, 1], [0, 2], [1, 4], [2, 4], [3, 4]]
    assert mesh.triangles.value[:4].tolist() == [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]]
    assert mesh.getEdge(2) == [0, 3] and mesh.getEdgesInTetrahedron(1) == [3, 1 - 1, 6, 1, 7, 8]


BLOCK = [[x, y, z] for z in range(3) for y in range(3) for x in range(3)]


def cells_of_block():
    """Six tetrahedra in each of eight cubes, all about one diagonal."""
    corners = [(0, 1, 3, 7), (0, 3, 2, 7), (0, 2, 6, 7), (0, 6, 4, 7), (0, 4, 5, 7), (0, 5, 1, 7)]
    return [[9 * (k + (c >> 2)) + 3 * (j + (c >> 1 & 1)) + i + (c & 1) for c in cell]
            for k in range(2) for j in range(2) for i in range(2) for cell in corners]


def block(cells, **state):
    root = Sofa.Core.Node("root")
    root.gravity = [0, -10, 0]
    body = root.addChild("body")
    body.addObject("EulerImplicitSolver")
    body.addObject("SparseLDLSolver")
    body.addObject("TetrahedronSetTopologyContainer", name="mesh", position=BLOCK, tetrahedra=cells, createTriangleArray=True)
    body.addObject("TetrahedronSetTopologyModifier", name="modifier")
    body.addObject("MechanicalObject", name="dofs", rest_position=BLOCK, **state)
    body.addObject("UniformMass", totalMass=27)
    body.addObject("FixedProjectiveConstraint", indices=list(range(9)))
    body.addObject("TetrahedronFEMForceField", youngModulus=1e4, poissonRatio=0.3, method="polar")
    surface = body.addChild("surface")
    surface.addObject("TriangleSetTopologyContainer", name="mesh")
    surface.addObject("Tetra2TriangleTopologicalMapping", input="@../mesh", output="@mesh")
    return root


def test_cells_go_by_a_modifier():
    """The run goes on as that of the scene without them does from there; numbers that are free are taken by the last."""
    cells = cells_of_block()
    root = block(cells)
    Sofa.Simulation.init(root)
    animate(root, 3)
    body = root.body
    x, v, faces = (np.array(data.value) for data in (body.dofs.position, body.dofs.velocity, body.surface.mesh.triangles))
    body.modifier.removeTetrahedra([45, 2, 40], True)
    kept = list(cells)
    for each in (45, 40, 2):
        kept[each] = kept[-1]
        kept.pop()
    assert body.mesh.tetrahedra.value.tolist() == kept and body.mesh.getNbTetrahedra() == 45
    animate(root, 4)
    other = block(kept, position=x, velocity=v)
    Sofa.Simulation.init(other)
    animate(other, 4)
    assert np.allclose(body.dofs.position.value, other.body.dofs.position.value, atol=1e-12, rtol=0)
    assert body.surface.mesh.triangles.value.tolist() == other.body.surface.mesh.triangles.value.tolist() != faces.tolist()
    whole = block(cells, position=x, velocity=v)
    Sofa.Simulation.init(whole)
    animate(whole, 4)
    assert np.abs(body.dofs.position.value - whole.body.dofs.position.value).max() > 1e-5


def test_cells_come_by_a_modifier():
    cells = cells_of_block()
    root = block(cells[:-1])
    root.body.modifier.addTetrahedra([cells[-1]])
    assert root.body.mesh.tetrahedra.value.tolist() == cells
    Sofa.Simulation.init(root)
    root.body.modifier.removeItems([0])
    root.body.modifier.addTetrahedra([cells[0]])
    animate(root, 1)
    assert root.body.mesh.tetrahedra.value.tolist() == [cells[-1], *cells[1:-1], cells[0]]


def test_what_a_modifier_cannot_is_told():
    root = block(cells_of_block())
    modifier = root.body.modifier
    with pytest.raises(IndexError, match="there are 48 tetrahedra, and 48 is none"):
        modifier.removeTetrahedra([48])
    with pytest.raises(IndexError, match="names node 27 of 27"):
        modifier.addTetrahedra([[0, 1, 2, 27]])
    alone = Sofa.Core.Node("root").addObject("TriangleSetTopologyModifier")
    with pytest.raises(RuntimeError, match="there is no container beside it"):
        alone.removeTriangles([0])


def test_sides_go_with_their_cells():
    root = Sofa.Core.Node("root")
    mesh = root.addObject("TetrahedronSetTopologyContainer", name="mesh", position=[*TETRAHEDRON, [1, 1, 1]],
                          tetrahedra=[[0, 1, 2, 3], [1, 2, 3, 4], [0, 1, 2, 4], [0, 1, 3, 4]], triangles=[[1, 2, 3], [2, 3, 4], [0, 1, 2]], edges=[[2, 3]])
    root.addObject("TetrahedronSetTopologyModifier", name="modifier").removeTetrahedra([1])
    assert mesh.triangles.value.tolist() == [[1, 2, 3], [0, 1, 2]] and mesh.edges.value.tolist() == [[2, 3]]


def pressed_ball(response):
    root = Sofa.Core.Node("root")
    root.dt, root.gravity = 0.01, [0, -10, 0]
    root.addObject("FreeMotionAnimationLoop")
    root.addObject("GenericConstraintSolver", name="solver", maxIterations=500, tolerance=1e-9)
    root.addObject("CollisionPipeline")
    root.addObject("LocalMinDistance", alarmDistance=0.3, contactDistance=0.1)
    root.addObject("CollisionResponse", response=response, responseParams="mu=0.5")
    ball = root.addChild("ball")
    ball.addObject("EulerImplicitSolver")
    ball.addObject("SparseLDLSolver")
    ball.addObject("LinearSolverConstraintCorrection")
    ball.addObject("MechanicalObject", name="dofs", position=[[0, 0.5, 0]], velocity=[[1, 0, 0]])
    ball.addObject("UniformMass", totalMass=1)
    ball.addObject("SphereCollisionModel", radius=0.4)
    floor = root.addChild("floor")
    floor.addObject("MeshTopology", position=[[-9, 0, -9], [9, 0, -9], [9, 0, 9], [-9, 0, 9]], triangles=[[0, 2, 1], [0, 3, 2]])
    floor.addObject("MechanicalObject")
    floor.addObject("TriangleCollisionModel", simulated=False, moving=False)
    Sofa.Simulation.init(root)
    return root


def test_a_constraint_solver_tells_of_its_search(capsys):
    root = pressed_ball("FrictionContactConstraint")
    assert root.solver.currentIterations.value == 0 and root.solver.currentError.value == 0
    animate(root, 2)
    assert root.solver.currentNumConstraints.value == 3 and 0 < root.solver.currentIterations.value < 50
    assert 0 <= root.solver.currentError.value < 1e-9
    root.ball.dofs.position.value = [[0, 5, 0]]
    animate(root, 2)
    assert root.solver.currentIterations.value == 0 and root.solver.currentError.value == 0
    assert "not computed here" not in capsys.readouterr().err


def test_events_of_a_constraint_solver():
    class Hears(Sofa.Core.Controller):
        def onEvent(self, event):
            self.heard.append(event["type"])

        def onBuildConstraintSystemEndEvent(self, event):
            self.heard.append("built")

        def onSolveConstraintSystemEndEvent(self, event):
            self.heard.append("solved")

        def onSimulationInitStartEvent(self, event):
            self.heard.append("starts")

        def onSimulationInitTexturesDoneEvent(self, event):
            self.heard.append("textures")

    for with_solver in (False, True):
        root = Sofa.Core.Node("root")
        if with_solver:
            root.addObject("FreeMotionAnimationLoop")
            root.addObject("GenericConstraintSolver")
        hears = root.addObject(Hears(name="hears"))
        hears.heard = []
        Sofa.Simulation.init(root)
        Sofa.Simulation.initTextures(root)
        animate(root, 1)
        step = ["AnimateBeginEvent", *(["built", "solved"] if with_solver else []), "AnimateEndEvent"]
        assert hears.heard == ["starts", "SimulationInitDoneEvent", "textures", *step]


def test_a_command_starts_and_stops(tmp_path):
    scene = tmp_path / "scene.py"
    scene.write_text('''
import Sofa

class Hears(Sofa.Core.Controller):
    def onSimulationStartEvent(self, event):
        print("started", self.dofs.position.value[0][1])
    def onSimulationStopEvent(self, event):
        print("stopped", self.dofs.position.value[0][1] < 0)

def createScene(root):
    root.addObject("EulerImplicitSolver")
    root.addObject("SparseLDLSolver")
    dofs = root.addObject("MechanicalObject", position=[0, 0, 0])
    root.addObject("UniformMass", totalMass=1)
    root.addObject(Hears()).dofs = dofs
''')
    done = run("run", scene, "-n", 3, "--no-record", folder=tmp_path)
    assert done.returncode == 0 and "is not called" not in done.stderr, done.stderr
    assert [line for line in done.stdout.splitlines() if line.startswith(("started", "stopped"))] == ["started 0.0", "stopped True"], done.stdout


def test_data_of_a_kind_have_its_numbers():
    thing = Sofa.Core.Node("root").addObject(Sofa.Core.Controller())
    assert thing.addData("q", value=[0, 0, 0, 1], type="Quatd").value.dtype.kind == "f"
    assert thing.addData("frame", value=[0, 0, 0, 0, 0, 0, 1], type="RigidCoord<3,double>").value.dtype.kind == "f"
    assert thing.addData("rows", value=[[1, 2], [3]], type="vector<vector<int>>").value == [[1, 2], [3]]


def test_a_change_that_takes_another_load_has_an_error_of_its_own():
    root = stroma.Node("root", dt=0.1)
    root.add("EulerImplicitSolver", name="ode")
    root.add("CGLinearSolver", name="linear")
    root.add("MechanicalObject", name="dofs", position=[0, 0, 0])
    root.add("UniformMass", name="mass", totalMass=1)
    simulation = stroma.load(root)
    with pytest.raises(stroma.LoadNeeded, match="load the scene again"):
        simulation["/dofs"].restScale = 2
    with pytest.raises(stroma.SceneError) as refused:
        simulation["/linear"].iterations = -3
    assert not isinstance(refused.value, stroma.LoadNeeded)


def turned(value):
    root = stroma.Node("root", dt=0.1, gravity=(0, 0, 0))
    root.add("EulerImplicitSolver")
    root.add("SparseLDLSolver")
    root.add("MechanicalObject", name="dofs", template="Rigid3", position=[0, 0, 0, 0, 0, 0, 1])
    root.add("UniformMass", totalMass=1)
    root.add("PositionConstraint", name="turn", useDirections="0 0 0 0 0 1", valueType="displacement", value=[value])
    return stroma.load(root)


def test_a_turn_is_at_most_half_a_turn():
    """An orientation is the same after a whole one: by 3 and 3.1 rad it is reached, by 3.2 it would be one of -3.08."""
    with pytest.raises(stroma.SceneError, match="turn by 3.142 at most"):
        turned(3.2)
    simulation = turned(3)
    for value in (3.0, 3.1):
        simulation["/turn"].value = [value]
        simulation.run(1)
        x, y, z, w = simulation.state("/dofs").x[0, 3:7] if simulation.state("/dofs").x.shape[1] > 6 else simulation["/dofs"].position[3:7]
        angle = 2 * np.arctan2(z, w)  # q and -q are one orientation
        assert np.exp(1j * (angle - value)) == pytest.approx(1, abs=1e-9) and abs(x) + abs(y) < 1e-12
    simulation["/turn"].value = [-3.2]
    with pytest.raises(stroma.SceneError, match="turn by 3.142 at most"):
        simulation.run(1)


def test_a_section_tells_its_beams():
    root = stroma.Node("root", dt=0.01)
    for name, given in (("plain", {}), ("counted", {"nbBeams": 8})):
        root.add("RodStraightSection", name=name, length=0.3, radius=0.001, youngModulus=1e9, massDensity=1000, nbEdgesCollis=3, **given)
    root.add("WireRestShape", name="shape", wireMaterials="@plain @counted")
    simulation = stroma.load(root, quiet=True)
    assert simulation["/plain"].nbBeams == 3 and simulation["/counted"].nbBeams == 8


def _region(kind, initialised, **given):
    root = Sofa.Core.Node("root")
    body = root.addChild("body")
    body.addObject("EulerImplicitSolver")
    body.addObject("SparseLDLSolver")
    word, written = {"grid": ("RegularGridTopology", dict(n=[3, 3, 3], min=[0, 0, 0], max=[1, 1, 1])),
                     "tets": ("TetrahedronSetTopologyContainer", dict(position=[*TETRAHEDRON, [1, 1, 1]], tetrahedra=[[0, 1, 2, 3], [1, 2, 3, 4]])),
                     "hexas": ("MeshTopology", dict(position=CUBE, hexahedra=[list(range(8))]))}[kind]
    mesh = body.addObject(word, name="mesh", **written)
    body.addObject("MechanicalObject", name="dofs")
    body.addObject("UniformMass", totalMass=1)
    region = body.addObject("BoxROI", name="roi", **given)
    if initialised:
        Sofa.Simulation.init(root)
    return mesh, region


@pytest.mark.parametrize("strict", (True, False))
@pytest.mark.parametrize("initialised", (False, True))
@pytest.mark.parametrize("kind", ("grid", "tets", "hexas"))
def test_regions_choose_of_all_that_a_topology_lists(kind, initialised, strict):
    """Also where nothing links to what they choose; whole cells, or those with the middle inside."""
    mesh, region = _region(kind, initialised, box=[-1, -1, -1, 2, 2, 0.6], strict=strict)
    places = np.array(mesh.position.value)
    for name, one in (("edges", "edge"), ("triangles", "triangle"), ("quads", "quad")):
        rows = np.array(mesh.findData(name).value)
        z = places[rows][..., 2] if len(rows) else np.zeros((0, 3))
        inside = np.flatnonzero((z.max(axis=1) if strict else z.mean(axis=1)) <= 0.6)
        assert list(region.findData(one + "Indices").value) == list(inside)
        assert np.array_equal(np.array(region.findData(name + "InROI").value).reshape(-1, LISTS[name]), rows[inside].reshape(-1, LISTS[name]))
    assert len(region.edgeIndices.value) > 2


def test_lists_that_a_region_is_given_count():
    _, region = _region("hexas", True, box=[-1, -1, -1, 2, 2, 2], edges=[[0, 1]], quads=[[0, 1, 2, 3]])
    assert region.edgesInROI.value.tolist() == [[0, 1]] and region.quadIndices.value.tolist() == [0]
    assert len(region.trianglesInROI.value) == 0
