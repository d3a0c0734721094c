# SPDX-License-Identifier: LGPL-2.1-or-later
"""Force fields written in Python against those of the engine."""
import gc
import weakref

import numpy
import pytest
import stroma


class Springs(stroma.ForceField):
    """Each node is pulled to where it was at rest."""

    linear = True

    def force(self, x, v, t):
        return -self.k * (x - self.rest)

    def energy(self, x):
        return 0.5 * self.k * ((x - self.rest) ** 2).sum()

    def stiffness(self, x, v, t):
        return numpy.broadcast_to(-self.k * numpy.eye(3), (len(x), 3, 3))


POINTS = numpy.random.default_rng(3).normal(size=(20, 3))


def scene(field=None, solver="EulerImplicitSolver", linear="CGLinearSolver"):
    root = stroma.Node("root", dt=0.01, gravity=(0, -9.81, 0))
    root.add(solver)
    if linear:
        root.add(linear, **({"iterations": 100, "tolerance": 1e-14} if linear == "CGLinearSolver" else {}))
    root.add("MechanicalObject", name="dofs", position=POINTS)
    root.add("UniformMass", totalMass=4)
    if field is not None:
        root.add(field, name="springs")
    else:
        root.add("RestShapeSpringsForceField", name="springs", stiffness=300, points=list(range(20)))
    return root


@pytest.mark.parametrize("linear", ["CGLinearSolver", "SparseLDLSolver"])
def test_a_field_in_python_is_that_of_the_engine(linear):
    mine, theirs = stroma.load(scene(Springs(k=300.0, rest=POINTS), linear=linear)), stroma.load(scene(linear=linear))
    mine.run(20), theirs.run(20)
    assert numpy.abs(mine.state().x - POINTS).max() > 1e-3
    assert numpy.allclose(mine.state().x, theirs.state().x, rtol=0, atol=1e-11)
    assert mine.energies()["elastic"] == pytest.approx(theirs.energies()["elastic"], rel=1e-9)


def test_without_a_stiffness_it_is_explicit():
    class Pull(stroma.ForceField):
        def force(self, x, v, t):
            return numpy.tile([1.0, 0, 0], (len(x), 1))
    simulation = stroma.load(scene(Pull()))
    simulation.run(10)
    plain = stroma.load(scene(Pull()), set={"gravity": "0 0 0"})
    plain.run(10)
    assert numpy.allclose(plain.state().v[:, 0], 10 * 0.01 * 1.0 / 0.2)


@pytest.mark.parametrize("solver, first", [("EulerImplicitSolver", 1), ("EulerExplicitSolver", 0)])
def test_a_force_is_told_the_time(solver, first):
    class Growing(stroma.ForceField):
        def force(self, x, v, t):
            return numpy.tile([0.2 * t, 0, 0], (len(x), 1))  # 0.2 kg of each node
    simulation = stroma.load(scene(Growing(), solver, "CGLinearSolver" if first else None), set={"gravity": "0 0 0"})
    simulation.run(10)
    assert numpy.allclose(simulation.state().v[:, 0], 0.01 * sum(0.01 * (first + step) for step in range(10)), rtol=1e-12)


def test_sparse_matrices_of_scipy():
    sparse = pytest.importorskip("scipy.sparse")

    class Chain(stroma.ForceField):
        """Springs of length zero between neighbours."""
        linear = True

        def matrix(self, n):
            each = sparse.diags([numpy.full(n - 1, 1.0), numpy.r_[-1, numpy.full(n - 2, -2.0), -1], numpy.full(n - 1, 1.0)], [-1, 0, 1])
            return 50 * sparse.kron(each, numpy.eye(3), format="bsr")

        def force(self, x, v, t):
            return (self.matrix(len(x)) @ x.ravel()).reshape(-1, 3)

        def stiffness(self, x, v, t):
            return self.matrix(len(x))

    direct, iterative = (stroma.load(scene(Chain(), linear=linear)) for linear in ("SparseLDLSolver", "CGLinearSolver"))
    direct.run(10), iterative.run(10)
    assert numpy.allclose(direct.state().x, iterative.state().x, rtol=0, atol=1e-10)
    stiffness = direct.matrix("stiffness").toarray()
    assert numpy.allclose(stiffness, Chain().matrix(20).toarray())


