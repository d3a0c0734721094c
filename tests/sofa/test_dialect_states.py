# SPDX-License-Identifier: LGPL-2.1-or-later
"""States in SOFA's dialect, how many nodes they have and where they start; and what SOFA creates and leaves idle. Usage:
test_dialect_states.py STROMA [WORD]."""
import numpy as np

from dialect import BODY, EXACT, Run, agree, case, differ, fallen, main, node, root

MESH = '<MeshTopology position="1 2 3  4 5 6  7 8 9" edges="0 1  1 2"/>'


@case
def numbers_beside_a_mesh_start_with_its_coordinates():
    """DataTypes::set() of a Vec1 takes the first coordinate; what is written, or a size, counts before it."""
    flow = '<EulerImplicitSolver firstOrder="1"/><SparseLDLSolver/>'
    for given, x in (("", [1, 4, 7]), ('position="5"', [1, 4, 7]), ('size="3"', [0, 0, 0]), ('position="3 2 1"', [3, 2, 1])):
        run = Run(node(f'{flow}{MESH}<MechanicalObject name="dofs" template="Vec1" {given}/><UniformMass totalMass="3"/>'), 1)
        agree(run.x("dofs", 1)[:, 0], x)
        assert ("/dofs: starts with the coordinates of" in run.text) == (x == [1, 4, 7])


@case
def numbers_that_a_mapping_places_are_its_own():
    mapped = Run(root(EXACT + BODY + '<Node name="d"><MeshTopology position="0 0 0  1 0 0" edges="0 1"/><MechanicalObject name="n" '
                      'template="Vec1"/><DistanceMapping/></Node>'), 1)
    agree(mapped.x("d.n", 1), [[0]])


@case
def nodes_without_a_velocity_have_the_last():
    three = '<MechanicalObject name="dofs" position="0 0 0  1 0 0  2 0 0" velocity="0 0 0  0 1 0"/><UniformMass totalMass="3"/>'
    run = Run(node(EXACT + three), 10)
    agree(run.x()[:, 1], [0, 0.1, 0.1])
    run.says("velocity: has 2 of 3 nodes: the others have the last one, as in SOFA")
    of_mesh = Run(node(EXACT + MESH + '<MechanicalObject name="dofs" velocity="0 0 0  0 1 0"/><UniformMass totalMass="3"/>'), 10)
    agree(of_mesh.x()[:, 1], [2, 5.1, 8.1])
    frames = ('<MechanicalObject name="dofs" template="Rigid3" position="0 0 0 0 0 0 1  1 0 0 0 0 0 1  2 0 0 0 0 0 1" '
              'velocity="0 0 0 0 0 0  0 1 0 0 0 0"/><UniformMass totalMass="3"/>')
    agree(Run(node(EXACT + frames), 10).x("dofs", 7)[:, 1], [0, 0.1, 0.1])


@case
def more_velocities_than_positions_make_nodes_at_the_origin():
    run = Run(node(EXACT + '<MechanicalObject name="dofs" position="1 0 0" velocity="0 1 0  0 2 0"/><UniformMass totalMass="2"/>'), 10)
    agree(run.x(), [[1, 0.1, 0], [0, 0.2, 0]])
    run.says("velocity: has 2 nodes and position 1: the others are at the origin, as in SOFA")


@case
def what_has_nothing_to_do_does_nothing():
    """SOFA creates it, and its part of the force is zero."""
    quad = '<MeshTopology position="0 0 0  1 0 0  1 1 0  0 1 0" quads="0 1 2 3" triangles="0 1 2  0 2 3"/>'
    body = quad + '<MechanicalObject name="dofs"/><UniformMass totalMass="4"/>'
    for field, word in (("QuadPressureForceField", "no pressure"), ('QuadPressureForceField quadList="0"', "no pressure"),
                        ('TrianglePressureForceField triangleList="0 1"', "no pressure"),
                        ("PositionBasedDynamicsProjectiveConstraint", "no places to go to")):
        run = Run(root(f"{EXACT}{body}<{field}/>"), 5)
        agree(run.x()[:, 1], [y + fallen(5) for y in (0, 0, 1, 1)])
        run.says(word, "it does nothing")
    springs = Run(root(EXACT + BODY + '<MeshSpringForceField stiffness="10"/>'), 5)
    agree(springs.x()[:, 1], [fallen(5)] * 2)
    springs.says("has no mesh that gives springs: it does nothing")
    frame = '<MechanicalObject name="dofs" template="Rigid3" position="0 0 0 0 0 0 1"/><UniformMass totalMass="1"/><FrameSpringForceField/>'
    agree(Run(root(EXACT + frame), 5).x("dofs", 7)[0, 1], fallen(5))


