# SPDX-License-Identifier: LGPL-2.1-or-later
"""Loads in SOFA's dialect: pressures, planes, ellipsoids, forces over time.
Usage: test_dialect_loads.py STROMA [WORD]."""
import itertools
import math

import numpy as np

from dialect import BODY, EXACT, TWO, Run, agree, case, differ, fallen, falls, main, node, numbers_of, root
from reference import euler, gravity, load, springs, together


@case
def a_pressure_on_a_surface_with_a_free_rim():
    """SOFA's conjugate gradients have its tangent as it is, which is not symmetric there."""
    X = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], float)
    scene = root('<EulerImplicitSolver/><CGLinearSolver iterations="25" tolerance="1e-9" threshold="1e-30"/><MeshTopology '
                 'position="0 0 0  1 0 0  0 1 0" triangles="0 1 2"/><MechanicalObject name="dofs"/><UniformMass totalMass="3"/>'
                 '<RestShapeSpringsForceField stiffness="50"/><SurfacePressureForceField pressure="60" {}/>')

    def cross_matrix(w):
        return np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])

    def pressed(x, v):
        e = [x[2] - x[1], x[0] - x[2], x[1] - x[0]]  # d (b - a) x (c - a) = sum of e_i x dx_i
        K = np.tile(np.hstack([10 * cross_matrix(each) for each in e]), (3, 1))
        return np.tile(10 * np.cross(x[1] - x[0], x[2] - x[0]), (3, 1)) - 50 * (x - X), K - 50 * np.eye(9)
    expected = euler(X, np.eye(3), together(gravity(np.ones(3), [0, -10, 0]), pressed), 20, 0.01, cg=(25, 1e-9, 1e-30))
    agree(Run(scene.format(""), 20).x(), expected, 1e-9)
    differ(Run(scene.format('tangent="symmetric"'), 20).x(), expected, 1e-6)
    whole = euler(X, np.eye(3), together(gravity(np.ones(3), [0, -10, 0]), pressed), 20, 0.01)  # and so have factors of any matrix
    for solver in ("SparseLUSolver", "EigenSparseLU", "EigenSparseQR", 'SVDLinearSolver template="FullMatrix"'):
        direct = scene.replace('CGLinearSolver iterations="25" tolerance="1e-9" threshold="1e-30"', solver)
        agree(Run(direct.format(""), 20).x(), whole, 1e-9)


@case
def forces_from_outside_that_are_zero():
    """As scenes that SOFA saved have them."""
    falls(Run(root(EXACT + BODY.replace('name="dofs"', 'name="dofs" externalForce="0 0 0 0.0 0 0"')), 10))
    Run(root("<RungeKutta2Solver/>" + BODY.replace('name="dofs"', 'name="dofs" externalForce="0 0 0 0 1 0"')), 1).fails(2, "externalForce")


@case
def ranges_have_their_last_node():
    plane = '<PlaneForceField normal="0 1 0" d="1" stiffness="100" localRange="{}"/>'

    def pushed(steps):  # mass 1, depth 1 - y
        y = v = 0.0
        for _ in range(steps):
            v += 0.01 * (-10 + 100 * (1 - y) - 0.01 * 100 * v) / (1 + 0.01**2 * 100)
            y += 0.01 * v
        return y
    for listed, count in (("0 0", 1), ("0 1", 2), ("-1 -1", 2), ("1 1", 1), ("1 -1", 1), ("-1 0", 1)):
        run = Run(root(EXACT + BODY + plane.format(listed).replace("/>", ' damping="0"/>')), 5)
        y = run.x()[:, 1] if not listed.startswith("1") else run.x()[::-1, 1]
        agree(y, [pushed(5)] * count + [fallen(5)] * (2 - count))


