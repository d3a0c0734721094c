# SPDX-License-Identifier: LGPL-2.1-or-later
"""Scenes in SOFA's dialect: components and attributes that no other of these files has a number for. Usage:
test_dialect_sentences.py STROMA [WORD]"""
import itertools

import numpy as np

from dialect import CUBE, EXACT, Run, agree, case, differ, fallen, falls, main, node, numbers_of, oriented, placed, root
from reference import axes_of, euler, gravity, hexahedra, membrane, of_rest, of_springs, springs, tetrahedra, together, turn_of

CHAIN = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [2.5, 0.5, 0.2]])
CHAIN_TEXT = (f'<MeshTopology position="{numbers_of(CHAIN)}" edges="0 1  1 2  2 3"/><MechanicalObject name="dofs"/>'
              '<UniformMass totalMass="4"/><MeshSpringForceField stiffness="500"/><FixedConstraint indices="0"/>')
LINKS = [(0, 1), (1, 2), (2, 3)]


@case
def the_first_matrix_for_ever():
    """PrecomputedLinearSolver: dv of each step by the inverse of the first step's matrix."""
    x, v, h = CHAIN.copy(), np.zeros_like(CHAIN), 0.01
    fields, kept = together(gravity(np.ones(4), [0, -10, 0]), springs(LINKS, CHAIN, 500)), None
    for _ in range(20):
        f, K = fields(x, v)
        if kept is None:
            kept = np.linalg.inv((np.eye(12) - h * h * K)[3:, 3:])
        v[1:] += (kept @ (h * (f.ravel() + h * K @ v.ravel()))[3:]).reshape(-1, 3)
        x = x + h * v
    run = Run(root('<EulerImplicitSolver/><PrecomputedLinearSolver/>' + CHAIN_TEXT), 20)
    agree(run.x(), x, 1e-9)


@case
def orderings_and_places_of_matrices():
    x = euler(CHAIN, np.eye(4), together(gravity(np.ones(4), [0, -10, 0]), springs(LINKS, CHAIN, 500)), 10, 0.01, held=[0])
    for solvers in ('<COLAMDOrderingMethod name="o"/><EigenSparseLU orderingMethod="@o" parallelInverseProduct="1"/>',
                    '<NaturalOrderingMethod name="o"/><EigenSimplicialLLT template="CompressedRowSparseMatrix" orderingMethod="@o"/>',
                    '<ConstantSparsityPatternSystem name="s" template="CompressedRowSparseMatrixMat3x3"/><SparseLDLSolver '
                    'linearSystem="@s" template="CompressedRowSparseMatrixMat3x3"/>',
                    '<BTDLinearSolver template="BTDMatrix6d" verification="0"/>'):
        agree(Run(root("<EulerImplicitSolver/>" + solvers + CHAIN_TEXT), 10).x(), x, 1e-9)


@case
def springs_across_two_quads():
    """QuadularBendingSprings: two springs for an edge of two quads, of the stiffness as it is, between the nodes opposite."""
    X = np.array([[i, j, 0.1 * i * j] for j in range(2) for i in range(3)], float)
    scene = root(EXACT + f'<MeshTopology position="{numbers_of(X)}" quads="0 1 4 3  1 2 5 4"/><MechanicalObject name="dofs"/>'
                 '<UniformMass totalMass="6"/><QuadularBendingSprings stiffness="200" damping="0"/><FixedConstraint indices="0 1"/>')
    fields = together(gravity(np.ones(6), [0, -10, 0]), springs([(0, 2), (3, 5)], X, 200, per_length=False))
    agree(Run(scene, 10).x(), euler(X, np.eye(6), fields, 10, 0.01, held=[0, 1]), 1e-8)


def towards(targets, k):
    """Springs on the distances of nodes to places that stay, all of their tangent."""
    def field(x, v):
        f, K = np.zeros_like(x), np.zeros((x.size, x.size))
        for i, (target, length) in targets.items():
            way = x[i] - target
            d = np.linalg.norm(way)
            n, t = way / d, k * (d - length)
            f[i] -= t * n
            at = slice(3 * i, 3 * i + 3)
            K[at, at] -= k * np.outer(n, n) + t / d * (np.eye(3) - np.outer(n, n))
        return f, K
    return field


@case
def distances_to_places():
    X = np.array([[0, 0, 0], [1, 0.2, 0], [2, 0, 0.3]])
    targets = {1: (np.array([1.0, 2, 0]), 1.0), 2: (np.array([3.0, 0, 1]), 2.0)}
    scene = root(EXACT + f'<MechanicalObject name="dofs" position="{numbers_of(X)}"/><UniformMass totalMass="3"/><Node name="y">'
                 '<MechanicalObject template="Vec1"/><DistanceFromTargetMapping indices="1 2" targetPositions="1 2 0  3 0 1" '
                 'restLengths="1 2" geometricStiffness="Exact"/><RestShapeSpringsForceField stiffness="80"/></Node>')
    fields = together(gravity(np.ones(3), [0, -10, 0]), towards(targets, 80))
    agree(Run(scene, 10).x(), euler(X, np.eye(3), fields, 10, 0.01), 1e-8)


@case
def masses_of_some_nodes():
    """indices, or localRange from the first to the last, share totalMass; the others have none, and no weight."""
    X = np.array([[i, 0, 0] for i in range(4)], float)
    for chosen in ('indices="1 2"', 'localRange="1 2"'):
        scene = root(EXACT + f'<MechanicalObject name="dofs" position="{numbers_of(X)}"/><UniformMass totalMass="3" {chosen}/>'
                     '<RestShapeSpringsForceField stiffness="100"/>')
        mass = np.diag([0, 1.5, 1.5, 0])
        field = together(gravity(np.diag(mass), [0, -10, 0]), lambda x, v: (-100 * (x - X), -100 * np.eye(12)))
        agree(Run(scene, 10).x(), euler(X, mass, field, 10, 0.01), 1e-9)


@case
def tubes_around_frames():
    """Edge2QuadTopologicalMapping and TubularMapping: circles in the yz planes of the frames, and quads between two of them."""
    turned = turn_of(np.array([0, 0, np.pi / 2]))
    places = f"0 0 0 0 0 0 1  2 0 0 {numbers_of(turned)}"
    scene = node(EXACT + f'<MeshTopology name="line" position="0 0 0  2 0 0" edges="0 1"/><MechanicalObject template="Rigid3" name="dofs" '
                 f'position="{places}"/><UniformMass totalMass="1"/><Node name="tube"><QuadSetTopologyContainer name="quads"/>'
                 '<Edge2QuadTopologicalMapping nbPointsOnEachCircle="4" radius="0.5" input="@../line" output="@quads"/>'
                 '<MechanicalObject name="skin"/><TubularMapping nbPointsOnEachCircle="4" radius="0.5"/></Node>')
    x = Run(scene, 1).x("tube.skin")
    assert x.shape == (8, 3), x
    agree(np.linalg.norm(x[:4], axis=1), np.full(4, 0.5))
    agree(1 + x[:4, 0], np.ones(4))  # across the first frame's x axis
    agree(np.linalg.norm(x[4:] - [2, 0, 0], axis=1), np.full(4, 0.5))
    agree(1 + x[4:, 1], np.ones(4))  # the second one's x axis is y
    agree(np.linalg.norm(np.roll(x[:4], 1, axis=0) - x[:4], axis=1), np.full(4, 0.5 * np.sqrt(2)))


