# SPDX-License-Identifier: LGPL-2.1-or-later
"""Membranes, plates and the springs of a surface in SOFA's dialect.
Usage: test_dialect_surfaces.py STROMA [WORD]."""
import itertools

import numpy as np

from dialect import EXACT, TWO, Run, agree, case, differ, fallen, main, node, numbers_of, root
from reference import euler, fibres, gravity, load, membrane, together

TRIANGLES = [(0, 1, 2), (1, 3, 2)]
X_SHEET = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1.2, 1.1, 0.2]])


def sheet(type_name, more=""):
    return root(EXACT + '<MeshTopology position="0 0 0  1 0 0  0 1 0  1.2 1.1 0.2" triangles="0 1 2  1 3 2"/>'
                '<MechanicalObject name="dofs"/><UniformMass totalMass="4"/>'
                f'<{type_name} youngModulus="2000" poissonRatio="0.3" {more}/><FixedConstraint indices="0 1"/>')


def sheet_reference(current, steps=10):
    fields = together(gravity(np.ones(4), [0, -10, 0]), membrane(TRIANGLES, X_SHEET, 2000, 0.3, current))
    return euler(X_SHEET, np.eye(4), fields, steps, 0.01, held=[0, 1])


@case
def quirk_membrane_shape():
    expected = sheet_reference(True)
    for name in ("TriangularFEMForceField", "TriangleFEMForceField"):
        agree(Run(sheet(name, 'method="large"'), 10).x(), expected, 1e-7)
    differ(Run(sheet("TriangularFEMForceField"), 10, args=["--without-quirk", "membrane-shape"]).x(), expected, 1e-8)


def fibre_law(direction):
    """direction(corners, normal) in space, projected on the sheet."""
    def law(corners, axes):
        along = axes.T @ direction(corners, axes[:, 2])
        c, s = along[:2] / np.linalg.norm(along[:2])
        return fibres(2000, 500, 0.3, c, s)
    return law


@case
def membrane_with_fibres():
    angle = np.radians(30)
    laws = {'fiberAngle="30"': fibre_law(lambda corners, n: np.array([np.cos(angle), np.sin(angle), 0])),
            'fiberCenter="3 -1 0.5"': fibre_law(lambda corners, n: np.cross(n, np.array([3, -1, 0.5]) - corners.mean(axis=0)))}
    for more, law in laws.items():
        scene = sheet("TriangularAnisotropicFEMForceField", f'transverseYoungModulus="500" {more}')
        for args, current in (((), True), (("--without-quirk", "membrane-shape"), None)):
            fields = together(gravity(np.ones(4), [0, -10, 0]), membrane(TRIANGLES, X_SHEET, 2000, 0.3, True, law))
            expected = euler(X_SHEET, np.eye(4), fields, 10, 0.01, held=[0, 1])
            (agree if current else differ)(Run(scene, 10, args=list(args)).x(), expected, 1e-7 if current else 1e-8)
    differ(Run(sheet("TriangularFEMForceField"), 10).x(), expected, 1e-4)
    Run(sheet("TriangularAnisotropicFEMForceField", 'method="small"'), 2).says("fibres in the axes of each first edge")


@case
def membrane_with_the_strain_at_rest():
    agree(Run(sheet("TriangularFEMForceFieldOptim"), 10).x(), sheet_reference(False), 1e-7)


@case
def sheets_with_another_rest_shape():
    """restScale makes triangles larger before their frames are taken; initialPoints of TriangleFEMForceField are its rest shape, those
    of other fields are overwritten with the rest positions."""
    other = X_SHEET * [1.1, 0.9, 1] + [0, 0, 3]
    for name, more, rest, current in (("TriangularFEMForceFieldOptim", 'restScale="0.9" damping="0.5"', 0.9 * X_SHEET, False),
                                      ("TriangleFEMForceField", f'initialPoints="{numbers_of(other)}"', other, True)):
        fields = together(gravity(np.ones(4), [0, -10, 0]), membrane(TRIANGLES, rest, 2000, 0.3, current))
        agree(Run(sheet(name, more), 10).x(), euler(X_SHEET, np.eye(4), fields, 10, 0.01, held=[0, 1]), 1e-7)
    solid = (EXACT + '<MeshTopology position="0 0 0  1 0 0  0 1 0  0 0 1" tetrahedra="0 1 2 3"/><MechanicalObject name="dofs"/>'
             '<UniformMass totalMass="1"/><FixedConstraint indices="0"/><TetrahedronFEMForceField youngModulus="100" poissonRatio="0.3" {}/>')
    given = Run(root(solid.format('initialPoints="0 0 0  2 0 0  0 2 0  0 0 2"')), 5)
    given.says("initialPoints")
    agree(given.x(), Run(root(solid.format("")), 5).x())


