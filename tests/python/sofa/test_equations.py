# SPDX-License-Identifier: LGPL-2.1-or-later
"""What linear systems, linear solvers and constraint solvers tell of the last step, against what NumPy makes of its parts."""
import numpy as np
import pytest
import Sofa
from playing import run
from Sofa import SofaConstraintSolver, SofaLinearSolver, SofaLinearSystem  # noqa: F401

H, RM, RK = 0.02, 0.3, 0.05


def body(root, name="body", linear="SparseLDLSolver", **options):
    """Six springs between four points, the first of which is held."""
    node = root.addChild(name)
    node.addObject("EulerImplicitSolver", name="ode", rayleighMass=RM, rayleighStiffness=RK)
    node.addObject(linear, name="linear", **options)
    node.addObject("MechanicalObject", name="state", position=[[0, 0, 0], [1, 0, 0.1], [0, 1, 0], [0.2, 0, 1]],
                   velocity=[[0, 0, 0], [1, 2, 3], [0, 1, 0], [-1, 0, 0.5]])
    node.addObject("UniformMass", name="mass", vertexMass=0.5)
    node.addObject("SpringForceField", name="springs", spring=[0, 1, 100, 0, 1, 0, 2, 80, 0, 0.9, 0, 3, 70, 0, 1, 1, 2, 60, 0, 1.2,
                                                               1, 3, 50, 0, 1.5, 2, 3, 40, 0, 1])
    node.addObject("FixedProjectiveConstraint", indices=[0])
    return node


def scene(**options):
    root = Sofa.Core.Node("root")
    root.dt, root.gravity = H, [0, -9.81, 0]
    return root, body(root, **options)


def held(matrix, numbers):
    """Rows and columns of what is held: ones on the diagonal."""
    matrix = np.array(matrix)
    matrix[numbers] = 0
    matrix[:, numbers] = 0
    matrix[numbers, numbers] = 1
    return matrix


@pytest.mark.parametrize("linear, options", [("SparseLDLSolver", {}), ("CGLinearSolver", dict(iterations=200, tolerance=1e-14, threshold=1e-30))])
def test_the_matrix_and_the_right_side_are_those_of_the_step(linear, options):
    root, node = scene(linear=linear, **options)
    system = node.addObject("MatrixLinearSystem", name="system", template="CompressedRowSparseMatrixMat3x3d")
    Sofa.Simulation.init(root)
    for _ in range(3):
        stiffness, mass = node.springs.assembleKMatrix().toarray(), node.mass.assembleMMatrix().toarray()
        before, speeds = np.array(node.state.position.value), node.state.velocity.value.ravel()
        force = np.array(node.mass.assembleMMatrix() @ np.tile([0, -9.81, 0], 4)) + springs(before)
        Sofa.Simulation.animate(root, H)
        matrix = held((1 + H * RM) * mass - H * (H + RK) * stiffness, [0, 1, 2])
        right = H * (force + (H + RK) * stiffness @ speeds - RM * mass @ speeds)
        right[:3] = 0
        for each in (node.linear, system):
            assert each.A().toarray() == pytest.approx(matrix, rel=1e-9, abs=1e-9) and each.A().shape == (12, 12)
            assert each.b() == pytest.approx(right, rel=1e-9, abs=1e-9)
            assert each.x() == pytest.approx(node.state.velocity.value.ravel() - speeds, abs=1e-9)
        assert node.linear.A() @ node.linear.x() == pytest.approx(right, abs=1e-9)
        assert system.get_system_matrix().nnz == node.linear.A().nnz and len(system.get_rhs_vector()) == 12


def springs(x):
    force = np.zeros_like(x)
    for a, b, stiffness, length in ((0, 1, 100, 1), (0, 2, 80, 0.9), (0, 3, 70, 1), (1, 2, 60, 1.2), (1, 3, 50, 1.5), (2, 3, 40, 1)):
        way = x[b] - x[a]
        pull = stiffness * (np.linalg.norm(way) - length) * way / np.linalg.norm(way)
        force[a] += pull
        force[b] -= pull
    return force.ravel()


