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


def column(load, method="polar", follows=False):
    """A cantilever of 1 m x 5 cm x 5 cm under an axial load at its end, in critical loads of Euler, and its lowest frequency unloaded."""
    E, side = 1e6, 0.05
    inertia = side**4 / 12
    root = stroma.Node("root", dt=0.01, gravity=(0, 0, 0))
    root.add("StaticSolver", newton_iterations=50, relative_residual_tolerance_threshold=1e-10)
    root.add("SparseLUSolver")
    body = root.add_child("column")
    body.add("RegularGridTopology", name="grid", n=(21, 3, 3), min=(0, 0, 0), max=(1, side, side))
    body.add("MechanicalObject", name="dofs")
    body.add("MeshMatrixMass", massDensity=1000)
    body.add("HexahedronFEMForceField", name="fem", youngModulus=E, poissonRatio=0, method=method, incompatibleModes=method != "green")
    body.add("BoxROI", name="end", box=(-1, -1, -1, 1e-6, 1, 1))
    body.add("FixedProjectiveConstraint", indices="@end.indices")
    body.add("BoxROI", name="tip", box=(1 - 1e-6, -1, -1, 2, 1, 1))
    force = -load * numpy.pi**2 * E * inertia / 4
    if follows:
        body.add("SurfacePressureForceField", pressure=force / side**2, min=(1 - 1e-6, -1, -1), max=(2, 1, 1))
    else:
        body.add("ConstantForceField", indices="@tip.indices", totalForce=(force, 0, 0))
    simulation = stroma.load(root, quiet=True)
    simulation.run(1)
    return simulation, 1.8751**2 / (2 * numpy.pi) * numpy.sqrt(E * inertia / (1000 * side**2))


@pytest.mark.parametrize("load", [0.5, 1.5])
def test_modes_of_a_loaded_column(load):
    """f = f0 sqrt(1 - P / P_E), nearly: half the load slows it, and beyond the critical load it buckles, in both planes."""
    simulation, unloaded = column(load)
    before = simulation.hash
    found = simulation.modes(2).frequencies
    expected = numpy.sign(1 - load) * unloaded * numpy.sqrt(abs(1 - load))
    assert found == pytest.approx([expected, expected], rel=0.1) and simulation.hash == before


def test_a_load_that_follows_the_surface_has_no_modes():
    with pytest.raises(stroma.StromaError, match="not symmetric"):
        column(0.5, "green", follows=True)[0].modes(1)


def test_modes_are_the_lowest_and_the_same_each_time():
    simulation, _ = column(0, "green")
    x = numpy.array(simulation.state().x)
    x[:, 0] *= 1 - 20 * numpy.pi**2 * 0.05**2 / 48  # far beyond the critical load: several shapes grow
    simulation.state().set(x=x)
    all_of_them = simulation.modes(5)
    assert (all_of_them.frequencies[:3] < 0).all() and (numpy.diff(all_of_them.frequencies) > -1e-9).all()
    for count in (1, 2, 3):
        assert simulation.modes(count).frequencies == pytest.approx(all_of_them.frequencies[:count], rel=1e-6)
    assert numpy.array_equal(simulation.modes(3).shapes, simulation.modes(3).shapes)


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


def tied(E, method):
    """Two blocks side by side, the nodes of whose common face are tied."""
    root = stroma.Node("root", dt=0.01, gravity=(0, -9.81, 0))
    root.add("StaticSolver", newton_iterations=100, relative_residual_tolerance_threshold=1e-12)
    root.add("SparseLUSolver")
    for name, start in (("a", 0.0), ("c", 0.1)):
        body = root.add_child(name)
        body.add("RegularGridTopology", name="grid", n=(5, 3, 3), min=(start, 0, 0), max=(start + 0.1, 0.03, 0.03))
        body.add("MechanicalObject", name="dofs")
        body.add("MeshMatrixMass", massDensity=1000)
        body.add("HexahedronFEMForceField", name="fem", method=method, youngModulus=E if name == "c" else 8e4, poissonRatio=0.3)
    root["a"].add("BoxROI", name="end", box=(-1, -1, -1, 1e-6, 1, 1))
    root["a"].add("FixedProjectiveConstraint", indices="@end.indices")
    root.add("AttachProjectiveConstraint", object1="@a/dofs", object2="@c/dofs", indices1=[4 + 5 * k for k in range(9)],
             indices2=[5 * k for k in range(9)])
    simulation = stroma.load(root, quiet=True)
    simulation.run(1)
    return simulation


