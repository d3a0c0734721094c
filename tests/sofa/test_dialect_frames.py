# SPDX-License-Identifier: LGPL-2.1-or-later
"""Frames in SOFA's dialect: rods, beams, arms and what rides on them.
Usage: test_dialect_frames.py STROMA [WORD]."""
import numpy as np

from dialect import (DAMPED_SOLVERS, EXACT, FREE_LOOP, Run, agree, case, differ, fallen, main, node, numbers_of, oriented,
                     root)
from reference import (axes_of, euler, euler_frames, first_end_beams, inverse, load, product, rotation_vector, springs, swept,
                       turn_of)


@case
def frames_in_a_body():
    """A body that is stretched and turned by 90 degrees about z where the scene starts: x = Q S X, S = diag(2, 1, 0.5). What a
    RigidMapping carries on the frame is where Q takes it from the frame's centre."""
    corners = "0 0 0  1 0 0  0 1 0  0 0 1"
    body = (f'<MeshTopology position="{corners}" tetrahedra="0 1 2 3"/><MechanicalObject name="dofs" rest_position="{corners}" '
            'position="0 0 0  0 2 0  -1 0 0  0 0 0.5"/><UniformMass totalMass="4"/><FixedConstraint indices="0 1 2 3"/>')
    frame = ('<Node name="frame"><MechanicalObject name="frame" template="Rigid3d" position="0.25 0.25 0.25 0 0 0 1"/>'
             '<BarycentricMapping template="Vec3d,Rigid3d" useRestPosition="1"/><Node name="tip"><MechanicalObject name="tip" '
             'position="1 0 0  0 0 3"/><RigidMapping/></Node></Node>')
    run = Run(root(EXACT + body + frame), 2)
    run.says("SOFA may pass other ones")
    agree(run.x("frame.tip.tip"), [[-0.25, 1.5, 0.125], [-0.25, 0.5, 3.125]])


@case
def frames_whose_translation_is_fixed_feel_no_torque():
    """SOFA clears the whole right side of them: they go on turning as they did. An assembled matrix does not know of them: what is
    tied to them by stiffness draws them along."""
    frame = ('<MechanicalObject name="dofs" template="Rigid3" position="0 0 0 0 0 0 1" velocity="0 0 0 0 0 0.5"/><UniformMass totalMass="2"/>'
             '<ConstantForceField indices="0" forces="0 0 0 0 0 3"/>{}<FixedTranslationProjectiveConstraint indices="0"/>')
    for solver in DAMPED_SOLVERS:
        undamped = solver.replace('rayleighMass="0.1"', "")
        run = Run(root(undamped + frame.format("")), 10)
        agree(run.x("dofs", 7)[0], [0, 0, 0, 0, 0, np.sin(0.025), np.cos(0.025)])
        differ(Run(root(undamped + frame.format("")), 10, args=["--without-quirk", "one-sided-turns"]).x("dofs", 7)[0],
               [0, 0, 0, 0, 0, np.sin(0.025), np.cos(0.025)], 1e-3)
    x, v, h = np.zeros(2), np.zeros(2), 0.01  # of the frame, and of a frame that is pushed and tied to it
    K, M, f = 40 * np.array([[-1, 1], [1, -1]]), 2 * np.eye(2), np.array([0, 6])
    for _ in range(10):
        b = h * (f + K @ (x + h * v))
        b[0] = 0
        v = v + np.linalg.solve(M - h * h * K, b)
        x = x + h * v
    tied = root('<EulerImplicitSolver/><SparseLDLSolver/><MechanicalObject name="dofs" template="Rigid3" position="0 0 0 0 0 0 1  0 0 0 0 0 0 1"/>'
                '<UniformMass vertexMass="2 1 1 0 0 0 1 0 0 0 1"/>'
                '<ConstantForceField indices="1" forces="6 0 0 0 0 0"/>'
                '<FixedTranslationProjectiveConstraint indices="0"/><Node name="centres"><MechanicalObject name="points"/><IdentityMapping/>'
                '<SpringForceField spring="0 1 40 0 0"/></Node>', "")
    run = Run(tied, 10, args=["--without-quirk", "meeting-ends"])
    agree(run.x("dofs", 7)[:, 0], x)


@case
def corrections_of_frames_by_a_default():
    """A frame with defaultCompliance moves by it, and turns by 1 whatever its inertia; other numbers than 7 do not count."""
    arm, h = np.array([0.6, 0.2, -0.1]), 0.01
    for given, C in (('defaultCompliance="0.7"', np.diag([0.7] * 3 + [1] * 3)),
                     ('compliance="0.4 2 3"', np.diag([0.5] * 3 + list(1 / np.array([0.3, 0.5, 0.4]))))):
        c, q, u = np.zeros(3), np.array([0, 0, 0, 1.0]), np.array([0.3, 0, -0.2, 0.5, -1, 0.4])
        for _ in range(10):
            u[1] -= 10 * h
            c, q = c + h * u[:3], product(turn_of(h * u[3:]), q)
            r = axes_of(q) @ arm
            J = np.hstack([np.eye(3), -np.array([[0, -r[2], r[1]], [r[2], 0, -r[0]], [-r[1], r[0], 0]])])
            d = C @ J.T @ np.linalg.solve(J @ C @ J.T, -(c + r - arm))
            c, q, u = c + d[:3], product(turn_of(d[3:]), q), u + d / h
        run = Run(root(FREE_LOOP + f'<Node name="frame">{EXACT}<MechanicalObject name="dofs" template="Rigid3" position="0 0 0 0 0 0 1" '
                       'velocity="0.3 0 -0.2 0.5 -1 0.4"/><UniformMass vertexMass="2 1 0.15 0 0 0 0.25 0 0 0 0.2"/>'
                       f'<UncoupledConstraintCorrection {given}/><Node name="arm"><MechanicalObject name="dofs" position="{numbers_of(arm)}"/>'
                       '<RigidMapping/><FixedLagrangianConstraint indices="0"/></Node></Node>'), 10)
        agree(run.x("frame.dofs", 7)[0], np.r_[c, q], 1e-8)
        assert ("compliance has 3 numbers and no effect" in run.text) == given.startswith("compliance"), run.text


@case
def a_sphere_of_two_sides():
    """f = -k (|y| - r) n inside and outside, with its derivative."""
    start = np.array([[0.5, 0, 0], [0, 2, 0.5]])

    def sphere(x, v):
        f, K = np.zeros_like(x), np.zeros((6, 6))
        for i, y in enumerate(x):
            length = np.linalg.norm(y)
            n = y / length
            f[i] = -30 * (length - 1) * n
            K[3 * i:3 * i + 3, 3 * i:3 * i + 3] = -30 * ((1 - 1 / length) * np.eye(3) + np.outer(n, n) / length)
        return f, K
    scene = node(EXACT + '<MechanicalObject name="dofs" position="0.5 0 0  0 2 0.5"/><UniformMass totalMass="2"/><SphereForceField '
                 'radius="1" stiffness="30" damping="0" {}/>')
    agree(Run(scene.format('bilateral="1"'), 20).x(), euler(start, np.eye(2), sphere, 20, 0.01))
    agree(Run(scene.format('bilateral="0"'), 20).x()[1], start[1])


