# SPDX-License-Identifier: LGPL-2.1-or-later
"""Mappings in SOFA's dialect: the cell that holds a point, lines, sets of nodes.
Usage: test_dialect_mappings.py STROMA [WORD]."""
import itertools

import numpy as np

from dialect import BODY, EXACT, Run, agree, case, differ, fallen, falls, main, node, numbers_of, oriented, root
from reference import euler, gravity, springs, together


@case
def mappings_that_pass_no_forces_on():
    for word in ('isMechanical="0"', 'mapForces="false"'):
        falls(Run(root(EXACT + BODY + '<Node name="seen"><MechanicalObject name="dofs" position="0 0 0  1 0 0"/>'
                       f'<IdentityMapping {word}/><ConstantForceField indices="0" forces="0 99 0"/></Node>'), 10))
    differ(Run(root(EXACT + BODY + '<Node name="seen"><MechanicalObject name="dofs" position="0 0 0  1 0 0"/>'
                    '<IdentityMapping isMechanical="1"/><ConstantForceField indices="0" forces="0 99 0"/></Node>'), 10).x()[0, 1],
           fallen(10), 0.1)


@case
def weakly_fixed():
    def held(x, v):
        return -100 * (x - [[0, 0, 0], [1, 0, 0]]), -100 * np.eye(6)
    both = euler([[0, 0, 0], [1, 0, 0]], np.eye(2), together(gravity(np.ones(2), [0, -10, 0]), held), 10, 0.01)
    agree(Run(root(EXACT + BODY + '<FixedWeakConstraint fixAll="1" stiffness="100"/>'), 10).x(), both)
    first = Run(root(EXACT + BODY + '<FixedWeakConstraint stiffness="100"/>'), 10).x()
    agree(first, [both[0], [1, fallen(10), 0]])


@case
def lengths_of_the_edges_of_a_grid():
    """A grid in SOFA has its lines, and the diagonals of its faces, for whoever names it: here four sides and a diagonal."""
    scene = root(EXACT + '<RegularGridTopology name="grid" n="2 2 1" min="0 0 0" max="1 1 0"/><MechanicalObject name="dofs"/>'
                 '<UniformMass totalMass="4"/><FixedConstraint indices="0 1"/><Node name="lengths"><MechanicalObject template="Vec1"/>'
                 '<DistanceMapping topology="@../grid" geometricStiffness="Exact"/><RestShapeSpringsForceField stiffness="100"/></Node>')
    X = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]], float)
    sides = [(0, 1), (0, 2), (1, 3), (2, 3)]  # springs() divides by lengths
    fields = together(gravity(np.ones(4), [0, -10, 0]), springs(sides, X, 100), springs([(0, 3)], X, 100 * np.sqrt(2)))
    agree(Run(scene, 10).x(), euler(X, np.eye(4), fields, 10, 0.01, held=[0, 1]), 1e-7)


@case
def points_of_edges_in_the_order_of_cells():
    """Edges that a mesh does not list: of tetrahedra, then hexahedra, else of triangles (from the side across their first node on)
    and quads, as they come."""
    rng = np.random.default_rng(3)
    nodes = rng.uniform(size=(9, 3))
    tet, hexa = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)], [(0, 1), (0, 3), (0, 4), (1, 2), (1, 5), (2, 3), (2, 6), (3, 7), (4, 5),
                                                                   (4, 7), (5, 6), (6, 7)]
    turns = {n: [((j + 1) % n, (j + 2) % n) for j in range(n)] for n in (3, 4)}
    for kind, container, lists in (("triangles", "TriangleSetTopologyContainer", [((5, 2, 7), turns[3]), ((7, 2, 1), turns[3])]),
                                   ("quads", "QuadSetTopologyContainer", [((3, 1, 7, 4), turns[4])]),
                                   ("tetrahedra", "TetrahedronSetTopologyContainer", [((4, 0, 7, 2), tet), ((7, 5, 2, 4), tet)]),
                                   ("hexahedra", "HexahedronSetTopologyContainer", [((8, 3, 1, 0, 2, 7, 6, 5), hexa)])):
        edges = []
        for cell, sides in lists:
            for a, b in sides:
                edge = tuple(sorted((cell[a], cell[b])))
                if edge not in edges:
                    edges.append(edge)
        cells = "  ".join(" ".join(map(str, cell)) for cell, _ in lists)
        run = Run(root(EXACT + f'<{container} name="cells" position="{numbers_of(nodes)}" {kind}="{cells}"/><MechanicalObject name="dofs"/>'
                       '<UniformMass totalMass="1"/><Node name="points"><PointSetTopologyContainer name="cloud"/>'
                       '<Mesh2PointTopologicalMapping input="@../cells" output="@cloud" edgeBaryCoords="0.25 0 0"/>'
                       '<MechanicalObject name="dofs"/><Mesh2PointMechanicalMapping/></Node>', 'gravity="0 0 0"'), 1)
        agree(run.x("points.dofs"), [0.75 * nodes[a] + 0.25 * nodes[b] for a, b in edges])


