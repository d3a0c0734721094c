# SPDX-License-Identifier: LGPL-2.1-or-later
"""Masses in SOFA's dialect: by cells, in all, of frames.
Usage: test_dialect_masses.py STROMA [WORD]."""
import itertools

import numpy as np

from dialect import (CUBE, EXACT, PLACES, X4_TEXT, Run, agree, case, differ, fallen, falls, main, node, numbers_of, root, shapes_at,
                     voxels)
from reference import euler, gravity, load, springs, stiffness, together


@case
def quirk_edge_mass():
    x = np.array([[i, j, k] for k in range(2) for j in range(2) for i in range(2)], float)
    edges = [(a, b) for a, b in itertools.combinations(range(8), 2) if np.abs(x[a] - x[b]).sum() == 1]
    mass = np.eye(8) / 20
    for a, b in edges:
        mass[a, b] = mass[b, a] = 1 / 40
    # the matrix is not definite: a solver that does not mind
    scene = root('<EulerImplicitSolver/><EigenSparseLU/><RegularGridTopology n="2 2 2" min="0 0 0" max="1 1 1"/><MechanicalObject name="dofs"/>'
                 '<MeshMatrixMass massDensity="8"/><RestShapeSpringsForceField stiffness="100" points="0 3"/>')

    def held(x_, v):
        f, K = np.zeros_like(x_), np.zeros((24, 24))
        for n in (0, 3):
            f[n] = -100 * (x_[n] - x[n])
            K[3 * n:3 * n + 3, 3 * n:3 * n + 3] = -100 * np.eye(3)
        return f, K
    fields = together(gravity(np.full(8, 8 * 2.5 / 20), [0, -10, 0]), held)
    expected = euler(x, 8 * mass, fields, 20, 0.01)
    agree(Run(scene, 20).x(), expected, 1e-8)
    differ(Run(scene, 20, args=["--without-quirk", "edge-mass"]).x(), expected, 1e-4)