@case
def frames_on_nodes():
    """z along the normal and x = y axis x z; or x along the way to the next node; turned about one of their axes."""
    def quaternion(axes, axis, angle):
        turn = turn_of(np.radians(angle) * axes[:, axis])
        return axes_of(turn) @ axes

    def unit(v):
        return np.asarray(v) / np.linalg.norm(v)

    def frames_of(engine):
        return Run(root(engine + EXACT + '<Node name="a"><MechanicalObject name="dofs" template="Rigid3" position="@../e.frames"/>'
                        '<UniformMass totalMass="1"/></Node>', 'gravity="0 0 0"'), 1).x("a.dofs", 7)
    nodes, normals = np.array([[0, 0, 0], [1, 0, 0], [1.5, 1, 0.5]]), np.array([[0, 0, 2.0], [0, 1, 0], [0.3, -0.9, 0.2]])
    for more, by_normals, sign, axis, angle in (("", True, 1, 0, 0), ('invertNormals="1" rotation="2" rotationAngle="40"', True, -1, 2, 40),
                                                ('useNormals="0" rotation="1" rotationAngle="-30"', False, 1, 1, -30),
                                                ('rotationAngle="25"', True, 1, 0, 25)):
        frames = frames_of(f'<Vertex2Frame name="e" position="{numbers_of(nodes)}" normals="{numbers_of(normals)}" {more}/>')
        for i, got in enumerate(frames):
            if by_normals:
                z = sign * unit(normals[i])
                x = unit(np.cross([0, 0, 1] if abs(z[1]) == 1 else [0, 1, 0], z))
                y = np.cross(z, x)
            else:
                x = unit(nodes[min(i, 1) + 1] - nodes[min(i, 1)])
                y = unit(np.cross([0, 0, 1] if abs(x[0]) == 1 else [1, 0, 0], x))
                z = np.cross(x, y)
            agree(got[:3], nodes[i])
            agree(axes_of(got[3:]), quaternion(np.array([x, y, z]).T, axis, angle))


@case
def points_about_a_chain_of_beams():
    """Cubic shares of two frames; the last frame of three is turned by a right angle about z."""
    turn = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1.0]])
    frames = ('<MechanicalObject template="Rigid3" name="f" position="0 0 0 0 0 0 1  1 0 0 0 0 0 1  '
              f'3 0 0 0 0 {np.sqrt(0.5)} {np.sqrt(0.5)}"/>')
    scene = node(EXACT + frames + '<UniformMass/><FixedConstraint indices="0 1 2"/><Node name="c">'
                 '<MechanicalObject name="dofs" position="0.25 0.1 0  1.5 0.2 0.4"/><BeamLinearMapping isMechanical="true"/></Node>')
    x = Run(scene, 1).x("c.dofs")
    s, u = 3 / 16 - 2 / 64, np.array([0.25, 0.1, 0.2])
    agree(x, [[0.25, 0.1, 0], (1 - s) * (np.array([1, 0, 0]) + 2 * u) + s * (np.array([3, 0, 0]) + turn @ (2 * u - [2, 0, 0]))], 1e-9)


@case
def the_middle_of_frames_and_points_of_several_states():
    """A force on the centre of mass moves all frames alike; a spring between states that are one."""
    frames = ('<MechanicalObject name="dofs" template="Rigid3d" position="0 0 0 0 0 0 1  4 0 0 0 0 0 1"/>'
              '<UniformMass vertexMass="2"/><Node name="c"><MechanicalObject name="middle" position="0 0 0"/>'
              '<CenterOfMassMapping template="Rigid3d,Vec3d"/><ConstantForceField forces="0 0 8"/></Node>')
    run = Run(node(EXACT + frames), 5)
    push = euler(np.zeros((1, 3)), [[1]], load({0: np.array([0, 0, 2.0])}), 5, 0.01)[0, 2]
    agree(run.x("dofs", 7)[:, :3], [[0, 0, push], [4, 0, push]])
    agree(run.x("c.middle"), [[2, 0, push]])
    body = '<Node name="{}"><MechanicalObject name="dofs" position="{}"/><UniformMass vertexMass="1"/></Node>'
    both = ('<Node name="both"><MechanicalObject name="all"/><IdentityMultiMapping template="Vec3d,Vec3d" input="@../a/dofs @../b/dofs" '
            'output="@all"/><SpringForceField spring="1 2 30 0 1"/></Node>')
    x = np.array([[0, 0, 0], [1, 0, 0], [3, 1, 0.0]])
    expected = euler(x, np.eye(3), springs([(1, 2)], [[0, 0, 0], [0, 0, 0], [1, 0, 0]], 30, per_length=False), 10, 0.01)
    scene = node(EXACT + body.format("a", "0 0 0  1 0 0") + body.format("b", "3 1 0") + both)
    run = Run(scene, 10)
    agree(run.x("both.all"), expected, 1e-8)
    agree(run.x("b.dofs"), expected[2:], 1e-8)
    pairs = scene.replace('<IdentityMultiMapping template="Vec3d,Vec3d"', '<SubsetMultiMapping indexPairs="0 1  1 0"').replace(
        "1 2 30", "0 1 30")
    agree(Run(pairs, 10).x("both.all"), expected[1:], 1e-8)


def rod_of(curvatures, lengths, places, steps=400):
    """Places of a rod by 400 steps a section: p' = R x, R' = R [k]."""
    out, p, R, s = [], np.zeros(3), np.eye(3), 0.0
    ends = np.cumsum(lengths)
    for place in places:
        while s < place - 1e-12:
            section = int(np.searchsorted(ends, s + 1e-9))
            ds = min(lengths[section] / steps, place - s)
            k = np.asarray(curvatures[section], float)
            angle = np.linalg.norm(k) * ds

            def turned(fraction):
                if angle == 0:
                    return np.eye(3)
                a = k / np.linalg.norm(k)
                A = np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])
                return np.eye(3) + np.sin(angle * fraction) * A + (1 - np.cos(angle * fraction)) * A @ A
            x = np.array([1.0, 0, 0])
            p = p + ds * R @ (x + 4 * turned(0.5) @ x + turned(1) @ x) / 6
            R = R @ turned(1)
            s += ds
        out.append(p)
    return np.array(out)


ROD = ('<Node name="base"><MechanicalObject name="base" template="Rigid3d" position="0 0 0 0 0 0 1"/><UniformMass totalMass="1"/>'
       '<FixedConstraint indices="0"/></Node><Node name="strain"><MechanicalObject name="k" position="0 0 0  0 0 0"/>'
       '<UniformMass totalMass="1e-3"/><BeamHookeLawForceField length="0.5 0.3" {}/>'
       '<Node name="rod"><MechanicalObject name="frames" template="Rigid3d" position="0 0 0 0 0 0 1  0.2 0 0 0 0 0 1  0.5 0 0 0 0 0 1  '
       '0.8 0 0 0 0 0 1"/><DiscreteCosseratMapping input1="@../k" input2="@../../base/base" '
       'output="@frames" curv_abs_input="0 0.5 0.8" curv_abs_output="0 0.2 0.5 0.8"/>{}</Node></Node>')
STILL = ('<StaticSolver newtonSolver="@n"/><NewtonRaphsonSolver name="n" maxNbIterationsNewton="{}" '
         'relativeInitialStoppingThreshold="1e-11" relativeSuccessiveStoppingThreshold="0" absoluteResidualStoppingThreshold="1e-13"/>'
         '<SparseLDLSolver/>')


