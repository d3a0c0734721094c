# SPDX-License-Identifier: LGPL-2.1-or-later
"""A step in SOFA's dialect: integrators, searches by conjugate gradients, loops, solvers that share a scene.
Usage: test_dialect_steps.py STROMA [WORD]."""
import itertools

import numpy as np

from dialect import (BODY, CHAIN, CHAIN_NODES, EXACT, LINKS, WATCH, Run, agree, case, differ, fallen, falls, main,
                     node, numbers_of, root)
from reference import axes_of, euler, gravity, load, multistep, product, springs, together, turn_of


@case
def one_integrator_on_the_way_down():
    falls(Run(root(f'{EXACT}<Node name="b"><EulerExplicitSolver/>{BODY}</Node>'), 10), "b.dofs")


@case
def other_direct_solvers():
    for solver in ("AsyncSparseLDLSolver", 'BTDLinearSolver template="BTDMatrix6d"', "EigenSimplicialLDLT"):
        falls(Run(root(f'<EulerImplicitSolver/><{solver}/>{BODY}'), 10))


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
def quirk_impulse_values():
    """A cable pulls a free point of 2 kg with the force that is written over dt: x = -(F / m) h^2 n (n + 1) / 2 from 1."""
    scene = node(EXACT + '<MechanicalObject name="dofs" position="1 0 0"/><UniformMass vertexMass="2"/>'
                 '<CableConstraint indices="0" pullPoint="0 0 0" valueType="force" value="0.003"/>')
    moved = 0.003 / 2 * 0.01**2 * 10 * 11 / 2
    agree(Run(scene, 10).x()[0, 0], 1 - moved / 0.01)
    agree(Run(scene, 10, args=["--without-quirk", "impulse-values"]).x()[0, 0], 1 - moved)


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
    assert ("scales the diffusion" in run.text) == (ratio == 3), run.text
    Run(scene.format('anisotropyRatio="2"'), 1).fails(2, "transverseAnisotropyArray has 0 directions for 2 tetrahedra")


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
def a_preconditioner_with_an_inverse_of_its_own():
    x = np.array([[i, 0, 0] for i in range(3)], float)
    fields = together(gravity(np.ones(3), [0, -10, 0]), springs([(0, 1), (1, 2)], x, 500))
    run = Run(root('<EulerImplicitSolver/><PCGLinearSolver iterations="100" tolerance="1e-12" preconditioner="@p"/>'
                   '<PrecomputedWarpPreconditioner name="p"/>' + SPRINGS), 20)
    agree(run.x(), euler(x, np.eye(3), fields, 20, 0.01, held=[0]), 1e-7)
    assert "leads nowhere" not in run.text, run.text


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
def damping_of_parts_is_in_the_matrix_alone():
    """rayleighStiffness of a force field and rayleighMass of a mass: A has them, the right side has only those of the integrator."""
    x0 = np.array([[0, 0, 0], [1, 0, 0], [1.8, 0.3, 0]])
    v0 = np.array([[0, 0, 0], [0, 1, 0.5], [-1, 0, 2]])
    pairs, h, mass = [(0, 1), (1, 2)], 0.01, 0.5
    fields = together(gravity(np.full(3, mass), [0, -10, 0]), springs(pairs, x0 * 0.9, 60, per_length=False))
    free = np.repeat([False, True, True], 3)

    def moved(own_stiffness, own_mass, of_all, on_both_sides=False):
        x, v = x0.copy(), v0.copy()
        for _ in range(10):
            f, K = fields(x, v)
            flat = v.ravel()
            A = (1 + h * (of_all + own_mass)) * mass * np.eye(9) - h * (h + of_all + own_stiffness) * K
            more = (own_stiffness, own_mass) if on_both_sides else (0, 0)
            b = h * (f.ravel() + (h + of_all + more[0]) * K @ flat - (of_all + more[1]) * mass * flat)
            dv = np.zeros(9)
            dv[free] = np.linalg.solve(A[np.ix_(free, free)], b[free])
            v = v + dv.reshape(-1, 3)
            x = x + h * v
        return x
    lengths = [np.linalg.norm(x0[b] - x0[a]) * 0.9 for a, b in pairs]
    listed = "  ".join(f"{a} {b} 60 0 {length!r}" for (a, b), length in zip(pairs, lengths))
    for own_stiffness, own_mass, of_all in ((0.1, 0, 0), (0, 2, 0), (0.05, 1, 0.1)):
        scene = root(f'<EulerImplicitSolver rayleighStiffness="{of_all}" rayleighMass="{of_all}"/><SparseLDLSolver/><MechanicalObject '
                     f'name="dofs" position="{numbers_of(x0)}" velocity="{numbers_of(v0)}"/><UniformMass vertexMass="{mass}" '
                     f'rayleighMass="{own_mass}"/><SpringForceField spring="{listed}" rayleighStiffness="{own_stiffness}"/>'
                     '<FixedConstraint indices="0"/>')
        agree(Run(scene, 10).x(), moved(own_stiffness, own_mass, of_all), 1e-9)
        agree(Run(scene, 10, args=["--without-quirk", "explicit-damping"]).x(), moved(own_stiffness, own_mass, of_all, True), 1e-9)


