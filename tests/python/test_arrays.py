# SPDX-License-Identifier: LGPL-2.1-or-later
"""States as arrays: views of the engine's memory, which outlive everything."""
import copy
import ctypes
import gc
import json
import os
import subprocess

import numpy
import pytest
import stroma
from conftest import EXAMPLES, PATIENCE, block

COMMAND = os.environ.get("STROMA_COMMAND", "stroma")


def test_positions_are_a_view(simulation):
    state = simulation.state("/body")
    x = state.x
    assert x.shape == (100, 3) and x.strides == (32, 8) and x.dtype == numpy.float64
    assert x.ctypes.data == state._state.address and state.x.ctypes.data == x.ctypes.data
    assert state.v.ctypes.data != x.ctypes.data
    before = x.copy()
    simulation.run(3)
    assert not numpy.array_equal(x, before), "it follows the steps"
    assert numpy.array_equal(x, simulation.state("/body/dofs").x)
    assert not x.flags.writeable and not x.flags.owndata
    with pytest.raises(ValueError):
        x[0, 0] = 1


def test_views_outlive_the_simulation():
    simulation = stroma.load(block())
    simulation.run(2)
    x = simulation.state("/body").x
    kept = x.copy()
    part = x[::7, 1]
    del simulation
    gc.collect()
    assert numpy.array_equal(x, kept) and numpy.array_equal(part, kept[::7, 1])
    del x
    gc.collect()
    assert numpy.array_equal(part, kept[::7, 1])


def test_views_outlive_a_reset_an_edit_and_a_checkpoint(simulation):
    x = simulation.state("/body").x
    start = x.copy()
    mark = simulation.checkpoint()
    simulation.run(2)
    simulation["/body/fem"].youngModulus = 8000
    simulation.run(1)
    simulation.reset()
    assert numpy.array_equal(x, start)
    simulation.run(1)
    simulation.restore(mark)
    assert numpy.array_equal(x, start)


def test_forces_exist_where_they_were_asked_for(simulation):
    state = simulation.state("/body")
    simulation.step()
    with pytest.raises(stroma.SceneError, match="not asked for.*request_forces"):
        state.f
    simulation.request_forces()
    simulation.step()
    assert numpy.abs(state.f).max() > 0


def test_forces_are_those_of_the_present_state(simulation):
    """Of rest, where gravity alone acts; of a checkpoint, to the bit; of positions that were set."""
    state = simulation.state("/body")
    simulation.request_forces()
    weights = numpy.array(state.f)
    assert weights == pytest.approx(numpy.tile((0, -9.81 / len(weights), 0), (len(weights), 1)), abs=1e-12)
    simulation.run(3)
    forces, mark, bits = state.f.copy(), simulation.checkpoint(), simulation.hash
    assert numpy.abs(forces - weights).max() > 1e-3
    simulation.run(2)
    ahead = simulation.hash
    simulation.reset()
    assert numpy.array_equal(state.f, weights)
    simulation.restore(mark)
    assert numpy.array_equal(state.f, forces) and simulation.hash == bits
    assert numpy.array_equal(copy.copy(simulation).state("/body").f, forces)
    simulation.run(2)
    assert simulation.hash == ahead, "reading forces changes no bit"
    simulation.reset()
    state.set(x=state.rest * 1.1, v=numpy.zeros_like(state.rest))
    pulled = state.f.copy()
    assert numpy.abs(pulled - simulation.force()).max() < 1e-12 and numpy.abs(pulled - weights).max() > 1e-3
    gone = simulation.hash
    simulation["/body/fem"].youngModulus = 10000
    assert state.f - weights == pytest.approx(2 * (pulled - weights), abs=1e-9), "of the present stiffness"
    simulation.set("/.gravity", (0, 0, 0))
    assert state.f == pytest.approx(2 * (pulled - weights), abs=1e-9) and simulation.hash == gone
    push = simulation.add_force(state, [5], force=(0, 0, 3))
    assert state.f[5] - 2 * (pulled - weights)[5] == pytest.approx([0, 0, 3], abs=1e-9)
    push.remove()
    assert state.f == pytest.approx(2 * (pulled - weights), abs=1e-9)