def weights_of_lines(point, frames, lines, k):
    def weight(a, b):
        places = frames[a, :3] + np.linspace(0, 1, 1001)[:, None] * (frames[b, :3] - frames[a, :3])
        return np.sum(np.linalg.norm(places - point, axis=1)**-float(k)) * np.linalg.norm(frames[b, :3] - frames[a, :3]) / 1000
    return np.array([weight(*line) for line in lines])


@case
def points_that_follow_lines():
    """As those that follow the frames at the first nodes of the lines, by the integrals of 1/d^k over them."""
    frames = np.array([[0, 0, 0, *oriented([1, 2, 0], 0.4)], [1, 0.1, 0, *oriented([0, 1, 1], -0.7)], [2, 0, 0.2, *oriented([1, 0, 0], 0.2)],
                       [3, 0, 0, *oriented([1, 1, 1], 1.0)], [4, 0.5, 0, *oriented([0, 0, 1], 1.0)]])
    lines = [(0, 1), (1, 2), (2, 3), (3, 4)]
    points = np.array([[0.3, 0.5, 0.1], [1.4, -0.4, 0.2], [2.5, 0.2, 0.6], [3.5, 0.05, 2.0], [0.9, 0.3, -0.5]])
    scene = node(EXACT + '<MeshTopology name="bones" position="0 0 0  1 0 0  2 0 0  3 0 0  4 0 0" lines="0 1  1 2  2 3  3 4"/>'
                 f'<MechanicalObject name="dofs" template="Rigid3d" position="{numbers_of(frames)}"/>'
                 '<UniformMass vertexMass="1.5 1 [0.2 0 0,0 0.3 0,0 0 0.4]"/><FixedConstraint indices="0"/><Node name="c">'
                 f'<MechanicalObject name="skin" position="{numbers_of(points)}"/>{{}}<RestShapeSpringsForceField stiffness="60"/>'
                 '<ConstantForceField totalForce="3 -2 5"/></Node>')
    for more, k, most, level in (("", 4, 4, 3), ('weightCoef="2" numberInfluencedLines="2"', 2, 2, 3),
                                 ('numberInfluencedLines="3" neighborhoodLevel="1"', 4, 3, 1)):
        indices, weights = [], []
        for point in points:
            w = weights_of_lines(point, frames, lines, k)
            order = np.argsort(-w)
            near = [line for line in order if abs(line - order[0]) <= level][:most]  # of a chain
            near += [near[0]] * (most - len(near))
            shares = [w[line] if line not in near[:i] else 0 for i, line in enumerate(near)]
            indices += [lines[line][0] for line in near]
            weights += list(np.array(shares) / sum(shares))
        named = f'<SkinningMapping nbRef="{most}" indices="{" ".join(map(str, indices))}" weight="{" ".join(map(str, weights))}"/>'
        run, other = Run(scene.format(f"<LineSetSkinningMapping {more}/>"), 6), Run(scene.format(named), 6)
        agree(run.x("c.skin"), other.x("c.skin"))
        agree(run.x("dofs", 7), other.x("dofs", 7))


@case
def numbers_without_a_weight():
    body = EXACT + '<MechanicalObject name="dofs" template="Vec1" position="0 1"/><UniformMass totalMass="2"/>'
    for gravity_, more, told in (("-10 0 0", "", True), ("0 -10 0", "", False), ("0 0 0", '<Gravity gravity="1 0 0"/>', True)):
        run = Run(root(more + body, f'gravity="{gravity_}"'), 1)
        assert ("numbers have a weight" in run.text) == told, run.text
    sixes = EXACT + '<MechanicalObject name="dofs" template="Vec6" position="0 1 2 3 4 5"/><UniformMass totalMass="2"/>'
    Run(root(sixes, 'gravity="0 -10 0"'), 1).says("numbers have a weight")


