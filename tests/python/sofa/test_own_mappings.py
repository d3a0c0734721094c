# SPDX-License-Identifier: LGPL-2.1-or-later
"""Mappings that a scene writes in Python move bodies as those of the engine do; and forces in Python on frames and numbers."""
import numpy as np
import pytest
import Sofa
import stroma
from playing import animate

SOLVERS = {"SparseLDLSolver": {}, "CGLinearSolver": {"iterations": 100, "tolerance": 1e-14, "threshold": 1e-14}}


class Lengths(Sofa.Core.Mapping_Vec3d_Vec1d):
    """Of the ways from point to point."""

    def apply(self, m, out, given):
        ways = given.value[1:] - given.value[:-1]
        lengths = np.linalg.norm(ways, axis=1)
        self.directions = ways / lengths[:, None]
        with out.writeableArray() as written:
            written[:, 0] = lengths

    def applyJ(self, m, out, given):
        with out.writeableArray() as written:
            written[:, 0] = np.einsum("ij,ij->i", self.directions, given.value[1:] - given.value[:-1])

    def applyJT(self, m, out, given):
        with out.writeableArray() as written:
            written[1:] += given.value * self.directions
            written[:-1] -= given.value * self.directions


class Carried(Sofa.Core.Mapping_Rigid3d_Vec3d):
    """Points of a frame."""

    def __init__(self, *arguments, **values):
        for name in ("input", "output"):
            values[name] = values[name].linkpath
        Sofa.Core.Mapping_Rigid3d_Vec3d.__init__(self, *arguments, **values)
        self.places = values["output"].target().position.value.copy()

    def apply(self, m, out, given):
        x, y, z, w = given.value[0, 3:]
        turn = np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                         [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                         [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])
        self.arms = self.places @ turn.T
        with out.writeableArray() as written:
            written[:] = given.value[0, :3] + self.arms

    def applyJ(self, m, out, given):
        with out.writeableArray() as written:
            written[:] = given.value[0, :3] + np.cross(given.value[0, 3:], self.arms)

    def applyJT(self, m, out, given):
        with out.writeableArray() as written:
            written[0, :3] += given.value.sum(axis=0)
            written[0, 3:] += np.cross(self.arms, given.value).sum(axis=0)


def beginning(solver, with_cable):
    root = Sofa.Core.Node("root")
    root.gravity, root.dt = [0, -9.81, 0], 0.01
    if with_cable:
        root.addObject("FreeMotionAnimationLoop")
        root.addObject("GenericConstraintSolver", tolerance=1e-12, maxIterations=1000)
    body = root.addChild("body")
    body.addObject("EulerImplicitSolver")
    body.addObject(solver, **SOLVERS[solver])
    if with_cable:
        body.addObject("LinearSolverConstraintCorrection")
    return root, body


def chain(in_python, solver, with_cable=False):
    root, body = beginning(solver, with_cable)
    state = body.addObject("MechanicalObject", name="state", position=[[0, 0, 0], [1, 0, 0], [2, 0.3, 0]])
    body.addObject("UniformMass", totalMass=3)
    body.addObject("FixedProjectiveConstraint", indices=[0])
    if with_cable:
        body.addObject("CableConstraint", indices=[1, 2], pullPoint=[0, 5, 0], value=0.5)
    below = body.addChild("lengths")
    lengths = below.addObject("MechanicalObject", name="lengths", template="Vec1", position=[[1], [1]])
    below.addObject("RestShapeSpringsForceField", stiffness=200)
    if in_python:
        below.addObject(Lengths(name="map", input=state, output=lengths))
    else:
        below.addObject("EdgeSetTopologyContainer", name="ways", edges=[[0, 1], [1, 2]], position="@../state.position")
        below.addObject("DistanceMapping", input=state.getLinkPath(), output=lengths.getLinkPath(), topology="@ways",
                        computeDistance=True, geometricStiffness=0)
    return root, state


def frame(in_python, solver, with_cable=False):
    root, body = beginning(solver, with_cable)
    state = body.addObject("MechanicalObject", name="state", template="Rigid3", position=[[0, 0, 0, 0, 0, 0, 1]])
    body.addObject("UniformMass", totalMass=1)
    below = body.addChild("points")
    points = below.addObject("MechanicalObject", name="points", position=[[1, 0, 0], [0, 1, 0.5]])
    below.addObject("ConstantForceField", indices=[0], forces=[[0, 0, 3]])
    below.addObject("RestShapeSpringsForceField", points=[1], stiffness=100)
    if with_cable:
        below.addObject("CableConstraint", indices=[1], pullPoint=[0, 5, 0], value=0.5)
    if in_python:
        below.addObject(Carried(name="map", input=state, output=points))
    else:
        below.addObject("RigidMapping", geometricStiffness=0)
    return root, state


@pytest.mark.parametrize("with_cable", [False, True])
@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("scene", [chain, frame])
def test_it_moves_as_the_mapping_of_the_engine_does(scene, solver, with_cable):
    found = []
    for in_python in (True, False):
        root, state = scene(in_python, solver, with_cable)
        Sofa.Simulation.init(root)
        animate(root, 50)
        found.append(np.array(state.position.value))
    assert np.abs(found[0] - found[1]).max() < 1e-12
    root, state = scene(True, solver, with_cable)
    start = np.array(state.position.value)
    assert np.abs(found[0] - start).max() > 0.1