@case
def quirk_edge_bending():
    """A fold of two triangles: lambda = 2/3 (N_a + N_b) / (N_a N_b)^2 l^3 mu, and that of a plate 2 (h_a + h_b) / (h_a h_b)^2 l mu."""
    flat = np.array([[0.0, 0, 0], [0, 0.5, 0], [1, 0.25, 0], [-1, 0.25, 0]])
    x, alpha = flat + np.outer([0, 0, 0, 1], [0, 0, 0.2]), np.array([-0.5, -0.5, 0.5, 0.5])

    def words(points):
        return " ".join(map(str, points.ravel()))
    scene = node(EXACT + f'<MechanicalObject name="dofs" position="{words(x)}" rest_position="{words(flat)}"/><UniformMass totalMass="4"/>'
                 f'<MeshTopology position="{words(flat)}" triangles="0 2 1  0 1 3"/><FastTriangularBendingSprings bendingStiffness="30"/>')

    def bent(stiffness):
        k = -stiffness * np.kron(np.outer(alpha, alpha), np.eye(3))
        return euler(x, np.eye(4), lambda x, v: ((k @ x.ravel()).reshape(-1, 3), k), 20, 0.01)
    springs, plate = bent(2 / 3 * 1 / 0.25**2 * 0.5**3 * 30), bent(2 * 2 * 0.5 * 30)
    agree(Run(scene, 20).x(), springs)
    agree(Run(scene, 20, args=["--without-quirk", "edge-bending"]).x(), plate)
    differ(springs, plate, 1e-3)


@case
def quirk_isolated_springs():
    """Bodies of solvers of their own: the spring above both pulls with the force of the start, its damping included."""
    pair = (TWO.format("a", EXACT, "0 0 0", "0 0 0", 1) + TWO.format("b", EXACT, "1.2 0 0", "0 0.5 0", 3)
            + '<StiffSpringForceField object1="@a/dofs" object2="@b/dofs" spring="0 0 200 1.5 1"/>')
    x, v, m, h = np.array([[0.0, 0, 0], [1.2, 0, 0]]), np.array([[0.0, 0, 0], [0, 0.5, 0]]), np.array([[1.0], [3]]), 0.01
    for _ in range(30):
        d, u = x[1] - x[0], v[1] - v[0]
        n = d / np.linalg.norm(d)
        force = (200 * (np.linalg.norm(d) - 1) + 1.5 * (u @ n)) * n
        v = v + h * np.array([force, -force]) / m
        x = x + h * v
    run = Run(node(pair), 30)
    agree([run.x("a.dofs")[0], run.x("b.dofs")[0]], x)
    implicit = Run(node(pair), 30, args=["--without-quirk", "isolated-springs"])
    differ([implicit.x("a.dofs")[0], implicit.x("b.dofs")[0]], x, 1e-3)
    # one solver above both: implicit, as everything that it solves for
    above = node(EXACT + TWO.format("a", "", "0 0 0", "0 0 0", 1) + TWO.format("b", "", "1.2 0 0", "0 0.5 0", 3)
                 + '<StiffSpringForceField object1="@a/dofs" object2="@b/dofs" spring="0 0 200 1.5 1"/>')
    agree(Run(above, 30).x("b.dofs"), implicit.x("b.dofs"), 1e-9)