def test_a_checkpoint_with_forces_is_one_for_the_command_too(folder):
    simulation = stroma.load(EXAMPLES / "organ.xml", observers=False, quiet=True)
    simulation.request_forces()
    simulation.run(2)
    (folder / "of.checkpoint").write_bytes(simulation.checkpoint())
    simulation.run(1)
    done = subprocess.run([COMMAND, "run", EXAMPLES / "organ.xml", "-n", "3", "--restart", "of.checkpoint", "--no-record", "--json", "-"],
                          capture_output=True, text=True, timeout=PATIENCE)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["state_hash"] == f"{simulation.hash:016x}"


def test_forces_before_a_step_have_the_contacts():
    """Friction is of a step: that of the next one, which begins here."""
    simulation = stroma.load(EXAMPLES / "folded_sheet.xml", observers=False, quiet=True)
    simulation.request_forces()
    start = [state.f.copy() for state in simulation.states()]
    assert all(numpy.isfinite(forces).all() for forces in start) and any(forces.any() for forces in start)
    simulation.run(1)
    simulation.reset()
    assert all(numpy.array_equal(state.f, forces) for state, forces in zip(simulation.states(), start))


def held_frame():
    """A frame that is held at a point of it by a Lagrangian constraint: it swings."""
    root = stroma.Node("root", dt=0.01, gravity=(0, -10, 0))
    root.add("EulerImplicitSolver", name="solver")
    root.add("SparseLDLSolver", name="linear")
    body = root.add_child("body")
    body.add("MechanicalObject", name="frame", template="Rigid3", position=(0, 0, 0, 0, 0, 0, 1))
    body.add("UniformMass", name="mass", totalMass=2)
    point = body.add_child("point")
    point.add("MechanicalObject", name="dofs", position=(0.5, 0, 0.1, 0, 0.3, 0))
    point.add("RigidMapping", name="rides")
    point.add("FixedLagrangianConstraint", name="held", indices=(0,))
    return root


def test_forces_of_constraints_are_what_momentum_lacks():
    """m dv/dt is the weight and the force of the constraint; its moment is that of a force at the point."""
    simulation = stroma.load(held_frame())
    assert not simulation.state("/body").constraint_forces.any(), "nothing before the first step"
    simulation.step()
    frame, point = simulation.state("/body/frame"), simulation.state("/body/point")
    force = frame.constraint_forces
    assert force.shape == (1, 6) and point.constraint_forces.shape == (2, 3)
    assert force[0, :3] == pytest.approx(2 * (frame.v[0, :3] / 0.01 - [0, -10, 0]), abs=1e-9) and force[0, 1] > 5
    assert point.constraint_forces[0] == pytest.approx(force[0, :3], abs=1e-12) and not point.constraint_forces[1].any()
    arm = point.x[0] - frame.x[0, :3]
    assert force[0, 3:] == pytest.approx(numpy.cross(arm, force[0, :3]), abs=1e-9)
    other = stroma.load(held_frame())
    simulation.run(4)
    other.run(5)
    assert simulation.hash == other.hash, "asking changes no bit"


def on_a_floor(response):
    """Two particles at their contact distance of 0.1 m from a floor, and one far away."""
    root = stroma.Node("root", dt=0.01, gravity=(0, -10, 0))
    for kind in ("CollisionPipeline", "MinProximityIntersection"):
        root.add(kind, name=kind, **({"alarmDistance": 0.3, "contactDistance": 0.1} if "Prox" in kind else {}))
    root.add("CollisionResponse", name="contact", response=response, responseParams="mu=0.9")
    body = root.add_child("body")
    body.add("EulerImplicitSolver", name="solver")
    body.add("SparseLDLSolver", name="linear")
    body.add("MechanicalObject", name="dofs", position=(0, 0.1, 0, 1, 0.1, 0, 0, 7, 0))
    body.add("UniformMass", name="mass", totalMass=6)
    body.add("PointCollisionModel", name="points")
    floor = root.add_child("floor")
    floor.add("MeshTopology", name="mesh", position=(-9, 0, -7, 9, 0, -9, 9, 0, 9, -9, 0, 9), triangles=(0, 2, 1, 0, 3, 2))
    floor.add("MechanicalObject", name="dofs")
    floor.add("TriangleCollisionModel", name="surface", simulated=False, moving=False)
    return stroma.load(root)