@case
def points_on_surfaces_and_lines():
    """They start at their feet on the body, and share forces with its nodes."""
    square = '<MechanicalObject name="d" position="0 0 0  2 0 0  2 2 0  0 2 0"/><UniformMass totalMass="4"/>'
    child = ('<Node name="c"><MechanicalObject name="dofs" position="0.5 0.5 0.1"/><BarycentricMapping/>'
             '<ConstantForceField forces="0 0 8"/></Node>')
    push = 0.01**2 * 8
    for cells, shares in (('quads="0 1 2 3"', [9 / 16, 3 / 16, 1 / 16, 3 / 16]), ('triangles="0 1 3  1 2 3"', [1 / 2, 1 / 4, 0, 1 / 4]),
                          ('edges="0 1  1 2"', [3 / 4, 1 / 4, 0, 0])):
        body = f'<MeshTopology position="0 0 0  2 0 0  2 2 0  0 2 0" {cells}/>'
        run = Run(node(EXACT + body + square + child), 1)
        agree(run.x("d")[:, 2], np.array(shares) * push)
        foot = [0.5, 0 if "edges" in cells else 0.5, push * np.dot(shares, shares)]
        agree(run.x("c.dofs"), [foot])


@case
def a_follower_pulls_nobody():
    """SOFA attaches one way unless twoWay is given: the push on the second node reaches nobody, and the first loses half of what it
    gains in a step; or half of the push reaches the first."""
    pair = ('<MechanicalObject name="dofs" position="0 0 0  1 0 0"/><UniformMass totalMass="4"/>'
            '<ConstantForceField indices="1" forces="0 8 0"/><AttachProjectiveConstraint indices1="0" indices2="1" {}/>')
    y = v = 0
    for _ in range(10):
        y += 0.01 * (v - 0.1)
        v -= 0.1 / 2
    for given in ("", 'twoWay="0"'):
        agree(Run(root(EXACT + pair.format(given)), 10).x()[0, 1], y)
    agree(Run(root(EXACT + pair.format("")), 10, args=["--without-quirk", "moved-inertia"]).x()[0, 1], fallen(10))
    agree(Run(root(EXACT + pair.format('twoWay="1"')), 10).x()[:, 1], [fallen(10, g=8.0)] * 2)


def weights_by_centres(cells, x, p, width=0):
    """Of the cell in which p lies deepest, else of that with the nearest centre; in a grid of `width` first in the cells near by."""
    def affine(cell):
        edges = np.array([x[n] - x[cell[0]] for n in cell[1:]])
        if len(edges) == 2:
            edges = np.vstack([edges, np.cross(*edges)])
        return np.linalg.solve(edges.T, p - x[cell[0]])

    def keys(point):
        return np.floor(np.asarray(point) / width).astype(int)

    def near(cell, key, reach):
        low, high = keys(x[list(cell)].min(axis=0)), keys(x[list(cell)].max(axis=0))
        return all(low[a] <= key[a] + reach and high[a] >= key[a] - reach for a in range(3))

    best = None
    for reach in ((0, 1) if width else ()) + (None,):
        if best is not None and (reach is None or abs(best[0]) <= width / 2):
            break
        for cell in cells:
            if reach is not None and not near(cell, keys(p), reach):
                continue
            u = affine(cell)
            out = max(-u[0], -u[1], -u[2], u.sum() - 1) if len(cell) == 4 else max(-u[0], -u[1], abs(u[2]) - 0.01, u[0] + u[1] - 1)
            if out > 0:
                out = ((p - x[list(cell)].mean(axis=0)) ** 2).sum()
            if best is None or out < best[0]:
                best = out, cell, u
    cell, u = best[1], best[2][:len(best[1]) - 1]
    row = np.zeros(len(x))
    row[list(cell)] = [1 - u.sum(), *u]
    return row


