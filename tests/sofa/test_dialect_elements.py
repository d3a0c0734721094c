# SPDX-License-Identifier: LGPL-2.1-or-later
"""Elements of solids in SOFA's dialect: rotations, materials, plasticity, cells of parts.
Usage: test_dialect_elements.py STROMA [WORD]."""
import itertools

import numpy as np

from dialect import (BODY, CORNERS, CUBE, CUBE_PLACES, EXACT, X4, X4_TEXT, Run, agree, case, differ, fallen, falls,
                     main, node, numbers_of, root)
from reference import edge_polar, euler, frame, gravity, hexahedra, load, polar, prisms, stiffness, tetrahedra, together


@case
def quirk_edge_polar():
    scene = root(EXACT + f'<MeshTopology position="{X4_TEXT}" tetrahedra="0 1 2 3"/><MechanicalObject name="dofs"/>'
                 '<UniformMass totalMass="4"/><TetrahedronFEMForceField method="polar" youngModulus="200" poissonRatio="0.3"/>'
                 '<FixedConstraint indices="0"/>')
    fields = together(gravity(np.ones(4), [0, -10, 0]), tetrahedra([(0, 1, 2, 3)], X4, 200, 0.3, edge_polar))
    expected = euler(X4, np.eye(4), fields, 30, 0.01, held=[0])
    agree(Run(scene, 30).x(), expected, 1e-7)
    differ(Run(scene, 30, args=["--without-quirk", "edge-polar"]).x(), expected, 1e-5)
    Run(scene.replace("polar", 'polar" updateStiffnessMatrix="1'), 3).says("updateStiffnessMatrix: takes polar factors")


def proper(A):
    """The nearest rotation."""
    U, S, V = np.linalg.svd(A)
    return U @ np.diag([1, 1, np.linalg.det(U @ V)]) @ V


def edge_svd(now, then):
    """The factor of the edges, until the cell is inside out: then of the edges now by those at rest."""
    if np.linalg.det(now) / np.linalg.det(then) >= 1e-6:
        return edge_polar(now, then)
    return polar(then) @ proper(np.linalg.inv(then) @ now) @ polar(then).T


@case
def cells_that_turn_inside_out():
    """SOFA's polar factors are reflections there, and the nearest rotations for svd and stable_polar."""
    corners = np.array([[0, 0, 0], [2, 0.3, 0], [0.4, 3, 0.2], [0.3, 0.5, 1.5]])
    nodes = [corners[list(order)] for order in ((0, 1, 2, 3), (0, 2, 1, 3))]
    nodes_svd = lambda now, then: proper(node_sum(now, then))
    ways = (("TetrahedronFEMForceField", 'method="polar"', edge_polar), ("TetrahedronFEMForceField", 'method="svd"', edge_svd),
            ("TetrahedralCorotationalFEMForceField", 'method="polar"', edge_polar),
            ("CorotationalFEMForceField", 'template="Vec3,Tetrahedron" rotationMethod="polar"', node_polar),
            ("CorotationalFEMForceField", 'template="Vec3,Tetrahedron" rotationMethod="stable_polar"', nodes_svd))
    for X, (kind, way, turn) in itertools.product(nodes, ways):
        signs = set()

        def watched(now, then):
            signs.add(np.sign(np.linalg.det(now) * np.linalg.det(then)))
            return turn(now, then)
        speed = np.vstack([np.zeros((3, 3)), 20 * (X[:3].mean(axis=0) - X[3]) + [1, -2, 0.5]])
        scene = root(EXACT + f'<MeshTopology position="{numbers_of(X)}" tetrahedra="0 1 2 3"/><MechanicalObject name="dofs" '
                     f'velocity="{numbers_of(speed)}"/><UniformMass totalMass="4"/><{kind} {way} youngModulus="30" poissonRatio="0.3"/>'
                     '<FixedConstraint indices="0 1 2"/>')
        fields = together(gravity(np.ones(4), [0, -10, 0]), tetrahedra([(0, 1, 2, 3)], X, 30, 0.3, watched))
        expected = euler(X, np.eye(4), fields, 40, 0.01, v=speed, held=[0, 1, 2])
        assert signs == {-1, 1}, (kind, way, signs)
        agree(Run(scene, 40).x(), expected, 1e-9)


def node_sum(now, then):
    p, q = (np.column_stack([np.zeros(3), edges]) for edges in (now, then))
    return (p - p.mean(axis=1, keepdims=True)) @ (q - q.mean(axis=1, keepdims=True)).T


def node_polar(now, then):
    """Of the sum over the nodes of (x - c)(X - C)^T."""
    return polar(node_sum(now, then))


@case
def polar_factors_of_nodes():
    """Of SOFA's corotational elements that are one component for all kinds."""
    scene = root(EXACT + f'<MeshTopology position="{X4_TEXT}" tetrahedra="0 1 2 3"/><MechanicalObject name="dofs"/><UniformMass '
                 'totalMass="4"/><CorotationalFEMForceField template="Vec3,Tetrahedron" rotationMethod="polar" youngModulus="200" '
                 'poissonRatio="0.3"/><FixedConstraint indices="0"/>')
    fields = together(gravity(np.ones(4), [0, -10, 0]), tetrahedra([(0, 1, 2, 3)], X4, 200, 0.3, node_polar))
    expected = euler(X4, np.eye(4), fields, 30, 0.01, held=[0])
    for word in ("polar", "stable_polar"):
        agree(Run(scene.replace('"polar"', f'"{word}"'), 30).x(), expected, 1e-7)
    differ(Run(scene, 30, args=["--without-quirk", "edge-polar"]).x(), expected, 1e-5)
    # a brick that turns about its first edge
    x = np.array([(a, b, c) for c in (0, 1) for a, b in ((0, 0), (2, 0), (2, 1), (0, 1))], float)
    brick = root(EXACT + f'<HexahedronSetTopologyContainer position="{" ".join(map(str, x.ravel()))}" hexahedra="0 1 2 3 4 5 6 7"/>'
                 '<MechanicalObject name="dofs"/><UniformMass totalMass="8"/><FixedConstraint indices="0"/><CorotationalFEMForceField '
                 'template="Vec3,Hexahedron" rotationMethod="polar" youngModulus="200" poissonRatio="0.3"/>')
    fields = together(gravity(np.ones(8), [0, -10, 0]), hexahedra([range(8)], x, 200, 0.3, lambda now, then: polar(
        (now - now.mean(axis=0)).T @ (then - then.mean(axis=0)))))
    agree(Run(brick, 30).x(), euler(x, np.eye(8), fields, 30, 0.01, held=[0]), 1e-7)