@case
def loads_that_choose_nothing():
    sheet = ('<MeshTopology name="m" position="0 0 0  1 0 0  0 1 0" triangles="0 1 2" quads="" /><MechanicalObject name="dofs"/><UniformMass '
             'totalMass="3"/><BoxROI name="none" box="8 8 8 9 9 9"/>')
    for load in ('<TrianglePressureForceField triangleList="@none.triangleIndices" pressure="0 9 0"/>',
                 '<TrianglePressureForceField pressure="0 9 0"/>', '<QuadPressureForceField quadList="@none.quadIndices" pressure="0 9 0"/>',
                 '<EdgePressureForceField edgeIndices="@none.edgeIndices" pressure="0 9 0"/>'):
        run = Run(root(EXACT + sheet + load), 5)
        run.says("there is no load")
        agree(run.x()[:, 1], np.add([0, 0, 1], fallen(5)))


@case
def planes_whose_direction_is_taken_as_it_is():
    """Nodes lie between the planes where d.x does, whatever the length of d."""
    nodes = '<MechanicalObject name="dofs" position="0 0 0  0 0.4 0  0 0.6 0"/><UniformMass totalMass="3"/>'
    for length, held in ((1, [0, 1, 2]), (2, [0, 1])):
        run = Run(root(EXACT + nodes + f'<FixedPlaneProjectiveConstraint direction="0 {length} 0" dmin="-1" dmax="1"/>'), 5)
        agree(run.x()[:, 1], [y if i in held else y + fallen(5) for i, y in enumerate((0, 0.4, 0.6))])
        assert ("direction: has the length 2: SOFA takes it as it is" in run.text) == (length == 2), run.text
    oblique = nodes + '<FixedPlaneProjectiveConstraint indices="0" direction="0 0.6 0.8"/>'
    assert "is along no axis: in SOFA's assembled matrix" in Run(root(EXACT + oblique), 1).text
    assert "is along no axis" not in Run(root('<EulerImplicitSolver/><CGLinearSolver/>' + oblique), 1).text


@case
def planes_beside_nodes_and_without_any():
    nodes = '<MechanicalObject name="dofs" position="0 0 0  0 0.4 0  0 0.6 0"/><UniformMass totalMass="3"/>'
    plane = '<FixedPlaneProjectiveConstraint direction="0 1 0" {}/>'
    for more, held in (('indices="2" dmin="-0.1" dmax="0.1"', [0, 2]), ('indices="1"', [1]), ('indices="1" dmin="0" dmax="0.0"', [1]), ("", []),
                       ('dmin="5" dmax="6"', []), ('dmin="0.5" dmax="-0.5"', []), ('dmin="-0.5"', [])):
        run = Run(root(EXACT + nodes + plane.format(more)), 5)
        agree(run.x()[:, 1], [y if i in held else y + fallen(5) for i, y in enumerate((0, 0.4, 0.6))])
        assert ("no node is held" in run.text) == (not held), run.text


