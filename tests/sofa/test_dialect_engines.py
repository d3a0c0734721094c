# SPDX-License-Identifier: LGPL-2.1-or-later
"""Engines and regions in SOFA's dialect.
Usage: test_dialect_engines.py STROMA [WORD]."""
import itertools

import numpy as np

from dialect import (BODY, CUBE_PLACES, EXACT, Run, agree, case, differ, fallen, falls, main, node, numbers_of, placed,
                     root)
from reference import euler, gravity, hexahedra, together


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
    for roi, held in (('<PlaneROI name="r" plane="1 -1 -1  1 1 -1  1 1 1  0.5"/>', [1]),
                      ('<PairBoxROI name="r" inclusiveBox="0.5 -1 -1 4.5 1 1" includedBox="1.5 -1 -1 2.5 1 1"/>', [1, 3, 4]),
                      ('<MeshROI name="r" ROIposition="-1 -1 -1  2.5 -1 -1  -1 2.5 -1  -1 -1 2.5" '
                       'ROItriangles="0 2 1  0 1 3  1 2 3  2 0 3"/>', [0]),
                      ('<BoxROI name="r" box="8 8 8 9 9 9"/>', [])):
        run = Run(root(EXACT + line + roi + '<FixedConstraint indices="@r.indices"/>'), 10)
        agree(run.x()[:, 1], [0 if i in held else fallen(10) for i in range(5)])


@case
def corners_of_planes():
    """The second corner lies between the others; a parallelogram, in two planes and with half the depth to each side."""
    points = np.random.default_rng(5).uniform(-1, 1, (200, 3))
    planes = [(np.array([-0.6, -0.5, 0.1]), np.array([1.2, 0, 0.2]), np.array([0, 1, 0.3]), 0.8),
              (np.array([0.2, -0.9, -0.8]), np.array([0.1, 0.8, 0]), np.array([0.6, 0.2, 0.4]), 0.3)]

    def holds(plane, point):
        corner, one, other, depth = plane
        normal = np.cross(one, other)
        a, b, c = np.linalg.solve(np.column_stack([one, other, normal / np.linalg.norm(normal)]), point - corner)
        return 0 <= a <= 1 and 0 <= b <= 1 and abs(c) <= depth / 2
    text = "  ".join(f"{numbers_of(c)} {numbers_of(c + a)} {numbers_of(c + a + b)} {depth}" for c, a, b, depth in planes)
    agree(placed(f'<PlaneROI name="e" position="{numbers_of(points)}" plane="{text}"/>', "e.pointsInROI"),
          [p for p in points if any(holds(plane, p) for plane in planes)])


@case
def regions_ask_the_state_above():
    """Where there is neither a state nor a loader beside it, whatever mesh there is."""
    line = '<MechanicalObject name="dofs" position="0 0 0  1 0 0  2 0 0"/><UniformMass totalMass="3"/>'
    for roi in ('BoxROI name="r" box="0.5 -1 -1 1.5 1 1"', 'SphereROI name="r" centers="1 0 0" radii="0.5"',
                'PlaneROI name="r" plane="1 -1 -1  1 1 -1  1 1 1  0.5"'):
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


@case
def selections_of_nothing_that_stand_for_all():
    """Springs to the rest shape and constant forces: as those without a list."""
    none = '<BoxROI name="none" box="50 50 50 51 51 51"/>'
    for field, link, warning in (
            ('<RestShapeSpringsForceField stiffness="100" {}/>', 'points="@none.indices"', "points is empty: springs act on"),
            ('<ConstantForceField totalForce="1 2 3" {}/>', 'indices="@none.indices"', "indices is empty: the load acts on")):
        run = Run(root(EXACT + BODY + none + field.format(link)), 5)
        run.says(f"{warning} all 2 nodes of /dofs")
        agree(run.x(), Run(root(EXACT + BODY + field.format("")), 5).x())
        differ(run.x()[:, 1], [fallen(5)] * 2, 1e-5)


@case
def engines_of_random_numbers():
    run = Run(root('<TransformPosition name="e" method="random" maxRandomDisplacement="0.1" input_position="0 0 0  5 5 5"/>'
                   f'<Node name="a">{EXACT}<MechanicalObject name="dofs" position="@../e.output_position"/><UniformMass totalMass="1"/>'
                   '</Node>', 'gravity="0 0 0"'), 1)
    run.says("other random numbers")
    agree(run.x("a.dofs"), [[0, 0, 0], [5, 5, 5]], 0.03)
    differ(run.x("a.dofs"), [[0, 0, 0], [5, 5, 5]], 1e-6)