def chain_that_starts_with_a_velocity():
    """Places, velocities, its fields, and its text with places for the integrator and for what damps the mass and the springs; node 0 is
    held and has a velocity all the same."""
    x0 = np.array([[0, 0, 0], [1, 0, 0], [1.8, 0.3, 0]])
    v0 = np.array([[0, 0.3, -0.2], [0, 1, 0.5], [-1, 0, 2]])
    pairs, mass = [(0, 1), (1, 2)], 0.5
    lengths = [np.linalg.norm(x0[b] - x0[a]) * 0.9 for a, b in pairs]
    listed = "  ".join(f"{a} {b} 60 0 {length!r}" for (a, b), length in zip(pairs, lengths))
    fields = together(gravity(np.full(3, mass), [0, -10, 0]), springs(pairs, x0 * 0.9, 60, per_length=False))
    return x0, v0, mass, fields, (f'{{}}<SparseLDLSolver/><MechanicalObject name="dofs" position="{numbers_of(x0)}" velocity="{numbers_of(v0)}"/>'
                                  f'<UniformMass vertexMass="{mass}" {{}}/><SpringForceField spring="{listed}" {{}}/><FixedConstraint indices="0"/>')


@case
def first_acceleration_of_newmarks_rule():
    """a0 = M^-1 f, without the damping; all that follows has it, of parts too."""
    x0, v0, mass, fields, text = chain_that_starts_with_a_velocity()
    free, h = np.repeat([False, True, True], 3), 0.01

    def newmark(gamma, beta, rm, rk, whole_start=False):
        x, v = x0.copy(), v0.copy()
        f, K = fields(x, v)
        a = f.ravel() / mass + (rk * K @ v.ravel() / mass - rm * v.ravel() if whole_start else 0)
        a[~free] = 0
        for _ in range(10):
            f, K = fields(x, v)
            b = f.ravel() - rm * mass * (v.ravel() + h * (1 - gamma) * a) + K @ (
                (rk + h) * v.ravel() + (h * (1 - gamma) * rk + h * h * (1 - 2 * beta) / 2) * a)
            A = (1 + h * gamma * rm) * mass * np.eye(9) - (h * h * beta + h * gamma * rk) * K
            new = np.zeros(9)
            new[free] = np.linalg.solve(A[np.ix_(free, free)], b[free])
            x = x + h * v + (h * h * ((0.5 - beta) * a + beta * new)).reshape(-1, 3)
            v = v + (h * ((1 - gamma) * a + gamma * new)).reshape(-1, 3)
            a = new
        return x
    for gamma, beta, rm, rk in ((0.5, 0.25, 0.8, 0.1), (0.7, 0.4, 0, 0.1), (0.7, 0.4, 2, 0), (0.5, 0.25, 0, 0)):
        damping = f'rayleighMass="{rm}"', f'rayleighStiffness="{rk}"'
        solver = f'<NewmarkImplicitSolver gamma="{gamma}" beta="{beta}" {{}}/>'
        for parts in ((solver.format(" ".join(damping)), "", ""), (solver.format(""), *damping)):
            scene = root(text.format(*parts))
            agree(Run(scene, 10).x(), newmark(gamma, beta, rm, rk), 1e-9)
            agree(Run(scene, 10, args=["--without-quirk", "explicit-damping"]).x(), newmark(gamma, beta, rm, rk, True), 1e-9)
        if rm or rk:
            differ(newmark(gamma, beta, rm, rk), newmark(gamma, beta, rm, rk, True), 1e-5)