@case
def forces_over_time_act_on_frames_and_numbers():
    """Linear from 0 to 2 N over 0.1 s, taken where a step starts, as in SOFA: v_n = h sum_k 20 k h/m, k < n."""
    h, steps, push = 0.01, 5, '<LinearForceField indices="0" times="0 0.1" forces="{}"/>'
    v = np.cumsum([20 * h * k * h for k in range(steps)])
    x = h * v.sum()
    frame = ('<MechanicalObject name="dofs" template="Rigid3" position="0 0 0 0 0 0 1"/><UniformMass vertexMass="2 1 [1 0 0,0 1 0,0 0 2]"/>'
             + push.format("0 0 0 0 0 0  0 2 0 0 0 2"))
    found = Run(node(EXACT + frame), steps).x("dofs", 7)[0]
    agree(found[:3], [0, x / 2, 0])
    agree(2 * np.arcsin(found[5]), x / 4)  # the inertia is that of the file times the mass
    numbers = Run(node(EXACT + '<MechanicalObject name="dofs" template="Vec1" position="0 1"/><UniformMass totalMass="2"/>' + push.format("0 2")), steps)
    agree(numbers.x("dofs", 1)[:, 0], [x, 1])
    Run(node(EXACT + BODY + push.format("0 0 0  1 0")), 1).fails(2, "forces has 5 numbers", "3 for each time")


@case
def a_normal_alone_chooses_no_triangles():
    """Planes choose where dmin and dmax differ: the list counts."""
    body = ('<MeshTopology position="0 0 0  1 0 0  0 1 0" triangles="0 1 2"/><MechanicalObject name="dofs"/><UniformMass totalMass="3"/>'
            '<TrianglePressureForceField triangleList="0" pressure="0 0 6" {}/>')
    plain, normal = (Run(node(EXACT + body.format(given)), 3) for given in ("", 'normal="0 0 1"'))
    agree(normal.x(), plain.x())
    agree(plain.x()[:, 2], [1 * 0.01**2 * 6] * 3)  # f/m = 6/2/3, n (n + 1)/2 = 6
    normal.says("TrianglePressureForceField.normal without dmin and dmax")


@case
def containers_list_edges_and_sides_for_who_reads_them():
    """Two tetrahedra that share a side: springs on each of their nine edges, once, and on their seven triangles."""
    x = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]]
    edges = [(a, b) for a in range(5) for b in range(a + 1, 5) if (a, b) != (0, 4)]
    places = " ".join(f"{a} {b} {c}" for a, b, c in x)
    body = (f'<TetrahedronSetTopologyContainer name="T" position="{places}" tetrahedra="0 1 2 3  1 2 3 4"/><MechanicalObject name="dofs" '
            'velocity="{}"/><UniformMass totalMass="5"/>').format(" ".join(f"{20 * a} {b} {c}" for a, b, c in x))
    part = ('<Node name="n"><{} name="S" position="@../T.position" {}="{}"/><MechanicalObject name="m"/><IdentityMapping/>'
            '<MeshSpringForceField {}Stiffness="10"/></Node>')
    listed = " ".join(f"{a} {b}" for a, b in edges)
    linked, given = (Run(node(EXACT + body + part.format("EdgeSetTopologyContainer", "edges", text, "lines")), 3).x()
                     for text in ("@../T.edges", listed))
    agree(linked, given)
    triangles = Run(node(EXACT + body + part.format("TriangleSetTopologyContainer", "triangles", "@../T.triangles", "triangles")), 3).x()
    agree(triangles, given)  # whose sides are the same edges, each once
    differ(given, Run(node(EXACT + body), 3).x(), 1e-3)


@case
def other_lines_of_a_file_of_spheres_are_left_out():
    text = "sph 1.0\nnumm 0\nnums 1\nsphe 0 1 2 3 0.5\nlink 0 0\n"
    run = Run(root(EXACT + '<SphereLoader name="l" filename="s.sph"/><MechanicalObject name="dofs" position="@l.position"/>'
                   '<UniformMass totalMass="2"/>'), 0, {"s.sph": text})
    agree(run.x(), [[1, 2, 3]])
    run.says("s.sph:2: 'numm 0' is not read")


main()