@case
def a_rod_under_a_moment_is_an_arc():
    """E Iz k = M everywhere; a torque about x twists it by M / (G J)."""
    young, nu, r = 2e5, 0.3, 0.02
    Iz = np.pi * r**4 / 4
    law = f'radius="{r}" youngModulus="{young}" poissonRatio="{nu}"'
    pull = '<ConstantForceField indices="3" forces="0 0 0 {}"/>'
    moment = 0.03
    run = Run(node(STILL.format(5) + ROD.format(law, pull.format(f"0 0 {moment}"))), 1)
    k = moment / (young * Iz)
    agree(run.x("strain.k"), [[0, 0, k], [0, 0, k]], 1e-9)
    s = np.array([0, 0.2, 0.5, 0.8])
    agree(run.x("strain.rod.frames", 7)[:, :3], np.transpose([np.sin(k * s) / k, (1 - np.cos(k * s)) / k, 0 * s]), 1e-9)
    run = Run(node(STILL.format(5) + ROD.format(law, pull.format("0.01 0 0"))), 1)
    twist = 0.01 / (young / (2 * (1 + nu)) * 2 * Iz)
    agree(run.x("strain.k"), [[twist, 0, 0], [twist, 0, 0]], 1e-9)
    agree(2 * np.arcsin(run.x("strain.rod.frames", 7)[3, 3]), 0.8 * twist, 1e-9)
    tube = Run(node(STILL.format(5) + ROD.format(law + ' innerRadius="0.01"', pull.format(f"0 0 {moment}"))), 1)
    agree(tube.x("strain.k")[0, 2], moment / (young * np.pi * (r**4 - 0.01**4) / 4), 1e-9)
    flat = Run(node(STILL.format(5) + ROD.format('crossSectionShape="rectangular" lengthY="0.03" lengthZ="0.01" youngModulus="2e6" '
                                                 'poissonRatio="0.3"', pull.format(f"0 0 {moment}"))), 1)
    agree(flat.x("strain.k")[0, 2], moment / (2e6 * 0.01 * 0.03**3 / 12), 1e-9)
    own = Run(node(STILL.format(5) + ROD.format('useInertiaParams="1" GI="0.02" EI="0.05"', pull.format(f"0.001 0 0"))), 1)
    agree(own.x("strain.k")[0, 0], 0.001 / 0.02, 1e-9)


@case
def a_rod_under_a_force_is_where_its_energy_is_least():
    """The derivative of L k D k / 2 - F.p is zero there, with the places of an integrator of its own."""
    law, force = 'useInertiaParams="1" GI="0.02" EI="0.05"', np.array([0.05, 0.11, -0.07])
    pull = f'<ConstantForceField indices="3" forces="{force[0]} {force[1]} {force[2]} 0 0 0"/>'
    k = Run(node(STILL.format(100) + ROD.format(law, pull)), 1).x("strain.k")
    lengths, D = [0.5, 0.3], np.array([0.02, 0.05, 0.05])

    def energy(k):
        return sum(L * (D * one) @ one / 2 for L, one in zip(lengths, k)) - rod_of(k, lengths, [0.8])[0] @ force
    steps = 1e-4 * np.eye(6).reshape(6, 2, 3)
    slope = np.array([(energy(k + u) - energy(k - u)) / 2e-4 for u in steps])
    straight = np.array([(energy(u) - energy(-u)) / 2e-4 for u in steps])
    assert np.abs(k).max() > 0.5 and np.abs(slope).max() < 1e-5 * np.abs(straight).max(), (k, slope, straight)
    frames = Run(node(STILL.format(100) + ROD.format(law, pull)), 1).x("strain.rod.frames", 7)
    agree(frames[:, :3], rod_of(k, lengths, [0, 0.2, 0.5, 0.8]), 1e-8)


@case
def a_rod_that_stretches_and_shears():
    """Strains of six numbers: F = E A e along the rod, G A e across it, E I k = M; the deflection of a short rod is that of Timoshenko."""
    rod = ROD.replace('name="k" position="0 0 0  0 0 0"', f'name="k" template="Vec6d" position="{"0 " * 12}"')
    young, nu, r, places = 2e5, 0.3, 0.02, np.array([0, 0.2, 0.5, 0.8])
    area, second, shear = np.pi * r**2, np.pi * r**4 / 4, young / (2 * (1 + nu))
    law = f'radius="{r}" youngModulus="{young}" poissonRatio="{nu}"'

    def pulled(law, force):
        run = Run(node(STILL.format(50) + rod.format(law, f'<ConstantForceField indices="3" forces="{numbers_of(force)}"/>')), 1)
        assert run.code == 0, run.text
        return run.x("strain.k", 6), run.x("strain.rod.frames", 7)[:, :3]
    strains, frames = pulled(law, [5.0, 0, 0, 0, 0, 0])
    agree(strains, [[0, 0, 0, 5 / (young * area), 0, 0]] * 2, 1e-9)
    agree(frames[:, 0], places * (1 + 5 / (young * area)), 1e-9)
    k = 0.03 / (young * second)
    strains, frames = pulled(law, [0, 0, 0, 0, 0, 0.03])
    agree(strains, [[0, 0, k, 0, 0, 0]] * 2, 1e-9)
    agree(frames, np.transpose([np.sin(k * places) / k, (1 - np.cos(k * places)) / k, 0 * places]), 1e-9)
    strains, frames = pulled('useInertiaParams="1" GI="1e7" EI="1e7" EA="1e7" GA="20"', [0, 0.4, -0.6, 0, 0, 0])
    agree(strains[:, 4:], [[0.4 / 20, -0.6 / 20]] * 2, 1e-6)
    agree(frames[:, 1:], np.outer(places, [0.4 / 20, -0.6 / 20]), 1e-6)
    force, levers, lengths = 1e-6, np.array([0.8 - 0.25, 0.15]), np.array([0.5, 0.3])
    strains, frames = pulled(law, [0, force, 0, 0, 0, 0])
    agree(frames[3, 1], force * (lengths @ levers**2 / (young * second) + 0.8 / (shear * area)), 1e-5)
    varied = 'variantSections="1" youngModulusList="1e5 4e5" poissonRatioList="0.3 0.1" radius="0.02"'
    agree(pulled(varied, [5.0, 0, 0, 0, 0, 0])[0][:, 3], [5 / (1e5 * area), 5 / (4e5 * area)], 1e-9)
    Run(node(EXACT + rod.format('useInertiaParams="1" GI="1" EI="1"', "")), 1).fails(2, "without GA and EA")


@case
def rods_say_what_does_not_fit():
    good = node(EXACT + ROD.format('radius="0.01"', ""))
    for old, new, words in (('curv_abs_input="0 0.5 0.8"', 'curv_abs_input="0 0.5"', "2 lengths for the 2 sections"),
                            ('curv_abs_input="0 0.5 0.8"', 'curv_abs_input="0 0.9 0.8"', "goes from 0.9 to 0.8"),
                            ('curv_abs_output="0 0.2 0.5 0.8"', 'curv_abs_output="0 0.2 0.5 1.8"', "a frame at 1.8 is not on the rod"),
                            ('curv_abs_output="0 0.2 0.5 0.8"', 'curv_abs_output="0 0.2"', "2 lengths for the 4 frames"),
                            ('input2="@../../base/base"', "", "input2 is not given"),
                            ('length="0.5 0.3"', 'length="0.5 0.3 0.1"', "length has 3 values for 2 sections")):
        Run(good.replace(old, new), 1).fails(2, words)