@pytest.mark.parametrize("linear, options", [("SparseLDLSolver", {}), ("CGLinearSolver", dict(iterations=60, tolerance=1e-9, threshold=1e-9))])
def test_who_asks_changes_no_bit(linear, options):
    ends = []
    for asks in (False, True):
        root, node = scene(linear=linear, **options)
        Sofa.Simulation.init(root)
        for _ in range(5):
            Sofa.Simulation.animate(root, H)
            if asks:
                node.linear.A()
        ends.append(np.array(node.state.position.value))
    assert np.array_equal(*ends)


def test_states_come_in_the_order_of_the_tree():
    root = Sofa.Core.Node("root")
    root.dt = 0.1
    root.addObject("EulerImplicitSolver")
    root.addObject("SparseLDLSolver", name="linear")
    for name, template, place, mass in (("frame", "Rigid3d", [0, 0, 0, 0, 0, 0, 1], 2), ("points", "Vec3d", [[0, 0, 0], [1, 0, 0]], 3)):
        node = root.addChild(name)
        node.addObject("MechanicalObject", template=template, position=place)
        node.addObject("UniformMass", vertexMass=mass if template == "Vec3d" else "2 1 [1 0 0 0 1 0 0 0 1]")
    Sofa.Simulation.init(root)
    Sofa.Simulation.animate(root, 0.1)
    assert root.linear.A().toarray() == pytest.approx(np.diag([2] * 6 + [3] * 6), abs=1e-12)
    assert root.linear.b()[:6] == pytest.approx([0, -9.81 * 0.2, 0, 0, 0, 0], abs=1e-12)


def test_two_bodies_have_equations_of_their_own():
    root = Sofa.Core.Node("root")
    root.dt = H
    first, second = body(root, "first"), body(root, "second")
    second.mass.vertexMass = 5
    shared = root.addChild("above").addObject("CGLinearSolver", name="none")
    Sofa.Simulation.init(root)
    Sofa.Simulation.animate(root, H)
    assert first.linear.A()[3, 3] < second.linear.A()[3, 3]
    with pytest.raises(RuntimeError, match="is of 2 systems of equations"):
        shared.A()


def held_by_lagrange(root, stiffness):
    root.dt, root.gravity = 0.01, [0, -10, 0]
    root.addObject("FreeMotionAnimationLoop")
    root.addObject("GenericConstraintSolver", name="solver", tolerance=1e-12, maxIterations=1000)
    node = root.addChild("body")
    node.addObject("EulerImplicitSolver")
    node.addObject("SparseLDLSolver", name="linear")
    node.addObject("MechanicalObject", name="state", position=[[0, 0, 0], [1, 0, 0]])
    node.addObject("UniformMass", vertexMass=2)
    if stiffness:
        node.addObject("RestShapeSpringsForceField", stiffness=stiffness)
    node.addObject("FixedLagrangianConstraint", indices=[1])
    node.addObject("LinearSolverConstraintCorrection")
    Sofa.Simulation.init(root)
    Sofa.Simulation.animate(root, 0.01)
    return root


@pytest.mark.parametrize("stiffness", [0, 1e4])
def test_compliance_of_a_held_point(stiffness):
    """An impulse changes the velocity of a mass by 1 / (m + h^2 k), and where it comes to by h times that."""
    root = held_by_lagrange(Sofa.Core.Node("root"), stiffness)
    assert root.solver.W() == pytest.approx(0.01 / (2 + 1e-4 * stiffness) * np.eye(3), abs=1e-12)
    assert sorted(np.abs(root.solver.lambda_force())) == pytest.approx([0, 0, 2 * 10 * 0.01], abs=1e-9)
    assert root.body.linear.A().shape == (6, 6)


def test_what_is_not_there_is_told():
    root, node = scene()
    with pytest.raises(RuntimeError, match="/body/linear: there are no equations before the scene is initialised"):
        node.linear.A()
    assert not hasattr(node.mass, "A")
    with pytest.raises(AttributeError, match=r"A\(\) is one of linear solvers and linear systems, and not of a UniformMass"):
        node.mass.A()
    Sofa.Simulation.init(root)
    with pytest.raises(Exception, match="has solved no linear system since it is watched"):
        node.linear.A()