@case
def a_pressure_on_a_layer():
    """Triangles between dmin and dmax along an axis: those of the lid alone, a sixth of its force for each of their nodes."""
    box = ('<MeshTopology name="m" position="0 0 0 1 0 0 0 1 0  0 0 1 1 0 1 0 1 1" triangles="0 2 1  3 4 5"/><MechanicalObject name="dofs"/>'
           '<UniformMass totalMass="6"/>')
    run = Run(node(EXACT + box + '<TrianglePressureForceField normal="0 0 1" dmin="0.9" dmax="1.1" pressure="0 0 12"/>'), 10)
    agree(run.x()[:, 2], [0, 0, 0] + [1 + fallen(10, g=-2.0)] * 3)


@case
def plates_of_rectangles():
    """QuadBendingFEMForceField: f = -K u with the sides of the moment, a membrane of 2x2 points and shear across by the middle alone."""
    E, nu, t = 3e3, 0.3, 0.2
    places = np.array([[i * 0.5, j * 0.4, 0.0] for j in range(3) for i in range(3)])
    quads = [(i + 3 * j, i + 1 + 3 * j, i + 4 + 3 * j, i + 3 + 3 * j) for j in range(2) for i in range(2)]
    C = E * t / (1 - nu * nu) * np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]])
    across = 5 / 6 * E * t / 2 / (1 + nu)

    def plate(x, v):
        f, K = np.zeros_like(x), np.zeros((27, 27))
        for q in quads:
            a, b = np.linalg.norm(x[q[1]] - x[q[0]]) / 2, np.linalg.norm(x[q[3]] - x[q[0]]) / 2
            k, m, n = np.zeros((12, 12)), np.array([-1, 1, 1, -1]), np.array([-1, -1, 1, 1])
            for s, r in itertools.product((-3**-0.5, 3**-0.5), repeat=2):
                B = np.zeros((3, 12))
                B[0, 0::3] = B[2, 1::3] = m * (1 + n * r) / (4 * a)
                B[1, 1::3] = B[2, 0::3] = n * (1 + m * s) / (4 * b)
                k += a * b * B.T @ C @ B
            k[2::3, 2::3] += 4 * a * b * across * (np.outer(m, m) / (16 * a * a) + np.outer(n, n) / (16 * b * b))
            at = [3 * i + c for i in q for c in range(3)]
            K[np.ix_(at, at)] -= k
            f.ravel()[at] -= k @ (x - places).ravel()[at]
        return f, K
    scene = root(EXACT + '<RegularGridTopology n="3 3 1" min="0 0 0" max="1 0.8 0"/><MechanicalObject name="dofs"/><UniformMass '
                 'totalMass="9"/><QuadBendingFEMForceField youngModulus="3e3" poissonRatio="0.3" thickness="0.2"/><FixedConstraint '
                 'indices="0 3 6"/><ConstantForceField indices="8" force="40 0 30"/>')
    forces = together(gravity(np.ones(9), [0, -10, 0]), plate, load({8: [40, 0, 30]}))
    moment = euler(places, np.eye(9), forces, 20, 0.01, held=[0, 3, 6])
    agree(Run(scene, 20).x(), moment, 1e-8)
    differ(Run(scene, 20, args=["--without-quirk", "membrane-shape"]).x(), moment, 1e-5)


