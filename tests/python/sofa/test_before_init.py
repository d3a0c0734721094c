# SPDX-License-Identifier: LGPL-2.1-or-later
"""Values that are read while a scene is built: each read computes what the component depends on, and values follow what changes."""
import numpy as np
import pytest
import Sofa
import stroma.tree
from playing import SCENES


@pytest.fixture
def computed(monkeypatch):
    """How many components have been made for values before a scene runs."""
    made = [0]
    begin = stroma.tree.Preview.__init__

    def counted(self, root):
        made[0] += sum(isinstance(each, stroma.tree.Component) for each in root.walk())
        begin(self, root)

    monkeypatch.setattr(stroma.tree.Preview, "__init__", counted)
    return made


def grid_in(node, **values):
    return node.addObject("RegularGridTopology", name="grid", n=[3, 2, 2], min=[0, 0, 0], max=[2, 1, 1], **values)


def region_in_turn(root, number):
    region = root.addObject("BoxROI", name=f"region_{number}", box=[-1, -1, -1, 0.5 + number % 3, 2, 2], position="@grid.position")
    assert len(region.indices.value) == 4 * min(3, number % 3 + 1)
    root.addObject("FixedProjectiveConstraint", name=f"held_{number}", indices=region.indices.getLinkPath())


def surface_in_turn(root, number):
    child = root.addChild(f"surface_{number}")
    child.addObject("QuadSetTopologyContainer", name="quads")
    child.addObject("Hexa2QuadTopologicalMapping", input="@../grid", output="@quads")
    assert child.quads.quads.value.shape == (10, 4)
    state = child.addObject("MechanicalObject", name="points")
    assert len(state.position.value) == 12
    child.addObject("IdentityMapping", input="@../dofs", output="@points")


def loader_in_turn(root, number):
    loader = root.addObject("MeshOBJLoader", name=f"loader_{number}", filename=str(SCENES / "tetrahedron.obj"))
    assert loader.triangles.value.shape == (4, 3)
    mesh = root.addChild(f"mesh_{number}").addObject("TriangleSetTopologyContainer", src=loader.getLinkPath())
    assert mesh.triangles.value.shape == (4, 3)


@pytest.mark.parametrize("turn", [region_in_turn, surface_in_turn, loader_in_turn])
def test_reads_in_turns_with_additions_compute_in_proportion(turn, computed):
    root = Sofa.Core.Node("root")
    grid_in(root)
    root.addObject("MechanicalObject", name="dofs")
    counts = []
    for number in range(24):
        before = computed[0]
        turn(root, number)
        counts.append(computed[0] - before)
    assert 0 < counts[23] <= counts[2], counts


def test_reads_after_all_is_there_compute_each_once(computed):
    root = Sofa.Core.Node("root")
    grid_in(root)
    regions = [root.addObject("BoxROI", name=f"r{i}", box=[-1, -1, -1, 0.5, 2, 2], position="@grid.position") for i in range(20)]
    assert all(len(each.indices.value) == 4 for each in regions) and all(len(each.position.value) == 12 for each in regions)
    assert computed[0] == 21
    root.addObject("UniformMass")
    assert all(len(each.indices.value) == 4 for each in regions) and computed[0] == 21, "a mass changes none of them"


def test_values_follow_what_they_depend_on():
    root = Sofa.Core.Node("root")
    body = root.addChild("body")
    grid = grid_in(body)
    state = body.addObject("MechanicalObject", name="dofs")
    region = body.addObject("BoxROI", name="region", box=[-1, -1, -1, 0.5, 2, 2])
    assert len(region.indices.value) == 4 and len(state.position.value) == 12
    grid.n = [5, 2, 2]
    assert len(state.position.value) == 20 and len(region.indices.value) == 8
    region.box = [-1, -1, -1, 1.1, 2, 2]
    assert len(region.indices.value) == 12
    state.translation = [1, 0, 0]
    assert state.position.value[:, 0].min() == 1 and len(region.indices.value) == 4


def test_values_follow_what_comes_later():
    root = Sofa.Core.Node("root")
    first = root.addChild("first")
    state = first.addObject("MechanicalObject", name="dofs")
    assert len(state.position.value) == 1, "one at the origin"
    grid_in(first)
    assert len(state.position.value) == 12, "a mesh beside it, which nothing links"
    region = root.addChild("second").addObject("BoxROI", name="region", box=[-1, -1, -1, 9, 9, 9], position="@../later/mesh.position")
    assert len(region.indices.value) == 0
    later = root.addChild("later")
    mesh = later.addObject("MeshTopology", name="mesh", position=[[0, 0, 0], [1, 0, 0]])
    assert len(region.indices.value) == 2, "where the text leads now"
    later.removeObject(mesh)
    later.addObject("MeshTopology", name="mesh", position=[[0, 0, 0], [1, 0, 0], [2, 0, 0]])
    assert len(region.indices.value) == 3
    quads = later.addChild("surface").addObject("QuadSetTopologyContainer", name="quads")
    assert len(quads.quads.value) == 0
    root.addChild("elsewhere").addObject("Hexa2QuadTopologicalMapping", input="@/first/grid", output=quads.getLinkPath())
    assert len(quads.quads.value) == 10, "what fills it from another node"