@case
def a_moment_that_oscillates_is_that_of_the_start_of_a_step():
    """A triangle around its first corner, held by nothing else: each step adds dt M cos(2 pi f t) to its moment of momentum."""
    scene = node('<EulerExplicitSolver/><MeshTopology position="0 0 0  2 0 0  0 2 0" triangles="0 1 2"/><MechanicalObject name="dofs"/>'
                 '<UniformMass totalMass="3"/><FixedConstraint indices="0"/>'
                 '<OscillatingTorsionPressureForceField moment="0.8" frequency="5" axis="0 0 1" penalty="0" triangleList="0"/>')
    x = np.array([[2.0, 0, 0], [0, 2, 0]])
    v = np.zeros_like(x)
    for step in range(20):
        moment = 0.8 * np.cos(2 * np.pi * 5 * step * 0.01)
        for i in range(2):  # both have half of it, along the tangent
            v[i] += 0.01 * moment / 2 * np.cross([0, 0, 1], x[i]) / (x[i] @ x[i])
        x = x + 0.01 * v
    agree(Run(scene, 20).x()[1:], x)
    agree(Run(scene.replace("<EulerExplicitSolver/>", EXACT), 20).x()[1:], x)  # the force has no derivative
    run = Run(scene.replace('triangleList="0"', ""), 2)  # nor a triangle, where none is chosen
    run.says("triangleList: is not given")
    agree(run.x()[1:], [[2, 0, 0], [0, 2, 0]])


def pulled_arm(turns, steps=30):
    """A frame whose point at (1, 0, 0) in its axes is pulled: turns, with the change of the torque in the tangent."""
    pull, mass, inertia = np.array([0, -40.0, 0]), 0.5, 0.05

    def forces(x, v):
        arm = axes_of(x[0, 3:]) @ np.array([1.0, 0, 0])
        f, K = np.zeros((1, 6)), np.zeros((6, 6))
        f[0, :3], f[0, 3:] = pull + np.array([0, -10 * mass, 0]), np.cross(arm, pull)
        if turns:  # (w x arm) x pull
            K[3:, 3:] = np.outer(arm, pull) - np.eye(3) * (arm @ pull)
        return f, K
    return euler_frames([[0, 0, 0, 0, 0, 0, 1]], [mass] * 3 + [inertia] * 3, forces, steps, 0.01)


@case
def quirk_held_arms():
    frame = ('<EulerImplicitSolver/>{}<MechanicalObject name="dofs" template="Rigid3" position="0 0 0 0 0 0 1"/><UniformMass '
             'vertexMass="0.5 1 0.1 0 0 0 0.1 0 0 0 0.1"/><Node name="c">{}</Node>')
    point = '<MechanicalObject position="1 0 0"/>{}<ConstantForceField indices="0" forces="0 -40 0"/>'
    arm = '<MechanicalObject template="Rigid3" position="1 0 0 0 0 0 1"/><RigidRigidMapping/><ConstantForceField forces="0 -40 0 0 0 0"/>'
    direct, iterative = "<SparseLUSolver/>", '<CGLinearSolver iterations="50" tolerance="1e-14" threshold="1e-30"/>'
    skin = point.format('<SkinningMapping nbRef="1" indices="0" weight="1"/>')
    off = ["--without-quirk", "held-arms"]
    for solver, child, args, turns in (
            (direct, point.format("<RigidMapping/>"), [], False), (direct, point.format("<RigidMapping/>"), off, True),
            (direct, point.format('<RigidMapping geometricStiffness="Exact"/>'), [], True), (direct, skin, [], False),
            (direct, skin, off, True), (direct, arm, [], False), (iterative, arm, [], True)):
        agree(Run(root(frame.format(solver, child)), 30, args=args).x(width=7), pulled_arm(turns), 1e-7)
    differ(pulled_arm(False), pulled_arm(True), 1e-2)


@case
def quirk_first_end_beams():
    """Beams along x, along y with the same axes, and about a corner, all of which bend far."""
    turned = [0, 0, np.sin(0.4), np.cos(0.4)]
    for rest in ([[0, 0, 0, 0, 0, 0, 1], [1, 0, 0, 0, 0, 0, 1], [2, 0, 0, 0, 0, 0, 1]],
                 [[0, 0, 0, 0, 0, 0, 1], [0, 1, 0, 0, 0, 0, 1], [0, 2, 0.5, 0, 0, 0, 1]],
                 [[0, 0, 0, 0, 0, 0, 1], [1, 0, 0, *turned], [1.5, 0.9, 0, *turned]]):
        rest = np.array(rest, float)
        scene = root(EXACT + '<MechanicalObject name="dofs" template="Rigid3" position="' + " ".join(repr(float(n)) for n in rest.ravel()) +
                     '"/><UniformMass vertexMass="0.5 1 0.1 0 0 0 0.1 0 0 0 0.1"/><MeshTopology lines="0 1 1 2"/>'
                     '<BeamFEMForceField youngModulus="2e5" radius="0.1"/><FixedConstraint indices="0"/>'
                     '<ConstantForceField indices="2" forces="0 0 -20 5 0 0"/>')
        beams = first_end_beams([(0, 1), (1, 2)], rest, 2e5, 0.49, 0.1)

        def forces(x, v):
            f, K = beams(x, v)
            f[:, 1] -= 0.5 * 10
            f[2] += [0, 0, -20, 5, 0, 0]
            return f, K
        expected = euler_frames(rest, [0.5] * 3 + [0.05] * 3, forces, 40, 0.01, held=[0])
        agree(Run(scene, 40).x(width=7), expected, 1e-8)
        differ(Run(scene, 40, args=["--without-quirk", "first-end-beams"]).x(width=7), expected, 1e-3)


@case
def wheels_turn_each_other():
    """A wheel that turns drives the other one backwards at twice the speed, with SOFA's words and order: pivots first."""
    frames = ('<MechanicalObject name="dofs" template="Rigid3d" position="0 0 0 0 0 0 1  2 0 0 0 0 0 1" velocity="0 0 0 0 0 1  0 0 0 0 0 -2"/>'
              '<UniformMass vertexMass="1 1 [0.1 0 0,0 0.1 0,0 0 0.1]"/>')
    gear = '<GearSpringForceField spring="BEGIN_SPRING 0 0 1 1 AXIS 2 2 KS_R 1e3 1e4 KD 0 RATIO 2 END_SPRING"/>'
    x = Run(node(EXACT + frames + gear), 50).x("dofs", 7)
    agree(x, [[0, 0, 0, 0, 0, np.sin(0.25), np.cos(0.25)], [2, 0, 0, 0, 0, -np.sin(0.5), np.cos(0.5)]], 1e-9)


@case
def a_plane_holds_the_centres_of_frames():
    plane = '<UniformMass totalMass="2"/><PlaneForceField normal="0 1 0" d="0" stiffness="300" damping="2"/>'
    frame = Run(root(EXACT + '<MechanicalObject name="dofs" template="Rigid3" position="1 -0.1 0 0 0 0.6 0.8"/>' + plane), 10).x("dofs", 7)
    point = Run(root(EXACT + '<MechanicalObject name="dofs" position="1 -0.1 0"/>' + plane), 10).x()
    agree(frame, [[*point[0], 0, 0, 0.6, 0.8]])
    assert point[0, 1] > -0.1, point
    Run(root(EXACT + '<MechanicalObject template="Vec1" position="0"/>' + plane), 1).fails(2, "acts on points")