def thin_cells(cells, rest, E, nu, turn, plane_stress=False):
    """f = R K (X - c0 - R^T (x - c)), df = -R K R^T dx, with the three-dimensional strains of the gradients in the cell."""
    mu, lam = E / 2 / (1 + nu), E * nu / (1 + nu) / (1 - nu if plane_stress else 1 - 2 * nu)
    D = np.diag([2 * mu] * 3 + [mu] * 3)
    D[:3, :3] += lam
    corners = len(cells[0])

    def slopes(p):
        if corners == 2:
            return np.array([[-0.5], [0.5]])
        if corners == 3:
            return np.array([[-1, -1], [1, 0], [0, 1]], float)
        at = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]], float)
        return np.array([[a * (1 + b * p[1]) / 4, b * (1 + a * p[0]) / 4] for a, b in at])
    points = {2: [((0,), 2)], 3: [((0, 0), 0.5)],
              4: [((np.sqrt(2 / 3), 0), 4 / 3), ((-6**-0.5, -2**-0.5), 4 / 3), ((-6**-0.5, 2**-0.5), 4 / 3)]}[corners]
    matrices = []
    for cell in cells:
        K = np.zeros((3 * corners, 3 * corners))
        for p, weight in points:
            J = rest[list(cell)].T @ slopes(p)
            g = slopes(p) @ np.linalg.inv(J.T @ J) @ J.T
            B = np.zeros((6, 3 * corners))
            for a, (i, j, k) in enumerate(g):
                B[:, 3 * a:3 * a + 3] = [[i, 0, 0], [0, j, 0], [0, 0, k], [j, i, 0], [0, k, j], [k, 0, i]]
            K += weight * np.sqrt(np.linalg.det(J.T @ J)) * B.T @ D @ B
        matrices.append(K)

    def field(x, v):
        f, whole = np.zeros_like(x), np.zeros((x.size, x.size))
        for cell, K in zip(cells, matrices):
            now, then = x[list(cell)], rest[list(cell)]
            R = turn(now, then)
            away = (now - now.mean(axis=0)) @ R - (then - then.mean(axis=0))
            f[list(cell)] -= (K @ away.ravel()).reshape(-1, 3) @ R.T
            T = np.kron(np.eye(corners), R)
            at = [3 * i + c for i in cell for c in range(3)]
            whole[np.ix_(at, at)] -= T @ K @ T.T
        return f, whole
    return field


def fit(now, then):
    """The rotation that fits nodes best; of a line, one that takes it along."""
    u, s, vt = np.linalg.svd((now - now.mean(axis=0)).T @ (then - then.mean(axis=0)))
    return u @ np.diag([1, 1, np.linalg.det(u) * np.linalg.det(vt)]) @ vt


def first_edge(now, then):
    def axes(x):
        first, normal = x[1] - x[0], np.cross(x[1] - x[0], x[2] - x[0])
        first, normal = first / np.linalg.norm(first), normal / np.linalg.norm(normal)
        return np.array([first, np.cross(normal, first), normal]).T
    return axes(now) @ axes(then).T


@case
def cells_without_a_thickness():
    """Fields of any kind of cell on edges, triangles and quads: Hooke's law of space for the gradients in the cell."""
    x = np.array([[0, 0, 0], [1, 0, 0.1], [2, 0.1, 0], [0, 1, 0], [1.1, 1, 0], [2, 1.2, 0.2]])
    kinds = {"Triangle": ("triangles", [(0, 1, 4), (0, 4, 3), (1, 2, 5), (1, 5, 4)]), "Quad": ("quads", [(0, 1, 4, 3), (1, 2, 5, 4)]),
             "Edge": ("edges", [(0, 1), (1, 2), (1, 4), (4, 5), (3, 4), (0, 4), (2, 5), (0, 3)])}
    still = lambda now, then: np.eye(3)
    ways = [("LinearSmallStrain", kind, "", still) for kind in kinds]
    ways += [("Corotational", "Triangle", "", first_edge), ("Corotational", "Triangle", 'rotationMethod="stable_polar"', fit),
             ("Corotational", "Triangle", 'rotationMethod="identity"', still), ("Corotational", "Quad", "", fit),
             ("Corotational", "Edge", "", fit)]
    fallen_sheet = []
    for name, kind, more, turn in ways:
        word, cells = kinds[kind]
        mesh = f'<MeshTopology position="{numbers_of(x)}" {word}="{" ".join(str(i) for cell in cells for i in cell)}"/>'
        rest = (EXACT + mesh + '<MechanicalObject name="dofs"/><UniformMass totalMass="3"/><FixedConstraint indices="0 3"/>')
        forces = together(gravity(0.5 * np.ones(6), [0, -10, 0]), thin_cells(cells, x, 2e3, 0.3, turn), load({5: [0, 0, 30]}))
        expected = euler(x, 0.5 * np.eye(6), forces, 20, 0.01, held=[0, 3])
        for words in (f'template="Vec3,{kind}"', f'elementType="{kind}"', f'dofType="Vec3d" elementType="{kind}"'):
            scene = root(rest + f'<{name}FEMForceField {words} {more} youngModulus="2000" poissonRatio="0.3" computeForceStrategy='
                                '"parallel"/><ConstantForceField indices="5" forces="0 0 30"/>')
            agree(Run(scene, 20).x() - x, expected - x, 1e-8)
        fallen_sheet.append(expected)
    for one, other in itertools.combinations(fallen_sheet[:6], 2):
        if one is not fallen_sheet[0] or other is not fallen_sheet[5]:  # identity is the linear one
            differ(one, other, 1e-4)