def hyperelastic(cells, rest, stress):
    """Cells of four or eight nodes: at each point f_a = -w F S(C) grad N_a, and K = df/dx by complex steps."""
    sides = np.array([(-1, -1, -1), (1, -1, -1), (1, 1, -1), (-1, 1, -1), (-1, -1, 1), (1, -1, 1), (1, 1, 1), (-1, 1, 1)], float)
    points = []
    for cell in cells:
        X = np.asarray(rest, float)[list(cell)]
        local = [(1 / 6, np.vstack([[-1, -1, -1], np.eye(3)]))]
        if len(cell) == 8:
            ones = [1 + sides * point for point in sides / np.sqrt(3)]
            local = [(1, sides * np.column_stack([o[:, 1] * o[:, 2], o[:, 0] * o[:, 2], o[:, 0] * o[:, 1]]) / 8) for o in ones]
        for weight, dN in local:
            J = dN.T @ X
            points.append((list(cell), weight * np.linalg.det(J), dN @ np.linalg.inv(J).T))

    def forces(x):
        f = np.zeros(x.shape, x.dtype)
        for cell, volume, G in points:
            F = x[cell].T @ G
            f[cell] -= volume * G @ (F @ stress(F.T @ F)).T
        return f

    def field(x, v):
        K = np.zeros((x.size, x.size))
        for i in range(x.size):
            y = x.astype(complex)
            y.ravel()[i] += 1e-30j
            K[:, i] = forces(y).imag.ravel() / 1e-30
        return forces(x), K
    return field


def of_invariants(energy):
    """S = 2 dW/dC of W(I1, I2, ln J), given as its three derivatives."""
    def stress(C):
        inverse, one = np.linalg.inv(C), np.eye(3)
        I1, L = np.trace(C), np.log(np.linalg.det(C)) / 2
        by1, by2, by_l = energy(I1, (I1 * I1 - np.trace(C @ C)) / 2, L)
        return 2 * by1 * one + 2 * by2 * (I1 * one - C) + by_l * inverse
    return stress


E, NU = 300.0, 0.3
MU, LAMBDA = E / (2 * (1 + NU)), E * NU / ((1 + NU) * (1 - 2 * NU))


def isochoric(mu10, mu01, bulk):
    def derivatives(I1, I2, L):
        a, b = mu10 * np.exp(-2 * L / 3), mu01 * np.exp(-4 * L / 3)
        return a, b, -2 / 3 * a * I1 - 4 / 3 * b * I2 + bulk * L
    return of_invariants(derivatives)


def squares(mu, kappa):
    """Ogden's law of alpha 2: mu/4 (J^-2/3 I1 - 3), and of alpha 4 by tr C^2 = I1^2 - 2 I2."""
    def derivatives(I1, I2, L):
        a = mu / 16 * np.exp(-4 * L / 3)
        return 2 * a * I1, -2 * a, -4 / 3 * a * (I1 * I1 - 2 * I2) + kappa * L
    return of_invariants(derivatives)


MATERIALS = {
    f'NeoHookeanMaterial youngModulus="{E}" poissonRatio="{NU}"': of_invariants(lambda I1, I2, L: (MU / 2, 0, LAMBDA * L - MU)),
    f'StVenantKirchhoffMaterial youngModulus="{E}" poissonRatio="{NU}"':
        lambda C: LAMBDA / 2 * np.trace(C - np.eye(3)) * np.eye(3) + MU * (C - np.eye(3)),
    'MooneyRivlinMaterial mu10="40" mu01="20" bulkModulus="250"': isochoric(40, 20, 250),
    'OgdenMaterial mu="240" alpha="2" kappa="250"': isochoric(60, 0, 250),
    'OgdenMaterial mu="240" alpha="4" kappa="250"': squares(240, 250),
    'IncompressibleMooneyRivlinMaterial mu10="1" mu01="2"': of_invariants(lambda I1, I2, L: (1, 2, 0)),
}
TWO_TETRAHEDRA = np.array([[0, 0, 0], [2, 0, 0], [0, 3, 0], [0, 0, 1.5], [1.8, 2, 1.4]])
TWO_BRICKS = np.array([(a + 0.1 * b * c, b, c) for c in (0, 1.5) for a, b in ((0, 0), (2, 0), (2, 1), (0, 1), (4, 0), (4, 1))], float)
HYPERELASTIC = {
    "Tetrahedron": (TWO_TETRAHEDRA, [(0, 1, 2, 3), (1, 4, 2, 3)], [0, 2, 3]),
    "Hexahedron": (TWO_BRICKS, [(0, 1, 2, 3, 6, 7, 8, 9), (1, 4, 5, 2, 7, 10, 11, 8)], [0, 3, 6, 9]),
}


def hyperelastic_scene(kind, parts, solvers=EXACT):
    x, cells, held = HYPERELASTIC[kind]
    text = [" ".join(map(str, np.ravel(each))) for each in (x, cells, held)]
    name = {"Tetrahedron": "tetrahedra", "Hexahedron": "hexahedra"}[kind]
    return (f'{solvers}<{kind}SetTopologyContainer position="{text[0]}" {name}="{text[1]}"/><MechanicalObject name="dofs"/>'
            f'<UniformMass vertexMass="1"/><FixedProjectiveConstraint indices="{text[2]}"/>{parts}')


@case
def materials_that_are_components():
    """Each law on both kinds of cell, in implicit steps under weight."""
    for kind, (x, cells, held) in HYPERELASTIC.items():
        for material, law in MATERIALS.items():
            parts = (f'<HyperelasticityFEMForceField template="Vec3d,{kind}" computeForceStrategy="parallel" elementSpace="0.1"/>'
                     f'<{material}/>')
            run = Run(root(hyperelastic_scene(kind, parts)), 12)
            fields = together(gravity(np.ones(len(x)), [0, -10, 0]), hyperelastic(cells, x, law))
            expected = euler(x, np.eye(len(x)), fields, 12, 0.01, held=held)
            agree(run.x() - x, expected - x, 1e-7)
            assert "has no attribute" not in run.text, run.text
    run.says("this law does not resist changes of volume", "a tension of 10")


@case
def a_field_finds_its_material():
    """The one that is linked, else the first of the node, else that above; numbers that are not given are SOFA's."""
    x, cells, held = HYPERELASTIC["Tetrahedron"]
    field = '<HyperelasticityFEMForceField template="Vec3,Tetrahedron" name="fem" {}/>'

    def expect(parts, law, more="", says=()):
        run = Run(root(more + f'<Node name="body">{hyperelastic_scene("Tetrahedron", parts)}</Node>'), 5)
        fields = together(gravity(np.ones(5), [0, -10, 0]), hyperelastic(cells, x, law))
        agree(run.x("body.dofs") - x, euler(x, np.eye(5), fields, 5, 0.01, held=held) - x, 1e-7)
        run.says(*says)
    soft, stiff = isochoric(40, 20, 250), isochoric(400, 200, 2500)
    first, second = '<MooneyRivlinMaterial mu10="40" mu01="20" bulkModulus="250"/>', \
        '<MooneyRivlinMaterial name="stiff" mu10="400" mu01="200" bulkModulus="2500"/>'
    expect(first + second + field.format(""), soft)
    expect(first + second + field.format('material="@stiff"'), stiff)
    expect(field.format(""), stiff, more=second)
    expect(first + field.format('material="@/stiff"'), stiff, more=second)
    expect('<MooneyRivlinMaterial/>' + field.format(""), isochoric(1000, 1000, 100), says=["Poisson's ratio of -0.9"])
    expect('<OgdenMaterial alpha="4"/>' + field.format(""), squares(100, 1000))
    mu, lam = 1e6 / 2.9, 1e6 * 0.45 / (1.45 * 0.1)
    expect('<NeoHookeanMaterial/>' + field.format(""), of_invariants(lambda I1, I2, L: (mu / 2, 0, lam * L - mu)))


