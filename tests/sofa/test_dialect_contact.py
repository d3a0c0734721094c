# SPDX-License-Identifier: LGPL-2.1-or-later
"""Contact and constraints by Lagrange's multipliers in SOFA's dialect.
Usage: test_dialect_contact.py STROMA [WORD]."""
import numpy as np

from dialect import (BODY, DAMPED_SOLVERS, EXACT, FREE_LOOP, HANGING_SPRINGS, SWINGING, WATCH, Run, agree, both_bodies,
                     case, damped_system, differ, fallen, falls, main, node, numbers_of, root, springs_of, two_bodies)
from listed import Lists, Model, friction_rows, rubbed
from reference import axes_of, euler, gravity, product, springs, swept, together, turn_of

FLOOR = ('<Node name="floor"><MeshTopology position="-9 0 -7  9 0 -9  9 0 9  -9 0 9" triangles="0 1 2  0 2 3"/>'
         '<MechanicalObject name="dofs"/><TriangleCollisionModel name="top" simulated="0" moving="0"/></Node>')


def falling_point(height, watch=WATCH, more=""):
    return root(watch + FLOOR + f'<Node name="ball">{EXACT}<MechanicalObject name="dofs" position="0 {height} 0"/>'
                f'<UniformMass totalMass="1"/><PointCollisionModel name="point" {more}/></Node>')


@case
def nothing_touches():
    falls_from = Run(falling_point(1), 10)
    agree(falls_from.x("ball.dofs"), [[0, 1 + fallen(10), 0]])


OTHER = WATCH.replace("PenalityContactForceField", "StickContactForceField")


@case
def contacts_on_the_way_of_a_step():
    """A point at 300 m/s, 3 m in a step: contact keeps it contactDistance above the floor, if it is found on the way. The same of a point
    that a frame carries, and of two lines that cross."""
    def after(kind, ball, steps=2):
        return Run(root('<CollisionPipeline/><BruteForceBroadPhase/><BVHNarrowPhase/><CollisionResponse response="FrictionContactConstraint" '
                        f'responseParams="mu=0"/><CCDTightInclusionIntersection continuousCollisionType="{kind}" alarmDistance="0.2" '
                        'contactDistance="0.1"/>' + FREE_LOOP + FLOOR.replace("</Node>", '<LineCollisionModel simulated="0" moving="0"/></Node>') +
                        f'<Node name="ball">{EXACT}{ball}<LinearSolverConstraintCorrection/></Node>', 'gravity="0 0 0"'), steps)
    models = '<PointCollisionModel/>'
    point = '<MechanicalObject name="dofs" position="0 2 0" velocity="0 -300 0"/><UniformMass totalMass="1"/>' + models
    tool = ('<MechanicalObject name="frame" template="Rigid3" position="0 2.5 0 0 0 0 1" velocity="0 -300 0 0 0 0"/><UniformMass '
            'totalMass="1"/><Node name="tip"><MechanicalObject name="dofs" position="0 -0.5 0"/>' + models + '<RigidMapping/></Node>')
    line = ('<MeshTopology name="mesh" edges="0 1"/><MechanicalObject name="dofs" position="0 2 8  0 2 10" velocity="0 -300 0  0 -300 0"/>'
            '<UniformMass totalMass="1"/><LineCollisionModel/>')
    for kind, height in (("None", -4), ("Inertia", 0.1), ("FreeMotion", 0.1)):
        agree(after(kind, point).x("ball.dofs"), [[0, height, 0]])
        agree(after(kind, tool).x("ball.tip.dofs"), [[0, height, 0]])
        agree(after(kind, line).x("ball.dofs").mean(0), [0, height, 9])
    after("FreeMotion", point, 1).says("finds contacts on the free motion of a step")