def test_penalties_of_a_contact_are_its_arrays():
    """k pen with k = 10 10/0.1, where the step started; they are no forces of constraint."""
    simulation = on_a_floor("PenalityContactForceField")
    simulation.state("/body").set(x=simulation.state("/body").x - [0, 0.02, 0])
    simulation.step()
    contact = simulation["/contact"]
    assert contact.gaps == pytest.approx([-0.02, -0.02], abs=1e-12) and contact.contacts == 2 and len(contact.multipliers) == 0
    assert contact.forces == pytest.approx(numpy.array([[0, -1000 * 0.02, 0]] * 2), abs=1e-9)
    assert not simulation.state("/body").constraint_forces.any()


def test_forces_of_a_contact_are_its_arrays():
    """Particles rest on a floor: what holds them is told of them, of each contact, and by the constraint."""
    simulation = on_a_floor("FrictionContactConstraint")
    simulation.run(3)
    contact = simulation["/contact"]
    weight = numpy.array([0, 2 * 10, 0])
    assert contact.models == ["/body/points", "/floor/surface"] and contact.contacts == 2
    assert sorted(contact.pairs[:, 1]) == [0, 1] and set(contact.pairs[:, 0]) == {0} and set(contact.pairs[:, 2]) == {1}
    assert contact.gaps == pytest.approx(numpy.zeros(2), abs=1e-9) and contact.normals == pytest.approx(numpy.array([[0, -1, 0]] * 2))
    assert contact.forces == pytest.approx(numpy.array([-weight] * 2), abs=1e-6), "on the floor"
    assert contact.secondPoints[:, 1] == pytest.approx(numpy.zeros(2)) and contact.firstPoints[:, 1] == pytest.approx(numpy.full(2, 0.1))
    assert contact.modelPairs == ["/body/points", "/floor/surface"]
    lever = sum(numpy.cross(point, weight) for point in contact.firstPoints)
    assert contact.pairWrenches == pytest.approx(numpy.array([2 * weight, lever]), abs=1e-6), "of the floor on the body"
    assert contact.multipliers.reshape(2, 3)[:, 0] == pytest.approx([20, 20], abs=1e-6)
    assert simulation.state("/body").constraint_forces == pytest.approx(numpy.array([weight, weight, 0 * weight]), abs=1e-6)
    told = [getattr(contact, name).copy() for name in ("pairs", "normals", "gaps", "forces", "firstPoints", "secondPoints", "multipliers")]
    mark, forces = simulation.checkpoint(), simulation.state("/body").constraint_forces
    simulation.run(2)
    for restored in (simulation, on_a_floor("FrictionContactConstraint")):
        restored.restore(mark)
        again = restored["/contact"]
        assert again.contacts == 2
        for name, value in zip(("pairs", "normals", "gaps", "forces", "firstPoints", "secondPoints", "multipliers"), told):
            assert numpy.array_equal(getattr(again, name), value), name
        for one in (restored, restored.copy()):
            assert numpy.array_equal(one.state("/body").constraint_forces, forces), "of the step before the checkpoint"
        restored.step()
        assert restored.state("/body").constraint_forces[0] == pytest.approx(weight, abs=1e-6)
    simulation.restore(mark)
    simulation.reset()
    assert contact.contacts == 0 and len(contact.forces) == len(contact.gaps) == 0
    assert not simulation.state("/body").constraint_forces.any()


def test_asking_for_forces_changes_no_bit():
    one, other = stroma.load(block()), stroma.load(block())
    other.request_forces()
    one.run(3), other.run(3)
    assert one.hash == other.hash


def test_frames_are_copies(folder):
    simulation = stroma.load(EXAMPLES / "gripper.xml", observers=False)
    frames = [state for state in simulation.states() if state.kind == "frames"]
    assert frames
    simulation.run(2)
    for state in frames:
        assert state.x.shape == (state.nodes, 7) and state.v.shape == (state.nodes, 6)
        assert numpy.allclose(numpy.linalg.norm(state.x[:, 3:], axis=1), 1)
        assert state.rest.shape == state.x.shape