@case
def frames_shared_out_to_frames():
    """repartition: how many frames each one carries."""
    frames = ('<MechanicalObject name="dofs" template="Rigid3" position="0 0 0 0 0 0 1  5 0 0 0 0 0.6 0.8" velocity="1 0 0 0 0 2  0 1 0 0 0 0"/>'
              '<UniformMass totalMass="2"/><Node name="c"><MechanicalObject name="k" template="Rigid3" position="0 1 0 0 0 0 1  1 0 0 0 0 0 1  '
              '0 0 2 0 0 0 1"/><RigidRigidMapping repartition="{}"/></Node>')
    x = Run(node(EXACT + frames.format("1 2")), 10).x("c.k", 7)
    s, c = np.sin(0.2), np.cos(0.2)
    turned = [[0.1 - s, c, 0, 0, 0, np.sin(0.1), np.cos(0.1)], [5 + 0.28, 0.1 + 0.96, 0, 0, 0, 0.6, 0.8], [5, 0.1, 2, 0, 0, 0.6, 0.8]]
    agree(x, turned)
    Run(node(EXACT + frames.format("1 3")), 1).fails(2, "shares out 4 points, and there are 3")
    Run(node(EXACT + frames.format("1 1 1")), 1).fails(2, "repartition has 3 numbers")
    each = frames.format("2").replace("0 1 0 0 0 0 1  1 0", "0 1 0 0 0 0 1  0 1 0 0 0 0 1  1 0")
    agree(Run(node(EXACT + each), 10).x("c.k", 7), [turned[0], turned[0], turned[1], turned[2]])


def cross_of(r):
    return np.array([[0, -r[2], r[1]], [r[2], 0, -r[0]], [-r[1], r[0], 0]])


def skinned(points, frames, count, k, push):
    """Weights 1/d^2 of the nearest frames, of frames as near the later one first; springs -k (y - points); arms that are held."""
    carried = []
    for p in points:
        square = [(p - frame[:3]) @ (p - frame[:3]) for frame in frames]
        order = sorted(range(len(frames)), key=lambda j: (square[j], -j))[:count]
        total = sum(1 / square[j] for j in order)
        carried.append([(j, 1 / square[j] / total, axes_of(frames[j][3:]).T @ (p - frames[j][:3])) for j in order])

    def places(x):
        return np.array([sum(w * (x[j][:3] + axes_of(x[j][3:]) @ local) for j, w, local in one) for one in carried])

    def field(x, v):
        J = np.zeros((3 * len(points), 6 * len(x)))
        for i, one in enumerate(carried):
            for j, w, local in one:
                J[3 * i:3 * i + 3, 6 * j:6 * j + 3] += w * np.eye(3)
                J[3 * i:3 * i + 3, 6 * j + 3:6 * j + 6] -= w * cross_of(axes_of(x[j][3:]) @ local)
        f = -k * (places(x) - points) + push
        return (J.T @ f.ravel()).reshape(-1, 6), -k * J.T @ J
    return places, field


@case
def points_that_follow_the_nearest_frames():
    """Two frames are as near to one of the points; and frames that start elsewhere than they rest, where the points are bound."""
    rest = np.array([[0, 0, 0, *oriented([1, 2, 0], 0.4)], [1, 0.1, 0, *oriented([0, 1, 1], -0.7)], [2, 0, 0.2, *oriented([1, 0, 0], 0.2)],
                     [3, 0, 0, *oriented([1, 1, 1], 1.0)]])
    points = np.array([[0.3, 0.5, 0.1], [1.4, -0.4, 0.2], [2.5, 0.2, 0.6], [1.5, 0.05, 2.0], [0.9, 0.3, -0.5]])
    push = np.array([[3, -2, 1], [0, 4, 0], [1, 1, -5], [0.5, 0, 2], [-1, 2, 0.3]])
    moved = rest.copy()
    moved[1, 2], moved[2, 3:] = 0.3, oriented([1, 1, 0], 0.5)
    for frames in (rest, moved):
        for count in (1, 2, 3, 4):
            places, field = skinned(points, rest, count, 60, push)
            scene = node(EXACT + f'<MechanicalObject name="dofs" template="Rigid3d" position="{numbers_of(frames)}" rest_position="'
                         f'{numbers_of(rest)}"/><UniformMass vertexMass="1.5 1 [0.2 0 0,0 0.3 0,0 0 0.4]"/><FixedConstraint indices="0"/>'
                         f'<Node name="c"><MechanicalObject name="skin" position="{numbers_of(points)}" rest_position="{numbers_of(points)}"/>'
                         f'<SkinningMapping nbRef="{count}"/><RestShapeSpringsForceField stiffness="60"/>'
                         f'<ConstantForceField indices="0 1 2 3 4" forces="{numbers_of(push)}"/></Node>')
            run = Run(scene, 6)
            x = euler_frames(frames, 1.5 * np.array([1, 1, 1, 0.2, 0.3, 0.4]), field, 6, 0.01, held=[0])
            agree(run.x("c.skin"), places(x))
            agree(run.x("dofs", 7), x)