@case
def dilatation_of_bricks_with_a_material():
    """SOFA takes that of the points, also near incompressibility."""
    x, cells, held = HYPERELASTIC["Hexahedron"]
    mu, lam = 300 / 2.9, 300 * 0.45 / (1.45 * 0.1)
    scene = root(hyperelastic_scene("Hexahedron", '<NeoHookeanMaterial template="Vec3d" youngModulus="300" poissonRatio="0.45"/>'
                                    '<HyperelasticityFEMForceField template="Vec3,Hexahedron"/>'))
    fields = together(gravity(np.ones(len(x)), [0, -10, 0]),
                      hyperelastic(cells, x, of_invariants(lambda I1, I2, L: (mu / 2, 0, lam * L - mu))))
    expected = euler(x, np.eye(len(x)), fields, 12, 0.01, held=held)
    agree(Run(scene, 12).x() - x, expected - x, 1e-7)
    differ(Run(scene, 12, args=["--without-quirk", "local-dilatation"]).x(), expected, 1e-5)


@case
def poisson_ratios_out_of_range():
    """SOFA's fields take 0.45 in the place of each one; its materials take any, and there are none for it here."""
    x, cells, held = HYPERELASTIC["Tetrahedron"]
    field = '<TetrahedronFEMForceField method="large" youngModulus="300" poissonRatio="{}"/>'
    scene = lambda written: root(hyperelastic_scene("Tetrahedron", field.format(written)))
    for written, taken in (("-0.2", "0.45"), ("0.5", "0.45"), ("-1.5", "0.45")):
        run = Run(scene(written), 6)
        run.says("SOFA takes 0.45")
        agree(run.x(), Run(scene(taken), 6).x(), 0)
    differ(Run(scene("0.45"), 6).x(), Run(scene("0.3"), 6).x(), 1e-6)
    material = '<NeoHookeanMaterial youngModulus="300" poissonRatio="0.6"/><HyperelasticityFEMForceField/>'
    Run(root(hyperelastic_scene("Tetrahedron", material)), 1).fails(2, "poissonRatio", "(-1, 0.5)")


@case
def nodes_that_follow_none():
    """With ignoreNotFound they stay where they are; the others hang on what they follow."""
    scene = node(EXACT + '<MechanicalObject name="p" position="0 0 0 1 0 0"/><UniformMass vertexMass="1"/><Node name="c">'
                 '<MechanicalObject name="s" position="1 0 0 5 1 2"/><SubsetMapping ignoreNotFound="1"/>'
                 '<ConstantForceField indices="0 1" forces="1 0 0 7 7 7"/></Node>')
    run = Run(scene, 5)
    X = np.array([[0, 0, 0], [1, 0, 0]], float)
    expected = euler(X, np.eye(2), load({1: np.array([1.0, 0, 0])}), 5, 0.01)
    agree(run.x("p"), expected)
    agree(run.x("c.s"), [expected[1], [5, 1, 2]])
    Run(scene.replace('ignoreNotFound="1"', ""), 1).fails(2, "from the nearest node", "ignoreNotFound")


@case
def fields_without_a_material_that_fits():
    body = '<HyperelasticityFEMForceField template="Vec3,Tetrahedron" {}/>{}'
    neo = '<NeoHookeanMaterial name="neo" youngModulus="300" poissonRatio="0.3"/>'
    for attributes, parts, words in (
            ("", "", ("there is no material", "NeoHookeanMaterial, StVenantKirchhoffMaterial", "OgdenMaterial")),
            ('material="@gone"', "", ("'@gone' leads nowhere", "there is no material")),
            ("", '<OgdenMaterial alpha="0"/>', ("alpha is 0", "an exponent other than 0")),
            ("", "<NeoHookeMaterial/>", ("NeoHookeMaterial", "NeoHookeanMaterial"))):
        Run(root(hyperelastic_scene("Tetrahedron", body.format(attributes, parts))), 1).fails(2, *words)
    triangles = root(EXACT + '<MeshTopology position="0 0 0 1 0 0 0 1 0" triangles="0 1 2"/><MechanicalObject name="dofs"/><UniformMass '
                     f'totalMass="3"/>{neo}<HyperelasticityFEMForceField template="Vec3,Triangle"/>')
    Run(triangles, 1).fails(2, "template 'Vec3,Triangle' is none that", "Vec3,Tetrahedron, Vec3,Hexahedron")


@case
def quirk_prism_points():
    """Two of them, with which a twist of the ends has no stiffness, and one rotation for both."""
    x = np.array([(a, b, c) for c in (0, 1.5) for a, b in ((0, 0), (1, 0.1), (0.2, 1.1), (1.1, 1))], float)
    cells = [(0, 1, 2, 4, 5, 6), (1, 3, 2, 5, 7, 6)]
    for field, turn in (('CorotationalFEMForceField', lambda now, then: polar((now - now.mean(axis=0)).T @ (then - then.mean(axis=0)))),
                        ('LinearSmallStrainFEMForceField', lambda now, then: np.eye(3))):
        scene = root(EXACT + f'<MeshTopology position="{" ".join(map(str, x.ravel()))}" prisms="{" ".join(str(n) for c in cells for n in c)}"/>'
                     f'<MechanicalObject name="dofs"/><UniformMass totalMass="8"/><{field} template="Vec3,Prism" youngModulus="200" '
                     'poissonRatio="0.3"/><FixedConstraint indices="0 1"/>')
        two, six = (euler(x, np.eye(8), together(gravity(np.ones(8), [0, -10, 0]), prisms(cells, x, 200, 0.3, turn, points)), 30, 0.01,
                          held=[0, 1]) for points in (2, 6))
        agree(Run(scene, 30).x(), two, 1e-7)
        agree(Run(scene, 30, args=["--without-quirk", "prism-points"]).x(), six, 1e-7)
        differ(two, six, 1e-4)


@case
def methods_of_fast_tetrahedra():
    """linear is none; polar has deformation gradients, and polar2 the edges."""
    scene = root(EXACT + f'<MeshTopology position="{X4_TEXT}" tetrahedra="0 1 2 3"/><MechanicalObject name="dofs"/><UniformMass '
                 'totalMass="4"/><FastTetrahedralCorotationalForceField method="WORD" youngModulus="200" poissonRatio="0.3"/>'
                 '<FixedConstraint indices="0"/>')
    for words, turn in ((("none", "linear", "small"), lambda now, then: np.eye(3)), (("polar2",), edge_polar),
                        (("polar",), lambda now, then: polar(now @ np.linalg.inv(then)))):
        fields = together(gravity(np.ones(4), [0, -10, 0]), tetrahedra([(0, 1, 2, 3)], X4, 200, 0.3, turn))
        expected = euler(X4, np.eye(4), fields, 30, 0.01, held=[0])
        for word in words:
            agree(Run(scene.replace("WORD", word), 30).x(), expected, 1e-7)


@case
def tangents_of_sofa_that_are_not_followed():
    """Each is said: the results differ."""
    for field, word in (('TetrahedronHyperelasticityFEMForceField materialName="Costa" ParameterSet="50 300 4 1.5 2 1.2 0.8 3"', "lacks the factor k0"),
                        ('StandardTetrahedralFEMForceField materialName="MooneyRivlin" ParameterSet="30 20 300"', "lacks a part of c2"),
                        ('FastTetrahedralCorotationalForceField youngModulus="300" poissonRatio="0.3"', "blocks are transposed")):
        scene = node(EXACT + '<TetrahedronSetTopologyContainer position="0 0 0  1 0 0  0 1 0  0 0 1" tetrahedra="0 1 2 3"/>'
                     f'<MechanicalObject name="dofs"/><UniformMass totalMass="2"/><FixedConstraint indices="0 1 2"/><{field}/>')
        Run(scene, 1).says(word)
        other = Run(scene.replace(EXACT, "<EulerImplicitSolver/><CGLinearSolver/>"), 1)
        assert "blocks are transposed" not in other.text, other.text
    assert "lacks a part" not in Run(scene.replace(field, 'StandardTetrahedralFEMForceField materialName="MooneyRivlin" ParameterSet="30 0 300"'), 1).text