@case
def cells_in_a_plane():
    """Bodies in a plane have the law of a sheet."""
    x = np.array([[0, 0, 0], [1, 0, 0], [2, 0.1, 0], [0, 1, 0], [1.1, 1, 0], [2, 1.2, 0]])
    for kind, word, cells in (("Triangle", "triangles", [(0, 1, 4), (0, 4, 3), (1, 2, 5), (1, 5, 4)]),
                              ("Quad", "quads", [(0, 1, 4, 3), (1, 2, 5, 4)])):
        flat = " ".join(f"{a} {b}" for a, b, _ in x)
        mesh = f'<MeshTopology position="{numbers_of(x)}" {word}="{" ".join(str(i) for cell in cells for i in cell)}"/>'
        scene = root(EXACT + mesh + f'<MechanicalObject name="dofs" template="Vec2" position="{flat}"/><UniformMass totalMass="3"/>'
                     f'<CorotationalFEMForceField template="Vec2,{kind}" youngModulus="2000 1000" poissonRatio="0.3"/>'
                     '<FixedConstraint indices="0 3"/>')
        young = [2e3, 1e3] + [2e3] * (len(cells) - 2)  # beyond the list's end the first
        fields = [thin_cells([cell], x, E, 0.3, fit, plane_stress=True) for cell, E in zip(cells, young)]
        expected = euler(x, 0.5 * np.eye(6), together(gravity(0.5 * np.ones(6), [0, -10, 0]), *fields), 20, 0.01, held=[0, 3])
        agree(Run(scene, 20).x() - x, expected - x, 1e-8)


@case
def surfaces_without_inner_edges_do_not_bend():
    """Nor do surfaces without cells of the kind: there is no spring, as in SOFA."""
    for kind in ("Quad", "Triangular"):
        mesh = '<MeshTopology position="0 0 0  1 0 0  1 1 0  0 1 0" quads="0 1 2 3"/><MechanicalObject name="dofs"/><UniformMass totalMass="4"/>'
        run = Run(root(EXACT + mesh + f'<{kind}BendingSprings stiffness="100"/>'), 10)
        run.says("no two cells of the surface share an edge")
        agree(run.x()[:, 1], [fallen(10), fallen(10), 1 + fallen(10), 1 + fallen(10)])


@case
def membranes_that_lose_triangles():
    """The others go on; a node without triangles goes, and the last one takes its number."""
    X = np.array([[0, 0, 0], [1, 0.1, 0], [2, 0, 0.1], [0.1, 1, 0], [1.1, 1.2, 0], [2, 1, 0.2]])
    v = np.array([[0, 0, 0], [0, 1, 2], [1, 0, 3], [0, 0, 0], [2, 0, 1], [0, -1, 2.0]])
    triangles = [(0, 1, 3), (1, 4, 3), (1, 2, 4), (2, 5, 4)]
    for removed, gone in (([1], 6), ([1, 2], 6), ([0], 0), ([3], 5), ([0, 3], 0)):
        for name, current in (("TriangularFEMForceField", True), ("TriangularFEMForceFieldOptim", False)):
            step = itertools.count()
            whole = membrane(triangles, X, 200, 0.3, current)
            left = membrane([t for i, t in enumerate(triangles) if i not in removed], X, 200, 0.3, current)
            scene = node(EXACT + f'<TriangleSetTopologyContainer name="c" position="{numbers_of(X)}" triangles="'
                         f'{" ".join(str(n) for t in triangles for n in t)}"/><TriangleSetTopologyModifier/><MechanicalObject name="dofs" '
                         f'velocity="{numbers_of(v)}"/><UniformMass vertexMass="0.5"/><FixedConstraint indices="3"/><{name} youngModulus='
                         '"200" poissonRatio="0.3" method="large"/><TopologicalChangeProcessor useDataInputs="1" timeToRemove="0.035" '
                         f'trianglesToRemove="{" ".join(map(str, removed))}"/>')
            x = euler(X, 0.5 * np.eye(6), lambda x, v: (whole if next(step) < 4 else left)(x, v), 9, 0.01, v=v, held=[3])
            if removed == [0, 3]:  # nodes 0 and 5
                x = np.array([x[4], *x[1:4]])
            elif gone < 6:
                x[gone] = x[5]
                x = x[:5]
            agree(Run(scene, 9).x(), x)