@case
def arms_of_hinges_and_slides():
    """Two hinges in one centre and a slide, with the masses of the frames: J by differences, and no change of J in the tangent."""
    joints = [[np.array(p) for p in pair] for pair in (([0.1, 0.2, 0], [-0.4, 0, 0.1]), ([0.5, 0, 0.1], [-0.3, 0.1, 0]))]
    axes = [np.array([0, 0, 1.]), np.array([0.6, 0, 0.8]), np.array([0, 1., 0])]

    def frames_at(y):
        q = product(turn_of(axes[0] * y[0]), turn_of(axes[1] * y[1]))
        R = axes_of(q)
        one = joints[0][0] - R @ joints[0][1]
        return [np.r_[one, q], np.r_[one + R @ (joints[1][0] + axes[2] * y[2]) - R @ joints[1][1], q]]

    def jacobian(y, h=1e-6):
        J = np.zeros((12, 3))
        for k, e in enumerate(np.eye(3) * h):
            for m, (a, b) in enumerate(zip(frames_at(y + e), frames_at(y - e))):
                J[6 * m:6 * m + 6, k] = np.r_[a[:3] - b[:3], rotation_vector(product(a[3:], inverse(b[3:])))] / (2 * h)
        return J
    start = np.array([0.3, -0.2, 0.15])
    loads = np.array([1, 0, 2, 0.5, 0, 0.1, -1, 1, 0, 0, 0.3, 0])
    M, h, k = np.diag(np.tile([2, 2, 2, 0.2, 0.4, 0.6], 2)), 0.01, 4.0
    y, v = start.copy(), np.zeros(3)
    for _ in range(6):
        J = jacobian(y)
        f = J.T @ (loads + np.tile([0, -20, 0, 0, 0, 0], 2)) - k * y
        v = v + np.linalg.solve(J.T @ M @ J + (0.01 + h * h * k) * np.eye(3), h * (f - h * k * v))
        y = y + h * v
    centre = '<Node name="{}"><ArticulationCenter parentIndex="{}" childIndex="{}" posOnParent="{}" posOnChild="{}"/>{}</Node>'
    part = '<Node name="a{0}"><Articulation rotation="{1}" translation="{2}" rotationAxis="{3}" articulationIndex="{0}"/></Node>'
    parts = [part.format(i, int(i < 2), int(i == 2), numbers_of(axis)) for i, axis in enumerate(axes)]
    text = (centre.format("one", 0, 1, *map(numbers_of, joints[0]), parts[0] + parts[1]) +
            centre.format("two", 1, 2, *map(numbers_of, joints[1]), parts[2]))
    for solver in (EXACT, '<EulerImplicitSolver/><CGLinearSolver iterations="300" tolerance="1e-15" threshold="0"/>'):
        arm = root(f'<Node name="arm">{solver}<MechanicalObject name="y" template="Vec1" position="{numbers_of(start)}" rest_position='
                   '"0 0 0"/><UniformMass vertexMass="0.01"/><RestShapeSpringsForceField stiffness="4"/>'
                   f'<ArticulatedHierarchyContainer/>{text}<Node name="rigid"><MechanicalObject template="Rigid3" name="dofs" position='
                   f'"0 0 0 0 0 0 1 {numbers_of(frames_at(start))}"/><UniformMass vertexMass="2 1 0.1 0 0 0 0.2 0 0 0 0.3"/>'
                   f'<ConstantForceField indices="1 2" forces="{numbers_of(loads)}"/><ArticulatedSystemMapping input1="@../y" '
                   'output="@dofs"/></Node></Node>')
        run = Run(arm, 6)
        agree(run.x("arm.y", 1)[:, 0], y, 1e-8)
        agree(run.x("arm.rigid.dofs", 7)[1:], frames_at(y), 1e-8)
    added = Run(arm.replace("<ArticulationCenter", '<ArticulationCenter articulationProcess="2"'), 6)
    agree(added.x("arm.y", 1)[:, 0], y, 1e-8)
    added.says("articulationProcess: adds up the turns of all steps in SOFA")


@case
def arms_that_hold_what_resists():
    """geometricStiffness Stabilized of RigidMapping: of each frame's sum of [f][r] the symmetric part without what would push on."""
    points, goals = np.array([[0.5, 0.1, 0], [-0.2, 0.4, 0.3], [0.1, -0.3, 0.2]]), np.array([[0.2, 0.9, 0.1], [-0.5, 0.1, 0.8], [0.6, 0.2, -0.4]])
    def cross(a):
        return np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])
    k, h, inertia, mass = 40.0, 0.02, np.array([0.3, 0.5, 0.4]), 2.0
    x, q, v = np.zeros(3), turn_of(np.array([0.2, -0.1, 0.3])), np.array([0.3, 0, -0.2, 0.5, -1, 0.4])
    start = q
    M = np.diag(np.r_[[mass] * 3, inertia])
    for _ in range(12):
        f, K, turning = np.zeros(6), np.zeros((6, 6)), np.zeros((3, 3))
        for p, goal in zip(points, goals):
            r = axes_of(q) @ p
            force = -k * (x + r - goal)
            J = np.hstack([np.eye(3), -cross(r)])
            f += J.T @ force
            K -= k * J.T @ J
            turning += cross(force) @ cross(r)
        values, ways = np.linalg.eigh((turning + turning.T) / 2)
        K[3:, 3:] += ways @ np.diag(np.minimum(values, 0)) @ ways.T
        v = v + np.linalg.solve(M - h * h * K, h * (f + h * K @ v))
        x, q = x + h * v[:3], product(turn_of(h * v[3:]), q)
    held = f'<RestShapeSpringsForceField stiffness="{k}" points="0 1 2"/>'
    for solver in (EXACT, '<EulerImplicitSolver/><CGLinearSolver iterations="200" tolerance="1e-15" threshold="0"/>'):
        scene = (f'<Node name="root" gravity="0 0 0" dt="{h}">{solver}<MechanicalObject name="dofs" template="Rigid3" position="0 0 0 '
                 f'{numbers_of(start)}" velocity="{numbers_of([0.3, 0, -0.2, 0.5, -1, 0.4])}"/><UniformMass vertexMass="2 1 0.15 0 0 0 0.25 0 0 0 '
                 f'0.2"/><Node name="arms"><MechanicalObject name="ends" position="{numbers_of(points)}" rest_position="{numbers_of(goals)}"/>'
                 f'<RigidMapping initialPoints="{numbers_of(points)}" geometricStiffness="Stabilized"/>{held}</Node></Node>')
        run = Run(scene, 12)
        agree(run.x("dofs", 7)[0], np.r_[x, q])


@case
def frames_that_stay_together_by_constraint():
    """One round of three rows for places and three for turns; with keepOrientationDifference the difference of the places stays too, in
    fixed axes, and else a rest_vector of six numbers."""
    h, centres = 0.01, [np.zeros(3), np.array([1, 0.2, -0.3])]
    turns = [turn_of(np.array([0.2, -0.1, 0.3])), turn_of(np.array([-0.3, 0.4, 0.1]))]
    speeds = [np.array([0.1, 0, 0.2, 0.5, -1, 0.4]), np.array([0, 0.5, 0, -0.2, 0.3, 1])]
    masses, inertias = [2.0, 1.0], [np.array([0.3, 0.5, 0.4]), np.array([0.2, 0.1, 0.25])]
    inverse_M = np.diag(1 / np.r_[[masses[0]] * 3, inertias[0], [masses[1]] * 3, inertias[1]])
    J = np.hstack([-np.eye(6), np.eye(6)])
    for words, rest in (('keepOrientationDifference="true"', None), ("", np.zeros(6)),
                        ('rest_vector="0.5 0.1 0 0.1 -0.2 0.3"', np.array([0.5, 0.1, 0, 0.1, -0.2, 0.3]))):
        x, q, u = [c.copy() for c in centres], list(turns), np.r_[speeds[0], speeds[1]]
        for _ in range(15):
            u = u + h * np.tile([0, -10, 0, 0, 0, 0], 2)
            moved = [x[k] + h * u[6 * k:6 * k + 3] for k in (0, 1)]
            turned = [product(turn_of(h * u[6 * k + 3:6 * k + 6]), q[k]) for k in (0, 1)]
            wanted = turned[0] if rest is not None else product(turned[0], product(inverse(turns[0]), turns[1]))
            g = np.r_[moved[1] - moved[0], rotation_vector(product(turned[1], inverse(wanted)))]
            g -= np.r_[centres[1] - centres[0], [0] * 3] if rest is None else rest
            dx = inverse_M @ J.T @ np.linalg.solve(J @ inverse_M @ J.T, -g)
            u = u + dx / h
            x = [moved[k] + dx[6 * k:6 * k + 3] for k in (0, 1)]
            q = [product(turn_of(dx[6 * k + 3:6 * k + 6]), turned[k]) for k in (0, 1)]
        bodies = ""
        for k in (0, 1):
            per_mass = " ".join(numbers_of(row) for row in np.diag(inertias[k] / masses[k]))
            bodies += (f'<Node name="b{k}">{EXACT}<MechanicalObject name="dofs" template="Rigid3" position="{numbers_of(centres[k])} '
                       f'{numbers_of(turns[k])}" velocity="{numbers_of(speeds[k])}"/><UniformMass vertexMass="{masses[k]} 1 {per_mass}"/>'
                       '<LinearSolverConstraintCorrection/></Node>')
        run = Run(root(FREE_LOOP + bodies + '<BilateralLagrangianConstraint template="Rigid3" object1="@b0/dofs" object2="@b1/dofs" '
                       f'first_point="0" second_point="0" {words}/>'), 15)
        for k in (0, 1):
            agree(run.x(f"b{k}.dofs", 7)[0], np.r_[x[k], q[k]], 1e-8)