@case
def the_step_that_would_touch_without_a_response_is_refused():
    steps = next(n for n in range(1000) if 1 + fallen(n) < 0.2)
    Run(falling_point(1, OTHER), 100).fails(3, "/ball/point", "/floor/top", "distance of 0.2:", f"step {steps + 1} ")
    agree(Run(falling_point(1, OTHER), steps).x("ball.dofs"), [[0, 1 + fallen(steps), 0]])


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
        assert abs(place[2] - z) < 1e-9, place
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
        outside.says("node 3", "which has 3 nodes: the springs have no effect")


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
def forces_of_constraint_up_to_a_tolerance():
    """SOFA's search for them is over where they move conditions by little, and goes on from there in the next step."""
    apart, h = np.array([0.1, 0.05, -0.1]), 0.01
    pairs, ends = ((3, 0), (2, 1), (1, 2)), "".join(f' {name}="{"{}"}"' for name in ("first_point", "second_point"))
    between = '<BilateralLagrangianConstraint object1="@one/dofs" object2="@two/dofs"' + ends.format("3 2 1", "0 1 2") + '/>'
    x0 = both_bodies(apart)[0]
    rest = np.ravel([x0[4 + b] - x0[a] + [0.1, 0, 0] for a, b in pairs])
    between = between.replace("/>", f' rest_vector="{numbers_of(rest)}"/>')
    J = np.zeros((12, 21))
    for i, (a, b) in enumerate(pairs):
        J[3 * i:3 * i + 3, 3 * a:3 * a + 3], J[3 * i:3 * i + 3, 12 + 3 * b:15 + 3 * b] = -np.eye(3), np.eye(3)
    J[9:, 18:] = np.eye(3)
    offset = np.r_[rest, x0[6]]
    blocks = [list(range(i, i + 3)) for i in range(0, 12, 3)]

    def motion(soft=0.0, cold=False, **how):
        x, v, mass, lists = both_bodies(apart)
        l, counts = np.zeros(12), []
        for _ in range(15):
            A, b = damped_system(x, v, mass, lists)
            C = np.zeros((21, 21))
            C[3:, 3:] = np.linalg.inv(A[3:, 3:])
            v = v + (C @ b).reshape(-1, 3)
            x = x + h * v
            W = h * J @ C @ J.T + soft * np.eye(12)
            l = np.zeros(12) if cold else l
            counts.append(swept(W, J @ x.ravel() - offset, blocks, l, **how))
            dx = (h * C @ J.T @ l).reshape(-1, 3)
            x, v = x + dx, v + dx / h
        return x, max(counts)
    kinds = (("Generic", "", {}), ("BlockGaussSeidel", 'tolerance="1e-5"', {"tolerance": 1e-5}), ("Generic", 'maxIt="2"', {"most": 2, "tolerance": 1e-3}),
             ("Generic", 'tolerance="1e-4" scaleTolerance="0"', {"tolerance": 1e-4, "scaled": False}),
             ("Generic", 'tolerance="1e-4" allVerified="1"', {"tolerance": 1e-4, "verified": True}),
             ("Generic", 'tolerance="1e-5" sor="0.7"', {"tolerance": 1e-5, "sor": 0.7}),
             ("Generic", 'tolerance="1e-5" regularizationTerm="0.02"', {"tolerance": 1e-5, "soft": 0.02}),
             ("UnbuiltGaussSeidel", 'tolerance="1e-4"', {"tolerance": 1e-4, "cold": True}),
             ("NNCG", 'tolerance="1e-5"', {"tolerance": 1e-5, "gradients": True}),
             ("Generic", 'resolutionMethod="NonsmoothNonlinearConjugateGradient"', {"gradients": True}))
    for kind, words, how in kinds:
        loop = f'<FreeMotionAnimationLoop/><{kind}ConstraintSolver {words}/>'
        scene = two_bodies(between, DAMPED_SOLVERS[1], apart, loop).replace("</Node></Node>", '</Node></Node>')
        scene = scene.replace(springs_of(HANGING_SPRINGS), springs_of(HANGING_SPRINGS) + '<FixedLagrangianConstraint indices="2"/>')
        scene = scene.replace("<UniformMass", "<LinearSolverConstraintCorrection/><UniformMass")
        expected, most = motion(**how)
        run = Run(scene, 15)
        agree(np.vstack([run.x("bodies.one.dofs"), run.x("bodies.two.dofs")]), expected, 1e-9)
        assert "makes constraints soft" not in run.text
        if words != 'tolerance="1e-5"':
            run = Run(scene, 15, args=["--without-quirk", "one-iteration"])
            differ(np.vstack([run.x("bodies.one.dofs"), run.x("bodies.two.dofs")]), expected, 1e-5)
    lone = scene.replace(loop, "<FreeMotionAnimationLoop/>")  # which makes a solver with the defaults
    agree(Run(lone, 15).x("bodies.two.dofs"), motion()[0][4:], 1e-9)
    Run(scene.replace(loop, "<FreeMotionAnimationLoop/><LCPConstraintSolver/>"), 1).says("takes all conditions as contacts")