SCENE = """import Sofa
{imports}
class Look(Sofa.Core.Controller):
    def onAnimateEndEvent(self, event):
        solver = self.getContext().linear
        print("left", abs(solver.A() @ solver.x() - solver.b()).max() < 1e-9, solver.A().shape)

def createScene(root):
    root.addObject("EulerImplicitSolver")
    root.addObject("SparseLDLSolver", name="linear")
    root.addObject("MechanicalObject", position=[[0, 0, 0]])
    root.addObject("UniformMass", totalMass=1)
    root.addObject(Look(name="look"))
"""


def test_the_command_has_them_too(tmp_path):
    (tmp_path / "scene.py").write_text(SCENE.format(imports="from Sofa import SofaLinearSolver\n"))
    done = run("run", tmp_path / "scene.py", "-n", 3, "--no-record", folder=tmp_path)
    assert done.returncode == 0 and done.stdout.count("left True (3, 3)") == 3, done.stderr


def test_without_the_module_nothing_is_kept(tmp_path):
    (tmp_path / "scene.py").write_text(SCENE.format(imports=""))
    done = run("run", tmp_path / "scene.py", "-n", 3, "--no-record", folder=tmp_path)
    assert done.returncode == 3 and "the equations of steps are kept where the program imports Sofa.SofaLinearSystem" in done.stderr, done.stderr
    assert "scene.py:6: AttributeError" in done.stderr, "the line that asks"


# ---- J on the nodes of a state ----

class Reads(Sofa.Core.Controller):
    """Forces of contact on each node, as scenes compute them from the text of `constraint`."""

    def __init__(self, root, **values):
        super().__init__(**values)
        self.root, self.found = root, []

    def onAnimateEndEvent(self, event):
        impulses = np.array(self.root.solver.constraintForces.value)
        numbers = np.array([float(word) for word in str(self.root.box.corners.state.constraint.value).split()])
        on_corners = np.zeros((4, 3))
        at = 0
        while at < len(numbers):
            row, count = int(numbers[at]), int(numbers[at + 1])
            at += 2
            for _ in range(count):
                on_corners[int(numbers[at])] += numbers[at + 1:at + 4] * impulses[row]
                at += 4
        whole = self.root.box.state.constraint.value
        on_box = whole.toarray().T @ impulses if len(impulses) else np.zeros(6)
        self.found.append((len(impulses), on_corners, on_box, self.root.box.corners.state.findData("lambda").value,
                           self.root.box.state.findData("lambda").value, self.root.solver.W() if len(impulses) else None, impulses))


def sliding_box(friction):
    root = Sofa.Core.Node("root")
    root.dt, root.gravity = 0.01, [0, -10, 0]
    for word in ("FreeMotionAnimationLoop", "CollisionPipeline", "BruteForceBroadPhase", "BVHNarrowPhase"):
        root.addObject(word)
    root.addObject("GenericConstraintSolver", name="solver", tolerance=1e-12, maxIterations=1000, computeConstraintForces=True)
    root.addObject("LocalMinDistance", alarmDistance=0.3, contactDistance=0.05)
    root.addObject("CollisionResponse", response="FrictionContactConstraint", responseParams=f"mu={friction}")
    box = root.addChild("box")
    box.addObject("EulerImplicitSolver")
    box.addObject("SparseLDLSolver")
    box.addObject("MechanicalObject", name="state", template="Rigid3d", position=[0, 0.57, 0, 0, 0, 0, 1], velocity=[2, 0, 1, 0, 0, 0])
    box.addObject("UniformMass", vertexMass="3 1 [0.5 0 0 0 0.5 0 0 0 0.5]")
    box.addObject("LinearSolverConstraintCorrection")
    corners = box.addChild("corners")
    corners.addObject("MechanicalObject", name="state", position=[[1, -0.5, 1], [-1, -0.5, 1], [1, -0.5, -1], [-1, -0.5, -1.2]])
    corners.addObject("PointCollisionModel")
    corners.addObject("RigidMapping")
    floor = root.addChild("floor")
    floor.addObject("MeshTopology", position=[[-90, 0, -90], [90, 0, -90], [0, 0, 90]], triangles=[[0, 2, 1]])
    floor.addObject("MechanicalObject")
    floor.addObject("TriangleCollisionModel", moving=False, simulated=False)
    reads = root.addObject(Reads(root, name="reads"))
    Sofa.Simulation.init(root)
    return root, reads