@case
def stresses_on_triangles():
    """f_a = sigma (x1 - x0) x (x2 - x0) / 6 at each corner, and nothing in the tangent; one of pressure and stress counts."""
    x = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0.3]])
    sigma = np.array([[30, 5, 2], [5, -20, 4], [2, 4, 50.0]])

    def stress(x, v):
        f = np.zeros_like(x)
        for a, b, c in ((0, 1, 2), (1, 3, 2)):
            f[[a, b, c]] += sigma @ np.cross(x[b] - x[a], x[c] - x[a]) / 6
        return f, np.zeros((12, 12))
    pairs = list(itertools.combinations(range(4), 2))
    lengths = [np.linalg.norm(x[a] - x[b]) for a, b in pairs]
    body = (f'<MeshTopology position="{numbers_of(x)}" triangles="0 1 2  1 3 2"/><MechanicalObject name="dofs"/><UniformMass totalMass="2"/>'
            '<FixedConstraint indices="0"/><SpringForceField spring="' +
            "  ".join(f"{a} {b} {300 / length!r} 0 {length!r}" for (a, b), length in zip(pairs, lengths)) + '"/>')
    load_of = ' triangleList="0 1" useConstantForce="{}" cauchyStress="30 5 -20 2 4 50"'
    forces = together(gravity(0.5 * np.ones(4), [0, -10, 0]), springs(pairs, x, 300.0), stress)
    expected = euler(x, 0.5 * np.eye(4), forces, 20, 0.01, held=[0])
    scene = root(EXACT + body + f'<TrianglePressureForceField pressure="9 9 9"{load_of.format(0)}/>')
    run = Run(scene, 20)
    run.says("pressure: does not count without useConstantForce")
    agree(run.x() - x, expected - x, 1e-9)
    differ(Run(scene, 20, args=["--without-quirk", "torsion-tangent"]).x(), expected, 1e-5)
    run = Run(root(EXACT + body + f'<TrianglePressureForceField pressure="0 0 0"{load_of.format(1)}/>'), 20)
    run.says("cauchyStress: does not count with useConstantForce")
    still = euler(x, 0.5 * np.eye(4), together(gravity(0.5 * np.ones(4), [0, -10, 0]), springs(pairs, x, 300.0)), 20, 0.01, held=[0])
    agree(run.x() - x, still - x, 1e-9)
    run = Run(root(EXACT + body + '<TrianglePressureForceField triangleList="0 1" useConstantForce="0" pressure="0 9 0"/>'), 20)
    run.says("has no cauchyStress")
    agree(run.x() - x, still - x, 1e-9)


@case
def loads_on_edges_and_quads():
    body = ('<MeshTopology position="0 0 0  3 0 0  3 4 0  0 4 0" edges="0 1  1 2" quads="0 1 2 3"/><MechanicalObject name="dofs"/>'
            '<UniformMass totalMass="4"/>')
    held = euler([[0, 0, 0]], [[1]], load({0: np.array([0, 0, 1.0])}), 5, 0.01)[0, 2]
    quad = Run(node(EXACT + body + '<QuadPressureForceField quadList="0" pressure="0 0 2"/>'), 5).x()
    agree(quad[:, 2], np.full(4, 12 / 4 * 2 * held))
    edge = Run(node(EXACT + body + '<EdgePressureForceField edgeIndices="1" pressure="0 0 2"/>'), 5).x()
    agree(edge[:, 2], [0, 4 * held, 4 * held, 0])
    edge = Run(node(EXACT + body + '<EdgePressureForceField edges="0 1" p_intensity="5" binormal="0 0 1"/>'), 1).x()
    agree(edge[:, 1] - [0, 0, 4, 4], [5 * 3 / 2 * 1e-4, 5 * 3 / 2 * 1e-4, 0, 0])


@case
def quirk_ellipsoid_ratio():
    """SOFA's stiffness multiplies sqrt(q) - 1, a number, along the unit normal, with the tangent that it has of it."""
    r, k, c, h = np.array([2.0, 1, 0.5]), 30.0, 4.0, 0.01

    def push(x, v):
        a = x / r**2
        depth = np.sqrt(x @ a) - 1
        if depth >= 0:
            return np.zeros(3), np.zeros((3, 3))
        n, size = a / np.linalg.norm(a), np.linalg.norm(a)
        pair = np.outer(a, a / r**2) / size**2
        tangent = k * (-np.outer(a, a) / (np.sqrt(x @ a) * size) + depth * (pair + pair.T) / 2 - depth * np.diag(1 / r**2) / size)
        return -k * depth * n - c * abs(depth) * v, tangent

    body = '<MechanicalObject name="dofs" position="0.9 0.4 0.1" velocity="-0.5 0 0"/><UniformMass totalMass="2"/>'
    field = '<EllipsoidForceField center="0 0 0" vradius="2 1 0.5" stiffness="30" damping="4"/>'
    x, v = np.array([0.9, 0.4, 0.1]), np.array([-0.5, 0, 0])
    y, w = x.copy(), v.copy()
    for _ in range(12):
        v = v + h * push(x, v)[0] / 2
        x = x + h * v
        force, tangent = push(y, w)
        w = w + np.linalg.solve(2 * np.eye(3) - h * h * tangent, h * (force + h * tangent @ w))
        y = y + h * w
    agree(Run(node('<EulerExplicitSolver/>' + body + field), 12).x(), [x])
    scene = node(EXACT + body + field)
    agree(Run(scene, 12).x(), [y])
    differ(Run(scene, 12, args=["--without-quirk", "ellipsoid-ratio"]).x(), [y], 1e-3)