@case
def quirk_centre_cells():
    random = np.random.default_rng(7)
    x = np.array([[i, j, k] for k in range(2) for j in range(2) for i in range(3)], float) + random.uniform(-0.2, 0.2, (12, 3))
    cells = []
    for i in range(2):
        for order in itertools.permutations((1, 3, 6)):
            cell = [i, i + order[0], i + order[0] + order[1], i + 10]
            cells.append(cell if np.linalg.det(x[cell[1:]] - x[cell[0]]) > 0 else [cell[0], cell[2], cell[1], cell[3]])
    v, points = random.uniform(-3, 3, x.shape), random.uniform(-1, 3, (40, 3)) * [1, 0.7, 0.7]
    text = {name: " ".join(repr(float(n)) for n in np.ravel(each)) for name, each in (("x", x), ("v", v), ("p", points))}
    width = np.mean([np.linalg.norm(x[a] - x[b]) for a, b in {tuple(sorted(e)) for c in cells for e in itertools.combinations(c, 2)}])
    triangles = [cell[:3] for cell in cells[::2]]
    for mesh, kind, wide in (("MeshTopology", "tetrahedra", 0), ("TetrahedronSetTopologyContainer", "tetrahedra", width),
                             ("MeshTopology", "triangles", 0)):
        found = cells if kind == "tetrahedra" else triangles
        scene = node(EXACT + f'<{mesh} position="{text["x"]}" {kind}="{" ".join(str(n) for n in np.ravel(found))}"/>'
                     f'<MechanicalObject name="dofs" velocity="{text["v"]}"/><UniformMass totalMass="1"/><Node name="c"><MechanicalObject '
                     f'name="points" position="{text["p"]}"/><BarycentricMapping/></Node>')
        W = np.array([weights_by_centres(found, x, p, wide) for p in points])
        agree(Run(scene, 10).x("c.points"), W @ (x + 0.1 * v), 1e-9)
        differ(Run(scene, 10, args=["--without-quirk", "centre-cells"]).x("c.points"), W @ (x + 0.1 * v), 1e-3)
    grid = np.array([[i, j, k] for k in range(2) for j in range(2) for i in range(3)], float)
    W = np.zeros((len(points), 12))  # of the nearest cell of a grid, trilinear beyond it
    for row, p in zip(W, points):
        low = np.clip(np.floor(p).astype(int), 0, [1, 0, 0])
        for corner in itertools.product((0, 1), repeat=3):
            node_of = low + corner
            row[node_of[0] + 3 * (node_of[1] + 2 * node_of[2])] = np.prod([u if c else 1 - u for u, c in zip(p - low, corner)])
    scene = node(EXACT + f'<RegularGridTopology n="3 2 2" min="0 0 0" max="2 1 1"/><MechanicalObject name="dofs" velocity="{text["v"]}"/>'
                 f'<UniformMass totalMass="1"/><Node name="c"><MechanicalObject name="points" position="{text["p"]}"/>'
                 '<BarycentricMapping/></Node>')
    agree(Run(scene, 10).x("c.points"), W @ (grid + 0.1 * v), 1e-9)


def embedded(mesh, x, kind, cells, points, more=""):
    """Points in a body of which each node flies on its own way, and where the nodes of the body go."""
    v = np.random.default_rng(8).uniform(-3, 3, x.shape)
    text = [" ".join(repr(float(n)) for n in np.ravel(each)) for each in (x, v, points)]
    return (node(EXACT + f'<{mesh} position="{text[0]}" {kind}="{" ".join(str(n) for n in np.ravel(cells))}" {more}/><MechanicalObject '
                 f'name="dofs" velocity="{text[1]}"/><UniformMass totalMass="1"/><Node name="c"><MechanicalObject name="points" '
                 f'position="{text[2]}"/><BarycentricMapping/></Node>'), x + 0.1 * v)