@case
def damping_of_held_nodes_in_central_differences():
    """v = c v + d a: constraints take what they hold out of a and not out of the first term."""
    x0, v0, mass, fields, text = chain_that_starts_with_a_velocity()
    for rate in (0.8, 5.0):
        x, v, h = x0.copy(), v0.copy(), 0.01
        for _ in range(10):
            a = fields(x, v)[0].reshape(-1, 3) / mass
            a[0] = 0
            v = ((1 / h - rate / 2) * v + a) / (1 / h + rate / 2)
            x = x + h * v
        scene = root(text.format(f'<CentralDifferenceSolver rayleighMass="{rate}"/>', "", "").replace("<SparseLDLSolver/>", ""))
        agree(Run(scene, 10).x(), x, 1e-9)
        kept = Run(scene, 10, args=["--without-quirk", "explicit-damping"]).x()
        agree(kept[0], x0[0] + 10 * h * v0[0], 1e-9)
        differ(kept[1:], x[1:], 1e-5)


@case
def explicit_steps_and_statics_know_no_damping_of_parts():
    for solver in ("EulerExplicitSolver", "RungeKutta2Solver", "RungeKutta4Solver", "CentralDifferenceSolver"):
        text = chain_that_starts_with_a_velocity()[-1].replace("<SparseLDLSolver/>", "")
        plain = Run(root(text.format(f"<{solver}/>", "", "")), 10)
        damped = Run(root(text.format(f"<{solver}/>", 'rayleighMass="2"', 'rayleighStiffness="0.1"')), 10)
        agree(damped.x(), plain.x(), 0)
        for part in ("UniformMass.rayleighMass", "SpringForceField.rayleighStiffness"):
            damped.says(part)
    bent = ('{}<SparseLDLSolver/><MechanicalObject name="dofs" position="0 0 0  1 0 0"/><UniformMass totalMass="2" rayleighMass="1"/>'
            '<RestShapeSpringsForceField stiffness="100" rayleighStiffness="0.1"/>')
    still = Run(root(bent.format('<StaticSolver newton_iterations="5"/>')), 1)
    agree(still.x()[:, 1], [-0.1, -0.1])
    still.says("UniformMass.rayleighMass", "RestShapeSpringsForceField.rayleighStiffness")


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
def settings_of_statics_in_two_places():
    newton = '<NewtonRaphsonSolver name="n" maxNbIterationsNewton="3"/>'
    body = ('<SparseLDLSolver/><MechanicalObject name="dofs" position="0 0 0  1 0 0"/><UniformMass totalMass="2"/><FixedConstraint '
            'indices="0"/><SpringForceField spring="0 1 100 0 0.5"/>')
    run = Run(root(newton + '<StaticSolver newton_iterations="5" absolute_residual_tolerance_threshold="1e-3"/>' + body), 3)
    run.says("newton_iterations: does not count", "absolute_residual_tolerance_threshold: does not count")
    agree(run.x(), Run(root(newton + "<StaticSolver/>" + body), 3).x())


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


def cut_gradients(A, b, iterations, tolerance, B):
    """Preconditioned conjugate gradients that end where r.B r <= tolerance b.b."""
    x, r = np.zeros_like(b), b.copy()
    w = B @ r
    rho, count = r @ w, 0
    while count < iterations and rho > tolerance * (b @ b):
        s = A @ w
        alpha = rho / (w @ s)
        x, r = x + alpha * w, r - alpha * s
        z = B @ r
        before, rho, count = rho, r @ z, count + 1
        w = z + rho / before * w
    return x