@case
def ellipsoids_of_a_frame_push_as_sofa_has_them():
    """The frame feels the force at its centre; what no solver has in common is pushed by the force of the start."""
    r, k, h = np.array([2.0, 1, 1]), 30.0, 0.01
    frame = ('<Node name="f">' + EXACT + '<MechanicalObject name="dofs" template="Rigid3" position="0 0 0 0 0 0 1"/><UniformMass '
             'totalMass="3"/></Node>')
    point = TWO.format("p", EXACT, "0.9 0.4 0.1", "0 0 0", 2)
    field = ('<InteractionEllipsoidForceField object1="@p/dofs" object2="@f/dofs" center="0 0 0" vradius="2 1 1" stiffness="30" '
             'damping="0" object2_forces="{}"/>')
    for answers in (1, 0):
        x, v = np.array([[0.9, 0.4, 0.1], [0, 0, 0]]), np.zeros((2, 3))
        for _ in range(10):
            a = (x[0] - x[1]) / r**2
            force = -k * (np.sqrt((x[0] - x[1]) @ a) - 1) * a / np.linalg.norm(a)
            v = v + h * np.array([force / 2, -force * answers / 3])
            x = x + h * v
        run = Run(node(point + frame + field.format(answers)), 10)
        agree(run.x("p.dofs"), [x[0]])
        agree(run.x("f.dofs", 7), [[*x[1], 0, 0, 0, 1]])


def plane(normal, d, k, c=5.0, most=0.0, both=False):
    """SOFA's obstacle: a normal as long as it is, a limit of force and damping that the tangent does not know, and damping that
    drives in front of it."""
    n = np.array(normal, float)

    def field(x, v):
        f, K = np.zeros_like(x), np.zeros((x.size, x.size))
        for i, depth in enumerate(d - x @ n):
            if not both and depth <= 0:
                continue
            f[i] = k * depth * n - c * depth * v[i]
            size = np.linalg.norm(f[i])
            if 0 < most < size:
                f[i] *= most / size
            K[3 * i:3 * i + 3, 3 * i:3 * i + 3] = -k * np.outer(n, n)
        return f, K
    return field


@case
def planes_with_long_normals_limits_and_two_sides():
    x = np.array([[0, -1, 0], [0, 1, 0.0]])
    for attributes, field in (('normal="0 1 0" d="0" stiffness="100"', plane([0, 1, 0], 0, 100)),
                              ('normal="0 2 0" d="0.5" stiffness="100"', plane([0, 2, 0], 0.5, 100)),
                              ('normal="0 1 1" damping="8"', plane([0, 1, 1], 0, 500, 8)),
                              ('normal="0 1 0" stiffness="100" maxForce="10"', plane([0, 1, 0], 0, 100, most=10)),
                              ('normal="0 1 0" stiffness="100" bilateral="1"', plane([0, 1, 0], 0, 100, both=True))):
        scene = node(EXACT + '<MechanicalObject name="dofs" position="0 -1 0 0 1 0"/><UniformMass totalMass="2"/>'
                     f'<PlaneForceField {attributes}/>')
        run = Run(scene, 20)
        agree(run.x(), euler(x, np.eye(2), field, 20, 0.01), 1e-10)
        if "0 2 0" in attributes:
            run.says("multiplies depths by 2 and forces by 4")
        else:
            assert "0 1 1" in attributes or "unit length" not in run.text, run.text
    linked = scene.replace("<PlaneForceField", '<PlaneForceField name="far" normal="0 1 0" d="-99" stiffness="100"/><PlaneForceField')
    linked = linked.replace('normal="0 1 0" stiffness="100" bilateral="1"', 'normal="0 2 0" stiffness="@far.stiffness"')
    Run(linked, 2).says("SOFA's is 4 times it")
    run = Run(scene.replace('"0 1 0"', '"0.70710678 0.70710678 0"'), 2)  # unit but for its last digit
    assert run.code == 0 and "unit length" not in run.text, run.text