def test_nodes_that_each_follow_one_take_four_products_for_a_matrix():
    class Shifted(Sofa.Core.Mapping_Vec3d_Vec3d):
        calls = 0

        def apply(self, m, out, given):
            with out.writeableArray() as written:
                written[:] = given.value + [0, 1, 0]

        def applyJ(self, m, out, given):
            self.calls += 1
            with out.writeableArray() as written:
                written[:] = given.value

        def applyJT(self, m, out, given):
            with out.writeableArray() as written:
                written += given.value

    places = np.random.default_rng(1).normal(size=(200, 3))
    root, body = beginning("SparseLDLSolver", False)
    state = body.addObject("MechanicalObject", position=places)
    body.addObject("UniformMass", totalMass=1)
    below = body.addChild("below")
    other = below.addObject("MechanicalObject", position=places + [0, 1, 0])
    below.addObject("RestShapeSpringsForceField", stiffness=10)
    mapping = below.addObject(Shifted(input=state, output=other))
    Sofa.Simulation.init(root)
    animate(root, 10)
    assert mapping.calls < 100
    x, v = 0.0, 0.0
    for _ in range(10):  # of each node, by the implicit step of its mass on a spring
        v = (v + 0.01 * (-9.81 - 10 / 0.005 * x)) / (1 + 0.01 ** 2 * 10 / 0.005)
        x += 0.01 * v
    assert np.abs(state.position.value - places - [0, x, 0]).max() < 1e-12
    assert np.abs(other.position.value - state.position.value - [0, 1, 0]).max() < 1e-12


#: all that SofaPython3 has, but those of frames in a plane
PAIRS = ["Vec1 Vec1", "Vec1 Vec2", "Vec1 Vec3", "Vec2 Vec2", "Vec2 Vec1", "Vec3 Vec3", "Vec3 Vec2", "Vec3 Vec1", "Vec6 Vec6", "Vec6 Vec3",
         "Vec6 Vec1", "Rigid3 Vec6", "Rigid3 Vec3", "Rigid3 Vec1", "Rigid3 Rigid3", "Vec3 Rigid3"]


@pytest.mark.parametrize("pair", PAIRS)
def test_a_linear_map_pulls_as_its_matrix_says(pair, capfd):
    """Springs on what follows by x = L x: of the implicit step (M + h^2 k L^T L) dv = -h k L^T (L x + h L v) in the same numbers."""
    start, end = pair.split()
    widths = [3 if name == "Rigid3" else int(name[3:]) for name in (start, end)]  # of frames only their centres are mapped
    matrix = np.random.default_rng(0).normal(size=widths[::-1])

    class Linear(getattr(Sofa.Core, f"Mapping_{start}d_{end}d")):
        def _put(self, out, given, factor):
            with out.writeableArray() as written:
                written[:, :factor.shape[0]] += given.value[:, :factor.shape[1]] @ factor.T

        def apply(self, m, out, given):
            with out.writeableArray() as written:
                written[:, :widths[1]] = given.value[:, :widths[0]] @ matrix.T

        def applyJ(self, m, out, given):
            self._put(out, given, matrix)

        def applyJT(self, m, out, given):
            self._put(out, given, matrix.T)

    frame = [0, 0, 0, 0, 0, 0, 1]
    for solver in SOLVERS:
        root, body = beginning(solver, False)
        root.gravity = [0, 0, 0]
        speed = np.arange(1.0, 1 + widths[0])
        state = body.addObject("MechanicalObject", template=start, position=[frame if start == "Rigid3" else [0] * widths[0]] * 2,
                               velocity=[[*speed, 0, 0, 0] if start == "Rigid3" else speed] * 2)
        body.addObject("UniformMass", totalMass=4)
        below = body.addChild("below")
        other = below.addObject("MechanicalObject", template=end, position=[frame if end == "Rigid3" else [0] * widths[1]] * 2)
        below.addObject("RestShapeSpringsForceField", stiffness=50, points=[0, 1])
        below.addObject(Linear(input=state, output=other))
        Sofa.Simulation.init(root)
        animate(root, 20)
        x, v, k = np.zeros(widths[0]), speed, 50 * matrix.T @ matrix
        for _ in range(20):
            v = v + np.linalg.solve(2 * np.eye(widths[0]) + 1e-4 * k, -0.01 * k @ (x + 0.01 * v))
            x = x + 0.01 * v
        near = 1e-10 if solver == "SparseLDLSolver" else 1e-7  # where conjugate gradients end
        assert np.abs(state.position.value[:, :widths[0]] - x).max() < near
        assert np.abs(other.position.value[:, :widths[1]] - matrix @ x).max() < near
    assert "is not the" not in capfd.readouterr().err


class Forgetful(Lengths):
    def applyJ(self, m, out, given):
        pass