def test_setting_a_state(simulation):
    state = simulation.state("/body")
    held = {int(node) for node in simulation["/body/top"].indices}
    wanted = state.x + (0.01, 0, 0)
    assert state.set(x=wanted) == len(held)
    for node in range(state.nodes):
        expected = state.start[node] if node in held else wanted[node]
        assert numpy.array_equal(state.x[node], expected)
    assert state.set(v=numpy.ones((100, 3))) == len(held)
    assert numpy.array_equal(state.v[sorted(held)], numpy.zeros((len(held), 3)))
    free = next(node for node in range(100) if node not in held)
    state.set(x=[[0.5, 0.25, 0.125]], nodes=[free])
    assert state.x[free].tolist() == [0.5, 0.25, 0.125]
    simulation.run(2)
    with pytest.raises(stroma.StromaError, match="set by a program"):
        simulation.actions()


def test_a_state_is_edited_in_place(simulation):
    state = simulation.state()
    before = state.x.copy()
    with state.edit() as edited:
        edited.x[7, 0] += 0.25
    assert state.x[7, 0] == before[7, 0] + 0.25 and numpy.array_equal(numpy.delete(state.x, 7, axis=0), numpy.delete(before, 7, axis=0))
    now = simulation.hash
    with state.edit():
        pass
    with pytest.raises(ZeroDivisionError):
        with state.edit() as edited:
            edited.x[:] = 7
            edited.x[0] /= 1 // 0
    assert simulation.hash == now


def test_a_set_state_is_where_it_came_from(simulation):
    """The state of another run, to the bit: Euler's method remembers nothing else."""
    other = stroma.load(block())
    other.run(5)
    simulation.state().set(x=other.state().x, v=other.state().v)
    assert numpy.array_equal(simulation.state().x, other.state().x) and numpy.array_equal(simulation.state().v, other.state().v)
    other.step(), simulation.step()
    assert numpy.allclose(simulation.state().x, other.state().x, rtol=0, atol=1e-12)


def test_what_a_state_cannot_be(simulation):
    state = simulation.state()
    good = state.x.copy()
    for wrong in (numpy.zeros((99, 3)), numpy.zeros((100, 4)), numpy.zeros(300), 7):
        with pytest.raises(ValueError, match=r"\(100, 3\)"):
            state.set(x=wrong)
    for wrong in (numpy.full((100, 3), numpy.nan), numpy.full((100, 3), numpy.inf)):
        with pytest.raises(stroma.SceneError, match="finite"):
            state.set(x=wrong)
    with pytest.raises((TypeError, ValueError)):
        state.set(x="here")
    assert numpy.array_equal(state.x, good)


def test_mapped_states_follow_and_cannot_be_set(folder):
    simulation = stroma.load(EXAMPLES / "organ_embedded.xml", observers=False)
    states = simulation.states()
    mapped = next(state for state in states if "mapp" in str([c.role for c in simulation.node(state.path.rpartition("/")[0]).components]))
    with pytest.raises(stroma.SceneError, match="mapping"):
        mapped.set(x=mapped.x)
    leader = next(state for state in states if state is not mapped)
    before = mapped.x.copy()
    leader.set(x=leader.x + 0.001)
    assert numpy.abs(mapped.x - before).max() > 1e-4


def test_meshes_are_arrays(simulation):
    mesh = simulation.state().mesh()
    assert mesh.cells["hexahedron"].shape == (4 * 4 * 3, 8) and mesh.points.shape == (100, 3)
    assert sum(len(cells) for cells in mesh.surface.values()) == 2 * (16 + 12 + 12)
    cells, types = mesh.vtk_cells()
    assert len(cells) == 48 * 9 and set(types) == {12}