@case
def of_several_loads_the_first_counts():
    body = '<MechanicalObject name="dofs" position="1 0 0  0 0 0"/><UniformMass totalMass="2"/>'
    load = '<ConstantForceField indices="0 1" totalForce="0 9 0" force="0 0 9" forces="1 0 0  0 1 0"/>'
    run = Run(node(EXACT + body + load), 1)
    agree(run.x(), [[1.0001, 0, 0], [0, 0.0001, 0]])
    run.says("forces is given too and counts")
    agree(Run(node(EXACT + body + load.replace('forces="1 0 0  0 1 0"', "")), 1).x(), [[1, 0, 0.0009], [0, 0, 0.0009]])


@case
def factors_of_a_load():
    scene = node(EXACT + BODY + '<LinearForceField indices="0 1" times="0 10" forces="0 1 0  0 1 0" force="{}"/>')
    agree(Run(scene.format(4), 10).x()[:, 1], [fallen(10, g=-4.0)] * 2)
    # from the last time on SOFA's force is that of the table
    v = y = 0
    for step in range(10):
        v += 0.01 * (4 if step < 5 else 1)
        y += 0.01 * v
    agree(Run(scene.format(4).replace("0 10", "0 0.05"), 10).x()[:, 1], [y] * 2)


@case
def a_force_of_the_first_step():
    """externalForce is forgotten after it, under implicit and explicit steps."""
    for solver in (EXACT, "<EulerExplicitSolver/>", "<CentralDifferenceSolver/>"):
        x = Run(node(solver + '<MechanicalObject name="dofs" position="0 0 0  1 0 0" externalForce="0 3 0  0 0 6"/><UniformMass totalMass="4"/>'),
                10).x()
        agree(x, [[0, 3 / 2 * 1e-4 * 10, 0], [1, 0, 6 / 2 * 1e-4 * 10]])
    frame = Run(node(EXACT + '<MechanicalObject name="dofs" template="Rigid3" position="0 0 0 0 0 0 1" externalForce="0 3 0 0 0 0.4"/>'
                     '<UniformMass vertexMass="2 1 1 0 0 0 1 0 0 0 1"/>'), 10).x(width=7)
    half = 0.4 / 2 * 1e-4 * 10 / 2
    agree(frame, [[0, 3 / 2 * 1e-4 * 10, 0, 0, 0, math.sin(half), math.cos(half)]])
    Run(node('<RungeKutta4Solver/><MechanicalObject position="0 0 0" externalForce="0 3 0"/><UniformMass totalMass="4"/>'), 1).fails(
        2, "externalForce")