def test_what_a_field_throws_comes_out_and_the_step_is_not_taken():
    class Fails(Springs):
        def force(self, x, v, t):
            if self.count == 7:
                raise ZeroDivisionError("in my force")
            self.count += 1
            return super().force(x, v, t)
    field = Fails(k=10.0, rest=POINTS, count=0)
    simulation = stroma.load(scene(field))
    with pytest.raises(ZeroDivisionError, match="in my force"):
        simulation.run(100)
    steps, before = simulation.steps, simulation.hash
    with pytest.raises(ZeroDivisionError):
        simulation.step()
    assert simulation.hash == before and simulation.steps == steps
    field.count = 100
    simulation.run(3)
    assert simulation.steps == steps + 3


def test_what_a_field_says_of_itself_is_checked():
    good = Springs(k=10.0, rest=POINTS).check(POINTS + 0.1)
    assert set(good) == {"energy", "stiffness"} and max(good.values()) < 1e-6

    class Wrong(Springs):
        def energy(self, x):
            return 0.4 * self.k * ((x - self.rest) ** 2).sum()
    assert Wrong(k=10.0, rest=POINTS).check(POINTS + 0.1)["energy"] > 0.1

    class Circular(Springs):
        def stiffness(self, x, v, t):
            return numpy.broadcast_to(numpy.array([[-self.k, 1, 0], [-1, -self.k, 0], [0, 0, -self.k]]), (len(x), 3, 3))
    with pytest.raises(ValueError, match="symmetric = False"):
        stroma.load(scene(Circular(k=300.0, rest=POINTS))).step()
    Circular.symmetric = False
    with pytest.raises(stroma.SceneError, match="symmetric systems only"):
        stroma.load(scene(Circular(k=300.0, rest=POINTS)))
    stroma.load(scene(Circular(k=300.0, rest=POINTS), linear="EigenSparseLU")).step()


def test_wrong_shapes_are_told():
    class Wrong(stroma.ForceField):
        def force(self, x, v, t):
            return numpy.zeros(7)
    with pytest.raises(ValueError, match=r"/springs.*\(20, 3\)"):
        stroma.load(scene(Wrong())).step()


def test_complex_forces_are_refused():
    class Wrong(stroma.ForceField):
        def force(self, x, v, t):
            return x + 1j
    with pytest.raises(TypeError, match="complex"):
        stroma.load(scene(Wrong())).step()


def test_a_field_sees_no_memory_of_the_engine():
    kept = []

    class Keeps(Springs):
        def force(self, x, v, t):
            kept.append(x)
            return super().force(x, v, t)
    simulation = stroma.load(scene(Keeps(k=10.0, rest=POINTS)))
    simulation.run(2)
    copies = [x.copy() for x in kept]
    del simulation
    gc.collect()
    assert all(numpy.array_equal(x, y) for x, y in zip(kept, copies)) and kept[0].flags.owndata


def test_copies_and_matrices_have_it_too():
    simulation = stroma.load(scene(Springs(k=300.0, rest=POINTS)))
    simulation.run(3)
    twin = simulation.copy()
    twin.run(3), simulation.run(3)
    assert twin.hash == simulation.hash
    assert numpy.allclose(simulation.matrix("stiffness").toarray(), -300 * numpy.eye(60))


@pytest.mark.parametrize("sleep", [0, 1e-4])
def test_a_sleeping_body_feels_what_a_program_changes(sleep):
    field = Springs(k=50, rest=POINTS[:1].copy())
    root = stroma.Node("root", dt=0.01, gravity=(0, 0, 0))
    root.add("EulerImplicitSolver", name="solver", rayleighMass=20, sleepDistance=sleep, sleepTime=0.3)
    root.add("SparseLDLSolver")
    root.add("MechanicalObject", name="dofs", position=POINTS[:1])
    root.add("UniformMass", totalMass=1)
    root.add(field, name="springs")
    simulation = stroma.load(root)
    simulation.run(100)
    assert (simulation.component("/solver").stepsAsleep > 0) == (sleep > 0)
    field.rest += 1
    simulation.run(200)
    assert abs(simulation.state().x - field.rest).max() < 0.01


