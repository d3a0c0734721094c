# SPDX-License-Identifier: LGPL-2.1-or-later
"""Springs in SOFA's dialect, of edges, grids, angles, joints and lengths; and damping.
Usage: test_dialect_springs.py STROMA [WORD]."""
import itertools

import numpy as np

from dialect import (BODY, CHAIN, CHAIN_NODES, EXACT, LINKS, TWO, X4, X4_TEXT, Run, agree, case, differ, falls, main,
                     node, numbers_of, oriented, root)
from reference import (axes_of, euler, euler_frames, gravity, inverse, product, rotation_vector, springs, together,
                       turn_of)


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
def springs_in_a_range_of_nodes():
    """An end before the first node of localRange leaves a spring out, and so do two ends behind the last; each bound counts alone."""
    pairs = list(itertools.combinations(range(4), 2))
    for first, last in ((1, 2), (1, -1), (-1, 1), (2, 2), (-1, -1)):
        scene = root(EXACT + f'<MeshTopology position="{X4_TEXT}" tetrahedra="0 1 2 3"/><MechanicalObject name="dofs"/><UniformMass '
                     f'totalMass="4"/><MeshSpringForceField stiffness="500" localRange="{first} {last}"/><FixedConstraint indices="0 2"/>')
        kept = [pair for pair in pairs if min(pair) >= first and not (last >= 0 and min(pair) > last)]
        fields = together(gravity(np.ones(4), [0, -10, 0]), springs(kept, X4, 500))
        agree(Run(scene, 20).x(), euler(X4, np.eye(4), fields, 20, 0.01, held=[0, 2]), 1e-8)