@case
def loads_on_bent_faces():
    """Areas of halves, lengths, and the shares of nodes that several faces have; explicit, so that forces are seen."""
    x = np.array([[0, 0, 0], [2, 0.1, 0], [2.2, 1.5, 0.7], [0.1, 1, 0], [4, 0, 1], [4, 2, 0.5]])
    p = np.array([1, -2, 3.0])

    def check(cells, words, parts):
        """parts: nodes that share a force."""
        f = np.zeros_like(x)
        for nodes, force in parts:
            f[list(nodes)] += np.asarray(force) / len(nodes)
        scene = node(f'<EulerExplicitSolver/><MeshTopology position="{numbers_of(x)}" {cells}/><MechanicalObject name="dofs"/><UniformMass '
                     f'vertexMass="1"/><{words}/>')
        agree((Run(scene, 1).x() - x) / 1e-4, f, 1e-8)

    def normal(a, b, c):
        return np.cross(x[b] - x[a], x[c] - x[a]) / 2

    def size(*nodes):
        return np.linalg.norm(normal(*nodes))
    quads, triangles = [(0, 1, 2, 3), (1, 4, 5, 2)], [(0, 1, 2), (0, 2, 3)]
    check('quads="0 1 2 3 1 4 5 2"', f'QuadPressureForceField quadList="0 1" pressure="{numbers_of(p)}"',
          [((a, b, c, d), (size(a, b, c) + size(a, c, d)) * p) for a, b, c, d in quads])
    check('edges="0 1 1 2 2 5"', f'EdgePressureForceField edgeIndices="0 2" pressure="{numbers_of(p)}"',
          [((a, b), np.linalg.norm(x[b] - x[a]) * p) for a, b in ((0, 1), (2, 5))])
    three = 'triangles="0 1 2 0 2 3 1 4 5"'
    check(three, f'TrianglePressureForceField triangleList="0 1" pressure="{numbers_of(p)}"', [(t, size(*t) * p) for t in triangles])
    check(three, 'SurfacePressureForceField triangleIndices="0 1" pressure="4"', [(t, normal(*t) * 4) for t in triangles])


@case
def pressures_on_tetrahedra():
    """SOFA also loads the faces between tetrahedra unless the mesh lists its triangles; here only the border, and the difference is told."""
    x = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1.0]])
    cells, border = [(0, 1, 2, 3), (1, 4, 2, 3)], [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 4), (1, 4, 3), (2, 3, 4)]
    f = np.zeros_like(x)
    for a, b, c in border:
        f[[a, b, c]] += 4 * np.cross(x[b] - x[a], x[c] - x[a]) / 6
    for kind, listed in itertools.product(("MeshTopology", "TetrahedronSetTopologyContainer"), (False, True)):
        triangles = f'triangles="{numbers_of(np.array(border))}"' if listed else ""
        run = Run(node(f'<EulerExplicitSolver/><{kind} position="{numbers_of(x)}" tetrahedra="{numbers_of(np.array(cells))}" {triangles}/>'
                       '<MechanicalObject name="dofs"/><UniformMass vertexMass="1"/><SurfacePressureForceField pressure="4"/>'), 1)
        agree((run.x() - x) / 1e-4, f, 1e-8)
        assert ("SOFA loads the faces between them too" in run.text) != listed, run.text


@case
def nodes_outside_of_a_cone():
    """Beside it, behind its tip and beyond its cap, inside it and outside, where SOFA's damping drives; the tangent is along the force."""
    x = np.array([[0.6, 0.5, 0.1], [0.1, 1.6, 0.2], [1.5, 1.5, 0], [0.2, -0.3, 0.1], [0.1, 0.8, 0], [0, 0.5, -0.9]])
    v = np.array([[1, 0, 2], [0, 2, 1], [1, -1, 0], [0, -2, 1], [3, 0, 0], [0, 1, -1.0]])
    tip, height, angle, k, c = np.array([0.05, 0, 0.02]), np.array([0.1, 1.4, 0.2]), np.radians(25), 300, 6

    def field(x, v):
        f, K = np.zeros_like(x), np.zeros((x.size, x.size))
        n, size = height / np.linalg.norm(height), np.linalg.norm(height)
        for i, y in enumerate(x - tip):
            far = np.linalg.norm(y)
            if far > size:
                way, g = -y / far, far - size
                f[i] += k * g * way + c * g * v[i]
            elif np.arccos(y @ n / far) > angle:
                if y @ n > 0:
                    across = y - y @ n * n
                    side = np.cos(angle) * n + np.sin(angle) * across / np.linalg.norm(across)
                    back = side @ y * side - y
                else:
                    back = -y
                g = np.linalg.norm(back)
                way = back / g
                f[i] += k * g * way - c * way * (way @ v[i])
            else:
                continue
            K[3 * i:3 * i + 3, 3 * i:3 * i + 3] -= k * np.outer(way, way)
        return f, K
    scene = node(EXACT + f'<MechanicalObject name="dofs" position="{numbers_of(x)}" velocity="{numbers_of(v)}"/><UniformMass totalMass="3"/>'
                 f'<ConicalForceField coneCenter="{numbers_of(tip)}" coneHeight="{numbers_of(height)}" coneAngle="25" stiffness="300" damping="6"/>')
    agree(Run(scene, 12).x(), euler(x, 0.5 * np.eye(6), field, 12, 0.01, v=v))