@case
def edges_of_hexahedra_with_method_polar():
    """Cells that are no cubes: polar factors of their mean edges, of a box and of a cell that is none."""
    flat = np.array([[2 * i, j, 0.5 * k] for k in range(2) for j in range(2) for i in range(2)], float)
    bent = flat + 0.1 * np.sin(3 * np.arange(24)).reshape(8, 3)
    for X in (flat, bent):
        places = " ".join(map(str, X.ravel()))
        scene = root(EXACT + f'<MeshTopology position="{places}" hexahedra="0 1 3 2 4 5 7 6"/><MechanicalObject name="dofs"/>'
                     '<UniformMass totalMass="8"/><HexahedronFEMForceField method="polar" youngModulus="200" poissonRatio="0.3"/>'
                     '<FixedConstraint indices="0 2"/>')
        fields = together(gravity(np.ones(8), [0, -10, 0]), hexahedra([(0, 1, 3, 2, 4, 5, 7, 6)], X, 200, 0.3))
        expected = euler(X, np.eye(8), fields, 30, 0.01, held=[0, 2])
        agree(Run(scene, 30).x(), expected, 1e-7)
        differ(Run(scene, 30, args=["--without-quirk", "edge-polar"]).x(), expected, 1e-5)


def halves_of_quads(quads, pressure):
    """Of the triangles 0 1 2 and 0 2 3 of the moment, without a stiffness."""
    def field(x, v):
        f = np.zeros_like(x)
        for a, b, c, d in quads:
            for t in ((a, b, c), (a, c, d)):
                f[list(t)] += pressure / 6 * np.cross(x[t[1]] - x[t[0]], x[t[2]] - x[t[0]])
        return f, np.zeros((x.size, x.size))
    return field


@case
def quirk_split_quads():
    scene = root(EXACT + '<MeshTopology position="0 0 0  1 0 0  1 1 0  0 1 0" quads="0 1 2 3"/><MechanicalObject name="dofs"/>'
                 '<UniformMass totalMass="4"/><RestShapeSpringsForceField stiffness="50"/><SurfacePressureForceField pressure="60"/>')
    X = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)

    def held(x, v):
        return -50 * (x - X), -50 * np.eye(12)
    expected = euler(X, np.eye(4), together(gravity(np.ones(4), [0, -10, 0]), held, halves_of_quads([(0, 1, 2, 3)], 60)), 20, 0.01)
    agree(Run(scene, 20).x(), expected, 1e-9)
    differ(Run(scene, 20, args=["--without-quirk", "split-quads"]).x(), expected, 1e-3)
    # where the way makes no difference it is not said to make one
    for mesh, quads in (('MeshTopology position="0 0 0  1 0 0  1 1 0  0 1 0" triangles="0 1 2  0 2 3"', False),
                        ('TriangleSetTopologyContainer position="0 0 0  1 0 0  1 1 0  0 1 0" triangles="0 1 2  0 2 3"', False),
                        ('RegularGridTopology n="2 2 1" min="0 0 0" max="1 1 0"', True)):
        run = Run(root(EXACT + f'<{mesh}/><MechanicalObject name="dofs"/><UniformMass totalMass="4"/><SurfacePressureForceField '
                       'pressure="60"/>'), 1)
        assert run.code == 0 and ("split-quads" in run.text) == quads, run.text


def mirrored_cut():
    """Cell 0 0 0 of a grid is mirrored in x, because its x index is even."""
    h = list(CORNERS)
    for a, b in ((0, 1), (3, 2), (4, 5), (7, 6)):
        h[a], h[b] = h[b], h[a]
    six = [(0, 5, 1, 6), (0, 1, 3, 6), (1, 3, 6, 2), (6, 3, 0, 7), (6, 7, 0, 5), (7, 5, 4, 0)]
    return [tuple(h[i] for i in cell) for cell in six]


@case
def quirk_local_dilatation_and_the_cut_of_a_grid():
    scene = root(EXACT + '<RegularGridTopology n="2 2 2" min="0 0 0" max="1 1 1"/><MechanicalObject name="dofs"/>'
                 '<UniformMass totalMass="8"/><TetrahedronFEMForceField method="small" youngModulus="500" poissonRatio="0.48"/>'
                 '<FixedConstraint indices="0 1 2"/>')
    fields = together(gravity(np.ones(8), [0, -10, 0]), tetrahedra(mirrored_cut(), CUBE, 500, 0.48))
    expected = euler(CUBE, np.eye(8), fields, 10, 0.01, held=[0, 1, 2])
    agree(Run(scene, 10).x(), expected, 1e-8)
    differ(Run(scene, 10, args=["--without-quirk", "local-dilatation"]).x(), expected, 1e-6)


@case
def frames_of_the_cut_of_a_grid():
    """Method large has the axes of the first three nodes: those of mirrored cells are the mirrored ones, in their order."""
    n = (3, 2, 3)
    X = np.array([[i, j, k] for k in range(n[2]) for j in range(n[1]) for i in range(n[0])]) * [0.5, 0.6, 0.7]
    number = {place: i for i, place in enumerate((i, j, k) for k in range(n[2]) for j in range(n[1]) for i in range(n[0]))}
    cells = []
    for k, j, i in itertools.product(*(range(m - 1) for m in n[::-1])):
        mirrored = np.array([i % 2 == 0, j % 2 == 1, k % 2 == 1])
        h = [number[tuple(np.where(mirrored, 1 - np.array(place), place) + [i, j, k])] for place in CUBE_PLACES]
        cells += [tuple(h[m] for m in cell) for cell in
                  ((0, 5, 1, 6), (0, 1, 3, 6), (1, 3, 6, 2), (6, 3, 0, 7), (6, 7, 0, 5), (7, 5, 4, 0))]
    held = [i for i, x in enumerate(X) if x[2] == 0]
    scene = root(EXACT + '<RegularGridTopology n="3 2 3" min="{} 0 0" max="{} 0.6 1.4"/><MechanicalObject name="dofs"/><UniformMass '
                 'totalMass="18"/><TetrahedronFEMForceField method="{}" youngModulus="300" poissonRatio="0.3"/><FixedConstraint '
                 f'indices="{" ".join(map(str, held))}"/>')
    ways = (("small", lambda now, then: np.eye(3)), ("polar", edge_polar), ("svd", edge_polar),
            ("large", lambda now, then: frame(np.vstack([[0, 0, 0], now.T])) @ frame(np.vstack([[0, 0, 0], then.T])).T))
    for (method, turn), (low, high) in itertools.product(ways, ((0, 1), (1, 0))):  # the second runs the other way
        Y = X * [high - low, 1, 1] + [low, 0, 0]
        fields = together(gravity(np.ones(18), [3, -10, 0]), tetrahedra(cells, Y, 300, 0.3, turn))
        expected = euler(Y, np.eye(18), fields, 20, 0.01, held=held)
        agree(Run(scene.format(low, high, method).replace('gravity="0 -10 0"', 'gravity="3 -10 0"'), 20).x(), expected, 1e-9)


