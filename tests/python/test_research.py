# SPDX-License-Identifier: LGPL-2.1-or-later
"""What programs of research ask for: modes, gradients, states kept in arrays, pictures, runs in processes."""
import copy
import pickle
import struct
import warnings

import numpy
import pytest
import stroma
from conftest import block


def bar(cells=40, **held):
    """A bar along x, 1 m long, of 1000 kg/m^3 and 1e7 Pa without lateral contraction."""
    root = stroma.Node("root", dt=0.01, gravity=(0, 0, 0))
    root.add("StaticSolver", newton_iterations=50)
    root.add("SparseLDLSolver")
    body = root.add_child("bar")
    body.add("RegularGridTopology", name="grid", n=(cells + 1, 2, 2), min=(0, 0, 0), max=(1, 0.1, 0.1))
    body.add("MechanicalObject", name="dofs")
    body.add("MeshMatrixMass", name="mass", massDensity=1000, lumping=False)
    body.add("HexahedronFEMForceField", name="fem", youngModulus=1e7, poissonRatio=0, method="polar")
    body.add("BoxROI", name="end", box=(-0.001, -1, -1, 0.001, 1, 1))
    body.add("FixedProjectiveConstraint", name="clamp", indices="@end.indices")
    if held:
        body.add("PartialFixedProjectiveConstraint", fixAll=True, **held)
    return root


def test_modes_of_a_bar():
    """Along x: f = (2k + 1) / (4 L) sqrt(E / rho), 25, 75 and 125 Hz; linear elements with a consistent mass are above, by h^2."""
    errors = []
    for cells in (20, 40):
        found = stroma.load(bar(cells, fixedDirections=(0, 1, 1)), quiet=True).modes(3)
        errors.append(found.frequencies / [25, 75, 125] - 1)
        assert found.shapes.shape == (3, 4 * (cells + 1), 3) and not found.shapes[:, :, 1:].any()
    assert (errors[1] > 0).all() and (errors[1] < 0.01).all() and errors[0] / errors[1] == pytest.approx([4, 4, 4], rel=0.02)


def test_shapes_have_the_modal_mass_one_and_free_bodies_move_as_rigid_ones():
    root = block()
    root["body"].remove(root["body/held"])
    simulation = stroma.load(root, quiet=True)
    found = simulation.modes(8)
    assert abs(found.frequencies[:6]).max() < 1e-4 * found.frequencies[6] and found.frequencies[6] > 1
    flat = found.shapes.reshape(8, -1)
    assert flat @ simulation.matrix("mass") @ flat.T == pytest.approx(numpy.eye(8), abs=1e-9)
    for wrong in (0, 300):
        with pytest.raises(ValueError, match="expected 1 to 299"):
            simulation.modes(wrong)


def test_free_directions():
    """Nodes that are held, that slide along an axis, and that slide in a plane which is not across one."""
    root = block()
    across = numpy.array([1.0, 2.0, -1.0]) / numpy.sqrt(6)
    root["linear"].iterations = 2000
    root["body"].add(stroma.Constraint(nodes=[0, 1], along=across))
    simulation = stroma.load(root, quiet=True)
    T = simulation.free_directions()
    held = len(simulation["/body/top"].indices)
    assert T.shape == (300, 300 - 3 * held - 2)
    assert abs(T.T @ T - numpy.eye(T.shape[1])).max() < 1e-14
    assert abs(across @ T.toarray()[:6].reshape(2, 3, -1)).max() < 1e-15
    K = simulation.matrix(constrained=True)
    u = T @ numpy.linalg.solve((T.T @ -K @ T).toarray(), T.T @ simulation.force().ravel())
    assert u.reshape(-1, 3) == pytest.approx(simulation.solve(simulation.force()), abs=1e-7 * abs(u).max())


def hanging(E=2e4, nu=0.3, method="large", gravity=(0.0, -9.81, 0.0)):
    root = block(youngModulus=E, poissonRatio=nu, method=method)
    root.gravity = gravity
    for name, type, more in (("solver", "StaticSolver", {"newton_iterations": 100, "relative_residual_tolerance_threshold": 1e-12}),
                             ("linear", "SparseLUSolver", {})):
        root.remove(root[name])
        root.add(type, name=name, **more)
    return root