def test_fields_die_with_what_holds_them():
    field = Springs(k=1.0, rest=POINTS)
    alive = weakref.ref(field)
    simulation = stroma.load(scene(field))
    del field
    gc.collect()
    assert alive() is not None
    simulation.step()
    del simulation
    gc.collect()
    assert alive() is None


class NeoHookean(stroma.Law):
    def density(self, F):
        log = numpy.log(self.J(F))
        return self.mu / 2 * (self.I1(F) - 3 - 2 * log) + self.la / 2 * log ** 2


@pytest.mark.parametrize("kind", ["Tetrahedron", "Hexahedron"])
def test_a_law_of_ones_own_is_that_of_the_engine(kind):
    pytest.importorskip("scipy")
    young, poisson = 8000, 0.35

    def scene_with(mine):
        root = stroma.Node("root", dt=0.02, gravity=(0, -9.81, 0))
        root.add("EulerImplicitSolver", newtonIterations=8)
        root.add("SparseLDLSolver")
        root.add("RegularGridTopology", name="grid", n=(4, 3, 3), min=(0, 0, 0), max=(0.09, 0.05, 0.04))
        root.add("MechanicalObject", name="dofs")
        root.add("UniformMass", totalMass=0.2)
        root.add("BoxROI", name="end", box=(-0.001, -1, -1, 0.001, 1, 1))
        root.add("FixedProjectiveConstraint", indices="@end.indices")
        cells = root.add_child("cells")
        topology = root["grid"]
        if kind == "Tetrahedron":
            topology = cells.add("TetrahedronSetTopologyContainer", name="tetrahedra")
            cells.add("Hexa2TetraTopologicalMapping", input="@../grid", output="@tetrahedra")
        if mine:
            found = topology.tetrahedra if kind == "Tetrahedron" else topology.hexahedra
            root.add(NeoHookean(root["grid"].position, found, mu=young / (2 * (1 + poisson)),
                                la=young * poisson / ((1 + poisson) * (1 - 2 * poisson))), name="law")
        else:
            cells.add(kind + "HyperelasticityFEMForceField", mstate="@../dofs", materialName="NeoHookean", youngModulus=young,
                      poissonRatio=poisson, **({} if kind == "Tetrahedron" else {"topology": "@../grid"}))
        return root
    mine, theirs = stroma.load(scene_with(True)), stroma.load(scene_with(False))
    assert mine.energies()["elastic"] == pytest.approx(0, abs=1e-12)
    mine.run(10), theirs.run(10)
    moved = numpy.abs(mine.state().x - mine.state().start).max()
    assert moved > 0.01
    assert numpy.allclose(mine.state().x, theirs.state().x, rtol=0, atol=1e-6 * moved)
    assert mine.energies()["elastic"] == pytest.approx(theirs.energies()["elastic"], rel=1e-5)


def test_laws_are_derived_to_round_off():
    pytest.importorskip("scipy")
    points = numpy.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]])
    law = NeoHookean(points, [[0, 1, 2, 3], [1, 2, 3, 4]], mu=3.0, la=5.0)
    bent = points + 0.1 * numpy.sin(3 * points[:, ::-1])
    off = law.check(bent)
    assert off["energy"] < 1e-7 and off["stiffness"] < 1e-7
    F = law.deformation(bent)
    inverse, log = numpy.linalg.inv(F).swapaxes(-1, -2), numpy.log(numpy.linalg.det(F))[..., None, None]
    assert numpy.allclose(law.stress(F), 3 * (F - inverse) + 5 * log * inverse, rtol=1e-13)
    assert numpy.abs(law.force(bent, 0, 0).sum(axis=0)).max() < 1e-12
    with pytest.raises(ValueError, match="inside out"):
        NeoHookean(points, [[0, 2, 1, 3]], mu=1, la=1)
    with pytest.raises(ValueError, match="shape"):
        NeoHookean(points, [[0, 1, 2]], mu=1, la=1)