class OneSided(Lengths):
    def applyJT(self, m, out, given):
        with out.writeableArray() as written:
            written[1:] += given.value * self.directions


def with_map(kind):
    root, body = beginning("SparseLDLSolver", False)
    state = body.addObject("MechanicalObject", position=[[0, 0, 0], [1, 0, 0], [2, 0.3, 0]])
    body.addObject("UniformMass", totalMass=3)
    below = body.addChild("lengths")
    lengths = below.addObject("MechanicalObject", template="Vec1", position=[[1], [1]])
    below.addObject("RestShapeSpringsForceField", stiffness=200)
    below.addObject(kind(name="map", input=state, output=lengths))
    return root


@pytest.mark.parametrize("kind, sentence", [(OneSided, "applyJT() is not the transposed of applyJ()"),
                                            (Forgetful, "applyJ() is not the derivative of apply()")])
def test_what_does_not_belong_together_is_told(kind, sentence, capfd):
    root = with_map(kind)
    Sofa.Simulation.init(root)
    animate(root, 2)
    assert sentence in capfd.readouterr().err


def test_errors_come_out():
    class Failing(Lengths):
        def applyJ(self, m, out, given):
            raise RuntimeError("of the scene")

    with pytest.raises(RuntimeError, match="of the scene"):
        root = with_map(Failing)
        Sofa.Simulation.init(root)
        animate(root, 1)

    class Empty(Sofa.Core.Mapping_Vec3d_Vec1d):
        pass

    with pytest.raises(NotImplementedError, match=r"a mapping needs apply\(\)"):
        root = with_map(Empty)
        Sofa.Simulation.init(root)
        animate(root, 1)


# ---- forces in Python on other states than points ----
class OfFrames(Sofa.Core.ForceFieldRigid3d):
    def addForce(self, m, out, place, velocity):
        with out.writeableArray() as written:
            written[:, :3] -= 100 * (place.value[:, :3] - [1, 0, 0])
            written[:, 3:] -= 0.5 * velocity.value[:, 3:]

    def addDForce(self, df, dx, m, b):
        with df.writeableArray() as written:
            written[:, :3] -= 100 * m["kFactor"] * dx.value[:, :3]


class OfNumbers(Sofa.Core.ForceFieldVec1d):
    def addForce(self, m, out, place, velocity):
        with out.writeableArray() as written:
            written -= 50 * place.value

    def addKToMatrix(self, m, nodes, width):
        return -50 * np.eye(nodes * width)


def implicit(x, k, mass, target):
    v = 0.0
    for _ in range(50):
        v = (v + 0.01 * k / mass * (target - x)) / (1 + 0.01 ** 2 * k / mass)
        x += 0.01 * v
    return x


@pytest.mark.parametrize("solver", SOLVERS)
def test_forces_on_frames_and_on_numbers(solver):
    root, body = beginning(solver, False)
    root.gravity = [0, 0, 0]
    state = body.addObject("MechanicalObject", template="Rigid3", position=[[0, 0, 0, 0, 0, 0, 1], [0, 1, 0, 0, 0, 0, 1]])
    body.addObject("UniformMass", totalMass=1)
    body.addObject(OfFrames())
    Sofa.Simulation.init(root)
    animate(root, 50)
    assert np.abs(state.position.value[:, 0] - implicit(0, 100, 0.5, 1)).max() < 1e-12
    assert abs(state.position.value[1, 1] - implicit(1, 100, 0.5, 0)) < 1e-12

    root, body = beginning(solver, False)
    state = body.addObject("MechanicalObject", template="Vec1", position=[[1], [2]])
    body.addObject("UniformMass", vertexMass=1)
    body.addObject(OfNumbers())
    Sofa.Simulation.init(root)
    animate(root, 50)
    assert np.abs(state.position.value.ravel() - [implicit(1, 50, 1, 0), implicit(2, 50, 1, 0)]).max() < 1e-12


class Doubled(Sofa.Core.Mapping_Vec3d_Vec3d):
    def apply(self, m, out, given):
        with out.writeableArray() as written:
            written[:] = 2 * given.value

    applyJ = apply

    def applyJT(self, m, out, given):
        with out.writeableArray() as written:
            written[:] += 2 * given.value


@pytest.mark.parametrize("is_mapped", [True, False])
def test_a_mapping_passes_forces_on_only_where_it_says_so(is_mapped):
    root = Sofa.Core.Node("root")
    root.gravity, root.dt = [0, 0, 0], 0.01
    root.addObject("EulerImplicitSolver")
    root.addObject("SparseLDLSolver")
    root.addObject("MechanicalObject", name="dofs", position=[[1, 0, 0]])
    root.addObject("UniformMass", totalMass=1)
    child = root.addChild("child")
    child.addObject("MechanicalObject", name="dofs", position=[[2, 0, 0]])
    child.addObject(Doubled(name="map", input="@../dofs", output="@dofs", mapForces=is_mapped))
    child.addObject("ConstantForceField", force=[0, 3, 0])
    Sofa.Simulation.init(root)
    animate(root, 1)
    assert root.dofs.velocity.value[0][1] == pytest.approx(0.06 if is_mapped else 0, abs=1e-12)