@case
def springs_on_the_rim_of_a_surface():
    """Triangle2EdgeTopologicalMapping: the edges of one triangle; constants are over their lengths."""
    X = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0.5, 0.3]])
    triangles = [(0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)]
    cells = " ".join(str(i) for triangle in triangles for i in triangle)
    scene = root(EXACT + f'<MeshTopology name="net" position="{numbers_of(X)}" triangles="{cells}"/>'
                 '<MechanicalObject name="dofs"/><UniformMass totalMass="5"/><FixedConstraint indices="0"/><Node name="rim">'
                 '<EdgeSetTopologyContainer name="edges"/><EdgeSetTopologyModifier/><Triangle2EdgeTopologicalMapping input="@../net" '
                 'output="@edges"/><MeshSpringForceField stiffness="300"/></Node>')
    fields = together(gravity(np.ones(5), [0, -10, 0]), springs([(0, 1), (1, 2), (2, 3), (3, 0)], X, 300))
    agree(Run(scene, 10).x(), euler(X, np.eye(5), fields, 10, 0.01, held=[0]), 1e-8)


@case
def hollow_beams():
    """radiusInner: A = pi (r^2 - r_i^2), I = pi (r^4 - r_i^4)/4. A cantilever of one beam in statics: u = F L/(E A), w = P L^3/(3 E I)."""
    r, inner, E, L, F, P = 0.1, 0.06, 2e6, 2.0, 3.0, 0.5
    area, inertia = np.pi * (r**2 - inner**2), np.pi * (r**4 - inner**4) / 4
    scene = node('<StaticSolver/><NewtonRaphsonSolver maxNbIterationsNewton="20"/><SparseLDLSolver/><MechanicalObject template="Rigid3" '
                 f'name="dofs" position="0 0 0 0 0 0 1  {L} 0 0 0 0 0 1"/><MeshTopology edges="0 1"/><FixedConstraint indices="0"/>'
                 f'<BeamFEMForceField radius="{r}" radiusInner="{inner}" youngModulus="{E}" poissonRatio="0.3"/>'
                 f'<ConstantForceField indices="1" forces="{{}} 0 0 0"/>')
    along = Run(scene.format(f"{F} 0 0"), 1).x(width=7)[1]
    agree(along[0] - L, F * L / (E * area), 1e-6)
    across = Run(scene.format(f"0 0 {P}"), 1).x(width=7)[1]
    agree(across[2], P * L**3 / (3 * E * inertia), 1e-3)


@case
def prefab_of_a_plane():
    """PlaneConstraint is a PlaneROI and what holds its nodes: a file of SOFA, and not the component of this name here."""
    prefab = ('<Node name="Group"><PlaneROI name="roi" plane="0 0 0  1 0 0  1 1 0  0.1" /><FixedProjectiveConstraint '
              'indices="@roi.indices"/></Node>')
    scene = root(EXACT + '<MechanicalObject name="dofs" position="0.2 0.1 0  0.2 0.1 3"/><UniformMass totalMass="2"/>'
                 '<PlaneConstraint plane="-1 -1 0  1 -1 0  1 1 0  0.1"/>')
    run = Run(scene, 10, {"Objects/PlaneConstraint.xml": prefab})
    agree(run.x()[:, 1], [0.1, 0.1 + fallen(10)])


@case
def solvers_of_constraints_that_links_name():
    """Links from loops and corrections, relative and by name, change nothing."""
    body = ('<Node name="body"><EulerImplicitSolver name="ode"/><SparseLDLSolver name="ldl"/><MechanicalObject name="dofs" position='
            '"0 0 0  1 0 0"/><UniformMass totalMass="2"/><FixedLagrangianConstraint indices="0"/><LinearSolverConstraintCorrection {}/>'
            '</Node>')
    for loop in ('<FreeMotionAnimationLoop constraintSolver="@solver"/>', '<FreeMotionAnimationLoop constraintSolver="@./solver"/>'):
        for link in ("", 'linearSolver="@ldl" ODESolver="@ode"', 'linearSolver="@./ldl" constraintSolvers="@../solver"'):
            scene = root(loop + '<GenericConstraintSolver name="solver" tolerance="1e-12" maxIterations="100"/>' + body.format(link))
            run = Run(scene, 10)
            agree(run.x("body.dofs")[:, 1], [0, fallen(10)], 1e-8)


@case
def a_net_of_lines_that_meets_itself_or_not():
    """Models of one node meet with selfCollision="1" alone."""
    models = ('<CollisionPipeline/><BruteForceBroadPhase/><BVHNarrowPhase/><MinProximityIntersection alarmDistance="0.5" '
              'contactDistance="0.2"/><CollisionResponse response="PenalityContactForceField"/>')
    two = ('<Node name="body"><MeshTopology edges="0 1  2 3"/><MechanicalObject name="dofs" position="0 0 0  1 0 0  0.5 0.1 -0.5  '
           '0.5 0.1 0.5"/><UniformMass totalMass="4"/><LineCollisionModel {} contactStiffness="100"/></Node>')
    falls(Run(root(models + EXACT + two.format("")), 5), "body.dofs", 5, start=[0, 0, 0.1, 0.1])
    x = Run(root(models + EXACT + two.format('selfCollision="1"')), 5).x("body.dofs")
    assert x[2, 1] > 0.1 and x[0, 1] < fallen(5), x


@case
def sparse_grids_without_boundary():
    """onlyInsideCells: of a cube of 4 x 4 x 4 cells whose surface runs through the outer ones the inner 2 x 2 x 2 are left."""
    corners = [(x, y, z) for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)]
    quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    surface = (f'<MeshTopology name="surface" position="{numbers_of(corners)}" quads="{" ".join(str(i) for q in quads for i in q)}"/>')
    for only, nodes in (("0", 125), ("1", 27)):
        run = Run(root(EXACT + surface + f'<Node name="grid"><SparseGridTopology n="5 5 5" min="-1.2 -1.2 -1.2" max="1.2 1.2 1.2" '
                       f'position="@../surface.position" quads="@../surface.quads" onlyInsideCells="{only}"/>'
                       '<MechanicalObject name="dofs"/><UniformMass vertexMass="1"/></Node>'), 1)
        assert len(run.x("grid.dofs")) == nodes, (only, len(run.x("grid.dofs")))


@case
def rigid_masses_of_a_file():
    """mass, volm and inrt of a file: the angular mass is mass times inrt. A torque about z turns by h tau/(m I_z) per step."""
    text = "Xsp 3.0\nmass 2.5\nvolm 10\ninrt 1 0 0 0 2 0 0 0 4\ncntr 0 0 0\n"
    scene = node(EXACT + '<MechanicalObject template="Rigid3" name="dofs" position="0 0 0 0 0 0 1"/><UniformMass filename="body.rigid"/>'
                 '<ConstantForceField indices="0" forces="5 0 0 0 0 3"/>')
    x = Run(scene, 1, {"body.rigid": text}).x(width=7)[0]
    agree(x[0], 1e-4 * 5 / 2.5)
    agree(x[3:], turn_of(np.array([0, 0, 1e-4 * 3 / (2.5 * 4)])), 1e-12)