@case
def frames_that_are_tied_up_to_a_tolerance():
    """SOFA's sweeps over frames begin at zero in each step, and those of turns end at 1e-4."""
    h, rng = 0.01, np.random.default_rng(5)
    centres, turns = 0.3 * rng.normal(size=(4, 3)), [turn_of(0.2 * r) for r in rng.normal(size=(4, 3))]
    speeds, inertia = 0.5 * rng.normal(size=(4, 6)), np.array([0.3, 0.5, 0.4])
    C = np.diag(1 / np.tile(np.r_[[2.0] * 3, inertia], 4))
    J = np.zeros((18, 24))
    for k in range(3):
        J[6 * k:6 * k + 6, 6 * k:6 * k + 12] = np.hstack([-np.eye(6), np.eye(6)])
    blocks = [list(range(i, i + 3)) for i in range(0, 18, 3)]
    per_mass = " ".join(numbers_of(row) for row in np.diag(inertia / 2))
    state = "  ".join(numbers_of(np.r_[c, q]) for c, q in zip(centres, turns))
    scene = root('<FreeMotionAnimationLoop/><GenericConstraintSolver {}/>' + f'<Node name="b">{EXACT}<MechanicalObject name="dofs" '
                 f'template="Rigid3" position="{state}" velocity="{numbers_of(speeds)}"/><UniformMass vertexMass="2 1 {per_mass}"/>'
                 '<LinearSolverConstraintCorrection/><BilateralLagrangianConstraint template="Rigid3" object1="@dofs" object2="@dofs" '
                 'first_point="0 1 2" second_point="1 2 3"/></Node>')
    for words, tolerance in (("", 1e-3), ('tolerance="1e-6"', 1e-6)):
        x, q, u = centres.copy(), list(turns), speeds.ravel().copy()
        for _ in range(12):
            u = u + h * np.tile([0, -10, 0, 0, 0, 0], 4)
            x = x + h * u.reshape(4, 6)[:, :3]
            q = [product(turn_of(h * u[6 * k + 3:6 * k + 6]), q[k]) for k in range(4)]
            g = np.concatenate([np.r_[x[k + 1] - x[k], rotation_vector(product(q[k + 1], inverse(q[k])))] for k in range(3)])
            l = np.zeros(18)
            swept(h * J @ C @ J.T, g, blocks, l, tolerance=tolerance, turns=(1, 3, 5))
            dx = h * C @ J.T @ l
            u = u + dx / h
            x = x + dx.reshape(4, 6)[:, :3]
            q = [product(turn_of(dx[6 * k + 3:6 * k + 6]), q[k]) for k in range(4)]
        run = Run(scene.format(words), 12)
        expected = np.array([np.r_[x[k], q[k]] for k in range(4)])
        agree(run.x("b.dofs", 7), expected, 1e-8)


def rods_that_are_out(rods, tips, threshold):
    """Lengths from the opening where nodes are, and where points of the contact model are, as SOFA's plug-in BeamAdapter puts them."""
    begins = [tip - sum(length for length, _ in rod) for rod, tip in zip(rods, tips)]
    ends = [begin + np.cumsum([length for length, _ in rod]) for rod, begin in zip(rods, begins)]
    nodes, divided = [0.0] + [end for each in ends for end in each if end > 0], 0.0
    for rod, each in zip(rods, ends):
        for (length, edges), end in zip(rod, each):
            if end > divided:
                nodes += [end - (k + 1) * length / edges for k in range(int(np.floor((end - divided) * edges / length + 1e-9)))]
                divided = end
    kept = []
    for node in sorted(nodes):
        if not kept or node - kept[-1] >= threshold:
            kept.append(node)
    outermost = [next(i for i, tip in enumerate(tips) if node <= tip + threshold) for node in kept]
    points, n, at = [], len(kept) - 1, kept[-1]
    on = outermost[n]
    while at > 0:
        points.append(at)
        length, edges = next(part for part, end in zip(rods[on], ends[on]) if at <= end + 1e-9)
        at -= length / edges
        while n > 0 and at < kept[n - 1]:
            n -= 1
            if outermost[n] != on:
                on, at = outermost[n], kept[n]
                break
    return np.array(kept), points[::-1]


@case
def points_on_rods_that_are_pushed():
    """MultiAdaptiveBeamMapping: on the cubic curves between the frames; what is not out waits at the opening."""
    sections = [[(0.2, 8)], [(0.25, 5), (0.05, 4)]]
    shapes = ('<Node name="t0"><RodStraightSection name="s" length="0.2" radius="0.002" youngModulus="1e8" nbEdgesCollis="8" '
              'massDensity="1000"/><WireRestShape name="shape" wireMaterials="@s"/><EdgeSetTopologyContainer name="mesh"/></Node>'
              '<Node name="t1"><RodStraightSection name="s" length="0.25" radius="0.001" youngModulus="1e8" nbEdgesCollis="5" '
              'massDensity="1000"/><RodSpireSection name="h" length="0.05" radius="0.001" youngModulus="1e8" nbEdgesCollis="4" '
              'spireDiameter="0.05" spireHeight="0" massDensity="1000"/><WireRestShape name="shape" wireMaterials="@s @h"/>'
              '<EdgeSetTopologyContainer name="mesh"/></Node>')
    wires = "".join(f'<WireBeamInterpolation name="w{i}" WireRestShape="@../t{i}/shape"/><AdaptiveBeamForceFieldAndMass '
                    f'interpolation="@w{i}"/>' for i in range(2))
    for steps, way in ((1, 0.0), (12, 0.3), (12, -0.2)):
        run = Run(root(shapes + '<Node name="rods"><EulerImplicitSolver rayleighStiffness="0.2" rayleighMass="0.1"/><BTDLinearSolver/>'
                       '<RegularGridTopology nx="40" ny="1" nz="1" xmin="0" xmax="1" ymin="0" ymax="0" zmin="1" zmax="1"/>'
                       f'<MechanicalObject name="frames" template="Rigid3d"/>{wires}<InterventionalRadiologyController name="irc" '
                       f'instruments="w0 w1" xtip="0.07 0.093" speed="{way}" controlledInstrument="1" threshold="0.001"/>'
                       '<FixedProjectiveConstraint indices="0"/><RestShapeSpringsForceField points="@irc.indexFirstNode" stiffness="1e8" '
                       'angularStiffness="1e8"/><Node name="collis"><EdgeSetTopologyContainer name="edges"/><EdgeSetTopologyModifier/>'
                       '<MechanicalObject name="points"/><MultiAdaptiveBeamMapping ircontroller="../irc" useCurvAbs="1"/></Node></Node>',
                       'gravity="0 0 0"'), steps)
        assert run.code == 0, run.text
        frames, points = run.x("rods.frames", 7), run.x("rods.collis.points")
        tip = 0.093 + abs(way) * 0.01 * steps if way > 0 else 0.093
        nodes, places = rods_that_are_out(sections, (0.07, tip), 0.001)
        expected = np.zeros((10, 3))
        for i, at in enumerate(places):
            n = min(np.searchsorted(nodes, at, "left"), len(nodes) - 1)
            length = nodes[n] - nodes[n - 1]
            a, b = frames[len(frames) - len(nodes) + n - 1], frames[len(frames) - len(nodes) + n]
            ends = [a[:3], a[:3] + length / 3 * axes_of(a[3:])[:, 0], b[:3] - length / 3 * axes_of(b[3:])[:, 0], b[:3]]
            s = (at - nodes[n - 1]) / length
            expected[10 - len(places) + i] = sum(c * p for c, p in zip(((1 - s)**3, 3 * s * (1 - s)**2, 3 * s * s * (1 - s), s**3), ends))
        agree(points, expected, 1e-8)