@case
def directions_that_an_isotropic_law_does_not_read():
    def body(more):
        return root(EXACT + '<MeshTopology position="0 0 0  1 0 0  0 1 0  0 0 1" tetrahedra="0 1 2 3"/><MechanicalObject name="dofs"/>'
                    '<UniformMass totalMass="4"/><FixedConstraint indices="0 1"/><TetrahedronHyperelasticityFEMForceField '
                    f'materialName="StVenantKirchhoff" ParameterSet="100 200" {more}/>')
    run = Run(body('AnisotropyDirections="0 0 0"'), 5)
    agree(run.x(), Run(body(""), 5).x())
    run.says("AnisotropyDirections of an isotropic law")


@case
def plasticity_of_tetrahedra():
    """Small strains: e = 6 V eps, creep and limit at each force evaluation, the stress from e - e_p, the tangent unchanged."""
    young, nu, yields, most, creep = 300, 0.3, 0.02, 0.5, 0.3
    scene = root(EXACT + f'<MeshTopology position="{X4_TEXT}" tetrahedra="0 1 2 3"/><MechanicalObject name="dofs"/>'
                 f'<UniformMass totalMass="4"/><TetrahedronFEMForceField method="small" youngModulus="{young}" poissonRatio="{nu}" '
                 f'plasticMaxThreshold="{most}" plasticYieldThreshold="{yields}" plasticCreep="{creep}"/><FixedConstraint indices="0"/>')
    elastic = tetrahedra([(0, 1, 2, 3)], X4, young, nu)
    then = (X4[1:] - X4[0]).T
    G = np.vstack([[0, 0, 0], np.linalg.inv(then)])
    G[0] = -G[1:].sum(axis=0)
    B = np.zeros((6, 12))
    for i, (a, b, c) in enumerate(G):
        B[:, 3 * i:3 * i + 3] = [[a, 0, 0], [0, b, 0], [0, 0, c], [b, a, 0], [0, c, b], [c, 0, a]]
    V = abs(np.linalg.det(then)) / 6
    kept = np.zeros(6)

    def plastic(x, v):  # one evaluation per step
        nonlocal kept
        f, K = elastic(x, v)
        e = 6 * V * B @ (x - X4).ravel()
        if np.linalg.norm(e - kept) > yields:
            kept = kept + creep * (e - kept)
        if np.linalg.norm(kept) > most:
            kept = kept * most / np.linalg.norm(kept)
        return f + (V * B.T @ stiffness(young, nu) @ (kept / (6 * V))).reshape(4, 3), K
    expected = euler(X4, np.eye(4), together(gravity(np.ones(4), [0, -10, 0]), plastic), 30, 0.01, held=[0])
    assert np.linalg.norm(kept) > 0.3 * most, "nothing yields"
    agree(Run(scene, 30).x(), expected, 1e-7)
    for method in ("large", "polar"):
        soft = Run(scene.replace('"small"', f'"{method}"'), 30)
        hard = Run(scene.replace('"small"', f'"{method}"').replace(f'plasticMaxThreshold="{most}"', 'plasticMaxThreshold="0"'), 30)
        differ(soft.x(), hard.x(), 1e-3)


@case
def cells_too_small_to_count():
    """A width that gives more cells than there are numbers is no grid of two nodes."""
    shell = 'position="0 0 0  1 0 0  0 1 0  0 0 1" triangles="0 2 1  0 1 3  1 2 3  2 0 3"'
    for width in ("1e-300", "1e-9", "1e-3"):
        Run(node(EXACT + f'<SparseGridTopology {shell} cellWidth="{width}"/><MechanicalObject/><UniformMass/>'), 1).fails(2, "too many cells")
    far = Run(node(EXACT + '<SparseGridTopology n="3 3 3" min="0 0 0" max="1e-6 1e-6 1e-6" position="0 0 0  1e9 0 0  0 1e9 0  0 0 1e9" '
                   'triangles="0 2 1  0 1 3  1 2 3  2 0 3"/><MechanicalObject name="dofs"/><UniformMass/>'), 1)
    assert len(far.x()) == 26, far.text  # of eight cells those that three planes meet


@case
def lists_of_materials_that_are_too_short():
    """Cells beyond the end take the first value."""
    grid = ('<RegularGridTopology n="4 2 2" min="0 0 0" max="3 1 1"/><MechanicalObject name="dofs"/><UniformMass totalMass="1"/>'
            '<FixedConstraint indices="0 4 8 12"/>')
    bar = lambda values, more="": grid + f'<HexahedronFEMForceField youngModulus="{values}" poissonRatio="0.3" {more}/>'
    run = Run(root(EXACT + bar("500 900")), 10)
    run.says("youngModulus has 2 values for 3 cells: the others take the first")
    agree(run.x(), Run(root(EXACT + bar("500 900 500")), 10).x(), 1e-14)
    differ(run.x(), Run(root(EXACT + bar("500 900 900")), 10).x(), 1e-4)
    agree(Run(root(EXACT + bar("500 900 500 7 7")), 10).x(), run.x(), 1e-14)
    Run(root(EXACT + bar("500 900")), 1, args=["--dialect", "native"]).fails(2, "youngModulus has 2 values")
    sheet = ('<RegularGridTopology n="3 2 1" min="0 0 0" max="2 1 0"/><MechanicalObject name="dofs"/><UniformMass totalMass="1"/>'
             '<FixedConstraint indices="0 3"/><TriangularFEMForceField poissonRatio="0.3" youngModulus="{}"/>')
    agree(Run(root(EXACT + sheet.format("50 90")), 5).x(), Run(root(EXACT + sheet.format("50 90 50 50")), 5).x(), 1e-14)


@case
def stress_of_elements_is_written():
    grid = ('<RegularGridTopology n="2 2 2" min="0 0 0" max="1 1 1"/><MechanicalObject name="dofs"/><UniformMass totalMass="1"/>'
            '<HexahedronFEMForceField name="fem" youngModulus="1000"/>')
    out = '<VTKExporter filename="out" cellsDataFields="fem.vonMisesPerElement" pointsDataFields="fem.vonMisesPerNode"/>'
    run = Run(root(EXACT + grid + out), 2)
    assert run.code == 0, run.text
    run.says("the stress of nodes")


@case
def moduli_of_groups():
    """Two tetrahedra of two groups: of both ways, and of one without a modulus, as of moduli that are written."""
    body = ('<MeshTopology name="mesh" position="0 0 0  1 0 0  0 1 0  0 0 1  1 1 1" tetrahedra="0 1 2 3  1 2 3 4"/><MechanicalObject '
            'name="dofs"/><UniformMass totalMass="5"/><TetrahedronFEMForceField youngModulus="{}" poissonRatio="0.3" method="small"/>'
            '<FixedConstraint indices="0 1 2"/>')

    def end(moduli, engine=""):
        return Run(root(EXACT + engine + body.format(moduli)), 10).x()
    made = "@e.youngModulus"
    wanted, other = end("500 2000"), end("10000 2000")
    differ(wanted, other, 1e-6)
    agree(end(made, '<GroupFilterYoungModulus name="e" groups="4 3" mapGroupModulus="3 2e3; 4 500;"/>'), wanted, 1e-12)
    agree(end(made, '<GroupFilterYoungModulus name="e" groups="4 3" groupModulus="500 2000"/>'), wanted, 1e-12)
    agree(end(made, '<GroupFilterYoungModulus name="e" elementsGroup="0 1" mapGroupModulus="0 500;1 2000;"/>'), wanted, 1e-12)
    agree(end(made, '<GroupFilterYoungModulus name="e" groups="4 3" mapGroupModulus="3 2e3;"/>'), other, 1e-12)
    Run(root(EXACT + '<GroupFilterYoungModulus name="e" groups="4 3" mapGroupModulus="3 2e3"/>' + body.format(made)), 1).fails(2, "semicolon")