@case
def a_density_that_a_mass_names():
    """Of two densities of nodes the one that is linked: a tetrahedron by one point has rho V/16 for each pair, rho the mean."""
    X = np.array([[0, 0, 0], [2, 0, 0], [0, 3, 0], [0, 0, 1.5]])
    scene = root(EXACT + f'<MeshTopology position="{numbers_of(X)}" tetrahedra="0 1 2 3"/><MechanicalObject name="dofs"/>'
                 '<NodalMassDensity name="one" property="50"/><NodalMassDensity name="two" property="1 3 5"/>'
                 '<FEMMass template="Vec3,Tetrahedron" nodalMassDensity="@two"/><RestShapeSpringsForceField stiffness="100 200 300 400" '
                 'points="0 1 2 3"/>')
    mass = np.full((4, 4), (1 + 3 + 5 + 5) / 4 * 1.5 / 16)
    stiff = np.repeat([100.0, 200, 300, 400], 3)
    fields = together(gravity(mass.sum(axis=1), [0, -10, 0]), lambda x, v: (-(stiff * (x - X).ravel()).reshape(-1, 3), -np.diag(stiff)))
    agree(Run(scene, 10).x(), euler(X, mass, fields, 10, 0.01), 1e-8)


@case
def cells_on_the_boundary_count_half():
    """fillWeighted of a SparseGridTopology: the only cell is one of the boundary, with half of the stiffness; without it the whole."""
    corners = [(x, y, z) for z in (0.1, 0.9) for y in (0.1, 0.9) for x in (0.1, 0.9)]
    quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    surface = f'<MeshTopology name="surface" position="{numbers_of(corners)}" quads="{" ".join(str(i) for q in quads for i in q)}"/>'
    X = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)  # sorted by x, then y, then z
    for flag, factor in (("true", 0.5), ("false", 1)):
        scene = root(EXACT + surface + f'<Node name="grid"><SparseGridTopology n="2 2 2" min="0 0 0" max="1 1 1" fillWeighted="{flag}" '
                     'position="@../surface.position" quads="@../surface.quads"/><MechanicalObject name="dofs"/><UniformMass '
                     'vertexMass="1"/><HexahedronFEMForceField youngModulus="3000" poissonRatio="0.3" method="polar"/>'
                     '<FixedConstraint indices="0 1 2 3"/></Node>')
        cells = [(0, 4, 6, 2, 1, 5, 7, 3)]
        fields = together(gravity(np.ones(8), [0, -10, 0]), hexahedra(cells, X, 3000 * factor, 0.3))
        agree(Run(scene, 10).x("grid.dofs"), euler(X, np.eye(8), fields, 10, 0.01, held=[0, 1, 2, 3]), 1e-6)


@case
def ties_of_points_know_no_tolerance_of_their_own():
    """numericalTolerance of a BilateralLagrangianConstraint between points: they hold as far as the solver goes."""
    bodies = "".join(f'<Node name="{name}">{EXACT}<MechanicalObject name="dofs" position="{x} 0 0" velocity="0 {v} 0"/><UniformMass '
                     f'totalMass="{m}"/><LinearSolverConstraintCorrection/></Node>' for name, x, v, m in (("a", 0, 1, 1), ("b", 1, -2, 3)))
    tie = ('<BilateralLagrangianConstraint object1="@a/dofs" object2="@b/dofs" first_point="0" second_point="0" rest_vector="1 0 0" '
           'numericalTolerance="0.5"/>')
    loop = '<FreeMotionAnimationLoop/><GenericConstraintSolver tolerance="1e-12" maxIterations="1000"/>'
    run = Run(root(loop + bodies + tie), 10)
    fall = fallen(10) + 0.1 * (1 * 1 - 2 * 3) / 4  # of the centre of mass
    agree(run.x("a.dofs"), [[0, fall, 0]], 1e-8)
    agree(run.x("b.dofs"), [[1, fall, 0]], 1e-8)


@case
def solves_that_begin_with_the_last_one():
    """warmStart of CGLinearSolver: x of the last solve, r = b - A x; here ended after two iterations each."""
    x, v, h, dv = CHAIN.copy(), np.zeros_like(CHAIN), 0.01, np.zeros(9)
    fields = together(gravity(np.ones(4), [0, -10, 0]), springs(LINKS, CHAIN, 5e4))
    for _ in range(10):
        f, K = fields(x, v)
        A, b = (np.eye(12) - h * h * K)[3:, 3:], (h * (f.ravel() + h * K @ v.ravel()))[3:]
        r, p, before = b - A @ dv, np.zeros(9), np.inf
        for _ in range(2):
            p, before = r + (r @ r) / before * p, r @ r
            alpha = before / (p @ A @ p)
            dv, r = dv + alpha * p, r - alpha * (A @ p)
        v[1:] += dv.reshape(-1, 3)
        x = x + h * v
    solver = '<EulerImplicitSolver/><CGLinearSolver iterations="2" tolerance="1e-14" threshold="1e-30" {}/>'
    body = CHAIN_TEXT.replace('"500"', '"5e4"')
    agree(Run(root(solver.format('warmStart="1"') + body), 10).x(), x, 1e-9)
    differ(Run(root(solver.format("") + body), 10).x(), x, 1e-5)


@case
def velocities_that_decay_after_each_step():
    """vdamping: v *= exp(-h vdamping) after x has moved."""
    y = v = 0.0
    for _ in range(10):
        v -= 0.01 * 10
        y += 0.01 * v
        v *= np.exp(-0.01 * 20)
    run = Run(root('<EulerImplicitSolver vdamping="20"/><SparseLDLSolver/><MechanicalObject name="dofs" position="1 0 0"/>'
                   '<UniformMass totalMass="2"/>'), 10)
    agree(run.x(), [[1, y, 0]])


@case
def places_before_and_after_the_rest_shape():
    """scale, rotation, translation, then the rest shape is kept, then rotation2 and translation2: springs to it pull by the second."""
    scene = node(EXACT + '<MechanicalObject name="dofs" position="1 0 0  0 1 0" scale="2" rotation="0 0 90" translation="0 0 1" '
                 'rotation2="90 0 0" translation2="0 5 0"/><UniformMass totalMass="2"/><RestShapeSpringsForceField stiffness="100"/>')
    rest = np.array([[0, 2, 1], [-2, 0, 1]], float)
    start = rest @ np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]]).T + [0, 5, 0]  # about x by 90 degrees
    agree(Run(scene, 1).x(), start + 1e-4 * 100 * (rest - start) / (1 + 1e-4 * 100), 1e-9)

def rotation(degrees):
    """About x, then y, then z."""
    a, b, c = np.radians(degrees)
    about_x = [[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]]
    about_y = [[np.cos(b), 0, np.sin(b)], [0, 1, 0], [-np.sin(b), 0, np.cos(b)]]
    return np.array([[np.cos(c), -np.sin(c), 0], [np.sin(c), np.cos(c), 0], [0, 0, 1]]) @ about_y @ about_x


