# SPDX-License-Identifier: LGPL-2.1-or-later
"""States in SOFA's dialect, how many nodes they have and where they start; and what SOFA creates and leaves idle.
Usage: test_dialect_states.py STROMA [WORD]."""
import re

import numpy as np

from dialect import BODY, CORNERS, CUBE, EXACT, RUNS, Run, agree, case, differ, fallen, falls, main, node, root
from reference import euler, gravity, load, springs, tetrahedra, together

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
    longer = Run(node(EXACT + MESH + '<MechanicalObject name="dofs" velocity="0 0 0  0 1 0  0 2 0  0 3 0"/><UniformMass totalMass="3"/>'), 10)
    agree(longer.x()[:, 1], [2, 5.1, 8.2])
    longer.says("velocity has 4 nodes and the mesh 3: the others are ignored, as in SOFA")
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


@case
def what_nothing_moves_stays():
    run = Run(root(f'<Node name="a">{EXACT}{BODY}</Node><Node name="b">{BODY}<FixedConstraint/></Node>'
                   f'<Node name="c" activated="0">{BODY}<Nonsense/></Node>'), 10)
    falls(run, "a.dofs")
    run.says("no integrator moves anything")


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


@case
def a_scene_that_nothing_moves():
    """As files of objects that other scenes include: what is mapped from them stays too."""
    part = ('<Node name="tips"><MechanicalObject name="dofs" position="1 0 0"/><RigidMapping/>'
            '<RestShapeSpringsForceField stiffness="10"/></Node>')
    run = Run(root('<MechanicalObject name="frame" template="Rigid3" position="0 2 0 0 0 0 1"/><UniformMass totalMass="1"/>' + part), 5)
    agree(run.x("tips.dofs"), [[1, 2, 0]])


@case
def velocities_that_loaders_have_not():
    scene = root(EXACT + '<SphereLoader name="loader" filename="two.sph"/><MechanicalObject name="dofs" position="@loader.position" '
                 'velocity="@loader.velocity"/><UniformMass totalMass="2"/>')
    run = Run(scene, 10, {"two.sph": "sph 1.0\nsphe 0 0 0 0 0.5\nsphe 1 3 0 0 0.25\n"})
    falls(run)
    run.says("has no velocities in SOFA either")


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
def states_of_files_need_no_integrator():
    """A recorded motion of what others touch or hang on; after its end it stays where it is."""
    file = "".join(f"T= {0.01 * n}\n  X= {n * n} 0 0 {n} 1 0\n  V= {2 * n} 0 0 1 0 0\n" for n in range(11))
    scene = node('<Node name="tool"><MechanicalObject name="dofs" position="0 0 0  0 1 0"/><ReadState filename="tool.state"/></Node>')
    for steps, n in ((4, 4), (10, 10), (25, 10)):
        run = Run(scene, steps, {"tool.state": file})
        agree(run.x("tool.dofs"), [[n * n, 0, 0], [n, 1, 0]])
        assert "warning" not in run.text, run.text


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
def a_subset_of_another_number_of_nodes():
    """SOFA gives the state that follows as many nodes as indices has, whatever is written."""
    three = EXACT + '<MechanicalObject name="dofs" position="0 0 0  1 0 0  2 3 0"/><UniformMass totalMass="3"/>'
    child = '<Node name="c"><MechanicalObject name="s" {}/><SubsetMapping indices="2 1"/></Node>'
    for written in ('position="9 9 9"', 'position="9 9 9  8 8 8  7 7 7  6 6 6"', 'size="5"', ""):
        run = Run(root(three + child.format(written)), 5)
        agree(run.x("c.s"), np.add([[2, 3, 0], [1, 0, 0]], [0, fallen(5), 0]))


main()