@case
def parts_of_files_and_laws_that_count_for_nothing():
    """Directions of a law that has none, a mesh of points alone, a document type."""
    law = (EXACT + '<MeshTopology position="0 0 0  1 0 0  0 1 0  0 0 1" tetrahedra="0 1 2 3"/><MechanicalObject name="dofs"/><UniformMass '
           'totalMass="4"/><StandardTetrahedralFEMForceField materialName="StVenantKirchhoff" ParameterSet="300 200" {}/><FixedConstraint indices="0"/>')
    run = Run(root(law.format('AnisotropyDirections="1 0 0"')), 10)
    run.says("AnisotropyDirections of an isotropic law")
    agree(run.x(), Run(root(law.format("")), 10).x(), 1e-14)
    points = {"points.obj": "v 1 2 3\nv 4 5 6\n"}
    bare = '<MeshOBJLoader name="l" filename="points.obj"/>' + EXACT + '<MechanicalObject name="dofs" src="@l"/><UniformMass totalMass="1"/>'
    agree(Run(node(bare), 1, points).x(), [[1, 2, 3], [4, 5, 6]])
    Run(node(bare), 1, points, name="native.xml").fails(2, "no cell")
    falls(Run('<?xml version="1.0"?>\n<!DOCTYPE Node>\n' + root(EXACT + BODY), 10))


def polar_factor(a):
    u, _, v = np.linalg.svd(a)
    return u @ np.diag([1, 1, np.linalg.det(u @ v)]) @ v


def clusters_of(x, pairs, number, radius):
    """Farthest nodes along pairs (Dijkstra over the whole matrix), their nearest nodes with neighbours, and what lies near."""
    n = len(x)
    way = np.full((n, n), np.inf)
    np.fill_diagonal(way, 0)
    for a, b in pairs:
        way[a, b] = way[b, a] = np.linalg.norm(x[a] - x[b])
    for k in range(n):
        way = np.minimum(way, way[:, k:k + 1] + way[k])
    chosen = [0]
    while len(chosen) < number:
        chosen.append(int(np.argmax(way[chosen].min(axis=0).round(12))))
    owner = way[chosen].round(12).argmin(axis=0)
    around = [{b if a == i else a for a, b in pairs if i in (a, b)} for i in range(n)]
    groups = []
    for g, middle in enumerate(chosen):
        group, waiting = {middle}, [middle]
        while waiting:
            node = waiting.pop()
            for other in around[node] - group:
                if owner[node] == g or np.linalg.norm(x[other] - x[middle]) < radius:
                    group.add(other)
                    waiting.append(other)
        groups.append(sorted(group))
    return groups


@case
def shapes_that_are_matched():
    """v += h g, x += h v, then x goes part of the way to the mean of the shapes of its groups, and v with it."""
    rest = np.array([[i, j, k] for k in range(2) for j in range(3) for i in range(4)], float)
    cells = [(i + 4 * j, i + 1 + 4 * j, i + 5 + 4 * j, i + 4 + 4 * j) for j in range(2) for i in range(3)]
    pairs = {tuple(sorted(p)) for c in cells for p in zip(c + tuple(n + 12 for n in c), c[1:] + c[:1] + tuple(n + 12 for n in c[1:] + c[:1]))}
    pairs |= {(i, i + 12) for i in range(12)}
    for number, radius, s, ratio, iterations in ((3, 1.5, 1, 0, 1), (4, 0.1, 0.6, 0.25, 2), (1, 9, 0.5, 0, 1)):
        scene = root('<EulerExplicitSolver/><RegularGridTopology n="4 3 2" min="0 0 0" max="3 2 1"/><MechanicalObject name="dofs"/><UniformMass '
                     'totalMass="24"/><ConstantForceField indices="0 23" force="0 200 300"/>'
                     f'<ClusteringEngine name="c" radius="{radius}" number="{number}" position="@dofs.rest_position"/>'
                     f'<ShapeMatching name="sm" iterations="{iterations}" affineRatio="{ratio}" position="@dofs.position" cluster="@c.cluster"/>'
                     f'<PositionBasedDynamicsConstraint stiffness="{s}" position="@sm.targetPosition"/>')
        groups = clusters_of(rest, pairs, number, radius)
        x, v, force = rest.copy(), np.zeros_like(rest), np.zeros_like(rest)
        force[[0, 23]] = 0, 200, 300
        for _ in range(10):
            old = x
            v = v + 0.01 * (force + [0, -10, 0])
            x = goal = x + 0.01 * v
            for _ in range(iterations):
                sums, counts = np.zeros_like(x), np.zeros(24)
                for group in groups:
                    X, p = rest[group] - rest[group].mean(axis=0), goal[group] - goal[group].mean(axis=0)
                    T = (1 - ratio) * polar_factor(p.T @ X) + ratio * p.T @ X @ np.linalg.pinv(X.T @ X)
                    sums[group] += goal[group].mean(axis=0) + X @ T.T
                    counts[group] += 1
                goal = np.where(counts[:, None] > 0, sums / np.maximum(counts, 1)[:, None], x)
            x = x + s * (goal - x)
            v = (x - old) / 0.01
        agree(Run(scene, 10).x(), x, 1e-9)
    held = Run(scene.replace("<ClusteringEngine", '<FixedConstraint indices="5"/><ClusteringEngine'), 10)
    agree(held.x()[5], rest[5])
    held.says("here they stay where they are held")
    Run(scene.replace("position=\"@dofs.position\"", 'position="@dofs.position" fixedPosition="0 0 0"'), 1).fails(2, "with fixed points")
    goal = root(EXACT + '<MechanicalObject name="dofs" position="0 0 0"/><UniformMass totalMass="1"/><PositionBasedDynamicsProjectiveConstraint '
                'stiffness="0.5" position="1 0 0"/>', 'gravity="0 0 0"')
    x, v = 0.0, 0.0
    for _ in range(10):
        new = x + 0.01 * v
        new += 0.5 * (1 - new)
        x, v = new, (new - x) / 0.01
    agree(Run(goal, 10).x(), [[x, 0, 0]])


