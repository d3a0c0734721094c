# SPDX-License-Identifier: LGPL-2.1-or-later
"""Scenes in SOFA's dialect: components and attributes that no other of these files has a number for. Usage:
test_dialect_sentences.py STROMA [WORD]"""
import numpy as np

from dialect import EXACT, Run, agree, case, differ, fallen, falls, main, node, numbers_of, root
from reference import euler, gravity, hexahedra, springs, together, turn_of

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


main()