@case
def shares_of_cells_that_are_no_boxes():
    """V / 8 and A / 4 at each node, A of the two triangles along corners 0 and 2; with totalMass scaled to it."""
    brick = np.array([[0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1.3, 1.2, 1.1], [0, 1, 1]])
    sheet = np.array([[0, 0, 0], [1, 0, 0.3], [1, 1, 0], [0, 1, 0.1], [2.5, 0, 0], [2, 1, 0]])

    def triangle(*nodes):
        a, b, c = sheet[list(nodes)]
        return np.linalg.norm(np.cross(b - a, c - a)) / 2

    def volume(X):  # of six tetrahedra on each face's centre and the cell's
        sides = [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
        middle, total = X.mean(axis=0), 0
        for side in sides:
            p = X[list(side)]
            total += sum(np.linalg.det([p[i] - middle, p[(i + 1) % 4] - middle, p.mean(axis=0) - middle]) for i in range(4)) / 6
        return total
    areas = np.array([triangle(0, 1, 2) + triangle(0, 2, 3), triangle(1, 4, 5) + triangle(1, 5, 2)])
    on_sheet = np.array([areas[0], areas.sum(), areas.sum(), areas[0], areas[1], areas[1]]) / 4
    for X, cells, parts in ((brick, 'hexahedra="0 1 2 3 4 5 6 7"', np.full(8, abs(volume(brick)) / 8)),
                            (sheet, 'quads="0 1 2 3  1 4 5 2"', on_sheet)):
        for mass, masses in (('DiagonalMass massDensity="3"', 3 * parts), ('DiagonalMass totalMass="5"', 5 * parts / parts.sum()),
                             ('MeshMatrixMass massDensity="3" lumping="1"', 3 * parts)):
            scene = node(EXACT + f'<MeshTopology position="{numbers_of(X)}" {cells}/><MechanicalObject name="dofs"/><{mass}/>'
                         f'<ConstantForceField indices="0-{len(X) - 1}" forces="0 0 1"/>')
            agree(1e-4 / (Run(scene, 1).x() - X)[:, 2], masses, 1e-9)
            if mass.startswith("Diagonal"):
                differ(1e-4 / (Run(scene, 1, args=["--without-quirk", "edge-mass"]).x() - X)[:, 2], masses, 1e-3)


@case
def shares_of_grids_that_are_warped():
    """A grid whose nodes the state puts elsewhere has no boxes: each corner has an eighth of its cell all the same."""
    warped, plain = CUBE.copy(), CUBE
    warped[7] = 2, 2, 2
    other = np.array([[0, 0, 0], [1.5, 0, 0.2], [0, 1, 0], [1, 1.4, 0], [0, 0, 1], [1, 0, 1], [-0.3, 1, 1], [1, 1, 1.5]])

    def volume(X):  # the trilinear map's, by two Gauss points along each axis
        total = 0
        for xi in itertools.product((-1 / np.sqrt(3), 1 / np.sqrt(3)), repeat=3):
            slopes = np.array([[s[a] / 8 * np.prod([1 + s[b] * xi[b] for b in range(3) if b != a]) for a in range(3)]
                               for s in 2 * plain - 1])
            total += np.linalg.det(X.T @ slopes)
        return total
    grid = '<RegularGridTopology n="2 2 2" min="0 0 0" max="1 1 1"/>'
    for X, state in ((warped, f'position="{numbers_of(warped)}"'), (other, f'position="{numbers_of(other)}"'), (plain, "")):
        scene = node(EXACT + f'{grid}<MechanicalObject name="dofs" {state}/><DiagonalMass massDensity="3"/>'
                     '<ConstantForceField indices="0-7" forces="0 0 1"/>')
        run = Run(scene, 1)
        agree(1e-4 / (run.x() - X)[:, 2], np.full(8, 3 * volume(X) / 8), 1e-9)
        assert ("edge-mass" in run.text) == bool(state), run.text
        if state:
            differ(1e-4 / (Run(scene, 1, args=["--without-quirk", "edge-mass"]).x() - X)[:, 2], np.full(8, 3 * volume(X) / 8), 1e-3)


@case
def quirk_total_mass():
    scene = node(EXACT + '<MechanicalObject name="dofs" position="0 0 0  1 0 0"/><UniformMass totalMass="4" vertexMass="1"/>'
                 '<ConstantForceField indices="0 1" forces="0 8 0"/>')
    falls(Run(scene, 10), g=-4)
    falls(Run(scene, 10, args=["--without-quirk", "total-mass"]), g=-8)


@case
def quirk_fixed_inertia():
    scene = node('<EulerImplicitSolver/><SparseLDLSolver/><MechanicalObject template="Rigid3d" name="dofs" position="0 0 0 0 0 0 1" '
                 'velocity="0 0 0 1 2 3"/><UniformMass vertexMass="2 1 [1 0 0, 0 2 0, 0 0 3]"/>')
    kept = Run(scene, 20).x("dofs", 7)  # without a torque the angular velocity stays what it is
    angle = 0.2 * np.sqrt(14)
    agree(kept[0, 3:], [*(np.sin(angle / 2) * np.array([1, 2, 3]) / np.sqrt(14)), np.cos(angle / 2)])
    differ(Run(scene, 20, args=["--without-quirk", "fixed-inertia"]).x("dofs", 7), kept, 1e-4)


@case
def finite_element_mass():
    scene = node(EXACT + '<RegularGridTopology n="2 2 2" min="0 0 0" max="1 1 1"/><MechanicalObject name="dofs"/>'
                 '<NodalMassDensity property="1 2 3 4 5 6 7 8"/><FEMMass template="Vec3,Hexahedron"/>'
                 '<ConstantForceField indices="0" forces="1 2 3"/>')
    mass, g = np.zeros((8, 8)), np.array([-1, 1]) / np.sqrt(3)
    for p in itertools.product(g, repeat=3):
        N = np.prod((1 + (2 * CUBE - 1) * p) / 2, axis=1)
        mass += np.outer(N, N) * (N @ np.arange(1, 9)) / 8
    agree(Run(scene, 5).x(), euler(CUBE, mass, load({0: np.array([1, 2, 3])}), 5, 0.01), 1e-8)


@case
def quirk_moved_inertia():
    """A triangle with the consistent mass, one node of which is moved: the others fall as if it stood still, by M dv = h f with 1/6
    and 1/12 of the mass in M, and 1/3 of it in f."""
    sheet = ('<MeshTopology position="0 0 0  1 0 0  0 1 0" triangles="0 1 2"/><MechanicalObject name="dofs"/><MeshMatrixMass '
             'massDensity="2"/><LinearMovementConstraint indices="0" keyTimes="0 1" movements="0 0 0  0 0 7"/>')
    run = Run(root(EXACT + sheet), 10)
    agree(run.x(), [[0, 0, 7 * 0.09], [1, fallen(10) * (1 / 3) / (1 / 4), 0], [0, 1 + fallen(10) * (1 / 3) / (1 / 4), 0]])
    Run(root(EXACT + sheet), 1, args=["--without-quirk", "moved-inertia"]).fails(2, "through a non-diagonal mass")
    child = ('<MechanicalObject name="dofs" position="0 0 0  1 0 0"/><UniformMass totalMass="2"/><LinearMovementConstraint indices="0" '
             'keyTimes="0 1" movements="0 0 0  0 0 7"/><Node name="c"><MechanicalObject name="c" position="0.5 0 0"/><MeshTopology '
             'position="0 0 0"/><SubsetMultiMapping input="@../dofs" output="@c" indexPairs="0 1"/><UniformMass totalMass="1"/></Node>')
    agree(Run(root(EXACT + child), 10).x(), [[0, 0, 7 * 0.09], [1, fallen(10), 0]])


def block_mass(scene_type, more=""):
    return (f'<RegularGridTopology n="2 2 2" min="0 0 0" max="1 1 1"/><MechanicalObject name="dofs"/>'
            f'<{scene_type} youngModulus="500" poissonRatio="0.3" method="large" density="4" {more}/>')


@case
def quirk_pair_mass():
    """All pairs of corners have 8/27 of the mass; gravity takes an eighth at each corner."""
    hold = '<RestShapeSpringsForceField stiffness="300"/>'

    def held(x, v):
        return -300 * (x - CUBE), -300 * np.eye(24)
    fields = together(gravity(np.full(8, 0.5), [0, -10, 0]), held)
    for name in ("HexahedronFEMForceFieldAndMass", "HexahedralFEMForceFieldAndMass"):
        scene = root(EXACT + block_mass(name).replace('youngModulus="500"', 'youngModulus="1e-9"') + hold)
        agree(Run(scene, 10).x(), euler(CUBE, np.full((8, 8), 8 / 27 * 4), fields, 10, 0.01), 1e-7)
        differ(Run(scene, 10, args=["--without-quirk", "pair-mass"]).x(), Run(scene, 10).x(), 1e-4)
    lumped = root(EXACT + block_mass(name, 'lumpedMass="1"').replace('youngModulus="500"', 'youngModulus="1e-9"') + hold)
    agree(Run(lumped, 10).x(), euler(CUBE, np.eye(8) * 64 / 27 * 4, fields, 10, 0.01), 1e-7)


@case
def cells_that_are_filled_unevenly():
    """A box in one cell, looked at on 4 x 4 x 4 parts: 1 for the eight in the middle, 0.5 for those that it cuts. Stiffness and all
    pairs of the mass are sums over the parts, whose nodes follow those of the cell."""
    young, nu, rho, size, n = 500, 0.3, 4, 2.0, 4
    corners = [f"{1.7 if c & 1 else 0.3} {1.7 if c & 2 else 0.3} {1.7 if c & 4 else 0.3}" for c in range(8)]
    faces = [(0, 2, 1), (1, 2, 3), (4, 5, 6), (5, 7, 6), (0, 1, 4), (1, 5, 4), (2, 6, 3), (3, 6, 7), (0, 4, 2), (2, 4, 6), (1, 3, 5), (3, 7, 5)]
    off = "OFF\n8 12 0\n" + "\n".join(corners) + "\n" + "\n".join("3 {} {} {}".format(*face) for face in faces) + "\n"

    def scene(more, levels=2):
        return root(EXACT + f'<SparseGridTopology name="grid" n="2 2 2" min="0 0 0" max="{size} {size} {size}" fileTopology="box.off" '
                    f'nbVirtualFinerLevels="2"/><MechanicalObject name="dofs"/><NonUniformHexahedronFEMForceFieldAndMass '
                    f'youngModulus="{young}" poissonRatio="{nu}" method="large" density="{rho}" nbVirtualFinerLevels="{levels}" {more}/>'
                    '<FixedConstraint indices="0 1"/>')
    nodes = np.array(list(itertools.product([0, size], repeat=3)))  # z is the fastest
    cell = [int(np.flatnonzero((nodes == size * place).all(axis=1))[0]) for place in PLACES]
    D = stiffness(young, nu)
    K, M, filled = np.zeros((24, 24)), np.zeros((8, 8)), 0.0
    for part in itertools.product(range(n), repeat=3):
        factor = 1.0 if all(p in (1, 2) for p in part) else 0.5
        volume = (size / n) ** 3
        filled += factor * volume
        centre = shapes_at((np.array(part) + 0.5) / n)[0]
        M += 8 / 27 * rho * factor * volume * np.outer(8 * centre, 8 * centre)
        for signs in itertools.product([-1, 1], repeat=3):
            _, slopes = shapes_at((np.array(part) + 0.5 + np.array(signs) / (2 * 3 ** 0.5)) / n)
            B = np.zeros((6, 24))
            for i, (a, b, c) in enumerate(slopes / size):
                B[:, 3 * i:3 * i + 3] = [[a, 0, 0], [0, b, 0], [0, 0, c], [b, a, 0], [0, c, b], [c, 0, a]]
            K += factor * volume / 8 * B.T @ D @ B

    def field(x, v):
        now = x[cell]
        edges = np.array([(now[PLACES[:, axis] == 1].mean(axis=0) - now[PLACES[:, axis] == 0].mean(axis=0)) for axis in range(3)]).T
        Q, R = np.linalg.qr(edges)
        R = Q * np.sign(np.diag(R))
        turn = np.kron(np.eye(8), R)
        f, stiff = np.zeros((8, 3)), np.zeros((24, 24))
        f[cell] = (-turn @ K @ (turn.T @ now.ravel() - nodes[cell].ravel())).reshape(8, 3)
        rows = np.array([[3 * node + k for k in range(3)] for node in cell]).ravel()
        stiff[np.ix_(rows, rows)] = -turn @ K @ turn.T
        return f, stiff
    fields = together(gravity(np.full(8, rho * filled / 8), [0, -10, 0]), field)
    mass = np.zeros((8, 8))
    mass[np.ix_(cell, cell)] = M
    run = Run(scene(""), 20, {"box.off": off})
    agree(run.x(), euler(nodes, mass, fields, 20, 0.01, held=[0, 1]), 1e-9)
    differ(run.x(), nodes, 0.01)
    plain = Run(scene("").replace("NonUniformHexahedron", "Hexahedron").replace('density="4" nbVirtualFinerLevels="2"', 'density="4"'),
                20, {"box.off": off})
    differ(plain.x(), run.x(), 1e-4)
    # with one level the parts are alike: eight times 0.5625
    differ(Run(scene("", 1), 20, {"box.off": off}).x(), run.x(), 1e-4)
    # a mass of its own beside it
    alone = Run(scene('useMass="0"').replace("<FixedC", '<UniformMass totalMass="5"/><FixedC'), 20, {"box.off": off})
    agree(alone.x(), euler(nodes, np.eye(8) * 5 / 8, together(gravity(np.full(8, 5 / 8), [0, -10, 0]), field), 20, 0.01, held=[0, 1]), 1e-9)
    Run(scene("", 3), 1, {"box.off": off}).says("has 2 finer levels")
    finer = scene("", 5).replace('nbVirtualFinerLevels="2"', 'nbVirtualFinerLevels="5"')
    Run(finer, 1, {"box.off": off}).says("parts of 4 levels are taken")
    # the parts of a grid are counted once
    second = '<NonUniformHexahedronFEMForceFieldAndMass name="second" density="1" useMass="0" nbVirtualFinerLevels="{}"/><FixedC'
    run = Run(scene("").replace("<FixedC", second.format(1)), 1, {"box.off": off})
    assert run.code == 0, run.text
    run.says("/second.nbVirtualFinerLevels: is 1, and another field on /grid asks for 2")
    assert "asks for" not in Run(scene("").replace("<FixedC", second.format(2)), 1, {"box.off": off}).text


@case
def a_common_centre_of_mass():
    """A force on it moves all bodies alike, and it lies where the masses say."""
    point = '<Node name="points"><MechanicalObject name="dofs" position="0 0 0  4 0 0"/><UniformMass vertexMass="1"/></Node>'
    other = '<Node name="frames"><MechanicalObject name="dofs" template="{0}" position="{1}"/><UniformMass vertexMass="{2}"/></Node>'
    child = ('<Node name="centre"><MechanicalObject name="dofs" position="0 0 0"/><{} output="@."/>'
             '<ConstantForceField forces="0 0 20"/></Node>')
    rise = 20 / 5 * 0.01 ** 2 * 5 * 6 / 2
    for kind, where, mass, mapping in (
            ("Vec3d", "1 5 0", "3", 'CenterOfMassMultiMapping template="Vec3d,Vec3d" input="@../points @../frames"'),
            ("Rigid3d", "1 5 0 0 0 0 1", "3 1 [1 0 0 0 1 0 0 0 1]",
             'CenterOfMassMulti2Mapping template="Vec3d,Rigid3d,Vec3d" input1="@../points" input2="@../frames"')):
        run = Run(root(EXACT + point + other.format(kind, where, mass) + child.format(mapping), 'gravity="0 0 0"'), 5)
        agree(run.x("centre.dofs"), [[7 / 5, 3, rise]])
        agree(run.x("points.dofs"), [[0, 0, rise], [4, 0, rise]])
        agree(run.x("frames.dofs", 7 if kind == "Rigid3d" else 3)[:, :3], [[1, 5, rise]])
    frame = child.replace('position="0 0 0"', 'template="Rigid3d" position="0 0 0 0 0 0 1"').replace('forces="0 0 20"', 'forces="0 0 20 0 0 0"')
    Run(root(EXACT + point + other.format("Rigid3d", "1 5 0 0 0 0 1", "3 1 [1 0 0 0 1 0 0 0 1]") + frame.format(mapping)), 1).fails(
        2, "/centre/dofs is of frames")


@case
def mass_of_what_a_surface_encloses():
    """A box of 1 x 2 x 3 turns about x under a torque of two forces: inertia m (b^2 + c^2) / 12."""
    nodes = [[i, 2 * j, 3 * k] for k in (0, 1) for j in (0, 1) for i in (0, 1)]
    faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    text = "  ".join(" ".join(map(str, p)) for p in nodes)
    quads = "  ".join(" ".join(map(str, q)) for q in faces)
    scene = node(f'<MeshTopology name="m" position="{text}" quads="{quads}"/><GenerateRigidMass name="e" src="@m" density="0.5"/>' + EXACT +
                 '<MechanicalObject name="dofs" template="Rigid3" position="0 0 0 0 0 0 1"/><UniformMass vertexMass="@e.rigidMass"/>'
                 '<ConstantForceField indices="0" forces="3 0 0 1 0 0"/>')
    x = Run(scene, 1).x("dofs", 7)
    agree(x[0, 0], 0.01**2 * 3 / 3)
    agree(2 * np.arcsin(x[0, 3]), 0.01**2 / (3 * (4 + 9) / 12), 1e-6)


@case
def masses_of_voxels():
    """Those of the finite element method: along an axis 1/3 of a part at its ends and 1/6 between them."""
    end, both = np.array([[2, 1], [1, 2]]) / 6, np.array([[2, 1, 0], [1, 4, 1], [0, 1, 2]]) / 6
    field = '<NonUniformHexahedralFEMForceFieldAndMass method="polar" youngModulus="1e-9" poissonRatio="0.3" density="6" {}/>'
    places = np.array([(i, j, k) for k in range(2) for j in range(2) for i in range(3)], float)

    def held(x, v):
        return -300 * (x - places), -300 * np.eye(36)
    M = 6 * np.kron(end, np.kron(end, both))
    fields = together(gravity(M.sum(1), [0, -10, 0]), held)
    springs_ = '<RestShapeSpringsForceField stiffness="300"/>'
    agree(voxels("MultilevelHexahedronSetTopologyContainer", field.format('recursive="0" useMBK="1"') + springs_).x(),
          euler(places, M, fields, 10, 0.01), 1e-7)
    agree(voxels("MultilevelHexahedronSetTopologyContainer", field.format('lumpedMass="1"') + springs_).x(),
          euler(places, np.diag(M.sum(1)), fields, 10, 0.01), 1e-7)
    voxels('MultilevelHexahedronSetTopologyContainer level="1"', field.format("")).fails(2, "cells of several voxels")


@case
def the_mass_of_all_frames_wins():
    """With both given the mass is the total's share, and the inertia stays per mass."""
    body = ('<MechanicalObject name="dofs" template="Rigid3" position="0 0 0 0 0 0 1  2 0 0 0 0 0 1"/><UniformMass totalMass="3" vertexMass="5 1 '
            '[0.5 0 0,0 0.5 0,0 0 0.25]"/><ConstantForceField indices="1" forces="6 0 0 0 0 3"/>')
    x = Run(node(EXACT + body), 10).x("dofs", 7)
    way, angle = 6 / 1.5 * 55e-4, 3 / (1.5 * 0.25) * 55e-4
    agree(x, [[0, 0, 0, 0, 0, 0, 1], [2 + way, 0, 0, 0, 0, np.sin(angle / 2), np.cos(angle / 2)]])


@case
def masses_that_a_mapping_does_not_map():
    """SOFA declares mapMasses and reads it nowhere; a mapping without forces passes no masses on either."""
    def scene(words):
        return root(EXACT + '<MechanicalObject name="dofs" position="0 0 0"/><UniformMass totalMass="1"/><RestShapeSpringsForceField '
                    'stiffness="40" points="0"/><Node name="seen"><MechanicalObject name="dofs"/><UniformMass totalMass="3"/>'
                    f'<IdentityMapping {words}/></Node>')

    def oscillated(m):
        y = v = 0.0
        for _ in range(20):
            v += 0.01 * (-10 * m - 40 * y - 0.4 * v) / (m + 0.01 * 0.4)
            y += 0.01 * v
        return [[0, y, 0]]
    for words, mass in (("", 4), ('mapMasses="0"', 4), ('mapForces="0"', 1), ('isMechanical="false"', 1)):
        run = Run(scene(words), 20)
        agree(run.x(), oscillated(mass))
        if "Masses" in words:
            run.says("has no effect, as in SOFA: masses of the nodes that follow count")


@case
def a_file_of_frames_for_points():
    """UniformMass reads filename with Rigid only: points keep totalMass."""
    run = Run(root(EXACT + '<MechanicalObject name="dofs" position="0 0 0  1 0 0"/><UniformMass filename="none.rigid" totalMass="2"/>'), 10)
    falls(run)
    run.says("is read in SOFA for rigid frames only")


@case
def gravity_apart_is_told():
    run = Run(root(EXACT + '<MechanicalObject name="dofs"/><UniformMass totalMass="1" separateGravity="true"/>'), 2)
    run.says("separateGravity", "SOFA adds gravity to velocities after positions have moved")
    assert "separateGravity" not in Run(root(EXACT + '<MechanicalObject/><UniformMass totalMass="1" separateGravity="0"/>'), 2).text


@case
def masses_of_one_state_add_up():
    """A force field each in SOFA: gravity, inertia and damping of both."""
    for solvers in (EXACT, '<EulerImplicitSolver rayleighMass="2"/><CGLinearSolver iterations="50" tolerance="1e-14" threshold="1e-30"/>',
                    "<EulerExplicitSolver/>", "<RungeKutta4Solver/>", '<CentralDifferenceSolver rayleighMass="2"/>'):
        scene = (f'{solvers}<MeshTopology position="{X4_TEXT}" tetrahedra="0 1 2 3"/><MechanicalObject name="dofs"/>{{}}'
                 '<RestShapeSpringsForceField points="0 1 2 3" stiffness="30"/>')
        both = Run(root(scene.format('<UniformMass totalMass="2"/><UniformMass totalMass="6"/>')), 10)
        agree(both.x(), Run(root(scene.format('<UniformMass totalMass="8"/>')), 10).x(), 1e-12)
        both.says("/dofs has the mass of /UniformMass too: they add up")
    scene = (f'{EXACT}<MeshTopology position="{X4_TEXT}" tetrahedra="0 1 2 3"/><MechanicalObject name="dofs"/>{{}}'
             '<FixedConstraint indices="0"/><TetrahedronFEMForceField youngModulus="50" poissonRatio="0.3"/>')
    twice = '<MeshMatrixMass massDensity="3" rayleighMass="2"/>'
    agree(Run(root(scene.format(twice + twice.replace("3", "6", 1))), 10).x(), Run(root(scene.format(twice.replace("3", "9", 1))), 10).x(), 1e-12)
    spun = (EXACT + '<MechanicalObject name="dofs" template="Rigid3" position="0 0 0 0 0 0 1" velocity="0 0 0 1 2 3"/>{}'
            '<RestShapeSpringsForceField points="0" stiffness="5" angularStiffness="40"/>')
    two = Run(node(spun.format('<UniformMass vertexMass="1 1 [1 0 0,0 2 0,0 0 3]"/><UniformMass vertexMass="2 1 [2 0 0,0 1 0,0 0 1]"/>')), 10)
    one = Run(node(spun.format('<UniformMass vertexMass="3 1 [1.6666666666666667 0 0,0 1.3333333333333333 0,0 0 1.6666666666666667]"/>')), 10)
    agree(two.x("dofs", 7), one.x("dofs", 7), 1e-12)
    two = '<UniformMass totalMass="2" rayleighMass="8"/><UniformMass totalMass="6"/>'
    for solver in ('<CentralDifferenceSolver/>', '<CondensedDynamicSolver condensed="false"/>', '<CondensedDynamicSolver/>'):
        # native scenes: 8 1/s on a quarter of the mass is 2 1/s on all
        scene = (f'{solver}<MeshTopology position="{X4_TEXT}" tetrahedra="0 1 2 3"/><MechanicalObject name="dofs"/>{{}}'
                 '<TetrahedronFEMForceField youngModulus="50" poissonRatio="0.3" method="small"/><FixedProjectiveConstraint indices="0"/>')

        def moved(masses):
            return Run.of_native(root(scene.format(masses)), 10).x()
        damped, free = (moved(f'<UniformMass totalMass="8" rayleighMass="{rate}"/>') for rate in (2, 0))
        agree(moved(two.replace("6", '6" mstate="@/dofs')), damped, 1e-12)
        differ(damped, free, 1e-4)
    scene = '<EulerExplicitSolver/><MechanicalObject name="dofs"/><UniformMass totalMass="2"/><UniformMass totalMass="6"/>'
    Run(root(scene), 1).says("added-masses: several masses of one state add up (/UniformMass2)")
    Run(root(scene), 1, args=["--without-quirk", "added-masses"]).fails(2, "/dofs has two masses: ")
    Run.of_native(root(scene), 1).fails(2, "/dofs has two masses: ")


@case
def lists_of_masses():
    """Of vertexMass MeshMatrixMass takes 2.5 times (on surfaces twice) for lumped matrices and for weights, and nothing without lumping
    or edgeMass; DiagonalMass repeats its last and has one density; UniformMass has one mass."""
    x = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    pairs = list(itertools.combinations(range(4), 2))
    given, along = np.array([1.0, 2, 3, 4]), np.array([0.1, 0.2, 0.3, 0.4, 0.5, 0.6])
    coupled = np.diag(given)
    for (a, b), m in zip(pairs, along):
        coupled[a, b] = coupled[b, a] = m
    lists = f'vertexMass="{numbers_of(given)}"'
    edges = f' edgeMass="{numbers_of(along)}"'
    volume, surface = 'tetrahedra="0 1 2 3"', 'triangles="0 1 2  1 3 2"'
    listed = ' edges="' + " ".join(f"{a} {b}" for a, b in pairs) + '"'
    whole = 1 / 20 * (np.eye(4) + 1)
    for mesh, mass, matrix, weights, words in (
            (volume, f'MeshMatrixMass {lists} lumping="1"', np.diag(2.5 * given), 2.5 * given, ()),
            (surface, f'MeshMatrixMass {lists} lumping="1"', np.diag(2 * given), 2 * given, ()),
            (volume + listed, f"MeshMatrixMass {lists}{edges}", coupled, 2.5 * given, ()),
            (volume, f'MeshMatrixMass {lists}{edges} lumping="1"', np.diag(2.5 * given), 2.5 * given, ()),
            (volume, f"MeshMatrixMass {lists}", whole, np.full(4, 0.25), ("does not count in SOFA",)),
            (volume, 'MeshMatrixMass vertexMass="3" lumping="1"', np.eye(4) / 4, np.full(4, 0.25), ("asks for one for each node",)),
            (volume, 'DiagonalMass vertexMass="1 2"', np.diag([1.0, 2, 2, 2]), np.array([1.0, 2, 2, 2]), ()),
            (volume, 'DiagonalMass massDensity="12 5"', np.eye(4) / 2, np.full(4, 0.5), ("reads the first",)),
            (volume, 'UniformMass vertexMass="2 3 4 5"', 2 * np.eye(4), np.full(4, 2.0), ("reads the first",))):
        forces = together(gravity(weights, [0, -10, 0]), load({3: [0, 0, 1]}), springs(pairs, x, 50.0))
        expected = euler(x, matrix, forces, 10, 0.01)
        run = Run(root(EXACT + f'<MeshTopology position="{numbers_of(x)}" {mesh}/><MechanicalObject name="dofs"/><{mass}/>'
                       '<ConstantForceField indices="3" forces="0 0 1"/><SpringForceField spring="' +
                       "  ".join(f"{a} {b} {50 / np.linalg.norm(x[a] - x[b])!r} 0 {np.linalg.norm(x[a] - x[b])!r}" for a, b in pairs) + '"/>'), 10)
        run.says(*words)
        agree(run.x() - x, expected - x, 1e-8)
    line = '<MeshTopology position="0 0 0  1 0 0" edges="0 1"/><MechanicalObject name="dofs"/><MeshMatrixMass massDensity="1"/>'
    Run(root(EXACT + line), 1).says("SOFA's MeshMatrixMass has none on lines")


main()