@pytest.mark.parametrize("friction", [0, 0.3])
def test_gradients_times_impulses_are_the_impulses_on_nodes(friction):
    root, reads = sliding_box(friction)
    for _ in range(8):
        Sofa.Simulation.animate(root, 0.01)
    touched = [each for each in reads.found if each[0]]
    assert len(touched) > 3 and touched[-1][0] == 4 * (3 if friction else 1)
    for count, on_corners, on_box, told_of_corners, told_of_box, compliance, impulses in touched:
        assert on_corners == pytest.approx(told_of_corners, abs=1e-9) and on_corners[:, 1].min() >= -1e-12
        assert on_box == pytest.approx(told_of_box.ravel(), abs=1e-9)
        assert compliance.shape == (count, count) and compliance == pytest.approx(compliance.T, abs=1e-12)
        assert np.linalg.eigvalsh(compliance).min() > -1e-12
        if count == (12 if friction else 4):  # dt (1/m + (r x n)^2 / J), n along y
            expected = [0.01 * (1 / 3 + (x ** 2 + z ** 2) / (3 * 0.5)) for x, z in ((1, 1), (-1, 1), (1, -1), (-1, -1.2))]
            assert sorted(np.diag(compliance)[::count // 4]) == pytest.approx(sorted(expected), rel=0.01)
    assert root.solver.W().shape == (touched[-1][0],) * 2


def test_what_no_controller_names_is_not_kept():
    root = held_by_lagrange(Sofa.Core.Node("root"), 0)
    matrix = root.body.state.constraint.value
    assert matrix.shape == (3, 6) and matrix.toarray()[:, 3:] == pytest.approx(np.eye(3)) and str(matrix).splitlines()[1] == "1 1 1 0 1 0"


def test_a_spring_is_taken_away():
    root, node = scene()
    assert len(node.springs.spring.value) == 30
    node.springs.removeSpring(1)
    assert node.springs.spring.value[5:7].tolist() == [0, 3] and len(node.springs.spring.value) == 25
    with pytest.raises(IndexError, match="there is no spring 5: there are 5"):
        node.springs.removeSpring(5)


@pytest.mark.parametrize("kind", ["box", "SparseLDLSolver", "CGLinearSolver", "AutomaticLinearSolver"])
def test_a_run_whose_equations_are_kept_has_the_bits_of_another_one(kind, monkeypatch):
    monkeypatch.setattr(Reads, "onAnimateEndEvent", lambda self, event: None)
    ends = []
    for kept in (False, True):
        monkeypatch.setattr("Sofa._equations.are_wanted", lambda: kept)  # noqa: B023
        monkeypatch.setattr("Sofa._equations.asks_for_gradients", lambda listeners: kept)  # noqa: B023
        if kind == "box":
            root = sliding_box(0.3)[0]
            state = root.box.state
        else:
            root, node = scene(linear=kind)
            Sofa.Simulation.init(root)
            state = node.state
        for _ in range(12):
            Sofa.Simulation.animate(root, 0.01)
        ends.append(np.array([*state.position.value.ravel(), *state.velocity.value.ravel()]))
    assert np.array_equal(*ends)


def test_after_a_change_of_the_mesh_the_equations_are_those_of_a_step_with_it():
    root = Sofa.Core.Node("root")
    root.dt = H
    node = root.addChild("body")
    node.addObject("EulerImplicitSolver", name="ode")
    node.addObject("SparseLDLSolver", name="linear")
    node.addObject("TetrahedronSetTopologyContainer", name="mesh", position=[[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]],
                   tetrahedra=[[0, 1, 2, 3], [1, 2, 3, 4]])
    node.addObject("TetrahedronSetTopologyModifier", name="modifier")
    node.addObject("MechanicalObject", name="state")
    node.addObject("UniformMass", totalMass=1)
    Sofa.Simulation.init(root)
    with pytest.raises(RuntimeError, match="since it is watched"):
        node.linear.A()
    Sofa.Simulation.animate(root, H)
    assert node.linear.A().shape == (15, 15)
    node.modifier.removeTetrahedra([1])
    with pytest.raises(RuntimeError, match="since a mesh of the scene has changed"):
        node.linear.A()
    Sofa.Simulation.animate(root, H)
    assert node.linear.A().shape == (12, 12)


def tied(tolerance, **options):
    """Eight springs in a row, which are tied at their ends."""
    n, root = 8, Sofa.Core.Node("root")
    root.dt, root.gravity = 0.01, [0, -9.81, 0]
    root.addObject("FreeMotionAnimationLoop")
    root.addObject("GenericConstraintSolver", name="solver", tolerance=tolerance, maxIterations=1000, **options)
    node = root.addChild("body")
    node.addObject("EulerImplicitSolver")
    node.addObject("SparseLDLSolver")
    node.addObject("MechanicalObject", name="state", position=[[k // 2 + k % 2, 0, 0] for k in range(2 * n)])
    node.addObject("UniformMass", totalMass=2 * n)
    node.addObject("SpringForceField", spring=[number for k in range(n) for number in (2 * k, 2 * k + 1, 1e4, 0, 1)])
    node.addObject("FixedLagrangianConstraint", indices=[0])
    node.addObject("BilateralLagrangianConstraint", first_point=list(range(1, 2 * n - 1, 2)), second_point=list(range(2, 2 * n, 2)))
    node.addObject("GenericConstraintCorrection")
    Sofa.Simulation.init(root)
    return root


def gap(root, steps):
    for _ in range(steps):
        Sofa.Simulation.animate(root, 0.01)
    x = root.body.state.position.value
    return np.linalg.norm(x[1:-1:2] - x[2::2], axis=1).max()


def test_a_tolerance_that_changes_in_a_run_counts():
    root = tied(0.1)
    assert gap(root, 10) > 1e-5
    root.solver.tolerance = 1e-10
    assert gap(root, 10) < 1e-9 and root.solver.tolerance.value == 1e-10
    root.solver.tolerance, root.solver.resolutionMethod = 0.1, "UnbuiltGaussSeidel"
    assert gap(root, 10) > 1e-5
    root.solver.tolerance.value = 1e-10
    assert gap(root, 10) < 1e-9
    with pytest.raises(RuntimeError, match="/solver.sor: -1"):
        root.solver.sor = -1
    Sofa.Simulation.animate(root, 0.01)


# ---- nodes that answer by themselves ----
def alone(template, **correction):
    """A body that is held by forces of constraint; of frames one with three moments of inertia, which is turned."""
    root = Sofa.Core.Node("root")
    root.dt, root.gravity = H, [0, -9.81, 0]
    root.addObject("FreeMotionAnimationLoop")
    root.addObject("GenericConstraintSolver", name="solver", tolerance=1e-12, maxIterations=1000)
    node = root.addChild("body")
    node.addObject("EulerImplicitSolver")
    node.addObject("SparseLDLSolver", name="linear")
    if template == "Rigid3":
        half = np.sqrt(0.5)
        node.addObject("MechanicalObject", name="state", template="Rigid3", position=[[0, 0, 0, half, 0, 0, half]])
        node.addObject("UniformMass", name="mass", vertexMass="2 1 [0.2 0 0 0 0.3 0 0 0 0.4]")
        points = node.addChild("points")
        points.addObject("MechanicalObject", name="points", position=[[0.5, 0, 0]])
        points.addObject("RigidMapping")
        points.addObject("CableConstraint", indices=[0], pullPoint=[0, 3, 4], value=0.01)
    else:
        node.addObject("MechanicalObject", name="state", position=[[0, 0, 0], [1, 0, 0]])
        node.addObject("UniformMass", name="mass", totalMass=3)
        node.addObject("SpringForceField", spring=[0, 1, 500, 0, 1])
        node.addObject("CableConstraint", indices=[1], pullPoint=[1, 2, 0], value=0.01)
    node.addObject("UncoupledConstraintCorrection", **correction)
    return root, node


@pytest.mark.parametrize("template, correction, expected", [
    ("Vec3", {"defaultCompliance": 0.01}, 0.01), ("Vec3", {"compliance": [0.1, 0.02]}, 0.02), ("Vec3", {}, 1e-5), ("Rigid3", {}, None),
    ("Rigid3", {"compliance": [0.5, 3, 0, 0, 4, 0, 5]}, None)])
def test_w_of_nodes_that_answer_by_themselves(template, correction, expected):
    root, node = alone(template, **correction)
    Sofa.Simulation.init(root)
    # in SOFA inertia stays in the axes of the world
    if template == "Rigid3":
        assert node.mass.assembleMMatrix().toarray() == pytest.approx(np.diag([2, 2, 2, 0.4, 0.6, 0.8]), abs=1e-12)
    Sofa.Simulation.animate(root, H)
    if template == "Rigid3":  # n . (1/m + [r]^T I^-1 [r]) n, with the point at r = (1/2, 0, 0)
        way = np.array([0, 3, 4]) - [0.5, 0, 0]
        arm = np.array([0.5, 0, 0])
        if correction:
            mass, inverse = 0.5, np.diag([3.0, 4.0, 5.0])
        else:
            mass, inverse = 0.5, np.diag([1 / 0.4, 1 / 0.6, 1 / 0.8])
        way = way / np.linalg.norm(way)
        turned = np.cross(arm, way)
        expected = mass + turned @ inverse @ turned
    assert root.solver.W() == pytest.approx(H * np.array([[expected]]), rel=5e-3)


# ---- what constraints would measure without their forces ----
def measured(kind, is_free):
    """A step of a body with one constraint, whose force is its own or, where it is free, none."""
    root = Sofa.Core.Node("root")
    root.dt, root.gravity = H, [0.3, -9.81, 0.2]
    root.addObject("FreeMotionAnimationLoop")
    root.addObject("GenericConstraintSolver", name="solver", tolerance=1e-14, maxIterations=1000)
    node = root.addChild("body")
    node.addObject("EulerImplicitSolver")
    node.addObject("SparseLDLSolver")
    node.addObject("MechanicalObject", name="state", position=[[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    node.addObject("UniformMass", totalMass=4)
    node.addObject("SpringForceField", spring=[0, 1, 100, 0, 1, 0, 2, 100, 0, 1, 0, 3, 100, 0, 1, 1, 2, 50, 0, 1.5])
    node.addObject("GenericConstraintCorrection")
    if kind == "cable":
        given = dict(valueType="force", value=0) if is_free else dict(valueType="displacement", value=0.003)
        node.addObject("CableConstraint", name="held", indices=[2], pullPoint=[0, 5, 0], **given)
    elif kind == "cavity":
        given = dict(valueType="pressure", value=0) if is_free else dict(valueType="volumeGrowth", value=0.0006)
        node.addObject("SurfacePressureConstraint", name="held", triangles=[[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], **given)
    elif not is_free:
        node.addObject("FixedLagrangianConstraint", name="held", indices=[1])
    Sofa.Simulation.init(root)
    Sofa.Simulation.animate(root, H)
    if kind == "fixed":
        way = node.state.position.value[1] - [1, 0, 0]
    else:
        way = np.ravel(node.held.displacement.value if kind == "cable" else node.held.volumeGrowth.value)
    return root, np.array(way, dtype=float)


@pytest.mark.parametrize("kind", ["cable", "cavity", "fixed"])
def test_dfree_is_what_a_step_without_the_forces_measures(kind):
    root, way = measured(kind, False)
    _, free = measured(kind, True)
    found = root.solver.dfree()
    assert found == pytest.approx(free, abs=2e-3 * np.abs(way - free).max())  # the way is curved a little
    assert np.abs(way - free).max() > 1e-3 or kind == "cavity"


def test_dfree_is_refused_beside_contacts():
    root, _ = sliding_box(0)
    for _ in range(8):
        Sofa.Simulation.animate(root, 0.01)
    with pytest.raises(RuntimeError, match=r"dfree\(\) is offered for cables"):
        root.solver.dfree()