@case
def rotations_about_three_axes():
    """Of states, loaders and engines: scale, rotation about x, y and z, translation; a loader and a state one after the other."""
    P = np.array([[1, 0, 0], [0, 2, 0], [0.3, 0.1, 3]])
    R, angles = rotation([30, -50, 110]), 'rotation="30 -50 110"'
    expected = (P * [2, 3, 0.5]) @ R.T + [5, 6, 7]
    place = f'scale3d="2 3 0.5" {angles} translation="5 6 7"'
    files = {"m.obj": "".join("v {} {} {}\n".format(*p) for p in P) + "f 1 2 3\n"}
    loader = f'<MeshOBJLoader name="e" filename="m.obj" {place}/>'

    def state(words):
        return Run(node(EXACT + f'{loader}<MechanicalObject name="dofs" {words}/><UniformMass totalMass="1"/>'), 1, files).x()
    agree(state(f'position="{numbers_of(P)}" {place}'), expected)
    agree(state(f'position="{numbers_of(P)}" sx="2" sy="3" sz="0.5" rx="30" ry="-50" rz="110" dx="5" dy="6" dz="7"'), expected)
    agree(state('src="@e"'), expected)
    agree(state('src="@e" scale3d="1 2 1" rotation="0 20 10" translation="0 0 1"'), (expected * [1, 2, 1]) @ rotation([0, 20, 10]).T + [0, 0, 1])
    engine = f'<TransformEngine name="e" input_position="{{}}" scale="2 3 0.5" {angles} translation="5 6 7" {{}}/>'
    agree(placed(engine.format(numbers_of(P), ""), "e.output_position"), expected)
    agree(placed(engine.format(numbers_of(expected), 'inverse="1"'), "e.output_position"), P)
    start = [1, 2, 3, *oriented([1, 1, 0], 0.7)]
    x = Run(node(EXACT + f'<MechanicalObject template="Rigid3" name="dofs" position="{numbers_of(start)}" {angles} translation="5 6 7"/>'
                 '<UniformMass totalMass="1"/>'), 1).x(width=7)[0]
    agree(x[:3], R @ [1, 2, 3] + [5, 6, 7])
    agree(axes_of(x[3:]), R @ axes_of(np.array(start[3:])))


@case
def points_in_a_grid_that_a_state_moves():
    """SOFA finds the cell, and the place in it, in the grid. A state takes the origin of a regular grid with it, and not its spacing; its own
    positions, and a sparse grid, are no matter."""
    child = '<Node name="c"><MechanicalObject name="c" position="{}"/><BarycentricMapping/></Node>'
    for state, points, found in (('translation="5 0 0"', "5.5 0.25 0.75  5 1 0", [[5.5, 0.25, 0.75], [5, 1, 0]]),
                                 ('translation="5 0 0" scale="2"', "5.5 0.25 0.75  5 1 0", [[6, 0.5, 1.5], [5, 2, 0]]),
                                 ('rotation="0 0 90" translation="3 0 0"', "3.25 0.5 0", [[2.5, 0.25, 0]]),
                                 (f'position="{numbers_of(CUBE + [5, 0, 0])}"', "0.5 0.25 0.75", [[5.5, 0.25, 0.75]])):
        scene = node(EXACT + f'<RegularGridTopology n="2 2 2" min="0 0 0" max="1 1 1"/><MechanicalObject name="dofs" {state}/><UniformMass '
                     f'totalMass="8"/>{child.format(points)}')
        agree(Run(scene, 1).x("c.c"), found)
    differ(Run(scene, 1, args=["--without-quirk", "centre-cells"]).x("c.c"), found, 1)
    surface = 'position="0 0 0  1 0 0  0 1 0  0 0 1" triangles="0 2 1  0 1 3  1 2 3  2 0 3"'
    scene = node(EXACT + f'<SparseGridTopology n="2 2 2" min="0 0 0" max="1 1 1" {surface}/><MechanicalObject name="dofs" translation="5 0 0"/>'
                 f'<UniformMass totalMass="8"/>{child.format("0.5 0.25 0.75")}')
    agree(Run(scene, 1).x("c.c"), [[5.5, 0.25, 0.75]])


def searched(A, b, kind, most, tolerance):
    """SOFA's preconditioned search: it ends where r.B r <= tolerance b.b."""
    B = np.diag(1 / np.diag(A)) if kind else np.eye(len(b))
    x, r = np.zeros_like(b), b.copy()
    p = B @ r
    rho, count = r @ p, 0
    while count < most and rho > tolerance * (b @ b):
        q = A @ p
        alpha = rho / (p @ q)
        x, r = x + alpha * p, r - alpha * q
        before, rho = rho, r @ B @ r
        p, count = B @ r + rho / before * p, count + 1
    return x


@case
def searches_that_end_by_squares():
    """PCGLinearSolver: without a preconditioner |r| <= sqrt(tolerance) |b|."""
    X, h, mass = np.array([[i, 0.1 * i * i, 0] for i in range(12)], float), 0.01, np.linspace(0.2, 2, 12)
    lists = [(i, i + 1, 3e3, 0, float(np.linalg.norm(X[i + 1] - X[i]))) for i in range(11)]
    fields = together(of_springs(lists), gravity(mass, [0, -10, 0]))
    body = (f'<MechanicalObject name="dofs" position="{numbers_of(X)}"/><DiagonalMass vertexMass="{numbers_of(mass)}"/><FixedConstraint '
            'indices="0"/><SpringForceField spring="' + "  ".join(" ".join(map(repr, spring)) for spring in lists) + '"/>')
    for kind in ("", "JacobiPreconditioner"):
        for words, most, tolerance in (("", 25, 1e-5), ('iterations="4" tolerance="1e-9"', 4, 1e-9), ('iterations="100" tolerance="1e-3"', 100, 1e-3)):
            x, v = X.copy(), np.zeros_like(X)
            for _ in range(10):
                f, K = fields(x, v)
                A, b = (np.diag(np.repeat(mass, 3)) - h * h * K)[3:, 3:], (h * (f.ravel() + h * K @ v.ravel()))[3:]
                v[1:] += searched(A, b, kind, most, tolerance).reshape(-1, 3)
                x = x + h * v
            inverse = f'<{kind} name="pre" template="CompressedRowSparseMatrixd"/>' if kind else ""
            solver = f'<EulerImplicitSolver/><PCGLinearSolver {words} {"preconditioner=" + chr(34) + "@pre" + chr(34) if kind else ""}/>{inverse}'
            run = Run(root(solver + body), 10)
            agree(run.x() - X, x - X, 1e-9)
            run.says("cg-threshold: conjugate gradients stop at an absolute p.Ap or, preconditioned, r.Br")
    differ(Run(root(solver + body), 10, args=["--without-quirk", "cg-threshold"]).x(), x, 1e-4)


@case
def thresholds_of_nothing():
    """Zero and less end no search of CGLinearSolver."""
    fields = together(gravity(np.ones(4), [0, -10, 0]), springs(LINKS, CHAIN, 5e4))
    x = euler(CHAIN, np.eye(4), fields, 10, 0.01, held=[0], cg=(3, 1e-5, 0))
    for threshold in ("0", "-1", "1e-300"):
        solver = f'<EulerImplicitSolver/><CGLinearSolver iterations="3" tolerance="1e-5" threshold="{threshold}"/>'
        agree(Run(root(solver + CHAIN_TEXT.replace('"500"', '"5e4"')), 10).x(), x, 1e-9)