@case
def centre_cells_that_are_flat_hold_nothing():
    """The nearest centre to the point is that of a cell without volume, exactly or but for round-off."""
    whole = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    for last in (1.0, 1.0 + 2 ** -52):
        x = np.array(whole + [[0.3, 0.3, 1], [0.6, 0.3, 1], [0.4, 0.6, 1], [0.5, 0.5, last]])
        for mesh in ("MeshTopology", "TetrahedronSetTopologyContainer"):
            scene, moved = embedded(mesh, x, "tetrahedra", [[0, 1, 2, 3], [4, 5, 6, 7]], [[0.45, 0.45, 1.2]])
            agree(Run(scene, 10).x("c.points"), [weights_by_centres([[0, 1, 2, 3]], x, np.array([0.45, 0.45, 1.2])) @ moved])
            Run(embedded(mesh, x, "tetrahedra", [[4, 5, 6, 7]], [[0.45, 0.45, 1.2]])[0], 1).fails(
                2, "no cell can contain point 0") if last == 1 else None
    x = np.array(whole[:3] + [[0.5, 0.5, 1], [0.6, 0.6, 1], [0.7, 0.7, 1]])
    scene, moved = embedded("MeshTopology", x, "triangles", [[0, 1, 2], [3, 4, 5]], [[0.6, 0.5, 0.9]])
    agree(Run(scene, 10).x("c.points"), [weights_by_centres([[0, 1, 2]], x, np.array([0.6, 0.5, 0.9])) @ moved])


@case
def centre_cells_of_graded_meshes():
    """One cell is 2,000 times as long as the edges that are given, which set the grid of the search: 10^9 of its cells; and far points."""
    random = np.random.default_rng(9)
    small = [np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]) * 0.01 + [0.0123 * i + 0.0017, -0.0213, 0.0031] for i in range(5)]
    x = np.vstack(small + [np.array([[0, 0, 0], [20, 0, 0], [0, 20, 0], [0, 0, 20]]) + 0.0047])
    cells = np.arange(len(x)).reshape(-1, 4)
    near = np.vstack([random.uniform(0, 0.01, (2, 3)) + each[0] for each in small] + [random.uniform(-2, 12, (10, 3))])
    for mesh, wide in (("MeshTopology", 0), ("TetrahedronSetTopologyContainer", 0.01)):
        for points in (near, np.array([[3e8, 1, 2], [-1, -4e15, 0]])):
            scene, moved = embedded(mesh, x, "tetrahedra", cells, points, 'edges="0 1 4 5 8 9"')
            agree(Run(scene, 10).x("c.points"), np.array([weights_by_centres(cells, x, p, wide) for p in points]) @ moved, 1e-9)


@case
def quirk_exact_borders():
    """Of a grid whose third layer is at 0.1 * 3 a box to 0.3 has two layers in SOFA, and so has a sphere or a load's box."""
    assert 0.1 * 3 > 0.3
    grid = '<RegularGridTopology n="11 2 2" min="0 0 0" max="1 0.1 0.1"/><MechanicalObject name="dofs"/><UniformMass totalMass="44"/>'
    native = ["--without-quirk", "exact-borders"]
    for region in ('<BoxROI name="r" box="-1 -1 -1 0.3 1 1"/>', '<PairBoxROI name="r" inclusiveBox="-1 -1 -1 0.3 1 1" includedBox="7 7 7 8 8 8"/>'):
        scene = node(EXACT + grid + region + '<ConstantForceField indices="@r.indices" forces="1 0 0"/>')
        for args, layers in (([], 3), (native, 4)):
            assert (Run(scene, 1, args=args).x()[:11, 0] - np.arange(11) / 10 > 1e-7).sum() == layers, (region, layers)
    ball = node(EXACT + '<MechanicalObject name="dofs" position="0 0 0  0.3 0 0"/><UniformMass totalMass="2"/><SphereROI name="r" '
                'centers="0 0 0" radii="0.29999999999999993"/><ConstantForceField indices="@r.indices" forces="0 1 0"/>')
    for args, pulled in (([], 1), (native, 2)):
        assert (Run(ball, 1, args=args).x()[:, 1] > 0).sum() == pulled
    load = '<SurfacePressureForceField pressure="1" min="0 0 0.1" max="0.3 0.1 0.1" useTangentStiffness="0"/>'
    for args, faces in (([], 2), (native, 3)):
        moved = Run(node(EXACT + grid + load), 1, args=args).x()[:, 2] - np.repeat([0, 0.1], 22)
        agree(moved.sum(), 1e-4 * faces * 0.01 * 2, 1e-6)  # of quads, and of the triangles of the grid