def test_values_follow_the_tree():
    root = Sofa.Core.Node("root")
    small, large = root.addChild("small"), root.addChild("large")
    small.addObject("MechanicalObject", position=[[0, 0, 0]])
    grid_in(large)
    large.addObject("MechanicalObject")
    part = small.addChild("part")
    region = part.addObject("BoxROI", box=[-1, -1, -1, 9, 9, 9])
    assert len(region.indices.value) == 1
    large.moveChild(part)
    assert len(region.indices.value) == 12, "the state above is another one"
    alone = Sofa.Core.Node("alone")
    inner = grid_in(alone.addChild("inner"))
    assert len(inner.position.value) == 12
    root.addChild(alone)
    inner.n = [2, 2, 2]
    assert len(inner.position.value) == 8 and root["alone.inner.grid"] is inner


def test_values_of_python_are_read_anew():
    class Doubled(Sofa.Core.DataEngine):
        def __init__(self, *arguments, **values):
            Sofa.Core.DataEngine.__init__(self, *arguments, **values)
            self.addData("given", value=[[0.0, 0, 0]], type="vector<Vec3d>")
            self.addData("made", value=[[0.0, 0, 0]], type="vector<Vec3d>")
            self.addInput(self.given)
            self.addOutput(self.made)

        def update(self):
            self.made.value = np.vstack([self.given.value, self.given.value])

    root = Sofa.Core.Node("root")
    engine = root.addObject(Doubled(name="doubled"))
    region = root.addObject("BoxROI", box=[-1, -1, -1, 9, 9, 9], position=engine.made)
    assert len(region.indices.value) == 2
    engine.given.value = [[0, 0, 0], [1, 0, 0]]
    assert len(region.indices.value) == 4


def test_engines_that_nothing_reads_are_computed_by_what_reads_them():
    """As in a scene that runs, of which SOFA's dialect leaves such engines out."""
    root = Sofa.Core.Node("root")
    grid_in(root)
    merged = root.addObject("JoinPoints", name="joined", points="@grid.position", distance=1.1)
    before = len(merged.findData("mergedPoints").value)
    root.addObject("BoxROI", box=[-1, -1, -1, 9, 9, 9], position="@joined.mergedPoints")
    assert before == 0 and len(merged.findData("mergedPoints").value) > 0


def test_what_was_kept_ends_with_the_start():
    root = Sofa.Core.Node("root")
    root.addObject("DefaultAnimationLoop")
    region = grid_in(root) and root.addObject("BoxROI", box=[-1, -1, -1, 0.5, 2, 2], position="@grid.position")
    assert len(region.indices.value) == 4
    Sofa.Simulation.init(root)
    assert not {"_s_register", "_s_preview"} & {*root.__dict__, *region.__dict__}
    assert len(region.indices.value) == 4


@pytest.mark.parametrize("sizes, edges, quads", [({"n": [3, 4, 2]}, 2 * 4 * 2 + 3 * 3 * 2 + 3 * 4, 2 * 3 * 2 + 2 * 4 + 3 * 3),
                                                 ({"nx": 4, "ny": 3, "nz": 1}, 3 * 3 + 4 * 2, 3 * 2), ({"n": [5, 1, 1]}, 4, 0)])
def test_grids_list_their_edges_and_faces(sizes, edges, quads):
    """Two triangles of each quad, and the edges with one diagonal in each, before a scene runs and while it does."""
    root = Sofa.Core.Node("root")
    grid = root.addObject("RegularGridTopology", min=[0, 0, 0], max=[1, 1, 1], **sizes)
    root.addObject("MechanicalObject")
    for _ in range(2):
        assert len(grid.quads.value) == quads and len(grid.triangles.value) == 2 * quads
        assert len({frozenset(edge) for edge in grid.edges.value.tolist()}) == len(grid.edges.value) == edges + quads
        assert grid.getNbEdges() == edges + quads
        Sofa.Simulation.init(root)
    assert len(root.addObject("RegularGridTopology", name="bare", n=[3, 3, 3], computeQuadList=False).quads.value) == 0


def test_springs_are_added_one_by_one():
    """Two springs side by side are as one of the sum of their stiffness: k (x - 1) = F where it comes to rest."""
    from Sofa.SofaDeformable import LinearSpring

    root = Sofa.Core.Node("root")
    root.gravity = [0, 0, 0]
    root.addObject("StaticSolver")
    root.addObject("NewtonRaphsonSolver", maxNbIterationsNewton=20)
    root.addObject("SparseLDLSolver")
    state = root.addObject("MechanicalObject", position=[[0, 0, 0], [1, 0, 0]])
    root.addObject("PartialFixedProjectiveConstraint", indices=[1], fixedDirections=[0, 1, 1])
    root.addObject("FixedProjectiveConstraint", indices=[0])
    root.addObject("ConstantForceField", indices=[1], forces=[3, 0, 0])
    springs = root.addObject("SpringForceField", object1="@.", object2="@.")
    springs.addSpring(0, 1, 10.0, 0.0, 1.0)
    springs.addSpring(LinearSpring(index1=0, index2=1, springStiffness=20, dampingFactor=0, restLength=1))
    Sofa.Simulation.init(root)
    Sofa.Simulation.animate(root, 0.01)
    assert state.position.value[1] == pytest.approx([1.1, 0, 0], abs=1e-9)
    with pytest.raises(AttributeError, match="has no springs"):
        state.addSpring(0, 1, 1, 1, 1)


def test_data_are_listed():
    root = Sofa.Core.Node("root")
    state = root.addObject("MechanicalObject", position=[0, 0, 0])
    assert "position" in [data.getName() for data in state.getDataFields()] and "position" in state.__data__