@case
def spheres_push_outwards():
    """f = -k (|y| - r) n - c (r - |y|) v inside, with a limit, and with both sides; the tangent is that of the spring alone."""
    X = np.array([[0.7, 0.2, 0.1], [1.2, 0, 0.3], [-0.1, 0.5, 0]])
    V = np.array([[1, 0, 0], [0, 1, 0], [0, 2, 1.0]])

    def sphere(both, most):
        def field(x, v):
            f, K = np.zeros_like(x), np.zeros((9, 9))
            for i, y in enumerate(x):
                d = np.linalg.norm(y)
                if d >= 1 and not both:
                    continue
                n = y / d
                f[i] = -80 * (d - 1) * n - 6 * abs(d - 1) * v[i]
                size = np.linalg.norm(f[i])
                if 0 < most < size:
                    f[i] *= most / size
                K[3 * i:3 * i + 3, 3 * i:3 * i + 3] = -80 * (np.outer(n, n) + (d - 1) / d * (np.eye(3) - np.outer(n, n)))
            return f, K
        return field
    scene = (f'{{}}<MechanicalObject name="dofs" position="{numbers_of(X)}" velocity="{numbers_of(V)}"/><UniformMass totalMass="3"/>'
             '<SphereForceField center="0 0 0" radius="1" stiffness="80" damping="6" {}/>')
    agree(Run(node(scene.format(EXACT, "")), 8).x(), euler(X, np.eye(3), sphere(False, 0), 8, 0.01, v=V), 1e-9)
    x, v = X.copy(), V.copy()
    for _ in range(8):
        v = v + 0.01 * sphere(False, 0)(x, v)[0]
        x = x + 0.01 * v
    agree(Run(node(scene.format("<EulerExplicitSolver/>", "")), 8).x(), x, 1e-9)


@case
def springs_of_each_kind_of_cell():
    """Each pair once, with the constants of the first kind that has it."""
    X = CUBE + 0.1 * np.sin(5 * np.arange(24)).reshape(8, 3)
    kinds = {"edges": ((2, 5), 10), "triangles": ((0, 1, 3), 20), "quads": ((0, 1, 3, 2), 30), "tetrahedra": ((0, 1, 2, 4), 40), "hexahedra": ((0, 1, 3, 2, 4, 5, 7, 6), 50)}
    for chosen in itertools.chain.from_iterable(itertools.combinations(kinds, n) for n in (1, 2, 5)):
        found, cells, words = {}, "", ""
        for kind in chosen:
            nodes, k = kinds[kind]
            cells += f'{kind}="{" ".join(map(str, nodes))}" '
            name = {"hexahedra": "cubes", "edges": "lines"}.get(kind, kind)
            words += f'{name}Stiffness="{k}" {name}Damping="{k / 100}" '
            for pair in itertools.combinations(sorted(nodes), 2):
                found.setdefault(pair, k)
        lengths = {pair: float(np.linalg.norm(X[pair[0]] - X[pair[1]])) for pair in found}
        fields = together(gravity(np.ones(8), [0, -10, 0]), of_springs([(*p, k / lengths[p], k / 100 / lengths[p], lengths[p]) for p, k in found.items()]))
        scene = root(EXACT + f'<MeshTopology position="{numbers_of(X)}" {cells}/><MechanicalObject name="dofs"/><UniformMass totalMass="8"/>'
                     f'<MeshSpringForceField {words}/><FixedConstraint indices="0 1"/>')
        agree(Run(scene, 10).x(), euler(X, np.eye(8), fields, 10, 0.01, held=[0, 1]), 1e-8)
    X, lists = CUBE * [1, 1.5, 2], []
    for a, b in itertools.combinations(range(8), 2):
        k, d = {1: (300, 2), 2: (100, 1), 3: (50, 0.5)}[int(np.abs(CUBE[a] - CUBE[b]).sum())]
        L = np.linalg.norm(X[a] - X[b])
        lists.append((a, b, k / L, d / L, L))
    for scale in (1, 1.1):  # the lengths are those of the grid
        scene = root(EXACT + f'<RegularGridTopology n="2 2 2" min="0 0 0" max="1 1.5 2"/><MechanicalObject name="dofs" scale="{scale}"/><UniformMass '
                     'totalMass="8"/><RegularGridSpringForceField linesStiffness="300" linesDamping="2" quadsStiffness="100" quadsDamping="1" '
                     'cubesStiffness="50" cubesDamping="0.5"/><FixedConstraint indices="0 1"/>')
        fields = together(gravity(np.ones(8), [0, -10, 0]), of_springs(lists))
        agree(Run(scene, 10).x(), euler(X * scale, np.eye(8), fields, 10, 0.01, held=[0, 1]), 1e-8)


@case
def masses_of_quads_and_of_edges():
    """MeshMatrixMass on quads A/8, A/16; totalMass scales the density; DiagonalMass on edges L/2."""
    Q = np.array([[0, 0, 0], [1, 0.1, 0], [0, 1, 0.2], [1.3, 1, 0]])
    size = sum(np.linalg.norm(np.cross(Q[b] - Q[0], Q[c] - Q[0])) / 2 for b, c in ((1, 3), (3, 2)))
    M = size / 8 * np.eye(4)
    for a, b in ((0, 1), (1, 3), (3, 2), (2, 0)):
        M[a, b] = M[b, a] = size / 16
    for words, factor in (('massDensity="3"', 3), ('totalMass="7"', 7 / size)):
        scene = root(f'<EulerImplicitSolver/><EigenSparseLU/><MeshTopology position="{numbers_of(Q)}" quads="0 1 3 2"/><MechanicalObject name="dofs"/>'
                     f'<MeshMatrixMass {words}/><RestShapeSpringsForceField stiffness="100"/>')
        fields = together(gravity(2 * factor * np.diag(M), [0, -10, 0]), of_rest(range(4), Q, 100.0))
        agree(Run(scene, 10).x(), euler(Q, factor * M, fields, 10, 0.01), 1e-8)
    E = np.array([[0, 0, 0], [1, 0.1, 0], [2, 0, 0]])
    lengths = [np.linalg.norm(E[1] - E[0]), np.linalg.norm(E[2] - E[1])]
    m = np.array([lengths[0], sum(lengths), lengths[1]]) / 2
    for words, factor in (('massDensity="3"', 3), ('totalMass="7"', 7 / m.sum())):
        scene = root(EXACT + f'<MeshTopology position="{numbers_of(E)}" edges="0 1  1 2"/><MechanicalObject name="dofs"/><DiagonalMass {words}/>'
                     '<RestShapeSpringsForceField stiffness="100"/>')
        fields = together(gravity(factor * m, [0, -10, 0]), of_rest(range(3), E, 100.0))
        agree(Run(scene, 10).x(), euler(E, factor * np.diag(m), fields, 10, 0.01), 1e-8)


@case
def masses_of_the_shape_at_rest_or_of_the_start():
    X = np.array([[0, 0, 0], [2, 0, 0], [0, 3, 0], [0, 0, 1.5]])
    now = X * [1.2, 0.9, 1.4]
    volumes = {True: 1.5, False: 1.5 * 1.2 * 0.9 * 1.4}
    for kind, default in (("DiagonalMass", True), ('MeshMatrixMass lumping="1"', False)):
        for given in (None, True, False):
            m = 2 * volumes[default if given is None else given] / 4
            word = "" if given is None else f'computeMassOnRest="{int(given)}"'
            scene = root(EXACT + f'<TetrahedronSetTopologyContainer position="{numbers_of(X)}" tetrahedra="0 1 2 3"/><MechanicalObject name="dofs" '
                         f'position="{numbers_of(now)}" rest_position="{numbers_of(X)}"/><{kind} massDensity="2" {word}/>'
                         '<RestShapeSpringsForceField stiffness="30"/>')
            fields = together(gravity(np.full(4, m), [0, -10, 0]), of_rest(range(4), X, 30.0))
            agree(Run(scene, 10).x(), euler(now, m * np.eye(4), fields, 10, 0.01), 1e-8)