@case
def forces_of_other_numbers_than_nodes():
    """One is that of each node; any other number is an error in later versions of SOFA, without a load. (Older ones read beyond the list.)"""
    X = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0]])
    body = f'<MechanicalObject name="dofs" position="{numbers_of(X)}"/><UniformMass totalMass="3"/><ConstantForceField {{}}/>'
    none = "the load is left out, as in SOFA"
    for words, forces, said in (('indices="0 1 2" forces="1 0 0  0 1 0"', np.zeros((3, 3)), none),
                                ('forces="1 0 0  0 1 0"', np.zeros((3, 3)), "forces has 2 values for 3 nodes"),
                                ('indices="2 1" forces="1 0 0  0 1 0  0 0 5"', np.zeros((3, 3)), none),
                                ('indices="2 1" forces="1 0 0  0 1 0"', [[0, 0, 0], [0, 1, 0], [1, 0, 0]], ""),
                                ('indices="0 2 1" forces="0 0 5"', [[0, 0, 5]] * 3, ""), ('forces="0 0 5"', [[0, 0, 5]] * 3, "")):
        run = Run(node(EXACT + body.format(words)), 1)
        agree((run.x() - X) / 1e-4 + 1, np.asarray(forces) + 1, 1e-8)
        run.says(said)
        assert said or "forces has" not in run.text, run.text


def pulse(pressure, low, change, steps):
    """SOFA's: once more in each step, cut off at its ends."""
    value, rises, values = 0.0, True, []
    ends = (low, pressure) if pressure > 0 else (pressure, low)
    for _ in range(steps):
        value += change if rises else -change
        if (rises and value >= ends[1]) or (not rises and value <= ends[0]):
            value, rises = ends[1] if rises else ends[0], not rises
        values.append(value)
    return values


@case
def pressures_that_beat():
    """On a triangle of area 1/2 with 1 kg at each corner; steps that fit between the ends and others; without
    a speed `pressure` in a second."""
    body = ('<MeshTopology position="0 0 0  1 0 0  0 1 0" triangles="0 1 2"/><MechanicalObject name="dofs"/><UniformMass vertexMass="1"/>'
            '<SurfacePressureForceField pressure="{}" pulseMode="1" pressureLowerBound="{}" {} useTangentStiffness="0"/>')
    for solver, (pressure, low, speed) in itertools.product(("<EulerExplicitSolver/>", EXACT), ((6, 1, 100), (6, 1, 170), (6, 0, 250), (-4, 0, 150))):
        v = z = 0.0
        for value in pulse(pressure, low, 0.01 * speed, 30):
            v += 0.01 * value / 6
            z += 0.01 * v
        agree(Run(node(solver + body.format(pressure, low, f'pressureSpeed="{speed}"')), 30).x()[:, 2], [z] * 3, 1e-6)
    for pressure, low, words in ((6, 1, ""), (-4, 0, 'pressureSpeed="0"')):
        v = z = 0.0
        for value in pulse(pressure, low, 0.01 * abs(pressure), 30):
            v += 0.01 * value / 6
            z += 0.01 * v
        run = Run(node(EXACT + body.format(pressure, low, words)), 30)
        agree(run.x()[:, 2], [z] * 3, 1e-6)
        run.says("pressureSpeed is not given")
    for pressure, speed in ((0, ""), (6, 'pressureSpeed="-2"')):
        run = Run(node(EXACT + body.format(pressure, -5, speed)), 10)
        agree(run.x()[:, 2] + 1, [1] * 3)
        run.says("SOFA's pulse stays at zero")


main()