@case
def springs_of_a_mesh_without_cells():
    mesh = '<MeshTopology position="0 0 0  1 0 0"/>' + BODY
    run = Run(root(EXACT + mesh + '<MeshSpringForceField stiffness="100"/>'), 10)
    run.says("there is no spring")
    falls(run)


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
def external_points_of_the_own_rest_shape():
    spring = '<RestShapeSpringsForceField points="{}" external_points="0" stiffness="10"/>'
    pulled = Run(root(EXACT + BODY + spring.format("0")), 10)
    agree(pulled.x(), Run(root(EXACT + BODY + spring.format("0").replace('external_points="0"', "")), 10).x())
    other = Run(root(EXACT + BODY + spring.format("1")), 10)  # another node than that of the spring: its number does not count
    agree(other.x(), Run(root(EXACT + BODY + spring.format("1").replace('external_points="0"', "")), 10).x())


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
    along = ('<MechanicalObject name="dofs" template="{}" position="{}" velocity="{}"/><UniformMass vertexMass="2"/>'
             '<DiagonalVelocityDampingForceField dampingCoefficient="{}"/>')
    way = lambda c: sum(0.01 / (1 + 0.01 * c / 2)**k for k in range(1, 21))  # noqa: E731
    numbers = [node(EXACT + along.format("Vec1", "0 0", "1 2", c)) for c in ("3", "3 5")]
    agree(Run(numbers[0], 20).x("dofs", 1)[:, 0], [way(3), 2 * way(3)])
    agree(Run(numbers[1], 20).x("dofs", 1)[:, 0], [way(3), 2 * way(5)])
    six = Run(node(EXACT + along.format("Vec6", "0 0 0 0 0 0", "1 1 1 1 1 1", "1 2 3 4 5 6")), 20)
    agree(six.x("dofs", 6)[0], [way(c) for c in range(1, 7)])
    # the last coefficients are those of all nodes beyond the list, and none damp nothing
    points = node(EXACT + along.format("Vec3", "0 0 0  0 0 0  0 0 0", "1 1 1  1 1 1  1 1 1", "1 2 3  4 5 6"))
    agree(Run(points, 20).x(), [[way(c) for c in of] for of in ((1, 2, 3), (4, 5, 6), (4, 5, 6))])
    free = Run(points.replace("1 2 3  4 5 6", ""), 20)
    agree(free.x(), np.full((3, 3), 0.2))
    free.says("has no coefficient: it does nothing")


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
    Run(node(EXACT + frames.format("3 0 0")), 1).fails(2, "has 3 numbers for 2 nodes", "expected 6 for all, or 6 of each")
    # its name since 2025, with a number for all that counts, or a vector for each
    nodal = frames.replace("DiagonalVelocity", "NodalLinear").replace("dampingCoefficient=", "{}=")
    agree(Run(node(EXACT + nodal.format("dampingCoefficientVector", "3 0 0 0 0 1  0 2 0 0 0 4")), 20).x("dofs", 7), [end(3, 0, 1), end(0, 2, 4)])
    agree(Run(node(EXACT + nodal.format('dampingCoefficientVector="1 1 1 1 1 1" dampingCoefficient', "2")), 20).x("dofs", 7), [end(2, 2, 2)] * 2)
    agree(Run(node(EXACT + BODY.replace('1 0 0"', '1 0 0" velocity="0 3 0"') + '<NodalLinearDampingForceField dampingCoefficient="4"/>'), 1).x()[:, 1],
          [0.01 * 3 / (1 + 0.01 * 4)] * 2)


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
def nodes_that_attract_each_other_and_keep_apart():
    """All pairs below dmax; pulls up to fmax, the tangent along the pair alone, and damping outside of it."""
    x = np.array([[0, 0, 0], [1.1, 0, 0], [0.5, 0.9, 0], [0.6, 0.4, 1], [0.7, 2.4, 0.3]])
    v = np.array([[0, 0.3, 0], [0.1, 0, 0], [0, -0.4, 0.2], [0, 0, -0.5], [0.2, 0, 0]])

    def field(pull, push, alpha, beta, reach, most, c, whole=False):
        def forces(x, v):
            f, K = np.zeros_like(x), np.zeros((x.size, x.size))
            for i, j in itertools.combinations(range(len(x)), 2):
                d = np.linalg.norm(x[j] - x[i])
                if d >= reach:
                    continue
                n = (x[j] - x[i]) / d
                t = min(pull(d) - push(d), most)
                slope = 0 if t == most else -((alpha + 1) * pull(d) - (beta + 1) * push(d)) / d
                force = t * n + c * (v[j] - v[i])
                f[i] += force
                f[j] -= force
                block = slope * np.outer(n, n) + whole * t / d * (np.eye(3) - np.outer(n, n))
                for a, b, sign in ((i, i, -1), (j, j, -1), (i, j, 1), (j, i, 1)):
                    K[3 * a:3 * a + 3, 3 * b:3 * b + 3] += sign * block
            return f, K
        return forces

    def molecules(alpha=6, beta=12, d0=1.0, p0=1.0, reach=2.0, most=1.0, c=0.0, whole=False):
        a, b = p0 * d0 ** alpha / (1 - alpha / beta), p0 * d0 ** beta / (beta / alpha - 1)
        return field(lambda d: a * alpha / d ** (alpha + 1), lambda d: b * beta / d ** (beta + 1), alpha, beta, reach, most, c, whole)
    body = (f'<MechanicalObject name="dofs" position="{numbers_of(x)}" velocity="{numbers_of(v)}"/><UniformMass totalMass="5"/>'
            '<LennardJonesForceField {}/>')
    ways = (("", molecules()), ('fmax="1.5" dmax="2.2" d0="0.95" p0="0.8" damping="0.3"', molecules(d0=0.95, p0=0.8, reach=2.2, most=1.5, c=0.3)),
            ('alpha="3" beta="7" fmax="100" dmax="9"', molecules(3, 7, reach=9, most=100)),
            ('p0="-0.8" fmax="1.5" dmax="2.2"', molecules(p0=-0.8, reach=2.2, most=1.5)),
            ('aInit="0.7" alpha="1" beta="0" fmax="0.5" dmax="5"', field(lambda d: 0.7 / d ** 2, lambda d: 0, 1, 0, 5, 0.5, 0)))
    for words, forces in ways:
        expected = euler(x, np.eye(5), together(gravity(np.ones(5), [0, -10, 0]), forces), 30, 0.01, v=v)
        agree(Run(root(EXACT + body.format(words)), 30).x(), expected, 1e-9)
        assert np.abs(expected - euler(x, np.eye(5), gravity(np.ones(5), [0, -10, 0]), 30, 0.01, v=v)).max() > 0.01
    whole = euler(x, np.eye(5), together(gravity(np.ones(5), [0, -10, 0]), molecules(3, 7, reach=9, most=100, whole=True)), 30, 0.01, v=v)
    agree(Run(root(EXACT + body.format(ways[2][0])), 30, args=["--without-quirk", "torsion-tangent"]).x(), whole, 1e-9)
    differ(Run(root(EXACT + body.format(ways[2][0])), 30).x(), whole, 1e-6)


main()
