# SPDX-License-Identifier: LGPL-2.1-or-later
"""What scenes in the manner of public ones compute, against closed forms and against mechanics written in NumPy here."""
import numpy as np
import pytest
import Sofa
from playing import SCENES, animate, scene, started


def fallen(g, h, steps):
    """The way of backward Euler in free fall."""
    return g * h * h * steps * (steps + 1) / 2


def test_the_cube_of_the_tutorial_falls_and_lies_on_the_floor():
    root = started("tutorial_floor")
    animate(root, 10)
    place = root.sphere.mstate.position.value[0]
    assert place == pytest.approx([0, fallen(-9.81, 0.01, 10), 0, 0, 0, 0, 1], abs=1e-9)
    animate(root, 900)
    half, thickness, distance = 45, 1, 5
    assert root.sphere.mstate.position.value[0] == pytest.approx([0, -300 + thickness + distance + half, 0, 0, 0, 0, 1], abs=1e-6)
    assert root.sphere.mstate.velocity.value[0] == pytest.approx(np.zeros(6), abs=1e-9)


def test_the_floor_carries_the_weight():
    """Impulses over dt: the normal first, then what rubs."""
    root = started("contact_forces")
    animate(root, 30)
    normal, one, other = root.GenericConstraintSolver.constraintForces.value / 0.02
    assert normal == pytest.approx(2 * 10, rel=1e-9) and abs(one) < 1e-9 and abs(other) < 1e-9
    assert root.Ball.mstate.position.value[0] == pytest.approx([0.3, 0.2, 0.05], abs=1e-9)
    assert root.Ball.forces.found[-1] == pytest.approx(20, rel=1e-9) and len(root.Ball.forces.found) == 30


def test_spheres_follow_the_tetrahedra_that_they_are_in():
    root = started("liver_keys")
    liver = root.Liver
    rest, cells = liver.MechanicalModel.rest_position.value.copy(), liver.TetrahedronSetTopologyContainer.tetrahedra.value
    spheres = liver.Surf.spheres.position.value.copy()

    def weights(point, cell):
        return np.linalg.solve(np.vstack([rest[cell].T, np.ones(4)]), [*point, 1])
    inside = [max(((weights(point, cell), cell) for cell in cells), key=lambda each: each[0].min()) for point in spheres]
    animate(root, 10)
    now = liver.MechanicalModel.position.value
    assert liver.KeyboardController.pressed == 10 and now[[3, 39, 64]] == pytest.approx(rest[[3, 39, 64]], abs=1e-12)
    assert np.abs(now - rest).max() > 0.05
    for place, (weight, cell) in zip(liver.Surf.spheres.position.value, inside):
        assert place == pytest.approx(weight @ now[cell], abs=1e-9)


def skew(w):
    return np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])


def along_the_beam(curvature, length):
    """exp of a twist of constant curvature along x: a series, which ends where its terms are below round-off."""
    twist = np.zeros((4, 4))
    twist[:3, :3], twist[:3, 3] = skew(curvature) * length, [length, 0, 0]
    term = total = np.eye(4)
    for k in range(1, 30):
        term = term @ twist / k
        total = total + term
    return total


def test_frames_of_a_cosserat_beam_are_products_of_exponentials():
    root = started("cosserat_beam")
    animate(root, 10)
    frames = root.solver.rigid_base.cosserat_in_Sofa_frame_node.FramesMO.position.value
    curvatures = root.solver.cosseratCoordinate.cosserat_state.position.value
    x, y, z, w = root.solver.rigid_base.cosserat_base_mo.position.value[0][3:]
    at = np.eye(4)
    at[:3, :3] = np.eye(3) + 2 * w * skew([x, y, z]) + 2 * skew([x, y, z]) @ skew([x, y, z])
    at[:3, 3] = root.solver.rigid_base.cosserat_base_mo.position.value[0][:3]
    expected = [at]
    for curvature in curvatures:
        expected += [at @ along_the_beam(curvature, 2.5), at @ along_the_beam(curvature, 5)]
        at = expected[-1]
    assert frames[:, :3] == pytest.approx(np.array([each[:3, 3] for each in expected]), abs=1e-9)
    # the axis of each frame, from its quaternion
    x, y, z, w = frames[:, 3:].T
    axes = np.array([1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)]).T
    assert axes == pytest.approx(np.array([each[:3, 0] for each in expected]), abs=1e-9)
    assert frames[-1][1] < -0.05 and (curvatures[:, :2] == 0).all()


