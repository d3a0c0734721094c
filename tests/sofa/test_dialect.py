# SPDX-License-Identifier: LGPL-2.1-or-later
"""Scenes in SOFA's dialect against closed forms and reference.py. Usage: test_dialect.py STROMA [WORD].

Where STROMA_TEST_SCENES names a folder, the scenes that leave a way of SOFA out are kept there: docs/plots/quirk_pictures.py draws them."""
import itertools
import os
import re
import tempfile

import numpy as np

from dialect import BODY, EXACT, FALL, RUNS, STROMA, Run, agree, case, differ, fallen, falls, main, node, root
from reference import (axes_of, edge_polar, euler, euler_frames, fibres, first_end_beams, frame, gravity, hexahedra, inverse, load,
                       membrane, multistep, polar, prisms, product, rotation_vector, springs, stiffness, tetrahedra, together, turn_of)


# ---- reading ----

@case
def free_fall_without_an_animation_loop():
    falls(Run(root(EXACT + BODY), 10))


@case
def dialect_on_the_command_line_and_on_the_node():
    falls(Run(root(EXACT + BODY + '<NaturalOrderingMethod/>'), 10, name="a.xml", args=["--dialect", "sofa"]))
    falls(Run(root(EXACT + BODY + '<NaturalOrderingMethod/>', FALL + ' dialect="sofa"'), 10, name="a.xml"))
    Run(root(EXACT + BODY + '<NaturalOrderingMethod/>'), 1, name="a.xml").fails(2, "NaturalOrderingMethod")
    Run(root(EXACT + BODY, FALL + ' dialect="sofia"'), 1, name="a.xml").fails(2, "is no dialect")


@case
def quirk_child_gravity():
    scene = root(f'<Node name="child" gravity="0 -1 0" dt="0.5">{EXACT}{BODY}</Node>')
    falls(Run(scene, 10), "child.dofs")
    falls(Run(scene, 10, args=["--without-quirk", "child-gravity"]), "child.dofs", g=1)


@case
def gravity_component():
    falls(Run(root(f'<Node name="child"><Gravity gravity="0 -3 0"/>{EXACT}{BODY}</Node>'), 10), "child.dofs", g=3)


@case
def prefab_beside_the_scene_and_on_the_data_path():
    prefab = '<Node name="Group"><EulerImplicitSolver rayleighMass="0.1"/><SparseLDLSolver/></Node>'
    decay = np.cumsum(list(itertools.accumulate([0.0] * 10, lambda v, _: (v - 0.1) / 1.001, initial=0.0)))[-1] * 0.01
    for place in ("Objects/Mine.xml", "data/Objects/Mine.xml"):
        run = Run(root("<Mine/>" + BODY), 10, {place: prefab})
        agree(run.x()[:, 1], [decay, decay])


@case
def prefab_of_a_name_that_was_removed():
    prefab = '<Node name="Group"><BoxROI name="box" box="-1 -1 -1 1 1 1"/><FixedProjectiveConstraint indices="@box.indices"/></Node>'
    run = Run(root(EXACT + BODY + '<BoxConstraint box="0.5 -1 -1 2 1 1"/>'), 10, {"Objects/BoxConstraint.xml": prefab})
    agree(run.x()[:, 1], [fallen(10), 0])


@case
def include_with_overrides():
    part = f'<Node name="part"><EulerImplicitSolver name="ode" rayleighMass="7"/><SparseLDLSolver/>{BODY}</Node>'
    run = Run(root('<include href="part.xml" name="mine" ode__rayleighMass="0" nobody="3"/>'), 10, {"part.xml": part})
    falls(run, "mine.dofs")
    run.says("nobody", "dropped")


@case
def include_of_a_group_and_a_merge():
    falls(Run(root('<include href="g.xml" name="other"/>' + BODY), 10, {"g.xml": f'<Group>{EXACT}</Group>'}))
    merge = '<Node name="_Merge_"><MechanicalObject name="dofs" position="5 0 0"/></Node>'
    agree(Run(root(EXACT + BODY + '<include href="m.xml"/>', 'gravity="0 0 0"'), 1, {"m.xml": merge}).x(), [[5, 0, 0]])


@case
def object_and_attribute_elements():
    falls(Run(root(EXACT + '<Object type="MechanicalObject" name="dofs"><Attribute type="position">0 0 0</Attribute></Object>'
                   '<UniformMass totalMass="1"/>'), 10))


@case
def links_by_place_by_number_and_to_the_first_of_two_names():
    scene = root('<MeshTopology position="0 0 0  3 0 0" edges="0 1"/><MeshTopology position="9 9 9" name="twin"/>'
                 '<MeshTopology position="8 8 8" name="twin"/>'
                 f'<Node name="a">{EXACT}<MechanicalObject name="dofs" position="@../MeshTopology1.position"/>'
                 '<UniformMass totalMass="1"/></Node>'
                 f'<Node name="b">{EXACT}<MechanicalObject name="dofs" position="@twin.position"/>'
                 '<UniformMass totalMass="1"/></Node>'
                 f'<Node name="c">{EXACT}<MeshTopology position="1 2 3"/><MechanicalObject name="dofs" position="@[-1].position"/>'
                 '<UniformMass totalMass="1"/></Node>', 'gravity="0 0 0"')
    run = Run(scene, 1)
    agree(run.x("a.dofs"), [[0, 0, 0], [3, 0, 0]])
    agree(run.x("b.dofs"), [[9, 9, 9]])
    agree(run.x("c.dofs"), [[1, 2, 3]])


@case
def values_as_a_stream_reads_them():
    scene = root('<EulerImplicitSolver trapezoidalScheme="0" firstOrder="F"/><SparseLDLSolver template="CompressedRowSparseMatrixMat3x3d"/>'
                 '<MechanicalObject name="dofs" template="Vec3d" position="[0 0 0] [1 0 0] [2 0 0] [3 0 0]" velocity="0 1 0"/>'
                 '<UniformMass totalMass="1"/><FixedConstraint indices="0-1"/>', 'gravity="0 0 0"')
    agree(Run(scene, 10).x()[:, 1], [0.1, 0.1, 0.1, 0.1])  # what is held keeps its velocity


@case
def typos_run_without_and_say_so():
    run = Run(root('<EulerImplicitSolver rayleighMas="9"/><SparseLDLSolver/>' + BODY), 10)
    falls(run)
    run.says("rayleighMas", "did you mean 'rayleighMass'")
    run = Run(root('<EulerImplicitSolver rayleighMass="much"/><SparseLDLSolver/>' + BODY), 10)
    falls(run)
    run.says("much", "keeps the default")


@case
def all_that_is_missing_at_once():
    Run(root(EXACT + BODY + '<NoSuchThing/><OtherThing/>'), 1).fails(2, "NoSuchThing", "OtherThing")


@case
def parts_without_effect():
    run = Run(root('<FreeMotionAnimationLoop/><NaturalOrderingMethod name="order"/><MatrixLinearSystem name="system"/>'
                   '<GenericConstraintSolver maxIterations="100"/><LeftMouseButtonSetting/><EulerImplicitSolver/>'
                   '<SparseLDLSolver orderingMethod="@order" linearSystem="@system"/><UncoupledConstraintCorrection/>'
                   + BODY, FALL + ' showBoundingTree="1"'), 10)
    falls(run)
    run.says("accepted without effect", "NaturalOrderingMethod", "showBoundingTree")
    Run(root('<MatrixLinearSystem assembleStiffness="0"/>' + EXACT + BODY), 1).fails(2, "assembleStiffness")


@case
def one_integrator_on_the_way_down():
    falls(Run(root(f'{EXACT}<Node name="b"><EulerExplicitSolver/>{BODY}</Node>'), 10), "b.dofs")


@case
def what_nothing_moves_stays():
    run = Run(root(f'<Node name="a">{EXACT}{BODY}</Node><Node name="b">{BODY}<FixedConstraint/></Node>'
                   f'<Node name="c" activated="0">{BODY}<Nonsense/></Node>'), 10)
    falls(run, "a.dofs")
    run.says("no integrator moves anything")


@case
def drawing_needs_no_files():
    falls(Run(root(EXACT + BODY + '<Node name="seen"><MeshOBJLoader name="loader" filename="nowhere.obj"/>'
                   '<OglModel src="@loader"/><IdentityMapping/></Node>'), 10))


@case
def other_direct_solvers():
    for solver in ("AsyncSparseLDLSolver", 'BTDLinearSolver template="BTDMatrix6d"', "EigenSimplicialLDLT"):
        falls(Run(root(f'<EulerImplicitSolver/><{solver}/>{BODY}'), 10))


@case
def explain_lists_quirks():
    run = Run(root('<EulerImplicitSolver/><CGLinearSolver name="cg"/>' + BODY), 0, command="explain")
    run.says("cg-threshold", "/cg", "--without-quirk")
    Run(root(EXACT + BODY), 1, args=["--without-quirk", "cg-treshold"]).fails(2, "cg-threshold")


# ---- quirks, each with a number ----

X4 = np.array([[0, 0, 0], [2, 0, 0], [0, 3, 0], [0, 0, 1.5]])
X4_TEXT = "0 0 0  2 0 0  0 3 0  0 0 1.5"


@case
def quirk_cg_threshold():
    springs_text = '<MeshTopology position="0 0 0  1 0 0  2 0 0  3 0 0" edges="0 1  1 2  2 3"/>'
    x = np.array([[i, 0, 0] for i in range(4)], float)
    scene = root('<EulerImplicitSolver/><CGLinearSolver iterations="20" tolerance="1e-12" threshold="1e-3"/>' + springs_text +
                 '<MechanicalObject name="dofs"/><UniformMass totalMass="4"/><MeshSpringForceField stiffness="1000"/>'
                 '<FixedConstraint indices="0"/>')
    fields = together(gravity(np.ones(4), [0, -10, 0]), springs([(0, 1), (1, 2), (2, 3)], x, 1000))
    cut = euler(x, np.eye(4), fields, 20, 0.01, held=[0], cg=(20, 1e-12, 1e-3))
    full = euler(x, np.eye(4), fields, 20, 0.01, held=[0])
    agree(Run(scene, 20).x(), cut, 1e-7)
    agree(Run(scene, 20, args=["--without-quirk", "cg-threshold"]).x(), full, 1e-7)
    differ(cut, full, 1e-6)


@case
def quirk_spring_length():
    scene = root(EXACT + f'<MeshTopology position="{X4_TEXT}" tetrahedra="0 1 2 3"/><MechanicalObject name="dofs"/>'
                 '<UniformMass totalMass="4"/><MeshSpringForceField stiffness="500"/><FixedConstraint indices="0"/>')
    pairs = list(itertools.combinations(range(4), 2))
    for args, per_length in (([], True), (["--without-quirk", "spring-length"], False)):
        fields = together(gravity(np.ones(4), [0, -10, 0]), springs(pairs, X4, 500, per_length=per_length))
        agree(Run(scene, 20, args=args).x(), euler(X4, np.eye(4), fields, 20, 0.01, held=[0]), 1e-8)


@case
def grid_springs():
    scene = root(EXACT + '<RegularGridTopology nx="2" ny="2" nz="2" xmin="0" xmax="1" ymin="0" ymax="2" zmin="0" zmax="1"/>'
                 '<MechanicalObject name="dofs"/><UniformMass vertexMass="1"/>'
                 '<RegularGridSpringForceField stiffness="300" damping="2"/><FixedConstraint indices="0"/>')
    x = np.array([[i, 2 * j, k] for k in range(2) for j in range(2) for i in range(2)], float)
    fields = together(gravity(np.ones(8), [0, -10, 0]), springs(list(itertools.combinations(range(8), 2)), x, 300, 2))
    agree(Run(scene, 20).x(), euler(x, np.eye(8), fields, 20, 0.01, held=[0]), 1e-8)


@case
def quirk_explicit_damping():
    scene = node(EXACT + '<MechanicalObject name="dofs" position="0 0 0  1 0 0" velocity="0 0 0  1 2 0"/>'
                 '<UniformMass totalMass="2"/><SpringForceField spring="0 1 50 3 1"/>')
    x, v = np.array([[0, 0, 0], [1, 0, 0.0]]), [[0, 0, 0], [1, 2, 0]]
    explicit = euler(x, np.eye(2), springs([(0, 1)], x, 50, 3), 20, 0.01, v=v)
    agree(Run(scene, 20).x(), explicit, 1e-8)
    differ(Run(scene, 20, args=["--without-quirk", "explicit-damping"]).x(), explicit, 1e-5)


@case
def quirk_explicit_damping_of_obstacles():
    scene = node(EXACT + '<MechanicalObject name="dofs" position="0 -0.1 0" velocity="0 -1 0"/><UniformMass totalMass="1"/>'
                 '<PlaneForceField normal="0 1 0" d="0" stiffness="100" damping="5"/>')

    def plane(x, v):
        g = max(-x[0, 1], 0.0)
        n = np.array([0, 1.0, 0])
        return (100 * g * n - 5 * g * v[0])[None], -100 * np.outer(n, n) * (g > 0)
    explicit = euler([[0, -0.1, 0]], [[1]], plane, 10, 0.01, v=[[0, -1, 0]])
    agree(Run(scene, 10).x(), explicit, 1e-9)
    differ(Run(scene, 10, args=["--without-quirk", "explicit-damping"]).x(), explicit, 1e-6)


@case
def quirk_explicit_damping_of_velocities():
    """Of what is damped against the ground C is asked for with implicit="1" alone."""
    scene = node(EXACT + '<MechanicalObject name="dofs" position="0 0 0" velocity="1 2 3"/><UniformMass totalMass="2"/>'
                 '<UniformVelocityDampingForceField dampingCoefficient="40"/>')
    for text, args, factor in ((scene, [], 1 - 0.01 * 40 / 2), (scene.replace('"40"', '"40" implicit="1"'), [], 1 / (1 + 0.01 * 40 / 2)),
                               (scene, ["--without-quirk", "explicit-damping"], 1 / (1 + 0.01 * 40 / 2))):
        x = np.cumsum(factor ** np.arange(1, 11))[-1] * 0.01
        agree(Run(text, 10, args=args).x(), [[x, 2 * x, 3 * x]])


@case
def quirk_edge_mass():
    x = np.array([[i, j, k] for k in range(2) for j in range(2) for i in range(2)], float)
    edges = [(a, b) for a, b in itertools.combinations(range(8), 2) if np.abs(x[a] - x[b]).sum() == 1]
    mass = np.eye(8) / 20
    for a, b in edges:
        mass[a, b] = mass[b, a] = 1 / 40
    # the matrix is not definite: a solver that does not mind
    scene = root('<EulerImplicitSolver/><EigenSparseLU/><RegularGridTopology n="2 2 2" min="0 0 0" max="1 1 1"/><MechanicalObject name="dofs"/>'
                 '<MeshMatrixMass massDensity="8"/><RestShapeSpringsForceField stiffness="100" points="0 3"/>')

    def held(x_, v):
        f, K = np.zeros_like(x_), np.zeros((24, 24))
        for n in (0, 3):
            f[n] = -100 * (x_[n] - x[n])
            K[3 * n:3 * n + 3, 3 * n:3 * n + 3] = -100 * np.eye(3)
        return f, K
    fields = together(gravity(np.full(8, 8 * 2.5 / 20), [0, -10, 0]), held)
    expected = euler(x, 8 * mass, fields, 20, 0.01)
    agree(Run(scene, 20).x(), expected, 1e-8)
    differ(Run(scene, 20, args=["--without-quirk", "edge-mass"]).x(), expected, 1e-4)


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


def node_polar(now, then):
    """Of the sum over the nodes of (x - c)(X - C)^T."""
    p, q = (np.column_stack([np.zeros(3), edges]) for edges in (now, then))
    return polar((p - p.mean(axis=1, keepdims=True)) @ (q - q.mean(axis=1, keepdims=True)).T)


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
    run.says("nothing in this law resists a change of volume", "a tension of 10")


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


@case
def a_constraint_ends_with_the_step_before_its_time():
    run = Run(root(EXACT + BODY + '<FixedConstraint indices="0" endTime="0.05"/>'), 10)
    agree(run.x()[:, 1], [fallen(5), fallen(10)])


@case
def lists_that_a_grid_has_not():
    """Tetrahedra of a grid are an empty list in SOFA, which a region reads besides others."""
    grid = '<RegularGridTopology name="grid" n="2 2 2" min="0 0 0" max="1 1 1"/><MechanicalObject name="dofs"/><UniformMass totalMass="8"/>'
    roi = ('<BoxROI name="roi" position="@grid.position" tetrahedra="@grid.tetrahedra" hexahedra="@grid.hexahedra" '
           'box="-0.1 -0.1 -0.1 0.1 2 2"/><FixedConstraint indices="@roi.indices"/>')
    run = Run(root(EXACT + grid + roi), 10)
    agree(run.x()[:, 1], [0, fallen(10), 1, 1 + fallen(10)] * 2)
    run.says("leads to a list that is empty in SOFA")
    # lists that SOFA fills: the edges of a sparse grid, and what a file holds
    surface = ('<MeshTopology name="surface" position="0 0 0  1 0 0  0 1 0  0 0 1" triangles="0 2 1  0 1 3  1 2 3  2 0 3"/>'
               '<SparseGridTopology name="grid" n="3 3 3" position="@surface.position" triangles="@surface.triangles"/>')
    net = ('<MechanicalObject name="dofs" position="@grid.position"/><UniformMass totalMass="1"/><MeshTopology name="net" '
           'position="@grid.position" edges="@grid.edges"/><MeshSpringForceField topology="@net" stiffness="100"/>')
    run = Run(root(EXACT + surface + net), 1)
    run.fails(2, "/net.edges")
    assert "is empty in SOFA" not in run.text, run.text
    mesh = ("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n7\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 1 0 1\n6 0 1 1\n7 0 0 2\n$EndNodes\n"
            "$Elements\n2\n1 6 2 0 1 1 2 3 4 5 6\n2 4 2 0 1 4 5 6 7\n$EndElements\n")
    read = ('<MeshGmshLoader name="loader" filename="prism.msh"/><MeshTopology position="@loader.position" tetrahedra="@loader.tetrahedra" '
            'prisms="@loader.prisms"/><MechanicalObject name="dofs"/><UniformMass totalMass="1"/>')
    run = Run(root(EXACT + read), 1, {"prism.msh": mesh})
    assert len(run.x()) == 7
    assert "is empty in SOFA" not in run.text, run.text


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
def quirk_trapezoidal_positions():
    scene = root('<EulerImplicitSolver trapezoidalScheme="1"/><SparseLDLSolver/>' + BODY +
                 '<RestShapeSpringsForceField stiffness="100" points="0 1"/>')
    x = np.array([[0, 0, 0], [1, 0, 0.0]])

    def held(y, v):
        return -100 * (y - x), -100 * np.eye(6)
    fields = together(gravity(np.ones(2), [0, -10, 0]), held)
    agree(Run(scene, 20).x(), euler(x, np.eye(2), fields, 20, 0.01, theta=0.5), 1e-9)
    agree(Run(scene, 20, args=["--without-quirk", "trapezoidal-positions"]).x(),
          euler(x, np.eye(2), fields, 20, 0.01, theta=0.5, textbook=True), 1e-9)


@case
def quirk_one_iteration():
    """x += -K^-1 f once in each step, from the shape that the step before left."""
    x = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0.0]])
    rest = x * 0.5
    fields = together(springs([(0, 1), (1, 2)], rest, 20, per_length=False), load({1: np.array([0, 12, 4.0])}))
    now = x.copy()
    for _ in range(2):
        f, K = fields(now, 0 * now)
        now[1] += np.linalg.solve(-K[3:6, 3:6], f[1])
    body = ('<MechanicalObject name="dofs" position="0 0 0  1 0 0  2 0 0"/><UniformMass totalMass="3"/><SpringForceField '
            'spring="0 1 20 0 0.5  1 2 20 0 0.5"/><ConstantForceField indices="1" forces="0 12 4"/><FixedConstraint indices="0 2"/>')
    solver = '<StaticSolver {}/><SparseLDLSolver/>'
    newton = '<NewtonRaphsonSolver name="n" {}/>'
    for text in (solver.format(""), solver.format('newton_iterations="1"'), newton.format("") + solver.format('newtonSolver="@n"')):
        agree(Run(node(text + body), 2).x(), now, 1e-9)
    settled = x.copy()
    for _ in range(60):
        f, K = fields(settled, 0 * settled)
        settled[1] += np.linalg.solve(-K[3:6, 3:6], f[1])
    differ(now, settled, 1e-4)
    more = 'newton_iterations="40" absolute_residual_tolerance_threshold="-1" relative_residual_tolerance_threshold="1e-12"'
    for text, args in ((solver.format(more), []), (solver.format(""), ["--without-quirk", "one-iteration"]),
                       (newton.format('maxNbIterationsNewton="50"') + solver.format('newtonSolver="@n"'), [])):
        agree(Run(node(text + body), 4, args=args).x(), settled, 1e-5)


@case
def quirk_grid_origin():
    grid = '<RegularGridTopology nx="3" ny="2" nz="1" xmin="0" xmax="4" ymin="1" ymax="3" zmin="0" zmax="5" p0="10 20 30"/>'
    scene = node(EXACT + grid + '<MechanicalObject name="dofs"/><UniformMass totalMass="1"/>')
    agree(Run(scene, 1).x(), [[10 + 2 * i, 20 + 2 * j, 30] for j in range(2) for i in range(3)])
    agree(Run(scene, 1, args=["--without-quirk", "grid-origin"]).x(), [[2 * i, 1 + 2 * j, 0] for j in range(2) for i in range(3)])


@case
def grids_run_the_other_way_and_lie_in_the_middle():
    grid = '<RegularGridTopology n="2 1 2" min="1 0 0" max="0 4 3"/>'
    scene = node(EXACT + grid + '<MechanicalObject name="dofs"/><UniformMass totalMass="1"/>')
    agree(Run(scene, 1).x(), [[1, 2, 0], [0, 2, 0], [1, 2, 3], [0, 2, 3]])


@case
def quirk_total_mass():
    scene = node(EXACT + '<MechanicalObject name="dofs" position="0 0 0  1 0 0"/><UniformMass totalMass="4" vertexMass="1"/>'
                 '<ConstantForceField indices="0 1" forces="0 8 0"/>')
    falls(Run(scene, 10), g=-4)
    falls(Run(scene, 10, args=["--without-quirk", "total-mass"]), g=-8)


@case
def quirk_fixed_inertia():
    scene = node('<EulerImplicitSolver/><SparseLDLSolver/><MechanicalObject template="Rigid3d" name="dofs" position="0 0 0 0 0 0 1" '
                 'velocity="0 0 0 1 2 3"/><UniformMass vertexMass="2 1 [1 0 0, 0 2 0, 0 0 3]"/>')
    kept = Run(scene, 20).x("dofs", 7)  # without a torque the angular velocity stays what it is
    angle = 0.2 * np.sqrt(14)
    agree(kept[0, 3:], [*(np.sin(angle / 2) * np.array([1, 2, 3]) / np.sqrt(14)), np.cos(angle / 2)])
    differ(Run(scene, 20, args=["--without-quirk", "fixed-inertia"]).x("dofs", 7), kept, 1e-4)


@case
def rest_positions_on_frames_stay_local():
    """A point at (1 0 0) in the axes of a frame, which starts at x = 5, is pulled to (1 0 0) in space: x'' = -k x."""
    scene = node(EXACT + '<MechanicalObject template="Rigid3d" name="dofs" position="5 0 0 0 0 0 1"/><UniformMass vertexMass="2"/>'
                 '<Node name="end"><MechanicalObject name="point" position="1 0 0"/><RigidMapping/>'
                 '<RestShapeSpringsForceField stiffness="30"/></Node>')
    x, v = 5.0, 0.0
    for _ in range(20):
        v = (v - 0.01 * 15 * x) / (1 + 0.0001 * 15)
        x += 0.01 * v
    agree(Run(scene, 20).x("dofs", 7)[0, 0], x)
    agree(Run(scene.replace("<RigidMapping", '<RigidMapping applyRestPosition="1"'), 20).x("dofs", 7)[0, 0], 5)


@case
def quirk_first_node():
    scene = root(EXACT + BODY + '<FixedProjectiveConstraint/>')
    agree(Run(scene, 10).x()[:, 1], [0, fallen(10)])
    Run(scene, 10, args=["--without-quirk", "first-node"]).fails(2, "no indices")


@case
def indices_that_are_empty():
    """Written and empty, as of a selection of a program that found nothing, they hold no node: SOFA reads them as an empty list."""
    for held in ['FixedProjectiveConstraint', 'PartialFixedProjectiveConstraint', 'FixedTranslationProjectiveConstraint']:
        run = Run(f'<Node name="root" {FALL} dt="0.01">{EXACT}{BODY}<{held} indices=""/></Node>', 10)
        agree(run.x()[:, 1], [fallen(10), fallen(10)])
        run.says("no node is held")


@case
def quirk_impulse_values():
    """A cable pulls a free point of 2 kg with the force that is written over dt: x = -(F / m) h^2 n (n + 1) / 2 from 1."""
    scene = node(EXACT + '<MechanicalObject name="dofs" position="1 0 0"/><UniformMass vertexMass="2"/>'
                 '<CableConstraint indices="0" pullPoint="0 0 0" valueType="force" value="0.003"/>')
    moved = 0.003 / 2 * 0.01**2 * 10 * 11 / 2
    agree(Run(scene, 10).x()[0, 0], 1 - moved / 0.01)
    agree(Run(scene, 10, args=["--without-quirk", "impulse-values"]).x()[0, 0], 1 - moved)


@case
def positions_of_softrobots():
    """A free point of 1 kg is pushed along y with the force that is written over dt, for one step from rest: y = F / m dt. Another
    is put to where it is to be, along a direction of any length with the weight 2: the half of it."""
    def put(attributes):
        return Run(node(EXACT + BODY + f'<PositionConstraint indices="1" {attributes}/>'), 1).x()
    agree(put('useDirections="0 1 0" valueType="force" value="0.003"'), [[0, 0, 0], [1, 0.003 * 0.01, 0]])
    agree(put('useDirections="0 1 0" value="2"'), [[0, 0, 0], [1, 2, 0]])
    agree(put('useDirections="0 0 1" directions="1 0 0 0 1 0 0 3 4" weight="2" value="2"'), [[0, 0, 0], [1, 0.6, 0.8]])
    agree(put('useDirections="0 0 0" weight="2 1" value="2"'), [[0, 0, 0], [2, 1, 1]])
    RUNS[-1].says("useDirections: holds no direction: as in SOFA all are taken",
                  "weight: has 2 numbers for 3 directions: as in SOFA the first is that of all")


@case
def frames_of_softrobots():
    """A free frame is put along y and turned about z by as much, with the weight 2: the half of it each."""
    run = Run(node(EXACT + '<MechanicalObject name="dofs" template="Rigid3" position="0 0 0 0 0 0 1"/><UniformMass totalMass="1"/>'
                   '<PositionConstraint template="Rigid3" indices="0" useDirections="0 1 0 0 0 1" weight="2 2 2 2 2 2" value="0.6"/>'), 1)
    agree(run.x(width=7), [[0, 0.3, 0, 0, 0, np.sin(0.15), np.cos(0.15)]])


@case
def files_that_nothing_reads():
    """A loader of what is only drawn, or of nothing, has no effect: where its file is not there, that is told."""
    scene = node(EXACT + BODY + '<MeshOBJLoader name="none" filename="nowhere.obj"/><MeshOBJLoader name="there" filename="there.obj"/>')
    run = Run(scene, 1, {"there.obj": "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"})
    run.says("warning: /none.filename: the file 'nowhere.obj' is not found: nothing with an effect reads it")
    assert "there.obj" not in run.text, run.text


CUBE = np.array([[i, j, k] for k in range(2) for j in range(2) for i in range(2)], float)
CORNERS = [0, 1, 3, 2, 4, 5, 7, 6]


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


# ---- components ----

@case
def finite_element_mass():
    scene = node(EXACT + '<RegularGridTopology n="2 2 2" min="0 0 0" max="1 1 1"/><MechanicalObject name="dofs"/>'
                 '<NodalMassDensity property="1 2 3 4 5 6 7 8"/><FEMMass template="Vec3,Hexahedron"/>'
                 '<ConstantForceField indices="0" forces="1 2 3"/>')
    mass, g = np.zeros((8, 8)), np.array([-1, 1]) / np.sqrt(3)
    for p in itertools.product(g, repeat=3):
        N = np.prod((1 + (2 * CUBE - 1) * p) / 2, axis=1)
        mass += np.outer(N, N) * (N @ np.arange(1, 9)) / 8
    agree(Run(scene, 5).x(), euler(CUBE, mass, load({0: np.array([1, 2, 3])}), 5, 0.01), 1e-8)


@case
def surface_of_tetrahedra():
    scene = root(EXACT + f'<TetrahedronSetTopologyContainer name="cells" position="{X4_TEXT}" tetrahedra="0 1 2 3"/>'
                 '<MechanicalObject name="dofs"/><UniformMass totalMass="4"/><RestShapeSpringsForceField stiffness="50"/>'
                 '<Node name="skin"><TriangleSetTopologyContainer name="skin"/><TriangleSetTopologyModifier/>'
                 '<Tetra2TriangleTopologicalMapping input="@../cells" output="@skin"/>'
                 '<MechanicalObject name="dofs"/><IdentityMapping/>'
                 '<TrianglePressureForceField triangleList="0" pressure="0 0 6"/></Node>', 'gravity="0 0 0"')

    def held(x, v):
        return -50 * (x - X4), -50 * np.eye(12)
    area = np.linalg.norm(np.cross(X4[2] - X4[1], X4[3] - X4[1])) / 2
    push = load({n: np.array([0, 0, 6 * area / 3]) for n in (1, 2, 3)})
    expected = euler(X4, np.eye(4), together(held, push), 10, 0.01)
    run = Run(scene, 10)
    agree(run.x(), expected, 1e-8)
    agree(run.x("skin.dofs"), expected, 1e-8)


@case
def borders_and_halves():
    scene = node('<MeshTopology name="cube" position="0 0 0  1 0 0  1 1 0  0 1 0  0 0 1  1 0 1  1 1 1  0 1 1" '
                 'hexahedra="0 1 2 3 4 5 6 7"/><Node name="a"><QuadSetTopologyContainer name="quads"/>'
                 '<Hexa2QuadTopologicalMapping input="@../cube" output="@quads"/><Node name="b">'
                 '<TriangleSetTopologyContainer name="triangles"/><Quad2TriangleTopologicalMapping input="@../quads" output="@triangles"/>'
                 '</Node></Node>' + EXACT + '<MeshTopology name="sheet" position="0 0 0  1 0 0  1 1 0  0 1 0  0.5 0.5 0" '
                 'triangles="0 1 4  1 2 4  2 3 4  3 0 4"/><MechanicalObject name="dofs" topology="@sheet"/>'
                 '<UniformMass totalMass="5"/><MeshBoundaryROI name="border" triangles="@sheet.triangles"/>'
                 '<ConstantForceField totalForce="0 0 50"/><FixedConstraint indices="@border.indices"/>')
    agree(Run(scene, 10).x()[:, 2], [0, 0, 0, 0, -fallen(10)])
    explained = Run(scene, 0, command="explain").text
    assert re.search(r"quads: .*6 quads", explained) and re.search(r"triangles: .*12 triangles", explained), explained


@case
def engines():
    scene = node('<MeshTopology name="m" position="1 0 0  0 2 0" edges="0 1"/>'
                 '<TransformEngine name="t" input_position="@m.position" scale="2 1 1" rotation="0 0 90" translation="0 0 5"/>'
                 '<TransformEngine name="back" input_position="@t.output_position" scale="2 1 1" rotation="0 0 90" '
                 'translation="0 0 5" inverse="1"/>'
                 '<MergeMeshes name="all" nbMeshes="2" position1="@t.output_position" position2="@back.output_position"/>'
                 '<PointsFromIndices name="p" position="@all.position" indices="3 0 3"/>'
                 f'<Node name="a">{EXACT}<MechanicalObject name="dofs" position="@../all.position"/><UniformMass totalMass="1"/></Node>'
                 f'<Node name="b">{EXACT}<MechanicalObject name="dofs" position="@../p.indices_position"/><UniformMass totalMass="1"/></Node>')
    run = Run(scene, 1)
    agree(run.x("a.dofs"), [[0, 2, 5], [-2, 0, 5], [1, 0, 0], [0, 2, 0]])
    agree(run.x("b.dofs"), [[0, 2, 0], [0, 2, 5]])


@case
def regions():
    line = '<MechanicalObject name="dofs" position="0 0 0  1 0 0  2 0 0  3 0 0  4 0 0"/><UniformMass totalMass="5"/>'
    for roi, held in (('<PlaneROI name="r" plane="1 -1 -1  1 1 -1  1 -1 1  0.5"/>', [1]),
                      ('<PairBoxROI name="r" inclusiveBox="0.5 -1 -1 4.5 1 1" includedBox="1.5 -1 -1 2.5 1 1"/>', [1, 3, 4]),
                      ('<MeshROI name="r" ROIposition="-1 -1 -1  2.5 -1 -1  -1 2.5 -1  -1 -1 2.5" '
                       'ROItriangles="0 2 1  0 1 3  1 2 3  2 0 3"/>', [0]),
                      ('<BoxROI name="r" box="8 8 8 9 9 9"/>', [])):
        run = Run(root(EXACT + line + roi + '<FixedConstraint indices="@r.indices"/>'), 10)
        agree(run.x()[:, 1], [0 if i in held else fallen(10) for i in range(5)])


@case
def regions_ask_the_state_above():
    """Where there is neither a state nor a loader beside it, whatever mesh there is."""
    line = '<MechanicalObject name="dofs" position="0 0 0  1 0 0  2 0 0"/><UniformMass totalMass="3"/>'
    for roi in ('BoxROI name="r" box="0.5 -1 -1 1.5 1 1"', 'SphereROI name="r" centers="1 0 0" radii="0.5"',
                'PlaneROI name="r" plane="1 -1 -1  1 1 -1  1 -1 1  0.5"'):
        run = Run(root(EXACT + line + f'<Node name="c"><MeshTopology position="1 0 0  7 0 0  8 0 0"/><{roi}/></Node>'
                       '<FixedConstraint indices="@c/r.indices"/>'), 10)
        agree(run.x()[:, 1], [fallen(10), 0, fallen(10)])


@case
def cells_in_regions():
    """MeshROI takes edges whose nodes are all inside, and unless strict those whose middle is; SphereROI asks for angles, too."""
    points = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0], [1, 1, 0.0]])
    edges = [(0, 1), (1, 2), (2, 3), (0, 4), (4, 5), (1, 5)]

    def whole(cells):
        return "  ".join(" ".join(map(str, cell)) for cell in cells)

    def chosen(roi):
        """The edges that are chosen: each drives its ends apart along y."""
        run = Run(node(EXACT + f'<MeshTopology name="m" position="{numbers_of(points)}" edges="{whole(edges)}"/>'
                       '<MechanicalObject name="dofs"/><UniformMass vertexMass="1"/>' + roi +
                       '<EdgePressureForceField edgeIndices="@r.edgeIndices" pressure="0 2 0"/>'), 1)
        return np.round((run.x()[:, 1] - points[:, 1]) / 1e-4, 6)

    def ends_of(numbers):
        loads = np.zeros(len(points))
        for i in numbers:
            loads[list(edges[i])] += 1
        return loads
    box = np.array([[x, y, z] for z in (-1, 1) for y in (-0.5, 0.5) for x in (-1, 1.8)])
    faces = [(0, 2, 1), (1, 2, 3), (4, 5, 6), (5, 7, 6), (0, 1, 4), (1, 5, 4), (2, 6, 3), (3, 6, 7), (0, 4, 2), (2, 4, 6), (1, 3, 5), (3, 7, 5)]
    roi = f'<MeshROI name="r" ROIposition="{numbers_of(box)}" ROItriangles="{whole(faces)}" {{}}/>'
    agree(chosen(roi.format('strict="1"')), ends_of([0]))
    agree(chosen(roi.format("")), ends_of([0, 1, 3, 5]))  # the middles of 3 and 5 lie on the surface
    agree(chosen(roi.format('computeMeshROI="0"')), ends_of(range(6)))
    sphere = '<SphereROI name="r" centers="1 0.5 0" radii="5" {}/>'
    agree(chosen(sphere.format("")), ends_of(range(6)))
    agree(chosen(sphere.format('edgeAngle="10" direction="0 3 0"')), ends_of([2, 3, 5]))
    agree(chosen(sphere.format('edgeAngle="10"')), ends_of([]))
    # of a triangle SOFA takes (c - a) x (b - a)
    for normal, loaded in (("0 0 2", [0, 0, 0, 0]), ("0 0.1 -2", [1 / 3, 1 / 6, 1 / 3, 1 / 6])):
        run = Run(node(EXACT + '<MeshTopology name="m" position="0 0 0  1 0 0  1 1 0  0 1 0" triangles="0 1 2  0 2 3"/>'
                       '<MechanicalObject name="dofs"/><UniformMass vertexMass="1"/>' + sphere.format(f'triAngle="10" normal="{normal}"') +
                       '<TrianglePressureForceField triangleList="@r.triangleIndices" pressure="0 0 1"/>'), 1)
        agree(run.x()[:, 2] / 1e-4, loaded, 1e-6)


BOX = [[i, j, k] for k in (0.1, 1.9) for j in (0.1, 1.9) for i in (0.1, 1.9)]
BOX_FACES = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]


@case
def files_of_spheres_and_surfaces_and_the_cells_inside():
    off = "OFF\n8 6 0\n" + "".join(f"{x} {y} {z}\n" for x, y, z in BOX) + "".join(
        f"4 {a} {b} {c} {d}\n" for a, b, c, d in BOX_FACES)
    scene = node(f'<Node name="a">{EXACT}<SphereLoader filename="s.sph"/><MechanicalObject name="dofs" position="@[-1].position"/>'
                 '<SphereCollisionModel listRadius="@[-2].listRadius"/><UniformMass totalMass="1"/></Node>'
                 f'<Node name="b">{EXACT}<SparseGridTopology name="grid" n="7 7 7" min="-1 -1 -1" max="2 2 2" fileTopology="box.off"/>'
                 '<MechanicalObject name="dofs"/><UniformMass totalMass="1"/><HexahedronFEMForceField youngModulus="100" '
                 'poissonRatio="0.3"/></Node>')
    run = Run(scene, 1, {"s.sph": "sph 1.0\n# two\nsphe 0 1 2 3 0.5\nsphe 1 4 5 6 0.25\n", "box.off": off})
    agree(run.x("a.dofs"), [[1, 2, 3], [4, 5, 6]])
    steps = np.arange(5) * 0.5  # the cells from 0 to 2; x is the slowest
    agree(run.x("b.dofs"), list(itertools.product(steps, repeat=3)))


# ---- contact ----

FLOOR = ('<Node name="floor"><MeshTopology position="-9 0 -7  9 0 -9  9 0 9  -9 0 9" triangles="0 1 2  0 2 3"/>'
         '<MechanicalObject name="dofs"/><TriangleCollisionModel name="top" simulated="0" moving="0"/></Node>')
WATCH = ('<CollisionPipeline/><BruteForceBroadPhase/><BVHNarrowPhase/><CollisionResponse response="PenalityContactForceField"/>'
         '<MinProximityIntersection alarmDistance="0.5" contactDistance="0.2"/>')


def falling_point(height, watch=WATCH, more=""):
    return root(watch + FLOOR + f'<Node name="ball">{EXACT}<MechanicalObject name="dofs" position="0 {height} 0"/>'
                f'<UniformMass totalMass="1"/><PointCollisionModel name="point" {more}/></Node>')


@case
def nothing_touches():
    falls_from = Run(falling_point(1), 10)
    agree(falls_from.x("ball.dofs"), [[0, 1 + fallen(10), 0]])


OTHER = WATCH.replace("PenalityContactForceField", "StickContactForceField")


@case
def the_step_that_would_touch_without_a_response_is_refused():
    steps = next(n for n in range(1000) if 1 + fallen(n) < 0.2)
    Run(falling_point(1, OTHER), 100).fails(3, "/ball/point", "/floor/top", "distance of 0.2:", f"step {steps + 1} ")
    agree(Run(falling_point(1, OTHER), steps).x("ball.dofs"), [[0, 1 + fallen(steps), 0]])


@case
def conjugate_gradients_of_each_body():
    """Bodies that may touch, and do not, each with iterations of their own that end early, whatever their damping."""
    def chain(name, y, more, stiffness):
        places = " ".join(f"{i} {y} 0" for i in range(6))
        return (f'<Node name="{name}"><EulerImplicitSolver {more}/><CGLinearSolver iterations="3" tolerance="1e-9" threshold="1e-9"/>'
                f'<MechanicalObject name="dofs" position="{places}"/><UniformMass totalMass="6"/><MeshTopology edges="0 1  1 2  2 3  3 4  4 5"/>'
                f'<MeshSpringForceField linesStiffness="{stiffness}"/><FixedConstraint indices="0"/><PointCollisionModel/></Node>')

    def expected(y, stiffness, damping):
        X = np.array([[i, y, 0] for i in range(6)], float)
        fields = together(gravity(np.ones(6), [0, -10, 0]), springs([(i, i + 1) for i in range(5)], X, stiffness))
        return euler(X, np.eye(6), fields, 10, 0.01, held=[0], rayleigh_stiffness=damping, cg=(3, 1e-9, 1e-9))
    for more, damping in (('rayleighStiffness="0.1"', 0.1), ('rayleighStiffness="0"', 0)):
        run = Run(root(WATCH + chain("a", 0, 'rayleighStiffness="0.1"', 3000) + chain("my b", 50, more, 900)), 10)
        agree(run.x("a.dofs"), expected(0, 3000, 0.1), 1e-9)
        agree(run.x("my_b.dofs"), expected(50, 900, damping), 1e-9)


@case
def meshes_that_change_by_lists_and_by_a_file():
    """Free tetrahedra: who is left falls on; numbers by SOFA's rule, the last into each hole, the largest first."""
    places = "0 0 0  1 0 0  0 1 0  0 0 1  9 0 0  8 0 0  9 1 0  9 0 1  20 0 0  21 0 0  20 1 0  20 0 1"
    starts = np.array(places.split(), float).reshape(-1, 3)

    def planned(attributes, steps, files=None):
        mesh = (f'<TetrahedronSetTopologyContainer position="{places}" tetrahedra="0 1 2 3  4 6 5 7  8 9 10 11"/>'
                '<TetrahedronSetTopologyModifier/><TetrahedronSetGeometryAlgorithms/><MechanicalObject name="dofs"/>'
                '<UniformMass vertexMass="1"/>')
        return Run(root(EXACT + mesh + f'<TopologicalChangeProcessor {attributes}/>'), steps, files=files or {
            "changes.txt": "T= 0.05\nREMOVE= 1\n0\nT= 0.08\nREMOVE= 1\n0\n"})

    def left(run, steps, points):
        agree(run.x(), starts[points] + [0, fallen(steps), 0])
    # points 3, 2, 1, 0 go, and 11, 10, 9, 8 take their numbers; the last tetrahedron is then 0
    second = [8, 9, 10, 11, 4, 5, 6, 7]
    for attributes, first in (('filename="changes.txt" listChanges="1"', 5), ('filename="changes.txt" shift="0.02"', 3),
                              ('useDataInputs="1" timeToRemove="0.06" tetrahedraToRemove="0"', 7)):
        left(planned(attributes, first), first, list(range(12)))
        left(planned(attributes, first + 1), first + 1, second)
    # then 3, 2, 1, 0 again: the tetrahedron 8 9 10 11 goes, and 7, 6, 5, 4 take the numbers
    left(planned('filename="changes.txt"', 12), 12, [4, 5, 6, 7])
    left(planned('useDataInputs="1" timeToRemove="0.02" interval="0.03" tetrahedraToRemove="0"', 8), 8, [4, 5, 6, 7])
    for attributes in ('useDataInputs="1" timeToRemove="0.06"', 'listChanges="1"'):  # nothing is planned
        left(planned(attributes, 9), 9, list(range(12)))
    planned('useDataInputs="1" pointsToRemove="3"', 3).fails(3, "point 3 cannot go", "step 2 ")
    planned('filename="none.txt"', 1).fails(2, "none.txt")
    for text, word in (("REMOVE= 1\n0\n", "before any time"), ("T=0.05\n", "before any time"), ("\nT= soon\n", ":2: "),
                       ("T=\n", "no time"), ("T= 1\nREMOVE Tetrahedron 1 0\n", "no change"), ("T= 1\nREMOVE= 2\n0\n", "1 numbers")):
        planned('filename="other.txt"', 1, {"other.txt": text}).fails(2, "other.txt:", word)
    planned('filename="other.txt.gz"', 1, {"other.txt.gz": ""}).fails(2, "compressed")
    left(planned('filename="other.txt"', 9, {"other.txt": "\n"}), 9, list(range(12)))
    planned('filename="cut.txt"', 5, {"cut.txt": "T= 0.03\nINCISE= 2\n0 0 0 0 1 1 1 1\n"}).fails(3, "along a path", "step 4 ")


@case
def springs_of_a_mesh_that_changes():
    """A chain of edges loses its third: the rest swings on, its last point falls with what hangs on it."""
    def chain(more, steps):
        mesh = ('<EdgeSetTopologyContainer position="0 0 0  1 0 0  2 0 0  3 0 0  4 0 0" edges="0 1  1 2  2 3  3 4"/>'
                '<EdgeSetTopologyModifier/><MechanicalObject name="dofs"/><UniformMass vertexMass="1"/>'
                '<MeshSpringForceField stiffness="300" damping="0"/><FixedProjectiveConstraint indices="0"/>')
        return Run(root(EXACT + mesh + more), steps)
    before = chain("", 3).x()
    start = np.array([[i, 0, 0] for i in range(5)], float)
    whole = springs([(0, 1), (1, 2), (2, 3), (3, 4)], start, 300)
    weight = gravity(np.ones(5), [0, -10, 0])
    agree(before, euler(start, np.eye(5), together(weight, whole), 3, 0.01, held=[0]), 1e-9)
    cut = chain('<TopologicalChangeProcessor useDataInputs="1" timeToRemove="0.025" edgesToRemove="2"/>', 8).x()
    x, earlier = (euler(start, np.eye(5), together(weight, whole), steps, 0.01, held=[0]) for steps in (3, 2))
    rest = together(weight, springs([(0, 1), (1, 2), (3, 4)], start, 300))
    agree(cut, euler(x, np.eye(5), rest, 5, 0.01, held=[0], v=(x - earlier) / 0.01), 1e-9)


@case
def a_mesh_that_changes_looks_for_no_contacts():
    """What looks for contacts is a pipeline, and nothing else that may end a run."""
    ball = ('<Node name="{0}">' + EXACT + '<MechanicalObject name="dofs" position="0 {1} 0"/><UniformMass totalMass="1"/>'
            '<PointCollisionModel/></Node>')
    def run(more):
        return Run(root('<CollisionResponse response="PenalityContactForceField"/><MinProximityIntersection alarmDistance="0.3" '
                        'contactDistance="0.2"/>' + ball.format("a", 0) + ball.format("b", 0.15) + more), 5).x("b.dofs")
    agree(run('<Node name="c"><PointSetTopologyContainer position="0 9 0"/><TopologicalChangeProcessor useDataInputs="1" timeToRemove="2" '
              'pointsToRemove="0"/></Node>'), run(""))
    differ(run("<CollisionPipeline/><BruteForceBroadPhase/><BVHNarrowPhase/>"), run(""), 1e-6)


@case
def actuators_by_number():
    """valueType by its number: 0 and 1 of displacement and force, of pressure and volumeGrowth."""
    def pulled(kind):
        cable = f'<CableConstraint indices="0" pullPoint="-1 0 0" value="0.1" {kind}/>'
        return Run(root('<FreeMotionAnimationLoop/><GenericConstraintSolver maxIterations="100" tolerance="1e-12"/><Node name="a">' +
                        EXACT + BODY + '<RestShapeSpringsForceField stiffness="100"/><LinearSolverConstraintCorrection/>' + cable +
                        '</Node>'), 3).x("a.dofs")

    def blown(kind):
        cube = ('<MechanicalObject name="dofs" position="0 0 0  1 0 0  0 1 0  0 0 1"/><UniformMass totalMass="4"/><RestShapeSpringsForceField '
                'stiffness="100"/><LinearSolverConstraintCorrection/><SurfacePressureConstraint triangles="0 2 1  0 1 3  1 2 3  0 3 2" '
                f'value="0.05" {kind}/>')
        return Run(root('<FreeMotionAnimationLoop/><GenericConstraintSolver maxIterations="100" tolerance="1e-12"/><Node name="a">' +
                        EXACT + cube + '</Node>'), 3).x("a.dofs")
    agree(blown('valueType="0"'), blown('valueType="pressure"'))
    agree(blown('valueType="1"'), blown('valueType="volumeGrowth"'))
    differ(blown('valueType="0"'), blown('valueType="1"'), 1e-3)
    agree(pulled('valueType="0"'), pulled('valueType="displacement"'))
    agree(pulled('valueType="1"'), pulled('valueType="force"'))
    differ(pulled('valueType="0"'), pulled('valueType="1"'), 1e-3)


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
def balls_of_a_file_that_counts_them():
    run = Run(root(EXACT + '<SphereLoader name="loader" filename="two.sph"/><MechanicalObject name="dofs" '
                   'position="@loader.position"/><UniformMass totalMass="2"/>'), 0, files={
                       "two.sph": "sph 1.0\nnums 2\nsphe 0 1 2 3 0.5\nsphe 1 4 5 6 0.25\n"})
    agree(run.x(), [[1, 2, 3], [4, 5, 6]])
    assert "cut off" not in run.text, run.text
    for told in ("3", "x"):
        Run(root(EXACT + '<SphereLoader name="loader" filename="two.sph"/><MechanicalObject name="dofs" position="@loader.position"/>'
                 '<UniformMass totalMass="2"/>'), 0, files={"two.sph": f"sph 1.0\nnums {told}\nsphe 0 1 2 3 0.5\n"}).says(
                     f"tells of {told} spheres, and holds 1")


@case
def springs_of_a_mesh_without_cells():
    mesh = '<MeshTopology position="0 0 0  1 0 0"/>' + BODY
    run = Run(root(EXACT + mesh + '<MeshSpringForceField stiffness="100"/>'), 10)
    run.says("there is no spring")
    falls(run)


@case
def selections_of_nothing_that_stand_for_all():
    """Springs to the rest shape and constant forces: as those without a list."""
    none = '<BoxROI name="none" box="50 50 50 51 51 51"/>'
    for field, link in (('<RestShapeSpringsForceField stiffness="100" {}/>', 'points="@none.indices"'),
                        ('<ConstantForceField totalForce="1 2 3" {}/>', 'indices="@none.indices"')):
        run = Run(root(EXACT + BODY + none + field.format(link)), 5)
        run.says("lists no node: all 2 nodes")
        agree(run.x(), Run(root(EXACT + BODY + field.format("")), 5).x())
        differ(run.x()[:, 1], [fallen(5)] * 2, 1e-5)


@case
def constants_of_fewer_springs_than_points():
    points = '<MechanicalObject name="dofs" position="0 0 0  1 0 0  2 0 0"/><UniformMass totalMass="3"/>'
    run = Run(root(EXACT + points + '<RestShapeSpringsForceField points="0 1 2" stiffness="100 200"/>'), 5)
    agree(run.x(), Run(root(EXACT + points + '<RestShapeSpringsForceField points="0 1 2" stiffness="100 200 100"/>'), 5).x())
    run.says("2 values for 3 points")
    run = Run(root(EXACT + points + '<RestShapeSpringsForceField points="0 1" stiffness="100 200 300"/>'), 5)
    agree(run.x(), Run(root(EXACT + points + '<RestShapeSpringsForceField points="0 1" stiffness="100 200"/>'), 5).x())
    run.says("3 values for 2 points")
    region = '<BoxROI name="all" box="-1 -1 -1 3 1 1"/>'
    for listed in ("0-2", "@all.indices"):
        run = Run(root(EXACT + region + points + f'<RestShapeSpringsForceField points="{listed}" stiffness="100 200"/>'), 5)
        agree(run.x(), Run(root(EXACT + points + '<RestShapeSpringsForceField points="0 1 2" stiffness="100 200 100"/>'), 5).x())
        run.says("2 values for 3 points: the others take the first")


@case
def names_with_blanks():
    """A body and what follows it, with blanks in the names of nodes and components that links name."""
    def named(blank):
        follower = (f'<Node name="Collision{blank}Model"><MechanicalObject name="the{blank}points" position="1 0 0"/><SubsetMapping '
                    f'indices="1" input="@../my{blank}dofs" output="@the{blank}points"/><RestShapeSpringsForceField '
                    f'stiffness="100" mstate="@the{blank}points"/></Node>')
        return Run(root(f'<Node name="Soft{blank}Body"><EulerImplicitSolver linearSolver="@linear{blank}solver"/><SparseLDLSolver '
                        f'name="linear{blank}solver"/><StringMeshCreator name="mesh{blank}loader" resolution="2"/><MechanicalObject '
                        f'name="my{blank}dofs" position="@mesh{blank}loader.position"/><UniformMass totalMass="2"/>' + follower +
                        '</Node>'), 5)
    for name, plain in named("").states.items():
        agree(named(" ").states[name.replace("SoftBody", "Soft_Body").replace("mydofs", "my_dofs").replace(
            "CollisionModel", "Collision_Model").replace("thepoints", "the_points")], plain)


@case
def files_that_are_no_utf8():
    """Latin-1, with a declaration and without, in the scene and in what it includes."""
    declared = '<?xml version="1.0" encoding="ISO-8859-1"?>\n'
    scene = root('<!-- r\xe9gime, 20 \xb0C --><Node name="k\xf6rper">' + EXACT + BODY + '</Node>')
    for text in (declared + scene, scene):
        run = Run(text.encode("latin-1"), 10)
        run.says(f"scene.scn:{1 + text.startswith('<?xml')}:", "is no UTF-8: it is read as Latin-1")
        falls(run, "k\xf6rper.dofs")
        falls(Run(text.encode("latin-1").replace(b'dt="0.01"', b'dt="0.01" dialect="sofa"'), 10, name="a.xml"), "k\xf6rper.dofs")
        Run(text.encode("latin-1"), 1, name="a.xml").fails(2, "is not part of a UTF-8 text")
        assert "Latin-1" not in Run(text.replace("ISO-8859-1", "UTF-8"), 1).text
    falls(Run(root('<include href="part.xml"/>'), 10, files={"part.xml": (declared + f'<Node name="k\xf6rper">{EXACT}{BODY}</Node>').encode(
        "latin-1")}), "k\xf6rper.dofs")


@case
def nodes_of_a_follower_that_is_made_after_what_names_them():
    """A constraint and springs of the outermost node, whose components come first, on states that have their nodes from mappings."""
    frames = "".join(f"{x} 0 0 0 0 0 1  " for x in (0, 1, 2))
    body = (f'<Node name="a">{EXACT}<MechanicalObject name="dofs" template="Rigid3" position="{frames}"/><UniformMass totalMass="3"/>'
            '<LinearSolverConstraintCorrection/><Node name="p"><MechanicalObject name="p"/><IdentityMapping/></Node></Node>')
    held = (f'<Node name="b">{EXACT}<MechanicalObject name="dofs" position="0 0 0  1 0 0  2 0 0"/><UniformMass totalMass="3"/>'
            '<FixedConstraint fixAll="1"/><LinearSolverConstraintCorrection/><Node name="p"><MechanicalObject name="p"/><IdentityMapping/>'
            '</Node></Node>')
    join = '<BilateralInteractionConstraint object1="@a/p/p" object2="@b/p/p" first_point="0 2" second_point="0 2"/>'
    free = '<FreeMotionAnimationLoop/><GenericConstraintSolver maxIterations="500" tolerance="1e-10"/>'
    run = Run(root(free + join + body + held), 5)
    agree(run.x("a.dofs", 7)[:, :3], [[0, 0, 0], [1, fallen(5), 0], [2, 0, 0]], 1e-7)
    spring = '<SpringForceField object1="@a/p/p" object2="@b/p/p" spring="2 2 1000 0 0"/>'
    run = Run(root(spring + body.replace("<LinearSolverConstraintCorrection/>", "") +
                   held.replace("<LinearSolverConstraintCorrection/>", "")), 5)
    agree(run.x("a.dofs", 7)[:2, 1], [fallen(5)] * 2)
    y = v = 0.0
    for _ in range(5):
        v -= 0.01 * (10 + 1000 * y)  # with the force of a step's start: no solver has both bodies
        y += 0.01 * v
    agree(run.x("a.dofs", 7)[2, 1], y, 1e-7)


@case
def quirk_moved_inertia():
    """A triangle with the consistent mass, one node of which is moved: the others fall as if it stood still, by M dv = h f with 1/6
    and 1/12 of the mass in M, and 1/3 of it in f."""
    sheet = ('<MeshTopology position="0 0 0  1 0 0  0 1 0" triangles="0 1 2"/><MechanicalObject name="dofs"/><MeshMatrixMass '
             'massDensity="2"/><LinearMovementConstraint indices="0" keyTimes="0 1" movements="0 0 0  0 0 7"/>')
    run = Run(root(EXACT + sheet), 10)
    agree(run.x(), [[0, 0, 7 * 0.09], [1, fallen(10) * (1 / 3) / (1 / 4), 0], [0, 1 + fallen(10) * (1 / 3) / (1 / 4), 0]])
    Run(root(EXACT + sheet), 1, args=["--without-quirk", "moved-inertia"]).fails(2, "through a mass that is not diagonal")
    child = ('<MechanicalObject name="dofs" position="0 0 0  1 0 0"/><UniformMass totalMass="2"/><LinearMovementConstraint indices="0" '
             'keyTimes="0 1" movements="0 0 0  0 0 7"/><Node name="c"><MechanicalObject name="c" position="0.5 0 0"/><MeshTopology '
             'position="0 0 0"/><SubsetMultiMapping input="@../dofs" output="@c" indexPairs="0 1"/><UniformMass totalMass="1"/></Node>')
    agree(Run(root(EXACT + child), 10).x(), [[0, 0, 7 * 0.09], [1, fallen(10), 0]])


@case
def forces_from_outside_that_are_zero():
    """As scenes that SOFA saved have them."""
    falls(Run(root(EXACT + BODY.replace('name="dofs"', 'name="dofs" externalForce="0 0 0 0.0 0 0"')), 10))
    Run(root("<RungeKutta2Solver/>" + BODY.replace('name="dofs"', 'name="dofs" externalForce="0 0 0 0 1 0"')), 1).fails(2, "externalForce")


@case
def stiffness_alone_moves_what_has_no_mass():
    """By springs it is at once where forces balance; nothing that acts there is gravity."""
    body = ('<Node name="b"><MechanicalObject name="b" position="1 2 3"/><RestShapeSpringsForceField stiffness="100"/><ConstantForceField '
            'forces="5 0 0"/></Node>')
    for steps in (1, 3):
        run = Run(root(EXACT + body), steps)
        agree(run.x("b.b"), [[1.05, 2, 3]], 1e-12)
        run.says("has no mass: stiffness alone moves it")
    soft = body.replace('stiffness="100"', 'stiffness="1e-9"').replace("5 0 0", "5e-11 0 0")  # next to no mass would be too much
    agree(Run(root(EXACT + soft), 1).x("b.b"), [[1.05, 2, 3]], 1e-12)
    whole = '<MechanicalObject name="dofs" position="0 0 0  2 0 0"/><FixedConstraint indices="0"/><SpringForceField spring="0 1 100 0 1"/>'
    agree(Run(root(EXACT + whole), 1).x(), [[0, 0, 0], [1, 0, 0]], 1e-7)
    below = body.replace("</Node>", '<Node name="c"><MechanicalObject name="c" position="0 0 0"/><UniformMass totalMass="1"/></Node></Node>')
    run = Run(root(EXACT + below), 3)
    agree(run.x("b.b"), [[1.05, 2, 3]], 1e-7)
    agree(run.x("b.c.c"), [[0, fallen(3), 0]])
    grid = '<RegularGridTopology n="3 2 2" min="0 0 0" max="2 1 1"/><MechanicalObject name="b"/>'
    soft = f'<Node name="b">{grid}<HexahedronFEMForceField youngModulus="1000" poissonRatio="0.3"/><FixedConstraint indices="0"/></Node>'
    assert "system of units" not in Run(root(EXACT + soft), 1).text  # nobody wrote the density
    # a state above a body, on which nothing acts
    above = '<Node name="b"><MechanicalObject name="b" position="1 2 3"/>' + BODY.replace("<Mech", '<Node name="c"><Mech') + (
        '<RestShapeSpringsForceField stiffness="0"/></Node></Node>')
    run = Run(root(EXACT + above), 3)
    agree(run.x("b.b"), [[1, 2, 3]])
    falls(run, "b.c.dofs", 3)
    both = body.replace('<MechanicalObject', '<UniformMass totalMass="1"/><MechanicalObject')
    assert "stiffness alone" not in Run(root(EXACT + both), 1).text
    Run(root(EXACT.replace("Solver/>", 'Solver trapezoidalScheme="1"/>', 1) + body), 1).fails(2, "has no mass")
    # a node that no cell has, and nothing pulls: conjugate gradients leave it, factors do not exist
    mesh = ('<MeshTopology position="0 0 0  1 0 0  0 1 0  0 0 1  5 5 5" tetrahedra="0 1 2 3"/><MechanicalObject name="dofs"/>'
            '<TetrahedronFEMForceField youngModulus="1000"/><DiagonalMass massDensity="6"/><FixedConstraint indices="0 1 2"/>')
    iterated = '<EulerImplicitSolver/><CGLinearSolver iterations="100" tolerance="1e-12" threshold="1e-30"/>'
    agree(Run(root(iterated + mesh), 3).x()[4], [5, 5, 5])
    free = body.replace('<RestShapeSpringsForceField stiffness="100"/>', "")
    Run(root(EXACT + free), 1).fails(3, "b")


@case
def one_solve_per_step_and_damping_that_nobody_wrote():
    """SOFA's trapezoidal rule makes one linear solve, and its springs and penalties are damped by 5 N s/m."""
    body = ('<RegularGridTopology name="grid" n="4 2 2" min="0 0 0" max="3 1 1"/><MechanicalObject name="dofs"/><UniformMass '
            'totalMass="2"/><HexahedronFEMForceField method="polar" youngModulus="1000" poissonRatio="0.3"/>'
            '<FixedConstraint indices="0 4 8 12"/>')
    for rule in ('EulerImplicitSolver trapezoidalScheme="true"', "NewmarkImplicitSolver", 'BDFOdeSolver order="2"'):
        solved = [Run(root(f"<{rule} {count}/><SparseLDLSolver/>" + body), 10).x()
                  for count in ("", 'newtonIterations="1"', 'newtonIterations="2"')]
        agree(solved[0], solved[1], 0)
        differ(solved[0], solved[2], 1e-8 if "BDF" in rule else 1e-6)  # whose start is nearer
    held = BODY + '<FixedConstraint indices="0"/>'
    for field in ('SpringForceField springsIndices1="0" springsIndices2="1" lengths="0.9" stiffness="100"',
                  'PlaneForceField normal="0 1 0" d="0.5" stiffness="100"', 'SphereForceField center="1 0 0" radius="2" stiffness="100"'):
        x = [Run(root(EXACT + held + f"<{field} {damping}/>"), 10).x() for damping in ("", 'damping="5"', 'damping="0"')]
        agree(x[0], x[1], 0)
        differ(x[0], x[2], 1e-6)


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
def lists_of_a_grid_that_links_name():
    grid = '<RegularGridTopology name="grid" n="3 1 1" min="0 0 0" max="2 0 0"/><MechanicalObject name="dofs"/><UniformMass totalMass="3"/>'
    child = ('<Node name="e"><EdgeSetTopologyContainer name="e" edges="@../grid.edges"/><MechanicalObject name="y" template="Vec1"/>'
             '<DistanceMapping topology="@e" computeDistance="1"/><RestShapeSpringsForceField stiffness="0"/></Node>')
    agree(Run(root(EXACT + grid + child), 1).x("e.y", 1), [[1], [1]])


@case
def files_of_masses_and_springs():
    """Of a file that has both, as TorusSpring has: against the same numbers in the scene."""
    text = ("Xsp 3.0\nnumm 3\nnums 2\ngrav 0 0 0\nvisc 0\nmass 1 v 0 0 0 0 0 0 -1 0\nmass 2 v 1 0 0 0 0 0 2 0\nmass 3 s 2 0 0 0 0 0 3 0\n"
            "lspg 1 1 2 100 1 0.9\nlspg 2 2 3 200 2 1.1\n")
    read = ('<MeshXspLoader name="l" filename="net.xs3"/><MechanicalObject name="dofs" src="@l"/><DiagonalMass fileMass="net.xs3"/>'
            '<FixedConstraint indices="0"/><StiffSpringForceField filename="net.xs3"/>')
    written = ('<MeshTopology position="0 0 0  1 0 0  2 0 0" edges="0 1  1 2"/><MechanicalObject name="dofs"/><DiagonalMass vertexMass="1 2 3"/>'
               '<FixedConstraint indices="0"/><StiffSpringForceField spring="0 1 100 1 0.9  1 2 200 2 1.1"/>')
    run = Run(root(EXACT + read), 10, files={"net.xs3": text})
    agree(run.x(), Run(root(EXACT + written), 10).x())
    differ(run.x()[:, 0], [0, 1, 2], 1e-4)
    Run(root(EXACT + read), 1).fails(2, "net.xs3", "is not found")
    Run(root(EXACT + read), 1, files={"net.xs3": text.replace(" 200 2 1.1", "")}).fails(2, "a line lspg with too few numbers")
    balls = ('<MechanicalObject name="dofs" template="Rigid3" position="1 2 3 0 0 0 1"/><UniformMass totalMass="1"/><FixedConstraint '
             'indices="0"/><Node name="c"><MechanicalObject name="c"/><RigidMapping filename="{}"/>{}</Node>')
    files = {"net.xs3": text, "two.sph": "sph 1.0\nsphe 0 0 0 4 0.5\nsphe 1 5 0 0 0.25\n"}
    for name, more, points in (("two.sph", '<SphereCollisionModel filename="two.sph"/>', [[1, 2, 7], [6, 2, 3]]),
                               ("net.xs3", "", [[1, 2, 3], [2, 2, 3], [3, 2, 3]])):
        agree(Run(root(EXACT + balls.format(name, more)), 1, files=files).x("c.c"), points)
    written = balls.format("two.sph", "").replace('name="c"/><Rigid', 'name="c" position="9 9 9"/><Rigid').replace("filename", "fileRigidMapping")
    run = Run(root(EXACT + written), 1, files=files)
    agree(run.x("c.c"), [[1, 2, 7], [6, 2, 3]])
    run.says("reads points of a file")
    # what a file replaces is said, and a file without what is read of it replaces nothing
    both = ('<MechanicalObject name="dofs" filename="net.xs3" position="7 7 7"/><DiagonalMass fileMass="net.xs3" vertexMass="5"/>'
            '<FixedConstraint indices="0 1 2"/>')
    run = Run(root(EXACT + both), 1, files=files)
    agree(run.x(), [[0, 0, 0], [1, 0, 0], [2, 0, 0]])
    run.says("/dofs.position: is read of a file too", "vertexMass: is read of a file too")
    Run(root(EXACT + both), 1, files={"net.xs3": "Xsp 3.0\nnumm 0\nnums 0\n"}).fails(
        2, "/dofs.filename: net.xs3 has no line mass", "fileMass: net.xs3 has no line mass")
    Run(root(EXACT + balls.format("two.sph", "")), 1, files={"two.sph": "sph 1.0\n"}).fails(2, "two.sph has no line sphe")


@case
def names_of_other_years():
    tetra = ('<MeshTopology position="0 0 0  1 0 0  0 1 0  0 0 1" tetrahedra="0 1 2 3"/><MechanicalObject name="dofs"/><UniformMass '
             'totalMass="1"/><FixedConstraint indices="0 1 2"/><MJEDTetrahedralForceField materialName="{}" ParameterSet="3000 3000"/>')
    agree(Run(root(EXACT + tetra.format("BoyceAndArruda")), 3).x(), Run(root(EXACT + tetra.format("ArrudaBoyce")), 3).x())
    run = Run(root('<CompositeCollisionPipeline/><SubCollisionPipeline name="a"/>' + EXACT + BODY), 3)
    falls(run, steps=3)


@case
def what_has_no_effect_here_and_one_in_sofa():
    touch = ('<CollisionPipeline/><BruteForceBroadPhase/><BVHNarrowPhase/>{}<CollisionResponse/><Node name="a">' + EXACT + BODY +
             '<PointCollisionModel {}/></Node>')
    near = '<LocalMinDistance alarmDistance="0.2" contactDistance="0.1" {}/>'
    for method, model, words in (
            (near.format('angleCone="0.1"'), "", "angleCone: keeps contacts within a cone in SOFA"),
            (near.format('filterIntersection="false"'), "", "filterIntersection: switches a filter of contacts off in SOFA"),
            (near.format('useLMDFilters="1"'), "", "useLMDFilters: filters contacts in SOFA"),
            ('<CCDTightInclusionIntersection continuousCollisionType="Inertia"/>', "", "finds contacts on the way of a step in SOFA"),
            (near.format(""), 'PointActiverPath="@../x"', "PointActiverPath: leaves some points out of contacts in SOFA")):
        Run(root(touch.format(method, model)), 1).says(words)
    usual = Run(root(touch.format(near.format('angleCone="0.0" filterIntersection="true" useLMDFilters="0"'), "")), 1)
    assert "warning" not in usual.text, usual.text
    held = '<FixedLagrangianConstraint indices="0"/>'
    free = '<FreeMotionAnimationLoop {}/><GenericConstraintSolver tolerance="1e-10"/><Node name="a">' + EXACT + BODY + "{}{}</Node>"
    Run(root(free.format('solveVelocityConstraintFirst="1"', held, "")), 1).says("solveVelocityConstraintFirst: finds forces of constraint twice")
    for attribute, words in (('complianceFactor="0.5"', "changes how far SOFA's forces of constraint move"),
                             ('regularizationTerm="0.1"', "makes constraints soft")):
        Run(root(free.format("", held, f"<GenericConstraintCorrection {attribute}/>")), 1).says(words)
    assert "warning" not in Run(root(free.format("", held, '<GenericConstraintCorrection complianceFactor="1.0"/>')), 1).text
    for attributes, words in (('useOdeSolverIntegrationFactors="0"', 'useOdeSolverIntegrationFactors="false" has no effect'),
                              ('compliance="0.5" defaultCompliance="0.2"', "compliance has no effect: defaultCompliance is given"),
                              ('compliance="0.5 0.1" defaultCompliance="0.2"', "defaultCompliance has no effect: compliance is given")):
        Run(root(free.format("", held, f"<UncoupledConstraintCorrection {attributes}/>")), 1).says(words)
    Run(root(free.format("", '<CableConstraint indices="1" pullPoint="-1 0 0" value="0.1"/>', "")), 1).says(
        "finds forces of constraint until cables and cavities hold")
    moved = '<MechanicalObject name="dofs" template="Rigid3" position="0 0 0 0 0 0 1"/><UniformMass totalMass="2"/>'
    flow = 'keyTimes="{} 0.5" velocities="1 0 0 0 0 1  2 0 0 0 0 1"'
    Run(root(EXACT + moved + f'<LinearVelocityProjectiveConstraint indices="0" {flow.format(-0.1)}/>'), 1).says("begins before the start")
    Run(root(EXACT + moved + f'<LinearVelocityProjectiveConstraint indices="0" {flow.format(0)} continueAfterEnd="1"/>'), 1).says(
        "keeps the last velocity, and velocities of frames are those of the moment")
    Run(root(EXACT + moved + '<AffineMovementProjectiveConstraint indices="0" quaternion="0 0 0.6 0.8" endConstraintTime="1"/>'), 1).says(
        "turns frames on their way")
    Run(root(EXACT + '<MechanicalObject name="dofs" template="Rigid3" position="0 0 0 0 0 0 1  1 0 0 0 0 0 1"/><UniformMass totalMass="2"/>'
             '<AttachProjectiveConstraint indices1="0" indices2="1" twoWay="1"/>'), 1).says("SOFA solves with them free")
    Run(root(EXACT + '<MechanicalObject name="dofs" template="Rigid3" position="0 0 0 0 0 0 1  1 0 0 0 0 0 1"/><UniformMass totalMass="2"/>'
             '<BilateralLagrangianConstraint first_point="0" second_point="1" rest_vector="1 0 0" keepOrientationDifference="1"/>'),
        1).says("rest_vector has no effect: with keepCentreDifference")


@case
def ways_of_sofa_that_newtons_method_leaves_out():
    body = ('<SparseLDLSolver/><MechanicalObject position="0 0 0  1 0 0"/><UniformMass totalMass="2"/><SpringForceField '
            'springsIndices1="0" springsIndices2="1" lengths="1" stiffness="50"/><FixedLagrangianConstraint indices="0"/>')
    answer = '<UncoupledConstraintCorrection defaultCompliance="0.1"/>'
    for iterations, is_told in ((1, False), (10, True)):
        rule = f'<EulerImplicitSolver newtonIterations="{iterations}" oneRound="true"/>'
        text = Run.of_native(root(rule + body + answer), 1).text
        assert ("oneRound has no effect" in text) == is_told, text
        assert ("/UncoupledConstraintCorrection: has no effect: /EulerImplicitSolver makes several linear solves" in text) == is_told, text
    statics = body + answer + '<FixedProjectiveConstraint indices="1"/>'
    Run.of_native(root('<StaticSolver/>' + statics), 1).says("/UncoupledConstraintCorrection: has no effect: /StaticSolver finds equilibria")
    frames = '<EulerImplicitSolver/><SparseLDLSolver/><MechanicalObject template="Rigid3" position="0 0 0 0 0 0 1  0 0 0 0 0 0 1"/>'
    Run.of_native(root(frames + '<UniformMass totalMass="2"/><AttachProjectiveConstraint indices1="0" indices2="1" meet="halfway"/>'), 1).says(
        'meet="halfway" has no effect: it is of points')
    points = '<MechanicalObject name="dofs" position="0 0 0  1 0 0"/><UniformMass totalMass="2"/>'
    line = '<ProjectToLineProjectiveConstraint indices="0" direction="1 1 0" inMatrix="false"/>'
    Run.of_native(root('<EulerImplicitSolver newtonIterations="10"/><SparseLDLSolver/>' + points + line), 1).fails(
        2, 'has inMatrix="false", which is for one linear solve per step')


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
def forces_of_constraint_that_sofa_does_not_look_for():
    pair = '<BilateralLagrangianConstraint object1="@one/dofs" object2="@two/dofs" first_point="3" second_point="0"/>'
    inert, lone = "acts here: in SOFA nothing finds forces of constraint", "moves a body that has no constraint correction"
    for loop, correction, said in (("", "<LinearSolverConstraintCorrection/>", inert), (FREE_LOOP, "", lone),
                                   (FREE_LOOP, "<LinearSolverConstraintCorrection/>", ""), (FREE_LOOP, "<GenericConstraintCorrection/>", "")):
        scene = two_bodies(pair, DAMPED_SOLVERS[1] + (correction if "Generic" in correction else ""), 0, loop)
        if "Linear" in correction:
            scene = scene.replace("<UniformMass", correction + "<UniformMass")
        text = Run(scene, 1).text
        assert (inert in text) == (said == inert) and (lone in text) == (said == lone), text
    rubs = ('{}<CollisionPipeline/><BruteForceBroadPhase/><BVHNarrowPhase/><MinProximityIntersection/><CollisionResponse '
            'response="FrictionContactConstraint"/><Node name="a">' + EXACT + BODY + '<PointCollisionModel/></Node>')
    for loop in ("", FREE_LOOP):
        text = Run(root(rubs.format(loop)), 1).text
        assert (inert in text) == (not loop), text
    follow = '<MechanicalObject name="dofs" position="0 0 0  1 0 0"/><UniformMass totalMass="2"/><FixedProjectiveConstraint indices="0"/>'
    Run(root('<StaticSolver/><SparseLDLSolver/>' + follow + '<SpringForceField spring="0 1 10 0 1"/><AttachProjectiveConstraint indices1="0" '
             'indices2="1"/>'), 1).says("SOFA's go halfway there after each step of statics")


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
        agree(run.x("frame.dofs", 7)[0], np.r_[c, q * np.sign(q[3])], 1e-8)
        assert ("compliance has 3 numbers and no effect" in run.text) == given.startswith("compliance"), run.text


@case
def what_is_accepted_and_may_do_something():
    run = Run(root(EXACT + BODY + '<PythonScriptController filename="a.py" classname="A"/>'), 2)
    run.says("is a script that SOFA runs")
    Run(root('<FreeMotionAnimationLoop/><GenericConstraintSolver regularizationTerm="0.1"/>' + EXACT + BODY), 1).says("makes constraints soft")
    held = '<FixedLagrangianConstraint indices="0"/><{}ConstraintCorrection/>'
    free = '<FreeMotionAnimationLoop/><GenericConstraintSolver tolerance="1e-10"/><Node name="a">'
    spring = '<SpringForceField spring="0 1 10 0 1"/>'
    for kind, word in (("Uncoupled", ""), ("Precomputed", "compliance of the start"), ("LinearSolver", "")):
        text = Run(root(free + EXACT + BODY + spring + held.format(kind) + '</Node>'), 2).text
        assert ("SOFA moves nodes by forces of constraint" in text) == bool(word) and word in text, text
        assert "SOFA moves nodes" not in Run(root(free + EXACT + BODY + held.format(kind) + '</Node>'), 2).text


@case
def tools_that_carve_nothing():
    for active in ("", 'active="0"'):
        falls(Run(root(EXACT + BODY + f'<CarvingManager {active} carvingDistance="0.1"/>'), 10))
    Run(root(EXACT + BODY + '<CarvingManager active="1"/>'), 1).fails(2, "CarvingManager")


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
def files_that_an_included_file_names():
    """Beside the included file first, then beside the scene."""
    part = '<Node name="part"><MeshOBJLoader name="loader" filename="mesh.obj"/><MechanicalObject name="dofs" src="@loader"/></Node>'
    scene = root(EXACT + '<include href="parts/part.xml"/>')
    beside = {"parts/part.xml": part, "mesh.obj": "v 1 2 3\nv 4 5 6\nv 7 8 10\nf 1 2 3\n"}
    agree(Run(scene, 0, files=beside).x("part.dofs")[0], [1, 2, 3])
    first = {**beside, "parts/mesh.obj": "v 7 7 7\nv 8 8 8\nv 9 9 7\nf 1 2 3\n"}
    agree(Run(scene, 0, files=first).x("part.dofs")[0], [7, 7, 7])


@case
def penalty_forces_are_those_of_the_formula():
    """k = k1 k2 / d, in one implicit step each, while the point is nearer than d where the step starts."""
    h, g, d, y, v = 0.01, 10, 0.2, 1.0, 0.0
    k = 10 * 10 / d
    for _ in range(150):
        stiffness = k if y < d else 0
        v += (h * (-g + stiffness * (d - y)) - h * h * stiffness * v) / (1 + h * h * stiffness)
        y += h * v
    assert y > 0.02, y
    agree(Run(falling_point(1), 150).x("ball.dofs"), [[0, y, 0]])


@case
def penalties_between_two_solvers_are_those_of_the_start():
    """Of two simulated bodies; where something groups them, or one is no simulated one, they are a part of the matrix."""
    h, d, k, m = 0.01, 0.2, 500, np.array([1.0, 3])
    ball = ('<Node name="{0}">' + EXACT + '<MechanicalObject name="dofs" position="0 {1} 0" velocity="0 {2} 0"/><UniformMass '
            'totalMass="{3}"/><SphereCollisionModel radius="0.05"/></Node>')
    scene = WATCH.replace('contactDistance="0.2"', 'contactDistance="0.1"') + ball.format("a", 0, 0, 1) + ball.format("b", 0.25, -1, 3)

    def meet(implicit):
        y, v = np.array([0, 0.25]), np.array([0, -1.0])
        for _ in range(40):
            pen = d - (y[1] - y[0])
            force = k * max(pen, 0) * np.array([-1, 1])
            K = -k * (pen > 0) * implicit * np.array([[1, -1], [-1, 1]])
            v = v + np.linalg.solve(np.diag(m) - h * h * K, h * (force + h * K @ v))
            y = y + h * v
        return y

    run = Run(node(scene), 40)
    agree([run.x("a.dofs")[0, 1], run.x("b.dofs")[0, 1]], meet(0))
    for more, args in (("<CollisionGroupManager/>", []), ("", ["--without-quirk", "isolated-springs"])):
        run = Run(node(scene + more), 40, args=args)
        agree([run.x("a.dofs")[0, 1], run.x("b.dofs")[0, 1]], meet(1))
    differ(meet(0), meet(1), 1e-3)
    iterates = scene.replace("<SparseLDLSolver/>", '<CGLinearSolver iterations="100" tolerance="1e-14" threshold="1e-30"/>')
    for more, implicit in (("", 0), ("<CollisionGroup/>", 1)):  # SOFA merges the solvers of bodies that touch
        run = Run(node(iterates + more), 40)
        agree([run.x("a.dofs")[0, 1], run.x("b.dofs")[0, 1]], meet(implicit))


@case
def balls_on_edges_of_triangles_lie():
    """On the edge that two triangles share, and on a corner, a ball lies as it does on a triangle: its radius and contactDistance above."""
    floor = ('<Node name="floor"><MeshTopology position="-5 0 -5  5 0 -5  5 0 5  -5 0 5" triangles="0 2 1  0 3 2"/><MechanicalObject/>'
             '<TriangleCollisionModel moving="0" simulated="0"/>{}</Node>')
    for x, z, more in ((0, 0, ""), (0.5, -0.7, ""), (-5, -5, ""), (5.05, 0, ""), (0, 0, '<LineCollisionModel moving="0" simulated="0"/>')):
        ball = (f'<Node name="ball"><EulerImplicitSolver/><SparseLDLSolver/><MechanicalObject name="dofs" position="{x} 0.25 {z}"/>'
                '<UniformMass totalMass="1"/><UncoupledConstraintCorrection/><SphereCollisionModel radius="0.2"/></Node>')
        run = Run(root('<FreeMotionAnimationLoop/><GenericConstraintSolver maxIterations="1000" tolerance="1e-12"/><CollisionPipeline/>'
                       '<BruteForceBroadPhase/><BVHNarrowPhase/><NewProximityIntersection alarmDistance="0.1" contactDistance="0.01"/>'
                       '<CollisionResponse response="FrictionContactConstraint" responseParams="mu=0.5"/>' + floor.format(more) + ball), 40)
        place = run.x("ball.dofs")[0]
        agree(place[2], z, 1e-9)
        if x <= 5:
            agree(place, [x, 0.21, z], 1e-6)
        else:  # beside the floor: it leans on the edge, and friction holds it there
            agree(np.hypot(place[0] - 5, place[1]), 0.21, 1e-6)


@case
def balls_on_frames_roll():
    """Thrown with v, a solid ball comes to roll at 5/7 v; a sphere on a point that follows the frame rubs at its centre, and stops."""
    frame = ('<EulerImplicitSolver/><SparseLDLSolver/><MechanicalObject name="dofs" template="Rigid3" position="0 0.3 0 0 0 0 1" '
             'velocity="2 0 0 0 0 0"/><UniformMass vertexMass="1 1 0.016 0 0 0 0.016 0 0 0 0.016"/><UncoupledConstraintCorrection/>')
    sphere = '<SphereCollisionModel radius="0.2"/>'
    floor = ('<Node name="floor"><MeshTopology position="-9 0 -7  9 0 -9  9 0 9  -9 0 9" triangles="0 2 1  0 3 2"/><MechanicalObject/>'
             '<TriangleCollisionModel moving="0" simulated="0"/></Node>')
    for more, speed in ((sphere, 10 / 7), ('<Node name="c"><MechanicalObject position="0 0 0"/>' + sphere + '<RigidMapping/></Node>', 0)):
        scene = root('<FreeMotionAnimationLoop/><GenericConstraintSolver maxIterations="1000" tolerance="1e-9"/><CollisionPipeline/>'
                     '<BruteForceBroadPhase/><BVHNarrowPhase/><NewProximityIntersection alarmDistance="0.3" contactDistance="0.1"/>'
                     '<CollisionResponse response="FrictionContactConstraint" responseParams="mu=0.5"/>' + floor +
                     f'<Node name="ball">{frame}{more}</Node>')
        x = [Run(scene, steps).x("ball.dofs", 7)[0, 0] for steps in (60, 70)]
        agree([1, (x[1] - x[0]) / 0.1], [1, speed], 1e-5)


@case
def friction_of_the_solver():
    """A point that slides on the floor loses mu g dt in each step: of LCPConstraintSolver the coefficient is its own, 0.6 when not given."""
    def slid(solver, parameters):
        floor = ('<Node name="floor"><MeshTopology position="-9 0 -9  9 0 -9  9 0 9  -9 0 9" triangles="0 2 1  0 3 2"/><MechanicalObject/>'
                 '<TriangleCollisionModel moving="0" simulated="0"/></Node>')
        ball = ('<Node name="ball"><EulerImplicitSolver/><SparseLDLSolver/><MechanicalObject name="dofs" position="0 0.1 0.3" velocity="1 0 0"/>'
                '<UniformMass totalMass="1"/><UncoupledConstraintCorrection/><PointCollisionModel/></Node>')
        return Run(root(f'<FreeMotionAnimationLoop/>{solver}<CollisionPipeline/><BruteForceBroadPhase/><BVHNarrowPhase/><LocalMinDistance '
                        f'alarmDistance="0.3" contactDistance="0.1"/><CollisionResponse response="FrictionContactConstraint" {parameters}/>' +
                        floor + ball), 8)
    lcp = '<LCPConstraintSolver tolerance="1e-9" maxIt="1000" {}/>'
    for solver, parameters, mu in ((lcp.format('mu="0.2"'), 'responseParams="mu=0.7"', 0.2), (lcp.format(""), "", 0.6),
                                   ('<GenericConstraintSolver maxIterations="1000" tolerance="1e-9"/>', 'responseParams="mu=0.7"', 0.7)):
        run = slid(solver, parameters)
        agree(run.x("ball.dofs")[0], [sum(0.01 * (1 - mu * 10 * 0.01 * (k + 1)) for k in range(8)), 0.1, 0.3], 1e-5)
        assert ("takes its own mu=0.2" in run.text) == (mu == 0.2), run.text


@case
def what_may_not_meet_falls_through():
    for scene in (falling_point(1, more='active="0"'), falling_point(1, more='group="3 4"').replace('simulated="0"', 'group="4"'),
                  falling_point(1, WATCH.replace('<CollisionResponse response="PenalityContactForceField"/>', ""))):
        agree(Run(scene, 60).x("ball.dofs"), [[0, 1 + fallen(60), 0]])


@case
def what_looks_for_contacts_has_nothing_to_look_at():
    run = Run(root(WATCH + EXACT + BODY), 10)
    falls(run)
    run.says("CollisionPipeline where nothing can touch", "CollisionResponse where nothing can touch")


# ---- what SOFA leaves to each body ----

def pulled_together(masses, damping, z, k, rest, steps, h=0.01):
    """Two masses on a line and the spring between them by SOFA's implicit Euler, the Rayleigh damping of each mass its own."""
    masses, damping, z, v = np.array(masses), np.array(damping), np.array(z, float), np.zeros(2)
    K = -k * np.array([[1, -1], [-1, 1]])
    for _ in range(steps):
        f = k * (z[1] - z[0] - rest) * np.array([1, -1])
        v += np.linalg.solve(np.diag(masses * (1 + h * damping)) - h * h * K, h * (f + h * K @ v - damping * masses * v))
        z += h * v
    return z


@case
def bodies_of_different_solvers_that_a_spring_ties():
    """The factors solve for both, and the damping of an integrator is that of its own mass."""
    scene = node('<Node name="a"><EulerImplicitSolver rayleighMass="2"/><SparseLDLSolver/><MechanicalObject name="dofs" '
                 'position="0 0 0"/><UniformMass totalMass="2"/></Node>'
                 '<Node name="b"><EulerImplicitSolver/><CGLinearSolver iterations="1" tolerance="1e-1"/><MechanicalObject '
                 'name="dofs" position="0 0 1.5"/><UniformMass totalMass="1"/></Node>'
                 '<SpringForceField object1="@a/dofs" object2="@b/dofs" spring="0 0 100 0 1"/>')
    implicit = ["--without-quirk", "isolated-springs"]
    run = Run(scene, 20, args=implicit)
    expected = pulled_together([2, 1], [2, 0], [0, 1.5], 100, 1, 20)
    agree(np.concatenate([run.x("a.dofs")[:, 2], run.x("b.dofs")[:, 2]]), expected)
    run.says("/b/CGLinearSolver1: bodies that touch or are tied are one system here")
    differ(expected, pulled_together([2, 1], [2, 2], [0, 1.5], 100, 1, 20), 1e-3)
    agree(Run(scene, 20, args=implicit, command="migrate").native["b.dofs"][2], expected[1])


@case
def bodies_of_solvers_of_other_kinds_that_a_spring_ties():
    """The first solver moves both; the damping of its own is that of its own mass."""
    scene = node('<Node name="a"><EulerImplicitSolver rayleighMass="2"/><SparseLDLSolver/><MechanicalObject name="dofs" position="0 0 0"/>'
                 '<UniformMass totalMass="2"/></Node><Node name="b"><EulerExplicitSolver/><MechanicalObject name="dofs" '
                 'position="0 0 1.5"/><UniformMass totalMass="1"/></Node>'
                 '<SpringForceField object1="@a/dofs" object2="@b/dofs" spring="0 0 100 0 1"/>')
    h, x, v = 0.01, np.array([0, 1.5]), np.zeros(2)
    for _ in range(20):
        force = 100 * (x[1] - x[0] - 1)
        v = (v + h * force * np.array([1 / 2, -1])) / [1 + 2 * h, 1]
        x = x + h * v
    run = Run(scene, 20)
    agree(np.concatenate([run.x("a.dofs")[:, 2], run.x("b.dofs")[:, 2]]), x)
    run.says("/a/EulerImplicitSolver moves all of them")


@case
def bodies_that_nothing_ties_keep_their_solvers():
    scene = root(f'<Node name="a">{EXACT}{BODY}</Node><Node name="b"><EulerImplicitSolver rayleighMass="1"/><CGLinearSolver/>'
                 f'{BODY}<SpringForceField object1="@dofs" object2="@dofs" spring="0 1 100 0 1"/></Node>')
    run = Run(scene, 10)
    falls(run, "a.dofs")
    assert "one system here" not in run.text


@case
def a_node_that_no_solver_moves_holds_a_spring():
    """A post without a solver: it stays, and the spring pulls the body with the force of a step's start."""
    post = '<Node name="post"><MechanicalObject name="post" position="0 0 0"/></Node>'
    body = ('<Node name="body">' + EXACT + '<MechanicalObject name="body" position="1 0 0"/><UniformMass totalMass="2"/></Node>')
    spring = '<StiffSpringForceField object1="@post/post" object2="@body/body" spring="0 0 100 0 0.5"/>'
    run = Run(node(post + body + spring), 10)
    x, v = 1.0, 0.0
    for _ in range(10):
        v -= 0.01 * 100 * (x - 0.5) / 2
        x += 0.01 * v
    agree(run.x("body.body"), [[x, 0, 0]])
    agree(run.x("post.post"), [[0, 0, 0]])
    run.says("no integrator moves it")
    assert "by stiffness alone" not in run.text and "held_by_the_scene" not in run.text, run.text


@case
def a_frame_that_no_solver_moves_leads_what_is_mapped_from_it():
    s = 0.5 ** 0.5
    scene = node('<Node name="frame"><MechanicalObject name="dofs" template="Rigid3d" position="0 1 0 0 0 '
                 f'{s!r} {s!r}"/><Node name="points"><MechanicalObject name="dofs" position="1 0 0"/><RigidMapping/></Node></Node>'
                 f'<Node name="body">{EXACT}<MechanicalObject name="dofs" position="0 2 3"/><UniformMass totalMass="1"/></Node>'
                 '<SpringForceField object1="@frame/points/dofs" object2="@body/dofs" spring="0 0 100 0 1"/>')
    run = Run(scene, 20)
    run.says("/frame: no integrator moves it")
    z, v, h, k = 3.0, 0.0, 0.01, 100
    for _ in range(20):
        v -= h * k * (z - 1)
        z += h * v
    agree(run.x("body.dofs"), [[0, 2, z]])
    agree(run.x("frame.dofs", 7), [[0, 1, 0, 0, 0, s, s]])
    agree(run.x("frame.points.dofs"), [[0, 2, 0]])



# ---- parts that become others ----

def block_mass(scene_type, more=""):
    return (f'<RegularGridTopology n="2 2 2" min="0 0 0" max="1 1 1"/><MechanicalObject name="dofs"/>'
            f'<{scene_type} youngModulus="500" poissonRatio="0.3" method="large" density="4" {more}/>')


@case
def quirk_pair_mass():
    """All pairs of corners have 8/27 of the mass; gravity takes an eighth at each corner."""
    hold = '<RestShapeSpringsForceField stiffness="300"/>'

    def held(x, v):
        return -300 * (x - CUBE), -300 * np.eye(24)
    fields = together(gravity(np.full(8, 0.5), [0, -10, 0]), held)
    for name in ("HexahedronFEMForceFieldAndMass", "HexahedralFEMForceFieldAndMass"):
        scene = root(EXACT + block_mass(name).replace('youngModulus="500"', 'youngModulus="1e-9"') + hold)
        agree(Run(scene, 10).x(), euler(CUBE, np.full((8, 8), 8 / 27 * 4), fields, 10, 0.01), 1e-7)
        differ(Run(scene, 10, args=["--without-quirk", "pair-mass"]).x(), Run(scene, 10).x(), 1e-4)
    lumped = root(EXACT + block_mass(name, 'lumpedMass="1"').replace('youngModulus="500"', 'youngModulus="1e-9"') + hold)
    agree(Run(lumped, 10).x(), euler(CUBE, np.eye(8) * 64 / 27 * 4, fields, 10, 0.01), 1e-7)


PLACES = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], float)


def shapes_at(xi):
    """N and its slopes in a cell of the unit size, corners in the order of cells."""
    factors = np.where(PLACES == 1, xi, 1 - np.asarray(xi))
    slopes = np.array([[(1 if place[axis] else -1) * np.prod(np.delete(row, axis)) for axis in range(3)]
                       for place, row in zip(PLACES, factors)])
    return factors.prod(axis=1), slopes


@case
def cells_that_are_filled_unevenly():
    """A box in one cell, looked at on 4 x 4 x 4 parts: 1 for the eight in the middle, 0.5 for those that it cuts. Stiffness and all
    pairs of the mass are sums over the parts, whose nodes follow those of the cell."""
    young, nu, rho, size, n = 500, 0.3, 4, 2.0, 4
    corners = [f"{1.7 if c & 1 else 0.3} {1.7 if c & 2 else 0.3} {1.7 if c & 4 else 0.3}" for c in range(8)]
    faces = [(0, 2, 1), (1, 2, 3), (4, 5, 6), (5, 7, 6), (0, 1, 4), (1, 5, 4), (2, 6, 3), (3, 6, 7), (0, 4, 2), (2, 4, 6), (1, 3, 5), (3, 7, 5)]
    off = "OFF\n8 12 0\n" + "\n".join(corners) + "\n" + "\n".join("3 {} {} {}".format(*face) for face in faces) + "\n"

    def scene(more, levels=2):
        return root(EXACT + f'<SparseGridTopology name="grid" n="2 2 2" min="0 0 0" max="{size} {size} {size}" fileTopology="box.off" '
                    f'nbVirtualFinerLevels="2"/><MechanicalObject name="dofs"/><NonUniformHexahedronFEMForceFieldAndMass '
                    f'youngModulus="{young}" poissonRatio="{nu}" method="large" density="{rho}" nbVirtualFinerLevels="{levels}" {more}/>'
                    '<FixedConstraint indices="0 1"/>')
    nodes = np.array(list(itertools.product([0, size], repeat=3)))  # z is the fastest
    cell = [int(np.flatnonzero((nodes == size * place).all(axis=1))[0]) for place in PLACES]
    D = stiffness(young, nu)
    K, M, filled = np.zeros((24, 24)), np.zeros((8, 8)), 0.0
    for part in itertools.product(range(n), repeat=3):
        factor = 1.0 if all(p in (1, 2) for p in part) else 0.5
        volume = (size / n) ** 3
        filled += factor * volume
        centre = shapes_at((np.array(part) + 0.5) / n)[0]
        M += 8 / 27 * rho * factor * volume * np.outer(8 * centre, 8 * centre)
        for signs in itertools.product([-1, 1], repeat=3):
            _, slopes = shapes_at((np.array(part) + 0.5 + np.array(signs) / (2 * 3 ** 0.5)) / n)
            B = np.zeros((6, 24))
            for i, (a, b, c) in enumerate(slopes / size):
                B[:, 3 * i:3 * i + 3] = [[a, 0, 0], [0, b, 0], [0, 0, c], [b, a, 0], [0, c, b], [c, 0, a]]
            K += factor * volume / 8 * B.T @ D @ B

    def field(x, v):
        now = x[cell]
        edges = np.array([(now[PLACES[:, axis] == 1].mean(axis=0) - now[PLACES[:, axis] == 0].mean(axis=0)) for axis in range(3)]).T
        Q, R = np.linalg.qr(edges)
        R = Q * np.sign(np.diag(R))
        turn = np.kron(np.eye(8), R)
        f, stiff = np.zeros((8, 3)), np.zeros((24, 24))
        f[cell] = (-turn @ K @ (turn.T @ now.ravel() - nodes[cell].ravel())).reshape(8, 3)
        rows = np.array([[3 * node + k for k in range(3)] for node in cell]).ravel()
        stiff[np.ix_(rows, rows)] = -turn @ K @ turn.T
        return f, stiff
    fields = together(gravity(np.full(8, rho * filled / 8), [0, -10, 0]), field)
    mass = np.zeros((8, 8))
    mass[np.ix_(cell, cell)] = M
    run = Run(scene(""), 20, {"box.off": off})
    agree(run.x(), euler(nodes, mass, fields, 20, 0.01, held=[0, 1]), 1e-9)
    differ(run.x(), nodes, 0.01)
    plain = Run(scene("").replace("NonUniformHexahedron", "Hexahedron").replace('density="4" nbVirtualFinerLevels="2"', 'density="4"'),
                20, {"box.off": off})
    differ(plain.x(), run.x(), 1e-4)
    # with one level the parts are alike: eight times 0.5625
    differ(Run(scene("", 1), 20, {"box.off": off}).x(), run.x(), 1e-4)
    # a mass of its own beside it
    alone = Run(scene('useMass="0"').replace("<FixedC", '<UniformMass totalMass="5"/><FixedC'), 20, {"box.off": off})
    agree(alone.x(), euler(nodes, np.eye(8) * 5 / 8, together(gravity(np.full(8, 5 / 8), [0, -10, 0]), field), 20, 0.01, held=[0, 1]), 1e-9)
    Run(scene("", 3), 1, {"box.off": off}).says("has 2 finer levels")
    finer = scene("", 5).replace('nbVirtualFinerLevels="2"', 'nbVirtualFinerLevels="5"')
    Run(finer, 1, {"box.off": off}).says("parts of 4 levels are taken")
    # the parts of a grid are counted once
    second = '<NonUniformHexahedronFEMForceFieldAndMass name="second" density="1" useMass="0" nbVirtualFinerLevels="{}"/><FixedC'
    run = Run(scene("").replace("<FixedC", second.format(1)), 1, {"box.off": off})
    assert run.code == 0, run.text
    run.says("/second.nbVirtualFinerLevels: is 1, and another field on /grid asks for 2")
    assert "asks for" not in Run(scene("").replace("<FixedC", second.format(2)), 1, {"box.off": off}).text


@case
def springs_that_only_push():
    """RepulsiveSpringForceField: nothing while the ends are farther than the length at rest."""
    for distance in (0.8, 1.3):
        run = Run(node(EXACT + f'<MechanicalObject name="dofs" position="0 0 0  {distance} 0 0" velocity="0 0 0  -1 0 0"/><UniformMass '
                       'totalMass="2"/><RepulsiveSpringForceField spring="0 1 50 0 1"/>'), 20)
        def push(x, v):
            length = np.linalg.norm(x[1] - x[0])
            return springs([(0, 1)], [[0, 0, 0], [1, 0, 0]], 50, 0)(x, v) if length < 1 else (np.zeros((2, 3)), np.zeros((6, 6)))
        agree(run.x(), euler([[0, 0, 0], [distance, 0, 0]], np.eye(2), push, 20, 0.01, v=[[0, 0, 0], [-1, 0, 0]]), 1e-8)


@case
def values_that_spread_in_tetrahedra():
    """Backward Euler of first order, with masses of a quarter of each cell: (M + h K) dT = -h K T. Along fibres it is quicker."""
    for ratio, fibres, numbers in ((1, [[0, 0, 0]] * 2, [0.7] * 2), (4, [[0.6, 0, 0.8], [0, 1, 0]], [0.7] * 2),
                                   (4, [[0.6, 0, 0.8], [0, 1, 0]], [0.7, 0.2]), (3, [[0, 0, 2]] * 2, [0.7] * 2)):
        spreads_in_tetrahedra(ratio, fibres, numbers)
    for mass in ('<MeshMatrixMass template="Vec1,Vec3" massDensity="1" lumping="0"/>', '<MeshMatrixMass massDensity="1" lumping="1"/>'):
        spreads_in_tetrahedra(4, [[0.6, 0, 0.8], [0, 1, 0]], [0.7, 0.2], mass)


def spreads_in_tetrahedra(ratio, fibres, numbers, mass='<DiagonalMass massDensity="1"/>'):
    cells = [(0, 1, 2, 3), (1, 2, 3, 4)]
    places = np.array([[0, 0, 0], [2, 0, 0], [0, 3, 0], [0, 0, 1.5], [2, 2, 2]], float)
    h, T = 0.01, np.array([5.0, 0, 1, 2, 0])
    K, M = np.zeros((5, 5)), np.zeros((5, 5))
    for cell, d, D in zip(cells, np.array(fibres), numbers):
        edges = (places[list(cell[1:])] - places[cell[0]]).T
        G = np.vstack([[0, 0, 0], np.linalg.inv(edges)])
        G[0] = -G[1:].sum(axis=0)
        V = abs(np.linalg.det(edges)) / 6
        K[np.ix_(cell, cell)] += D * V * G @ (np.eye(3) + (ratio - 1) * np.outer(d, d)) @ G.T
        M[np.ix_(cell, cell)] += V / 20 * (1 + np.eye(4)) if 'lumping="0"' in mass else V / 4 * np.eye(4)
    text = "  ".join(" ".join(map(str, p)) for p in places)
    heat = ('<Node name="heat"><EulerImplicitSolver firstOrder="1"/><SparseLDLSolver/><MechanicalObject name="T" template="Vec1d" '
            f'position="5 0 1 2 0"/>{mass}<FixedConstraint indices="0"/><TetrahedronDiffusionFEMForceField '
            'template="Vec1d" tagMechanics="mechanics" {}/></Node>')
    scene = node(f'<TetrahedronSetTopologyContainer position="{text}" tetrahedra="0 1 2 3  1 2 3 4"/><MechanicalObject name="dofs" '
                 f'tags="mechanics"/>{heat}')
    for _ in range(30):
        A = M + h * K
        dT = np.zeros(5)
        dT[1:] = np.linalg.solve(A[1:, 1:], (-h * K @ T)[1:])
        T = T + dT
    of_cells = f'tetraDiffusionCoefficient="{numbers[0]} {numbers[1]}"'
    more = f'constantDiffusionCoefficient="{numbers[0]}"' if numbers[0] == numbers[1] else of_cells
    more += f' anisotropyRatio="{ratio}" transverseAnisotropyArray="{fibres}"'.replace("[", "").replace("]", "").replace(",", "")
    run = Run(scene.format(more), 30)
    agree(run.x("heat.T", 1).ravel(), T)
    assert ("counts with it" in run.text) == (ratio == 3), run.text
    Run(scene.format('anisotropyRatio="2"'), 1).fails(2, "transverseAnisotropyArray has 0 directions for 2 tetrahedra")


@case
def movements_in_parts():
    """x = x_0 + s(x_0) m: s is linear between four corners in x and y, or eight; the second step ends with the first movement."""
    places = np.array([[0, 0, 0], [1, 0.5, 0], [2, 3, 1], [0.5, 1, 4]], float)
    text = "  ".join(" ".join(map(str, p)) for p in places)
    for sizes, shares, flat in (((2, 3, 0), [0, 1, 2, 5], True), ((0, 2, 3), [0, 1, 2, 5], True), ((2, 3, 4), [1, 0, 2, 5, 3, 1, 4, 2], False)):
        box = [size for size in sizes if size] if flat else list(sizes)
        of_cell = np.array(shares if flat else [shares[i] for i in (0, 3, 7, 4, 1, 2, 6, 5)])  # SOFA goes about z before y
        s = [np.sum(of_cell * shapes_at(np.append(p[:2] / box, 0) if flat else p / box)[0][:len(shares)]) for p in places]
        scene = node(EXACT + f'<MechanicalObject name="dofs" position="{text}"/><UniformMass totalMass="4"/>'
                     '<PartialLinearMovementConstraint indices="0 1 2 3" keyTimes="0 0.04" movements="0 0 0  4 0 8" movedDirections="1 0 1" '
                     f'linearMovementBetweenNodesInIndices="1" X0="{sizes[0]}" Y0="{sizes[1]}" Z0="{sizes[2]}" '
                     f'imposedDisplacmentOnMacroNodes="{" ".join(map(str, shares))}" mainIndice="0" minDepIndice="0" maxDepIndice="3"/>')
        agree(Run(scene, 3).x(), places + np.outer(s, [4, 0, 8]) / 2)
    Run(scene.replace("imposedDisplacmentOnMacroNodes", "imposed"), 1).fails(2, "linearMovementBetweenNodesInIndices")
    # of a link there are no numbers, and the whole movement is another
    link = ('<RegularGridTopology name="g" n="2 2 2" min="0 0 0" max="1 1 1"/><ValuesFromPositions name="values" position="@g.position" '
            'inputValues="1 3" direction="0 1 0"/>')
    Run(scene.replace('"1 0 2 5 3 1 4 2"', '"@values.values"').replace("</Node>", link + "</Node>"), 1).fails(
        2, "linearMovementBetweenNodesInIndices", "not available")
    Run(scene.replace('X0="2"', 'X0="@g.radius"'), 1).fails(2, "linearMovementBetweenNodesInIndices", "not available")
    for given in ("1 2 3", "1 2 3 4"):
        run = Run(scene.replace('"1 0 2 5 3 1 4 2"', f'"{given}"'), 1)
        run.fails(2, f"imposedDisplacmentOnMacroNodes: has {len(given.split())} numbers", "eight")
        assert "cornerShares" not in run.text, run.text
    run = Run(scene.replace('X0="2"', 'X0="-2"'), 1)
    run.fails(2, "X0, Y0 and Z0 are no size of a box")
    assert "cornerBox" not in run.text, run.text


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
def a_common_centre_of_mass():
    """A force on it moves all bodies alike, and it lies where the masses say."""
    point = '<Node name="points"><MechanicalObject name="dofs" position="0 0 0  4 0 0"/><UniformMass vertexMass="1"/></Node>'
    other = '<Node name="frames"><MechanicalObject name="dofs" template="{0}" position="{1}"/><UniformMass vertexMass="{2}"/></Node>'
    child = ('<Node name="centre"><MechanicalObject name="dofs" position="0 0 0"/><{} output="@."/>'
             '<ConstantForceField forces="0 0 20"/></Node>')
    rise = 20 / 5 * 0.01 ** 2 * 5 * 6 / 2
    for kind, where, mass, mapping in (
            ("Vec3d", "1 5 0", "3", 'CenterOfMassMultiMapping template="Vec3d,Vec3d" input="@../points @../frames"'),
            ("Rigid3d", "1 5 0 0 0 0 1", "3 1 [1 0 0 0 1 0 0 0 1]",
             'CenterOfMassMulti2Mapping template="Vec3d,Rigid3d,Vec3d" input1="@../points" input2="@../frames"')):
        run = Run(root(EXACT + point + other.format(kind, where, mass) + child.format(mapping), 'gravity="0 0 0"'), 5)
        agree(run.x("centre.dofs"), [[7 / 5, 3, rise]])
        agree(run.x("points.dofs"), [[0, 0, rise], [4, 0, rise]])
        agree(run.x("frames.dofs", 7 if kind == "Rigid3d" else 3)[:, :3], [[1, 5, rise]])
    frame = child.replace('position="0 0 0"', 'template="Rigid3d" position="0 0 0 0 0 0 1"').replace('forces="0 0 20"', 'forces="0 0 20 0 0 0"')
    Run(root(EXACT + point + other.format("Rigid3d", "1 5 0 0 0 0 1", "3 1 [1 0 0 0 1 0 0 0 1]") + frame.format(mapping)), 1).fails(
        2, "/centre/dofs is of frames")


@case
def engines_of_random_numbers():
    run = Run(root('<TransformPosition name="e" method="random" maxRandomDisplacement="0.1" input_position="0 0 0  5 5 5"/>'
                   f'<Node name="a">{EXACT}<MechanicalObject name="dofs" position="@../e.output_position"/><UniformMass totalMass="1"/>'
                   '</Node>', 'gravity="0 0 0"'), 1)
    run.says("other random numbers")
    agree(run.x("a.dofs"), [[0, 0, 0], [5, 5, 5]], 0.03)
    differ(run.x("a.dofs"), [[0, 0, 0], [5, 5, 5]], 1e-6)


@case
def fields_under_other_names():
    cells = ('<RegularGridTopology n="2 2 2" min="0 0 0" max="1 1 1"/><MechanicalObject name="dofs"/><UniformMass totalMass="8"/>'
             '<{} youngModulus="500" poissonRatio="0.3" {}/><FixedConstraint indices="0 1"/>')
    agree(Run(root(EXACT + cells.format("HexahedralFEMForceField", 'method="large"')), 5).x(),
          Run(root(EXACT + cells.format("HexahedronFEMForceField", 'method="large"')), 5).x(), 1e-12)
    fields = together(gravity(np.ones(4), [0, -10, 0]), tetrahedra([(0, 1, 2, 3)], X4, 200, 0.3))
    tensor = root(EXACT + f'<MeshTopology position="{X4_TEXT}" tetrahedra="0 1 2 3"/><MechanicalObject name="dofs"/>'
                  '<UniformMass totalMass="4"/><TetrahedralTensorMassForceField youngModulus="200" poissonRatio="0.3"/>'
                  '<FixedConstraint indices="0"/>')
    agree(Run(tensor, 20).x(), euler(X4, np.eye(4), fields, 20, 0.01, held=[0]), 1e-8)


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


SPRINGS = ('<MeshTopology position="0 0 0  1 0 0  2 0 0" edges="0 1  1 2"/><MechanicalObject name="dofs"/>'
           '<UniformMass totalMass="3"/><MeshSpringForceField stiffness="500"/><FixedConstraint indices="0"/>')


@case
def several_linear_solvers():
    x = np.array([[i, 0, 0] for i in range(3)], float)
    fields = together(gravity(np.ones(3), [0, -10, 0]), springs([(0, 1), (1, 2)], x, 500))
    exact = euler(x, np.eye(3), fields, 20, 0.01, held=[0])
    for solvers in ('<PCGLinearSolver iterations="100" tolerance="1e-9" preconditioner="@pre"/><SparseLDLSolver name="pre"/>',
                    '<ShewchukPCGLinearSolver iterations="100" tolerance="1e-12" preconditioners="pre"/><SSORPreconditioner name="pre"/>',
                    '<PCGLinearSolver iterations="100" tolerance="1e-12" preconditioner="@w"/><WarpPreconditioner name="w" '
                    'solverName="@f"/><SparseLDLSolver name="f"/>',
                    '<SparseLDLSolver name="first"/><CGLinearSolver iterations="1" tolerance="0.5" threshold="1"/>'):
        run = Run(root("<EulerImplicitSolver/>" + solvers + SPRINGS), 20)
        agree(run.x(), exact, 1e-7)
    run.says("does not count: /first solves in this node")


@case
def a_loop_that_divides_its_steps():
    run = Run(root('<MultiStepAnimationLoop collisionSteps="2" integrationSteps="5"/>' + EXACT + BODY), 10)
    falls(run, h=0.001)
    run.says("divides each step into 10")


@case
def mappings_that_pass_no_forces_on():
    for word in ('isMechanical="0"', 'mapForces="false"'):
        falls(Run(root(EXACT + BODY + '<Node name="seen"><MechanicalObject name="dofs" position="0 0 0  1 0 0"/>'
                       f'<IdentityMapping {word}/><ConstantForceField indices="0" forces="0 99 0"/></Node>'), 10))
    differ(Run(root(EXACT + BODY + '<Node name="seen"><MechanicalObject name="dofs" position="0 0 0  1 0 0"/>'
                    '<IdentityMapping isMechanical="1"/><ConstantForceField indices="0" forces="0 99 0"/></Node>'), 10).x()[0, 1],
           fallen(10), 0.1)


@case
def engines_that_nobody_reads():
    run = Run(root(EXACT + BODY + '<DisplacementMatrixEngine name="s" labels="1 2"/><NormEngine input="@s.indices"/>'
                   '<Node name="seen"><OglModel position="@../s.position"/></Node>'), 10)
    falls(run)
    run.says("DisplacementMatrixEngine, which nothing with an effect reads", "NormEngine")
    Run(root(EXACT + '<DisplacementMatrixEngine name="s"/><MechanicalObject position="@s.indices"/><UniformMass totalMass="1"/>'), 1).fails(
        2, "DisplacementMatrixEngine")


@case
def grid_and_container_in_one_node():
    """Nodes from the grid, cells from the container that stands after it."""
    scene = root(EXACT + '<RegularGridTopology name="grid" n="2 2 2" min="0 0 0" max="1 1 1"/><MechanicalObject name="dofs"/>'
                 '<TetrahedronSetTopologyContainer name="c"/><Hexa2TetraTopologicalMapping input="@grid" output="@c"/>'
                 '<DiagonalMass massDensity="8"/><TetrahedronFEMForceField method="small" youngModulus="500" poissonRatio="0.3"/>'
                 '<FixedConstraint indices="0 1 2"/>')
    corners = [CORNERS[i] for i in range(8)]
    six = [(0, 5, 1, 6), (0, 1, 3, 6), (1, 3, 6, 2), (6, 3, 0, 7), (6, 7, 0, 5), (7, 5, 4, 0)]
    cells = [tuple(corners[i] for i in cell) for cell in six]
    mass = np.zeros(8)
    for cell in cells:
        for node_ in cell:
            mass[node_] += 8 / 6 / 4
    fields = together(gravity(mass, [0, -10, 0]), tetrahedra(cells, CUBE, 500, 0.3))
    agree(Run(scene, 10).x(), euler(CUBE, np.diag(mass), fields, 10, 0.01, held=[0, 1, 2]), 1e-8)


@case
def grids_have_triangles_and_their_edges():
    """A sheet of elements right on a flat grid, whose mass is that of its quads; lines of a solid grid with diagonals."""
    X = np.array([[i, j, 0] for j in range(2) for i in range(2)], float)
    scene = root(EXACT + '<RegularGridTopology n="2 2 1" min="0 0 0" max="1 1 0"/><MechanicalObject name="dofs"/>'
                 '<DiagonalMass massDensity="4"/><TriangularFEMForceFieldOptim youngModulus="500" poissonRatio="0.3"/>'
                 '<FixedConstraint indices="0 1"/>')
    fields = together(gravity(np.ones(4), [0, -10, 0]), membrane([(0, 1, 3), (0, 3, 2)], X, 500, 0.3, False))
    agree(Run(scene, 10).x(), euler(X, np.eye(4), fields, 10, 0.01, held=[0, 1]), 1e-7)
    taken = root(EXACT + '<RegularGridTopology name="g" n="2 2 1" min="0 0 0" max="1 1 0"/><MechanicalObject name="dofs"/>'
                 '<TriangleSetTopologyContainer src="@g"/><DiagonalMass name="mass" massDensity="6"/>'
                 '<TriangularFEMForceFieldOptim youngModulus="500" poissonRatio="0.3"/><FixedConstraint indices="0 1"/>')
    lumped = np.diag([2.0, 1, 1, 2])  # those of triangles: the quads stay with the grid
    fields = together(gravity(np.diag(lumped), [0, -10, 0]), membrane([(0, 1, 3), (0, 3, 2)], X, 500, 0.3, False))
    agree(Run(taken, 10).x(), euler(X, lumped, fields, 10, 0.01, held=[0, 1]), 1e-7)
    scene = root(EXACT + '<RegularGridTopology n="2 2 2" min="0 0 0" max="1 1 1"/><MechanicalObject name="dofs"/>'
                 '<UniformMass totalMass="8"/><MeshSpringForceField linesStiffness="500"/><FixedConstraint indices="0 1 2"/>')
    faces = [(0, 1, 3, 2), (4, 5, 7, 6), (0, 1, 5, 4), (2, 3, 7, 6), (0, 2, 6, 4), (1, 3, 7, 5)]
    pairs = {tuple(sorted(pair)) for a, b, c, d in faces for pair in ((a, b), (b, c), (c, d), (d, a), (a, c))}
    assert len(pairs) == 18
    fields = together(gravity(np.ones(8), [0, -10, 0]), springs(sorted(pairs), CUBE, 500))
    agree(Run(scene, 10).x(), euler(CUBE, np.eye(8), fields, 10, 0.01, held=[0, 1, 2]), 1e-7)


def placed(content, link, files=None):
    body = f'<Node name="a"><MechanicalObject name="dofs" position="@../{link}"/><UniformMass totalMass="1"/></Node>'
    run = Run(node(content + EXACT + body), 1, files)
    return run.x("a.dofs")


@case
def value_engines():
    agree(placed('<ValuesFromIndices name="e" template="Vec3d" in="0 0 0  1 0 0  2 0 0" indices="2 0"/>', "e.out"), [[2, 0, 0], [0, 0, 0]])
    agree(placed('<MergeVectors name="e" template="vector&lt;Vec3d&gt;" input1="0 0 0" input2="1 0 0  2 0 0"/>', "e.output"),
          [[0, 0, 0], [1, 0, 0], [2, 0, 0]])
    agree(placed('<MergePoints name="e" position1="0 0 0" position2="1 0 0"/>', "e.points"), [[0, 0, 0], [1, 0, 0]])
    agree(placed('<DifferenceEngine name="e" template="Vec3" input="3 3 3  1 1 1" substractor="1 2 3  0 0 4"/>', "e.output"),
          [[2, 1, 0], [1, 1, -3]])
    agree(placed('<MathOp name="e" template="vector&lt;Vec3d&gt;" nbInputs="2" input1="1 2 3  4 5 6" input2="2 2 2" op="*"/>', "e.output"),
          [[2, 4, 6], [8, 10, 12]])
    for engine, link, held in (
            ('<MergeSets name="e" in1="0 1" in2="1 2" op="intersection"/>', "e.out", [1]),
            ('<IndicesFromValues name="e" template="double" values="5 7" global="7 6 5"/>', "e.indices", [0, 2]),
            ('<ComplementaryROI name="e" position="@dofs.position" nbSet="2" setIndices1="0" setIndices2="2"/>', "e.indices", [1])):
        run = Run(root(EXACT + '<MechanicalObject name="dofs" position="0 0 0  1 0 0  2 0 0"/><UniformMass totalMass="3"/>' + engine +
                       f'<FixedConstraint indices="@{link}"/>'), 10)
        agree(run.x()[:, 1], [0 if i in held else fallen(10) for i in range(3)])
    stiff = Run(node(EXACT + '<MechanicalObject name="dofs" position="0 0 0  2 0 0  4 0 0"/><UniformMass totalMass="3"/>'
                     '<IndexValueMapper name="e" inputValues="10 10" indices="1" value="40"/><FixedConstraint indices="1"/>'
                     '<SpringForceField springsIndices1="0 1" springsIndices2="1 2" lengths="1 1" stiffness="@e.outputValues" '
                     'damping="0"/>'), 1)
    moved = stiff.x()[:, 0] - [0, 2, 4]
    agree(moved[0] / -moved[2], 10 / (1 + 0.01**2 * 10) / (40 / (1 + 0.01**2 * 40)), 1e-9)


@case
def values_that_lists_are_filled_with():
    """Where nothing is said SOFA fills lists with 1, as factors; of one list - and / are the opposite and the inverse."""
    def reals(engine, link, count):  # each is the stiffness of a spring of length 1, drawn out by 1: x = k dt^2 / (m + k dt^2)
        ends = "  ".join(f"{2 * i} 0 0  {2 * i} 2 0" for i in range(count))
        pairs = [" ".join(str(2 * i + j) for i in range(count)) for j in (0, 1)]
        run = Run(node(EXACT + f'<MechanicalObject name="dofs" position="{ends}"/><UniformMass vertexMass="1"/>' + engine +
                       f'<FixedConstraint indices="{pairs[0]}"/><SpringForceField springsIndices1="{pairs[0]}" springsIndices2="{pairs[1]}" '
                       f'lengths="{" ".join(["1"] * count)}" stiffness="@{link}" damping="0"/>'), 1)
        moved = 2 - run.x()[1::2, 1]
        return moved / (1 - moved) / 1e-4
    agree(reals('<IndexValueMapper name="e" inputValues="10" indices="3" value="40"/>', "e.outputValues", 4), [10, 1, 1, 40], 1e-6)
    agree(reals('<IndexValueMapper name="e" inputValues="10" indices="2" value="40" defaultValue="5"/>', "e.outputValues", 3), [10, 5, 40], 1e-6)
    agree(reals('<Indices2ValuesMapper name="e" inputValues="7 8 9" indices="9 7" values="20 30"/>', "e.outputValues", 3), [30, 1, 20], 1e-6)
    agree(reals('<MathOp name="e" template="vector&lt;double&gt;" nbInputs="1" input1="4 0.1" op="/"/>', "e.output", 2), [0.25, 10], 1e-6)
    agree(reals('<MathOp name="e" template="vector&lt;double&gt;" nbInputs="2" input1="4 9" input2="6 2" op="&lt;"/>', "e.output", 2), [4, 2], 1e-6)
    agree(reals('<MathOp name="e" template="vector&lt;double&gt;" nbInputs="2" input1="4 9" input2="6 2" op="&gt;"/>', "e.output", 2), [6, 9], 1e-6)
    agree(placed('<MathOp name="e" template="vector&lt;Vec3d&gt;" nbInputs="1" input1="1 2 -3" op="-"/>', "e.output"), [[-1, -2, 3]])
    agree(placed('<ValuesFromIndices name="e" template="Vec3d" input="0 0 0  1 2 3" indices="1 1"/>', "e.output"), [[1, 2, 3]] * 2)
    # SOFA makes no difference of lists that are not as long
    Run(node('<DifferenceEngine name="e" template="Vec3" input="3 3 3  1 1 1" substractor="1 2 3"/>' + EXACT + BODY +
             '<Node name="a"><MechanicalObject position="@../e.output"/></Node>'), 1).fails(2, "2 values of input and 1 of substractor")
    # values along a direction: p . d from the least x to the largest, through all that are given, as SOFA has it
    points = np.array([[0, 0, 0], [4, 1, 0], [1, 3, 0], [2, 6, 0.0]])
    given = np.array([1, 5, 7.0])
    place = np.clip((points @ [0, 1, 0] - points[:, 0].min()) / np.ptp(points[:, 0]), 0, 1) * 2
    expected = np.interp(place, [0, 1, 2], given)
    engine = f'<ValuesFromPositions name="e" position="{numbers_of(points)}" inputValues="1 5 7" direction="0 1 0"/>'
    agree(reals(engine, "e.values", 4), expected, 1e-6)
    agree(reals(engine.replace("1 5 7", "3"), "e.values", 4), [3] * 4, 1e-6)


@case
def points_that_replace_others():
    both = '<MergePoints name="e" position1="0 0 0  1 0 0  2 0 0" position2="7 0 0  8 0 0" mappingX2="2 0"/>'
    agree(placed(both, "e.points"), [[8, 0, 0], [1, 0, 0], [7, 0, 0]])
    for link, held in (("indices1", [1]), ("indices2", [0, 2])):
        run = Run(root(EXACT + both + '<MechanicalObject name="dofs" position="@e.points"/><UniformMass totalMass="3"/>'
                       f'<FixedConstraint indices="@e.{link}"/>'), 10)
        agree(run.x()[:, 1], [0 if i in held else fallen(10) for i in range(3)])


@case
def frames_and_places_of_lists():
    """As many frames as both lists have, or a single orientation for all; places once; of nodes as near the later ones."""
    q = "0 0 0.6 0.8"
    for positions, turns, more, expected in (
            ("1 2 3  4 5 6", q, "", [[1, 2, 3, 0, 0, 0.6, 0.8], [4, 5, 6, 0, 0, 0.6, 0.8]]),
            ("1 2 3  4 5 6", "0 0 0 1  " + q + "  " + q, "", [[1, 2, 3, 0, 0, 0, 1], [4, 5, 6, 0, 0, 0.6, 0.8]]),
            ("1 2 3", "0 0 0 1  " + q, "", [[1, 2, 3, 0, 0, 0, 1]]),
            ("1 2 3  4 5 6", "0 0.6 0 0.8", 'colinearPositions="1 1 1"', [[2.8512, 1, 1.5397, 0, 0.6, 0, 0.8], [4, 5, 6, 0, 0.6, 0, 0.8]])):
        engine = f'<QuatToRigidEngine name="e" position="{positions}" orientation="{turns}" {more}/>'
        z = np.array([2 * 0.6 * 0.8, 0, 1 - 2 * 0.36])  # the third axis of that turn
        if more:
            expected[0][:3] = np.ones(3) + z * (z @ [0, 1, 2])
        body = '<Node name="a"><MechanicalObject name="dofs" template="Rigid3" position="@../e.rigid"/><UniformMass totalMass="1"/></Node>'
        agree(Run(node(engine + EXACT + body), 1).x("a.dofs", 7), expected)
    # the angles are in radians
    agree(placed(f'<RigidToQuatEngine name="e" rigids="1 2 3 {q}"/>', "e.orientationsEuler"), [[0, 0, 2 * np.arctan2(0.6, 0.8)]])
    agree(placed('<PointsFromIndices name="e" position="1 0 0  2 0 0  1 0 0" indices="2 1 0 1"/>', "e.indices_position"), [[1, 0, 0], [2, 0, 0]])
    ring = np.array([[0, 1, 0], [1, 0, 0], [0, -1, 0], [-1, 0, 0], [0.5, 0, 0.0]])
    run = Run(root(EXACT + f'<MechanicalObject name="dofs" position="{numbers_of(ring)}"/><UniformMass totalMass="5"/>'
                   '<ProximityROI name="r" centers="0 0 0" radii="2" N="2"/><FixedConstraint indices="@r.indices"/>'), 10)
    agree(run.x()[:, 1] - ring[:, 1], [fallen(10)] * 3 + [0, 0])


@case
def borders_of_parts_and_lids_of_holes():
    """Four triangles around a node: the border of the two that have nodes 0 1 2 and 0 2 3 has node 0, that of all four has not."""
    fan = '<MeshTopology name="n" position="0 0 0  1 0 0  0 1 0  -1 0 0  0 -1 0" triangles="0 1 2  0 2 3  0 3 4  0 4 1"/>'
    for part, held in (("", [1, 2, 3, 4]), ('inputROI="3 2 1 0"', [0, 1, 2, 3])):
        run = Run(root(EXACT + fan + '<MechanicalObject name="dofs"/><UniformMass totalMass="5"/>'
                       f'<MeshBoundaryROI name="r" triangles="@n.triangles" {part}/><FixedConstraint indices="@r.indices"/>'), 10)
        agree(run.x()[:, 1] - [0, 0, 1, 0, -1], [0 if i in held else fallen(10) for i in range(5)])
    # triangles of a lid: from its middle to each node of the loop and the one before, the first with the last
    hole = ('<MeshTopology name="n" position="0 0 0  3 0 0  0 3 0  0 0 3" triangles="0 2 1  0 1 3  0 3 2"/>'
            '<MeshClosingEngine name="e" inputPosition="@n.position" inputTriangles="@n.triangles"/>')
    loop = [1, 3, 2]  # the hole's sides as the triangles go: 2 1, 1 3, 3 2
    triangles = [(0, 2, 1), (0, 1, 3), (0, 3, 2)] + [(4, node, loop[i - 1]) for i, node in enumerate(loop)]
    nodes = np.array([[0, 0, 0], [3, 0, 0], [0, 3, 0], [0, 0, 3], [1, 1, 1.0]])
    for number in (3, 4, 5):
        held = sorted(triangles[number])
        run = Run(root(EXACT + hole + '<MeshTopology name="all" position="@e.position" triangles="@e.triangles"/>'
                       '<MechanicalObject name="dofs" position="@e.position"/><UniformMass totalMass="5"/>'
                       f'<TrianglePressureForceField topology="@all" triangleList="{number}" pressure="0 30 0"/>'), 1)
        area = np.linalg.norm(np.cross(nodes[held[1]] - nodes[held[0]], nodes[held[2]] - nodes[held[0]])) / 2
        agree(run.x()[:, 1] - nodes[:, 1] - fallen(1), [1e-4 * 30 * area / 3 * (i in held) for i in range(5)], 1e-6)


@case
def the_surface_of_a_cylinder():
    """Closed: its volume is that of a prism on a regular polygon; its first triangle goes down from the second layer."""
    closed = ('<GenerateCylinder name="e" radius="2" height="3" origin="1 2 3" resCircumferential="5" resRadial="3" resHeight="4" openSurface="0"/>'
              '<GenerateRigidMass name="m" position="@e.output_TrianglesPosition" triangles="@e.triangles" density="1"/>'
              f'<Expect of="/m.volume" is="{5 / 2 * 4 * np.sin(2 * np.pi / 5) * 3}"/>')
    run = Run(node(EXACT + closed + BODY), 1)
    assert run.code == 0, run.text
    ring = [[1 + 2 * np.cos(a), 2 + 2 * np.sin(a), 3 + z] for z in range(4) for a in 2 * np.pi / 5 * np.arange(5)]
    agree(placed(closed.replace('openSurface="0"', "").split("<GenerateRigidMass")[0], "e.output_TrianglesPosition"), ring)
    Run(node(EXACT + closed.replace('openSurface="0"', 'BezierTetrahedronDegree="3"') + BODY), 1).fails(2, "BezierTetrahedronDegree")


@case
def engines_that_move_points():
    net = '<MeshTopology name="n" position="0 0 0  2 0 0  2 2 0  6 6 6" edges="0 1  1 2"/>'
    for method, more, expected in (
            ("translation", 'translation="0 0 1"', [[0, 0, 1], [2, 0, 1], [2, 2, 1], [6, 6, 7]]),
            ("scale", 'origin="2 0 0" scale="2 1 1"', [[-2, 0, 0], [2, 0, 0], [2, 2, 0], [10, 6, 6]]),
            ("rotation", 'rotation="0 0 90"', [[0, 0, 0], [0, 2, 0], [-2, 2, 0], [-6, 6, 6]]),
            ("projectOnPlane", 'origin="0 0 5" normal="0 0 2"', [[0, 0, 5], [2, 0, 5], [2, 2, 5], [6, 6, 5]]),
            ("scaleRotationTranslation", 'scale="2 2 2" rotation="0 0 90" translation="1 0 0" fixedIndices="3"',
             [[1, 0, 0], [1, 4, 0], [-3, 4, 0], [6, 6, 6]]),
            ("affine", 'matrix="0 1 0 0  1 0 0 0  0 0 1 3  0 0 0 1"', [[0, 0, 3], [0, 2, 3], [2, 2, 3], [6, 6, 9]])):
        agree(placed(net + f'<TransformPosition name="e" input_position="@n.position" method="{method}" {more}/>', "e.output_position"),
              expected)
    agree(placed(net + '<SmoothMeshEngine name="e" topology="@n" input_position="@n.position" nb_iterations="2"/>', "e.output_position"),
          [[1, 1, 0], [2, 0, 0], [1, 1, 0], [6, 6, 6]])


@case
def pairs_of_near_nodes():
    bodies = ('<Node name="one"><MechanicalObject name="dofs" position="0 0 0  5 0 0"/><UniformMass/></Node>'
              '<Node name="two"><MechanicalObject name="dofs" position="9 9 9  5.1 0 0  0.2 0 0"/><UniformMass/></Node>'
              '<NearestPointROI name="e" object1="@one/dofs" object2="@two/dofs" radius="0.5"/>')
    assert placed(bodies + '<ValuesFromIndices name="v" template="Vec3" in="0 0 0  5 0 0" indices="@e.indices1"/>', "v.out").tolist() == [
        [5, 0, 0], [0, 0, 0]]
    assert placed(bodies + '<ValuesFromIndices name="v" template="Vec3" in="0 0 0  1 0 0  2 0 0" indices="@e.indices2"/>',
                  "v.out").tolist() == [[1, 0, 0], [2, 0, 0]]


@case
def pairs_of_near_nodes_as_edges():
    """NearestPointROI numbers pairs for mappings of several bodies: 0 and the node of the first, 1 and that of the second."""
    bodies = ('<Node name="one"><MechanicalObject name="dofs" position="0 0 0  5 0 0"/><UniformMass/></Node>'
              '<Node name="two"><MechanicalObject name="dofs" position="0.1 0 0  5 0.2 0"/><UniformMass/></Node>'
              '<NearestPointROI name="e" object1="@one/dofs" object2="@two/dofs" radius="0.5"/>')
    values = "  ".join(f"{i} 0 0" for i in range(4))
    for name, flat in (("indexPairs", [0, 0, 1, 0, 0, 1, 1, 1]), ("edges", [0, 1, 2, 3])):
        got = placed(bodies + f'<ValuesFromIndices name="v" template="Vec3" in="{values}" indices="@e.{name}"/>', "v.out")[:, 0]
        assert got.tolist() == flat, (name, got)


@case
def normals_of_surfaces():
    """DilateEngine sums cross products of a corner's sides, NormalsFromPoints their directions, with useAngles times the angle."""
    nodes = np.array([[0, 0, 0], [1, 0, 0.1], [1.2, 0.9, 0.3], [-0.1, 1, 0.2], [0.5, 2, -0.4]])
    cells = [(0, 1, 2, 3), (3, 2, 4)]

    def normals(weight):
        sums = np.zeros_like(nodes)
        for cell in cells:
            for i, here in enumerate(cell):
                a, b = nodes[cell[(i + 1) % len(cell)]] - nodes[here], nodes[cell[i - 1]] - nodes[here]
                n = np.cross(a, b)
                size = np.linalg.norm(n)
                sums[here] += n * {"area": 1, "one": 1 / size, "angle": np.arccos(a @ b / np.linalg.norm(a) / np.linalg.norm(b)) / size}[weight]
        return sums / np.linalg.norm(sums, axis=1)[:, None]
    surface = f'position="{numbers_of(nodes)}" quads="0 1 2 3" triangles="3 2 4"'
    agree(placed(f'<NormalsFromPoints name="e" {surface}/>', "e.normals"), normals("one"))
    agree(placed(f'<NormalsFromPoints name="e" {surface} useAngles="1" invertNormals="1"/>', "e.normals"), -normals("angle"), 1e-7)
    agree(placed(f'<DilateEngine name="e" {surface} distance="0.3"/>', "e.output_position"), nodes + 0.3 * normals("area"))
    # two sheets that look away from each other, 0.4 apart: half of what is missing to 1 more; behind the second there is nothing
    sheets = np.array([[0, 0, 0.4], [1, 0, 0.4], [0, 1, 0.4], [-3, -3, 0], [-3, 6, 0], [6, -3, 0]])
    moved = placed(f'<DilateEngine name="e" position="{numbers_of(sheets)}" triangles="0 1 2  3 4 5" distance="0.1" minThickness="1"/>',
                   "e.output_position")
    agree(moved, sheets + ([[0, 0, 0.4]] * 3 + [[0, 0, -0.6]] * 3))


@case
def mass_of_what_a_surface_encloses():
    """A box of 1 x 2 x 3 turns about x under a torque of two forces: inertia m (b^2 + c^2) / 12."""
    nodes = [[i, 2 * j, 3 * k] for k in (0, 1) for j in (0, 1) for i in (0, 1)]
    faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    text = "  ".join(" ".join(map(str, p)) for p in nodes)
    quads = "  ".join(" ".join(map(str, q)) for q in faces)
    scene = node(f'<MeshTopology name="m" position="{text}" quads="{quads}"/><GenerateRigidMass name="e" src="@m" density="0.5"/>' + EXACT +
                 '<MechanicalObject name="dofs" template="Rigid3" position="0 0 0 0 0 0 1"/><UniformMass vertexMass="@e.rigidMass"/>'
                 '<ConstantForceField indices="0" forces="3 0 0 1 0 0"/>')
    x = Run(scene, 1).x("dofs", 7)
    agree(x[0, 0], 0.01**2 * 3 / 3)
    agree(2 * np.arcsin(x[0, 3]), 0.01**2 / (3 * (4 + 9) / 12), 1e-6)


@case
def made_meshes():
    agree(placed('<GridMeshCreator name="e" resolution="2 3" trianglePattern="1"/>', "e.position"),
          [[x, y / 2, 0] for y in range(3) for x in range(2)])
    agree(placed('<StringMeshCreator name="e" resolution="3"/>', "e.position"), [[0, 0, 0], [0.5, 0, 0], [1, 0, 0]])
    agree(placed('<GenerateGrid name="e" min="1 0 0" max="3 1 1" resolution="1 1 1"/>', "e.output_position"),
          [[1 + 2 * i, j, k] for k in range(2) for j in range(2) for i in range(2)])
    agree(placed('<MeshTopology name="m" position="0 0 0  1 0 0  1 1 0  0 1 0" quads="0 1 2 3"/><ExtrudeQuadsAndGenerateHexas name="e" '
                 'surfaceVertices="@m.position" surfaceQuads="@m.quads" thicknessIn="1" thicknessOut="2" numberOfSlices="3"/>',
                 "e.extrudedVertices"), [[x, y, z] for x, y in ((0, 0), (1, 0), (1, 1), (0, 1)) for z in (-1, 0, 1, 2)])
    agree(placed('<MeshTopology name="m" position="0 0 0  1 0 0" edges="0 1"/><ExtrudeEdgesAndGenerateQuads name="e" '
                 'curveVertices="@m.position" curveEdges="@m.edges" extrudeDirection="0 0 2" numberOfSections="2"/>',
                 "e.extrudedVertices"), [[x, 0, z] for z in (0, 0.5, 1) for x in (0, 1)])
    for cells, total in (('<GenerateGrid name="e" max="1 2 3" resolution="2 2 2"/><TetrahedronSetTopologyContainer src="@e"/>', 6),
                         ('<GenerateGrid name="e" max="1 2 3" resolution="2 2 2"/><HexahedronSetTopologyContainer src="@e"/>', 6),
                         ('<GenerateCylinder name="e" radius="2" height="3" resCircumferential="200"/>'
                          '<TetrahedronSetTopologyContainer src="@e"/>', 12 * np.pi),
                         ('<Node name="n"><MeshTopology name="m" position="0 0 0  1 0 0  1 1 0  0 1 0" quads="0 1 2 3"/></Node>'
                          '<ExtrudeQuadsAndGenerateHexas name="e" surfaceVertices="@n/m.position" surfaceQuads="@n/m.quads" '
                          'thicknessOut="2" flipNormals="1"/>'
                          '<HexahedronSetTopologyContainer position="@e.extrudedVertices" hexahedra="@e.extrudedHexas"/>', 2)):
        run = Run(root(EXACT + cells + '<MechanicalObject name="dofs"/><DiagonalMass name="mass" massDensity="1"/>'
                       f'<Expect of="/mass.totalMass" is="{total}" tolerance="1e-3"/>'), 1)
        assert run.code == 0, run.text


@case
def round_grids():
    x = placed('<CylinderGridTopology name="e" nx="3" ny="3" nz="2" center="0 0 5" axis="0 0 1" radius="2" length="4"/>', "e.position")
    assert x.shape == (18, 3)
    s = np.sqrt(2)
    agree(x[:9], [[-s, -s, 5], [0, -2, 5], [s, -s, 5], [-2, 0, 5], [0, 0, 5], [2, 0, 5], [-s, s, 5], [0, 2, 5], [s, s, 5]])
    agree(x[9:, 2], np.full(9, 9))
    x = placed('<CylinderGridTopology name="e" nx="2" ny="2" nz="2" axis="1 0 0" radius="1" length="3"/>', "e.position")
    agree(x[4:, 0], np.full(4, 3))
    x = placed('<SphereGridTopology name="e" nx="3" ny="3" nz="3" radius="2"/>', "e.position")
    agree(np.linalg.norm(x, axis=1), [0 if i == 13 else 2 for i in range(27)])


@case
def surface_of_a_box():
    cube = '<CubeTopology name="e" nx="{}" ny="{}" nz="{}" {}/>'
    x = placed(cube.format(3, 3, 3, 'xmin="0" ymin="0" zmin="0" xmax="2" ymax="2" zmax="2"'), "e.position")
    agree(x[:18], [[i, j, k] for k in (0, 2) for j in range(3) for i in range(3)])
    agree(x[18:], [[0, 0, 1], [1, 0, 1], [2, 0, 1], [0, 2, 1], [1, 2, 1], [2, 2, 1], [0, 1, 1], [2, 1, 1]])
    agree(placed(cube.format(2, 3, 3, 'internalPoints="1" max="1 2 2"'), "e.position"),
          [[i, j, k] for k in range(3) for j in range(3) for i in range(2)])
    # a pressure on all of its quads has no resultant, and that of the volume of six faces
    scene = node(EXACT + cube.format(3, 4, 3, 'max="2 3 2"') + '<MechanicalObject name="dofs"/><UniformMass vertexMass="1"/>'
                 '<SurfacePressureForceField pressure="6"/>')
    x = Run(scene, 1).x() - placed(cube.format(3, 4, 3, 'max="2 3 2"'), "e.position")
    assert np.abs(x.sum(axis=0)).max() < 1e-9, x
    push = 0.01**2 * 6
    agree(np.abs(x).sum(axis=0) / push, [2 * 3 * 2, 2 * 2 * 2, 2 * 2 * 3], 1e-2)
    springs = Run(node(EXACT + cube.format(2, 2, 2, "") + '<MechanicalObject name="dofs"/><UniformMass vertexMass="1"/>'
                       '<MeshSpringForceField linesStiffness="100"/><FixedConstraint indices="0"/>'
                       '<ConstantForceField indices="7" forces="1 0 0"/>'), 3).x()
    assert springs[7, 0] > 1 + 1e-5 and springs[6, 0] > 1e-8, springs


@case
def sides_with_nodes_of_their_own():
    """Sides of the least x, y, z, then of the largest."""
    n, places, at = (2, 3, 4), [], {}
    for upper in (0, 1):
        for axis in range(3):
            u, v = [a for a in range(3) if a != axis]
            for j in range(n[v]):
                for i in range(n[u]):
                    p = [0, 0, 0]
                    p[axis], p[u], p[v] = (n[axis] - 1) * upper, i, j
                    at[axis, upper, *p] = len(places)
                    places.append(p)
    cube = '<CubeTopology name="e" nx="2" ny="3" nz="4" max="1 2 3" splitNormals="1"/>'
    agree(placed(cube, "e.position"), places)
    # a pressure on all sides pushes each as a whole, and none of their corners is shared
    scene = root(EXACT + cube + '<MechanicalObject name="dofs"/><UniformMass vertexMass="1"/><SurfacePressureForceField pressure="6"/>',
                 'gravity="0 0 0"')
    moved = Run(scene, 1).x() - places
    for (axis, upper, *_), number in at.items():
        side = np.zeros(3)
        side[axis] = 1 if upper else -1
        assert moved[number] @ side > 1e-6 and np.abs(moved[number] - moved[number] @ side * side).max() < 1e-12, (axis, upper)


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
def constraints_of_direction_and_patch():
    run = Run(root(EXACT + BODY + '<DirectionProjectiveConstraint indices="1" direction="1 -1 0"/>'), 10)
    agree(run.x(), [[0, fallen(10), 0], [1 - fallen(10) / 2, fallen(10) / 2, 0]])
    scene = node(EXACT + '<MechanicalObject name="dofs" position="0 0 0  2 0 0  2 4 0  0 4 0  1 4 0"/><UniformMass totalMass="1"/>'
                 '<PatchTestMovementConstraint indices="0 1 2 3 4" cornerPoints="0 0 0  2 0 0  2 4 0  0 4 0" beginConstraintTime="0" '
                 'endConstraintTime="0.2" cornerMovements="0 0 0  1 0 0  1 2 0  0 4 0"/>')
    agree(Run(scene, 11).x(), [[0, 0, 0], [2.5, 0, 0], [2.5, 5, 0], [0, 6, 0], [1.25, 5.5, 0]])
    agree(Run(scene, 30).x(), [[0, 0, 0], [3, 0, 0], [3, 6, 0], [0, 8, 0], [1.5, 7, 0]])
    agree(Run(scene.replace('cornerPoints="0 0 0  2 0 0  2 4 0  0 4 0"', 'constrainedPoints="0 0 0  2 0 0  2 4 0  0 4 0"'), 30).x(),
          Run(scene, 30).x())
    # corners among points in any order: the far one of corner 0 is looked for beyond where that one is by then
    points = np.array([(0, 1, 0), (1, 0, 2), (1, 0, 0), (0, 0, 1), (0, 1, 2), (1, 1, 0), (0, 1, 1), (1, 0, 1), (0, 0, 2), (0, 0, 0),
                       (1, 1, 2), (1, 1, 1)], float)
    found = [points[0].copy() for _ in range(8)]
    for p in points:
        beyond = [(p[0] < c[0], p[0] > c[0], p[1] < c[1], p[1] > c[1], p[2] < c[2], p[2] > c[2]) for c in found]
        for i, (x, y) in enumerate(((0, 2), (1, 2), (1, 3), (0, 3))):
            if beyond[i][x] or beyond[i][y] or beyond[i][4]:
                found[i] = p
        if beyond[4][0] or beyond[4][2] or p[2] > found[0][2]:
            found[4] = p
    share = np.abs(points - found[0]) / [abs(found[1][0] - found[0][0]), abs(found[3][1] - found[0][1]), abs(found[4][2] - found[0][2])]
    moved = points.copy()
    moved[:, 2] += share[:, 2]  # the four far corners go up by one
    body = f'<MechanicalObject name="dofs" position="{numbers_of(points)}"/><UniformMass totalMass="1"/>'
    agree(Run(node(EXACT + body + f'<PatchTestMovementConstraint indices="0-11" constrainedPoints="{numbers_of(points)}" endConstraintTime="0.05" '
                   'cornerMovements="0 0 0  0 0 0  0 0 0  0 0 0  0 0 1  0 0 1  0 0 1  0 0 1"/>'), 12).x(), moved)


@case
def quirk_late_times():
    """SOFA's clock stands at the start of a step: nodes are where they were to be then, and forces are those of then."""
    one = '<MechanicalObject name="dofs" position="1 2 3"/><UniformMass totalMass="2"/>'
    move = '<LinearMovementConstraint indices="0" keyTimes="0 0.02 0.04" movements="0 0 0  2 0 0  2 6 0"/>'
    for steps, place in ((1, [1, 2, 3]), (2, [2, 2, 3]), (3, [3, 2, 3]), (4, [3, 5, 3])):
        agree(Run(node(EXACT + one + move), steps).x(), [place])
    agree(Run(node(EXACT + one + move), 6).x(), [[3, 11, 3]])  # free from 0.04 s on, with the velocity that it had
    agree(Run(node(EXACT + one + move), 3, args=["--without-quirk", "late-times"]).x(), [[3, 5, 3]])
    late = move.replace("0 0.02 0.04", "0.02 0.04 0.06").replace("LinearMovementConstraint", 'PartialLinearMovementConstraint '
                                                                 'movedDirections="1 1 0"')
    for steps, place in ((3, [1, 2, 3]), (4, [2, 2, 3]), (5, [3, 2, 3])):
        agree(Run(node(EXACT + one + late), steps).x(), [place])
    swing = '<OscillatorConstraint oscillators="0  1 2 3  0 4 0  10 0.3"/>'
    for steps in (1, 4):
        agree(Run(node(EXACT + one + swing), steps).x(), [[1, 2 + 4 * np.sin(10 * (steps - 1) * 0.01 + 0.3), 3]])
    frame = '<MechanicalObject name="dofs" template="Rigid3" position="0 0 0 0 0 0 1"/><UniformMass totalMass="2"/>'
    swing = '<OscillatorConstraint oscillators="0  1 2 3 0 0 0.6 0.8  0 4 0 0 0 0.5  10 0.3"/>'
    for steps in (1, 4):  # the mean orientation turned about its own axis
        phase = np.sin(10 * (steps - 1) * 0.01 + 0.3)
        half = np.arcsin(0.6) + 0.25 * phase
        agree(Run(node(EXACT + frame + swing), steps).x(width=7), [[1, 2 + 4 * phase, 3, 0, 0, np.sin(half), np.cos(half)]])
    turn = ('<AffineMovementConstraint indices="0" beginConstraintTime="0.01" endConstraintTime="0.03" rotation="1 0 0 0 1 0 0 0 1" '
            'translation="0 0 8"/>')
    for steps, z in ((2, 3), (3, 7), (4, 11), (5, 11)):
        agree(Run(node(EXACT + one + turn), steps).x(), [[1, 2, z]])

    flow = '<LinearVelocityConstraint indices="0" keyTimes="{}" velocities="10 0 0  40 0 0" coordinates="0 1 2"/>'
    for keys, before in (("0 0.03", 0), ("0.01 0.04", 1)):  # in the end it goes on with the 30 m/s of the last step
        for steps, x in ((1, 0.1), (2, 0.3), (3, 0.6), (4, 0.9)):  # at 0 also before the first step
            agree(Run(node(EXACT + one + flow.format(keys)), steps + before).x(), [[1 + x + (0 if before else 0.1), 2, 3]], 1e-7)

    def pushed(forces):  # one node of mass 2
        x = v = 0.0
        for f in forces:
            v += 0.01 * f / 2
            x += 0.01 * v
        return x
    push = '<LinearForceField points="0" times="0 0.02" forces="0 0 0  6 0 0"/>'
    for solver in (EXACT, '<EulerExplicitSolver/>'):
        agree(Run(node(solver + one + push), 4).x()[:, 0], [1 + pushed([0, 3, 6, 6])])
        agree(Run(node(solver + one + push.replace("0 0.02", "0.01 0.03").replace("0 0 0  6", "4 0 0  6")), 4).x()[:, 0],
              [1 + pushed([0, 4, 5, 6])])


@case
def weakly_fixed():
    def held(x, v):
        return -100 * (x - [[0, 0, 0], [1, 0, 0]]), -100 * np.eye(6)
    both = euler([[0, 0, 0], [1, 0, 0]], np.eye(2), together(gravity(np.ones(2), [0, -10, 0]), held), 10, 0.01)
    agree(Run(root(EXACT + BODY + '<FixedWeakConstraint fixAll="1" stiffness="100"/>'), 10).x(), both)
    first = Run(root(EXACT + BODY + '<FixedWeakConstraint stiffness="100"/>'), 10).x()
    agree(first, [both[0], [1, fallen(10), 0]])


@case
def files_in_other_formats():
    files = {"a.trian": "3\n0 0 0\n1 0 0\n0 1 0\n1\n0 1 2 -1 -1 -1\n",
             "a.gid": "MESH dimension 3 ElemType Tetrahedra Nnode 4\nCoordinates\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n"
                      "End Coordinates\n\nElements\n1 1 2 3 4\nEnd Elements\n",
             "a.xs3": "Xsp 3.0\nnumm 2\nnums 1\nmass 1 v 5 0 0 0 0 0 1 0\nmass 2 v 6 0 0 0 0 0 1 0\nlspg 1 1 2 10 1 1\n"}
    agree(placed('<MeshTrianLoader name="e" filename="a.trian"/>', "e.position", files), [[0, 0, 0], [1, 0, 0], [0, 1, 0]])
    agree(placed('<GIDMeshLoader name="e" filename="a.gid" translation="0 0 1"/>', "e.position", files), X4_UNIT + [0, 0, 1])
    agree(placed('<MeshXspLoader name="e" filename="a.xs3"/>', "e.position", files), [[5, 0, 0], [6, 0, 0]])
    Run(node('<MeshTrianLoader name="e" filename="a.trian"/><MeshTopology src="@e"/>' + EXACT + '<MechanicalObject/>'), 1,
        {"a.trian": "3\n0 0 0\n1 0 0\n0 1"}).fails(2, "a.trian", "node 2")


@case
def voxels_of_a_file():
    """Two by two by one voxels, of which the third counts for nothing: three cells with a node at (0, 0) ... without that at (0, 2)."""
    def loaded(more, link="e.position", content=bytes([1, 2, 0, 3])):
        return placed(f'<VoxelGridLoader name="e" filename="a.raw" resolution="2 2 1" {more}/>', link, {"a.raw": content})
    flat = [(i, j, k) for k in range(2) for j in range(3) for i in range(3)]
    agree(loaded('bgValue="0"'), [p for p in flat if p[:2] != (0, 2)])
    agree(loaded('voxelSize="2 3 4" generateHexa="0" bgValue="0"'), [[0, 0, 0], [2, 0, 0], [2, 3, 0]])
    agree(loaded('generateHexa="0" bgValue="1" dataValue="0 1" header="2"', content=bytes([9, 9, 1, 2, 0, 3])), [[0, 0, 0], [0, 1, 0]])
    agree(loaded('ROI="1 0 0 1 7 7"'), [p for p in flat if p[0] > 0])
    agree(loaded('generateHexa="0"'), [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]])
    Run(node(EXACT + '<VoxelGridLoader name="e" filename="a.raw" resolution="3 2 1"/><MechanicalObject position="@e.position"/>'), 1,
        {"a.raw": b"1234"}).fails(2, "has 4 bytes, and 6 voxels after a header of 0 are more")
    for more, said in (('ROI="1 0 0 0 7 7"', "ROI ends at 0 and begins at 1"), ('voxelSize="1 1 0"', "voxelSize")):
        Run(node(EXACT + f'<VoxelGridLoader name="e" filename="a.raw" resolution="2 2 1" {more}/><MechanicalObject position="@e.position"/>'),
            1, {"a.raw": b"1234"}).fails(2, said)


def voxels(container, content):
    loader = '<VoxelGridLoader name="loader" filename="a.raw" resolution="2 1 1"/>'
    return Run(root(EXACT + loader + f'<{container} src="@loader"/><MechanicalObject name="dofs"/>' + content), 10, {"a.raw": b"12"})


@case
def containers_of_voxels():
    places = np.array([(i, j, k) for k in range(2) for j in range(2) for i in range(3)], float)
    cells = [[0, 1, 4, 3, 6, 7, 10, 9], [1, 2, 5, 4, 7, 8, 11, 10]]
    fields = together(gravity(np.ones(12), [0, -10, 0]), hexahedra(cells, places, 200, 0.3))
    falls_so = euler(places, np.eye(12), fields, 10, 0.01, held=[0, 3, 6, 9])
    for container in ('DynamicSparseGridTopologyContainer resolution="2 1 1" voxelSize="1 1 1"',
                      'MultilevelHexahedronSetTopologyContainer level="1"'):
        agree(voxels(container, '<DynamicSparseGridTopologyModifier/><DynamicSparseGridGeometryAlgorithms/><UniformMass totalMass="12"/>'
                     '<FixedConstraint indices="0 3 6 9"/><HexahedralFEMForceField method="polar" youngModulus="200" '
                     'poissonRatio="0.3"/>').x(), falls_so, 1e-7)


@case
def masses_of_voxels():
    """Those of the finite element method: along an axis 1/3 of a part at its ends and 1/6 between them."""
    end, both = np.array([[2, 1], [1, 2]]) / 6, np.array([[2, 1, 0], [1, 4, 1], [0, 1, 2]]) / 6
    field = '<NonUniformHexahedralFEMForceFieldAndMass method="polar" youngModulus="1e-9" poissonRatio="0.3" density="6" {}/>'
    places = np.array([(i, j, k) for k in range(2) for j in range(2) for i in range(3)], float)

    def held(x, v):
        return -300 * (x - places), -300 * np.eye(36)
    M = 6 * np.kron(end, np.kron(end, both))
    fields = together(gravity(M.sum(1), [0, -10, 0]), held)
    springs_ = '<RestShapeSpringsForceField stiffness="300"/>'
    agree(voxels("MultilevelHexahedronSetTopologyContainer", field.format('recursive="0" useMBK="1"') + springs_).x(),
          euler(places, M, fields, 10, 0.01), 1e-7)
    agree(voxels("MultilevelHexahedronSetTopologyContainer", field.format('lumpedMass="1"') + springs_).x(),
          euler(places, np.diag(M.sum(1)), fields, 10, 0.01), 1e-7)
    voxels('MultilevelHexahedronSetTopologyContainer level="1"', field.format("")).fails(2, "cells of several voxels")


@case
def parts_that_programs_fill():
    """In a scene alone they hold and measure nothing."""
    run = Run(root(EXACT + BODY + '<UnilateralLagrangianConstraint/><AugmentedLagrangianConstraint/><DataMonitor/><TimeMonitor/>'
                   '<PerformanceMonitor/>'), 10)
    falls(run)
    run.says("UnilateralLagrangianConstraint", "AugmentedLagrangianConstraint", "PerformanceMonitor")
    frames = '<MechanicalObject name="dofs" template="Rigid3" position="0 0 0 0 0 0 1  1 0 0 0 0 0 1"/><UniformMass totalMass="2"/>'
    run = Run(root(EXACT + frames + '<GearSpringForceField template="Rigid3"/>'), 10)
    run.says("has no pair of wheels")
    agree(run.x(width=7)[:, 1], [fallen(10)] * 2)
    for name in ("SkeletalMotionConstraint", "SkeletalMotionProjectiveConstraint"):
        run = Run(root(EXACT + frames + f'<{name} animationSpeed="2"/>'), 10)
        run.says("has no joints")
        agree(run.x(width=7), [[0, 0, 0, 0, 0, 0, 1], [1, 0, 0, 0, 0, 0, 1]])
        agree(Run(root(EXACT + frames + f'<{name} active="0"/>'), 10).x(width=7)[:, 1], [fallen(10)] * 2)
        Run(root(EXACT + frames + f'<{name} joints="a"/>'), 10).fails(2, "the movement of a skeleton")
    run = Run(node(EXACT + '<SphereQuadTopology nx="3" ny="3" nz="3"/><MechanicalObject name="dofs"/><UniformMass totalMass="2"/>'), 1)
    run.says("is 0 in SOFA when not given")


@case
def tetrahedra_cut_into_eight():
    """Springs of a fine mesh whose nodes are those of the coarse one and the middles of its edges, as its cells name them."""
    coarse = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]], float)
    cells = [(0, 1, 2, 3), (4, 3, 2, 1)]
    edges = []
    for cell in cells:
        edges += [e for e in (tuple(sorted(p)) for p in itertools.combinations(cell, 2)) if e not in edges]
    J = np.vstack([np.eye(5)] + [(np.eye(5)[a] + np.eye(5)[b]) / 2 for a, b in edges])
    fine = []
    for a, b, c, d in cells:
        ab, ac, ad, bc, bd, cd = (5 + edges.index(tuple(sorted(p))) for p in itertools.combinations((a, b, c, d), 2))
        fine += [(a, ab, ac, ad), (b, ab, bd, bc), (c, ac, bc, cd), (d, ad, cd, bd), (ac, ab, bc, cd), (ac, ab, cd, ad),
                 (bd, ab, cd, bc), (bd, ab, ad, cd)]
    field = tetrahedra(fine, J @ coarse, 300, 0.3)

    def carried(x, v):
        f, K = field(J @ x, J @ v)
        I = np.kron(J, np.eye(3))
        return J.T @ f, I.T @ K @ I
    fields = together(gravity(np.ones(5), [0, -10, 0]), carried)
    text = "  ".join(" ".join(map(str, p)) for p in coarse)
    run = Run(root(EXACT + f'<TetrahedronSetTopologyContainer name="coarse" position="{text}" tetrahedra="0 1 2 3  4 3 2 1"/>'
                   '<MechanicalObject name="dofs"/><UniformMass totalMass="5"/><FixedConstraint indices="0 1"/><Node name="fine">'
                   '<TetrahedronSetTopologyContainer name="cells"/><TetrahedronSetTopologyModifier/>'
                   '<SimpleTesselatedTetraTopologicalMapping input="@../coarse" output="@cells"/><MechanicalObject name="fine"/>'
                   '<SimpleTesselatedTetraMechanicalMapping input="@../dofs" output="@fine"/><TetrahedronFEMForceField method="small" '
                   'youngModulus="300" poissonRatio="0.3"/></Node>'), 10)
    expected = euler(coarse, np.eye(5), fields, 10, 0.01, held=[0, 1])
    agree(run.x(), expected, 1e-7)
    agree(run.x("fine.fine"), J @ expected, 1e-7)


@case
def hexahedra_cut_into_eight():
    """Nodes of the grid, and then what is new in a cell: middles of edges, of faces, and its own. The fine cells ride on the coarse."""
    places = np.array([(i, j, k) for k in range(2) for j in range(2) for i in range(3)], float) * [2, 1, 1]
    J = [np.eye(12)[i] for i in range(12)]

    def mean(nodes):
        row = np.eye(12)[list(nodes)].mean(axis=0)
        found = [i for i, known in enumerate(J) if np.allclose(known, row)]
        if not found:
            J.append(row)
        return found[0] if found else len(J) - 1
    fine = []
    for c in ((0, 1, 4, 3, 6, 7, 10, 9), (1, 2, 5, 4, 7, 8, 11, 10)):
        for names in "01 12 32 03 04 15 26 37 45 56 76 47 0123 0154 1265 3267 0374 4567 01234567".split():
            mean([c[int(i)] for i in names])
        for corner in PLACES.astype(int):  # of the part at this corner
            def at(side):
                near = [k for k in range(8) if all(PLACES[k][a] == corner[a] for a in range(3) if side[a] == corner[a])]
                return mean([c[k] for k in near])
            fine.append([at([int(s) for s in side]) for side in PLACES])
    J = np.array(J)
    field = hexahedra(fine, J @ places, 300, 0.3)

    def carried(x, v):
        f, K = field(J @ x, J @ v)
        I = np.kron(J, np.eye(3))
        return J.T @ f, I.T @ K @ I
    expected = euler(places, np.eye(12), together(gravity(np.ones(12), [0, -10, 0]), carried), 10, 0.01, held=[0, 3, 6, 9])
    for mapping in ("BarycentricMapping", "Mesh2PointMechanicalMapping"):
        run = Run(root(EXACT + '<RegularGridTopology name="grid" n="3 2 2" min="0 0 0" max="4 1 1"/><MechanicalObject name="dofs"/>'
                       '<UniformMass totalMass="12"/><FixedConstraint indices="0 3 6 9"/><Node name="fine">'
                       '<HexahedronSetTopologyContainer name="cells"/><HexahedronSetTopologyModifier/>'
                       '<SimpleTesselatedHexaTopologicalMapping input="@../grid" output="@cells"/><MechanicalObject name="fine"/>'
                       f'<{mapping}/><HexahedronFEMForceField method="polar" youngModulus="300" poissonRatio="0.3"/></Node>'), 10)
        agree(run.x(), expected, 1e-7)
        agree(run.x("fine.fine"), J @ expected, 1e-7)


@case
def points_of_edges_in_the_order_of_cells():
    """Edges that a mesh does not list: of tetrahedra, then hexahedra, else of triangles (from the side across their first node on)
    and quads, as they come."""
    rng = np.random.default_rng(3)
    nodes = rng.uniform(size=(9, 3))
    tet, hexa = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)], [(0, 1), (0, 3), (0, 4), (1, 2), (1, 5), (2, 3), (2, 6), (3, 7), (4, 5),
                                                                   (4, 7), (5, 6), (6, 7)]
    turns = {n: [((j + 1) % n, (j + 2) % n) for j in range(n)] for n in (3, 4)}
    for kind, container, lists in (("triangles", "TriangleSetTopologyContainer", [((5, 2, 7), turns[3]), ((7, 2, 1), turns[3])]),
                                   ("quads", "QuadSetTopologyContainer", [((3, 1, 7, 4), turns[4])]),
                                   ("tetrahedra", "TetrahedronSetTopologyContainer", [((4, 0, 7, 2), tet), ((7, 5, 2, 4), tet)]),
                                   ("hexahedra", "HexahedronSetTopologyContainer", [((8, 3, 1, 0, 2, 7, 6, 5), hexa)])):
        edges = []
        for cell, sides in lists:
            for a, b in sides:
                edge = tuple(sorted((cell[a], cell[b])))
                if edge not in edges:
                    edges.append(edge)
        cells = "  ".join(" ".join(map(str, cell)) for cell, _ in lists)
        run = Run(root(EXACT + f'<{container} name="cells" position="{numbers_of(nodes)}" {kind}="{cells}"/><MechanicalObject name="dofs"/>'
                       '<UniformMass totalMass="1"/><Node name="points"><PointSetTopologyContainer name="cloud"/>'
                       '<Mesh2PointTopologicalMapping input="@../cells" output="@cloud" edgeBaryCoords="0.25 0 0"/>'
                       '<MechanicalObject name="dofs"/><Mesh2PointMechanicalMapping/></Node>', 'gravity="0 0 0"'), 1)
        agree(run.x("points.dofs"), [0.75 * nodes[a] + 0.25 * nodes[b] for a, b in edges])


def weights_of_lines(point, frames, lines, k):
    def weight(a, b):
        places = frames[a, :3] + np.linspace(0, 1, 1001)[:, None] * (frames[b, :3] - frames[a, :3])
        return np.sum(np.linalg.norm(places - point, axis=1)**-float(k)) * np.linalg.norm(frames[b, :3] - frames[a, :3]) / 1000
    return np.array([weight(*line) for line in lines])


@case
def points_that_follow_lines():
    """As those that follow the frames at the first nodes of the lines, by the integrals of 1/d^k over them."""
    frames = np.array([[0, 0, 0, *oriented([1, 2, 0], 0.4)], [1, 0.1, 0, *oriented([0, 1, 1], -0.7)], [2, 0, 0.2, *oriented([1, 0, 0], 0.2)],
                       [3, 0, 0, *oriented([1, 1, 1], 1.0)], [4, 0.5, 0, *oriented([0, 0, 1], 1.0)]])
    lines = [(0, 1), (1, 2), (2, 3), (3, 4)]
    points = np.array([[0.3, 0.5, 0.1], [1.4, -0.4, 0.2], [2.5, 0.2, 0.6], [3.5, 0.05, 2.0], [0.9, 0.3, -0.5]])
    scene = node(EXACT + '<MeshTopology name="bones" position="0 0 0  1 0 0  2 0 0  3 0 0  4 0 0" lines="0 1  1 2  2 3  3 4"/>'
                 f'<MechanicalObject name="dofs" template="Rigid3d" position="{numbers_of(frames)}"/>'
                 '<UniformMass vertexMass="1.5 1 [0.2 0 0,0 0.3 0,0 0 0.4]"/><FixedConstraint indices="0"/><Node name="c">'
                 f'<MechanicalObject name="skin" position="{numbers_of(points)}"/>{{}}<RestShapeSpringsForceField stiffness="60"/>'
                 '<ConstantForceField totalForce="3 -2 5"/></Node>')
    for more, k, most, level in (("", 4, 4, 3), ('weightCoef="2" numberInfluencedLines="2"', 2, 2, 3),
                                 ('numberInfluencedLines="3" neighborhoodLevel="1"', 4, 3, 1)):
        indices, weights = [], []
        for point in points:
            w = weights_of_lines(point, frames, lines, k)
            order = np.argsort(-w)
            near = [line for line in order if abs(line - order[0]) <= level][:most]  # of a chain
            near += [near[0]] * (most - len(near))
            shares = [w[line] if line not in near[:i] else 0 for i, line in enumerate(near)]
            indices += [lines[line][0] for line in near]
            weights += list(np.array(shares) / sum(shares))
        named = f'<SkinningMapping nbRef="{most}" indices="{" ".join(map(str, indices))}" weight="{" ".join(map(str, weights))}"/>'
        run, other = Run(scene.format(f"<LineSetSkinningMapping {more}/>"), 6), Run(scene.format(named), 6)
        agree(run.x("c.skin"), other.x("c.skin"))
        agree(run.x("dofs", 7), other.x("dofs", 7))


@case
def numbers_without_a_weight():
    body = EXACT + '<MechanicalObject name="dofs" template="Vec1" position="0 1"/><UniformMass totalMass="2"/>'
    for gravity_, more, told in (("-10 0 0", "", True), ("0 -10 0", "", False), ("0 0 0", '<Gravity gravity="1 0 0"/>', True)):
        run = Run(root(more + body, f'gravity="{gravity_}"'), 1)
        assert ("numbers have a weight" in run.text) == told, run.text
    sixes = EXACT + '<MechanicalObject name="dofs" template="Vec6" position="0 1 2 3 4 5"/><UniformMass totalMass="2"/>'
    Run(root(sixes, 'gravity="0 -10 0"'), 1).says("numbers have a weight")


@case
def names_that_loops_had():
    held = EXACT + BODY + '<LinearSolverConstraintCorrection/><UniformLagrangianConstraint constrainToRestPos="1"/>'
    for loop in ('<MasterContactSolver tolerance="1e-6" maxIt="100"/>', '<FreeMotionMasterSolver/><LCPConstraintSolver/>'):
        run = Run(root(loop + held), 5)
        agree(run.x(), [[0, 0, 0], [1, 0, 0]])
        assert "nothing finds forces of constraint" not in run.text, run.text
    falls(Run(root('<MasterSolver/>' + EXACT + BODY), 10))
    falls(Run(root('<MultiStepMasterSolver integrationSteps="2"/>' + EXACT + BODY), 10), h=0.005)


@case
def names_that_were_short():
    """The same scene with the names that SOFA had until 24.12 and those that it has."""
    pairs = (("SphereQuad", "SphereQuadTopology"), ("CylinderGrid", "CylinderGridTopology"), ("SphereGrid", "SphereGridTopology"))
    grid = '<{} nx="3" ny="3" nz="3" radius="1" length="2" axis="0 0 1"/><MechanicalObject name="dofs"/><UniformMass totalMass="27"/>'
    for short, name in pairs:
        agree(Run(root(EXACT + grid.format(short)), 3).x(), Run(root(EXACT + grid.format(name)), 3).x())
    for short, name in (("MinResSolver", "MinResLinearSolver"), ("MINRESSolver", "MinResLinearSolver"), ("SVD", "SVDLinearSolver"),
                        ("SVDLinear", "SVDLinearSolver")):
        falls(Run(root(f'<EulerImplicitSolver/><{short}/>' + BODY), 10))
    falls(Run(root('<Background/><Stats/><Viewer/><AttachBodyButton/><PointSplat/><IncrementalSAP/>' + EXACT + BODY), 10))
    slowed = BODY.replace("/><Uniform", ' velocity="1 0 0  1 0 0"/><Uniform')
    agree(Run(node(EXACT + slowed + '<DampVelocity rate="3"/>'), 5).x(), Run(node(EXACT + slowed + '<DampVelocitySolver rate="3"/>'), 5).x())
    variational = '<{} newtonError="1e-9" steps="9" rayleighMass="0" rayleighStiffness="0"/><SparseLDLSolver/>'
    agree(*(Run(root(variational.format(name) + BODY), 5).x() for name in ("VariationalSolver", "VariationalSymplecticSolver")))


X4_UNIT = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])


@case
def attributes_that_would_change_the_result():
    """What SOFA reads and is not here is an error; at its default it is nothing."""
    mesh = '<MeshTopology position="0 0 0  1 0 0  0 1 0" triangles="0 1 2"/><MechanicalObject name="dofs"/><UniformMass totalMass="3"/>'
    falls(Run(root(EXACT + mesh + '<TriangularFEMForceFieldOptim youngModulus="10" poissonRatio="0.3" restScale="1" damping="0"/>'),
              10), start=(0, 0, 1))
    Run(root(EXACT + mesh + '<TrianglePressureForceField pressure="0 0 1" normal="0 1 1" dmin="-1" dmax="1"/>'), 1).fails(2, "dmin")


COMMENTED = """<?xml version="1.0"?>
<!-- of M\u00fcller's scene -->
<Node name="root" gravity="0 0 0" dt="0.01">
  <!-- of what has no effect -->
  <VisualStyle displayFlags="showAll"/>

  <!-- first -->
  <Node name="part"> <!-- of the state --> <MechanicalObject name="dofs" position="0 0 0"/>
    <UniformMass totalMass="1"/>
    <!-- at the end of part -->
  </Node>

  <!-- of the solver,
       on two lines -->
  <EulerImplicitSolver/>
  <SparseLDLSolver/>
  <OglModel/>
  <!-- last -->
</Node>
<!-- behind -->
"""


@case
def migration_keeps_comments_blank_lines_and_order():
    with tempfile.TemporaryDirectory() as folder:
        with open(os.path.join(folder, "a.scn"), "w", encoding="utf-8") as out:
            out.write(COMMENTED)
        done = STROMA.run(["migrate", "a.scn"], folder)
    assert done.returncode == 0, done.stderr
    text = done.stdout
    order = ["of M\u00fcller's scene", "<Node name=\"root\"", "of what has no effect", "<!-- first -->",
             "<Node name=\"part\"",
             "of the state", "<MechanicalObject", "<UniformMass", "at the end of part", "</Node>",
             "of the solver,\n       on two lines -->", "<EulerImplicitSolver", "<SparseLDLSolver", "<!-- last -->", "</Node>",
             "<!-- behind -->"]
    places = [text.index(order[0])]
    for words in order[1:]:
        places.append(text.find(words, places[-1] + 1))
        assert places[-1] > 0, f"'{words}' is not where it was:\n{text}"
    for words in order:
        if "Node" not in words:
            assert text.count(words) == 1, f"'{words}' stands there {text.count(words)} times:\n{text}"
    assert "\n\n  <!-- of the solver," in text, text
    assert '  <VisualStyle displayFlags="showAll"/>' in text, text
    assert max(len(line) for line in text.splitlines()[2:]) <= 140


@case
def states_without_mass_stay_where_they_are():
    """Targets of scenes that programs steer, below an integrator or with one of their own."""
    goal = '<Node name="goal">{}<MechanicalObject name="goal" position="3 0 0"/></Node>'
    for solver in ("", EXACT):
        run = Run(root(EXACT + BODY + goal.format(solver)), 10)
        falls(run)
        agree(run.x("goal.goal"), [[3, 0, 0]])
        run.says("has no mass, and nothing acts on it")
    # a spring without damping and length draws it to where the other end is at the end of each step, and feels nothing
    spring = '<StiffSpringForceField object1="@goal/goal" object2="@./" spring="0 0 100 0 0"/>'
    run = Run(root(EXACT + BODY + goal.format("") + spring), 10)
    agree(run.x("goal.goal"), [[0, fallen(10), 0]], 1e-7)
    falls(run)
    spring = '<RestShapeSpringsForceField points="0"/>'
    Run(root('<NewmarkImplicitSolver/><SparseLDLSolver/>' + goal.replace("/></Node>", "/>" + spring + "</Node>").format("")), 1).fails(
        2, "has no mass")
    Run(root('<EulerExplicitSolver/>' + BODY + goal.replace("/></Node>", "/>" + spring + "</Node>").format("")), 1).fails(2, "has no mass")
    # of a body whose nodes are those of two states, one of which has nothing else, it has the mass of those nodes alone
    parts = ('<Node name="free"><MechanicalObject name="free" position="0 0 0  1 0 0"/></Node><Node name="held"><MechanicalObject name="held" '
             'position="2 0 0"/><UniformMass totalMass="1"/><FixedConstraint/></Node><Node name="all"><MechanicalObject name="all"/>'
             '<SubsetMultiMapping input="@../free/free @../held/held" output="@all" indexPairs="0 0  0 1  1 0"/><UniformMass totalMass="3"/>'
             '<ConstantForceField indices="0" forces="2 0 0"/></Node>')
    x = Run(root(EXACT + parts), 10).x("free.free")
    agree(x, [[-fallen(10) * 0.2, fallen(10), 0], [1, fallen(10), 0]])


@case
def joints_below_their_container():
    """A hinge about z under gravity: y'' = -m g l / (m l^2 + I) where it hangs sideways."""
    joints = ('<Node name="centers"><Node name="c">'
              '<ArticulationCenter parentIndex="0" childIndex="1" posOnParent="0 0 0" posOnChild="-1 0 0" articulationProcess="0"/>'
              '<Node name="a"><Articulation translation="0" rotation="1" rotationAxis="0 0 1" '
              'articulationIndex="0"/></Node></Node></Node>')
    body = ('<Node name="rigid"><MechanicalObject template="Rigid3" name="dofs" position="0 0 0 0 0 0 1  1 0 0 0 0 0 1"/>'
            '<UniformMass vertexMass="2 1 1 0 0 0 1 0 0 0 1"/><ArticulatedSystemMapping input1="@../y" output="@dofs"/></Node>')
    scene = root(f'<Node name="arm">{EXACT}<MechanicalObject name="y" template="Vec1" position="0"/><ArticulatedHierarchyContainer/>'
                 f'{joints}{body}</Node>')
    deeper = scene.replace('<Node name="a">', '<Node name="articulations"><Node name="a">').replace(
        'articulationIndex="0"/></Node>', 'articulationIndex="0"/></Node></Node>')
    for each in (scene, deeper):
        agree(Run(each, 1).x("arm.y", 1), [[-0.01**2 * 2 * 10 / (2 + 2)]], 1e-3)


@case
def nodes_that_follow_without_positions_of_their_own():
    child = '<Node name="c"><MechanicalObject name="dofs"/>{}<ConstantForceField totalForce="0 0 6"/></Node>'
    three = EXACT + '<MechanicalObject name="d" position="0 0 0  1 0 0  2 0 0"/><UniformMass totalMass="3"/>'
    push = euler(np.zeros((1, 3)), [[1]], load({0: np.array([0, 0, 3.0])}), 5, 0.01)[0, 2]
    run = Run(node(three + child.format('<SubsetMapping indices="2 1"/>')), 5)
    agree(run.x("c.dofs"), [[2, 0, push], [1, 0, push]])
    agree(run.x("d"), [[0, 0, 0], [1, 0, push], [2, 0, push]])
    run = Run(node(three + child.format("<IdentityMapping/>")), 5)
    agree(run.x("c.dofs"), [[i, 0, push * 2 / 3] for i in range(3)])


@case
def points_on_surfaces_and_lines():
    """They start at their feet on the body, and share forces with its nodes."""
    square = '<MechanicalObject name="d" position="0 0 0  2 0 0  2 2 0  0 2 0"/><UniformMass totalMass="4"/>'
    child = ('<Node name="c"><MechanicalObject name="dofs" position="0.5 0.5 0.1"/><BarycentricMapping/>'
             '<ConstantForceField forces="0 0 8"/></Node>')
    push = 0.01**2 * 8
    for cells, shares in (('quads="0 1 2 3"', [9 / 16, 3 / 16, 1 / 16, 3 / 16]), ('triangles="0 1 3  1 2 3"', [1 / 2, 1 / 4, 0, 1 / 4]),
                          ('edges="0 1  1 2"', [3 / 4, 1 / 4, 0, 0])):
        body = f'<MeshTopology position="0 0 0  2 0 0  2 2 0  0 2 0" {cells}/>'
        run = Run(node(EXACT + body + square + child), 1)
        agree(run.x("d")[:, 2], np.array(shares) * push)
        foot = [0.5, 0 if "edges" in cells else 0.5, push * np.dot(shares, shares)]
        agree(run.x("c.dofs"), [foot])


@case
def the_first_mesh_of_a_node():
    """A state takes the first one, and fields and masses the last."""
    two = '<MeshTopology name="m" position="0 0 0  1 0 0"/><MeshTopology position="5 0 0  6 0 0  7 0 0"/>'
    run = Run(node(EXACT + two + '<MechanicalObject name="dofs"/><UniformMass totalMass="1"/>'), 1)
    agree(run.x(), [[0, 0, 0], [1, 0, 0]])
    cells = '<EdgeSetTopologyContainer edges="0 1" position="0 0 0  1 0 0"/>'
    run = Run(root(EXACT + f'<MeshTopology position="0 0 0  1 0 0"/><MechanicalObject name="dofs"/>{cells}<UniformMass totalMass="2"/>'
                   '<MeshSpringForceField linesStiffness="50"/><FixedConstraint indices="0"/>'), 10)
    X = np.array([[0, 0, 0], [1, 0, 0]], float)
    agree(run.x(), euler(X, np.eye(2), together(gravity(np.ones(2), [0, -10, 0]), springs([(0, 1)], X, 50)), 10, 0.01, held=[0]))


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
def external_points_of_the_own_rest_shape():
    spring = '<RestShapeSpringsForceField points="{}" external_points="0" stiffness="10"/>'
    pulled = Run(root(EXACT + BODY + spring.format("0")), 10)
    agree(pulled.x(), Run(root(EXACT + BODY + spring.format("0").replace('external_points="0"', "")), 10).x())
    other = Run(root(EXACT + BODY + spring.format("1")), 10)  # another node than that of the spring: its number does not count
    agree(other.x(), Run(root(EXACT + BODY + spring.format("1").replace('external_points="0"', "")), 10).x())


@case
def names_of_integrators_to_come():
    falls(Run(root(EXACT.replace("EulerImplicitSolver", "EulerImplicitIntegrationScheme") + BODY), 10))


# ---- measures of cells, middles and rods ----

def gradient_of(measure, x, h=1e-5):
    """By central differences: (gradient, Hessian)."""
    x = np.asarray(x, float)
    n = x.size
    unit = np.eye(n).reshape(n, *x.shape) * h
    g = np.array([(measure(x + u) - measure(x - u)) / (2 * h) for u in unit])
    H = np.array([[(measure(x + u + w) - measure(x + u - w) - measure(x - u + w) + measure(x - u - w)) / (4 * h * h) for w in unit]
                  for u in unit])
    return g, H


def measured(measure, k, rest, always=False):
    """A spring on a measure; of its tangent the geometric part where the force pulls."""
    def fields(x, v):
        g, H = gradient_of(measure, x)
        force = -k * (measure(x) - rest)
        return (force * g).reshape(-1, 3), -k * np.outer(g, g) + (force * H if force < 0 or always else 0)
    return fields


def area(x):
    return np.linalg.norm(np.cross(x[1] - x[0], x[2] - x[0])) / 2


def volume(x):
    return np.dot(x[1] - x[0], np.cross(x[2] - x[0], x[3] - x[0])) / 6


@case
def springs_on_areas_volumes_and_heights():
    cells = f'<MeshTopology name="net" position="{X4_TEXT}" triangles="0 1 2" tetrahedra="0 1 2 3"/>'
    body = cells + '<MechanicalObject name="dofs" velocity="{}"/><UniformMass totalMass="4"/><Node name="c"><MechanicalObject template='
    body += '"Vec1d" name="y"/>{}<RestShapeSpringsForceField stiffness="{}"/></Node>'
    for out in (1, -1):  # it grows and shrinks: with the geometric stiffness and without
        v = out * X4 * 2.0
        text = " ".join(str(value) for value in v.ravel())
        for kind, measure, k in (("Area", area, 30), ("Volume", volume, 80)):
            mapping = f'<{kind}Mapping topology="@../net" applyRestPosition="1"/>'
            expected = euler(X4, np.eye(4), measured(measure, k, measure(X4)), 10, 0.01, v=v)
            agree(Run(node(EXACT + body.format(text, mapping, k)), 10).x(), expected, 1e-6)
            other = euler(X4, np.eye(4), measured(measure, k, measure(X4), True), 10, 0.01, v=v)
            exact = mapping.replace("/>", ' geometricStiffness="Exact"/>')
            agree(Run(node(EXACT + body.format(text, exact, k)), 10).x(), other, 1e-6)
            if out < 0:
                differ(expected, other, 1e-5)
    heights = '<DistanceToPlaneMapping planeNormal="0 0 2" planePoint="0 0 1"/>'
    n = np.array([0, 0, 1.0])

    def held(x, v):
        return -5 * np.outer(x @ n - 1, n), -5 * np.kron(np.eye(4), np.outer(n, n))
    agree(Run(node(EXACT + body.format("0 0 0", heights, 5)), 10).x(), euler(X4, np.eye(4), held, 10, 0.01), 1e-9)
    Run(node(EXACT + body.format("0 0 0", heights.replace("0 0 2", "0 0 0"), 5)), 1).fails(2, "planeNormal is zero")
    Run(node(EXACT + body.format("0 0 0", '<AreaMapping topology="@../net"/>', 5).replace('triangles="0 1 2"', "")), 1).fails(
        2, "there are no triangles")


@case
def springs_on_squares():
    """y = x^2, E = k/2 y^2: a force 2 k x^3, and the tangent of it."""
    scene = node(EXACT + '<MechanicalObject name="dofs" template="Vec1d" position="1"/><UniformMass totalMass="1"/><Node name="c">'
                 '<MechanicalObject template="Vec1d"/><SquareMapping/><RestShapeSpringsForceField stiffness="50"/></Node>')
    x, v, h, k = 1.0, 0.0, 0.01, 50
    for _ in range(20):
        f, K = -2 * k * x**3, -k * 4 * x * x - 2 * k * x * x
        v += (h * f + h * h * K * v) / (1 - h * h * K)
        x += h * v
    agree(Run(scene, 20).x("dofs", 1), [[x]])


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


# ---- engines, and what they accept ----

@case
def engines_of_meshes():
    net = ('<MeshTopology name="n" position="0 0 0  1 0 0  1 1 0  0 1 0  2 0 0" triangles="0 1 2  0 2 3  1 4 2" edges="0 1  1 4"/>')
    part = net + ('<MeshSubsetEngine name="e" inputPosition="@n.position" inputTriangles="@n.triangles" inputEdges="@n.edges" '
                  'indices="2 0 1 4"/>')
    agree(placed(part, "e.position"), [[1, 1, 0], [0, 0, 0], [1, 0, 0], [2, 0, 0]])
    # cells with the new numbers: areas of a surface are masses of its nodes
    body = ('<Node name="b"><TriangleSetTopologyContainer position="@../e.position" triangles="@../e.triangles"/><MechanicalObject/>'
            '<DiagonalMass name="mass" massDensity="6"/></Node><Expect of="/b/mass.totalMass" is="{}"/>')
    assert Run(node(EXACT + part + body.format(6)), 1).code == 0
    # a tetrahedron that lacks a face: with the lid it holds a sixth
    lidless = ('<MeshTopology name="n" position="0 0 0  3 0 0  0 3 0  0 0 3" triangles="0 2 1  0 1 3  0 3 2"/>'
               '<MeshClosingEngine name="e" inputPosition="@n.position" inputTriangles="@n.triangles"/>')
    agree(placed(lidless, "e.position"), [[0, 0, 0], [3, 0, 0], [0, 3, 0], [0, 0, 3], [1, 1, 1]])
    agree(placed(lidless, "e.closingPosition")[3], [1, 1, 1])
    closed = lidless + ('<GenerateRigidMass name="m" position="@e.position" triangles="@e.triangles" density="1"/>'
                        '<Expect of="/m.volume" is="4.5"/>')
    run = Run(node(EXACT + closed + BODY), 1)
    assert run.code == 0, run.text
    Run(node(EXACT + closed.replace("0 3 2", "0 2 3")), 1).fails(2, "/e: two holes meet")
    Run(node(EXACT + part.replace("2 0 1 4", "2 7")), 1).fails(2, "indices names 7")


@case
def the_nearest_nodes():
    line = '<MechanicalObject name="dofs" position="0 0 0  1 0 0  2 0 0  3 0 0  4 0 0"/><UniformMass totalMass="5"/>'
    for words, held in (('centers="1.2 0 0" radii="2" N="2"', [1, 2]), ('centers="0 0 0  4 0 0" radii="1.5" N="9"', [0, 1, 3, 4]),
                        ('centers="0 0 0  4 0 0" radii="0.5 1.5" N="2"', [0, 4])):
        run = Run(root(EXACT + line + f'<ProximityROI name="r" {words}/><FixedConstraint indices="@r.indices"/>'), 10)
        agree(run.x()[:, 1], [0 if i in held else fallen(10) for i in range(5)])
    Run(root(EXACT + line + '<ProximityROI name="r" centers="0 0 0" radii="1 2" N="1"/>'), 1).fails(2, "2 radii for 1 centers")


@case
def cells_outside_of_a_region():
    """What is not in the box weighs: two of three triangles, by their centres."""
    scene = node(EXACT + '<MeshTopology name="n" position="0 0 0  1 0 0  0 1 0  1 1 0  2 1 0" triangles="0 1 2  1 3 2  1 4 3"/>'
                 '<MechanicalObject/><UniformMass totalMass="1"/><BoxROI name="r" box="-1 -1 -1 0.4 2 1" strict="0"/>'
                 '<Node name="b"><TriangleSetTopologyContainer position="@../n.position" triangles="@../r.trianglesOutROI"/>'
                 '<MechanicalObject/><DiagonalMass name="mass" massDensity="2"/><FixedConstraint indices="0"/></Node>'
                 '<Expect of="/b/mass.totalMass" is="{}"/>')
    assert Run(scene.format(2), 1).code == 0
    assert Run(scene.format(3), 1).code == 1


@case
def many_points_that_look_for_the_nearest():
    """As a search through all pairs finds them, ties to the first."""
    rng = np.random.default_rng(3)
    a, b = np.round(rng.uniform(-1, 1, (60, 3)), 1), np.round(rng.uniform(-1, 1, (40, 3)), 1)
    distance = np.linalg.norm(a[None] - b[:, None], axis=2)
    nearest = [(i.argmin(), j) for j, i in enumerate(distance) if i.min() < 0.35]
    assert 10 < len(nearest) < 40

    def text(points):
        return " ".join(str(value) for value in np.ravel(points))
    bodies = (f'<Node name="one"><MechanicalObject name="dofs" position="{text(a)}"/><UniformMass/></Node><Node name="two">'
              f'<MechanicalObject name="dofs" position="{text(b)}"/><UniformMass/></Node>'
              '<NearestPointROI name="e" object1="@one/dofs" object2="@two/dofs" radius="0.35"/>')
    for k, points in ((1, a), (2, b)):
        values = f'<ValuesFromIndices name="v" template="Vec3" in="{text(points)}" indices="@e.indices{k}"/>'
        agree(placed(bodies + values, "v.out"), points[[pair[k - 1] for pair in nearest]])


@case
def made_meshes_are_placed_as_loaded_ones():
    place = 'scale3d="2 4 1" rotation="0 0 90" translation="0 0 5"'
    agree(placed(f'<GridMeshCreator name="e" resolution="2 2" {place}/>', "e.position"), [[0, 0, 5], [0, 2, 5], [-4, 0, 5], [-4, 2, 5]])
    agree(placed(f'<StringMeshCreator name="e" resolution="3" {place}/>', "e.position"), [[0, 0, 5], [0, 1, 5], [0, 2, 5]])
    # triangles of split quads, and turned round: a pressure along the normals
    load = ('<MechanicalObject name="dofs" src="@e"/><TriangleSetTopologyContainer src="@e"/><UniformMass totalMass="4"/>'
            '<SurfacePressureForceField pressure="4"/>')
    up = Run(node(EXACT + '<GridMeshCreator name="e" trianglePattern="0" triangulate="1"/>' + load), 1).x()
    agree(up[:, 2].sum(), 4 * 0.01**2, 1e-3)
    down = Run(node(EXACT + '<GridMeshCreator name="e" trianglePattern="0" triangulate="1" flipNormals="1"/>' + load), 1).x()
    agree(down[:, 2], -up[:, 2], 1e-3)


@case
def lines_of_round_grids():
    """SOFA's grids list the edges of the triangles of all quads; a disc has two triangles for each of its quads."""
    rod = '<CylinderGridTopology name="e" nx="2" ny="2" nz="2" axis="0 0 1" radius="1" length="1"/>'
    x = placed(rod, "e.position")
    faces = [(0, 1, 3, 2), (4, 5, 7, 6), (0, 1, 5, 4), (2, 3, 7, 6), (0, 2, 6, 4), (1, 3, 7, 5)]
    pairs = {tuple(sorted(pair)) for a, b, c, d in faces for pair in ((a, b), (b, c), (c, d), (d, a), (a, c))}
    fields = together(gravity(np.ones(8), [0, -10, 0]), springs(sorted(pairs), x, 500))
    scene = root(EXACT + rod + '<MechanicalObject name="dofs"/><UniformMass totalMass="8"/><MeshSpringForceField linesStiffness="500"/>'
                 '<FixedConstraint indices="0 1 2"/>')
    agree(Run(scene, 10).x(), euler(x, np.eye(8), fields, 10, 0.01, held=[0, 1, 2]), 1e-7)
    disc = '<CylinderGridTopology name="e" nx="2" ny="2" nz="1" axis="0 0 1" radius="1"/>'
    flat = placed(disc, "e.position")
    fields = together(gravity(np.ones(4), [0, -10, 0]), springs([(0, 1), (0, 2), (0, 3), (1, 3), (2, 3)], flat, 500))
    agree(Run(scene.replace(rod, disc).replace('totalMass="8"', 'totalMass="4"'), 10).x(),
          euler(flat, np.eye(4), fields, 10, 0.01, held=[0, 1, 2]), 1e-7)


@case
def numbers_of_nodes_of_a_grid():
    """nx, ny and nz together win over n; one of them alone does not count."""
    for words, count in (('n="2 2 2" nx="3" ny="2" nz="2"', 12), ('n="2 2 2" nx="3"', 8)):
        for grid in ("RegularGridTopology", "CylinderGridTopology"):
            box = 'min="0 0 0" max="1 1 1"' if grid.startswith("Reg") else ""
            run = Run(node(EXACT + f'<{grid} {words} {box}/><MechanicalObject name="dofs"/><UniformMass totalMass="1"/>'), 1)
            assert len(run.x()) == count, run.text


@case
def words_and_numbers_that_cannot_be():
    net = '<MeshTopology name="n" position="0 0 0  1 0 0"/>'
    Run(node(net + '<TransformPosition name="e" input_position="@n.position" method="fromFile"/>' + EXACT + BODY), 1).fails(2, "/e: ", "file")
    for number in ("1e300", "-1e300", "9999999999999", "2.5e9"):
        run = Run(root(EXACT + BODY + f'<FixedConstraint indices="0 {number}"/>'), 1)
        assert run.code in (0, 2), run.text
    Run(node(EXACT + '<IndexValueMapper name="e" indices="99999999" value="1"/>' + BODY), 1).fails(2, "indices names 99999999")


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
def regions_that_would_follow_a_body():
    run = Run(root(EXACT + BODY + '<BoxROI name="r" box="-1 -1 -1 0.5 1 1" position="@dofs.position"/><FixedConstraint '
                   'indices="@r.indices"/>'), 2)
    run.says("is read once", "in SOFA BoxROI follows /dofs")
    for more in ('position="@dofs.rest_position"', 'position="@dofs.position" doUpdate="0"'):
        run = Run(root(EXACT + BODY + f'<BoxROI name="r" box="-1 -1 -1 0.5 1 1" {more}/><FixedConstraint indices="@r.indices"/>'), 2)
        assert "is read once" not in run.text, run.text


@case
def templates_of_old_scenes():
    frames = '<MechanicalObject template="Rigid" name="dofs" position="0 0 0 0 0 0 1"/><UniformMass/>'
    child = '<Node name="c"><MechanicalObject template="Vec3d" name="p" position="0 1 0"/><RigidMapping template="Rigid,Vec3d"/></Node>'
    run = Run(root(EXACT + frames + child), 10)
    agree(run.x("c.p"), [[0, 1 + fallen(10), 0]])


@case
def cells_that_take_the_nodes_of_the_state():
    """A mesh of edges alone beside a state that takes its points from a loader, or from a grid before it."""
    line = '<StringMeshCreator name="l" resolution="4"/>'
    x = np.array([[i / 3, 0, 0] for i in range(4)])
    fields = together(gravity(np.ones(4), [0, -10, 0]), springs([(0, 1), (1, 2), (2, 3)], x, 500))
    expected = euler(x, np.eye(4), fields, 10, 0.01, held=[0])
    springs_on = '<UniformMass totalMass="4"/><MeshSpringForceField linesStiffness="500"/><FixedConstraint indices="0"/>'
    for state in ('<MechanicalObject name="dofs" src="@l"/>', '<MechanicalObject name="dofs" position="@l.position"/>'):
        agree(Run(root(EXACT + line + '<MeshTopology edges="@l.edges"/>' + state + springs_on), 10).x(), expected, 1e-7)
    grid = '<RegularGridTopology n="4 1 1" min="0 0 0" max="1 0 0" computeEdgeList="0"/><MechanicalObject name="dofs"/>'
    agree(Run(root(EXACT + grid + '<EdgeSetTopologyContainer edges="0 1  1 2  2 3"/>' + springs_on), 10).x(), expected, 1e-7)


@case
def a_preconditioner_with_an_inverse_of_its_own():
    x = np.array([[i, 0, 0] for i in range(3)], float)
    fields = together(gravity(np.ones(3), [0, -10, 0]), springs([(0, 1), (1, 2)], x, 500))
    run = Run(root('<EulerImplicitSolver/><PCGLinearSolver iterations="100" tolerance="1e-12" preconditioner="@p"/>'
                   '<PrecomputedWarpPreconditioner name="p"/>' + SPRINGS), 20)
    agree(run.x(), euler(x, np.eye(3), fields, 20, 0.01, held=[0]), 1e-7)
    assert "leads nowhere" not in run.text, run.text


@case
def bools_in_other_cases():
    """As programs print them: what asks for a bool before the component exists reads the same words."""
    spring = '<RestShapeSpringsForceField stiffness="100" points="0 1"/>'
    half = '<EulerImplicitSolver trapezoidalScheme="{}"/><SparseLDLSolver/>' + BODY + spring
    agree(Run(root(half.format("True")), 10).x(), Run(root(half.format("1")), 10).x(), 1e-15)
    differ(Run(root(half.format("True")), 10).x(), Run(root(half.format("False")), 10).x(), 1e-6)
    falls(Run(root(EXACT + BODY + '<Node name="seen"><MechanicalObject name="dofs" position="0 0 0  1 0 0"/>'
                   '<IdentityMapping isMechanical="False"/><ConstantForceField indices="0" forces="0 99 0"/></Node>'), 10))
    falls(Run(root(EXACT + BODY + '<Node name="off" activated="False"><Nonsense/></Node>'), 10))
    weak = Run(root(EXACT + BODY + '<FixedWeakConstraint fixAll="True" stiffness="100"/>'), 10).x()
    agree(weak, Run(root(EXACT + BODY + '<FixedWeakConstraint fixAll="1" stiffness="100"/>'), 10).x(), 1e-15)


@case
def a_follower_pulls_nobody():
    """SOFA attaches one way unless twoWay is given: the push on the second node reaches nobody, and the first loses half of what it
    gains in a step; or half of the push reaches the first."""
    pair = ('<MechanicalObject name="dofs" position="0 0 0  1 0 0"/><UniformMass totalMass="4"/>'
            '<ConstantForceField indices="1" forces="0 8 0"/><AttachProjectiveConstraint indices1="0" indices2="1" {}/>')
    y = v = 0
    for _ in range(10):
        y += 0.01 * (v - 0.1)
        v -= 0.1 / 2
    for given in ("", 'twoWay="0"'):
        agree(Run(root(EXACT + pair.format(given)), 10).x()[0, 1], y)
    agree(Run(root(EXACT + pair.format("")), 10, args=["--without-quirk", "moved-inertia"]).x()[0, 1], fallen(10))
    agree(Run(root(EXACT + pair.format('twoWay="1"')), 10).x()[:, 1], [fallen(10, g=8.0)] * 2)


@case
def quirk_one_sided_turns():
    """The second frame turns back, and the first feels nothing of it."""
    th, w, h, k, inertia = 0.3, 0.0, 0.01, 50, 0.2
    scene = node(EXACT + f'<MechanicalObject name="dofs" template="Rigid3d" position="0 0 0 0 0 0 1  1 0 0 0 0 {np.sin(th / 2):.17g} '
                 f'{np.cos(th / 2):.17g}"/><UniformMass vertexMass="1 1 [0.2 0 0,0 0.2 0,0 0 0.2]"/>'
                 '<AngularSpringForceField indices="0 1" angularStiffness="50 50"/>')
    for _ in range(20):
        w += h * (-k * th - h * k * w) / (inertia + h * h * k)
        th += h * w
    agree(Run(scene, 20).x("dofs", 7), [[0, 0, 0, 0, 0, 0, 1], [1, 0, 0, 0, 0, np.sin(th / 2), np.cos(th / 2)]])
    both = Run(scene, 20, args=["--without-quirk", "one-sided-turns"]).x("dofs", 7)
    assert both[0, 5] > 0.01, both


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
def quirk_torsion_tangent():
    x = np.array([[1.0, 0, 0], [0, 2, 1]])

    def torsion(x, v):
        return 5 * np.cross([0, 0, 1], x), 5 * np.kron(np.eye(2), np.diag([1.0, 1, 0]))
    scene = node(EXACT + '<MechanicalObject name="dofs" position="1 0 0  0 2 1"/><UniformMass totalMass="4"/>'
                 '<TorsionForceField indices="0 1" torque="5" axis="0 0 2" origin="0 0 0"/>')
    expected = euler(x, 2 * np.eye(2), torsion, 20, 0.01)
    agree(Run(scene, 20).x(), expected)
    plain = euler(x, 2 * np.eye(2), lambda x, v: (torsion(x, v)[0], np.zeros((6, 6))), 20, 0.01)
    agree(Run(scene, 20, args=["--without-quirk", "torsion-tangent"]).x(), plain)
    differ(expected, plain, 1e-5)


@case
def curves_are_those_of_the_start_of_a_step():
    one = '<MechanicalObject name="dofs" position="1 2 3"/><UniformMass totalMass="2"/>'
    curve = '<ParabolicConstraint indices="0" P1="0 0 0" P2="1 1 0" P3="2 0 0" BeginTime="0.02" EndTime="0.06"/>'
    for steps, place in ((2, [1, 2, 3]), (3, [0, 0, 0]), (5, [1, 1, 0]), (7, [2, 0, 0])):
        agree(Run(node(EXACT + one + curve), steps).x(), [place])
    agree(Run(node(EXACT + one + curve), 5, args=["--without-quirk", "late-times"]).x(), [[1.5, 0.75, 0]])
    spline = '<HermiteSplineConstraint indices="0" X0="0 0 0" dX0="4 0 0" X1="0 2 0" dX1="0 0 8" BeginTime="0" EndTime="0.04"/>'
    agree(Run(node(EXACT + one + spline), 3).x(), [[0.5, 1, -1]])  # half the way: H10 = -H11 = 1/8


@case
def a_bilinear_movement_is_one_of_its_corners():
    points = '<MechanicalObject name="dofs" position="0 0 0  2 0 0  2 4 0  0 4 0  1 4 0"/><UniformMass totalMass="1"/>'
    moved = ('<{} indices="0 1 2 3 4" cornerPoints="0 0 0  2 0 0  2 4 0  0 4 0" beginConstraintTime="0" '
             'endConstraintTime="0.2" cornerMovements="0 0 0  1 0 0  1 2 0  0 4 0"/>')
    for name in ("BilinearMovementConstraint", "BilinearMovementProjectiveConstraint"):
        agree(Run(node(EXACT + points + moved.format(name)), 30).x(), [[0, 0, 0], [3, 0, 0], [3, 6, 0], [0, 8, 0], [1.5, 7, 0]])


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


@case
def a_subset_of_a_topology_is_a_region():
    grid = '<RegularGridTopology name="grid" n="3 1 1" min="0 0 0" max="2 0 0"/><MechanicalObject name="dofs"/><UniformMass totalMass="3"/>'
    for region in ('box="-0.1 -1 -1 1.1 1 1"', 'centers="0.5 0 0" radii="0.6"'):
        run = Run(root(EXACT + grid + f'<SubsetTopology name="e" {region}/><FixedConstraint indices="@e.indices"/>'), 10)
        agree(run.x()[:, 1], [0, 0, fallen(10)])
    # the second of two tetrahedra, whose nodes are counted in the part; its springs are those of the whole one
    mesh = ('<MeshTopology name="m" position="5 5 5  0 0 0  1 0 0  0 1 0  0 0 1" tetrahedra="0 1 2 3  1 2 3 4"/><MechanicalObject '
            'name="dofs" position="5 5 5  0 0 0  1 0 0  0 1 0  0 0 2"/><UniformMass totalMass="5"/>')
    region = '<SubsetTopology name="e" box="-0.1 -0.1 -0.1 1.1 1.1 2.1" rest_position="@m.position" tetrahedra="@m.tetrahedra" {}/>'
    part = ('<Node name="part"><TetrahedronSetTopologyContainer position="{}" tetrahedra="@../e.{}"/><MechanicalObject name="p" '
            'rest_position="@../m.position"/><{}/><TetrahedronFEMForceField youngModulus="1000" poissonRatio="0.3"/></Node>')
    local = Run(root(EXACT + mesh + region.format('localIndices="true"') + part.format(
        "@../e.pointsInROI", "tetrahedraInROI", 'SubsetMapping indices="@../e.indices"').replace(
            'rest_position="@../m.position"', 'rest_position="@../e.pointsInROI"')), 5)
    agree(local.x(), Run(root(EXACT + mesh + region.format("") + part.format("@../m.position", "tetrahedraInROI", "IdentityMapping")), 5).x())
    differ(local.x()[:, 2], [5, 0, 0, 0, 2], 1e-2)
    Run(root(EXACT + mesh + region.format('localIndices="true"') + part.format("@../m.position", "tetrahedraOutROI", "IdentityMapping")),
        1).fails(2, "keep the numbers of the whole")


TWO = ('<Node name="{0}">{1}<MechanicalObject name="dofs" position="{2}" velocity="{3}"/><UniformMass totalMass="{4}"/></Node>')


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


@case
def bodies_in_a_plane():
    """Rigid2: x, y and the angle, an inertia of one number; Vec2: points that a frame carries or springs tie."""
    m, inertia, h = 2.0, 0.5, 0.01
    frames = ('<MechanicalObject name="dofs" template="Rigid2" position="0 0 0.3  2 0 0" velocity="0 0 0  0.1 0 1"/>'
              '<UniformMass template="Rigid2" vertexMass="2 1 [0.5]"/><FixedConstraint template="Rigid2" indices="0"/>'
              '<ConstantForceField template="Rigid2" indices="1" forces="1 0 0.6"/>')
    points = ('<Node name="c"><MechanicalObject name="p" template="Vec2d" position="1 0  0 1"/><RigidMapping '
              'template="Rigid2,Vec2d" index="{}"/></Node>')
    x, v, g = np.array([2.0, 0, 0]), np.array([0.1, 0, 1]), np.array([1 / m, -10, 0.6 / (m * inertia)])
    for _ in range(10):
        v = v + h * g
        x = x + h * v
    run = Run(root(EXACT + frames + points.format(1)), 10)
    agree(run.x("dofs", 7), [[0, 0, 0, 0, 0, np.sin(0.15), np.cos(0.15)], [*x[:2], 0, 0, 0, np.sin(x[2] / 2), np.cos(x[2] / 2)]])
    turn = np.array([[np.cos(x[2]), -np.sin(x[2])], [np.sin(x[2]), np.cos(x[2])]])
    agree(run.x("c.p")[:, :2], x[:2] + np.array([[1, 0], [0, 1]]) @ turn.T)
    agree(run.x("c.p")[:, 2], [0, 0])
    # a force on what the frame carries turns it, and gravity across the plane does nothing
    pulled = frames.replace("<ConstantForceField", "<NO").replace("velocity=", "novelocity=")
    pulled = pulled[:pulled.index("<NO")] + points.format(1).replace(
        "</Node>", '<ConstantForceField template="Vec2" indices="0" forces="0 3"/></Node>')
    run = Run(root(EXACT + pulled, 'gravity="0 0 -10"'), 1)
    w = h * 3 / (m * inertia)
    agree(run.x("dofs", 7)[1], [2, h * h * 3 / m, 0, 0, 0, np.sin(w * h / 2), np.cos(w * h / 2)], 1e-5)
    springs2 = ('<MechanicalObject name="dofs" template="Vec2" position="0 0  1.5 0" velocity="0 0  0 1"/><UniformMass totalMass="2"/>'
                '<SpringForceField template="Vec2" spring="0 1 100 0 1"/><FixedConstraint indices="0"/>')
    flat = springs2.replace('template="Vec2" ', "").replace("0 0  1.5 0", "0 0 0  1.5 0 0").replace("0 0  0 1", "0 0 0  0 1 0")
    agree(Run(root(EXACT + springs2, 'gravity="0 -10 -7"'), 10).x(), Run(root(EXACT + flat), 10).x())
    Run(root(EXACT + '<MechanicalObject template="Rigid2" position="0 0"/><UniformMass totalMass="1"/>'), 1).fails(
        2, "2 numbers for nodes in a plane", "the angle of each")
    # vectors of what acts in the plane have two numbers too
    ball = '<MechanicalObject name="dofs" template="Vec2" position="0.3 0.2"/><UniformMass totalMass="1"/>'
    for field, wrong in (('PlaneForceField normal="0.6 0.8" d="1" stiffness="90" damping="0"', 'normal="1"'),
                         ('SphereForceField center="0.4 0" radius="1" stiffness="90" damping="0"', 'center="0.4 x"'),
                         ('EllipsoidForceField center="0.4 0 7" vradius="1 2" stiffness="90" damping="0"', 'vradius="1"'),
                         ('LineProjectiveConstraint indices="0" origin="0.3 0.2" direction="1 1"', 'direction="1 2 3 4"')):
        in_space = re.sub(r'(normal|center|vradius|origin|direction)="(\S+) (\S+)( 7)?"',
                          lambda m: f'{m[1]}="{m[2]} {m[3]} {int(m[1] == "vradius")}"', field)
        there = Run(root(EXACT + ball.replace('template="Vec2" ', "").replace("0.3 0.2", "0.3 0.2 0") + f"<{in_space}/>"), 20).x()
        agree(Run(root(EXACT + ball + f"<{field}/>"), 20).x()[:, :2], there[:, :2])
        differ(there[:, :2], [[0.3, 0.2 + fallen(20)]], 1e-3)
        name = wrong.split("=")[0]
        Run(root(EXACT + ball + f"<{field}/>".replace(re.search(name + '="[^"]*"', field)[0], wrong)), 1).fails(2, "is no vector in a plane")


@case
def vectors_as_a_stream_reads_them():
    """The numbers at the start count, a word is zero, and what is not there stays."""
    for text, g in (("0 -3", [0, -3, 0]), ("0 0", [0, 0, 0]), ("5", [5, -9.81, 0]), ("0, -3, 0", [0, 0, 0]), ("1 down 2", [1, 0, 0]),
                    ("", [0, -9.81, 0])):
        run = Run(root(EXACT + BODY, f'gravity="{text}"'), 10)
        agree(run.x()[0], np.array(g) * 0.01**2 * 55, 1e-12)
        run.says("SOFA has")
    moved = Run(root(EXACT + BODY.replace("<MechanicalObject", '<MechanicalObject translation="1 2"'), 'gravity="0 0 0"'), 1)
    agree(moved.x()[0], [1, 2, 0])


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
def systems_of_which_a_solver_takes_one():
    """Parts of a matrix may be in systems that no solver solves."""
    body = BODY + '<MatrixLinearSystem name="all"/><MatrixLinearSystem name="part" assembleMass="false"/>'
    both = '<CompositeLinearSystem name="both" linearSystems="@part @all" solverLinearSystem="@{}"/>'
    falls(Run(root(EXACT.replace("<SparseLDLSolver/>", '<SparseLDLSolver linearSystem="@both"/>') + body + both.format("all")), 10))
    Run(root(EXACT + body + both.format("part")), 1).fails(2, "a matrix without a part of it")


@case
def switches_of_a_matrix_in_a_node_of_its_own():
    """What acts is asked where the solver is that has the matrix, and of all where there is none."""
    matrix = '<Node name="lin"><MatrixLinearSystem name="system" {}/></Node>'
    solver = '<EulerImplicitSolver/><SparseLDLSolver linearSystem="@{}lin/system"/>'
    held = '<FixedProjectiveConstraint indices="0"/>'
    follows = '<Node name="child"><MechanicalObject name="child"/><IdentityMapping/></Node>'
    for switch, acting in (('applyProjectiveConstraints="false"', held), ('applyMappedComponents="false"', follows)):
        falls(Run(root(solver.format("") + matrix.format(switch) + BODY), 10))
        Run(root(solver.format("") + matrix.format(switch) + BODY + acting), 1).fails(2, "a matrix without a part of it")
        body = "<Node name=\"body\">" + solver.format("/") + BODY + "{}</Node>"
        Run(root(matrix.format(switch) + body.format(acting)), 1).fails(2, "a matrix without a part of it")
        beside = '<Node name="lin">' + EXACT + matrix.format(switch)[len('<Node name="lin">'):]
        Run(root(beside + body.format(acting)), 1).fails(2, "a matrix without a part of it")


@case
def meshes_of_topologies_in_older_formats():
    """A topology reads .xs3 and .trian itself; models that draw volumes are no parts."""
    net = "Xsp 3.0\nnumm 2\nmass 1 v 0 0 0 0 0 0 1 1\nmass 2 v 1.5 0 0 0 0 0 1 1\nlnks 1\nlspg 1 1 2 100 0 1\n"
    scene = root(EXACT + '<MeshTopology filename="net.xs3"/><MechanicalObject name="dofs"/><UniformMass totalMass="2"/>'
                 '<OglVolumetricModel name="v"/><IdentityMapping output="@v"/><CollisionGroup/>')
    run = Run(scene, 10, files={"net.xs3": net})
    agree(run.x()[:, 0], [0, 1.5])
    falls(run)


def weights_by_centres(cells, x, p, width=0):
    """Of the cell in which p lies deepest, else of that with the nearest centre; in a grid of `width` first in the cells near by."""
    def affine(cell):
        edges = np.array([x[n] - x[cell[0]] for n in cell[1:]])
        if len(edges) == 2:
            edges = np.vstack([edges, np.cross(*edges)])
        return np.linalg.solve(edges.T, p - x[cell[0]])

    def keys(point):
        return np.floor(np.asarray(point) / width).astype(int)

    def near(cell, key, reach):
        low, high = keys(x[list(cell)].min(axis=0)), keys(x[list(cell)].max(axis=0))
        return all(low[a] <= key[a] + reach and high[a] >= key[a] - reach for a in range(3))

    best = None
    for reach in ((0, 1) if width else ()) + (None,):
        if best is not None and (reach is None or abs(best[0]) <= width / 2):
            break
        for cell in cells:
            if reach is not None and not near(cell, keys(p), reach):
                continue
            u = affine(cell)
            out = max(-u[0], -u[1], -u[2], u.sum() - 1) if len(cell) == 4 else max(-u[0], -u[1], abs(u[2]) - 0.01, u[0] + u[1] - 1)
            if out > 0:
                out = ((p - x[list(cell)].mean(axis=0)) ** 2).sum()
            if best is None or out < best[0]:
                best = out, cell, u
    cell, u = best[1], best[2][:len(best[1]) - 1]
    row = np.zeros(len(x))
    row[list(cell)] = [1 - u.sum(), *u]
    return row


@case
def quirk_centre_cells():
    random = np.random.default_rng(7)
    x = np.array([[i, j, k] for k in range(2) for j in range(2) for i in range(3)], float) + random.uniform(-0.2, 0.2, (12, 3))
    cells = []
    for i in range(2):
        for order in itertools.permutations((1, 3, 6)):
            cell = [i, i + order[0], i + order[0] + order[1], i + 10]
            cells.append(cell if np.linalg.det(x[cell[1:]] - x[cell[0]]) > 0 else [cell[0], cell[2], cell[1], cell[3]])
    v, points = random.uniform(-3, 3, x.shape), random.uniform(-1, 3, (40, 3)) * [1, 0.7, 0.7]
    text = {name: " ".join(repr(float(n)) for n in np.ravel(each)) for name, each in (("x", x), ("v", v), ("p", points))}
    width = np.mean([np.linalg.norm(x[a] - x[b]) for a, b in {tuple(sorted(e)) for c in cells for e in itertools.combinations(c, 2)}])
    triangles = [cell[:3] for cell in cells[::2]]
    for mesh, kind, wide in (("MeshTopology", "tetrahedra", 0), ("TetrahedronSetTopologyContainer", "tetrahedra", width),
                             ("MeshTopology", "triangles", 0)):
        found = cells if kind == "tetrahedra" else triangles
        scene = node(EXACT + f'<{mesh} position="{text["x"]}" {kind}="{" ".join(str(n) for n in np.ravel(found))}"/>'
                     f'<MechanicalObject name="dofs" velocity="{text["v"]}"/><UniformMass totalMass="1"/><Node name="c"><MechanicalObject '
                     f'name="points" position="{text["p"]}"/><BarycentricMapping/></Node>')
        W = np.array([weights_by_centres(found, x, p, wide) for p in points])
        agree(Run(scene, 10).x("c.points"), W @ (x + 0.1 * v), 1e-9)
        differ(Run(scene, 10, args=["--without-quirk", "centre-cells"]).x("c.points"), W @ (x + 0.1 * v), 1e-3)
    grid = np.array([[i, j, k] for k in range(2) for j in range(2) for i in range(3)], float)
    W = np.zeros((len(points), 12))  # of the nearest cell of a grid, trilinear beyond it
    for row, p in zip(W, points):
        low = np.clip(np.floor(p).astype(int), 0, [1, 0, 0])
        for corner in itertools.product((0, 1), repeat=3):
            node_of = low + corner
            row[node_of[0] + 3 * (node_of[1] + 2 * node_of[2])] = np.prod([u if c else 1 - u for u, c in zip(p - low, corner)])
    scene = node(EXACT + f'<RegularGridTopology n="3 2 2" min="0 0 0" max="2 1 1"/><MechanicalObject name="dofs" velocity="{text["v"]}"/>'
                 f'<UniformMass totalMass="1"/><Node name="c"><MechanicalObject name="points" position="{text["p"]}"/>'
                 '<BarycentricMapping/></Node>')
    agree(Run(scene, 10).x("c.points"), W @ (grid + 0.1 * v), 1e-9)


def embedded(mesh, x, kind, cells, points, more=""):
    """Points in a body of which each node flies on its own way, and where the nodes of the body go."""
    v = np.random.default_rng(8).uniform(-3, 3, x.shape)
    text = [" ".join(repr(float(n)) for n in np.ravel(each)) for each in (x, v, points)]
    return (node(EXACT + f'<{mesh} position="{text[0]}" {kind}="{" ".join(str(n) for n in np.ravel(cells))}" {more}/><MechanicalObject '
                 f'name="dofs" velocity="{text[1]}"/><UniformMass totalMass="1"/><Node name="c"><MechanicalObject name="points" '
                 f'position="{text[2]}"/><BarycentricMapping/></Node>'), x + 0.1 * v)


@case
def centre_cells_that_are_flat_hold_nothing():
    """The nearest centre to the point is that of a cell without volume, exactly or but for round-off."""
    whole = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    for last in (1.0, 1.0 + 2 ** -52):
        x = np.array(whole + [[0.3, 0.3, 1], [0.6, 0.3, 1], [0.4, 0.6, 1], [0.5, 0.5, last]])
        for mesh in ("MeshTopology", "TetrahedronSetTopologyContainer"):
            scene, moved = embedded(mesh, x, "tetrahedra", [[0, 1, 2, 3], [4, 5, 6, 7]], [[0.45, 0.45, 1.2]])
            agree(Run(scene, 10).x("c.points"), [weights_by_centres([[0, 1, 2, 3]], x, np.array([0.45, 0.45, 1.2])) @ moved])
            Run(embedded(mesh, x, "tetrahedra", [[4, 5, 6, 7]], [[0.45, 0.45, 1.2]])[0], 1).fails(
                2, "no cell can hold point 0") if last == 1 else None
    x = np.array(whole[:3] + [[0.5, 0.5, 1], [0.6, 0.6, 1], [0.7, 0.7, 1]])
    scene, moved = embedded("MeshTopology", x, "triangles", [[0, 1, 2], [3, 4, 5]], [[0.6, 0.5, 0.9]])
    agree(Run(scene, 10).x("c.points"), [weights_by_centres([[0, 1, 2]], x, np.array([0.6, 0.5, 0.9])) @ moved])


@case
def centre_cells_of_graded_meshes():
    """One cell is 2,000 times as long as the edges that are given, which set the grid of the search: 10^9 of its cells; and far points."""
    random = np.random.default_rng(9)
    small = [np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]) * 0.01 + [0.0123 * i + 0.0017, -0.0213, 0.0031] for i in range(5)]
    x = np.vstack(small + [np.array([[0, 0, 0], [20, 0, 0], [0, 20, 0], [0, 0, 20]]) + 0.0047])
    cells = np.arange(len(x)).reshape(-1, 4)
    near = np.vstack([random.uniform(0, 0.01, (2, 3)) + each[0] for each in small] + [random.uniform(-2, 12, (10, 3))])
    for mesh, wide in (("MeshTopology", 0), ("TetrahedronSetTopologyContainer", 0.01)):
        for points in (near, np.array([[3e8, 1, 2], [-1, -4e15, 0]])):
            scene, moved = embedded(mesh, x, "tetrahedra", cells, points, 'edges="0 1 4 5 8 9"')
            agree(Run(scene, 10).x("c.points"), np.array([weights_by_centres(cells, x, p, wide) for p in points]) @ moved, 1e-9)


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
def quirk_no_centrifugal():
    """A frame with a mass on an arm, which turns and falls: J^T M J alone, so that its centre falls straight."""
    scene = root('<EulerImplicitSolver/>{}<MechanicalObject name="dofs" template="Rigid3" position="0 0 0 0 0 0 1" velocity="0 0 0 0 0 2"/>'
                 '<UniformMass vertexMass="0.5 1 0.1 0 0 0 0.1 0 0 0 0.1"/><Node name="c"><MechanicalObject position="1 0 0"/>'
                 '<UniformMass totalMass="2"/><RigidMapping/></Node>')
    x, v = np.array([0, 0, 0, 0, 0, 0, 1.0]), np.array([0, 0, 0, 0, 0, 2.0])
    for _ in range(50):
        arm = axes_of(x[3:]) @ np.array([1.0, 0, 0])
        J = np.hstack([np.eye(3), np.cross(np.eye(3), -arm)])
        M = np.diag([0.5] * 3 + [0.05] * 3) + 2 * J.T @ J
        v = v + np.linalg.solve(M, 0.01 * (np.array([0, -5, 0, 0, 0, 0]) + J.T @ np.array([0, -20, 0])))
        x = np.array([*(x[:3] + 0.01 * v[:3]), *product(turn_of(0.01 * v[3:]), x[3:])])
    for solver in ("<SparseLDLSolver/>", '<CGLinearSolver iterations="50" tolerance="1e-14" threshold="1e-30"/>'):
        agree(Run(scene.format(solver), 50).x(width=7)[0], x, 1e-8)
    differ(Run(scene.format("<SparseLDLSolver/>"), 50, args=["--without-quirk", "no-centrifugal"]).x(width=7)[0], x, 1e-2)


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
def quirk_whole_first_step():
    """v += h a from the first step on: of a fall as symplectic Euler; from the half step on the parabola exactly."""
    scene = root("<CentralDifferenceSolver/>" + BODY)
    agree(Run(scene, 10).x()[:, 1], [-10 * 0.01 ** 2 * 10 * 11 / 2] * 2)
    agree(Run(scene, 10, args=["--without-quirk", "whole-first-step"]).x()[:, 1], [-10 * 0.1 ** 2 / 2] * 2)
    damped = root('<CentralDifferenceSolver rayleighMass="3"/>' + BODY)
    y = v = 0.0
    for _ in range(10):
        v = ((1 / 0.01 - 1.5) * v - 10) / (1 / 0.01 + 1.5)
        y += 0.01 * v
    agree(Run(damped, 10).x()[:, 1], [y, y])


@case
def quirk_exact_borders():
    """Of a grid whose third layer is at 0.1 * 3 a box to 0.3 has two layers in SOFA, and so has a sphere or a load's box."""
    assert 0.1 * 3 > 0.3
    grid = '<RegularGridTopology n="11 2 2" min="0 0 0" max="1 0.1 0.1"/><MechanicalObject name="dofs"/><UniformMass totalMass="44"/>'
    native = ["--without-quirk", "exact-borders"]
    for region in ('<BoxROI name="r" box="-1 -1 -1 0.3 1 1"/>', '<PairBoxROI name="r" inclusiveBox="-1 -1 -1 0.3 1 1" includedBox="7 7 7 8 8 8"/>'):
        scene = node(EXACT + grid + region + '<ConstantForceField indices="@r.indices" forces="1 0 0"/>')
        for args, layers in (([], 3), (native, 4)):
            assert (Run(scene, 1, args=args).x()[:11, 0] - np.arange(11) / 10 > 1e-7).sum() == layers, (region, layers)
    ball = node(EXACT + '<MechanicalObject name="dofs" position="0 0 0  0.3 0 0"/><UniformMass totalMass="2"/><SphereROI name="r" '
                'centers="0 0 0" radii="0.29999999999999993"/><ConstantForceField indices="@r.indices" forces="0 1 0"/>')
    for args, pulled in (([], 1), (native, 2)):
        assert (Run(ball, 1, args=args).x()[:, 1] > 0).sum() == pulled
    load = '<SurfacePressureForceField pressure="1" min="0 0 0.1" max="0.3 0.1 0.1" useTangentStiffness="0"/>'
    for args, faces in (([], 2), (native, 3)):
        moved = Run(node(EXACT + grid + load), 1, args=args).x()[:, 2] - np.repeat([0, 0.1], 22)
        agree(moved.sum(), 1e-4 * faces * 0.01 * 2, 1e-6)  # of quads, and of the triangles of the grid


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
def joints_and_vectors_between_two_solvers():
    """As springs: the force of the start, equal and opposite, and no warning that the way is not SOFA's."""
    h, m, k = 0.01, np.array([[1.0], [3]]), 200

    def pulled(reach):
        x, v = np.array([[0.0, 0, 0], [1.2, 0, 0]]), np.array([[0.0, 0, 0], [0, 0.5, 0]])
        for _ in range(20):
            force = k * (x[1] - x[0] - reach)
            v = v + h * np.array([force, -force]) / m
            x = x + h * v
        return x

    pair = TWO.format("a", EXACT, "0 0 0", "0 0 0", 1) + TWO.format("b", EXACT, "1.2 0 0", "0 0.5 0", 3)
    run = Run(node(pair + '<VectorSpringForceField object1="@a/dofs" object2="@b/dofs" stiffness="200" viscosity="0" useTopology="0"/>'), 20)
    agree([run.x("a.dofs")[0], run.x("b.dofs")[0]], pulled(0))
    assert "isolated-springs': the result differs" not in run.text, run.text
    frames = [TWO.format(name, EXACT, place + " 0 0 0 1", speed + " 0 0 0", mass).replace("<MechanicalObject", '<MechanicalObject template="Rigid3"')
              for name, place, speed, mass in (("a", "0 0 0", "0 0 0", 1), ("b", "1.2 0 0", "0 0.5 0", 3))]
    joint = ('<JointSpringForceField object1="@a/dofs" object2="@b/dofs" spring="BEGIN_SPRING 0 0 FREE_AXIS 0 0 0 0 0 0 KS_T 0 200 KS_R 0 0 '
             'KS_B 0 REST_T 1 0 0 END_SPRING"/>')
    run = Run(node(frames[0] + frames[1] + joint), 20)
    assert "isolated-springs': the result differs" not in run.text, run.text
    total = run.x("a.dofs", 7)[0, :3] + 3 * run.x("b.dofs", 7)[0, :3]
    agree(total, [3.6, 3 * 0.5 * 0.2, 0], 1e-9)


@case
def wheels_turn_each_other():
    """A wheel that turns drives the other one backwards at twice the speed, with SOFA's words and order: pivots first."""
    frames = ('<MechanicalObject name="dofs" template="Rigid3d" position="0 0 0 0 0 0 1  2 0 0 0 0 0 1" velocity="0 0 0 0 0 1  0 0 0 0 0 -2"/>'
              '<UniformMass vertexMass="1 1 [0.1 0 0,0 0.1 0,0 0 0.1]"/>')
    gear = '<GearSpringForceField spring="BEGIN_SPRING 0 0 1 1 AXIS 2 2 KS_R 1e3 1e4 KD 0 RATIO 2 END_SPRING"/>'
    x = Run(node(EXACT + frames + gear), 50).x("dofs", 7)
    agree(x, [[0, 0, 0, 0, 0, np.sin(0.25), np.cos(0.25)], [2, 0, 0, 0, 0, -np.sin(0.5), np.cos(0.5)]], 1e-9)


@case
def numbers_that_stay_zero():
    """Older and newer names; the rod of a pendulum keeps its length."""
    points = ('<MechanicalObject name="dofs" position="0 0 0  1 0 0"/><UniformMass totalMass="2"/><FixedConstraint indices="0"/>'
              '<Node name="rod"><MeshTopology edges="0 1"/><MechanicalObject template="Vec1d"/><DistanceMapping/>'
              '<{} template="Vec1d" iterative="false"/></Node><GenericConstraintCorrection/>')
    for name in ("UniformConstraint", "UniformLagrangianConstraint"):
        x = Run(root('<FreeMotionAnimationLoop/><GenericConstraintSolver/>' + EXACT + points.format(name)), 60).x()
        agree(np.linalg.norm(x[1]), 1, 1e-9)
        assert x[1, 1] < -0.1, x


@case
def names_that_a_scene_gives():
    falls(Run(root('<MakeAliasComponent targetcomponent="UniformMass" alias="Weight"/><MakeDataAliasComponent '
                   'componentname="MechanicalObject" dataname="position" alias="places"/>' + EXACT
                   + '<MechanicalObject name="dofs" places="0 0 0  1 0 0"/><Weight totalMass="2"/>'), 10))


@case
def templates_of_graphics_cards():
    text = EXACT + BODY.replace('name="dofs"', 'name="dofs" template="CudaVec3f"').replace("UniformMass", 'UniformMass template="CudaVec3f1"')
    run = Run(root(text), 10)
    falls(run)
    run.says("Cuda in the template of MechanicalObject")
    frames = '<MechanicalObject name="dofs" template="CudaRigid3f" position="0 0 0 0 0 0 1"/><UniformMass template="StdRigidTypes"/>'
    agree(Run(root(EXACT + frames), 10).x("dofs", 7), [[0, fallen(10), 0, 0, 0, 0, 1]])


@case
def files_of_the_tree_of_a_scene():
    """share/ and examples/ of the tree that a scene lies in are searched, as SOFA does."""
    square = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
    text = root(EXACT + '<MeshOBJLoader name="l" filename="mesh/{}.obj"/><MechanicalObject name="dofs" src="@l"/><UniformMass totalMass="3"/>')
    files = {"tree/share/mesh/a.obj": square, "tree/examples/mesh/b.obj": square, "tree/other/mesh/c.obj": square}
    for name in "ab":
        agree(Run(text.format(name), 10, files, name="tree/examples/some/folder/scene.scn").x()[:, 1],
              np.add([0, 0, 1], fallen(10)))
    Run(text.format("c"), 1, files, name="tree/examples/some/folder/scene.scn").fails(2, "mesh/c.obj", "share")


@case
def springs_that_are_given_twice_in_part_or_not_at_all():
    pair = '<MechanicalObject name="dofs" position="0 0 0  1.5 0 0"/><UniformMass totalMass="2"/>'
    expected = Run(node(EXACT + pair + '<SpringForceField spring="0 1 300 0 1"/>'), 10).x()
    for other in ('<StiffSpringForceField stiffness="100" damping="7" spring="0 1 300 0 1"/>',
                  '<StiffSpringForceField spring="0 1 300 0 1  1 0 5"/>',
                  '<StiffSpringForceField indices1="0" indices2="1" length="1" stiffness="300" damping="0" fileSprings="" topology=""/>'):
        agree(Run(node(EXACT + pair + other), 10).x(), expected, 1e-12)
    three = '<MechanicalObject name="dofs" position="0 0 0  1.5 0 0  3 1 0"/><UniformMass totalMass="3"/>'
    lists = '<SpringForceField springsIndices1="0 1 0" springsIndices2="1 2 2" lengths="1" stiffness="{}" damping="0"/>'
    agree(Run(node(EXACT + three + lists.format("100 200")), 10).x(), Run(node(EXACT + three + lists.format("100 200 200")), 10).x(), 0)
    falls(Run(root(EXACT + BODY + '<StiffSpringForceField stiffness="100"/>'), 10))


@case
def parts_that_do_nothing():
    """What acts on no state, attaches no nodes, or never moves."""
    run = Run(root(EXACT + '<UniformMass totalMass="7"/><Node name="body">' + BODY + '<AttachConstraint/><LinearMovementConstraint '
                   'indices="0"/><UniformVelocityDampingForceField dampingCoefficient="0"/></Node>'), 10)
    falls(run, "body.dofs")
    run.says("has no state to act on", "names no nodes", "has no two times")
    falls(Run(root(f'<Node name="empty">{EXACT}</Node>' + EXACT.join(["<Node name='body'>", BODY + "</Node>"])), 10), "body.dofs")


@case
def damping_of_frames_and_numbers():
    """v *= 1 / (1 + h c / m) where it is implicit, of turns with the inertia."""
    frame = ('<MechanicalObject name="dofs" template="Rigid3d" position="0 0 0 0 0 0 1" velocity="1 0 0 0 0 2"/><UniformMass '
             'vertexMass="2 1 [0.1 0 0,0 0.1 0,0 0 0.1]"/><UniformVelocityDampingForceField template="Rigid3d" dampingCoefficient="3" implicit="1"/>')
    v, w, x, th = 1.0, 2.0, 0.0, 0.0
    for _ in range(20):
        v, w = v / (1 + 0.01 * 3 / 2), w / (1 + 0.01 * 3 / 0.2)
        x, th = x + 0.01 * v, th + 0.01 * w
    agree(Run(node(EXACT + frame), 20).x("dofs", 7), [[x, 0, 0, 0, 0, np.sin(th / 2), np.cos(th / 2)]])
    number = ('<MechanicalObject name="dofs" template="Vec1d" position="0" velocity="1"/><UniformMass totalMass="2"/>'
              '<UniformVelocityDampingForceField dampingCoefficient="3" implicit="1"/>')
    agree(Run(node(EXACT + number), 20).x("dofs", 1), [[x]])


@case
def damping_of_frames_along_axes():
    """Six coefficients for all frames, or six of each: v *= 1 / (1 + h c / m)."""
    frames = ('<MechanicalObject name="dofs" template="Rigid3d" position="0 0 0 0 0 0 1  0 0 0 0 0 0 1" velocity="1 1 0 0 0 2  1 1 0 0 0 2"/>'
              '<UniformMass vertexMass="2 1 [0.1 0 0,0 0.1 0,0 0 0.1]"/><DiagonalVelocityDampingForceField dampingCoefficient="{}"/>')

    def end(c, d, e):
        way = [sum(v / (1 + 0.01 * k / m) ** (n + 1) for n in range(20)) * 0.01 for v, k, m in ((1, c, 2), (1, d, 2), (2, e, 0.2))]
        return [way[0], way[1], 0, 0, 0, np.sin(way[2] / 2), np.cos(way[2] / 2)]
    agree(Run(node(EXACT + frames.format("3 0 0 0 0 1")), 20).x("dofs", 7), [end(3, 0, 1)] * 2)
    agree(Run(node(EXACT + frames.format("3 0 0 0 0 1  0 2 0 0 0 4")), 20).x("dofs", 7), [end(3, 0, 1), end(0, 2, 4)])
    Run(node(EXACT + frames.format("3 0 0")), 1).fails(2, "six numbers")
    # its name since 2025, with a number for all that counts, or a vector for each
    nodal = frames.replace("DiagonalVelocity", "NodalLinear").replace("dampingCoefficient=", "{}=")
    agree(Run(node(EXACT + nodal.format("dampingCoefficientVector", "3 0 0 0 0 1  0 2 0 0 0 4")), 20).x("dofs", 7), [end(3, 0, 1), end(0, 2, 4)])
    agree(Run(node(EXACT + nodal.format('dampingCoefficientVector="1 1 1 1 1 1" dampingCoefficient', "2")), 20).x("dofs", 7), [end(2, 2, 2)] * 2)
    agree(Run(node(EXACT + BODY.replace('1 0 0"', '1 0 0" velocity="0 3 0"') + '<NodalLinearDampingForceField dampingCoefficient="4"/>'), 1).x()[:, 1],
          [0.01 * 3 / (1 + 0.01 * 4)] * 2)


@case
def a_plane_holds_the_centres_of_frames():
    plane = '<UniformMass totalMass="2"/><PlaneForceField normal="0 1 0" d="0" stiffness="300" damping="2"/>'
    frame = Run(root(EXACT + '<MechanicalObject name="dofs" template="Rigid3" position="1 -0.1 0 0 0 0.6 0.8"/>' + plane), 10).x("dofs", 7)
    point = Run(root(EXACT + '<MechanicalObject name="dofs" position="1 -0.1 0"/>' + plane), 10).x()
    agree(frame, [[*point[0], 0, 0, 0.6, 0.8]])
    assert point[0, 1] > -0.1, point
    Run(root(EXACT + '<MechanicalObject template="Vec1" position="0"/>' + plane), 1).fails(2, "acts on points")


@case
def attributes_that_are_empty():
    """As a program saves them: an empty list is that of nobody's."""
    frames = ('<MechanicalObject name="dofs" template="Rigid3" position="0 0 0 0 0 0 1" externalForce="" derivX="" restScale="1"/>'
              '<UniformMass vertexMass="1 1 1 0 0 0 1 0 0 0 1" filename="unused" indices=""/><Node name="c"><MechanicalObject name="p" '
              'position="1 0 0"/><RigidMapping initialPoints="" rigidIndexPerPoint="" filename=""/><PlaneForceField normal="0 1 0" d="-99" '
              'indices=""/></Node>')
    agree(Run(root(EXACT + frames), 10).x("c.p"), [[1, fallen(10), 0]])


@case
def a_pressure_on_a_layer():
    """Triangles between dmin and dmax along an axis: those of the lid alone, a sixth of its force for each of their nodes."""
    box = ('<MeshTopology name="m" position="0 0 0 1 0 0 0 1 0  0 0 1 1 0 1 0 1 1" triangles="0 2 1  3 4 5"/><MechanicalObject name="dofs"/>'
           '<UniformMass totalMass="6"/>')
    run = Run(node(EXACT + box + '<TrianglePressureForceField normal="0 0 1" dmin="0.9" dmax="1.1" pressure="0 0 12"/>'), 10)
    agree(run.x()[:, 2], [0, 0, 0] + [1 + fallen(10, g=-2.0)] * 3)


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
def a_mapping_of_nothing_holds_its_nodes():
    child = ('<Node name="child"><MechanicalObject name="dofs" position="5 0 0"/><VoidMapping/><UniformMass totalMass="1"/>'
             '<ConstantForceField indices="0" forces="9 0 0"/></Node>')
    run = Run(root(EXACT + BODY + child), 10)
    falls(run)
    agree(run.x("child.dofs"), [[5, 0, 0]])


@case
def a_solver_that_damps_after_another():
    run = Run(root('<EulerImplicitSolver/><DampVelocitySolver rate="2"/><SparseLDLSolver/>' + BODY), 10)
    v = y = 0.0
    for _ in range(10):
        v -= 10 * 0.01
        y += v * 0.01
        v *= np.exp(-2 * 0.01)
    agree(run.x()[:, 1], [y, y])


def damped_steps(kind, steps, rate=2.0, threshold=0.0, h=0.01, g=-10.0):
    """Of a free fall with v *= exp(-rate h) after each step, and v = 0 where it is slow then."""
    y, v = 0.0, 0.0
    for _ in range(steps):
        before = v
        v += g * h
        y += h * {"RungeKutta4Solver": (before + v) / 2, "NewmarkImplicitSolver": (before + v) / 2, "explicit": before}.get(kind, v)
        v *= np.exp(-rate * h)
        if abs(v) < threshold:
            v = 0.0
    return [y, y]


@case
def a_solver_that_damps_after_others():
    for kind, more in (("EulerExplicitSolver", ""), ("EulerExplicitSolver", 'symplectic="0"'), ("RungeKutta4Solver", ""),
                       ("CentralDifferenceSolver", ""), ("NewmarkImplicitSolver", ""), ("EulerImplicitSolver", "")):
        for threshold in (0, 0.12):  # a step of the fall gives 0.1 m/s
            run = Run(root(f'<{kind} {more}/><DampVelocitySolver rate="2" threshold="{threshold}"/><SparseLDLSolver/>' + BODY), 10)
            agree(run.x()[:, 1] + 1, np.add(damped_steps("explicit" if more else kind, 10, threshold=threshold), 1))  # some stay at 0
    Run(root('<EulerImplicitSolver/><DampVelocitySolver/><SparseLDLSolver/>' + BODY), 1).says("is vdamping of")
    Run(root('<DampVelocitySolver/><EulerImplicitSolver/><SparseLDLSolver/>' + BODY), 1).says("the velocities that a step starts with")
    Run(root('<BDFOdeSolver/><DampVelocitySolver threshold="0.5"/><SparseLDLSolver/>' + BODY), 1).fails(2, "DampVelocitySolver")


@case
def slow_frames_stop_as_a_whole():
    frame = ('<MechanicalObject name="dofs" template="Rigid3" position="0 0 0 0 0 0 1" velocity="0.3 0 0 0 0.{} 0"/>'
             '<UniformMass totalMass="1"/>')
    for turn, moves in ((3, False), (5, True)):  # 0.3^2 + 0.3^2 < 0.5^2 < 0.3^2 + 0.5^2
        scene = f'<EulerExplicitSolver/><DampVelocitySolver rate="0" threshold="0.5"/>{frame.format(turn)}'
        agree(Run(node(scene), 3).x(width=7)[0, 0], 0.009 if moves else 0.003)


@case
def middles_of_hexahedra():
    grid = '<RegularGridTopology name="grid" n="3 2 2" min="0 0 0" max="2 1 1"/><MechanicalObject name="dofs"/><UniformMass totalMass="12"/>'
    child = ('<Node name="middles"><PointSetTopologyContainer name="cloud"/><CenterPointTopologicalMapping input="@../grid" '
             'output="@cloud"/><MechanicalObject name="seen"/><CenterPointMechanicalMapping/></Node>')
    agree(Run(root(EXACT + grid + child), 10).x("middles.seen"), [[0.5, 0.5 + fallen(10), 0.5], [1.5, 0.5 + fallen(10), 0.5]])


@case
def prefabs_that_the_scene_does_not_bring():
    """Of a node that is held and one that falls; and the damping of the integrator in CGImplicit."""
    run = Run(root(EXACT + BODY + '<BoxConstraint box="-0.1 -0.1 -0.1 0.1 0.1 0.1"/>'), 10)
    agree(run.x(), [[0, 0, 0], [1, fallen(10), 0]])
    run.says("is a prefab of SOFA")
    run = Run(root(EXACT + BODY + '<FixedBoxConstraint name="held" box="0.9 -0.1 -0.1 1.1 0.1 0.1"/>'), 10)
    agree(run.x(), [[0, fallen(10), 0], [1, 0, 0]])
    for mass, name in ((0.1, "CGImplicit"), (2, "CGImplicit"), (0.1, "CGImplicitSolver")):
        y = v = 0.0
        for _ in range(10):
            v = (v - 10 * 0.01) / (1 + mass * 0.01)
            y += v * 0.01
        given = "" if mass == 0.1 else f'rayleighMass="{mass}"'
        run = Run(root(f"<{name} {given}/>{BODY}"), 10)
        agree(run.x()[:, 1], [y, y], 1e-6)
    run = Run(root(f'<CGImplicit name="mine" foo="7" warmStart="true"/>{BODY}'), 10)
    run.says("/mine", "foo")
    assert "warmStart" not in run.text, run.text
    triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
    mesh = '<MeshLoader name="loader" filename="one.{}"/><MeshTopology src="@loader"/><MechanicalObject name="dofs"/><UniformMass totalMass="1"/>'
    falls(Run(root(EXACT + mesh.format("obj")), 10, {"one.obj": triangle}), start=[0, 0, 1])
    old = ("# vtk DataFile Version 2.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 3 float\n0 0 0 1 0 0 0 1 0\n"
           "CELLS 1 4\n3 0 1 2\nCELL_TYPES 1\n5\n")
    falls(Run(root(EXACT + mesh.format("vtk")), 10, {"one.vtk": old}), start=[0, 0, 1])


@case
def stress_of_elements_is_written():
    grid = ('<RegularGridTopology n="2 2 2" min="0 0 0" max="1 1 1"/><MechanicalObject name="dofs"/><UniformMass totalMass="1"/>'
            '<HexahedronFEMForceField name="fem" youngModulus="1000"/>')
    out = '<VTKExporter filename="out" cellsDataFields="fem.vonMisesPerElement" pointsDataFields="fem.vonMisesPerNode"/>'
    run = Run(root(EXACT + grid + out), 2)
    assert run.code == 0, run.text
    run.says("the stress of nodes")


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


@case
def labels_select():
    """[0 1] and [1 2] as lists of three nodes' labels, and pairs of labels that meet."""
    body = '<MechanicalObject name="dofs" position="0 0 0  1 0 0  2 0 0"/><UniformMass totalMass="3"/>'
    merged = '<MergeROIs name="m" nbROIs="2" indices1="4 7" indices2="2"/><MergeROIs name="n" nbROIs="3" indices1="1" indices2="2 1"/>'
    for engine, link, still in (('<SelectLabelROI template="unsigned int" name="e" labels="@m.roiIndices" selectLabels="2 9"/>', "indices", [1]),
                                ('<SelectLabelROI name="e" labels="@n.roiIndices" selectLabels="1"/>', "indices", [0, 1]),
                                ('<SelectConnectedLabelsROI name="e" nbLabels="2" labels1="[1] [2,5] []" labels2="[1] [5,1] [2]" '
                                 'connectLabels="1 2"/>', "indices", [1]),
                                ('<MapIndices name="e" in="7 1" indices="5 6 7"/>', "out", [1, 2]),
                                ('<MapIndices name="e" in="0 2" indices="2 1 1" transpose="1"/>', "outStr", [1, 2])):
        y = Run(root(EXACT + merged + engine + body + f'<FixedConstraint indices="@e.{link}"/>'), 10).x()[:, 1]
        agree(y, [0 if i in still else fallen(10) for i in range(3)])
    Run(root(EXACT + body + '<SelectLabelROI name="e" labels="1 2 3" selectLabels="1"/><FixedConstraint indices="@e.indices"/>'), 1).fails(
        2, "in brackets")
    Run(root(EXACT + body + '<MergeROIs nbROIs="1" indices1="3"/>'), 1).says("which nothing with an effect reads")


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
def points_joined_projected_and_shared_out():
    bare = '<MechanicalObject name="dofs" position="@../e.{}"/><UniformMass totalMass="1"/>'

    def made(engine, link):
        return Run(node(engine + f'<Node name="a">{EXACT}{bare.format(link)}</Node>'), 1).x("a.dofs")
    agree(made('<JoinPoints name="e" points="0 0 0  1 0 0  0.1 0 0  1.3 0 0  0.16 0 0" distance="0.2"/>', "mergedPoints"),
          [[0.26 / 3, 0, 0], [1, 0, 0], [1.3, 0, 0]])
    agree(made('<ProjectiveTransformEngine template="Vec3d" name="e" input_position="1 2 3  -1 0 2" focal_distance="2" '
               'proj_mat="1 0 0 1  0 2 0 0  0 0 1 -1"/>', "output_position"), [[2, 4, 2], [0, 0, 2]])
    split = ('<MeshSplittingEngine name="e" position="0 0 0  1 0 0  2 0 0  3 0 0  4 0 0" triangles="2 3 4" nbInputs="2" indices1="3" '
             'triangleIndices2="0"/>')
    agree(made(split, "position1"), [[3, 0, 0]])
    agree(made(split, "position2"), [[2, 0, 0], [4, 0, 0]])
    agree(made(split, "position3"), [[0, 0, 0], [1, 0, 0]])
    parts = "".join(f'<Node name="{name}">{EXACT}<MechanicalObject name="dofs" position="@../e.position{i + 1}"/><UniformMass '
                    f'totalMass="1"/>{"<FixedConstraint fixAll=%s1%s/>" % (chr(34), chr(34)) if i == 1 else ""}</Node>'
                    for i, name in enumerate("abc"))
    whole = '<Node name="all"><MechanicalObject name="dofs"/><SubsetMultiMapping input="@../a @../b @../c" output="@." indexPairs="@../e.indexPairs"/></Node>'
    x = Run(root(split + parts + whole), 10).x("all.dofs")
    agree(x, [[0, fallen(10), 0], [1, fallen(10), 0], [2, 0, 0], [3, fallen(10), 0], [4, 0, 0]])


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


@case
def a_force_of_the_first_step():
    """externalForce is forgotten after it, under implicit and explicit steps."""
    for solver in (EXACT, "<EulerExplicitSolver/>", "<CentralDifferenceSolver/>"):
        x = Run(node(solver + '<MechanicalObject name="dofs" position="0 0 0  1 0 0" externalForce="0 3 0  0 0 6"/><UniformMass totalMass="4"/>'),
                10).x()
        agree(x, [[0, 3 / 2 * 1e-4 * 10, 0], [1, 0, 6 / 2 * 1e-4 * 10]])
    Run(node('<RungeKutta4Solver/><MechanicalObject position="0 0 0" externalForce="0 3 0"/><UniformMass totalMass="4"/>'), 1).fails(
        2, "externalForce")


@case
def the_mass_of_all_frames_wins():
    """With both given the mass is the total's share, and the inertia stays per mass."""
    body = ('<MechanicalObject name="dofs" template="Rigid3" position="0 0 0 0 0 0 1  2 0 0 0 0 0 1"/><UniformMass totalMass="3" vertexMass="5 1 '
            '[0.5 0 0,0 0.5 0,0 0 0.25]"/><ConstantForceField indices="1" forces="6 0 0 0 0 3"/>')
    x = Run(node(EXACT + body), 10).x("dofs", 7)
    way, angle = 6 / 1.5 * 55e-4, 3 / (1.5 * 0.25) * 55e-4
    agree(x, [[0, 0, 0, 0, 0, 0, 1], [2 + way, 0, 0, 0, 0, np.sin(angle / 2), np.cos(angle / 2)]])


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


def led(place, speed, steps, k=100.0, h=0.01, first=0.0, last=np.inf):
    """Node 0 of a spring of length 1 is put to place(t) of each step's start t, and meanwhile counts with the velocity of that start."""
    x, v = np.array([0.0, 1.0]), np.zeros(2)
    start = x[0]
    if first <= 0:
        x[0], v[0] = start + place(0), speed(0)
    for n in range(steps):
        t, on = n * h, first <= n * h + 1e-12 < last
        force = k * (x[1] - x[0] - 1 + h * (v[1] - v[0]))
        A = (np.eye(2) + h * h * k * np.array([[1, -1], [-1, 1]]))
        b = h * np.array([force, -force])
        if on:
            b[0], A[0], A[:, 0] = 0, [1, 0], [1, 0]
        v = v + np.linalg.solve(A, b)
        x = x + h * v
        if on:
            x[0], v[0] = start + place(t), speed(t)
    return x


@case
def moved_nodes_have_the_velocity_of_a_steps_start():
    """Their neighbours feel it, from the first step on: SOFA projects positions and velocities before it."""
    body = ('<MechanicalObject name="dofs" position="0 0 0  1 0 0"/><UniformMass totalMass="2"/><SpringForceField spring="0 1 100 0 1"/>')

    def x(constraint, steps=10):
        return Run(node(EXACT + body + constraint), steps, args=["--without-quirk", "unheld-matrix"]).x()[:, 0]
    ramp = '<LinearMovementConstraint indices="0" keyTimes="{}" movements="0 0 0  0.1 0 0  0.1 0 0"/>'
    agree(x(ramp.format("0 0.05 1")), led(lambda t: min(0.1, 2 * t), lambda t: 2.0 if t < 0.05 - 1e-9 else 0.0, 10))
    agree(x(ramp.format("0.03 0.08 1")), led(lambda t: min(0.1, 2 * (t - 0.03)), lambda t: 2.0 if t < 0.08 - 1e-9 else 0.0, 10, first=0.03))
    agree(x(ramp.replace("0 0 0  0.1", "0.05 0 0  0.1").format("0 0.05 1")),  # elsewhere from before the first step on
          led(lambda t: min(0.1, 0.05 + t), lambda t: 1.0 if t < 0.05 - 1e-9 else 0.0, 10))
    agree(x(ramp.format("0 0.05 0.07")), led(lambda t: min(0.1, 2 * t), lambda t: 2.0 if t < 0.05 - 1e-9 else 0.0, 10, last=0.07))
    agree(x('<OscillatorConstraint oscillators="0  0 0 0  0.1 0 0  20 0"/>'),
          led(lambda t: 0.1 * np.sin(20 * t), lambda t: 2 * np.cos(20 * t), 10))
    agree(x('<OscillatorConstraint oscillators="0  0 0 0  0.1 0 0  20 0.5"/>'),
          led(lambda t: 0.1 * np.sin(20 * t + 0.5), lambda t: 2 * np.cos(20 * t + 0.5), 10))
    turn = ('<AffineMovementConstraint meshIndices="0 1" indices="0" translation="0.5 0 0" rotation="1 0 0 0 1 0 0 0 1" '
            'beginConstraintTime="0" endConstraintTime="0.2"/>')
    agree(x(turn), led(lambda t: 2.5 * t, lambda t: 0.0, 10))

    def hermite(t):
        u = 5 * t
        w = u * u * (3 - 2 * u)
        return 0.3 * w * w * (3 - 2 * w), 0.3 * 6 * w * (1 - w)  # by w, not by time
    curve = ('<HermiteSplineConstraint indices="0" BeginTime="0" EndTime="0.2" X0="0 0 0" dX0="0 0 0" X1="0.3 0 0" dX1="0 0 0" SX0="0 0" '
             'SX1="0 0"/>')
    agree(x(curve), led(lambda t: hermite(t)[0], lambda t: hermite(t)[1], 10))
    elsewhere = curve.replace(' X0="0 0 0"', ' X0="0.05 0 0"').replace('X1="0.3', 'X1="0.35')  # from before the first step on
    agree(x(elsewhere), led(lambda t: 0.05 + hermite(t)[0], lambda t: hermite(t)[1], 10))
    arc = '<ParabolicConstraint indices="0" P1="0 0 0" P2="0.1 0.2 0" P3="0.4 0 0" BeginTime="0" EndTime="0.2"/>'
    fallen_off = Run(node(EXACT + body.replace('<SpringForceField spring="0 1 100 0 1"/>', "") + arc), 23).x()[0]

    def on_arc(t):
        s = 2 * t
        return np.array([s, 0.2 * s * (0.4 - s) / (0.1 * 0.3), 0])
    agree(fallen_off, on_arc(0.2) + 0.02 * (on_arc(0.21) - on_arc(0.2)) / 0.01)  # on along the chord of a step that is not made
    free = '<MechanicalObject name="dofs" position="0 0 0"/><UniformMass totalMass="2"/>'
    slide = '<PartialLinearMovementConstraint indices="0" keyTimes="0 1" movements="0 0 0  0 1 0.5" movedDirections="0 1 0"/>'
    agree(Run(root(EXACT + free + slide, 'gravity="3 0 0"'), 10).x(), [[10 * 3e-4, 0.09, 10 * 0.005]])


@case
def what_no_integrator_moves_goes_where_constraints_put_it():
    """SOFA ends a step by projecting the positions of all states, those without a solver too. Without a solver nothing goes on."""
    state = '<MechanicalObject name="dofs" position="0 0 0  5 0 0"/>'
    falling = f'<Node name="body">{EXACT}<MechanicalObject name="body" position="0 0 0"/><UniformMass totalMass="1"/></Node>'
    ramp = '<LinearMovementConstraint indices="0" keyTimes="0 0.1 0.2" movements="0 0 0  1 0 0  1 2 0"/>'

    def x(content, steps, more=falling):
        run = Run(root(f'{more}<Node name="tool">{state}{content}</Node>'), steps)
        run.says("no integrator moves it: it is held where it is, or where the scene puts it")
        assert "warning" not in run.text, run.text
        return run.x("tool.dofs")
    rest = [5, 0, 0]
    for more in (falling, ""):  # with a body that moves, and where nothing else does
        agree(x(ramp, 8, more), [[0.7, 0, 0], rest])
        agree(x(ramp, 16, more), [[1, 1, 0], rest])
    agree(x(ramp, 30), [[1, 1.8, 0], rest])  # the last step that moves it starts at 0.19
    agree(x('<UniformMass totalMass="1"/>' + ramp, 16), [[1, 1, 0], rest])  # without falling
    part = '<PartialLinearMovementConstraint indices="0" keyTimes="0 0.1" movements="0 0 0  1 1 0" movedDirections="0 1 0"/>'
    agree(x(part, 6), [[0, 0.5, 0], rest])
    agree(x(part, 30), [[0, 0.9, 0], rest])
    agree(x('<OscillatorConstraint oscillators="0  1 2 3  0 1 0  20 0.5"/>', 9), [[1, 2 + np.sin(20 * 0.08 + 0.5), 3], rest])
    flow = '<LinearVelocityConstraint indices="0" keyTimes="0 0.1" velocities="1 0 0  3 0 0"/>'
    places = [0.01] + [0.01 * (1 + 20 * 0.01 * n) for n in range(10)]  # one before the first step
    agree(x(flow, 5), [[sum(places[:6]), 0, 0], rest])
    agree(x(flow, 20), [[sum(places), 0, 0], rest])
    turn = '<AffineMovementConstraint {}translation="0.5 0 0" rotation="1 0 0 0 1 0 0 0 1" beginConstraintTime="0" endConstraintTime="0.1"/>'
    agree(x(turn.format('indices="0" meshIndices="0 1" '), 30), [[0.5, 0, 0], rest])
    frame_of = Run(root('<Node name="tool"><MechanicalObject name="dofs" template="Rigid3" position="0 0 0 0 0 0 1"/><LinearMovementConstraint '
                        'template="Rigid3" indices="0" keyTimes="0 1" movements="0 0 0 0 0 0  1 0 0 0 0 2"/><Node name="other"><MechanicalObject '
                        'name="other" position="7 0 0"/><UniformMass totalMass="1"/></Node></Node>'), 26)
    agree(frame_of.x("tool.dofs", 7), [[0.25, 0, 0, 0, 0, np.sin(0.25), np.cos(0.25)]])
    agree(frame_of.x("tool.other.other"), [[7, 0, 0]])  # below it, and moved by nothing
    named = Run(root(f'{falling}<Node name="tool">{state}</Node>' + ramp.replace(" indices", ' mstate="@tool/dofs" indices')), 8)
    agree(named.x("tool.dofs"), [[0.7, 0, 0], rest])
    agree(named.x("body.body"), [[0, fallen(8), 0]])


@case
def states_of_files_need_no_integrator():
    """A recorded motion of what others touch or hang on; after its end it stays where it is."""
    file = "".join(f"T= {0.01 * n}\n  X= {n * n} 0 0 {n} 1 0\n  V= {2 * n} 0 0 1 0 0\n" for n in range(11))
    scene = node('<Node name="tool"><MechanicalObject name="dofs" position="0 0 0  0 1 0"/><ReadState filename="tool.state"/></Node>')
    for steps, n in ((4, 4), (10, 10), (25, 10)):
        run = Run(scene, steps, {"tool.state": file})
        agree(run.x("tool.dofs"), [[n * n, 0, 0], [n, 1, 0]])
        assert "warning" not in run.text, run.text


@case
def floors_and_anchors_without_an_integrator_carry_others_along():
    contacts = ('<FreeMotionAnimationLoop/><GenericConstraintSolver tolerance="1e-9" maxIterations="1000"/><CollisionPipeline/>'
                '<BruteForceBroadPhase/><BVHNarrowPhase/><LocalMinDistance alarmDistance="0.1" contactDistance="0.02"/>'
                '<CollisionResponse response="FrictionContactConstraint" responseParams="mu=0.1"/>')
    rising = '<LinearMovementConstraint indices="0 1 2 3" keyTimes="0 1 2" movements="0 0 0  0 0.3 0  0 0.3 0"/>'
    floor = ('<Node name="floor"><MeshTopology position="-1 0 -1  1 0 -1  1 0 1  -1 0 1" triangles="0 2 1  0 3 2"/><MechanicalObject '
             f'name="floor"/>{rising}<TriangleCollisionModel/><LineCollisionModel/><PointCollisionModel/></Node>')
    ball = (f'<Node name="ball">{EXACT}<MechanicalObject template="Rigid3" name="dofs" position="0.2 0.12 0.1 0 0 0 1"/>'
            '<UniformMass totalMass="1"/><SphereCollisionModel radius="0.1"/><UncoupledConstraintCorrection/></Node>')
    run = Run(root(contacts + floor + ball), 150)
    agree(run.x("floor.floor")[:, 1], np.full(4, 0.3))
    agree(run.x("ball.dofs", 7)[0, :3], [0.2, 0.3 + 0.1 + 0.02, 0.1], 1e-6)
    pushed = contacts.replace("FrictionContactConstraint", "PenalityContactForceField").replace("FreeMotionAnimationLoop", "DefaultAnimationLoop")
    light = ('<Node name="ball">{}<MechanicalObject name="dofs" position="0.2 0.12 0.1"/><UniformMass totalMass="0.1"/><SphereCollisionModel '
             'radius="0.1" contactStiffness="5"/></Node>')
    for solver in ("<EulerExplicitSolver/>", "<RungeKutta4Solver/>"):  # of the body: it goes on with its own
        run = Run(root(pushed + floor + light.format(solver)), 40)
        assert "not alike" not in run.text and "warning" not in run.text, run.text
        by_hand = Run(root(pushed + floor.replace("<MeshTopology", solver + '<UniformMass totalMass="1"/><MeshTopology') + light.format(solver)), 40)
        agree(run.x("ball.dofs"), by_hand.x("ball.dofs"))
    moving = '<LinearMovementConstraint indices="0" keyTimes="0 1 2" movements="0 0 0  1 0 0  1 0 0"/>'
    k, m, h = 1000.0, 0.01, 0.01
    anchor = f'<Node name="a"><MechanicalObject name="anchor" position="5 0 0"/>{moving}</Node>'
    body = (f'<Node name="b">{EXACT}<MechanicalObject name="dofs" position="5 0 0"/><UniformMass totalMass="{m}"/><RestShapeSpringsForceField '
            f'points="0" stiffness="{k}" external_rest_shape="@../a/anchor" external_points="0"/></Node>')
    run = Run(node(body + anchor), 50)
    x, v, at = 0.0, 0.0, 0.0
    for n in range(50):  # the anchor is where it was when the step began
        v = (m * v + h * k * (at - x)) / (m + h * h * k)
        x, at = x + h * v, n * h
    agree(run.x("b.dofs"), [[5 + x, 0, 0]])
    agree(run.x("a.anchor"), [[5.49, 0, 0]])


@case
def nodes_whose_velocity_is_given_go_on_with_that_of_a_steps_start():
    """Where they are is a sum over the steps, whatever kinks their velocity has, and their neighbours feel that of the step before."""
    body = ('<MechanicalObject name="dofs" position="0 0 0  1 0 0"/><UniformMass totalMass="2"/><SpringForceField spring="0 1 100 0 1"/>')

    def check(times, values, steps=17, more="", last=None, runs_on=False):
        first, last = times[0], times[-1] if last is None else last

        def speed(t):
            line = np.polyfit(times[-2:], values[-2:], 1)
            return np.polyval(line, t) if runs_on and t > times[-1] else np.interp(t, times, values)
        places = [0.01 * speed(0) if first <= 0 else 0.0]
        for n in range(steps):
            places.append(places[-1] + (0.01 * speed(0.01 * n) if first <= 0.01 * n + 1e-12 < last else 0))
        place = iter(places[first > 0:])
        flow = (f'<LinearVelocityProjectiveConstraint indices="0" keyTimes="{" ".join(map(str, times))}" '
                f'velocities="{"  ".join(f"{value} 0 0" for value in values)}" {more}/>')
        if first > 0:
            place = iter(places[1 + round(first / 0.01):])
        agree(Run(node(EXACT + body + flow), steps).x()[:, 0], led(lambda t: next(place), speed, steps, first=first, last=last))
    check([0, 0.05, 0.1, 0.3], [1, 3, -1, 2])
    check([0, 0.05, 0.1, 0.13], [1, 3, -1, 2])
    check([0.03, 0.05, 0.1, 0.13], [1, 3, -1, 2])
    check([0, 0.05, 0.1], [1, 3, 3], more='continueAfterEnd="1"', last=np.inf)
    check([0, 0.05, 0.1], [1, 3, 3], more='continueAfterEnd="0"')
    check([0, 0.05, 0.0825], [1, 3, -1], more='continueAfterEnd="1"', last=np.inf, runs_on=True)  # along the line of the last two
    check([0, 0.02, 0.06], [1, 3, -1], more='continueAfterEnd="1"', last=np.inf, runs_on=sum([0.01] * 6) != 0.06)
    check([0, 0.02, 0.03], [1, 3, -1], more='continueAfterEnd="1"', last=np.inf)  # a step begins there


@case
def nodes_that_are_driven_along_some_axes():
    """Along the others nothing pulls at them, and the first velocity counts before the first step too."""
    free = '<MechanicalObject name="dofs" position="0 0 0" velocity="0 0 2"/><UniformMass totalMass="2"/>'
    flow = '<LinearVelocityConstraint indices="0" keyTimes="0 0.06" velocities="1 0 0  1 0 0" {}/>'
    agree(Run(root(EXACT + free + flow.format('coordinates="0"')), 5).x(), [[0.06, 0, 0.1]], 1e-7)
    y, v = 0.0, 0.0
    for step in range(8):  # free from 0.06 s on
        v -= 0.1 if step >= 6 else 0
        y += 0.01 * v
    agree(Run(root(EXACT + free + flow.format('coordinates="0"')), 8).x(), [[0.09, y, 0.16]], 1e-7)
    agree(Run(root(EXACT + free + flow.format("")), 5).x(), [[0.06, 0, 0]], 1e-7)


@case
def what_was_ahead_stays_so_when_the_mesh_changes():
    """A cell goes on the other side: the driven nodes have other numbers, and are where they were to be."""
    points = [(x, y, z) for y in (0, 1) for z in (0, 1) for x in range(4)]
    number = {p: i for i, p in enumerate(points)}
    cells = [[number[x + a, b, c] for a, b, c in ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))]
             for x in range(3)]
    text = [" ".join(str(v) for row in rows for v in row) for rows in (points, cells)]
    scene = node(EXACT + f'<HexahedronSetTopologyContainer position="{text[0]}" hexahedra="{text[1]}"/><MechanicalObject name="dofs"/>'
                 '<DiagonalMass massDensity="1000"/><HexahedronFEMForceField youngModulus="3000" poissonRatio="0.4" method="large"/>'
                 '<LinearVelocityConstraint indices="3 7 11 15" keyTimes="0 1" velocities="1 0 0  1 0 0"/>'
                 '<TopologicalChangeProcessor useDataInputs="1" timeToRemove="0.025" hexahedraToRemove="0"/>')
    x = Run(scene, 6).x()
    assert len(x) == 12, x
    agree(sorted(x[:, 0])[-4:], [3.07] * 4, 1e-7)


@case
def quirk_unturned_springs():
    """A frame that is turned by 1.2 about z and spins about x: the tangent of its torque is -a I."""
    q = np.array([0, 0, np.sin(0.6), np.cos(0.6)])
    scene = node(EXACT + f'<MechanicalObject name="dofs" template="Rigid3d" position="0 0 0 0 0 {q[2]:.17g} {q[3]:.17g}" rest_position="0 0 0 '
                 '0 0 0 1" velocity="0 0 0 2 0 0"/><UniformMass vertexMass="1 1 [0.5 0 0,0 0.5 0,0 0 0.5]"/><RestShapeSpringsForceField '
                 'points="0" external_points="0" stiffness="10" angularStiffness="50"/>')
    w = np.array([2.0, 0, 0])
    for _ in range(10):
        w = w + 0.01 * (-50 * rotation_vector(q) - 0.01 * 50 * w) / (0.5 + 1e-4 * 50)
        q = product(turn_of(0.01 * w), q)
    end = np.append([0, 0, 0], q)
    agree(Run(scene, 10).x(width=7), [end])
    differ(Run(scene, 10, args=["--without-quirk", "unturned-springs"]).x(width=7), [end], 1e-5)


@case
def points_of_no_other_body():
    """external_points without external_rest_shape: only their number counts."""
    body = ('<MechanicalObject name="dofs" position="0 0 0  1 0 0  2 0 0"/><UniformMass totalMass="3"/><RestShapeSpringsForceField '
            'points="0 1" {} stiffness="40"/>')
    plain = Run(root(EXACT + body.format("")), 10).x()
    agree(Run(root(EXACT + body.format('external_points="2 0"')), 10).x(), plain, 1e-14)
    other = Run(root(EXACT + body.format('external_points="2"')), 10)
    falls(other)
    other.says("are not as many as points")
    for position in ('position="0 0 0  1 0 0  2 0 0"', 'position="@grid.position"'):
        grid = '<RegularGridTopology name="grid" n="3 1 1" min="0 0 0" max="2 0 0"/>' if "@" in position else ""
        outside = Run(root(EXACT + grid + body.format('external_points="2 3"').replace('position="0 0 0  1 0 0  2 0 0"', position)), 10)
        falls(outside)
        outside.says("node 3", "which has 3 nodes: the springs do nothing")


# ---- contacts by pairs, contents of surfaces ----

@case
def contacts_that_rules_answer():
    """Points on a floor: the first rule that fits says with how much friction they slide, and a model's own response goes before."""
    floor = ('<Node name="floor"><MeshTopology position="-9 0 -9  9 0 -9  9 0 9  -9 0 9" triangles="0 2 1  0 3 2"/><MechanicalObject/>'
             '<TriangleCollisionModel name="ground" group="7" moving="0" simulated="0"/></Node>')
    model = {"slow": 'group="1"', "fast": 'group="1 2"', "soft": 'group="1" contactResponse="PenalityContactForceField" contactStiffness="20"'}
    balls = "".join(f'<Node name="{name}"><EulerImplicitSolver/><SparseLDLSolver/><MechanicalObject name="dofs" position="0 0.1 {i}" '
                    'velocity="1 0 0"/><UniformMass totalMass="1"/><UncoupledConstraintCorrection/>'
                    f'<PointCollisionModel name="{name}" {more}/></Node>' for i, (name, more) in enumerate(model.items()))

    def scene(solver, rules):
        return root(f'<FreeMotionAnimationLoop/>{solver}<CollisionPipeline/><BruteForceBroadPhase/><BVHNarrowPhase/><LocalMinDistance '
                    'alarmDistance="0.3" contactDistance="0.1"/><RuleBasedContactManager responseParams="mu=0.9" response='
                    f'"FrictionContactConstraint" {rules}/>' + floor + balls)
    rules = ('variables="law" law="FrictionContactConstraint?mu=0.7" rules="slow ground AugmentedLagrangianResponseConstraint?mu=0.2&amp;'
             'epsilon=3  2 7 $law$  * * FrictionContactConstraint?mu=0.5"')
    many = '<GenericConstraintSolver maxIterations="1000" tolerance="1e-9"/>'
    run = Run(scene(many, rules), 8)
    y, v, k = 0.1, 0.0, 20 * 10 / 0.1
    for _ in range(8):
        pen = 0.1 - y
        v += 0.01 * (-10 + (k * pen - 0.01 * k * v if pen > 0 else 0)) / (1 + (1e-4 * k if pen > 0 else 0))
        y += 0.01 * v
    slid = {mu: sum(0.01 * (1 - mu * 10 * 0.01 * (i + 1)) for i in range(8)) for mu in (0.2, 0.6, 0.7)}
    agree(run.x("slow.dofs")[0], [slid[0.2], 0.1, 0], 1e-5)
    agree(run.x("fast.dofs")[0], [slid[0.7], 0.1, 1], 1e-5)
    agree(run.x("soft.dofs")[0], [0.08, y, 2], 1e-5)
    run.says("comes near the forces of constraint")
    run = Run(scene('<LCPConstraintSolver tolerance="1e-9" maxIt="1000"/>', rules), 8)
    agree(run.x("fast.dofs")[0], [slid[0.6], 0.1, 1], 1e-5)
    Run(scene(many, 'rules="slow ground"'), 1).says("the last rule lacks some")


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


CUBE_PLACES = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]


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
def grids_in_several_surfaces():
    """Files are surfaces, in their order; a field that is a mass too has the factors of the mass (closed forms: tests/topology)."""
    box = [(0, 2, 1), (0, 3, 2), (4, 5, 6), (4, 6, 7), (0, 1, 5), (0, 5, 4), (1, 2, 6), (1, 6, 5), (2, 3, 7), (2, 7, 6), (3, 0, 4),
           (3, 4, 7)]

    def corners(low, high):
        return [[high if c[0] else low, 0.5 + 2 * c[1], 0.5 + 2 * c[2]] for c in CUBE_PLACES]

    def file(low, high):
        return ("".join("v {} {} {}\n".format(*p) for p in corners(low, high)) +
                "".join("f {} {} {}\n".format(*(i + 1 for i in face)) for face in box))
    files = {"one.obj": file(0.5, 5.5), "two.obj": file(2.5, 7.5)}
    grid = '<SparseGridMultipleTopology name="grid" n="9 4 4" min="0 0 0" max="8 3 3" stiffnessCoefs="2 8" massCoefs="1 3" %s/>'
    body = '<MechanicalObject name="dofs"/>%s<HexahedronFEMForceField%s method="large" youngModulus="1000" poissonRatio="0.3" %s/>'
    hold = '<FixedProjectiveConstraint indices="0"/>'
    solver = '<EulerImplicitSolver %s/><SparseLDLSolver/>'
    foreign = Run(root(solver % "" + grid % 'fileTopologies="one.obj two.obj"' + body % ("", "AndMass", 'density="2"') + hold), 5, files)
    surfaces = " ".join(f'position{i}="{" ".join(str(v) for p in corners(*ends) for v in p)}" triangles{i}="'
                        f'{" ".join(str(node) for face in box for node in face)}"' for i, ends in ((1, (0.5, 5.5)), (2, (2.5, 7.5))))
    mass = '<MeshMatrixMass massDensity="2" matrix="pairs" computeMassOnRest="true" cellFactors="@grid.massFactors"/>'
    native = Run.of_native(root(solver % 'newtonIterations="1"' + grid % surfaces + body % (
        mass, "", 'localStiffnessFactor="@grid.cellFactors" dilatation="local"') + hold), 5)
    agree(foreign.x(), native.x(), 1e-12)
    Run(root(grid % 'fileTopologies="one.ply"'), 1).fails(2, "there is no loader for 'one.ply'")


@case
def lattices_in_a_surface():
    """Corners and middles of cubes, of the tetrahedra with a node inside of an octahedron, in the order of the lattice."""
    r, cubes = 1.0, 5
    corners = [r * s * np.eye(3)[a] for a in range(3) for s in (1, -1)]
    faces = [(2 * 0 + i, 2 * 1 + j, 2 * 2 + k) if (i + j + k) % 2 == 0 else (2 * 0 + i, 2 * 2 + k, 2 * 1 + j)
             for i in (0, 1) for j in (0, 1) for k in (0, 1)]
    size = 2.04 * r / cubes
    half = int(1.02 * r / size) + 2

    def place(q):
        return np.array(q) * size / 2

    def is_inside(q):
        return np.abs(place(q)).sum() < r
    used = set()
    evens = range(-2 * half, 2 * half + 1, 2)
    for p in itertools.product(evens, evens, evens):
        for axis in range(3):
            q = tuple(c - 2 * (i == axis) for i, c in enumerate(p))
            across = [i for i in range(3) if i != axis]
            ring = []
            for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
                m = list(p)
                m[axis] -= 1
                m[across[0]] += a
                m[across[1]] += b
                ring.append(tuple(m))
            for m, n in zip(ring, ring[1:] + ring[:1]):
                if any(map(is_inside, (p, q, m, n))):
                    used |= {p, q, m, n}
    nodes = sorted(used, key=lambda q: (q[0] % 2, q[2], q[1], q[0]))
    expected = np.array([place(q) for q in nodes])
    expected[:, 1] += fallen(4)
    surface = (f'inputPoints="{" ".join(str(c) for p in corners for c in p)}" '
               f'inputTriangles="{" ".join(str(n) for face in faces for n in face)}"')
    body = ('<Node name="body"><EulerImplicitSolver/><SparseLDLSolver/><TetrahedronSetTopologyContainer position="@../e.outputPoints" '
            'tetrahedra="@../e.outputTetras"/><MechanicalObject name="dofs"/><UniformMass totalMass="1"/><TetrahedronFEMForceField '
            'method="svd" youngModulus="1000" poissonRatio="0.3"/></Node>')
    agree(Run(root(f'<MeshTetraStuffing name="e" size="-{cubes}" {surface} draw="1"/>' + body), 4).x("body.dofs"), expected, 1e-7)
    run = Run(root(f'<MeshTetraStuffing name="e" size="-{cubes}" {surface} snapPoints="1" splitTetras="1"/>' + body), 4)
    x = run.x("body.dofs") - [0, fallen(4), 0]
    distances = np.abs(x).sum(axis=1)
    assert (distances < r + 1e-6).all() and (abs(distances - r) < 1e-6).sum() > 50, distances
    run.says("along other diagonals than SOFA")


@case
def a_node_that_no_solver_moves_holds_by_constraints():
    free = '<FreeMotionAnimationLoop/><GenericConstraintSolver tolerance="1e-12" maxIterations="1000"/>'
    still = ('<Node name="still"><MechanicalObject name="dofs" position="-1 1 0  2 1 0" free_position="-1 1 0  2 1 0"/>'
             '<UncoupledConstraintCorrection/></Node>')
    body = (f'<Node name="body">{EXACT}<MechanicalObject name="dofs" position="0 1 0  5 0 0"/><UniformMass totalMass="2"/>'
            '<UncoupledConstraintCorrection/></Node>')
    gravity_of = 'gravity="3 -10 0"'
    slide = '<SlidingLagrangianConstraint object1="@body/dofs" object2="@still/dofs" sliding_point="0" axis_1="0" axis_2="1"/>'
    run = Run(root(free + still + body + slide, gravity_of), 10)
    agree(run.x("body.dofs"), [[-fallen(10, g=3), 1, 0], [5 - fallen(10, g=3), fallen(10), 0]])
    agree(run.x("still.dofs"), [[-1, 1, 0], [2, 1, 0]])
    hold = '<BilateralInteractionConstraint object1="@still/dofs" object2="@body/dofs" first_point="1" second_point="1"/>'
    run = Run(root(free + still + body + hold, gravity_of), 10)
    agree(run.x("body.dofs"), [[-fallen(10, g=3), 1 + fallen(10), 0], [2, 1, 0]])


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
def springs_between_frames():
    """A frame whose point is drawn to one of a frame that is held, and one that turns back: oscillators, each step in closed form."""
    def scene(start, words):
        return node(EXACT + f'<MechanicalObject name="dofs" template="Rigid3" position="0 0 0 0 0 0 1  {start}"/><UniformMass '
                    'vertexMass="2 1 [0.5 0 0 0 0.5 0 0 0 0.5]"/><FixedConstraint indices="0"/><FrameSpringForceField spring="BEGIN_SPRING '
                    f'0 1 {words} END_SPRING"/>')

    def oscillated(way, k, m, c=0.0, h=0.01):
        v = 0.0
        for _ in range(20):
            v += h * (-k * way - c * v - h * k * v) / (m + h * c + h * h * k)
            way += h * v
        return way
    run = Run(scene("1.5 0.2 0 0 0 0 1", "KS_T 300 KD 3 VEC1 0.75 0 0"), 20)
    agree(run.x(width=7)[1, :3], [0.75 + oscillated(0.75, 300, 2, 3), oscillated(0.2, 300, 2, 3), 0], 1e-9)
    turn = 0.4
    run = Run(scene(f"0 0 0 {np.sin(turn / 2)} 0 0 {np.cos(turn / 2)}", "KS_R 40"), 20)
    half = oscillated(turn, 40, 2 * 0.5) / 2
    agree(run.x(width=7)[1], [0, 0, 0, np.sin(half), 0, 0, np.cos(half)], 1e-7)
    run.says("SOFA's torques stay in fixed axes")


CHAIN = np.array([[0, 0, 0], [1, 0, 0], [2, 0.3, 0], [2.5, 1, 0.2]])
CHAIN_NODES = '<MechanicalObject name="dofs" position="' + " ".join(str(c) for p in CHAIN for c in p) + '"/><UniformMass totalMass="4"/>'
LINKS = [(0, 1), (1, 2), (2, 3)]


@case
def quirk_predicted_start():
    body = (CHAIN_NODES + '<MeshTopology edges="0 1  1 2  2 3"/><MeshSpringForceField stiffness="200"/><FixedConstraint indices="0"/>'
            "<SparseLDLSolver/>")
    fields = together(gravity(np.ones(4), [0, -10, 0]), springs(LINKS, CHAIN, 200))
    for order, rM, rK, iterations in itertools.product((1, 2), (0, 0.2), (0, 0.03), (1, 3)):
        newton = f'<NewtonRaphsonSolver maxNbIterationsNewton="{iterations}" absoluteResidualStoppingThreshold="0" ' + \
            ('relativeSuccessiveStoppingThreshold="1e-14" relativeInitialStoppingThreshold="1e-14"/>' if iterations > 1 else "/>")
        scene = root(f'<BDFOdeSolver order="{order}" rayleighMass="{rM}" rayleighStiffness="{rK}"/>' + newton + body)
        run = Run(scene, 20)
        x = multistep(CHAIN, np.ones(4), fields, 20, 0.01, order, [0], rM, rK, iterations)
        agree(run.x() - CHAIN, x - CHAIN, 1e-10)
        run.says("predicted-start: BDFOdeSolver begins with order 1")
        if iterations > 1:
            continue
        textbook = Run(scene, 20, args=["--without-quirk", "predicted-start"]).x()
        differ(textbook, x, 1e-5)
        if order == 1:
            agree(textbook, euler(CHAIN, np.eye(4), fields, 20, 0.01, held=[0], rayleigh_mass=rM, rayleigh_stiffness=rK), 1e-10)


@case
def frames_that_turn_as_they_are_predicted_to():
    """Inertia in fixed axes: without torque an angular velocity stays, and natively its axis turns."""
    w = np.array([1, 2, 3.0])
    frame = ('<NewtonRaphsonSolver/><SparseLDLSolver/><MechanicalObject name="dofs" template="Rigid3" position="0 0 0 0 0 0 1" '
             'velocity="0 0 0 1 2 3"/><UniformMass vertexMass="2 1 [0.5 0 0 0 0.7 0 0 0 0.9]"/>')
    for order in (1, 2):
        scene = root(f'<BDFOdeSolver order="{order}"/>' + frame)
        x = Run(scene, 20).x(width=7)[0]
        fall = multistep(np.zeros((1, 3)), [2], gravity([2], [0, -10, 0]), 20, 0.01, order)[0]
        agree(x, np.r_[fall, turn_of(0.2 * w)], 1e-12)
        Run(scene, 1, args=["--without-quirk", "fixed-inertia"]).fails(2, "is not for frames whose inertia turns")
        turned = Run(scene, 20, args=["--without-quirk", "fixed-inertia", "--without-quirk", "predicted-start"]).x(width=7)[0]
        differ(turned[3:], turn_of(0.2 * w), 1e-3)


@case
def frames_that_swing_and_rest_for_some_steps():
    """Where the torque of a spring is small a step ends as it begins: the one after it has no change of velocity behind it."""
    inertia, k, angle, lack = 0.9, 40.0, 0.3, 0.02
    def spring(x, v):
        return -k * x, -k * np.eye(3)
    for order in (1, 2):
        scene = root(f'<BDFOdeSolver order="{order}"/><NewtonRaphsonSolver absoluteResidualStoppingThreshold="{lack}"/><SparseLDLSolver/>'
                     f'<MechanicalObject name="dofs" template="Rigid3" position="0 0 0 0 0 {np.sin(angle / 2)} {np.cos(angle / 2)}" '
                     'rest_position="0 0 0 0 0 0 1"/><UniformMass vertexMass="1 1 [0.5 0 0 0 0.7 0 0 0 0.9]"/>'
                     f'<RestShapeSpringsForceField stiffness="1" angularStiffness="{k}"/>', 'gravity="0 0 0"')
        for steps in (5, 40):
            turn, awake = (multistep([[0, 0, angle]], [inertia], spring, steps, 0.01, order, rest_below=below)[0] for below in (lack, 0))
            agree(Run(scene, steps).x(width=7)[0], np.r_[0, 0, 0, turn_of(turn)], 1e-9)
        differ(turn, awake, 1e-3)


@case
def steps_that_are_over_before_they_begin():
    """m g h sqrt(2) of a light body is below Newton's absolute threshold of 1e-5: in SOFA it does not fall."""
    light = '<MechanicalObject name="dofs" position="0 0 0  1 0 0"/><UniformMass totalMass="1e-4"/><SparseLDLSolver/>'
    for order in (1, 2):
        solver = f'<BDFOdeSolver order="{order}"/>'
        run = Run(root(solver + "<NewtonRaphsonSolver/>" + light), 10)
        assert np.array_equal(run.x(), [[0, 0, 0], [1, 0, 0]]), run.x()
        fall = multistep(np.zeros((2, 3)), [5e-5] * 2, gravity([5e-5] * 2, [0, -10, 0]), 10, 0.01, order)[:, 1]
        finer = '<NewtonRaphsonSolver absoluteResidualStoppingThreshold="1e-7"/>'
        agree(Run(root(solver + finer + light), 10).x()[:, 1], fall)
        differ(Run(root(solver + "<NewtonRaphsonSolver/>" + light), 10, args=["--without-quirk", "predicted-start"]).x()[:, 1], [0, 0], 1e-3)
    Run(root("<BDFOdeSolver/>" + light), 1).says("leads to no NewtonRaphsonSolver: SOFA moves nothing then")


@case
def one_sided_springs_exactly_at_rest():
    """They have no tangent there, in SOFA and natively: the first step is that of a free body."""
    scene = root(EXACT + CHAIN_NODES + '<MeshTopology edges="0 1  1 2  2 3"/><FixedConstraint indices="0"/>'
                 '<MeshSpringForceField stiffness="200" noCompression="true"/>', 'gravity="4 -10 1"')
    fields = together(gravity(np.ones(4), [4, -10, 1]), springs(LINKS, CHAIN, 200, acts=lambda stretch: stretch > 0))
    for steps in (1, 20):
        agree(Run(scene, steps).x() - CHAIN, euler(CHAIN, np.eye(4), fields, steps, 0.01, held=[0]) - CHAIN, 1e-9)
    agree(Run(scene, 1).x() - CHAIN, np.outer([0, 1, 1, 1], [4e-4, -1e-3, 1e-4]))
    hangs = ('<Node name="root" dt="0.01" gravity="0 {}10 0"><EulerImplicitSolver/><SparseLDLSolver/><MechanicalObject name="dofs" '
             'position="0 0 0  0 -1 0"/><UniformMass totalMass="2"/><FixedProjectiveConstraint indices="0"/><SpringForceField '
             'springsIndices1="0" springsIndices2="1" lengths="1" stiffness="5000" damping="0" {}="true"/></Node>')
    for sign, word in (("-", "elongationOnly"), ("", "compressionOnly")):
        agree(Run.of_native(hangs.format(sign, word), 1).x()[1], [0, -1 + float(sign + "1") * 1e-3, 0], 1e-12)


@case
def quirk_meeting_ends():
    """A node where its spring has no length falls freely for one step, and is drawn back from there on."""
    scene = root(EXACT + '<MechanicalObject name="dofs" position="0 0 0  0 0 0"/><UniformMass totalMass="2"/><FixedConstraint indices="0"/>'
                 '<SpringForceField {}/>')

    def drawn(steps, free):
        y = v = 0.0
        for step in range(steps):
            k = 0 if free and step == 0 else 500
            v += 0.01 * (-10 - k * y - 0.01 * k * v) / (1 + 1e-4 * k)
            y += 0.01 * v
        return y
    for words in ('springsIndices1="0" springsIndices2="1" stiffness="500" damping="0" lengths="0"', 'spring="0 1 500 0 0"'):
        for steps in (1, 20):
            run = Run(scene.format(words), steps)
            agree(run.x()[1], [0, drawn(steps, True), 0])
            agree(Run(scene.format(words), steps, args=["--without-quirk", "meeting-ends"]).x()[1], [0, drawn(steps, False), 0])
        run.says("meeting-ends: springs do nothing where their ends meet")
    longer = scene.format('springsIndices1="0" springsIndices2="1" stiffness="500" damping="0" lengths="0.5"')
    agree(Run(longer, 1).x()[1], [0, drawn(1, True), 0])
    agree(Run(longer, 1, args=["--without-quirk", "meeting-ends"]).x()[1], [0, drawn(1, False), 0])
    apart = '<Node name="{}">{}<MechanicalObject name="dofs" position="0 0 0"/>{}</Node>'
    Run(root(apart.format("a", EXACT, "<UniformMass/>") + apart.format("b", "", "") +
             '<SpringForceField object1="@a" object2="@b" springsIndices1="0" springsIndices2="0"/>'), 1).says("holds nodes without mass")


@case
def masses_that_a_mapping_does_not_map():
    """SOFA declares mapMasses and reads it nowhere; a mapping without forces passes no masses on either."""
    def scene(words):
        return root(EXACT + '<MechanicalObject name="dofs" position="0 0 0"/><UniformMass totalMass="1"/><RestShapeSpringsForceField '
                    'stiffness="40" points="0"/><Node name="seen"><MechanicalObject name="dofs"/><UniformMass totalMass="3"/>'
                    f'<IdentityMapping {words}/></Node>')

    def oscillated(m):
        y = v = 0.0
        for _ in range(20):
            v += 0.01 * (-10 * m - 40 * y - 0.4 * v) / (m + 0.01 * 0.4)
            y += 0.01 * v
        return [[0, y, 0]]
    for words, mass in (("", 4), ('mapMasses="0"', 4), ('mapForces="0"', 1), ('isMechanical="false"', 1)):
        run = Run(scene(words), 20)
        agree(run.x(), oscillated(mass))
        if "Masses" in words:
            run.says("has no effect, as in SOFA: masses of the nodes that follow count")


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
def lines_between_nodes_that_several_bodies_have():
    """A mesh of lines alone has as many nodes as they name, and the mapping says where these are."""
    a, b = [[0, 0, 0], [1, 0, 0]], [[2, 0.5, 0], [3, 0.5, 0]]
    x = np.array(a + b, float)
    for lines, indices in (("0 1", "0 1  1 0"), ("1 0", "1 0  0 1")):
        scene = root(EXACT + '<Node name="a"><MechanicalObject name="dofs" position="0 0 0  1 0 0"/><UniformMass totalMass="2"/>'
                     '<FixedConstraint indices="0"/></Node><Node name="b"><MechanicalObject name="dofs" position="2 0.5 0  3 0.5 0"/>'
                     f'<UniformMass totalMass="2"/></Node><Node name="both"><MeshTopology lines="{lines}"/><MechanicalObject name="dofs"/>'
                     f'<SubsetMultiMapping input="@../a/dofs @../b/dofs" output="@dofs" indexPairs="{indices}"/>'
                     '<MeshSpringForceField stiffness="500"/></Node>')
        run = Run(scene, 20)
        fields = together(gravity(np.ones(4), [0, -10, 0]), springs([(1, 2)], x, 500))
        moved = euler(x, np.eye(4), fields, 20, 0.01, held=[0])
        agree(np.vstack([run.x("a.dofs"), run.x("b.dofs")]), moved)


@case
def surfaces_without_inner_edges_do_not_bend():
    """Nor do surfaces without cells of the kind: there is no spring, as in SOFA."""
    for kind in ("Quad", "Triangular"):
        mesh = '<MeshTopology position="0 0 0  1 0 0  1 1 0  0 1 0" quads="0 1 2 3"/><MechanicalObject name="dofs"/><UniformMass totalMass="4"/>'
        run = Run(root(EXACT + mesh + f'<{kind}BendingSprings stiffness="100"/>'), 10)
        run.says("no two cells of the surface share an edge")
        agree(run.x()[:, 1], [fallen(10), fallen(10), 1 + fallen(10), 1 + fallen(10)])


def numbers_of(values):
    return " ".join(repr(float(value)) for value in np.ravel(values))


def oriented(axis, angle):
    return turn_of(np.array(axis) / np.linalg.norm(axis) * angle)


def joint_of(free, shift, turn, block, kd, limits, start=None, rest=None):
    """SOFA's JointSpring between frames 0 and 1. start: frames of the start, where REST_T is given; rest: REST_R."""
    k_shift, k_turn = [np.where(free[i:i + 3], *pair) for i, pair in ((0, shift), (3, turn))]
    place = np.zeros(3) if start is None else start[1][:3] - start[0][:3]
    back = (np.array([0, 0, 0, 1.]) if rest is None else rest) if start is None else product(start[1][3:], inverse(start[0][3:]))

    def torques(th, R):
        k, out = np.array(k_turn, float), k_turn * th
        frees = [i for i in range(3) if free[3 + i]]
        if len(frees) == 1 and limits[frees[0]][0] < th[frees[0]] < limits[frees[0]][1]:
            e = np.eye(3)[frees[0]]
            across = np.cross(e, R @ e)
            angle = np.arctan2(np.linalg.norm(across), e @ R @ e)
            return k, np.where(e == 1, out, k * angle * across)
        beyond = np.where(free[3:], 0.0, th)
        for i in frees:
            low, high = limits[i]
            if not low < th[i] < high:
                ways = (th[i] - high + (0 if th[i] > 0 else 2 * np.pi), low - th[i] + (2 * np.pi if th[i] > 0 else 0))
                beyond[i] = th[i] - (high if ways[0] < ways[1] else low)
                k[i] = block
        if frees:
            out = np.where([i in frees and beyond[i] != 0 for i in range(3)], k * beyond, out)
        return k, out

    def field(x, v):
        A = axes_of(x[0][3:])
        relative = product(product(inverse(x[0][3:]), x[1][3:]), back)
        k, torque = torques(rotation_vector(relative), axes_of(relative))
        push = A @ (k_shift * (A.T @ (x[1][:3] - x[0][:3] - place)))
        one = np.r_[push, A @ torque] + kd * (v[1] - v[0])
        block = np.zeros((6, 6))
        block[:3, :3], block[3:, 3:] = A @ np.diag(k_shift) @ A.T, A @ np.diag(k) @ A.T
        return np.array([one, -one]), np.kron([[-1, 1], [1, -1]], block)
    return field


@case
def joints_between_frames():
    """SOFA's forces: no arms, a rest in fixed axes, pivots, limits; both frames move. With products, as it has no matrix of them."""
    frames = np.array([[0, 0, 0, *oriented([1, 2, 0.5], 0.5)], [0.3, -0.2, 0.4, *oriented([0.2, 1, 1], 0.9)]])
    none = [(-1e5, 1e5)] * 3
    inertia = 1.5 * np.array([1, 1, 1, 0.2, 0.3, 0.4])
    solver = '<EulerImplicitSolver/><CGLinearSolver iterations="300" tolerance="1e-15" threshold="0"/>'
    turned = oriented([1, 0, 2], 0.3)

    def run(words, field, steps=6):
        scene = node(solver + f'<MechanicalObject name="dofs" template="Rigid3d" position="{numbers_of(frames)}"/><UniformMass '
                     'vertexMass="1.5 1 [0.2 0 0,0 0.3 0,0 0 0.4]"/><JointSpringForceField spring="BEGIN_SPRING 0 1 ' + words +
                     ' END_SPRING"/>')
        return Run(scene, steps), euler_frames(frames, inertia, field, steps, 0.01)
    for words, field in (
            ("KS_T 0 300 KS_R 20 90", joint_of([0, 0, 0, 1, 1, 1], (0, 300), (20, 90), 0.9, 0, none)),
            ("FREE_AXIS 1 0 0 0 0 0 KS_T 40 300 KS_R 20 90 KD 2", joint_of([1, 0, 0, 0, 0, 0], (40, 300), (20, 90), 0.9, 2, none)),
            ("FREE_AXIS 0 0 0 1 0 0 KS_T 0 300 KS_R 20 90", joint_of([0, 0, 0, 1, 0, 0], (0, 300), (20, 90), 0.9, 0, none)),
            ("FREE_AXIS 0 1 0 0 1 0 KS_T 5 300 KS_R 20 90 KD 1", joint_of([0, 1, 0, 0, 1, 0], (5, 300), (20, 90), 0.9, 1, none)),
            ("FREE_AXIS 0 0 0 0 0 1 KS_T 0 300 KS_R 0 90", joint_of([0, 0, 0, 0, 0, 1], (0, 300), (0, 90), 0.9, 0, none)),
            ("FREE_AXIS 0 0 0 0 1 1 KS_T 0 300 KS_R 7 90 KS_B 60 R_LIM_Y -0.1 0.1 R_LIM_Z -1 1",
             joint_of([0, 0, 0, 0, 1, 1], (0, 300), (7, 90), 60, 0, [(-1e5, 1e5), (-0.1, 0.1), (-1, 1)])),
            ("FREE_AXIS 0 0 0 0 0 1 KS_T 0 300 KS_R 0 9000 R_LIM_Z -0.05 0.05",
             joint_of([0, 0, 0, 0, 0, 1], (0, 300), (0, 9000), 90, 0, [(-1e5, 1e5), (-1e5, 1e5), (-0.05, 0.05)])),
            ("KS_T 0 300 KS_R 20 90 R_LIM_X 0 0", joint_of([0, 0, 0, 0, 1, 1], (0, 300), (20, 90), 0.9, 0, none)),
            ("FREE_AXIS 0 0 0 0 0 0 KS_T 0 300 KS_R 0 90 REST_T 9 9 9", joint_of([0] * 6, (0, 300), (0, 90), 0.9, 0, none, start=frames)),
            ("FREE_AXIS 0 0 0 0 0 0 KS_T 0 300 KS_R 0 90 REST_R " + numbers_of(turned),
             joint_of([0] * 6, (0, 300), (0, 90), 0.9, 0, none, rest=turned))):
        seen, expected = run(words, field)
        agree(seen.x("dofs", 7), expected * np.where(expected[:, 6:] < 0, [1, 1, 1, -1, -1, -1, -1], 1))
        assert "in none that is assembled" not in seen.text, seen.text
    direct = node(EXACT + '<MechanicalObject name="dofs" template="Rigid3d" position="0 0 0 0 0 0 1  1 0 0 0 0 0 1"/><UniformMass/>'
                  '<JointSpringForceField spring="BEGIN_SPRING 0 1 END_SPRING"/>')
    Run(direct, 1).says("in SOFA it is in none that is assembled")


@case
def turns_of_one_frame():
    """No spring, but the tangent of one, of the first constant; a second one that has none takes that too."""
    q = oriented([0, 0, 1], 0.3)
    scene = node(EXACT + f'<MechanicalObject name="dofs" template="Rigid3d" position="0 0 0 0 0 0 1  1 0 0 {numbers_of(q)}" velocity="0 0 0 0 0 0  0 0 '
                 '0 0 0 2"/><UniformMass vertexMass="1 1 [0.2 0 0,0 0.2 0,0 0 0.2]"/><AngularSpringForceField indices="1" angularStiffness="50"/>')
    h, k, inertia, w, th = 0.01, 50, 0.2, 2.0, 0.3
    for _ in range(10):
        w += -h * h * k * w / (inertia + h * h * k)
        th += h * w
    agree(Run(scene, 10).x("dofs", 7), [[0, 0, 0, 0, 0, 0, 1], [1, 0, 0, 0, 0, np.sin(th / 2), np.cos(th / 2)]])
    w, th = 2.0, 0.3
    for _ in range(10):
        w += h * (-k * th - h * k * w) / (inertia + h * h * k)
        th += h * w
    agree(Run(scene.replace('indices="1"', 'indices="0 1"'), 10).x("dofs", 7)[1], [1, 0, 0, 0, 0, np.sin(th / 2), np.cos(th / 2)])


@case
def grids_without_thickness():
    """SOFA has two nodes at each place then."""
    run = Run(root(EXACT + '<RegularGridTopology n="3 2 2" min="0 0 0" max="2 0 1"/><MechanicalObject name="dofs"/><UniformMass '
                   'totalMass="2"/>'), 10)
    agree(run.x(), [[i, fallen(10), k] for k in (0, 1) for _ in (0, 1) for i in (0, 1, 2)])
    Run.of_native('<Node name="root"><RegularGridTopology n="3 2 2" min="0 0 0" max="2 0 1"/></Node>', 1).fails(2, "the box is 0 long in y")


@case
def groups_with_a_name():
    """The element says what it is."""
    falls(Run(root('<include href="g.xml"/>' + BODY), 10, {"g.xml": f'<Group name="any">{EXACT}</Group>'}))


@case
def rest_positions_that_a_mapping_was_given():
    """y = |x_b - x_a| - L pulled to L: a spring of twice the length."""
    scene = node(EXACT + '<MeshTopology name="m" position="0 0 0  1.2 0 0" edges="0 1"/><MechanicalObject name="dofs"/><UniformMass '
                 'totalMass="2"/><FixedConstraint indices="0"/><Node name="c"><MechanicalObject name="y" template="Vec1" '
                 'rest_position="@map.restLengths"/><DistanceMapping name="map" topology="@../m" restLengths="0.7"/>'
                 '<RestShapeSpringsForceField stiffness="100"/></Node>')
    x = np.array([[0, 0, 0], [1.2, 0, 0]])
    agree(Run(scene, 10).x(), euler(x, np.eye(2), springs([(0, 1)], [[0, 0, 0], [1.4, 0, 0]], 100, per_length=False), 10, 0.01, held=[0]))


@case
def settings_of_statics_in_two_places():
    newton = '<NewtonRaphsonSolver name="n" maxNbIterationsNewton="3"/>'
    body = ('<SparseLDLSolver/><MechanicalObject name="dofs" position="0 0 0  1 0 0"/><UniformMass totalMass="2"/><FixedConstraint '
            'indices="0"/><SpringForceField spring="0 1 100 0 0.5"/>')
    run = Run(root(newton + '<StaticSolver newton_iterations="5" absolute_residual_tolerance_threshold="1e-3"/>' + body), 3)
    run.says("newton_iterations: does not count", "absolute_residual_tolerance_threshold: does not count")
    agree(run.x(), Run(root(newton + "<StaticSolver/>" + body), 3).x())


@case
def fractions_and_writers_of_nothing():
    """A stream reads what stands before a stroke; and what has nothing to write is not created."""
    run = Run('<Node name="root" dt="0.04/2" gravity="0 -10 0"><VTKExporter filename="a"/><WriteState filename="b"/><Node name="n">' + EXACT +
              '<MechanicalObject name="dofs" position="0 0 0"/><UniformMass totalMass="1/3"/><ConstantForceField force="0 2 0"/></Node></Node>',
              10)
    run.says("'0.04/2' is no value: SOFA has 0.04", "'1/3' is no value: SOFA has 1 of it", "VTKExporter", "has nothing to write")
    agree(run.x("n.dofs")[0, 1], (2 - 10) * 0.04**2 * 55)
    run = Run(root(EXACT + '<MechanicalObject name="dofs" position="0 0 0" translation="1/4 0 0"/><UniformMass totalMass="1"/>'), 1)
    run.says("'1/4 0 0' is no value: SOFA has 1")
    agree(run.x()[0, 0], 1)
    idle = '<VectorSpringForceField stiffness="9"/><Node name="b"><RigidMapping/></Node>'
    run = Run(root(EXACT + BODY + idle), 10)
    falls(run)
    run.says("joins each node to itself", "has no state that follows")


def on_lengths(pairs, k, squares, mode, rest):
    """Springs on lengths, or on their squares: the geometric stiffness of all, of none, or of those that pull."""
    def field(x, v):
        f, K = np.zeros_like(x), np.zeros((x.size, x.size))
        for (a, b), y0 in zip(pairs, rest):
            d = x[b] - x[a]
            n = np.linalg.norm(d)
            y, g, H = (d @ d, 2 * d, 2 * np.eye(3)) if squares else (n, d / n, (np.eye(3) - np.outer(d, d) / n**2) / n)
            push = -k * (y - y0)
            f[b] += push * g
            f[a] -= push * g
            block = -k * np.outer(g, g) + (push * H if mode == "Exact" or (mode == "Stabilized" and push < 0) else 0)
            for i, j, sign in ((a, a, 1), (b, b, 1), (a, b, -1), (b, a, -1)):
                K[3 * i:3 * i + 3, 3 * j:3 * j + 3] += sign * block
        return f, K
    return field


@case
def springs_on_lengths():
    """Some pull and some push at once; three modes, by word and by number; lengths given, of the start, and none."""
    x = np.array([[0, 0, 0], [1, 0.2, 0], [0.3, 1.1, 0.1], [0.2, 0.1, 0.9]])
    v = np.array([[0, 0, 0], [2, 1, -1], [1, -3, 0.5], [-1, 0, -2.0]])
    pairs = [(0, 1), (1, 2), (2, 3), (3, 0), (1, 3)]
    edges = " ".join(f"{a} {b}" for a, b in pairs)
    starts, given = [np.linalg.norm(x[b] - x[a]) for a, b in pairs], [0.8, 1.9, 1.0, 1.3, 0.9]
    for solver in (EXACT, '<EulerImplicitSolver/><CGLinearSolver iterations="200" tolerance="1e-15" threshold="0"/>'):
        for number, mode in enumerate(("None", "Exact", "Stabilized")):
            word = number if solver == EXACT else mode
            for kind, k, more, rest in (("Distance", 40, "", starts), ("Distance", 40, f'restLengths="{numbers_of(given)}"', given),
                                        ("Distance", 40, 'computeDistance="1"', [0] * 5), ("SquareDistance", 3, "", [0] * 5)):
                scene = node(solver + f'<MeshTopology name="net" position="{numbers_of(x)}" edges="{edges}"/><MechanicalObject name="dofs" '
                             f'velocity="{numbers_of(v)}"/><UniformMass totalMass="2"/><FixedConstraint indices="0"/><Node name="c">'
                             f'<MechanicalObject template="Vec1d"/><{kind}Mapping topology="@../net" {more} geometricStiffness="{word}"/>'
                             f'<RestShapeSpringsForceField stiffness="{k}"/></Node>')
                expected = euler(x, 0.5 * np.eye(4), on_lengths(pairs, k, kind != "Distance", mode, rest), 8, 0.01, v=v, held=[0])
                agree(Run(scene, 8).x(), expected)


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
        run = Run(root(f'<Node name="arm">{solver}<MechanicalObject name="y" template="Vec1" position="{numbers_of(start)}" rest_position='
                       '"0 0 0"/><UniformMass vertexMass="0.01"/><RestShapeSpringsForceField stiffness="4"/>'
                       f'<ArticulatedHierarchyContainer/>{text}<Node name="rigid"><MechanicalObject template="Rigid3" name="dofs" position='
                       f'"0 0 0 0 0 0 1 {numbers_of(frames_at(start))}"/><UniformMass vertexMass="2 1 0.1 0 0 0 0.2 0 0 0 0.3"/>'
                       f'<ConstantForceField indices="1 2" forces="{numbers_of(loads)}"/><ArticulatedSystemMapping input1="@../y" '
                       'output="@dofs"/></Node></Node>'), 6)
        agree(run.x("arm.y", 1)[:, 0], y, 1e-8)
        agree(run.x("arm.rigid.dofs", 7)[1:], frames_at(y), 1e-8)


@case
def plasticity_of_turned_tetrahedra():
    """Large and polar: strains in the axes of each element, which turns; two of them that move far."""
    young, nu, yields, most, creep = 300, 0.3, 0.02, 0.9, 0.3
    X = np.array([[0, 0, 0], [1, 0.1, 0], [0.2, 1.1, 0], [0.1, 0.3, 0.9], [1, 1, 1.2]])
    cells = [(0, 1, 2, 3), (1, 2, 3, 4)]
    v = np.array([[0, 0, 0], [0, 3, 1], [-3, 0, 2], [2, -1, 0], [1, 2, -3.0]])
    D = stiffness(young, nu)

    def field_of(axes):
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
    for method, axes in (("small", lambda x: np.eye(3)), ("large", frame), ("polar", lambda x: polar((x[1:] - x[0]).T))):
        scene = node(EXACT + f'<MeshTopology position="{numbers_of(X)}" tetrahedra="0 1 2 3 1 2 3 4"/><MechanicalObject name="dofs" '
                     f'velocity="{numbers_of(v)}"/><UniformMass totalMass="5"/><TetrahedronFEMForceField method="{method}" youngModulus="{young}" '
                     f'poissonRatio="{nu}" plasticMaxThreshold="{most}" plasticYieldThreshold="{yields}" plasticCreep="{creep}"/>'
                     '<FixedConstraint indices="0"/>')
        agree(Run(scene, 12).x(), euler(X, np.eye(5), field_of(axes), 12, 0.01, v=v, held=[0]))


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


@case
def frames_drawn_to_others():
    """Springs of several constants to a rest shape, and to frames of another body by their numbers; both turn about skew axes."""
    frames = np.array([[0, 0, 0, *oriented([1, 2, 0.5], 0.5)], [1.3, -0.2, 0.4, *oriented([0.2, 1, 1], 0.9)], [2, 1, 0, *oriented([1, 0, 1], 2.0)]])
    rest = np.array([[0.2, 0, 0, *oriented([1, 0, 0], 0.3)], [1, 0, 0.1, *oriented([0, 1, 0], -0.4)], [2, 0.5, 0, *oriented([1, 1, 1], 0.7)]])
    others = np.array([[0, 1, 0, *oriented([0, 0, 1], 0.8)], [1, 1, 0, *oriented([1, 1, 0], -0.6)], [0, 2, 1, *oriented([0, 1, 2], 1.1)]])
    inertia = 1.5 * np.array([1, 1, 1, 0.2, 0.3, 0.4])

    def field_of(pairs, targets, ks, angular):
        def field(x, v):
            f, K = np.zeros((len(x), 6)), np.zeros((6 * len(x), 6 * len(x)))
            for i, (a, b) in enumerate(pairs):
                f[a, :3] -= ks[i] * (x[a][:3] - targets[b][:3])
                f[a, 3:] -= angular[i] * rotation_vector(product(x[a][3:], inverse(targets[b][3:])))
                K[6 * a:6 * a + 6, 6 * a:6 * a + 6] -= np.diag([ks[i]] * 3 + [angular[i]] * 3)
            return f, K
        return field
    body = (f'<MechanicalObject name="dofs" template="Rigid3d" position="{numbers_of(frames)}" rest_position="{numbers_of(rest)}"/><UniformMass '
            'vertexMass="1.5 1 [0.2 0 0,0 0.3 0,0 0 0.4]"/><RestShapeSpringsForceField {}/>')
    for words, field in (
            ('stiffness="40" angularStiffness="9"', field_of([(0, 0), (1, 1), (2, 2)], rest, [40] * 3, [9] * 3)),
            ('points="2 0" stiffness="40 10" angularStiffness="9 3"', field_of([(2, 2), (0, 0)], rest, [40, 10], [9, 3])),
            ('points="1 2" stiffness="40" angularStiffness="9 3" external_rest_shape="@../o/other" external_points="2 0"',
             field_of([(1, 2), (2, 0)], others, [40] * 2, [9, 3]))):
        scene = node(f'<Node name="o"><MechanicalObject name="other" template="Rigid3d" position="{numbers_of(others)}"/></Node>'
                     f'<Node name="b">{EXACT}{body.format(words)}</Node>')
        expected = euler_frames(frames, inertia, field, 8, 0.01)
        run = Run(scene, 8)
        agree(run.x("b.dofs", 7), expected * np.where(expected[:, 6:] < 0, [1, 1, 1, -1, -1, -1, -1], 1))


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
def cells_about_a_box():
    """A sparse grid: cells that the surface cuts have half the stiffness and come first; a load on a point inside."""
    box = np.array([[0.1, 0.3, 0.2], [2.4, 2.6, 1.7]])
    faces = "0 2 1 1 2 3 4 5 6 5 7 6 0 1 4 1 5 4 2 6 3 3 6 7 0 4 2 2 4 6 1 3 5 3 7 5"
    corners = [[box[i][0], box[j][1], box[k][2]] for k in (0, 1) for j in (0, 1) for i in (0, 1)]
    inside = {c: all(box[0] < c) and all(np.add(c, 1) < box[1]) for c in itertools.product(range(4), range(4), range(3))}
    met = sorted((c for c in inside if all(np.add(c, 1) > box[0]) and all(c < box[1])), key=lambda c: (inside[c], c[::-1]))
    places = sorted({tuple(np.add(c, o)) for c in met for o in CUBE_PLACES})
    number = {p: i for i, p in enumerate(places)}
    x = np.array(places, float)
    cells = [[number[tuple(np.add(c, o))] for o in CUBE_PLACES] for c in met]

    def axes(p):
        e = np.mean([p[1] - p[0], p[2] - p[3], p[5] - p[4], p[6] - p[7]], axis=0)
        n = np.cross(e, np.mean([p[3] - p[0], p[2] - p[1], p[7] - p[4], p[6] - p[5]], axis=0))
        e, n = e / np.linalg.norm(e), n / np.linalg.norm(n)
        return np.column_stack([e, np.cross(n, e), n])
    parts = [hexahedra([cell], x, 900 if inside[c] else 450, 0.3, turn=lambda now, then: axes(now) @ axes(then).T)
             for c, cell in zip(met, cells)]
    held = [i for i, p in enumerate(places) if p[2] == 0]
    point, push = np.array([1.3, 1.1, 1.0]), np.array([20, -10, 30.0])
    share = np.zeros(len(x))
    for o in CUBE_PLACES:
        share[number[tuple(np.add([1, 1, 1], o))]] = np.prod(np.where(o, point - 1, 2 - point))

    def pushed(x, v):
        return np.outer(share, push), np.zeros((x.size, x.size))
    scene = root(EXACT + f'<SparseGridTopology n="5 5 4" min="0 0 0" max="4 4 3" position="{numbers_of(corners)}" triangles="{faces}"/>'
                 '<MechanicalObject name="dofs"/><UniformMass vertexMass="0.3"/><HexahedronFEMForceField youngModulus="900" poissonRatio="0.3" '
                 f'method="large"/><FixedConstraint indices="{" ".join(map(str, held))}"/><Node name="c"><MechanicalObject name="m" '
                 f'position="{numbers_of(point)}"/><BarycentricMapping/><ConstantForceField force="{numbers_of(push)}"/></Node>')
    fields = together(gravity(np.full(len(x), 0.3), [0, -10, 0]), pushed, *parts)
    run = Run(scene, 6)
    expected = euler(x, 0.3 * np.eye(len(x)), fields, 6, 0.01, held=held)
    agree(run.x(), expected)
    agree(run.x("c.m"), [share @ expected])


def variational(x, mass, forces, steps, h, held=(), v=None, rM=0.0, rK=0.0, error=0.01, most=5):
    """SOFA's implicit steps: the midpoint's way r = x_m - x, the momentum is carried on, and few iterations."""
    x = np.array(x, float)
    n, v = len(x), np.zeros_like(x) if v is None else np.array(v, float)
    M = np.kron(np.asarray(mass, float), np.eye(3))
    free = np.repeat([i not in held for i in range(n)], 3)
    p = M @ v.ravel()
    for _ in range(steps):
        r, change, count = np.zeros(3 * n), 0.0, 0
        while count == 0 or (count < most and change > error):
            f, K = forces(x + r.reshape(-1, 3), v)
            A = (4 / h**2 + 4 * rM / h) * M - (1 + 4 * rK / h) * K
            b = f.ravel() + 2 / h * p - K @ r
            before, r = r, np.zeros(3 * n)
            r[free] = np.linalg.solve(A[np.ix_(free, free)], b[free])
            change, count = np.linalg.norm(r - before) / np.linalg.norm(x), count + 1
        v = 2 / h * r.reshape(-1, 3)
        f = forces(x + r.reshape(-1, 3), v)[0].ravel() * free
        p = M @ v.ravel() + h / 2 * f
        x = x + h * v
    return x


@case
def variational_steps_end_where_positions_change_little():
    """One iteration or several, with damping, which is of the first half of a step; with products and with a matrix."""
    x = np.array([[0, 0, 0], [1, 0, 0], [1.5, 1, 0], [0.2, 1.2, 0.5]])
    v = np.array([[0, 0, 0], [0, 2, 0], [3, 0, -1], [0, 0, 2.0]])
    pairs = [(0, 1), (1, 2), (2, 3), (3, 0), (0, 2)]
    fields = together(gravity(np.full(4, 0.5), [0, -10, 0]), springs(pairs, x, 300))
    edges = " ".join(f"{a} {b}" for a, b in pairs)
    body = (f'<MeshTopology position="{numbers_of(x)}" edges="{edges}"/><MechanicalObject name="dofs" velocity="{numbers_of(v)}"/><UniformMass '
            'totalMass="2"/><MeshSpringForceField stiffness="300"/><FixedConstraint indices="0"/>')
    for solver in ("<SparseLDLSolver/>", '<CGLinearSolver iterations="300" tolerance="1e-15" threshold="0"/>'):
        for words, more in (("", {}), ('newtonError="1e-12" steps="3"', {"error": 1e-12, "most": 3}),
                            ('rayleighMass="0.4" rayleighStiffness="0.02"', {"rM": 0.4, "rK": 0.02}),
                            ('rayleighMass="0.4" rayleighStiffness="0.02" newtonError="1e-5"', {"rM": 0.4, "rK": 0.02, "error": 1e-5})):
            scene = root(f'<VariationalSymplecticSolver {words}/>' + solver + body)
            agree(Run(scene, 15).x(), variational(x, 0.5 * np.eye(4), fields, 15, 0.01, held=[0], v=v, **more))
    other = Run(scene, 15, args=["--without-quirk", "one-iteration"]).x()
    differ(other, variational(x, 0.5 * np.eye(4), fields, 15, 0.01, held=[0], v=v, **more), 1e-4)
    explicit = root('<VariationalSymplecticSolver explicitIntegration="1" rayleighStiffness="0.1"/>' + BODY)
    falls(Run(explicit, 10))


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


SWINGING = [np.array([[0, 0, 0], [1, 0.1, 0.2], [2, -0.1, 0.1], [2.9, 0.3, -0.2]]),
            np.array([[0.1, 0.2, -0.3], [0.5, 0, 1], [0, -1, 0.3], [-0.4, 0.6, 0.2]])]
HANGING = [np.array([[2.9, 0.3, -0.2], [3.8, 0.2, 0.3], [4.5, -0.4, 0.1]]), np.array([[0.3, -0.2, 0.5], [0, 1, -1], [0.4, 0.4, 0.2]])]
SWINGING_SPRINGS = [(0, 1, 80, 2, 1.1), (1, 2, 60, 1, 0.9), (2, 3, 70, 1.5, 1.2)]
HANGING_SPRINGS = [(0, 1, 90, 1, 1.0), (1, 2, 50, 2, 0.8)]
DAMPED = '<EulerImplicitSolver rayleighStiffness="0.02" rayleighMass="0.1"/>'
DAMPED_SOLVERS = (DAMPED + '<CGLinearSolver iterations="400" tolerance="1e-14" threshold="1e-30"/>', DAMPED + '<SparseLDLSolver/>')


def damped_system(x, v, mass, lists, h=0.01, rm=0.1, rk=0.02, g=10.0):
    """A and b of an implicit step of nodes on springs (a, b, k, d, L), whose damping is not in the matrix."""
    f, K = np.outer(mass, [0, -g, 0]), np.zeros((x.size, x.size))
    for a, b, k, d, L in lists:
        e = x[b] - x[a]
        now = np.linalg.norm(e)
        n = e / now
        t = (k * (now - L) + d * (v[b] - v[a]) @ n) / now
        f[a] += t * e
        f[b] -= t * e
        block = (k - t) * np.outer(n, n) + t * np.eye(3)
        for i, j, sign in ((a, a, -1), (b, b, -1), (a, b, 1), (b, a, 1)):
            K[3 * i:3 * i + 3, 3 * j:3 * j + 3] += sign * block
    M, flat = np.diag(np.repeat(mass, 3)), v.ravel()
    return (1 + h * rm) * M - h * (h + rk) * K, h * (f.ravel() + (h + rk) * K @ flat - rm * M @ flat)


FREE_LOOP = '<FreeMotionAnimationLoop/><GenericConstraintSolver maxIterations="1000" tolerance="1e-14"/>'


def springs_of(lists):
    return '<SpringForceField spring="' + "  ".join(numbers_of(spring) for spring in lists) + '"/>'


@case
def nodes_that_start_off_their_lines_and_planes():
    """SOFA projects positions and velocities before the first step too: no step takes the nodes there."""
    d, o = np.array([1, 2, -0.5]) / np.linalg.norm([1, 2, -0.5]), np.array([0.3, 0.1, 0.2])
    X, V = SWINGING
    onto, off = np.outer(d, d), np.eye(3) - np.outer(d, d)
    for P, place, text in ((onto, lambda p: o + onto @ (p - o), f'LineProjectiveConstraint origin="{numbers_of(o)}" direction="2 4 -1"'),
                           (off, lambda p: o + off @ (p - o), f'PlaneProjectiveConstraint origin="{numbers_of(o)}" normal="2 4 -1"'),
                           (0 * onto, lambda p: o, f'PointProjectiveConstraint point="{numbers_of(o)}"'),
                           (onto, lambda p: X[3] + onto @ (p - X[3]), 'DirectionProjectiveConstraint direction="2 4 -1"')):
        x, v = X.copy(), V.copy()
        x[3], v[3] = place(x[3]), P @ v[3]
        whole = np.eye(12)
        whole[:3, :3], whole[9:, 9:] = 0, P
        for _ in range(15):
            A, b = damped_system(x, v, [0.5] * 4, SWINGING_SPRINGS)
            dv = np.linalg.solve(whole @ A @ whole + np.eye(12) - whole, whole @ b)
            v = v + dv.reshape(-1, 3)
            x = x + 0.01 * v
            x[3], v[3] = place(x[3]), P @ v[3]
        for solver, args in ((DAMPED_SOLVERS[0], []), (DAMPED_SOLVERS[1], ["--without-quirk", "unheld-matrix"])):
            run = Run(root(solver + f'<MechanicalObject name="dofs" position="{numbers_of(X)}" velocity="{numbers_of(V)}"/><UniformMass '
                           f'vertexMass="0.5"/>{springs_of(SWINGING_SPRINGS)}<{text} indices="3"/><FixedProjectiveConstraint indices="0"/>'), 15,
                      args=args)
            agree(run.x(), x)


@case
def nodes_that_assembled_matrices_do_not_hold():
    """A is that of free nodes, b is projected, and so are positions and velocities after the step."""
    d, o, h = np.array([1, 2, -0.5]) / np.linalg.norm([1, 2, -0.5]), np.array([0.3, 0.1, 0.2]), 0.01
    X, V = SWINGING
    onto, off, none = np.outer(d, d), np.eye(3) - np.outer(d, d), np.zeros((3, 3))
    amplitude, way, tall = np.array([0.1, -0.2, 0.3]), np.array([0.8, 0, 0]), np.array([0, 0.3, 0])

    def swung(p, v, t):
        return X[3] + np.sin(20 * t + 0.3) * amplitude, 20 * np.cos(20 * t + 0.3) * amplitude

    def thrown(p, v, t):
        def at(u):
            return X[3] + u * way + 4 * u * (1 - u) * tall
        return at(5 * t), (at(5 * (t + h)) - at(5 * t)) / h

    def carried(p, v, t):
        return X[3] + min((t + 0.05) / 0.15, 1) * amplitude, 0 * v
    corners = numbers_of(X[3]) + "  " + "  ".join(numbers_of(X[3] + c) for c in ([1, 0, 0], [1, 1, 0], [0, 1, 0]))
    moves = "  ".join([numbers_of(amplitude)] * 4)
    times = 'beginConstraintTime="-0.05" endConstraintTime="0.1"'
    for P, place, text in (
            (onto, lambda p, v, t: (o + onto @ (p - o), onto @ v), f'LineProjectiveConstraint origin="{numbers_of(o)}" direction="2 4 -1"'),
            (off, lambda p, v, t: (o + off @ (p - o), off @ v), f'PlaneProjectiveConstraint origin="{numbers_of(o)}" normal="2 4 -1"'),
            (onto, lambda p, v, t: (X[3] + onto @ (p - X[3]), onto @ v), 'DirectionProjectiveConstraint direction="2 4 -1"'),
            (none, swung, f'OscillatorProjectiveConstraint oscillators="3 {numbers_of(X[3])} {numbers_of(amplitude)} 20 0.3"'),
            (none, thrown, f'ParabolicProjectiveConstraint P1="{numbers_of(X[3])}" P2="{numbers_of(X[3] + way / 2 + tall)}" '
                           f'P3="{numbers_of(X[3] + way)}" BeginTime="0" EndTime="0.2"'),
            (none, carried, f'AffineMovementProjectiveConstraint {times} translation="{numbers_of(amplitude)}"'),
            (none, carried, f'PatchTestMovementProjectiveConstraint {times} cornerPoints="{corners}" cornerMovements="{moves}"')):
        x, v, part = X.copy(), V.copy(), np.eye(12)
        part[9:, 9:] = P
        x[3], v[3] = place(x[3], v[3], 0)
        for step in range(15):
            A, b = damped_system(x, v, [0.5] * 4, SWINGING_SPRINGS)
            dv = np.zeros(12)
            dv[3:] = np.linalg.solve(A[3:, 3:], (part @ b)[3:])
            v = v + dv.reshape(-1, 3)
            x = x + h * v
            x[3], v[3] = place(x[3], v[3], step * h)
        if "indices" not in text and "oscillators" not in text:
            text += ' indices="3"'
        scene = (f'<MechanicalObject name="dofs" position="{numbers_of(X)}" velocity="{numbers_of(V)}"/><UniformMass vertexMass="0.5"/>'
                 f'{springs_of(SWINGING_SPRINGS)}<{text}/><FixedProjectiveConstraint indices="0"/>')
        run = Run(root(DAMPED_SOLVERS[1] + scene), 15)
        agree(run.x(), x, 1e-8)
        run.says("unheld-matrix: assembled matrices leave nodes on lines")
        differ(Run(root(DAMPED_SOLVERS[1] + scene), 15, args=["--without-quirk", "unheld-matrix"]).x(), x, 2e-6)
        differ(Run(root(DAMPED_SOLVERS[0] + scene), 15).x(), x, 2e-6)
        sparse = DAMPED_SOLVERS[0].replace("<CGLinearSolver", '<CGLinearSolver template="CompressedRowSparseMatrixd"')
        agree(Run(root(sparse + scene), 15).x(), x, 1e-7)
        still = Run(root('<StaticSolver/><SparseLDLSolver/>' + scene), 1)
        still.says("holds its nodes in the matrix of /StaticSolver1: SOFA solves with them free")


@case
def ends_attached_both_ways():
    """Ends have the mean of their velocities. Products with a matrix see one node; assembled matrices see two free ones whose right
    sides are the mean."""
    for solver, args, assembled in ((DAMPED_SOLVERS[0], [], False), (DAMPED_SOLVERS[1], [], True),
                                    (DAMPED_SOLVERS[1], ["--without-quirk", "unheld-matrix"], False)):
        x, v, mass, lists = both_bodies()
        mean = np.eye(21)
        for i in range(3):
            mean[np.ix_((9 + i, 12 + i), (9 + i, 12 + i))] = 0.5
        v = (mean @ v.ravel()).reshape(-1, 3)
        for _ in range(15):
            A, b = damped_system(x, v, mass, lists)
            if not assembled:
                A = mean @ A @ mean + np.eye(21) - mean
            dv = np.zeros(21)
            dv[3:] = np.linalg.solve(A[3:, 3:], (mean @ b)[3:])
            v = v + dv.reshape(-1, 3)
            x = x + 0.01 * v
            x[4], v = (x[3] + x[4]) / 2, (mean @ v.ravel()).reshape(-1, 3)
        text = '<AttachProjectiveConstraint object1="@one/dofs" object2="@two/dofs" indices1="3" indices2="0" twoWay="1"/>'
        run = Run(two_bodies(text, solver), 15, args=args)
        agree(np.vstack([run.x("bodies.one.dofs"), run.x("bodies.two.dofs")]), x, 1e-8)


@case
def frames_whose_held_turns_are_taken_back():
    """FixedRotationProjectiveConstraint takes the twists about its axes, one after another, out of the orientation; torques about
    them go on to speed frames up."""
    def parted(q, axis):
        twist = np.array([0, 0, 0, q[3]])
        twist[axis] = q[axis]
        twist /= np.linalg.norm(twist)
        swing = product(q, inverse(twist))
        return twist, swing / np.linalg.norm(swing)
    start = np.array([0.1, 0.2, -0.1, 0.9])
    start /= np.linalg.norm(start)
    for axes in ([0], [0, 1], [0, 1, 2]):
        q, w, kept, left = start, np.array([1, 2, -1.5]), np.array([0, 0, 0, 1.0]), start
        for axis in axes:
            twist, left = parted(left, axis)
            kept = product(twist, kept)
        for _ in range(20):
            w = w + 0.01 * np.array([1, -2, 3]) / [0.2, 0.3, 0.5]
            left = product(turn_of(0.01 * w), q)
            for axis in axes:
                left = parted(left, axis)[1]
            q = product(left, kept)
        held = " ".join(f'Fixed{"XYZ"[axis]}Rotation="true"' for axis in axes)
        scene = node(EXACT + f'<MechanicalObject name="dofs" template="Rigid3" position="0 0 0 {numbers_of(start)}" velocity="0 0 0 1 2 -1.5"/>'
                     '<UniformMass vertexMass="1 1 0.2 0 0 0 0.3 0 0 0 0.5"/><ConstantForceField indices="0" forces="0 0 0 1 -2 3"/>'
                     f'<FixedRotationProjectiveConstraint {held}/>')
        agree(Run(scene, 20).x("dofs", 7)[0, 3:], q * np.sign(q[3]))
        differ(Run(scene, 20, args=["--without-quirk", "one-sided-turns"]).x("dofs", 7)[0, 3:], q * np.sign(q[3]), 1e-3)


def two_bodies(between, solver, apart=0, loop=""):
    bodies = ""
    for name, (x, v), mass, lists, more in (("one", SWINGING, 0.5, SWINGING_SPRINGS, '<FixedProjectiveConstraint indices="0"/>'),
                                            ("two", HANGING, 0.3, HANGING_SPRINGS, "")):
        x = x + apart if name == "two" else x
        bodies += (f'<Node name="{name}"><MechanicalObject name="dofs" position="{numbers_of(x)}" velocity="{numbers_of(v)}"/>'
                   f'<UniformMass vertexMass="{mass}"/>{springs_of(lists)}{more}</Node>')
    return root(loop + f'<Node name="bodies">{solver}{bodies}{between}</Node>')


def both_bodies(apart=0):
    lists = SWINGING_SPRINGS + [(a + 4, b + 4, *rest) for a, b, *rest in HANGING_SPRINGS]
    return np.vstack([SWINGING[0], HANGING[0] + apart]), np.vstack([SWINGING[1], HANGING[1]]), [0.5] * 4 + [0.3] * 3, lists


@case
def attached_ends_take_means_after_each_step():
    """One way, of points: in a step the second goes on as it was, and the first as if alone; then both have the mean of their
    velocities, and the second the mean of the places."""
    for apart in (0, np.array([0.1, 0.05, -0.1])):
        x, v, mass, lists = both_bodies(apart)
        free = [i for i in range(21) if i > 2 and not 12 <= i < 15]
        for step in range(16):
            if step > 0:
                A, b = damped_system(x, v, mass, lists)
                dv = np.zeros(21)
                dv[free] = np.linalg.solve(A[np.ix_(free, free)], b[free])
                v = v + dv.reshape(-1, 3)
                x = x + 0.01 * v
            x[4] = (x[3] + x[4]) / 2
            v[3] = v[4] = (v[3] + v[4]) / 2
        text = ('<AttachProjectiveConstraint object1="@one/dofs" object2="@two/dofs" indices1="3" indices2="0" positionFactor="1.0" '
                'velocityFactor="1.0" responseFactor="1.0" constraintFactor="1.0"/>')
        for solver in DAMPED_SOLVERS:
            run = Run(two_bodies(text, solver, apart), 15)
            agree(np.vstack([run.x("bodies.one.dofs"), run.x("bodies.two.dofs")]), x)
        run = Run(two_bodies(text, DAMPED_SOLVERS[1], apart), 15, args=["--without-quirk", "moved-inertia"])
        differ(run.x("bodies.one.dofs"), x[:4], 0.01)


@case
def pairs_that_attach_in_part():
    """c = (v2 - v1) b k / 2 changes both velocities, and x2 goes a k / 2 of the way to x1, which stays. Pairs are free past lastPos,
    unless clamp holds the second there, and farther apart than minDistance."""
    apart = np.array([0.1, 0.05, -0.1])
    last = {"place": SWINGING[0][3] + [0.01, 0, 0], "way": np.array([1.0, 0.5, 0])}
    passes = f'lastPos="{numbers_of(last["place"])}" lastDir="1 0.5 0"'
    met = [0, 0]
    for more, factors, ends, clamp, least, both in (
            ("", (1, 1, 1), False, False, -1, True),
            ('positionFactor="0.5" velocityFactor="0.3" constraintFactor="0.8"', (0.4, 0.24, 1), False, False, -1, False),
            ('positionFactor="0.5" velocityFactor="0.3" responseFactor="0.6"', (0.5, 0.3, 0.6), False, False, -1, True),
            (passes, (1, 1, 1), True, False, -1, False), (passes + ' clamp="1"', (1, 1, 1), True, True, -1, False),
            ('minDistance="0.149"', (1, 1, 1), False, False, 0.149, False), ('minDistance="0.2"', (1, 1, 1), False, False, 0.2, False)):
        for solver in DAMPED_SOLVERS[:1] if least > 0 else DAMPED_SOLVERS:
            assembled = solver is DAMPED_SOLVERS[1]
            if both and not more and not assembled:
                continue
            x, v, mass, lists = both_bodies(apart)
            mix = np.eye(21)
            for i in range(3):
                share = factors[2] / 2 if assembled else 0
                mix[np.ix_((9 + i, 12 + i), (9 + i, 12 + i))] = [[1 - share, share], [share, 1 - share]]
            follows = is_clamped = False
            for step in range(16):
                if step > 0:
                    A, b = damped_system(x, v, mass, lists)
                    held = {0, 1, 2} | ({12, 13, 14} if not both and (follows or is_clamped) else set())
                    free = [i for i in range(21) if i not in held]
                    dv = np.zeros(21)
                    dv[free] = np.linalg.solve(A[np.ix_(free, free)], (mix @ b if both else b)[free])
                    v = v + dv.reshape(-1, 3)
                    x = x + 0.01 * v
                is_past = ends and (x[3] - last["place"]) @ last["way"] > 0
                follows, is_clamped = not is_past, is_past and clamp
                if least > 0 and np.linalg.norm(x[4] - x[3]) > least:
                    follows = False
                met[follows] += 1
                if follows:
                    x[4] -= factors[0] / 2 * (x[4] - x[3])
                    change = factors[1] / 2 * (v[4] - v[3])
                    v[3], v[4] = v[3] + change, v[4] - change
                if is_clamped:
                    x[4], v[4] = (x[4] + last["place"]) / 2, v[4] / 2
            text = (f'<AttachProjectiveConstraint object1="@one/dofs" object2="@two/dofs" indices1="3" indices2="0" {more} '
                    f'twoWay="{int(both)}"/>')
            run = Run(two_bodies(text, solver, apart), 15)
            agree(np.vstack([run.x("bodies.one.dofs"), run.x("bodies.two.dofs")]), x, 1e-8)
    assert min(met) > 10, met
    Run(two_bodies('<AttachProjectiveConstraint object1="@one/dofs" object2="@two/dofs" indices1="3" indices2="0" minDistance="0.1" '
                   'twoWay="1"/>', DAMPED_SOLVERS[0]), 1).fails(2, "lastDir and minDistance are of points and frames that follow")


@case
def frames_that_attach_in_part():
    """Followers take centres alone, or their rest turn too: the one that takes the way to the next node, in its own axes, to x."""
    turn = turn_of(np.array([0.3, -0.2, 0.4]))
    scene = (EXACT + '<Node name="one"><MechanicalObject name="dofs" template="Rigid3" position="0 0 0 0 0 0 1  1 0 0 0 0 0 1" '
             'velocity="1 0 0 0 0 2  1 0 0 0.5 0 0"/><UniformMass totalMass="2"/></Node><Node name="two"><MechanicalObject name="dofs" '
             f'template="Rigid3" position="0 0 0 {numbers_of(turn)}  1 2 0 0 0 0 1" velocity="0 0 0 0 0.3 0  0 0 0 0 0 0"/>'
             '<UniformMass totalMass="2"/></Node><AttachProjectiveConstraint object1="@one/dofs" object2="@two/dofs" indices1="0 1" '
             'indices2="0 1" {}/>')
    way = axes_of(inverse(turn)) @ np.array([1, 2, 0]) / np.sqrt(5)
    axis = np.cross(way, [1, 0, 0])
    rest = turn_of(np.arccos(way[0]) * axis / np.linalg.norm(axis))
    ahead = turn_of(np.array([0, 0, 0.2]))
    for more, first, second in (("", ahead, turn_of(np.array([0.05, 0, 0]))), ('restRotations="1"', product(ahead, rest), None),
                                ('freeRotations="1"', product(turn_of(np.array([0, 0.03, 0])), turn), np.array([0, 0, 0, 1.0])),
                                ('lastFreeRotation="1"', ahead, np.array([0, 0, 0, 1.0])),
                                ('lastFreeRotation="1" lastPos="0.5 0 0" lastDir="1 0 0" clamp="1"',
                                 product(turn_of(np.array([0, 0.03, 0])), turn), turn_of(np.array([0.05, 0, 0])))):
        run = Run(root(scene.format(more), 'gravity="0 0 0"'), 10)
        two = run.x("two.dofs", 7)
        agree(two[0, :3], [0.1, 0, 0])
        agree(two[1, :3], [0.5 if "clamp" in more else 1.1, 0, 0])
        second = turn_of(np.array([0.05, 0, 0])) if second is None else second
        for k, q in enumerate((first, second)):
            agree(two[k, 3:] * np.sign(two[k, 6]), q * np.sign(q[3]))


@case
def forces_of_constraint_have_the_directions_of_the_free_motion():
    """One round: J where bodies have come to without these forces. Rods by lengths that a mapping measures, and a point that slides
    along a line that moves."""
    def rods(x):
        J, g = np.zeros((2, 21)), np.zeros(2)
        for row, (i, j) in enumerate(((1, 2), (2, 3))):
            e = x[j] - x[i]
            length = np.linalg.norm(e)
            J[row, 3 * j:3 * j + 3], J[row, 3 * i:3 * i + 3] = e / length, -e / length
            g[row] = length - np.linalg.norm(SWINGING[0][j] - SWINGING[0][i])
        return J, g

    def slide(x):
        along = x[3] - x[2]
        u = along / np.linalg.norm(along)
        share = (x[4] - x[2]) @ u / np.linalg.norm(along)
        n = x[4] - x[2] - u * ((x[4] - x[2]) @ u)
        n /= np.linalg.norm(n)
        J, g = np.zeros((2, 21)), np.zeros(2)
        for row, way in enumerate((n, np.cross(n, u))):
            J[row, 12:15], J[row, 6:9], J[row, 9:12] = way, -(1 - share) * way, -share * way
            g[row] = (x[4] - share * x[3] - (1 - share) * x[2]) @ way
        return J, g
    measured = ('<Node name="lengths"><MeshTopology name="net" position="@../one/dofs.position" edges="1 2  2 3"/><MechanicalObject name="y" '
                'template="Vec1"/><DistanceMapping topology="@net" input="@../one/dofs" output="@y"/><UniformLagrangianConstraint/></Node>')
    slides = '<SlidingLagrangianConstraint object1="@two/dofs" object2="@one/dofs" sliding_point="0" axis_1="2" axis_2="3"/>'
    for rows, text, apart in ((rods, measured, 0), (slide, slides, np.array([-0.4, -0.2, 0.1]))):
        x, v, mass, lists = both_bodies(apart)
        free = list(range(3, 21))
        for _ in range(15):
            A, b = damped_system(x, v, mass, lists)
            inverse_A = np.zeros((21, 21))
            inverse_A[3:, 3:] = np.linalg.inv(A[np.ix_(free, free)])
            v = v + (inverse_A @ b).reshape(-1, 3)
            x = x + 0.01 * v
            J, g = rows(x)
            dx = (inverse_A @ J.T @ np.linalg.solve(J @ inverse_A @ J.T, -g)).reshape(-1, 3)
            x, v = x + dx, v + dx / 0.01
        scene = two_bodies(text + "<LinearSolverConstraintCorrection/>", DAMPED_SOLVERS[1], apart, FREE_LOOP)
        run = Run(scene, 15)
        agree(np.vstack([run.x("bodies.one.dofs"), run.x("bodies.two.dofs")]), x, 1e-8)
        run = Run(scene, 15, args=["--without-quirk", "one-iteration"])
        differ(np.vstack([run.x("bodies.one.dofs"), run.x("bodies.two.dofs")]), x, 1e-4)


@case
def lengths_that_stay_at_rest():
    """constrainToRestPos: what a mapping measures stays what it is at rest; nothing is at zero then."""
    text = ('<MechanicalObject name="dofs" position="0 0 0  1 0 0  2 0.1 0"/><UniformMass totalMass="3"/><FixedProjectiveConstraint indices="0"/>'
            '<LinearSolverConstraintCorrection/><Node name="lengths"><MeshTopology name="net" position="@../dofs.position" edges="0 1  1 2"/>'
            '<MechanicalObject name="y" template="Vec1"/><DistanceMapping topology="@net" computeDistance="true" applyRestPosition="true"/>'
            '<UniformLagrangianConstraint constrainToRestPos="true"/></Node>')
    x = Run(root(FREE_LOOP + f'<Node name="rods">{EXACT}{text}</Node>'), 10).x("rods.dofs")
    agree(np.linalg.norm(x[1:] - x[:-1], axis=1), [1, np.sqrt(1.01)], 1e-4)
    assert x[2, 1] < 0.06, x


@case
def meshes_that_link_to_a_state_that_follows():
    """The positions of the mesh are those of the state beside it, which a mapping places: SOFA counts the nodes that cells name."""
    chain = ('<MechanicalObject name="m" position="0 0 0  1 0 0  2 0 0  3 0 1"/><UniformMass totalMass="4"/><FixedProjectiveConstraint '
             'indices="0"/>')
    given = Run(root(EXACT + chain + '<SpringForceField spring="1 2 50 1 1  2 3 50 1 1.41421356237309515"/>'), 12).x("m")
    for links in ('<MeshTopology position="@s.position" edges="0 1  1 2"/>', '<EdgeSetTopologyContainer name="t" edges="0 1  1 2" '
                  'position="@s.position"/>'):
        run = Run(root(EXACT + chain + '<Node name="part"><MechanicalObject name="s"/><SubsetMapping indices="1 2 3"/>' + links +
                       '<SpringForceField spring="0 1 50 1 1  1 2 50 1 1.41421356237309515"/></Node>'), 12)
        agree(run.x("m"), given)
    frames = ('<MechanicalObject name="m" template="Rigid3" position="0 0 0 0 0 0 1  1 0 0 0 0 0 1"/><UniformMass totalMass="2"/>'
              '<FixedProjectiveConstraint indices="0"/>{}')
    beam = '<BeamFEMForceField radius="0.1" youngModulus="1e4" poissonRatio="0.3"/>'
    there = Run(root(EXACT + frames.format('<MeshTopology edges="0 1"/>' + beam)), 12).x("m", 7)
    part = ('<Node name="part"><MechanicalObject name="s" template="Rigid3"/><SubsetMultiMapping template="Rigid3,Rigid3" input="@../m" '
            f'output="@s" indexPairs="0 0  0 1"/><MeshTopology edges="0 1" position="@s.position"/>{beam}</Node>')
    agree(Run(root(EXACT + frames.format(part)), 12).x("m", 7), there)


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
        agree(run.x("dofs", 7)[0], np.r_[x, q * np.sign(q[3])])


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
            agree(run.x(f"b{k}.dofs", 7)[0], np.r_[x[k], q[k] * np.sign(q[k][3])], 1e-8)


@case
def normals_of_edges_that_lag():
    """p_intensity along the normals of the evaluation before; lengths are those of as many edges of the mesh, from the first on."""
    X = np.array([[0, 0, 0], [1, 0.1, 0], [1.3, 0.9, 0.1], [0.1, 1.4, 0.05]])
    edges, h = [(0, 1), (1, 2), (2, 3), (3, 0), (0, 2)], 0.01
    third = {1: 0, 3: 2}
    for words, across in (("", None), ('binormal="0 0.2 1"', np.array([0, 0.2, 1]) / np.linalg.norm([0, 0.2, 1]))):
        def forces(x):
            found = []
            for i, e in enumerate(third):
                a, b = edges[e]
                t = (x[b] - x[a]) / np.linalg.norm(x[b] - x[a])
                n = np.cross([0, 0, 1] if across is None else across, t)
                if across is None:
                    n = -n if n @ (x[third[e]] - x[a]) < 0 else n
                else:
                    n /= np.linalg.norm(n)
                first = edges[i]
                found.append(20 * n * np.linalg.norm(X[first[1]] - X[first[0]]))
            return found
        x, v, known = X.copy(), np.zeros_like(X), forces(X)
        for _ in range(20):
            f = -30 * (x - X)
            for force, e in zip(known, third):
                for end in edges[e]:
                    f[end] += force / 2
            known = forces(x)
            f[0] = 0
            dv = (h * (f - 30 * h * v)) / (0.5 + 30 * h * h)
            dv[0] = 0
            v = v + dv
            x = x + h * v
        scene = node(EXACT + f'<MeshTopology position="{numbers_of(X)}" edges="0 1  1 2  2 3  3 0  0 2" triangles="0 1 2  0 2 3"/><MechanicalObject '
                     'name="dofs"/><UniformMass vertexMass="0.5"/><FixedProjectiveConstraint indices="0"/><RestShapeSpringsForceField points='
                     f'"1 2 3" stiffness="30"/><EdgePressureForceField edgeIndices="1 3" p_intensity="20" {words}/>')
        agree(Run(scene, 20).x(), x)
        differ(Run(scene, 20, args=["--without-quirk", "late-times"]).x(), x, 1e-4)


@case
def bodies_whose_nodes_answer_constraints_one_by_one():
    """UncoupledConstraintCorrection leaves the matrix out: nodes move by their compliance times the force on them, and frames by their
    masses and inertias, in fixed axes."""
    J = np.zeros((3, 21))
    J[:, 9:12], J[:, 12:15] = np.eye(3), -np.eye(3)
    for corrections, compliances in ((("<UncoupledConstraintCorrection/>", "<UncoupledConstraintCorrection/>"), (1e-5, [1e-5] * 3)),
                                     (("<LinearSolverConstraintCorrection/>", '<UncoupledConstraintCorrection defaultCompliance="0.7"/>'),
                                      (None, [0.7] * 3)),
                                     (("<LinearSolverConstraintCorrection/>", '<UncoupledConstraintCorrection compliance="0.2 3 4"/>'),
                                      (None, [0.2, 3, 4]))):
        x, v, mass, lists = both_bodies(np.array([0.1, 0.05, -0.1]))
        for _ in range(15):
            A, b = damped_system(x, v, mass, lists)
            C = np.zeros((21, 21))
            C[3:, 3:] = np.linalg.inv(A[3:, 3:])
            v = v + (C @ b).reshape(-1, 3)
            x = x + 0.01 * v
            if compliances[0]:
                C[:12, :12] = 0
                C[range(3, 12), range(3, 12)] = compliances[0]
            C[12:, 12:] = np.diag(np.repeat(compliances[1], 3))
            dx = (C @ J.T @ np.linalg.solve(J @ C @ J.T, -J @ x.ravel())).reshape(-1, 3)
            x, v = x + dx, v + dx / 0.01
        scene = two_bodies('<BilateralLagrangianConstraint object1="@one/dofs" object2="@two/dofs" first_point="3" second_point="0"/>',
                           DAMPED_SOLVERS[1], np.array([0.1, 0.05, -0.1]), FREE_LOOP)
        scene = scene.replace('indices="0"/></Node>', f'indices="0"/>{corrections[0]}</Node>')
        scene = scene.replace(springs_of(HANGING_SPRINGS), springs_of(HANGING_SPRINGS) + corrections[1])
        run = Run(scene, 15)
        agree(np.vstack([run.x("bodies.one.dofs"), run.x("bodies.two.dofs")]), x)
    run = Run(scene, 15, args=["--without-quirk", "one-iteration"])
    differ(run.x("bodies.two.dofs"), x[4:], 1e-3)
    # a frame and a point at the end of its arm
    inertia, arm, h = np.array([0.3, 0.5, 0.4]), np.array([0.6, 0.2, -0.1]), 0.01
    c, q, u, p, s = np.zeros(3), turn_of(np.array([0.2, -0.1, 0.3])), np.array([0.3, 0, -0.2, 0.5, -1, 0.4]), np.array([0.8, 0.1, 0]), np.zeros(3)
    for _ in range(15):
        u[1], s = u[1] - 10 * h, s - [0, 10 * h, 0]
        c, q, p = c + h * u[:3], product(turn_of(h * u[3:]), q), p + h * s
        r = axes_of(q) @ arm
        J = np.hstack([np.eye(3), -np.array([[0, -r[2], r[1]], [r[2], 0, -r[0]], [-r[1], r[0], 0]]), -np.eye(3)])
        C = np.diag(np.r_[[0.5] * 3, 1 / inertia, [0.25] * 3])
        d = C @ J.T @ np.linalg.solve(J @ C @ J.T, -(c + r - p))
        c, q, p = c + d[:3], product(turn_of(d[3:6]), q), p + d[6:]
        u, s = u + d[:6] / h, s + d[6:] / h
    run = Run(root(FREE_LOOP + f'<Node name="frame">{EXACT}<MechanicalObject name="dofs" template="Rigid3" position="0 0 0 '
                   f'{numbers_of(turn_of(np.array([0.2, -0.1, 0.3])))}" velocity="0.3 0 -0.2 0.5 -1 0.4"/><UniformMass vertexMass="2 1 0.15 0 0 0 '
                   '0.25 0 0 0 0.2"/><UncoupledConstraintCorrection/><Node name="arm"><MechanicalObject name="dofs" position='
                   f'"{numbers_of(arm)}"/><RigidMapping/></Node></Node><Node name="point">{EXACT}<MechanicalObject name="dofs" position="0.8 0.1 0"/>'
                   '<UniformMass totalMass="1"/><UncoupledConstraintCorrection compliance="0.25"/></Node><BilateralLagrangianConstraint '
                   'object1="@frame/arm/dofs" object2="@point/dofs" first_point="0" second_point="0"/>'), 15)
    agree(run.x("frame.dofs", 7)[0], np.r_[c, q * np.sign(q[3])], 1e-8)
    agree(run.x("point.dofs")[0], p, 1e-8)


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
def states_of_another_number_of_nodes_than_they_follow():
    """IdentityMapping gives its state the nodes that it follows, whatever the scene says of it."""
    chain = ('<MechanicalObject name="m" position="0 0 0  1 0 0  2 0 0  3 0 1"/><UniformMass totalMass="4"/><FixedProjectiveConstraint '
             'indices="0"/>{}')
    springs_here = '<SpringForceField spring="0 1 50 1 1  1 2 50 1 1  2 3 50 1 1"/>'
    given = Run(root(EXACT + chain.format(springs_here)), 12).x("m")
    for position in ('position="0 0 0"', 'position="7 7 7  8 8 8"', 'size="6"'):
        part = f'<Node name="part"><MechanicalObject name="s" {position}/><IdentityMapping/>{springs_here}</Node>'
        run = Run(root(EXACT + chain.format(part)), 12)
        agree(run.x("m"), given)
        agree(run.x("part.s"), given)


@case
def the_page_has_a_picture_of_each_quirk():
    """The names in the table, and those in the titles of the pictures, are those that the program knows."""
    said = Run(root(EXACT + BODY), 1, args=["--without-quirk", "none-such"]).text
    known = sorted(re.search(r"expected one of: ([a-z, -]+)", said)[1].split(", "))
    tutorials = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "docs", "tutorials")
    with open(os.path.join(tutorials, "sofa.md"), encoding="utf-8") as file:
        page = file.read()
    assert sorted(re.findall(r"(?m)^\| `([a-z-]+)` \|", page)) == known
    drawn = []
    for picture in re.findall(r"!\[[^]]+\]\((quirks/\d+\.png)\)", page):
        with open(os.path.join(tutorials, picture), "rb") as file:
            chunks = file.read()
        at = chunks.index(b"tEXtTitle\0")
        drawn += chunks[at + 10:at + 4 + int.from_bytes(chunks[at - 4:at], "big")].decode().split()
    assert sorted(drawn) == known, "docs/plots/quirk_pictures.py draws them"


@case
def loaders_of_one_file_of_a_sequence():
    """OffSequenceLoader: of one file a loader as others. Of more, whose next is read in a run, none where something moves."""
    files = {"m1.off": "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", "m2.off": "OFF\n3 1 0\n0 0 0\n2 0 0\n0 2 0\n3 0 1 2\n"}
    loader = '<OffSequenceLoader name="m" filename="m1.off" stepDuration="0.02" {}/>'
    body = f'{EXACT}<MeshTopology src="@m"/><MechanicalObject name="dofs"/><UniformMass totalMass="1"/>'
    for count in ("", 'nbOfFiles="1"'):
        run = Run(root(loader.format(count) + body), 10, files)
        agree(run.x(), [[0, fallen(10), 0], [1, fallen(10), 0], [0, 1 + fallen(10), 0]])
    Run(root(loader.format('nbOfFiles="2"') + body), 10, files).fails(2, "m.nbOfFiles", "SOFA reads another file after stepDuration")
    apart = Run(root(loader.format('nbOfFiles="2"') + f'<Node name="b">{EXACT}{BODY}</Node>'), 10, files)
    falls(apart, "b.dofs")
    apart.says("/m")


@case
def what_has_no_effect_in_sofa_says_why():
    """ReadTopology, and models of cylinders and of tetrahedra, which SOFA's points with normals alone meet."""
    cells = '<MeshTopology position="0 0 0  1 0 0  0 1 0  0 0 1" tetrahedra="0 1 2 3"/>'
    ball = f'<Node name="a">{EXACT}{cells}<MechanicalObject name="dofs"/><UniformMass totalMass="1"/>{{}}</Node>'
    other = (f'<Node name="b">{EXACT}<MechanicalObject name="dofs" position="0.1 0.1 0.1  9 0 0"/><UniformMass totalMass="2"/>'
             '<PointCollisionModel {}/></Node>')
    detect = ('<CollisionPipeline/><BruteForceBroadPhase/><BVHNarrowPhase/><CollisionResponse response="PenalityContactForceField"/>'
              '{}')
    alone = Run(root(ball.format('<ReadTopology filename="none.data"/>')), 10)
    agree(alone.x("a.dofs")[0], [0, fallen(10), 0])
    alone.says("a/ReadTopology1: has no effect because SOFA reads its file into lists")
    Run(root(ball.format('<CylinderCollisionModel/>')), 1).says("has no effect because none of SOFA's own methods")

    def met(points, method, model=""):
        return Run(root(detect.format(method) + ball.format(f"<TetrahedronCollisionModel {model}/>") + other.format(points)), 1)
    says = "meets the points of /b/PointCollisionModel1 in SOFA"
    met('computeNormals="1"', "<DiscreteIntersection/>").fails(2, says)
    met('computeNormals="1"', "").fails(2, says)
    for quiet in (met("", "<DiscreteIntersection/>"), met('computeNormals="1" active="0"', "<DiscreteIntersection/>"),
                  met('computeNormals="1"', "<DiscreteIntersection/>", 'active="0"'),
                  met('computeNormals="1"', '<MinProximityIntersection alarmDistance="0.01" contactDistance="0.005"/>')):
        assert quiet.code == 0, quiet.text
        quiet.says("has no effect because SOFA's tetrahedra")


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
    run.says("rigidIndexPerPoint has 3 values for 2 points: it does not count, as in SOFA, and frame 1 carries all")
    wrong = node(EXACT + frames + child.format(rigid, "RigidRigidMapping", 'initialPoints="0.5 0 0 0 0 0 0"'))
    Run(wrong, 1).fails(2, "initialPoints: the quaternion of frame 0 has the length 0", "x y z w of length one")


@case
def links_that_lead_nowhere_name_what_is_near():
    """Each of several, and one that starts in the wrong place: file, line and path, and the link that is right."""
    state = '<MechanicalObject name="dofs" position="0 0 0"/><UniformMass totalMass="1"/>'
    bodies = f'<Node name="left">{state}</Node><Node name="right">{state}</Node>'
    both = bodies + ('<Node name="both"><MechanicalObject name="all" position="0 0 0 0 0 0"/>\n<SubsetMultiMapping name="m" '
                     'input="@../left/dofs {}" indexPairs="0 0  1 0"/></Node>')
    for wrong, near in (("@../rigth/dofs", "@../right/dofs"), ("@../right/dof", "@../right/dofs"), ("@../../right/dofs", "@/right/dofs"),
                        ("@/rihgt/dofs", "@/right/dofs")):
        run = Run(root(EXACT + both.format(wrong)), 1)
        line = next((each for each in run.text.splitlines() if "leads nowhere" in each), run.text)
        assert line.startswith("scene.scn:2:") and f"/both/m.input: the link '{wrong}' leads nowhere" in line and f"'{near}'" in line, line
    agree(Run(root(EXACT + both.format("@../right/dofs")), 10).x("both.all")[:, 1], [fallen(10)] * 2)
    roi = '<BoxROI name="fixed" box="-1 -1 -1 1 1 1"/>'
    Run(root(EXACT + BODY + roi + '<FixedProjectiveConstraint indices="@fixd.indices"/>'), 1).says("'@fixed.indices'")


@case
def templates_that_do_not_fit_are_told():
    """SOFA takes another template where the one that is written does not exist or does not fit the state, and so is it here."""
    body = '<MechanicalObject name="dofs" position="0 0 0  1 0 0"/><UniformMass totalMass="2" template="{}"/>'
    for template, words in (("Rigid3d", "is Rigid3, and /dofs has Vec3: SOFA takes the one that fits"), ("Vac3", "did you mean 'Vec3'?")):
        run = Run(root(EXACT + body.format(template)), 10)
        falls(run)
        run.says("scene.scn:1:", "/UniformMass1.template: ", words)
    solver = '<EulerImplicitSolver/><SparseLDLSolver template="{}"/>' + body.format("Vec3d")
    run = Run(root(solver.format("CompresedRowSparseMatrixd")), 10)
    falls(run)
    run.says("'CompresedRowSparseMatrixd' is no template", "did you mean 'CompressedRowSparseMatrix'?")
    for fine in ("CompressedRowSparseMatrixMat3x3d", "CompressedRowSparseMatrix<Mat3x3d>", "CompressedRowSparseMatrixd", "BTDMatrix6d"):
        assert "template" not in Run(root(solver.format(fine)), 1).text
    frames = '<MechanicalObject template="{}" name="dofs" position="0 0 0 0 0 0 1"/><UniformMass template="Rigid3d,Rigid3dMass"/>'
    assert ".template" not in Run(root(EXACT + frames.format("Rigid3d")), 1).text
    Run(root(EXACT + frames.format("Rgid3d")), 1).fails(2, "nodes of type Rgid3d do not exist here", "did you mean 'Rigid3'?")


@case
def one_position_beside_a_mesh():
    """A state takes the nodes of the mesh in its node unless more than one position is written."""
    mesh = '<MeshTopology position="0 1 0  2 1 0" edges="0 1"/><MechanicalObject name="dofs" position="5 5 5" {} scale="2" dx="1"/>'
    run = Run(node(EXACT + mesh.format("") + '<UniformMass totalMass="2"/>'), 1)
    agree(run.x(), [[1, 2, 0], [5, 2, 0]])
    run.says("/dofs.position: is one node: those of /MeshTopology1 count, as in SOFA")
    agree(Run(node(EXACT + mesh.format('useTopology="0"') + '<UniformMass totalMass="2"/>'), 1).x(), [[11, 10, 10]])
    rigid = mesh.replace('"5 5 5"', '"5 5 5 0 0 0 1"').format('template="Rigid3d"')
    agree(Run(node(EXACT + rigid + '<UniformMass totalMass="2"/>'), 1).x("dofs", 7), [[1, 2, 0, 0, 0, 0, 1], [5, 2, 0, 0, 0, 0, 1]])
    Run(node("<DefaultAnimationLop/>" + EXACT + BODY), 1).fails(2, "scene.scn:1:", "did you mean 'DefaultAnimationLoop'?")


@case
def capsules_and_boxes_of_old_scenes():
    """On a floor, each corner or end a spring k = k1 k2 / d0 as long as d0 - y > 0; d0 has a capsule's radius in it."""
    def pushed(springs, d0, y, h=0.01, m=2.0, g=10.0):
        k, v = springs * 100 / d0, 0.0
        for _ in range(8):
            assert d0 > y
            v += h * (k * (d0 - y) - m * g - h * k * v) / (m + h * h * k)
            y += h * v
        return y

    scene = ('<CollisionPipeline/><BruteForceDetection/><DefaultContactManager response="default"/>'
             '<{} alarmDistance="0.3" contactDistance="0.1"/><Node name="b">' + EXACT + '<MechanicalObject name="dofs" template="{}" '
             'position="{}"/><UniformMass totalMass="2"/>{}</Node><Node name="floor"><MeshTopology position="-9 0 -9  9 0 -9  9 0 9  -9 0 9" '
             'triangles="0 2 1  0 3 2"/><MechanicalObject/><TriangleCollisionModel simulated="0" moving="0"/></Node>')
    lying = "0 0.55 0 0 0 0.7071067811865476 0.7071067811865476"
    for method in ("NewProximityIntersection", "MinProximityIntersection"):
        for given in ('<CapsuleCollisionModel radii="0.5" heights="2"/>', '<RigidCapsuleModel name="c" defaultRadius="0.5"/>'):
            run = Run(root(scene.format(method, "Rigid3", lying, given)), 8)
            agree(run.x("b.dofs", 7)[0, :3], [0, pushed(2, 0.6, 0.55), 0], 1e-7)
            run.says("/b/c: is a line" if "name" in given else "/b/CapsuleCollisionModel1: is a line with a skin of its radius here")
        for given in ('<OBBCollisionModel extents="0.3 0.4 0.2"/>', '<OBBModel defaultExtent="0.4"/>'):
            agree(Run(root(scene.format(method, "Rigid3", "0 0.496 0 0 0 0 1", given)), 8).x("b.dofs", 7)[0, :3],
                  [0, pushed(4, 0.1, 0.096) + 0.4, 0], 1e-7)
    two = ('<Node name="a">' + EXACT + '<MechanicalObject name="dofs" template="Rigid3" position="-3 0.55 0 0 0 0 1  3 0.2 0 0 0 0 1"/>'
           '<UniformMass totalMass="4"/><CapsuleModel radii="0.5 0.15" heights="0 0"/></Node>')
    pair = Run(root(scene.format("NewProximityIntersection", "Rigid3", "0 50 0 0 0 0 1", "") + two), 8).x("a.dofs", 7)
    agree(pair[:, 1], [pushed(2, 0.6, 0.55), pushed(2, 0.25, 0.2)], 1e-7)  # of no height: both ends are in one place
    points = ('<MeshTopology edges="0 1"/><CapsuleCollisionModel template="Capsule" defaultRadius="0.5"/>')
    fallen_line = Run(root(scene.format("NewProximityIntersection", "Vec3", "-1 0.55 0  1 0.55 0", points)), 8).x("b.dofs")
    agree(fallen_line[:, 1], [pushed(2, 0.6, 0.55)] * 2, 1e-7)
    several = points.replace('defaultRadius="0.5"', 'name="c" listCapsuleRadii="0.5 0.4"')
    several = Run(root(scene.format("NewProximityIntersection", "Vec3", "-1 0.55 0  1 0.55 0", several)), 8)
    agree(several.x("b.dofs")[:, 1], [pushed(2, 0.6, 0.55)] * 2, 1e-7)
    several.says("/b/c: has lines of several radii: all have the first one here, 0.5")
    assert "several radii" not in Run(root(scene.format("NewProximityIntersection", "Vec3", "-1 0.55 0  1 0.55 0", points)), 1).text


main()