@case
def fixed_points_go_to_where_they_rest():
    """FixedLagrangianConstraint compares with rest positions; of frames with their orientations, too."""
    rest = '0 0 0  1.5 0.2 0'
    text = ('<MechanicalObject name="dofs" position="0 0 0  1 0 0" rest_position="{}"/><UniformMass totalMass="2"/><LinearSolverConstraintCorrection/>'
            '<FixedLagrangianConstraint indices="1"/>')
    x = Run(root(FREE_LOOP + f'<Node name="a">{EXACT}{text.format(rest)}</Node>'), 3).x("a.dofs")
    agree(x, [[0, fallen(3), 0], [1.5, 0.2, 0]])
    turn, bent = turn_of(np.array([0.2, -0.1, 0.3])), turn_of(np.array([-0.1, 0.3, 0.1]))
    frame = (f'<MechanicalObject name="dofs" template="Rigid3" position="0 0 0 {numbers_of(turn)}" rest_position="0.1 0 -0.2 {numbers_of(bent)}"/>'
             '<UniformMass totalMass="1"/><LinearSolverConstraintCorrection/><FixedLagrangianConstraint indices="0"/>')
    x = Run(root(FREE_LOOP + f'<Node name="a">{EXACT}{frame}</Node>'), 12).x("a.dofs", 7)[0]
    agree(x, np.r_[0.1, 0, -0.2, bent], 1e-6)


@case
def numbers_start_between_their_stops():
    """StopperConstraint puts what starts beyond at its bound, where it has no velocity."""
    stops = "".join(f'<StopperConstraint index="{i}" min="-1" max="1"/>' for i in range(3))
    numbers = (f'<MechanicalObject name="dofs" template="Vec1d" position="2 -3 0.5" velocity="0 0 1"/><UniformMass totalMass="3"/>'
               f'<LinearSolverConstraintCorrection/>{stops}')
    agree(Run(root(FREE_LOOP + f'<Node name="a">{EXACT}{numbers}</Node>'), 5).x("a.dofs", 1)[:, 0], [1, -1, 0.55])


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
    agree(run.x("frame.dofs", 7)[0], np.r_[c, q], 1e-8)
    agree(run.x("point.dofs")[0], p, 1e-8)


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


def grid_body(place, turn, seed):
    """Nine points, eight triangles and sixteen edges of a sheet that is not flat."""
    random = np.random.default_rng(seed)
    points = np.array([[0.5 * i, 0, 0.5 * j] for j in range(3) for i in range(3)]) + random.uniform(-0.06, 0.06, (9, 3)) * [1, 0.5, 1]
    c, s = np.cos(turn), np.sin(turn)
    points = points @ np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]) + place
    triangles = [t for j in range(2) for i in range(2)
                 for t in ((3 * j + i, 3 * j + i + 4, 3 * j + i + 1), (3 * j + i, 3 * j + i + 3, 3 * j + i + 4))]
    edges = sorted({tuple(sorted(e)) for a, b, c in triangles for e in ((a, b), (b, c), (c, a))}, key=lambda e: (7 * e[0] + 3 * e[1]) % 17)
    return points, triangles, edges