def test_cables_of_a_tentacle_are_as_short_as_they_are_told():
    """A cable pulls, and then has its displacement; one that does not pull may be shorter than that."""
    root = started("tentacle")
    animate(root, 10)
    for k in range(8):
        node = root.tentacle[f"cable_{k}"]
        cable = node.CableConstraint
        places = node.MechanicalObject.position.value
        line = np.vstack([cable.pullPoint.value, places])
        length = np.linalg.norm(np.diff(line, axis=0), axis=1).sum()
        start = 85.0  # from z = 0 to z = 85, straight
        wanted = max(0.0, 0.5 * 0.1 * 10 * np.cos(2 * np.pi * k / 8))
        assert cable.value.value[0] == pytest.approx(wanted, abs=1e-12)
        assert cable.cableInitialLength.value == pytest.approx(start) and cable.cableLength.value == pytest.approx(length, abs=1e-9)
        shorter = start - length
        assert cable.displacement.value == pytest.approx(shorter, abs=1e-9)
        assert cable.force.value >= 0 and shorter >= wanted - 1e-6
        assert shorter == pytest.approx(wanted, abs=1e-6) or abs(cable.force.value) < 1e-9, k
    assert root.goal.goalMO.position.value[0] == pytest.approx([30 * np.cos(0.1), 30 * np.sin(0.1), 100])


def test_a_gripper_closes_on_a_falling_cube():
    """The cube falls until the fingers hold it up; each cable is half a millimetre shorter per step."""
    root = started("gripper_cube")
    for step in range(1, 7):
        animate(root, 1)
        place = root.cube.MechanicalObject.position.value[0]
        free = fallen(-9810, 0.005, step)
        if step < 4:
            assert place == pytest.approx([50, free, 0, 0, 0, 0, 1], abs=1e-9)
        else:
            assert place[1] > free + 0.3
        for finger in (root.finger0, root.finger1):
            assert finger.cable.CableConstraint.displacement.value == pytest.approx(0.5 * step, abs=1e-6)


def lame_of(young, poisson):
    return young * poisson / (1 + poisson) / (1 - 2 * poisson), young / 2 / (1 + poisson)


def stiffness_of(rest, cells, lame, shear, factors=None):
    """Of linear tetrahedra, a node times three to a node times three; a factor for each."""
    law = np.diag([2 * shear] * 3 + [shear] * 3)
    law[:3, :3] += lame
    matrix = np.zeros((3 * len(rest), 3 * len(rest)))
    for cell, factor in zip(cells, np.ones(len(cells)) if factors is None else factors):
        gradients = np.linalg.inv(np.vstack([rest[cell].T, np.ones(4)]))[:, :3]
        strain = np.zeros((6, 12))
        for k, (x, y, z) in enumerate(gradients):
            strain[:, 3 * k:3 * k + 3] = [[x, 0, 0], [0, y, 0], [0, 0, z], [y, x, 0], [0, z, y], [z, 0, x]]
        volume = abs(np.linalg.det(rest[cell[1:]] - rest[cell[0]])) / 6
        rows = (3 * np.asarray(cell)[:, None] + np.arange(3)).ravel()
        matrix[np.ix_(rows, rows)] += factor * volume * strain.T @ law @ strain
    return matrix


