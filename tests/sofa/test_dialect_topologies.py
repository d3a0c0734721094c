# SPDX-License-Identifier: LGPL-2.1-or-later
"""Meshes in SOFA's dialect: grids, containers, loaders, and the mappings that fill them.
Usage: test_dialect_topologies.py STROMA [WORD]."""
import itertools
import re

import numpy as np

from dialect import (BODY, CUBE, CUBE_PLACES, EXACT, PLACES, X4, X4_TEXT, Run, agree, case, differ, fallen, falls,
                     main, node, placed, root, voxels)
from reference import euler, gravity, hexahedra, load, membrane, springs, tetrahedra, together


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
    planned('useDataInputs="1" pointsToRemove="3"', 3).fails(3, "point 3 cannot be removed: one of the tetrahedra still uses it", "step 2 ")
    planned('filename="none.txt"', 1).fails(2, "none.txt")
    for text, word in (("REMOVE= 1\n0\n", "before any time"), ("T=0.05\n", "before any time"), ("\nT= soon\n", ":2: "),
                       ("T=\n", "no time"), ("T= 1\nREMOVE Tetrahedron 1 0\n", "no change"), ("T= 1\nREMOVE= 2\n0\n", "1 numbers")):
        planned('filename="other.txt"', 1, {"other.txt": text}).fails(2, "other.txt:", word)
    planned('filename="other.txt.gz"', 1, {"other.txt.gz": ""}).fails(2, "compressed")
    left(planned('filename="other.txt"', 9, {"other.txt": "\n"}), 9, list(range(12)))
    planned('filename="cut.txt"', 5, {"cut.txt": "T= 0.03\nINCISE= 2\n0 0 0 0 1 1 1 1\n"}).fails(3, "along a path", "step 4 ")


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
def balls_of_a_file_that_counts_them():
    run = Run(root(EXACT + '<SphereLoader name="loader" filename="two.sph"/><MechanicalObject name="dofs" '
                   'position="@loader.position"/><UniformMass totalMass="2"/>'), 0, files={
                       "two.sph": "sph 1.0\nnums 2\nsphe 0 1 2 3 0.5\nsphe 1 4 5 6 0.25\n"})
    agree(run.x(), [[1, 2, 3], [4, 5, 6]])
    assert "cut off" not in run.text, run.text
    for told in ("3", "x"):
        Run(root(EXACT + '<SphereLoader name="loader" filename="two.sph"/><MechanicalObject name="dofs" position="@loader.position"/>'
                 '<UniformMass totalMass="2"/>'), 0, files={"two.sph": f"sph 1.0\nnums {told}\nsphe 0 1 2 3 0.5\n"}).says(
                     f"declares {told} spheres, and contains 1")


@case
def lists_of_a_grid_that_links_name():
    grid = '<RegularGridTopology name="grid" n="3 1 1" min="0 0 0" max="2 0 0"/><MechanicalObject name="dofs"/><UniformMass totalMass="3"/>'
    child = ('<Node name="e"><EdgeSetTopologyContainer name="e" edges="@../grid.edges"/><MechanicalObject name="y" template="Vec1"/>'
             '<DistanceMapping topology="@e" computeDistance="1"/><RestShapeSpringsForceField stiffness="0"/></Node>')
    agree(Run(root(EXACT + grid + child), 1).x("e.y", 1), [[1], [1]])


@case
def tools_that_carve_nothing():
    for active in ("", 'active="0"'):
        falls(Run(root(EXACT + BODY + f'<CarvingManager {active} carvingDistance="0.1"/>'), 10))
    run = Run(root(EXACT + BODY + '<CarvingManager active="1"/>'), 10)
    falls(run)
    run.says("warning", "here nothing is removed")


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


X4_UNIT = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])


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


@case
def meshes_of_topologies_in_older_formats():
    """A topology reads .xs3 and .trian itself; models that draw volumes are no parts."""
    net = "Xsp 3.0\nnumm 2\nmass 1 v 0 0 0 0 0 0 1 1\nmass 2 v 1.5 0 0 0 0 0 1 1\nlnks 1\nlspg 1 1 2 100 0 1\n"
    scene = root(EXACT + '<MeshTopology filename="net.xs3"/><MechanicalObject name="dofs"/><UniformMass totalMass="2"/>'
                 '<OglVolumetricModel name="v"/><IdentityMapping output="@v"/><CollisionGroup/>')
    run = Run(scene, 10, files={"net.xs3": net})
    agree(run.x()[:, 0], [0, 1.5])
    falls(run)


@case
def middles_of_hexahedra():
    grid = '<RegularGridTopology name="grid" n="3 2 2" min="0 0 0" max="2 1 1"/><MechanicalObject name="dofs"/><UniformMass totalMass="12"/>'
    child = ('<Node name="middles"><PointSetTopologyContainer name="cloud"/><CenterPointTopologicalMapping input="@../grid" '
             'output="@cloud"/><MechanicalObject name="seen"/><CenterPointMechanicalMapping/></Node>')
    agree(Run(root(EXACT + grid + child), 10).x("middles.seen"), [[0.5, 0.5 + fallen(10), 0.5], [1.5, 0.5 + fallen(10), 0.5]])


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
def grids_without_thickness():
    """SOFA has two nodes at each place then."""
    run = Run(root(EXACT + '<RegularGridTopology n="3 2 2" min="0 0 0" max="2 0 1"/><MechanicalObject name="dofs"/><UniformMass '
                   'totalMass="2"/>'), 10)
    agree(run.x(), [[i, fallen(10), k] for k in (0, 1) for _ in (0, 1) for i in (0, 1, 2)])
    Run.of_native('<Node name="root"><RegularGridTopology n="3 2 2" min="0 0 0" max="2 0 1"/></Node>', 1).fails(2, "the box is 0 long in y")


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


main()