def test_matrices_are_those_of_the_forces(simulation):
    """K is the derivative of the force, M the mass; asking changes no bit."""
    scipy = pytest.importorskip("scipy.sparse")
    twin = stroma.load(block(method="small"))
    twin.run(2)
    before = twin.hash
    stiffness, mass = twin.matrix("stiffness"), twin.matrix("mass")
    assert scipy.issparse(stiffness) and stiffness.shape == (300, 300)
    assert abs(stiffness - stiffness.T).max() < 1e-9 * abs(stiffness).max()
    assert mass.sum() == pytest.approx(3 * 1)
    force = twin.force()
    assert twin.hash == before
    state = twin.state()
    node = next(node for node in range(100) if node not in set(twin["/body/top"].indices))
    shift = numpy.zeros((100, 3))
    shift[node, 1] = 1e-4
    state.set(x=state.x + shift)
    change = (twin.force() - force).ravel()
    assert numpy.allclose(change, stiffness @ shift.ravel(), atol=1e-9 * abs(change).max() + 1e-12)
    held = twin.matrix("stiffness", constrained=True).toarray()
    for node in twin["/body/top"].indices:
        assert held[3 * node, 3 * node] == 1
    with pytest.raises(stroma.SceneError, match="did you mean '?stiffness"):
        twin.matrix("stifness")
    with pytest.raises(stroma.SceneError, match="stiffness"):
        twin.matrix("nothing")
    assert abs(twin.matrix_of("/body/fem") - stiffness).max() == 0 == abs(twin.matrix_of(twin["/body/mass"]) - mass).max()
    assert twin.hash != before, "the state was set"
    before = twin.hash
    twin.matrix_of("/body/fem")
    assert twin.hash == before
    with pytest.raises(stroma.SceneError, match="no force field and no mass"):
        twin.matrix_of("/body/grid")


def test_the_linear_solve():
    """K u + f = 0 on what is free, and M a = b; what has no solution says so."""
    linear = stroma.load(block(method="small"), set={"/linear.iterations": 1000})
    linear.run(2)
    before = linear.hash
    held = numpy.isin(numpy.arange(100), linear["/body/top"].indices)
    force, u = linear.force(), linear.solve(linear.force())
    assert u.shape == (100, 3) and not u[held].any() and numpy.abs(u[~held]).max() > 1e-5
    left = (linear.matrix("stiffness") @ u.ravel()).reshape(-1, 3) + force
    assert numpy.abs(left[~held]).max() < 1e-8 * numpy.abs(force).max()
    a = linear.solve(numpy.ones((100, 3)), mass=2, stiffness=0)
    assert a[~held] == pytest.approx(50) and not a[held].any(), "each node has 10 g"
    assert not linear.solve(numpy.zeros((100, 3))).any() and linear.hash == before
    with pytest.raises(stroma.SceneError, match="/linear finds no solution.*definite"):
        linear.solve(force, stiffness=1)
    with pytest.raises(stroma.SceneError, match="/linear finds no solution.*more iterations"):
        stroma.load(block(), set={"/linear.iterations": 3}).solve(force)
    with pytest.raises(ValueError, match=r"shape \(100, 3\)"):
        linear.solve([1, 2, 3])
    assert stroma.load(held_frame()).solve([[0, 2, 0], [0, 0, 0]], mass=1, stiffness=0)[0] == pytest.approx([0, 1, 0])
    root = stroma.Node("root")
    root.add("EulerExplicitSolver", name="solver")
    root.add("MechanicalObject", position=(0, 0, 0))
    root.add("UniformMass", totalMass=1)
    with pytest.raises(stroma.SceneError, match="/solver solves no linear systems"):
        stroma.load(root).solve([[0, 0, 1]], mass=1)


INTEGRATORS = {"EulerImplicitSolver": {}, "BDFOdeSolver": {"order": 2}, "NewmarkImplicitSolver": {}, "TrapezoidalRuleSolver": {},
               "VariationalSymplecticSolver": {}, "CentralDifferenceSolver": {}, "EulerExplicitSolver": {}, "RungeKutta4Solver": {},
               "StaticSolver": {}}


@pytest.mark.parametrize("type", INTEGRATORS)
def test_integrators_begin_anew_where_a_state_is_set(type):
    """A run whose state was set goes on with the bits of one that begins there: nothing of the way before is left."""
    def loaded():
        root = block()
        root.remove(root["solver"])
        root.insert(0, type, name="solver", **INTEGRATORS[type])
        return stroma.load(root, set={"dt": 1e-3})
    walked, fresh = loaded(), loaded()
    walked.run(7)
    bent = fresh.state().start + 0.01 * numpy.sin(20 * fresh.state().start[:, ::-1])
    speed = numpy.cos(10 * fresh.state().start)
    for simulation in (walked, fresh):
        simulation.state().set(x=bent, v=speed)
    assert walked.hash == fresh.hash
    walked.run(4), fresh.run(4)
    assert walked.hash == fresh.hash
    free = loaded()
    free.run(4)
    assert free.hash != fresh.hash