def sheets(models, response, method, solver, velocity):
    """A floor, and two sheets above it of springs along their edges; models: kinds of each."""
    words = {"triangle": "TriangleCollisionModel", "line": "LineCollisionModel", "point": "PointCollisionModel", "sphere": "SphereCollisionModel"}
    text, bodies = "", []
    floor = np.array([[-4, -0.03, -3.0], [4, -0.03, -3], [4, -0.03, 4], [-4, -0.03, 4]])
    text += (f'<Node name="floor"><MeshTopology position="{numbers_of(floor)}" triangles="0 2 1  0 3 2"/><MechanicalObject/>'
             '<TriangleCollisionModel simulated="0" moving="0"/></Node>')
    for name, own, place, turn, seed, v in (("one", models[0], [0, 0.08, 0], 0, 1, [0.3, -0.4, 0.1]),
                                            ("two", models[1], [0.13, 0.2, 0.07], 0.3, 2, velocity)):
        points, triangles, edges = grid_body(place, turn, seed)
        springs_here = [(a, b, 60, 0.5, np.linalg.norm(points[b] - points[a])) for a, b in edges]
        bodies.append((points, np.tile(v, (9, 1)), springs_here, triangles, edges))
        shape = "".join(f'<{words[kind]} {"radius=%s" % chr(34) + "0.03" + chr(34) if kind == "sphere" else ""}/>' for kind in own)
        text += (f'<Node name="{name}">{DAMPED_SOLVERS[1]}<MeshTopology position="{numbers_of(points)}" triangles="'
                 f'{" ".join(str(i) for t in triangles for i in t)}" edges="{" ".join(str(i) for e in edges for i in e)}"/><MechanicalObject name="dofs" '
                 f'velocity="{numbers_of(np.tile(v, (9, 1)))}"/><UniformMass vertexMass="0.4"/>{springs_of(springs_here)}'
                 f'<LinearSolverConstraintCorrection/>{shape}</Node>')
    loop = f'<FreeMotionAnimationLoop/>{solver}' if solver else ""
    scene = root(loop + f'<CollisionPipeline depth="3"/><BruteForceBroadPhase/><BVHNarrowPhase/><{method} alarmDistance="0.11" contactDistance='
                 f'"0.05" {"filterIntersection=%s0%s" % (chr(34), chr(34)) if method == "LocalMinDistance" else ""}/>'
                 f'<CollisionResponse response="{response}" responseParams="mu=0.4"/>' + text)
    return scene, bodies, floor


def listed_models(models, bodies, floor):
    found = [Model("triangle", [(0, 2, 1), (0, 3, 2)], 0, -1, 0, simulated=False, places=floor)]
    for number, (own, body) in enumerate(zip(models, bodies)):
        parts = {"triangle": body[3], "line": body[4], "point": [(i,) for i in range(9)], "sphere": [(i,) for i in range(9)]}
        found += [Model(kind, parts[kind], number + 1, 9 * number, number + 1, radius=0.03 * (kind == "sphere")) for kind in own]
    return found


SHEETS = ((("MinProximityIntersection", (("triangle", "line", "point"), ("point", "line", "triangle")))),
          (("LocalMinDistance", (("triangle", "line", "point"), ("line", "point")))),
          (("MinProximityIntersection", (("triangle", "line", "point"), ("sphere",)))),
          (("NewProximityIntersection", (("point",), ("line",)))))