def tait(p0, bulk, gamma, injected, faces, rest, rate=1000.0, h=0.01):
    """Pressure behind a closed surface with what comes in until the end of each step."""
    def volume(x):
        return sum(np.linalg.det(x[list(face)]) for face in faces) / 6
    count = itertools.count(1)

    def field(x, v):
        v0, now = volume(rest) + min(injected, rate * h * next(count)), volume(x)
        g, H = np.zeros(x.shape), np.zeros((x.size, x.size))
        for a, b, c in (face[i:] + face[:i] for face in faces for i in range(3)):
            g[a] += np.cross(x[b], x[c]) / 6
            H[3 * a:3 * a + 3, 3 * b:3 * b + 3] += np.cross(np.eye(3), x[c]).T / 6  # of x_b cross x_c by x_b
            H[3 * a:3 * a + 3, 3 * c:3 * c + 3] += np.cross(x[b], np.eye(3)).T / 6
        p = p0 - bulk * ((now / v0) ** gamma - 1)
        fall = -bulk * gamma * (now / v0) ** gamma / now
        return p * g, p * H + fall * np.outer(g.ravel(), g.ravel())
    return field


@case
def content_of_a_surface():
    """The tangent knows how the pressure falls where the volume grows, with products and with a matrix; volume comes in at a rate."""
    rest = np.array([[0, 0, 0], [1.0, 0, 0], [0, 1.2, 0], [0.1, 0, 0.9]])
    faces = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)]
    for more, rate in (('', 1000.0), ('maxInjectionRate="0.8"', 0.8)):
        for solver in (EXACT, '<EulerImplicitSolver/><CGLinearSolver iterations="200" tolerance="1e-14" threshold="0"/>'):
            scene = node(solver + f'<MeshTopology position="{" ".join(map(str, rest.ravel()))}" triangles='
                         f'"{" ".join(str(corner) for face in faces for corner in face)}"/>' + '<MechanicalObject name="dofs"/><UniformMass '
                f'totalMass="0.4"/><TaitSurfacePressureForceField p0="3" B="20" gamma="1.4" injectedVolume="0.06" {more}/>')
            x = euler(rest, 0.1 * np.eye(4), tait(3, 20, 1.4, 0.06, faces, rest, rate), 10, 0.01)
            agree(Run(scene, 10).x(), x, 1e-9)


def cube_stiffness(size, lam, mu):
    """Of a cube with eight corners, from integrals of products of shape functions: along an axis those of N N, N' N and N' N'."""
    mass, slope, bend = np.array([[2, 1], [1, 2]]) / 6, np.array([[-1, -1], [1, 1]]) / 2, np.array([[1, -1], [-1, 1]])

    def integral(a, b, i, j):
        value = 1.0
        for axis in range(3):
            at = CUBE_PLACES[a][axis], CUBE_PLACES[b][axis]
            value *= (bend[at] if i == j == axis else slope[at] if i == axis else slope.T[at] if j == axis else mass[at])
        return size * value
    K = np.zeros((24, 24))
    for a, b, i, j in itertools.product(range(8), range(8), range(3), range(3)):
        K[3 * a + i, 3 * b + j] = lam * integral(a, b, i, j) + mu * integral(a, b, j, i)
        if i == j:
            K[3 * a + i, 3 * b + j] += mu * sum(integral(a, b, k, k) for k in range(3))
    return K


def condensed(factors, size, lam, mu):
    """factors[z, y, x] of the parts of a cube: eight children in one, of which the empty ones are rigid where the others yield."""
    n = len(factors)
    if n == 1:
        return factors[0, 0, 0] * cube_stiffness(size, lam, mu)
    h = n // 2
    filled, yields = np.zeros((81, 81)), np.zeros((81, 81))
    for at in CUBE_PLACES:
        part = factors[tuple(slice(h * at[k], h * at[k] + h) for k in (2, 1, 0))]
        K = condensed(part, size / 2, lam, mu)
        rows = [3 * sum((at[k] + corner[k]) * 3 ** k for k in range(3)) + i for corner in CUBE_PLACES for i in range(3)]
        filled[np.ix_(rows, rows)] += K
        yields[np.ix_(rows, rows)] += K if part.any() else cube_stiffness(size / 2, 0, 1e7 * (lam + 2 * mu) / 2)
    corner = [3 * sum(2 * c[k] * 3 ** k for k in range(3)) + i for c in CUBE_PLACES for i in range(3)]
    others = [i for i in range(81) if i not in corner]
    W = np.zeros((81, 24))
    W[corner] = np.eye(24)
    W[others] = -np.linalg.solve(yields[np.ix_(others, others)], yields[np.ix_(others, corner)])
    for row in range(81):
        place = [row // 3 // 3 ** k % 3 for k in range(3)]
        for a, i in itertools.product(range(8), range(3)):
            if i != row % 3 or any(place[k] not in (1, 2 * CUBE_PLACES[a][k]) for k in range(3)):
                W[row, 3 * a + i] = 0
        W[row] /= W[row].sum()
    return W.T @ filled @ W


@case
def cells_of_parts_that_yield():
    """A cube of 64 parts, an eighth of it empty, small strains; and SOFA's field on a grid is that field and a mass."""
    factors = np.array([0.2 + (3 * i + 5 * j + 7 * k) % 4 for k in range(4) for j in range(4) for i in range(4)]).reshape(4, 4, 4)
    factors[2:, 2:, :2] = 0
    lam, mu = 2000 * 0.3 / (1.3 * 0.4), 2000 / 2.6
    rest = np.array([[i, j, k] for k in (0, 2.0) for j in (0, 2.0) for i in (0, 2.0)])
    order = np.array([2 * (c[0] + 2 * c[1] + 4 * c[2]) // 2 for c in CUBE_PLACES])
    K = np.zeros((24, 24))
    rows = (3 * order[:, None] + np.arange(3)).ravel()
    K[np.ix_(rows, rows)] = condensed(factors, 2.0, lam, mu)

    def field(x, v):
        return -(K @ (x - rest).ravel()).reshape(-1, 3), -K
    held = [0, 2, 4, 6]
    scene = ('<Node name="root" dt="0.02" gravity="0 -10 3"><EulerImplicitSolver newtonIterations="1"/><SparseLDLSolver/>'
             '<RegularGridTopology n="2 2 2" min="0 0 0" max="2 2 2"/><MechanicalObject name="dofs"/><UniformMass totalMass="8"/>'
             '<FixedProjectiveConstraint indices="0 2 4 6"/>'
             '<HexahedronCompositeFEMForceField method="small" youngModulus="2000" poissonRatio="0.3" partFactors="'
             + " ".join(f"{s:.17g}" for s in factors.ravel()) + '"/></Node>')
    x = euler(rest, np.eye(8), together(field, gravity(np.ones(8), (0, -10, 3))), 8, 0.02, held=held)
    assert abs(x - rest).max() > 0.01
    agree(Run.of_native(scene, 8).x(), x, 1e-7)

    surface = 'position="0 0 0  1 0 0  0 1 0  0 0 1" triangles="0 2 1  0 1 3  1 2 3  2 0 3"'
    grid = f'<SparseGridTopology name="grid" n="3 3 3" nbVirtualFinerLevels="2" {surface} %s/><MechanicalObject name="dofs"/>'
    hold = '<FixedProjectiveConstraint indices="0 1"/>'
    solver = '<EulerImplicitSolver %s/><SparseLDLSolver/>'
    foreign = Run(root(solver % "" + grid % "" + '<HexahedronCompositeFEMForceFieldAndMass method="large" youngModulus="2000" '
                       'poissonRatio="0.3" density="2" nbVirtualFinerLevels="2" drawType="1"/>' + hold), 8)
    mass = '<MeshMatrixMass massDensity="2" matrix="pairs" computeMassOnRest="true" cellFactors="@grid.partFactors"/>'
    native = Run.of_native(root(solver % 'newtonIterations="1"' + grid % 'partLevels="2"' + mass + '<HexahedronCompositeFEMForceField '
                      'method="large" youngModulus="2000" poissonRatio="0.3" partFactors="@grid.partFactors"/>' + hold), 8)
    agree(foreign.x(), native.x(), 1e-12)
    foreign.says("follow the weights of its parts")


@case
def angles_that_choose_among_cells():
    """A SphereROI's normal and angles count for edges and triangles: where nodes alone are asked for they do nothing."""
    scene = ('<RegularGridTopology name="grid" n="3 3 1" min="0 0 0" max="2 2 0"/><MechanicalObject name="dofs"/><UniformMass totalMass="9"/>'
             '<SphereROI name="roi" centers="0 0 0" radii="1.1" normal="0 0 1" edgeAngle="30" triAngle="20"/>'
             '<FixedProjectiveConstraint indices="@roi.indices"/>{}')
    run = Run(root(EXACT + scene.format("")), 10)
    y = np.repeat([0.0, 1.0, 2.0], 3) + fallen(10)
    y[[0, 1, 3]] = 0, 0, 1
    agree(run.x()[:, 1], y)


@case
def quirk_fixed_fibres():
    """Costa's energy in the axes of space, differentiated by complex steps; SOFA's law reads no directions."""
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.2, 0.1, 1]])
    x = corners @ np.array([[1.1, 0.2, 0], [0, 0.95, 0.1], [0.05, 0, 1.2]])
    a, k0, bff, bfs, bss, bfn, bsn, bnn = values = 50, 300, 4, 1.5, 2, 1.2, 0.8, 3
    B = np.array([[bff, bfs, bfn], [bfs, bss, bsn], [bfn, bsn, bnn]])
    rest = (corners[1:] - corners[0]).T

    def energy(x, axes):
        F = (x[1:] - x[0]).T @ np.linalg.inv(rest)
        J = np.linalg.det(F)
        E = axes @ (F.T @ F - np.eye(3)) @ axes.T / 2
        return np.linalg.det(rest) / 6 * (a / 2 * (np.exp(J ** (-4 / 3) * np.sum(B * E * E)) - 1) + k0 * (J * np.log(J) - J + 1))

    def stepped(axes):
        f = np.zeros((4, 3))
        for i in np.ndindex(4, 3):
            y = x.astype(complex)
            y[i] += 1e-30j
            f[i] = -energy(y, axes).imag / 1e-30
        return x + 1e-4 * f

    def scene(directions):
        list_of = [" ".join(str(c) for c in np.ravel(p)) for p in (x, corners)]
        return node(f'<EulerExplicitSolver/><MeshTopology position="{list_of[1]}" tetrahedra="0 1 2 3"/><MechanicalObject name="dofs" '
                    f'position="{list_of[0]}" rest_position="{list_of[1]}"/><UniformMass totalMass="4"/><TetrahedronHyperelasticityFEMForceField '
                    f'materialName="Costa" ParameterSet="{" ".join(map(str, values))}" {directions}/>')
    turned = np.array([[0, 1, 0], [0, 0, 1], [1, 0, 0]])
    in_space = stepped(np.eye(3)) - x
    for directions in ("", 'AnisotropyDirections="1 0 0"', 'AnisotropyDirections="0 1 0"', 'AnisotropyDirections="0 1 0  0 0 1"'):
        run = Run(scene(directions), 1)
        agree(run.x() - x, in_space, 1e-9)
    run.says("fixed-fibres: Costa's law has its fibre along x")
    agree(Run(scene(directions), 1, args=["--without-quirk", "fixed-fibres"]).x() - x, stepped(turned) - x, 1e-9)