def springs_of_triangles(triangles, rest, E, nu, damping, angular):
    """Constants of Delingette's quadratic springs in SOFA's words, and its tangent: lengths at rest along a side."""
    lam, mu = E * nu / (1 - nu * nu), E / (1 + nu)
    sheets = []
    for t in triangles:
        L = np.array([np.linalg.norm(rest[t[(j + 2) % 3]] - rest[t[(j + 1) % 3]]) for j in range(3)])
        A = np.linalg.norm(np.cross(rest[t[1]] - rest[t[0]], rest[t[2]] - rest[t[0]])) / 2
        c = np.array([(L[(j + 1) % 3] ** 2 + L[(j + 2) % 3] ** 2 - L[j] ** 2) / (4 * A) for j in range(3)])
        gamma = [L[(j + 1) % 3] * L[(j + 2) % 3] * (2 * c[(j + 1) % 3] * c[(j + 2) % 3] * (lam + mu) - mu) / (8 * A) for j in range(3)]
        sheets.append((t, L, gamma, L * L * (2 * c * c * (lam + mu) + mu) / (8 * A)))

    def field(x, v):
        f, K = np.zeros_like(x), np.zeros((x.size, x.size))
        for t, L, gamma, stiff in sheets:
            d = [x[t[(k + 1) % 3]] - x[t[(k + 2) % 3]] for k in range(3)]
            w = [v[t[(k + 1) % 3]] - v[t[(k + 2) % 3]] for k in range(3)]
            l = np.array([np.linalg.norm(one) for one in d])
            s = l - L + damping * np.array([a @ b for a, b in zip(d, w)]) / l
            for k in range(3):
                i, j = (k + 1) % 3, (k + 2) % 3
                pull = stiff[k] * s[k] + (gamma[i] * s[j] + gamma[j] * s[i] if angular else 0)
                f[t[i]] -= pull * d[k] / l[k]
                f[t[j]] += pull * d[k] / l[k]
                m = -pull / l[k] * np.eye(3) + ((pull if angular else 0) - stiff[k] * L[k]) / l[k] ** 3 * np.outer(d[k], d[k])
                if angular:
                    to_i, to_j = -d[j], d[i]  # from the corner k
                    m += (np.outer(to_i, to_j) * gamma[k] / (l[i] * l[j]) - np.outer(to_i, d[k]) * gamma[i] / (l[j] * l[k]) +
                          np.outer(d[k], to_j) * gamma[j] / (l[k] * l[i]))
                else:
                    m = -stiff[k] * s[k] / l[k] * np.eye(3) - stiff[k] * L[k] / l[k] ** 3 * np.outer(d[k], d[k])
                a, b = slice(3 * t[i], 3 * t[i] + 3), slice(3 * t[j], 3 * t[j] + 3)
                K[a, a] += m
                K[a, b] -= m
                K[b, a] -= m.T
                K[b, b] += m.T
        return f, K
    return field