@case
def a_mapping_of_nothing_holds_its_nodes():
    child = ('<Node name="child"><MechanicalObject name="dofs" position="5 0 0"/><VoidMapping/><UniformMass totalMass="1"/>'
             '<ConstantForceField indices="0" forces="9 0 0"/></Node>')
    run = Run(root(EXACT + BODY + child), 10)
    falls(run)
    agree(run.x("child.dofs"), [[5, 0, 0]])


@case
def points_joined_projected_and_shared_out():
    bare = '<MechanicalObject name="dofs" position="@../e.{}"/><UniformMass totalMass="1"/>'

    def made(engine, link):
        return Run(node(engine + f'<Node name="a">{EXACT}{bare.format(link)}</Node>'), 1).x("a.dofs")
    agree(made('<JoinPoints name="e" points="0 0 0  1 0 0  0.1 0 0  1.3 0 0  0.16 0 0" distance="0.2"/>', "mergedPoints"),
          [[0.26 / 3, 0, 0], [1, 0, 0], [1.3, 0, 0]])
    agree(made('<ProjectiveTransformEngine template="Vec3d" name="e" input_position="1 2 3  -1 0 2" focal_distance="2" '
               'proj_mat="1 0 0 1  0 2 0 0  0 0 1 -1"/>', "output_position"), [[2, 4, 2], [0, 0, 2]])
    split = ('<MeshSplittingEngine name="e" position="0 0 0  1 0 0  2 0 0  3 0 0  4 0 0" triangles="2 3 4" nbInputs="2" indices1="3" '
             'triangleIndices2="0"/>')
    agree(made(split, "position1"), [[3, 0, 0]])
    agree(made(split, "position2"), [[2, 0, 0], [4, 0, 0]])
    agree(made(split, "position3"), [[0, 0, 0], [1, 0, 0]])
    parts = "".join(f'<Node name="{name}">{EXACT}<MechanicalObject name="dofs" position="@../e.position{i + 1}"/><UniformMass '
                    f'totalMass="1"/>{"<FixedConstraint fixAll=%s1%s/>" % (chr(34), chr(34)) if i == 1 else ""}</Node>'
                    for i, name in enumerate("abc"))
    whole = '<Node name="all"><MechanicalObject name="dofs"/><SubsetMultiMapping input="@../a @../b @../c" output="@." indexPairs="@../e.indexPairs"/></Node>'
    x = Run(root(split + parts + whole), 10).x("all.dofs")
    agree(x, [[0, fallen(10), 0], [1, fallen(10), 0], [2, 0, 0], [3, fallen(10), 0], [4, 0, 0]])



@case
def beams_of_some_segments():
    """listSegment: of the edges of the mesh, those that are beams."""
    frames = "".join(f"{x} 0 0 0 0 0 1  " for x in range(4))

    def hung(edges, words):
        return Run(root(EXACT + f'<MeshTopology position="0 0 0  1 0 0  2 0 0  3 0 0" edges="{edges}"/><MechanicalObject name="dofs" '
                        f'template="Rigid3" position="{frames}"/><UniformMass totalMass="4"/><FixedProjectiveConstraint indices="0"/>'
                        f'<BeamFEMForceField youngModulus="2e5" radius="0.1" {words}/>'), 8).x("dofs", 7)
    all_of = hung("0 1  1 2  2 3", "")
    some = hung("0 1  1 2  2 3", 'listSegment="0 2"')
    agree(some, hung("0 1  2 3", ""), 1e-12)
    differ(some, all_of, 1e-4)


@case
def lengths_between_points_of_several_bodies():
    """DistanceMultiMapping: edges between points of two parents; what is stretched has its geometric stiffness."""
    k, x = 300.0, np.array([[0, 0, 0], [1.0, 0.2, 0], [0.3, -1, 0.1], [1.2, -0.9, 0]])
    edges = [(0, 2), (1, 3), (1, 2)]
    bodies = "".join(f'<Node name="{name}"><MechanicalObject name="dofs" position="{numbers_of(x[rows])}"/><UniformMass vertexMass="0.5"/>{more}</Node>'
                     for name, rows, more in (("a", [0, 1], '<FixedProjectiveConstraint fixAll="1"/>'), ("b", [2, 3], "")))
    child = ('<Node name="lengths"><MeshTopology name="net" edges="0 2  1 3  1 2"/><MechanicalObject name="dofs" template="Vec1"/>'
             '<DistanceMultiMapping topology="@net" input="@../a/dofs @../b/dofs" output="@dofs" indexPairs="0 0  0 1  1 0  1 1"/>'
             f'<RestShapeSpringsForceField stiffness="{k}"/></Node>')
    run = Run(root(EXACT + bodies + child), 25)
    moved = euler(x, 0.5 * np.eye(4), together(gravity(np.full(4, 0.5), [0, -10, 0]), springs(edges, x, k, per_length=False)), 25, 0.01, held=[0, 1])
    agree(run.x("b.dofs"), moved[2:], 1e-8)