def test_condensed_bodies_refuse(folder):
    simulation = stroma.load(EXAMPLES / "organ_condensed.xml", observers=False)
    simulation.step()
    state = simulation.states()[0]
    with pytest.raises(stroma.SceneError, match="beforehand"):
        state.set(x=state.x)
    with pytest.raises(stroma.SceneError, match="beforehand"):
        simulation.matrix("stiffness")
    with pytest.raises(stroma.SceneError, match="beforehand.*dragForces"):
        simulation.request_forces()


def test_bodies_that_would_overlap_stay_where_they_are():
    root = stroma.Node("root", dt=0.01, gravity=(0, 0, -9.81))
    root.add("EulerImplicitSolver", newtonIterations=30)
    root.add("SparseLDLSolver")
    root.add("MeshTopology", position="0 0 0  1 0 0  0 1 0  0.3 0.3 0.8", tetrahedra="0 1 2 3")
    root.add("MechanicalObject", name="dofs")
    root.add("UniformMass", totalMass=2)
    root.add("TetrahedronFEMForceField", youngModulus=1e5, poissonRatio=0.3)
    root.add("BarrierContact", contactDistance=0.25, planes=[0, 0, 1, -0.35])
    simulation = stroma.load(root)
    state = simulation.state()
    before = simulation.hash
    with pytest.raises(stroma.SceneError, match="keeps its positions"):
        state.set(x=state.x - (0, 0, 1))
    assert simulation.hash == before
    state.set(x=state.x + (0, 0, 1))
    simulation.run(60)
    assert state.x[:, 2].min() > -0.35, "it falls again and is stopped"


def test_histories_keep_what_they_remember():
    """A viscous body that is told to be where it is goes on as it would; without its memory it would be stiffer."""
    def loaded():
        root = block()
        body = root["body"]
        body.remove(body["fem"])
        body.add("HexahedronHyperelasticityFEMForceField", name="fem", materialName="NeoHookean", youngModulus=5000, poissonRatio=0.3,
                 viscous=True, ParameterAlpha=[0.6], ParameterTau=[0.05])
        return stroma.load(root)
    kept, told, fresh = loaded(), loaded(), loaded()
    kept.run(20), told.run(20)
    told.state().set(x=told.state().x, v=told.state().v)
    fresh.state().set(x=kept.state().x, v=kept.state().v)
    for simulation in (kept, told, fresh):
        simulation.run(5)
    moved = numpy.abs(kept.state().x - kept.state().start).max()
    assert numpy.allclose(told.state().x, kept.state().x, rtol=0, atol=1e-7 * moved)
    assert numpy.abs(fresh.state().x - kept.state().x).max() > 1e-3 * moved, "with no memory it goes another way"


def bytes_in_use():
    """What malloc has given and not got back, by glibc. The pages of a process also tell where its heap has holes."""
    names = "arena ordblks smblks hblks hblkhd usmblks fsmblks uordblks fordblks keepcost".split()
    info = type("mallinfo2", (ctypes.Structure,), {"_fields_": [(name, ctypes.c_size_t) for name in names]})
    count = ctypes.CDLL("libc.so.6").mallinfo2
    count.restype = info
    return count().uordblks


def test_what_is_set_in_each_step_does_not_fill_the_memory():
    """The record of what was done to a run ends where a program has set so much that nobody does it again."""
    node = stroma.Node("root", gravity="0 0 0", dt="0.01")
    node.add("EulerExplicitSolver")
    node.add("MechanicalObject", position="0 0 0")
    node.add("UniformMass", totalMass="1")
    node.add("ConstantForceField", indices="0", forces="0 0 1", name="load")
    sim = stroma.load(node)
    force = sim.component("/load")

    def set_often():
        before = bytes_in_use()
        for i in range(30_000):
            force.forces = [0, 0, 1e-5 * i]
            sim.step()
        return bytes_in_use() - before

    force.forces = [0, 0, 2]
    sim.step()
    assert '"value":"0 0 2"' in sim.actions()
    set_often()
    with pytest.raises(stroma.StromaError, match="so often that no record has all of it"):
        sim.actions()
    assert set_often() < 500_000, "a record of these takes 4 MB and more"
    sim.reset()
    sim.actions()