@case
def engines_that_nobody_reads():
    run = Run(root(EXACT + BODY + '<DisplacementMatrixEngine name="s" labels="1 2"/><NormEngine input="@s.indices"/>'
                   '<Node name="seen"><OglModel position="@../s.position"/></Node>'), 10)
    falls(run)
    run.says("DisplacementMatrixEngine, which nothing with an effect reads", "NormEngine")
    run = Run(root(EXACT + BODY + '<MeanComputation name="m"/><DataExchange name="d" from="@dofs.position" to="@dofs.rest_position"/>'), 10)
    falls(run)
    run.says("MeanComputation, which nothing with an effect reads", "copies values between parts of a scene")
    # what it would need is not there, which nobody misses
    run = Run(root('<SmoothMeshEngine input_position="0 0 0"/>' + EXACT + BODY), 10)
    falls(run)
    run.says("SmoothMeshEngine, which nothing with an effect reads")
    Run(root(EXACT + '<DisplacementMatrixEngine name="s"/><MechanicalObject position="@s.indices"/><UniformMass totalMass="1"/>'), 1).fails(
        2, "DisplacementMatrixEngine")


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
def regions_that_would_follow_a_body():
    run = Run(root(EXACT + BODY + '<BoxROI name="r" box="-1 -1 -1 0.5 1 1" position="@dofs.position"/><FixedConstraint '
                   'indices="@r.indices"/>'), 2)
    run.says("is read once", "in SOFA BoxROI follows /dofs")
    for more in ('position="@dofs.rest_position"', 'position="@dofs.position" doUpdate="0"'):
        run = Run(root(EXACT + BODY + f'<BoxROI name="r" box="-1 -1 -1 0.5 1 1" {more}/><FixedConstraint indices="@r.indices"/>'), 2)
        assert "is read once" not in run.text, run.text


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


@case
def regions_choose_of_all_that_a_topology_lists():
    """Edges and sides of cells that nobody writes: springs on those in a box are those on them written out."""
    tets = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 1)]
    cube = [(x, y, z) for z in range(2) for y in range(2) for x in range(2)]
    sides = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (1, 3, 7, 5), (3, 2, 6, 7), (2, 0, 4, 6)]
    pairs = {kind: [(a, b) for a in range(len(x)) for b in range(a + 1, len(x)) if near(a, b)] for kind, x, near in (
        ("tets", tets, lambda a, b: (a, b) != (0, 4)), ("cube", cube, lambda a, b: bin(a ^ b).count("1") == 1))}
    faces = [f for f in itertools.combinations(range(5), 3) if not {0, 4} <= set(f)]
    text = " ".join
    of_tets = f'position="{text(f"{a} {b} {c}" for a, b, c in tets)}" tetrahedra="0 1 2 3  1 2 3 4"'
    of_cube = f'position="{text(f"{a} {b} {c}" for a, b, c in cube)}" hexahedra="0 1 3 2 4 5 7 6"'
    meshes = [("tets", f"<{mesh} {of_tets}/>") for mesh in ("TetrahedronSetTopologyContainer", "MeshTopology")]
    meshes += [("cube", f"<{mesh} {of_cube}/>") for mesh in ("HexahedronSetTopologyContainer", "MeshTopology")]
    scene = ('{}{}<MechanicalObject name="dofs" velocity="{}"/><UniformMass totalMass="5"/><BoxROI name="roi" box="-1 -1 -1  {}"/>'
             '<Node name="n"><{}SetTopologyContainer position="@../dofs.position" {}="{}"/><MechanicalObject name="m"/><IdentityMapping/>'
             '<MeshSpringForceField stiffness="10"/></Node>')
    for kind, mesh in meshes:
        x = tets if kind == "tets" else cube
        v = text(f"{20 * a + c * c} {b} {9 * c * a}" for a, b, c in x)
        corners = {"edges": pairs[kind], "triangles": faces, "quads": sides}
        for part, name in (("Edge", "edges"), ("Triangle", "triangles") if kind == "tets" else ("Quad", "quads")):
            for top, inside in (("2 2 2", lambda p: True), ("2 2 0.5", lambda p: p[2] < 0.5)):
                chosen = text(text(map(str, f)) for f in corners[name] if all(inside(x[i]) for i in f))
                linked, given = (Run(node(scene.format(EXACT, mesh, v, top, part, name, cells)), 3).x()
                                 for cells in (f"@../roi.{name}InROI", chosen))
                agree(linked, given)
    start = Run(node(scene.format(EXACT, meshes[0][1], " ", "2 2 2", "Edge", "edges", "0 1")), 0).x()
    differ(given - np.array(cube) - 0.03 * np.array(v.split(), float).reshape(-1, 3), np.zeros((8, 3)), 1e-4)  # springs act
    agree(start, tets)
    grid = '<RegularGridTopology name="g" n="3 3 3" min="0 0 0" max="1 1 1"/>'
    agree(*(Run(node(scene.format(EXACT, grid, text(["1 0 0", "0 3 0", "0 0 2"] * 9), "2 2 2", "Edge", "edges", link)), 3).x()
            for link in ("@../roi.edgesInROI", "@../g.edges")))