@case
def plasticity_of_turned_tetrahedra():
    """Large and polar: strains in the axes of each element, which turns; two of them that move far. The norms that are compared with
    the thresholds are of these axes, so that they depend on the order of nodes; the last cell is inside out. Cells that do not start at rest
    yield in the first step."""
    young, nu, creep = 300, 0.3, 0.3
    X = np.array([[0, 0, 0], [1, 0.1, 0], [0.2, 1.1, 0], [0.1, 0.3, 0.9], [1, 1, 1.2]])
    v = np.array([[0, 0, 0], [0, 3, 1], [-3, 0, 2], [2, -1, 0], [1, 2, -3.0]])
    D = stiffness(young, nu)

    def field_of(axes, cells, yields, most):
        kept = [np.zeros(6) for _ in cells]

        def field(x, v):
            f, K = np.zeros_like(x), np.zeros((x.size, x.size))
            for i, cell in enumerate(cells):
                rest, now = X[list(cell)], x[list(cell)]
                R0, R = axes(rest), axes(now)
                local, moved = rest @ R0, now @ R
                then = (local[1:] - local[0]).T
                G = np.vstack([[0, 0, 0], np.linalg.inv(then)])
                G[0] = -G[1:].sum(axis=0)
                B = np.zeros((6, 12))
                for n, (a, b, c) in enumerate(G):
                    B[:, 3 * n:3 * n + 3] = [[a, 0, 0], [0, b, 0], [0, 0, c], [b, a, 0], [0, c, b], [c, 0, a]]
                V = abs(np.linalg.det(then)) / 6
                e = 6 * V * B @ (moved - local).ravel()
                if np.linalg.norm(e - kept[i]) > yields:
                    kept[i] = kept[i] + creep * (e - kept[i])
                if np.linalg.norm(kept[i]) > most:
                    kept[i] = kept[i] * most / np.linalg.norm(kept[i])
                T = np.kron(np.eye(4), R)
                where = np.ravel([[3 * n, 3 * n + 1, 3 * n + 2] for n in cell])
                f.ravel()[where] -= T @ (V * B.T @ D @ (e - kept[i]) / (6 * V))
                K[np.ix_(where, where)] -= T @ (V * B.T @ D @ B) @ T.T
            return f, K
        return field
    ways = (("small", lambda x: np.eye(3)), ("large", frame), ("polar", lambda x: polar((x[1:] - x[0]).T)))
    cases = (([(0, 1, 2, 3), (1, 2, 3, 4)], 0.02, 0.9), ([(0, 1, 2, 3), (3, 1, 2, 4)], 1e-4, 0.05), ([(2, 1, 3, 0), (1, 2, 4, 3)], 1e-4, 0.05))
    stretched = X * [1.05, 0.97, 1.1]
    for (method, axes), (cells, yields, most), start in itertools.product(ways, cases, (X, stretched)):
        listed = " ".join(str(n) for cell in cells for n in cell)
        scene = node(EXACT + f'<MeshTopology position="{numbers_of(X)}" tetrahedra="{listed}"/><MechanicalObject name="dofs" '
                     f'rest_position="{numbers_of(X)}" position="{numbers_of(start)}" velocity="{numbers_of(v)}"/><UniformMass '
                     f'totalMass="5"/><TetrahedronFEMForceField method="{method}" youngModulus="{young}" '
                     f'poissonRatio="{nu}" plasticMaxThreshold="{most}" plasticYieldThreshold="{yields}" plasticCreep="{creep}"/>'
                     '<FixedConstraint indices="0"/>')
        agree(Run(scene, 12).x(), euler(start, np.eye(5), field_of(axes, cells, yields, most), 12, 0.01, v=v, held=[0]))


main()