@case
def beams_of_rods_by_their_number():
    """nbBeams of a section has the beams, nbEdgesCollis the points of the contact model: frames are those of as many edges."""
    def run(section):
        return Run(root(f'<Node name="t"><RodStraightSection name="s" length="0.2" radius="0.002" youngModulus="1e8" {section} '
                        'massDensity="1000"/><WireRestShape name="shape" wireMaterials="@s"/><EdgeSetTopologyContainer name="mesh"/></Node>'
                        '<Node name="rods"><EulerImplicitSolver rayleighStiffness="0.2" rayleighMass="0.1"/><BTDLinearSolver/>'
                        '<RegularGridTopology nx="20" ny="1" nz="1" xmin="0" xmax="1" ymin="0" ymax="0" zmin="1" zmax="1"/>'
                        '<MechanicalObject name="frames" template="Rigid3d"/><WireBeamInterpolation name="w" WireRestShape="@../t/shape"/>'
                        '<AdaptiveBeamForceFieldAndMass interpolation="@w"/><InterventionalRadiologyController name="irc" '
                        'instruments="w" xtip="0.15" controlledInstrument="0" threshold="0.001"/><FixedProjectiveConstraint indices="0"/>'
                        '<RestShapeSpringsForceField points="@irc.indexFirstNode" stiffness="1e8" angularStiffness="1e8"/>'
                        '<Node name="collis"><EdgeSetTopologyContainer name="edges"/><EdgeSetTopologyModifier/><MechanicalObject name="p"/>'
                        '<MultiAdaptiveBeamMapping ircontroller="../irc" useCurvAbs="1"/></Node></Node>', 'gravity="0 0 0"'), 3)
    given, edges = run('nbBeams="8" nbEdgesCollis="16"'), run('nbEdgesCollis="8"')
    agree(given.x("rods.frames", 7), edges.x("rods.frames", 7), 1e-14)
    assert len(given.x("rods.collis.p")) == 17 and len(edges.x("rods.collis.p")) == 9


@case
def what_frames_carry_where_they_turn():
    """Points and frames in the axes of a frame that turns by 90 degrees about z where the scene starts, x = c + q p: places that are
    listed, of a child that has none or others; rest positions with useX0; places in space, which a frame turned back has."""
    s = 0.7071067811865476
    frames = f'<MechanicalObject name="dofs" template="Rigid3" position="0 0 0 0 0 0 1  1 2 0 0 0 {s} {s}"/><UniformMass totalMass="1"/>'
    child = '<Node name="c"><MechanicalObject name="p" {}/><{} {}/></Node>'

    def carried(state, kind, attributes, width=3):
        run = Run(node(EXACT + frames + child.format(state, kind, attributes)), 1)
        return run, run.x("c.p", width)

    listed = 'index="1" initialPoints="0.5 0 0  0 0 3"'
    for state in ("", 'position="7 7 7"'):
        agree(carried(state, "RigidMapping", listed)[1], [[1, 2.5, 0], [1, 2, 3]])
    run, x = carried("", "RigidMapping", listed + ' globalToLocalCoords="1"')
    agree(x, [[1, 2.5, 0], [1, 2, 3]])
    run.says("/c/RigidMapping1.globalToLocalCoords: has no effect beside initialPoints")
    places = 'position="0.5 0 0  0 4 0" rest_position="2 0 0  0 3 0"'
    agree(carried(places, "RigidMapping", 'indexFromEnd="1"')[1], [[1, 2.5, 0], [-3, 2, 0]])
    agree(carried(places, "RigidMapping", 'index="1" useX0="1"')[1], [[1, 4, 0], [-2, 2, 0]])
    run, x = carried(places, "RigidMapping", 'index="1" useX0="1" globalToLocalCoords="1"')
    agree(x, [[1, 4, 0], [-2, 2, 0]])
    run.says("/c/RigidMapping1.globalToLocalCoords: has no effect beside useX0")
    agree(carried(places, "RigidMapping", 'index="1" globalToLocalCoords="1"')[1], [[0.5, 0, 0], [0, 4, 0]])
    rigid, turned = 'template="Rigid3"', f"0.5 0 0 {s} 0 0 {s}"
    agree(carried(rigid, "RigidRigidMapping", f'index="1" initialPoints="{turned}"', 7)[1], [[1, 2.5, 0, 0.5, 0.5, 0.5, 0.5]])
    agree(carried(rigid, "RigidRigidMapping", f'repartition="1 1" initialPoints="{turned}  0 0 1 0 0 0 1"', 7)[1],
          [[0.5, 0, 0, s, 0, 0, s], [1, 2, 1, 0, 0, s, s]])
    agree(carried(rigid + f' position="{turned}"', "RigidRigidMapping", 'index="1" globalToLocalCoords="1"', 7)[1], [[0.5, 0, 0, s, 0, 0, s]])
    run, x = carried(places, "RigidMapping", 'index="1" rigidIndexPerPoint="0 0 0"')
    agree(x, [[1, 2.5, 0], [-3, 2, 0]])
    run.says("rigidIndexPerPoint has 3 values for 2 points: it is ignored, as in SOFA, and frame 1 carries all points")
    wrong = node(EXACT + frames + child.format(rigid, "RigidRigidMapping", 'initialPoints="0.5 0 0 0 0 0 0"'))
    Run(wrong, 1).fails(2, "initialPoints: the quaternion of frame 0 has the length 0", "x y z w of length one")


@case
def a_frame_of_which_only_the_move_is_written():
    """A state without positions is one node at the origin in SOFA, as scenes of rigid bodies have it: it says nothing, and neither is said
    here. A node that nothing moves may be a mistake, and is told."""
    body = '<MechanicalObject name="dofs" {} /><UniformMass totalMass="1"/>'
    for text, width in (('template="Rigid3d" dx="1" dy="2" dz="3" rz="90"', 7), ('template="Rigid3"', 7), ('translation="1 2 3"', 3)):
        run = Run(root(EXACT + body.format(text)), 10)
        assert "no positions" not in run.text, run.text
        start = [0, 0, 0] if text == 'template="Rigid3"' else [1, 2, 3]
        agree(run.x(width=width)[0, :3], np.add(start, [0, fallen(10), 0]))
        if "rz" in text:
            agree(np.abs(run.x(width=7)[0, 3:]), [0, 0, np.sqrt(0.5), np.sqrt(0.5)])
    Run(root(EXACT + body.format("")), 1).says("no positions: neither position")


main()