@case
def what_is_seen_or_scheduled_alone():
    for text in ('<TaskSchedulerSettings threadNumber="3"/>', '<OglShaderDefineMacro id="x"/>', '<CylinderVisualModel radius="0.3"/>',
                 '<OglSceneFrame/>', '<VisualStyle displayFlags="showAll"/>', '<InteractiveCamera position="0 0 9"/>', '<LightManager/>',
                 '<DirectionalLight direction="0 0 1"/>', '<RequiredPlugin name="Sofa.Component"/>', '<BackgroundSetting color="1 1 1"/>',
                 '<AttachBodyButtonSetting stiffness="9"/>', '<ViewerSetting resolution="8 8"/>', '<MouseButtonSetting/>', '<OglModel/>',
                 '<VisualGrid/>', '<VisualTransform/>', '<OrderIndependentTransparencyManager/>', '<ClipPlane/>', '<SlicedVolumetricModel/>'):
        run = Run(root(text + EXACT + BODY), 10)
        falls(run)


@case
def systems_of_all_templates():
    """Where matrices live changes no number, nor does how seldom a preconditioner is assembled."""
    for text in ('<CGLinearSolver template="GraphScattered" iterations="50" tolerance="1e-14" threshold="1e-30"/>',
                 '<CGLinearSolver template="CompressedRowSparseMatrixMat3x3d" iterations="50" tolerance="1e-14" threshold="1e-30"/>',
                 '<SparseLDLSolver name="ldl" template="CompressedRowSparseMatrixd"/><PreconditionedMatrixFreeSystem assemblingRate="3"/>'
                 '<PCGLinearSolver preconditioner="@ldl" iterations="50" tolerance="1e-14"/>',
                 '<GlobalSystemMatrixImage/><SparseLDLSolver/>', '<MatrixLinearSystem template="CompressedRowSparseMatrixMat3x3d" name="m"/>'
                 '<EigenSimplicialLDLT template="CompressedRowSparseMatrix" linearSystem="@m"/>'):
        falls(Run(root('<EulerImplicitSolver/>' + text + BODY), 10))
    jacobi = ('<JacobiPreconditioner name="j" template="DiagonalMatrix"/>', '<BlockJacobiPreconditioner name="j" template="BlockDiagonalMatrix"/>')
    for text in jacobi:
        run = Run(root('<EulerImplicitSolver/>' + text + '<PCGLinearSolver preconditioner="@j" iterations="50" tolerance="1e-14"/>' + BODY), 10)
        falls(run)


@case
def faces_that_a_mapping_leaves_out():
    """noInitialTriangles: none of the first faces; noNewTriangles is of cuts."""
    rest = np.array([[0, 0, 0], [1.0, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]])
    body = (f'<TetrahedronSetTopologyContainer name="cells" position="{numbers_of(rest)}" tetrahedra="0 1 2 3  1 2 3 4"/>'
            '<MechanicalObject name="dofs"/><UniformMass totalMass="5"/>')

    def pressed(words):
        return Run(root(EXACT + body + '<Node name="skin"><TriangleSetTopologyContainer name="faces"/><TriangleSetTopologyModifier/>'
                        f'<Tetra2TriangleTopologicalMapping input="@../cells" output="@faces" {words}/><SurfacePressureForceField '
                        'pressure="50"/></Node>', 'gravity="0 0 0"'), 3)
    differ(pressed("").x(), rest, 1e-4)
    agree(pressed('noNewTriangles="1"').x(), pressed("").x(), 1e-12)
    pressed('noInitialTriangles="1"').fails(2, "/skin/SurfacePressureForceField: no face of the mesh is loaded")


main()