@case
def regions_without_nodes():
    """A region that finds neither a state nor a loader does nothing in SOFA but tell. BoxROI, SphereROI and MeshROI begin with node 0, and
    keep it then; the others have no node."""
    child = f'<Node name="a">{EXACT}{BODY}<FixedProjectiveConstraint indices="@../r.indices"/></Node>'
    for region, held in (('<BoxROI name="r" box="-1 -1 -1 5 5 5"/>', [0]), ('<SphereROI name="r" centers="0 0 0" radii="9"/>', [0]),
                         ('<PlaneROI name="r" plane="-1 -1 0  5 -1 0  5 5 0  3"/>', []),
                         ('<SubsetTopology name="r" box="-1 -1 -1 5 5 5"/>', []),
                         ('<MeshTopology position="0 0 0  1 0 0  2 0 0"/><BoxROI name="r" box="0.5 -1 -1 5 5 5"/>', [0])):
        run = Run(root(region + child), 10)
        agree(run.x("a.dofs")[:, 1], [0.0 if n in held else fallen(10) for n in (0, 1)])
        run.says("scene.scn:1:", "/r: finds no state or loader to take nodes of: it" + ("s indices are node 0" if held else " selects nothing"))
    alone = '<Node name="Group"><BoxConstraint box="-1 -1 -1 5 5 5"/><BoxROI name="other" triangles="0 1 2"/></Node>'  # a prefab by itself
    run = Run(alone, 1)
    assert run.code == 0, run.text


@case
def a_region_beside_a_loader():
    """It takes the nodes of the file, where no state is beside it, and not those of a state above."""
    files = {"p.obj": "v 9 0 0\nv 0 0 0\nv 8 0 0\nf 1 2 3\n"}
    scene = root(f'{EXACT}<MechanicalObject name="dofs" position="0 0 0  1 0 0  2 0 0"/><UniformMass totalMass="3"/>'
                 '<FixedProjectiveConstraint indices="@b/r.indices"/>'
                 '<Node name="b"><MeshOBJLoader name="l" filename="p.obj"/><BoxROI name="r" box="-1 -1 -1 0.5 1 1"/></Node>')
    agree(Run(scene, 10, files).x()[:, 1], [fallen(10), 0, fallen(10)])


@case
def lists_of_quads_of_a_region():
    """SOFA calls them quad, quadInROI and computeQuad; pointIndices of a sphere are its indices."""
    mesh = '<MeshTopology name="m" position="0 0 0  1 0 0  1 1 0  0 1 0  2 0 0  2 1 0" quads="0 1 2 3  1 4 5 2"/>'
    body = f'{EXACT}{mesh}<MechanicalObject name="dofs"/><UniformMass totalMass="6"/>'
    region = '<BoxROI name="r" box="0.9 -1 -1 3 2 1" quad="@m.quads" computeQuad="1"/>'
    load = ('<Node name="c"><MeshTopology name="part" position="@../m.position" quads="@../r.quadInROI"/><MechanicalObject name="skin"/>'
            '<IdentityMapping/><QuadPressureForceField pressure="0 0 6" quadList="0"/></Node>')
    run = Run(node(body + region + load), 1)
    assert "quad" not in "".join(line for line in run.text.splitlines() if "warning" in line), run.text
    push = np.array([0, 1, 1, 0, 1, 1]) * 1.5 * 0.01 ** 2
    agree(run.x()[:, 2], push)
    ball = '<SphereROI name="r" centers="0 0 0" radii="0.5"/><FixedProjectiveConstraint indices="@r.pointIndices"/>'
    agree(Run(root(EXACT + BODY + ball), 10).x()[:, 1], [0, fallen(10)])


@case
def a_mapper_without_a_value():
    """IndexValueMapper then maps zeros."""
    mapper = '<IndexValueMapper name="m" indices="1" defaultValue="500"/>'
    springs = '<RestShapeSpringsForceField points="0 1" stiffness="@m.outputValues"/>'
    run = Run(root(mapper + EXACT + BODY + springs), 10)
    agree(run.x()[1, 1], fallen(10))  # has a spring of no stiffness
    differ(run.x()[0, 1], fallen(10), 1e-4)


main()