@case
def contacts_in_the_order_of_sofa():
    """Two sweeps with friction over the contacts of SOFA's lists, found by hand: in another order they end elsewhere. LCPConstraintSolver
    goes on from the forces of contacts that it knows, and has a measure of its own."""
    h, mu = 0.01, 0.4
    few, known = '<GenericConstraintSolver maxIterations="2" tolerance="1e-9"/>', '<LCPConstraintSolver tolerance="1e-4" maxIt="300" mu="0.4"/>'
    for (method, models), solver in [(SHEETS[0], known), (SHEETS[2], known)] + [(sheet, few) for sheet in SHEETS[:3]]:
        scene, bodies, floor = sheets(models, "FrictionContactConstraint", method, solver, [-0.2, -1.2, 0.1])
        x, v = np.vstack([b[0] for b in bodies]), np.vstack([b[1] for b in bodies])
        springs_here = bodies[0][2] + [(a + 9, b + 9, *rest) for a, b, *rest in bodies[1][2]]
        lists = Lists(listed_models(models, bodies, floor), method, 0.11, 0.05, 3)
        most, kept = 0, {}
        for _ in range(8):
            contacts = lists.contacts(x)
            most = max(most, len(contacts))
            A, b = damped_system(x, v, [0.4] * 18, springs_here)
            C, before = np.linalg.inv(A), x
            v = v + (C @ b).reshape(-1, 3)
            x = x + h * v
            J, g = friction_rows(contacts, x, before)
            if len(g):
                start = np.ravel([kept.get(c["name"], np.zeros(3)) for c in contacts])
                f = rubbed(h * J @ C @ J.T, g, mu, *((2, 1e-9) if solver == few else (300, 1e-4, start)))
                kept = {c["name"]: part for c, part in zip(contacts, f.reshape(-1, 3))}
                dx = (h * C @ J.T @ f).reshape(-1, 3)
                x, v = x + dx, v + dx / h
        run = Run(scene, 8)
        assert most > 20, most
        agree(np.vstack([run.x("one.dofs"), run.x("two.dofs")]), x, 1e-9)
    run = Run(scene, 8, args=["--without-quirk", "contact-lists"])
    differ(np.vstack([run.x("one.dofs"), run.x("two.dofs")]), x, 1e-4)


@case
def one_penalty_for_a_point():
    """Of the contacts of a point, or of a line of the model with more of them, the nearest pushes."""
    for method, models in SHEETS:
        scene, bodies, floor = sheets(models, "PenalityContactForceField", method, "", [-0.2, -1.2, 0.1])
        scene = scene.replace("<LinearSolverConstraintCorrection/>", "")
        x, v = np.vstack([b[0] for b in bodies]), np.vstack([b[1] for b in bodies])
        springs_here = bodies[0][2] + [(a + 9, b + 9, *rest) for a, b, *rest in bodies[1][2]]
        lists = Lists(listed_models(models, bodies, floor), method, 0.11, 0.05, 3)
        for _ in range(10):
            contacts = lists.contacts(x, rubs=False)
            A, b = damped_system(x, v, [0.4] * 18, springs_here)
            for c in contacts:
                way = c["fixed"] + sum(w * x[row] for row, w in c["rows"].items())
                pen, k = c["d"] - way @ c["n"], 100 / c["d"]
                if pen <= 0:
                    continue
                J = np.zeros(54)
                for row, w in c["rows"].items():
                    J[3 * row:3 * row + 3] += w * c["n"]
                b += 0.01 * k * pen * J
                if np.any(c["fixed"]):  # the floor: a part of the matrix
                    A += 1e-4 * k * np.outer(J, J) * 3
                    b -= 1e-4 * k * J * (J @ v.ravel()) * 3
            v = v + np.linalg.solve(A, b).reshape(-1, 3)
            x = x + 0.01 * v
        run = Run(scene, 10)
        agree(np.vstack([run.x("one.dofs"), run.x("two.dofs")]), x, 1e-9)


main()