@pytest.mark.parametrize("method", ["large", "polar", "small"])  # of the first the matrix is not the derivative, which is not symmetric
def test_gradient_of_an_equilibrium(method):
    simulation = stroma.load(hanging(method=method, gravity=(3, -9.81, 1)), quiet=True)
    simulation.run(1)
    of = numpy.random.default_rng(3).normal(size=(100, 3))
    found = simulation.gradient(of, ["/body/fem.youngModulus", "/body/fem.poissonRatio", "gravity"])

    def measured(p, pull=None):
        again = stroma.load(hanging(p[0], p[1], method, p[2:]), quiet=True)
        if pull is not None:
            again.add_force("/body", [7, 30], pull)
        again.run(1)
        return (of * again.state().x).sum()
    present = [2e4, 0.3, 3, -9.81, 1]
    expected = stroma.jacobian(measured, present)[0]
    given = [found.parameters["/body/fem.youngModulus"], found.parameters["/body/fem.poissonRatio"], *found.parameters["gravity"]]
    assert given == pytest.approx(expected, rel=2e-5)
    by_force = stroma.jacobian(lambda f: measured(present, f.reshape(2, 3)), numpy.zeros(6))[0]
    assert found.forces[[7, 30]].ravel() == pytest.approx(by_force, rel=1e-4, abs=1e-5 * abs(by_force).max())


def test_gradient_by_a_number_of_each_cell():
    E = numpy.geomspace(3e4, 3e2, 48)  # the softest is less than a change of the stiffest
    simulation = stroma.load(hanging(E=E), quiet=True)
    simulation.run(1)
    of = numpy.zeros((100, 3))
    of[60, 1] = 1
    found = simulation.gradient(of, "/body/fem.youngModulus").parameters["/body/fem.youngModulus"]
    assert found.shape == (48,)
    for cell in (0, 20, 40):
        def measured(p, at=cell):
            other = E.copy()
            other[at] = p[0]
            again = stroma.load(hanging(E=other), quiet=True)
            again.run(1)
            return again.state().x[60, 1]
        expected = stroma.jacobian(measured, [E[cell]])[0, 0]
        assert found[cell] == pytest.approx(expected, rel=1e-4, abs=1e-5 * abs(found).max())


def test_gradients_that_are_none():
    simulation = stroma.load(hanging(nu=0.4), quiet=True)
    simulation.run(1)
    of = numpy.ones((100, 3))
    with pytest.raises(stroma.StromaError, match="jumps"):  # hexahedra change their volume in another way from 0.4 on
        simulation.gradient(of, "/body/fem.poissonRatio")
    with pytest.raises(ValueError, match="is no number"):
        simulation.gradient(of, "/body/fem.method")
    with pytest.raises(ValueError, match=r"expected \(100, 3\)"):
        simulation.gradient(numpy.ones(3))
    with pytest.raises(stroma.LoadNeeded):
        simulation.gradient(of, "/body/grid.n")
    with pytest.raises(stroma.SceneError, match="names no attribute|did you mean"):
        simulation.gradient(of, "fem")
    free = block()
    free["body"].remove(free["body/held"])
    with pytest.raises(stroma.StromaError, match="moves freely"):
        stroma.load(free, quiet=True).gradient(of)
    moving = stroma.load(block())
    moving.run(2)
    with pytest.warns(stroma.SceneWarning, match="no equilibrium"):
        moving.gradient(of)


def test_states_are_kept_in_arrays(simulation):
    twin = simulation.copy()
    kept = simulation.record(steps=6, every=2)
    assert kept.times == pytest.approx([0, 0.02, 0.04, 0.06]) and kept.x.shape == kept.v.shape == (4, 100, 3)
    twin.run(4)
    assert numpy.array_equal(kept.x[2], twin.state().x) and numpy.array_equal(kept.v[2], twin.state().v)
    assert len(simulation.record(until=0.08).times) == 3 and simulation.record(1, state="/body").x.shape == (2, 100, 3)
    assert numpy.array_equal(twin.state().displacement, twin.state().x - twin.state().start)
    with pytest.raises(ValueError, match="expected 1 or more"):
        simulation.record(3, every=0)