@case
def preconditioners_of_sofa():
    """Cut early, or by a mild tolerance, one preconditioner gives another result than the next. SOFA's sweeps are over single numbers, the
    upper triangle first."""
    x = np.array([[i, 0.3 * i ** 2, 0.2 * i] for i in range(9)], float)
    start = np.array([[0, 0, 0], *([1, -0.5 * i, 2] for i in range(8))])
    pairs, masses = [(i, i + 1) for i in range(8)], np.linspace(0.2, 2, 9)
    fields = together(gravity(masses, [1, -10, 0]), springs(pairs, x, 4000))
    scene = ('<EulerImplicitSolver/><PCGLinearSolver {} {}/>{}<MeshTopology position="'
             + numbers_of(x) + '" edges="' + " ".join(f"{a} {b}" for a, b in pairs) + '"/><MechanicalObject name="dofs" velocity="'
             + numbers_of(start) + '"/><DiagonalMass vertexMass="' + numbers_of(masses) +
             '"/><MeshSpringForceField stiffness="4000"/><FixedConstraint indices="0"/>')

    def inverse(A, kind):
        D, L, w = np.diag(np.diag(A)), np.tril(A, -1), 1.3
        if kind == "SSOR":
            return (2 - w) * np.linalg.inv(np.eye(len(A)) + w * np.linalg.solve(D, L)) @ np.linalg.inv(D / w + L.T)
        return np.linalg.inv(D) if kind else np.eye(len(A))

    def solve(iterations, tolerance, kind):
        def of(A, b, _first):
            free = np.flatnonzero(np.diag(A))
            held = A[np.ix_(free, free)]
            out = np.zeros_like(b)
            out[free] = cut_gradients(held, b[free], iterations, tolerance, inverse(held, kind))
            return out
        return of

    for iterations, tolerance in ((3, 1e-30), (40, 1e-2), (40, 1e-4)):
        ends, numbers = [], f'iterations="{iterations}" tolerance="{tolerance}"'
        for kind, text in (("", ""), ("Jacobi", '<JacobiPreconditioner name="j"/>'), ("SSOR", '<SSORPreconditioner name="j" omega="1.3"/>')):
            run = Run(root(scene.format(numbers, 'preconditioner="@j"' if kind else "", text), 'gravity="1 -10 0"'), 5)
            ends.append(euler(x, np.diag(masses), fields, 5, 0.01, v=start, held=[0], cg=solve(iterations, tolerance, kind)))
            agree(run.x(), ends[-1], 1e-8)
        for one, other in ((0, 1), (1, 2), (0, 2)):
            differ(ends[one], ends[other], 1e-6)
        blocks = scene.format(numbers, 'preconditioner="@j"', '<SSORPreconditioner name="j" omega="1.3" scalar="0"/>')
        differ(Run(root(blocks, 'gravity="1 -10 0"'), 5).x(), ends[2], 1e-6)


@case
def a_preconditioner_that_is_kept_for_some_steps():
    """SOFA solves with one of a former step then, which is told; of each step it is what it is here."""
    solver = ('<EulerImplicitSolver/><PCGLinearSolver iterations="50" tolerance="1e-14" preconditioner="@p" {}/><SparseLDLSolver name="p"/>'
              '<PreconditionedMatrixFreeSystem name="s" {}/>')
    for pcg, system, told in (("", 'assemblingRate="5"', "/s.assemblingRate"), ('update_step="3"', "", "/PCGLinearSolver1.update_step"),
                              ('update_step="1"', 'assemblingRate="1"', "")):
        run = Run(root(solver.format(pcg, system) + BODY), 10)
        falls(run)
        assert (f"{told}: keeps a preconditioner for as many steps in SOFA" in run.text) == bool(told), run.text


main()