@case
def inverted_cells_have_a_mass():
    """Volumes are without a sign: of meshes whose tetrahedra are listed the other way round."""
    X = np.array([[0, 0, 0], [1, 0, 0], [0, 0, 1], [0, 1, 0], [1, 1, 1.0]])
    cells, m = [(0, 1, 2, 3), (1, 2, 3, 4)], np.zeros(5)
    for cell in cells:
        edges = X[list(cell[1:])] - X[cell[0]]
        assert np.linalg.det(edges) < 0
        m[list(cell)] += 3 * abs(np.linalg.det(edges)) / 24
    fields = together(gravity(m, [0, -10, 0]), tetrahedra(cells, X, 300, 0.3))
    for mass in ('DiagonalMass massDensity="3"', f'DiagonalMass totalMass="{m.sum()}"', 'MeshMatrixMass massDensity="3" lumping="1"'):
        scene = root(EXACT + f'<TetrahedronSetTopologyContainer position="{numbers_of(X)}" tetrahedra="0 1 2 3  1 2 3 4"/><MechanicalObject name="dofs"/>'
                     f'<{mass}/><TetrahedronFEMForceField method="small" youngModulus="300" poissonRatio="0.3"/><FixedConstraint indices="0"/>')
        agree(Run(scene, 10).x(), euler(X, np.diag(m), fields, 10, 0.01, held=[0]), 1e-8)


def shapes_of_cells():
    """Nodes, values and slopes of shape functions, and points with weights, of FEMMass."""
    def edge(s):
        return np.array([1 - s[0], 1 + s[0]]) / 2, np.array([[-0.5], [0.5]])

    def triangle(s):
        return np.array([1 - s[0] - s[1], s[0], s[1]]), np.array([[-1, -1], [1, 0], [0, 1]])

    def quad(s):
        at = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
        return (1 + at[:, 0] * s[0]) * (1 + at[:, 1] * s[1]) / 4, np.array([[a * (1 + b * s[1]) / 4, b * (1 + a * s[0]) / 4] for a, b in at])

    def prism(s):
        flat, slopes = triangle(s)
        return (np.concatenate([flat * (1 + z * s[2]) / 2 for z in (-1, 1)]),
                np.vstack([np.column_stack([slopes * (1 + z * s[2]) / 2, flat * z / 2]) for z in (-1, 1)]))
    low, high = -6 ** -0.5, 2 ** -0.5
    return {"Edge": ("edges", [[0, 0, 0], [1, 0.2, 0.1]], edge, [((0,), 2)]),
            "Triangle": ("triangles", [[0, 0, 0], [1, 0.2, 0.1], [0, 1, 0]], triangle, [((1 / 3, 1 / 3), 0.5)]),
            "Quad": ("quads", [[0, 0, 0], [1, 0.2, 0.1], [1.2, 1, 0], [0, 1, 0.1]], quad,
                     [(((2 / 3) ** 0.5, 0), 4 / 3), ((low, -high), 4 / 3), ((low, high), 4 / 3)]),
            "Prism": ("prisms", [[0, 0, 0], [1, 0.2, 0.1], [0, 1, 0], [0, 0.1, 1], [1, 0.2, 1.1], [0, 1, 1.4]], prism,
                      [((1 / 3, 1 / 3, z), 0.5) for z in (-3 ** -0.5, 3 ** -0.5)])}


@case
def finite_element_masses_of_other_cells():
    for kind, (word, places, shape, points) in shapes_of_cells().items():
        X = np.array(places)
        rho, M = np.arange(1, len(X) + 1), np.zeros((len(X),) * 2)
        for s, weight in points:
            N, slopes = shape(s)
            J = X.T @ slopes
            M += weight * np.sqrt(np.linalg.det(J.T @ J)) * (N @ rho) * np.outer(N, N)
        scene = root(f'<EulerImplicitSolver/><EigenSparseLU/><MeshTopology position="{numbers_of(X)}" {word}="{" ".join(map(str, range(len(X))))}"/>'
                     f'<MechanicalObject name="dofs"/><NodalMassDensity property="{numbers_of(rho)}"/><FEMMass template="Vec3,{kind}"/>'
                     '<RestShapeSpringsForceField stiffness="100"/>')
        fields = together(gravity(M.sum(axis=1), [0, -10, 0]), of_rest(range(len(X)), X, 100.0))
        agree(Run(scene, 5).x(), euler(X, M, fields, 5, 0.01), 1e-8)


