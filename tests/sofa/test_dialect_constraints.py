# SPDX-License-Identifier: LGPL-2.1-or-later
"""Constraints in SOFA's dialect that hold, move and attach nodes.
Usage: test_dialect_constraints.py STROMA [WORD]."""
import numpy as np

from dialect import (BODY, DAMPED_SOLVERS, EXACT, FALL, SWINGING, SWINGING_SPRINGS, Run, agree, both_bodies, case,
                     damped_system, differ, fallen, main, node, numbers_of, root, shapes_at, springs_of, two_bodies)
from reference import axes_of, inverse, product, turn_of


@case
def a_constraint_ends_with_the_step_before_its_time():
    run = Run(root(EXACT + BODY + '<FixedConstraint indices="0" endTime="0.05"/>'), 10)
    agree(run.x()[:, 1], [fallen(5), fallen(10)])


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
def a_bilinear_movement_is_one_of_its_corners():
    points = '<MechanicalObject name="dofs" position="0 0 0  2 0 0  2 4 0  0 4 0  1 4 0"/><UniformMass totalMass="1"/>'
    moved = ('<{} indices="0 1 2 3 4" cornerPoints="0 0 0  2 0 0  2 4 0  0 4 0" beginConstraintTime="0" '
             'endConstraintTime="0.2" cornerMovements="0 0 0  1 0 0  1 2 0  0 4 0"/>')
    for name in ("BilinearMovementConstraint", "BilinearMovementProjectiveConstraint"):
        agree(Run(node(EXACT + points + moved.format(name)), 30).x(), [[0, 0, 0], [3, 0, 0], [3, 6, 0], [0, 8, 0], [1.5, 7, 0]])


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
        assert " differ: " not in run.text and "warning" not in run.text, run.text
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
        agree(Run(scene, 20).x("dofs", 7)[0, 3:], q)
        differ(Run(scene, 20, args=["--without-quirk", "one-sided-turns"]).x("dofs", 7)[0, 3:], q, 1e-3)


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


TIED = (EXACT + '<MechanicalObject name="dofs" position="0 0 0  1 0 0  1 0 0  2 0 0  2 0 0  3 0 0"/><UniformMass totalMass="6"/><SpringForceField '
        'spring="0 1 1e4 0 1  2 3 1e4 0 1  4 5 1e4 0 1"/><FixedLagrangianConstraint indices="0"/><BilateralLagrangianConstraint first_point="1 3" '
        'second_point="2 4"/><GenericConstraintCorrection/>')


def tied(solver, loop="<FreeMotionAnimationLoop/>", **options):
    return Run(root(loop + solver + TIED), 20, **options)


@case
def constraint_solvers_as_scenes_write_them():
    """Methods are words or SOFA's numbers. What no sweep can do is told of the solver that the scene has."""
    solver = '<GenericConstraintSolver name="solver" maxIterations="1000" {}/>'
    exact = tied(solver.format('tolerance="1e-12"')).x()
    for number, word in enumerate(("ProjectedGaussSeidel", "UnbuiltGaussSeidel", "NonsmoothNonlinearConjugateGradient")):
        by_word = tied(solver.format(f'tolerance="1e-4" resolutionMethod="{word}"')).x()
        agree(tied(solver.format(f'tolerance="1e-4" resolutionMethod="{number}"')).x(), by_word, 1e-15)
        differ(by_word, exact, 1e-9)
    agree(tied(solver.format('tolerance="-1"')).x(), exact, 1e-9)
    run = tied(solver.format('tolerance="1e-4" resolutionMethod="Jacobi"'))
    agree(run.x(), tied(solver.format('tolerance="1e-4"')).x(), 1e-15)
    run.says("'Jacobi' is no method: SOFA keeps ProjectedGaussSeidel")
    for wrong in ('sor="2.5"', 'regularizationTerm="-1"', 'tolerance="small"'):
        run = tied(solver.format(wrong))
        run.fails(2, "/solver." + wrong.split("=")[0])
        assert "sweeps_of_constraints" not in run.text, run.text
    tied(solver.format("").replace("1000", "0")).fails(2, "/solver.maxIterations", "1 or more")


@case
def the_first_constraint_solver_counts():
    both = '<GenericConstraintSolver name="first" tolerance="1e-3"/><GenericConstraintSolver name="second" tolerance="1e-12"/>'
    run = tied(both)
    agree(run.x(), tied('<GenericConstraintSolver tolerance="1e-3"/>').x(), 1e-15)
    run.says("/second: does not count", "/first")


@case
def what_a_constraint_solver_does_is_told():
    run = tied('<GenericConstraintSolver tolerance="1e-5" maxIterations="77"/>', command="explain")
    run.says("1e-05 for each condition", "77 sweeps")
    assert "GenericConstraintSolver" not in run.text.partition("accepted without effect")[2], run.text
    stop = EXACT + ('<MechanicalObject name="dofs" template="Vec1" position="0.5"/><UniformMass totalMass="2"/><StopperLagrangianConstraint '
                    'index="0" min="-1" max="1"/><GenericConstraintCorrection/>')
    run = Run(root('<FreeMotionAnimationLoop/><GenericConstraintSolver/>' + stop), 2)
    run.says("depends on the order of constraints")
    assert "contact" not in run.text, run.text


main()