def test_the_first_step_of_old_names_is_that_of_linear_elements():
    """(M + h^2 K) v = h M g from rest, held at four nodes. The scene's own 25 iterations leave 1 % of it."""
    root = scene("old_names")
    for name, value in (("iterations", 2000), ("threshold", 1e-24), ("tolerance", 1e-24)):
        root.n.CGSolver.findData(name).value = value
    Sofa.Simulation.init(root)
    body, h = root.n, root.dt.value
    rest = body.MechanicalObject.position.value.copy()
    matrix = stiffness_of(rest, body.TetrahedronSetTopologyContainer.tetrahedra.value, *lame_of(100, 0.45))
    mass = 1.0 / len(rest)
    free = np.arange(12, 3 * len(rest))
    load = h * mass * np.tile(root.gravity.value, len(rest))
    velocity = np.zeros(3 * len(rest))
    velocity[free] = np.linalg.solve((mass * np.eye(len(matrix)) + h * h * matrix)[np.ix_(free, free)], load[free])
    animate(root, 1)
    assert body.MechanicalObject.velocity.value == pytest.approx(velocity.reshape(-1, 3), rel=1e-4, abs=1e-6 * abs(velocity).max())
    assert body.MechanicalObject.position.value == pytest.approx(rest + h * velocity.reshape(-1, 3), abs=1e-8)


def test_what_a_thread_has_put_into_a_queue_is_the_load():
    root = started("threads_and_waits")
    animate(root, 10)
    x = v = 0.0
    for k in range(1, 11):
        v += 0.01 * 0.01 * k
        x += 0.01 * v
    assert root.n.MechanicalObject.position.value[0] == pytest.approx([x, fallen(-9.81, 0.01, 10), 0], rel=1e-9)


def test_what_is_drawn_disturbs_no_fall():
    root = started("everything_drawn")
    rest = root.n.mo.position.value.copy()
    animate(root, 10)
    assert root.n.mo.position.value == pytest.approx(rest + [0, fallen(-9.81, 0.01, 10), 0], rel=1e-9)


def test_a_bead_slides_and_a_number_stops():
    root = started("sliding_old_names")
    for step in range(1, 11):
        animate(root, 1)
        assert root.bead.mo.position.value[0] == pytest.approx([0.5 + 0.01 * step, 0, 0], abs=1e-9)
        assert root.stop.mo.position.value.ravel()[0] == pytest.approx(min(fallen(5, 0.01, step), 0.01), abs=1e-9)


def test_a_controller_finds_the_pressure_of_a_cavity():
    """The volume is that of its faces; the pressure what the controller's gains make of the heights that the effector had."""
    root = started("pneumatic_pid")
    cavity = root.body.cavity.getObject("SurfacePressureConstraint")
    faces, places = root.body.cavity.topo.triangles.value, root.body.cavity.cavity.position

    def volume():
        return sum(np.linalg.det(places.value[face]) for face in faces) / 6
    sign = np.sign(volume())
    assert sign * volume() == pytest.approx(16 ** 3, rel=1e-9)
    summed = 0.0
    for step in range(10):
        height = root.body.effector.MechanicalObject.position.value[0][1]
        animate(root, 1)
        error = root.controller._target - height
        summed += error * 0.01
        assert cavity.value.value[0] == pytest.approx(max(0, 0.01 * error + 0.5 * summed), rel=1e-9)
        assert cavity.cavityVolume.value == pytest.approx(sign * volume(), rel=1e-9)
        assert cavity.initialCavityVolume.value == pytest.approx(16 ** 3, rel=1e-9)