def test_pictures_and_films(simulation, folder):
    simulation.run(2)
    before = simulation.hash
    picture = simulation.picture("shown.png", field="vonMises", size=(320, 240), views=["front", (30, 20)], edges=True)
    assert picture._repr_png_() == (folder / "shown.png").read_bytes() == picture.png and "von Mises" in picture.summary
    assert struct.unpack(">II", picture.png[16:24]) == (320, 240) and "von Mises" in repr(picture) and simulation.hash == before
    film = simulation.film("film.png", steps=4, every=2, size=(200, 200))
    frames = struct.unpack(">I", film.png[film.png.index(b"acTL") + 4:][:4])
    assert frames == (3,) and simulation.steps == 6 and not simulation._end
    for wrong, error, words in (({"feild": "x"}, TypeError, "did you mean 'field'"), ({"cut": "q"}, ValueError, "expected"),
                                ({"range": (2, 1)}, ValueError, "expected"), ({"field": "vonMices"}, stroma.SceneError, "vonMises"),
                                ({"cut": ("x", 9.0)}, stroma.SceneError, "between")):
        with pytest.raises(error, match=words):
            simulation.picture(**wrong)


def test_forces_of_each_node(simulation):
    """Forces that differ are those of several calls, and all of them end and change together."""
    one, other = simulation, simulation.copy()
    pull = one.add_force("/body", [3, 8], [[0, 0.3, 0], [0.1, 0, 0]])
    first, second = other.add_force("/body", 3, (0, 0.3, 0)), other.add_force("/body", [8], (0.1, 0, 0))
    one.run(3), other.run(3)
    assert one.hash == other.hash
    pull.change(force=[[0, 0, 0.2], [0, 0, 0.1]])
    first.change(force=(0, 0, 0.2)), second.change(force=(0, 0, 0.1))
    one.run(2), other.run(2)
    assert one.hash == other.hash
    for wrong in ((1, 2), numpy.ones((3, 3))):
        with pytest.raises(ValueError, match=r"3 numbers, not .*\(2, 3\)"):
            pull.change(force=wrong)
    with pytest.raises(stroma.SceneError, match="node 1000"):
        one.add_force("/body", [3, 1000], numpy.ones((2, 3)))
    pull.remove()
    first.remove(), second.remove()
    one.run(2), other.run(2)
    assert one.hash == other.hash  # nothing is left of the force that was refused


def test_names_that_are_nearly_right(simulation):
    for asked, meant in (("fem", "/body/fem"), ("/fem", "/body/fem"), ("body/fme", "/body/fem")):
        with pytest.raises(stroma.SceneError, match=meant) as refused:
            simulation[asked]
        assert refused.value.file == __file__ and refused.value.line > 0
    with pytest.raises(stroma.SceneError, match="/body/dofs"):
        simulation.state("dofs")
    with pytest.raises(TypeError, match="until="):
        simulation.run(0.5)
    assert "linear iterations" in repr(simulation.step())


def test_copies_of_all_kinds(simulation):
    simulation.run(2)
    twins = [simulation.copy(), copy.copy(simulation), copy.deepcopy({"it": simulation})["it"]]
    simulation.run(2)
    for twin in twins:
        twin.run(2)
        assert twin is not simulation and twin.hash == simulation.hash
    with pytest.raises(TypeError, match="checkpoint"):
        pickle.dumps(simulation)


def lowest(simulation):
    simulation.run(3)
    return float(simulation.state().x[:, 1].min())


def test_runs_in_processes():
    values = {"/body/fem.youngModulus": [5e3, 1e4]}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        here, there = (stroma.sweep(block(), values, lowest, **how) for how in ({"threads": 2}, {"processes": 2}))
    assert [run.result for run in there] == [run.result for run in here] and here[0].result != here[1].result
    with pytest.raises(ValueError, match="not both"):
        stroma.sweep(block(), values, lowest, threads=1, processes=1)