@case
def halves_of_the_quads_of_a_grid():
    """Quad i of a grid with nx quads in a row: where (i mod nx) xor (i div nx) is odd (0 1 3)(2 3 1), else (1 2 0)(3 0 2); without a
    grid nx is 2."""
    for n, m, is_grid in ((4, 3, True), (3, 4, True), (4, 3, False)):
        X = np.array([[i, j, 0 if is_grid else 0.1 * i * j] for j in range(m) for i in range(n)], float)
        quads = [(i + n * j, i + 1 + n * j, i + 1 + n * (j + 1), i + n * (j + 1)) for j in range(m - 1) for i in range(n - 1)]
        nx, triangles = n - 1 if is_grid else 2, []
        for i, quad in enumerate(quads):
            halves = ((0, 1, 3), (2, 3, 1)) if ((i % nx) ^ (i // nx)) & 1 else ((1, 2, 0), (3, 0, 2))
            triangles += [tuple(quad[a] for a in half) for half in halves]
        mesh = (f'<RegularGridTopology name="g" n="{n} {m} 1" min="0 0 0" max="{n - 1} {m - 1} 0"/>' if is_grid else
                f'<QuadSetTopologyContainer name="g" position="{numbers_of(X)}" quads="{" ".join(str(i) for quad in quads for i in quad)}"/>')
        scene = root(EXACT + mesh + '<MechanicalObject name="dofs"/><UniformMass vertexMass="1"/><FixedConstraint indices="0 1"/><Node name="t">'
                     '<TriangleSetTopologyContainer name="t"/><TriangleSetTopologyModifier/><Quad2TriangleTopologicalMapping input="@../g" '
                     'output="@t"/><TriangularFEMForceFieldOptim youngModulus="500" poissonRatio="0.3"/></Node>')
        fields = together(gravity(np.ones(len(X)), [0, -10, 0]), membrane(triangles, X, 500, 0.3, False))
        agree(Run(scene, 5).x(), euler(X, np.eye(len(X)), fields, 5, 0.01, held=[0, 1]), 1e-7)


@case
def pressures_on_the_sides_of_solids():
    """Sides of tetrahedra and hexahedra look outwards, with flipNormals inwards."""
    X = CUBE + 0.05 * np.sin(5 * np.arange(24)).reshape(8, 3)
    cells = [(0, 5, 1, 7), (0, 1, 3, 7), (0, 3, 2, 7), (0, 2, 6, 7), (0, 6, 4, 7), (0, 4, 5, 7)]
    sides = {}
    for cell in cells:
        for last in range(4):
            side = [n for i, n in enumerate(cell) if i != last]
            out = np.cross(X[side[1]] - X[side[0]], X[side[2]] - X[side[0]]) * 30 / 6
            sides.setdefault(tuple(sorted(side)), []).append(out if out @ (X[cell[last]] - X[side[0]]) < 0 else -out)
    f = np.zeros_like(X)
    for side, outwards in sides.items():
        if len(outwards) == 1:
            f[list(side)] += outwards[0]
    listed = " ".join(str(i) for cell in cells for i in cell)
    for flip, sign in (("", 1), ('flipNormals="1"', -1)):
        run = Run(node(f'<EulerExplicitSolver/><TetrahedronSetTopologyContainer name="c" position="{numbers_of(X)}" tetrahedra="{listed}"/>'
                       '<MechanicalObject name="dofs"/><UniformMass vertexMass="1"/><Node name="s"><TriangleSetTopologyContainer name="t"/>'
                       f'<Tetra2TriangleTopologicalMapping input="@../c" output="@t" {flip}/><SurfacePressureForceField pressure="30"/></Node>'), 1)
        agree((run.x() - X) / 1e-4, sign * f, 1e-9)
    run = Run(node(f'<EulerExplicitSolver/><HexahedronSetTopologyContainer name="c" position="{numbers_of(CUBE)}" hexahedra="0 1 3 2 4 5 7 6"/>'
                   '<MechanicalObject name="dofs"/><UniformMass vertexMass="1"/><Node name="s"><QuadSetTopologyContainer name="t"/>'
                   '<Hexa2QuadTopologicalMapping input="@../c" output="@t"/><SurfacePressureForceField pressure="30"/></Node>'), 1)
    moved = (run.x() - CUBE) / 1e-4
    agree(moved.sum(axis=0) + 1, [1, 1, 1], 1e-9)
    assert (moved * (CUBE - 0.5) > 0).all(), moved


@case
def followers_weigh_in_explicit_steps():
    """SOFA divides forces by the mass of each state itself: what follows has a weight, whose inertia nobody feels."""
    scene = ('<{}/><MechanicalObject name="dofs" position="0 0 0  1 0 0"/><UniformMass totalMass="2"/><Node name="c"><MechanicalObject name="c" '
                 'position="1 0 0"/><SubsetMapping indices="1"/><UniformMass {}/><ConstantForceField indices="0" forces="0 0 6"/></Node>')
    for solver, factor in (("EulerExplicitSolver", 1), ("CentralDifferenceSolver", 1), ("RungeKutta4Solver", 5 / 6), ("RungeKutta2Solver", 5 / 6)):
        for mass in ('totalMass="3"', 'vertexMass="3"'):
            agree(Run(root(scene.format(solver, mass)), 5).x()[1], np.array([1 / factor, 4 * fallen(5), -fallen(5, g=6.0)]) * factor)
    Run(root(scene.format("EulerExplicitSolver", mass)), 1, args=["--without-quirk", "moved-inertia"]).fails(2, "the mass is not diagonal")


@case
def old_grids_are_of_single_precision():
    """0.1 is then a little more, and so is 1.1: the one lies in a box that begins there, the other beyond one that ends there."""
    body = ('<MechanicalObject name="dofs"/><UniformMass totalMass="1"/><BoxROI name="b" box="{}"/><FixedConstraint indices="@b.indices"/>')
    for words, last in (('xmin="0.1" xmax="1.1" ymin="0" ymax="1" zmin="0" zmax="1"', False), ('min="0.1 0 0" max="1.1 1 1"', True)):
        grid = root(EXACT + f'<RegularGridTopology nx="2" ny="2" nz="2" {words}/>' + body)
        still = [(np.abs(Run(grid.format(box), 1).x()[:, 1] - CUBE[:, 1]) < 1e-9).sum() for box in ("0.1 -1 -1 0.5 2 2", "0.5 -1 -1 1.1 2 2")]
        assert still == [4, 4 if last else 0], (words, still)


@case
def followers_without_a_mesh_have_the_first_of_an_ancestor():
    X, v = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]), np.array([[0, 0, 0], [1, 1, 0], [0, 0, 1], [0, 2, 2.0]])
    scene = root(EXACT + f'<MeshTopology position="{numbers_of(X)}" edges="0 1"/><MeshTopology position="{numbers_of(X)}" edges="2 3"/>'
                 f'<MechanicalObject name="dofs" velocity="{numbers_of(v)}"/><UniformMass totalMass="4"/><Node name="c"><MechanicalObject name="c"/>'
                 '<IdentityMapping/><MeshSpringForceField stiffness="300"/></Node>')
    agree(Run(scene, 5).x(), euler(X, np.eye(4), together(gravity(np.ones(4), [0, -10, 0]), springs([(0, 1)], X, 300)), 5, 0.01, v=v), 1e-9)


@case
def regions_look_at_the_shape_at_rest():
    held = '<UniformMass totalMass="2"/><BoxROI name="b" box="{}"/><FixedConstraint indices="@b.indices"/>'
    swapped = '<MechanicalObject name="dofs" position="0 0 0  5 0 0" rest_position="5 0 0  0 0 0"/>'
    agree(Run(root(EXACT + swapped + held.format("-1 -1 -1 1 1 1")), 3).x(), [[0, fallen(3), 0], [5, 0, 0]])
    moved = '<MechanicalObject name="dofs" position="0 0 0  5 0 0" translation="0 0 2" translation2="0 0 9"/>'
    agree(Run(root(EXACT + moved + held.format("-1 -1 1 1 1 3")), 3).x(), [[0, 0, 11], [5, fallen(3), 11]])


@case
def gravity_of_a_part_of_the_tree():
    part = '<Node name="{}">{}<Node name="b"><MechanicalObject name="dofs" position="0 0 0"/><UniformMass totalMass="1"/></Node></Node>'
    run = Run(root(EXACT + part.format("p", '<Gravity gravity="0 0 5"/>') + part.format("q", "") + part.format("r", "<Gravity/>")), 10)
    agree(run.x("p.b.dofs"), [[0, 0, -fallen(10, g=5.0)]])
    agree(run.x("q.b.dofs"), [[0, fallen(10), 0]])
    agree(run.x("r.b.dofs") + 1, [[1, 1, 1]])


@case
def springs_along_some_axes():
    X, V, along = np.array([[0, 0, 0], [1, 0, 0]]), np.array([[1, 2, 3], [1, 1, 1.0]]), np.diag([1, 0, 1])
    scene = node(EXACT + f'<MechanicalObject name="dofs" position="{numbers_of(X)}" velocity="{numbers_of(V)}"/><UniformMass totalMass="2"/>'
                 '<RestShapeSpringsForceField stiffness="50" activeDirections="1 0 1"/>')
    field = lambda x, v: (-50 * (x - X) @ along, -50 * np.kron(np.eye(2), along))
    agree(Run(scene, 10).x(), euler(X, np.eye(2), field, 10, 0.01, v=V))