def test_the_first_step_of_a_neo_hookean_body_is_that_of_linear_elasticity():
    """((1 + h rM) M + (h^2 + h rK) K) v = h f from rest. SOFA's energy is mu/2 (I1 - 3 - 2 ln J) + k0/2 (ln J)^2: k0 is Lame's first
    parameter, whatever the scene takes it for. A dead load on four faces."""
    root = started("hyperelastic")
    body, h = root.body, 0.01
    rest = body.mstate.position.value.copy()
    shear, k0 = 5000 / 2 / 1.45, 5000 / 3 / 0.1
    matrix = stiffness_of(rest, body.Container.tetrahedra.value, k0, shear)
    mass = 0.05 / len(rest)
    load = mass * np.tile(root.gravity.value, len(rest)).reshape(-1, 3)
    for face in body.surface.Container.triangles.value[:4]:
        one, two, three = rest[face]
        load[face] += np.linalg.norm(np.cross(two - one, three - one)) / 2 / 3 * np.array([0, -5, 0])
    free = np.array([3 * i + k for i in range(len(rest)) if rest[i][0] > 0.001 for k in range(3)])
    whole = (1 + h * 0.1) * mass * np.eye(len(matrix)) + (h * h + h * 0.1) * matrix
    velocity = np.zeros(3 * len(rest))
    velocity[free] = np.linalg.solve(whole[np.ix_(free, free)], h * load.ravel()[free])
    animate(root, 1)
    assert body.mstate.velocity.value == pytest.approx(velocity.reshape(-1, 3), rel=1e-6, abs=1e-9 * abs(velocity).max())


def test_tied_nodes_stay_together():
    root = started("attached")
    held = root.one.dofs.position.value[[0, 4, 8]].copy()
    animate(root, 10)
    one, two = root.one.dofs.position.value, root.two.dofs.position.value
    assert one[[1, 3]] == pytest.approx(two[[0, 2]], abs=1e-12) and one[[0, 4, 8]] == pytest.approx(held, abs=1e-12)
    assert one[11][2] < 2 - 1e-3