@pytest.mark.parametrize("method", ["small", "large"])
def test_gradient_of_bodies_that_are_tied(method):
    simulation = tied(9e4, method)
    of = numpy.zeros(simulation.force().shape)
    of[simulation.rows()["/c/dofs"].stop - 1, 1] = 1
    found = simulation.gradient(of, "/c/fem.youngModulus").parameters["/c/fem.youngModulus"]
    expected = stroma.jacobian(lambda E: tied(E[0], method).state("/c").x[-1, 1], [9e4])[0, 0]
    assert found == pytest.approx(expected, rel=1e-6)


def test_gradients_that_are_none():
    simulation = stroma.load(hanging(nu=0.4), quiet=True)
    simulation.run(1)
    of = numpy.ones((100, 3))
    with pytest.raises(stroma.StromaError, match="jumps"):  # hexahedra change their volume in another way from 0.4 on
        simulation.gradient(of, "/body/fem.poissonRatio")
    for step in (0, -1e-4, numpy.nan):
        with pytest.raises(ValueError, match="expected a positive fraction"):
            simulation.gradient(of, "/body/fem.youngModulus", step=step)
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
                                ({"range": (2, 1)}, ValueError, "expected"), ({"size": (0, 10)}, ValueError, "pixels"),
                                ({"size": (9.5, 10)}, ValueError, "pixels"), ({"field": "vonMices"}, stroma.SceneError, "vonMises"),
                                ({"cut": ("x", 9.0)}, stroma.SceneError, "between")):
        with pytest.raises(error, match=words):
            simulation.picture(**wrong)
    for every in (0, 1.5):
        with pytest.raises(ValueError, match="expected a whole number"):
            simulation.film(steps=2, every=every)
    assert simulation.steps == 6


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
    for mask in (numpy.arange(100) == 5, [True, False], True):
        with pytest.raises(TypeError, match="flatnonzero"):
            one.add_force("/body", mask, (0, 1, 0))
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


def failing(simulation):
    """Fails with the soft body, in an exception and in a result that no other process can read."""
    young = simulation["/body/fem"].youngModulus
    if young < 6e3:
        raise stroma.StepError("it diverged", simulation.run(1))
    return simulation.run(1) if young < 8e3 else young


def test_a_run_that_fails_in_a_process_leaves_the_others():
    values = {"/body/fem.youngModulus": [5e3, 7e3, 1e4]}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        first, second, third = stroma.sweep(block(), values, failing, processes=1)
    assert isinstance(first.error, stroma.StepError) and "it diverged" in str(first.error) and first.result is None
    assert isinstance(second.error, stroma.StromaError) and "RunReport" in str(second.error) and second.result is None
    assert third.error is None and third.result == 1e4
    with pytest.raises(ValueError, match="expected 1 or more"):
        stroma.sweep(block(), values, failing, processes=0)


def test_runs_in_processes():
    values = {"/body/fem.youngModulus": [5e3, 1e4]}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        here, there = (stroma.sweep(block(), values, lowest, **how) for how in ({"threads": 2}, {"processes": 2}))
    assert [run.result for run in there] == [run.result for run in here] and here[0].result != here[1].result
    with pytest.raises(ValueError, match="not both"):
        stroma.sweep(block(), values, lowest, threads=1, processes=1)