@case
def what_a_silent_scene_means():
    """SOFA's defaults: the same bits as where they are written."""
    grid = ('<RegularGridTopology n="3 2 2" min="0 0 0" max="2 1 1"/><MechanicalObject name="dofs"/>{}<BoxROI name="b" box="-0.1 -1 -1 0.1 2 2"/>'
            '<FixedProjectiveConstraint indices="@b.indices"/>{}')
    uniform = '<UniformMass totalMass="2"/>'
    tets = ('<TetrahedronSetTopologyContainer position="0 0 0  1 0.1 0  0 1 0.2  0.1 0 1  1 1 1" tetrahedra="0 1 2 3  1 2 3 4"/><MechanicalObject '
            'name="dofs"/>{}<FixedProjectiveConstraint indices="0 1 2"/>{}')
    sheet = ('<MeshTopology position="0 0 0  1 0.1 0  0 1 0.2  1 1 0.1" triangles="0 1 2  1 3 2"/><MechanicalObject name="dofs"/>{}'
             '<FixedProjectiveConstraint indices="0 1"/>{}')
    points = '<MechanicalObject name="dofs" position="0 0 0  1.2 -0.1 0  2 -0.4 0.1"/>{}<FixedProjectiveConstraint indices="0"/>{}'
    frames = ('<MeshTopology edges="0 1  1 2"/><MechanicalObject template="Rigid3" name="dofs" position="0 0 0 0 0 0 1  1 0 0 0 0 0 1  2 0 0 0 0 0 1"/>{}'
              '<FixedProjectiveConstraint indices="0"/><ConstantForceField indices="2" forces="0 0 0 30 0 0"/>{}')
    young = 'youngModulus="5000" poissonRatio="0.45"'
    explicit = [(grid, uniform, "<HexahedronFEMForceField/>", f'<HexahedronFEMForceField method="large" {young}/>'),
                (tets, uniform, "<TetrahedronFEMForceField/>", f'<TetrahedronFEMForceField method="large" {young}/>'),
                (tets, uniform, "<TetrahedralCorotationalFEMForceField/>", f'<TetrahedralCorotationalFEMForceField method="large" {young}/>'),
                (tets, uniform, "<FastTetrahedralCorotationalForceField/>", f'<FastTetrahedralCorotationalForceField method="qr" {young}/>'),
                (tets, uniform, '<TetrahedronFEMForceField youngModulus="300 900" poissonRatio="0.2 0.4"/>',
                 '<TetrahedronFEMForceField method="large" youngModulus="300 900" poissonRatio="0.2 0.4"/>'),
                (tets, "<DiagonalMass/>", "", None), (tets, "<MeshMatrixMass/>", "", None), (tets, "<UniformMass/>", "", None),
                (grid, uniform, "<RegularGridSpringForceField/>", '<RegularGridSpringForceField stiffness="100" damping="5"/>'),
                (points, uniform, '<SpringForceField springsIndices1="0 1" springsIndices2="1 2"/>',
                 '<SpringForceField springsIndices1="0 1" springsIndices2="1 2" stiffness="100" damping="5" lengths="0"/>'),
                (points, uniform, "<RestShapeSpringsForceField/>", '<RestShapeSpringsForceField points="0 1 2" stiffness="100"/>'),
                (points, uniform, "<PlaneForceField/>", '<PlaneForceField normal="0 1 0" d="0" stiffness="500" damping="5"/>'),
                (points, uniform, "<SphereForceField/>", '<SphereForceField center="0 0 0" radius="1" stiffness="500" damping="5"/>'),
                (frames, uniform, "<BeamFEMForceField/>", '<BeamFEMForceField radius="0.1" radiusInner="0" youngModulus="5000" poissonRatio="0.49"/>'),
                (sheet, uniform, "<TriangularFEMForceFieldOptim/>", None), (sheet, uniform, "<TriangularBendingSprings/>",
                                                                            '<TriangularBendingSprings stiffness="1e5" damping="1"/>')]
    for body, mass, silent, written in explicit:
        other = written
        if written is None and silent:
            continue
        if written is None:
            other, silent = mass.replace("/>", ' totalMass="1"/>' if "Diagonal" not in mass else ' massDensity="1"/>'), mass
            silent, other = body.format(silent, ""), body.format(other, "")
        else:
            silent, other = body.format(mass, silent), body.format(mass, other)
        width = 7 if "Rigid3" in body else 3
        a, b = (Run(root(EXACT.replace("SparseLDLSolver", "EigenSparseLU") + each), 8).x(width=width) for each in (silent, other))
        agree(a, b, 0)
    chain = '<MeshTopology edges="0 1  1 2"/>' + points.format(uniform, '<MeshSpringForceField stiffness="3000"/>')
    for silent, written in (("<EulerImplicitSolver/><CGLinearSolver/>", '<EulerImplicitSolver rayleighMass="0" rayleighStiffness="0"/><CGLinearSolver '
                             'iterations="25" tolerance="1e-5" threshold="1e-5"/>'),
                            ("<NewmarkImplicitSolver/><CGLinearSolver/>", '<NewmarkImplicitSolver gamma="0.5" beta="0.25" rayleighMass="0" '
                             'rayleighStiffness="0"/><CGLinearSolver iterations="25" tolerance="1e-5" threshold="1e-5"/>'),
                            ("<EulerExplicitSolver/>", '<EulerExplicitSolver symplectic="1"/>')):
        agree(Run(root(silent + chain), 8).x(), Run(root(written + chain), 8).x(), 0)


@case
def options_of_constraints_springs_and_regions():
    X = np.array([[0, 0, 0], [1, 0, 0], [2, 0.1, 0]])
    body = f'<MechanicalObject name="dofs" position="{numbers_of(X)}"/><UniformMass totalMass="3"/>'
    fall = np.array([0, fallen(5), 0])

    def ended(words, steps=5, scene=root):
        return Run(scene(EXACT + body + words), steps).x()
    moved = X.copy()
    moved[[0, 2]] = 1.1, 2, 3
    agree(ended('<LinearMovementProjectiveConstraint indices="0 2" keyTimes="0 1" movements="1 2 3  2 2 3" relativeMovements="0"/>', 11, node), moved)
    agree(ended('<PartialFixedProjectiveConstraint fixAll="1" fixedDirections="1 0 1"/>'), X + fall)
    agree(ended('<FixedTranslationProjectiveConstraint indices="1"/>'), X + np.outer([1, 0, 1], fall))
    first = springs([(0, 1)], [[0, 0, 0], [0.8, 0, 0], [0, 0, 0]], 50, per_length=False)
    two = '<SpringForceField springsIndices1="0 1" springsIndices2="1 2" lengths="0.8" stiffness="50" damping="0" {}/>'
    agree(ended(two.format('enabled="1 0"'), 5, node), euler(X, np.eye(3), first, 5, 0.01))
    for start in (1.0, 0.6):
        pair = np.array([[0, 0, 0], [start, 0, 0]])
        scene = node(EXACT + f'<MechanicalObject name="dofs" position="{numbers_of(pair)}"/><UniformMass totalMass="2"/><SpringForceField '
                     'springsIndices1="0" springsIndices2="1" lengths="0.8" stiffness="50" damping="0" elongationOnly="1"/>')
        acts = springs([(0, 1)], [[0, 0, 0], [0.8, 0, 0]], 50, per_length=False, acts=lambda stretch: stretch > 0)
        agree(Run(scene, 15).x(), euler(pair, np.eye(2), acts, 15, 0.01))
    held = '<{} name="b" {}/><FixedProjectiveConstraint indices="@b.{}"/>'
    for region, out, nodes in (('BoxROI box="-0.1 -1 -1 0.1 1 1  1.9 -1 -1 2.1 1 1"', "indices", [0, 2]), ('BoxROI box="0.1 1 1 -0.1 -1 -1"', "indices", [0]),
                               ('BoxROI orientedBox="-0.5 -1 0  0.5 -1 0  0.5 1 0  2"', "indices", [0]),
                               ('SphereROI centers="0 0 0  2 0 0" radii="0.3 0.2"', "indicesOut", [1])):
        kind, words = region.split(" ", 1)
        agree(ended(held.format(kind, words, out)), X + np.outer([i not in nodes for i in range(3)], fall))
    small = f'<MechanicalObject name="dofs" position="{numbers_of(X)}" restScale="0.5"/><UniformMass totalMass="3"/><RestShapeSpringsForceField stiffness="100"/>'
    agree(Run(node(EXACT + small), 5).x(), euler(X, np.eye(3), of_rest(range(3), X * 0.5, 100.0), 5, 0.01))


main()