def test_episodes_of_an_environment_repeat_themselves():
    import importlib.util

    spec = importlib.util.spec_from_file_location("episodes", SCENES / "episodes.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    env = module.Env({"dt": 0.02})
    seen = []
    for _ in range(3):
        assert env.reset() == pytest.approx([0.1, 0], abs=0)
        seen.append([env.step(a)[0] for a in (1.0, -2.0)])
    x, v = 0.1, 0.0
    for action, found in zip((1.0, -2.0), seen[0]):
        for _ in range(2):
            v += 0.02 * action
            x += 0.02 * v
        assert found == pytest.approx([x, v], rel=1e-9)
    assert np.array_equal(seen[0], seen[1]) and np.array_equal(seen[0], seen[2])


def test_a_camera_orbits_while_a_ball_falls():
    root = started("drawn")
    animate(root, 10)
    assert root.ball.mstate.position.value[0] == pytest.approx([0, fallen(-9.81, 0.01, 10), 0, 0, 0, 0, 1], abs=1e-9)
    assert root.camera.position.value[0] == pytest.approx(1.0) and root.sun.color.value == pytest.approx([1, 1, 1])


# ---- ways to write scenes ----

def test_an_arm_of_python_2_pulls_one_node():
    root = started("arm_of_python2")
    animate(root, 10)
    loads = root.arm.load.indices.value
    assert loads[0][0] == 1 and loads[0] + 1 == 2 and [each[0] for each in loads] == [1] and loads[:1].tolist() == [1]
    assert root.arm.dofs.position.value == pytest.approx(np.array([[0, 0, 0], [1 + fallen(1, 0.01, 10), 0, 0]]), rel=1e-9)


def test_a_monitor_writes_where_the_tip_is(folder):
    root = started("beam_argparse")
    animate(root, 4)
    rows = np.loadtxt(folder / "tip_x.txt")
    rest, places = root.beam.dofs.rest_position.value, root.beam.dofs.position.value
    assert rows[-1, 0] == pytest.approx(0.08) and rows[-1, 1:4] == pytest.approx(places[-1], rel=1e-5)
    assert places[rest[:, 0] < 1e-3] == pytest.approx(rest[rest[:, 0] < 1e-3], abs=1e-12) and places[-1][2] < 0.2 - 1e-3


def test_a_cable_pulls_with_the_force_of_a_ramp():
    """SOFA takes the number for what acts in a whole step, and tells it so."""
    root = started("robot_class")
    for step in range(1, 9):
        animate(root, 1)
        assert root.robot.top.cable.force.value == pytest.approx(min(5 * step, 30), rel=1e-9)


def test_the_first_step_of_two_materials_is_that_of_linear_elements(folder):
    root = started("two_materials")
    rest, cells = root.n.mo.position.value.copy(), root.n.topo.tetrahedra.value
    young = np.where(rest[cells].mean(axis=1)[:, 0] < 40, 1000., 5000.)
    matrix = stiffness_of(rest, cells, *lame_of(1, 0.3), young)
    h, mass = root.dt.value, 0.1 / len(rest)
    free = np.array([3 * i + k for i in range(len(rest)) if rest[i][0] > 1 for k in range(3)])
    velocity = np.zeros(3 * len(rest))
    load = h * mass * np.tile(root.gravity.value, len(rest))
    velocity[free] = np.linalg.solve((mass * np.eye(len(matrix)) + h * h * matrix)[np.ix_(free, free)], load[free])
    animate(root, 1)
    assert root.n.mo.velocity.value == pytest.approx(velocity.reshape(-1, 3), rel=1e-6, abs=1e-9 * abs(velocity).max())
    time, *tip = np.loadtxt(folder / "rows.csv", delimiter=",")
    assert time == pytest.approx(h) and tip == pytest.approx(root.n.monitor.tip.position.value[0], rel=1e-12)


def test_frames_of_an_arm_follow_its_angles():
    root = started("joints_kinematics")
    animate(root, 10)
    first, second = root.arm.dofs.position.value.ravel()
    frames = root.arm.rigid.dofs.position.value
    assert first > 0.1 and second < -0.05
    assert frames[1] == pytest.approx([0, 0, 0, 0, 0, np.sin(first / 2), np.cos(first / 2)], abs=1e-9)
    turned = (first + second) / 2
    assert frames[2] == pytest.approx([10 * np.cos(first), 10 * np.sin(first), 0, 0, 0, np.sin(turned), np.cos(turned)], abs=1e-9)


def test_a_pid_controller_follows_its_own_equations():
    root = started("pid_data")
    x = v = summed = 0.0
    last = None
    for _ in range(20):
        error = 1 - x
        summed += error * 0.01
        force = 20 * error + summed + (0 if last is None else 2 * (error - last) / 0.01)
        last = error
        v += 0.01 * force
        x += 0.01 * v
        animate(root, 1)
        assert root.n.s.position.value[0] == pytest.approx([x, 0, 0], rel=1e-9, abs=1e-12)


def test_forces_of_python_are_solved_for():
    """(m + h^2 k) dv = h (m g + k (X - x) - c v - h k v): the derivative has the stiffness alone."""
    root = started("springs_in_python")
    k, c, h, m = 100.0, 0.1, 0.01, 1.0
    y = v = 0.0
    for _ in range(20):
        v += h * (-10 * m - k * y - c * v - h * k * v) / (m + h * h * k)
        y += h * v
        animate(root, 1)
        assert root.n.mo.position.value == pytest.approx(np.array([[0, y, 0], [1, y, 0]]), rel=1e-9)


def test_a_body_follows_a_spline():
    """(m (1 + h rM) + h^2 k) dv = h (k (s - x) - rM m v - h k v), s where the rest is at the start of the step."""
    from scipy.interpolate import CubicSpline

    root = started("spline_follow")
    t = np.linspace(0, 1, 5)
    spline = CubicSpline(t, np.c_[np.sin(t), np.cos(t) - 1, 0 * t])
    h, m, k = 0.01, 0.01, 1e4
    x, v = np.zeros(3), np.zeros(3)
    for step in range(10):
        v = v + h * (k * (spline(step * h) - x) - m * v - h * k * v) / (m * (1 + h) + h * h * k)
        x = x + h * v
        animate(root, 1)
        assert root.n.mo.position.value[0] == pytest.approx(x, rel=1e-8, abs=1e-12)


def test_a_machine_stops_pushing():
    root = started("state_machine")
    animate(root, 10)
    assert root.n.mo.velocity.value[0] == pytest.approx([4 * 0.01, 0, 0])
    assert root.n.mo.position.value[0] == pytest.approx([fallen(1, 0.01, 4) + 6 * 0.01 * 0.04, 0, 0])