@case
def quadratic_springs_of_triangles():
    x = np.array([[0, 0, 0], [1, 0.1, 0], [0.3, 1.1, 0.2], [1.2, 1, 0.1]])
    v = np.array([[0, 0, 0], [3, -1, 0], [-2, 3, 1], [2, 4, -1.0]])
    triangles = [(0, 1, 2), (1, 3, 2)]
    for damping in (0, 0.02):
        for angular in (True, False):
            scene = node(EXACT + f'<MeshTopology position="{numbers_of(x)}" triangles="0 1 2 1 3 2"/><MechanicalObject name="dofs" velocity="'
                         f'{numbers_of(v)}"/><UniformMass totalMass="2"/><FixedConstraint indices="0"/><TriangularQuadraticSpringsForceField '
                         f'youngModulus="500" poissonRatio="0.3" dampingRatio="{damping}" useAngularSprings="{int(angular)}"/>')
            field = springs_of_triangles(triangles, x, 500, 0.3, damping, angular)
            expected = euler(x, 0.5 * np.eye(4), field, 12, 0.01, v=v, held=[0])
            agree(Run(scene, 12).x(), expected)
            if angular:
                differ(Run(scene, 12, args=["--without-quirk", "torsion-tangent"]).x(), expected, 1e-4)


@case
def springs_of_polynomials():
    """Those that do not resist have a tangent too; to places at rest the diagonal alone."""
    x = np.array([[0, 0, 0], [1, 0.1, 0], [0.3, 1.1, 0.2], [1.2, 1, 0.1]])
    v = np.array([[0, 0, 0], [-6, -1, 0], [-2, 5, 1], [2, 4, -1.0]])
    pairs, c = [(0, 1), (1, 2), (2, 3)], [(100, 300), (80, 50, 20), (60,)]

    def value(i, e):
        return sum(a * e ** (n + 1) for n, a in enumerate(c[i])), sum((n + 1) * a * e ** n for n, a in enumerate(c[i]))

    def between(resists):
        def field(x_now, v_now):
            f, K = np.zeros_like(x), np.zeros((x.size, x.size))
            for i, (a, b) in enumerate(pairs):
                d, L = x_now[b] - x_now[a], np.linalg.norm(x[b] - x[a])
                l = np.linalg.norm(d)
                n, (p, slope) = d / l, value(i, abs(l - L) / L)
                sign = 1 if l >= L else -1 if resists else 0
                f[a] += sign * p * n
                f[b] -= sign * p * n
                block = (slope / L - p / l) * np.outer(n, n) + p / l * np.eye(3)
                K += np.kron(np.outer(np.eye(4)[a] - np.eye(4)[b], np.eye(4)[b] - np.eye(4)[a]), block)
            return f, K
        return field

    def to_rest(x_now, v_now):
        f, K = np.zeros_like(x), np.zeros((x.size, x.size))
        for i, a in enumerate((1, 2, 3)):
            d = x_now[a] - x[a]
            rounding, L = np.exp(0.2 - 0.7 * d @ d), 0.9
            m, (p, slope) = np.sqrt(d @ d + rounding), value(i, np.linalg.norm(d) / L)
            f[a] -= p * d / m
            K[3 * a:3 * a + 3, 3 * a:3 * a + 3] -= np.diag((slope / L - p / m) * (1 - 0.7 * rounding) * d * d / m**2 + p / m)
        return f, K
    body = (f'<MechanicalObject name="dofs" position="{numbers_of(x)}" velocity="{numbers_of(v)}"/><UniformMass totalMass="2"/><FixedConstraint '
            'indices="0"/>')
    words = 'polynomialDegree="2 3 1" polynomialStiffness="100 300 80 50 20 60"'
    for more, field in (('firstObjectPoints="0 1 2" secondObjectPoints="1 2 3"', between(False)),
                        ('firstObjectPoints="0 1 2" secondObjectPoints="1 2 3" compressible="1"', between(True)),
                        ('points="1 2 3" initialLength="0.9" smoothShift="0.2" smoothScale="0.7"', to_rest)):
        kind = "PolynomialRestShapeSpringsForceField" if "smooth" in more else "PolynomialSpringsForceField"
        expected = euler(x, 0.5 * np.eye(4), field, 12, 0.01, v=v, held=[0])
        agree(Run(node(EXACT + body + f'<{kind} {words} {more}/>'), 12).x(), expected)


main()
