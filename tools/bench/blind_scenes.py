# SPDX-License-Identifier: LGPL-2.1-or-later
"""Ten scenes of solver_choice.py, the set `blind`: contact of two bodies, an unstructured mesh, a cavity, cables, a rigid gripper, a
membrane, nearly incompressible hexahedra, quadratic cells, cutting, many small bodies. They were written after the estimates had been
read, but before any of them had run: none was changed because of the solver that is chosen for it. SI units."""
import math

from scene_parts import (EULER, NOWHERE, STATIC, bent, body, cable, grid, held, hexas, law, loaded, moved_end, newton, numbers,
                         quadratics, root, tets, unheld)

T, H = "tetrahedra", "hexahedra"
CORNERS = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))


def pressed_pair():
    """A soft block that falls on another one, aside of its middle."""
    def named(text, name):
        return text.replace('name="body"', f'name="{name}"')
    below = named(body(grid((17, 17, 8), (.08, .08, .03), (-.04, -.04, -.03)), tets(1.5e4, .45, "svd"), "", T, solver="",
                       wall="-1 -1 -0.0301 1 1 -0.0299"), "below")
    above = named(unheld(body(grid((11, 11, 9), (.04, .04, .03), (-.012, -.02, .004)), tets(4e4, .4, "svd"), "", T, solver="",
                              wall=NOWHERE)), "above")
    return (newton(1e-4, 40) + "@SOLVER@" + below + above + '<BarrierContact name="touch" mstate="@above/dofs" '
            'topology="@above/tetrahedra" other="@below/dofs" contactDistance="0.002" friction="0.3" slipVelocity="2e-3" '
            'selfContact="false"/>')


def chamber():
    """A finger with a closed chamber, blown up by a given volume."""
    n, size, first, last = (31, 9, 9), (.12, .03, .03), (2, 2, 2), (28, 6, 6)  # cells of the chamber: first <= cell < last
    inside = lambda c: all(f <= a < e for f, a, e in zip(first, c, last))  # noqa: E731
    cells = [(i, j, k) for k in range(n[2] - 1) for j in range(n[1] - 1) for i in range(n[0] - 1)]
    solid = [[tuple(a + o for a, o in zip(c, corner)) for corner in CORNERS] for c in cells if not inside(c)]
    number = {p: m for m, p in enumerate(sorted({p for c in solid for p in c}, key=lambda p: p[::-1]))}
    points = numbers(a * s / (m - 1) for p in number for a, s, m in zip(p, size, n))
    faces = {(0, -1): (0, 3, 7, 4), (0, 1): (1, 5, 6, 2), (1, -1): (0, 4, 5, 1), (1, 1): (3, 2, 6, 7), (2, -1): (0, 1, 2, 3),
             (2, 1): (4, 7, 6, 5)}  # of a cell of the chamber, seen from within
    quads = []
    for c in filter(inside, cells):
        for (axis, way), face in faces.items():
            next_one = tuple(a + way * (d == axis) for d, a in enumerate(c))
            if not inside(next_one):
                quads.append([number[tuple(a + o for a, o in zip(c, CORNERS[m]))] for m in face])
    mesh = (f'<MeshTopology name="grid" position="{points}" hexahedra="{" ".join(str(number[p]) for c in solid for p in c)}"/>')
    air = (f'<SurfacePressureConstraint name="air" quads="{" ".join(str(i) for q in quads for i in q)}" valueType="pressure" '
           'value="4000"/>')
    return body(mesh, hexas(1.5e5, .42, "polar"), more=air)


def trunk():
    """Three cables, one of which is drawn."""
    def tapered(u, v, w):
        wide = .03 * (1 - .5 * u)
        return .22 * u, wide * (v - .5), wide * (w - .5)
    drawn = "".join(cable([(.01 + .02 * i, y * (1 - .5 * (.01 + .02 * i) / .22), z * (1 - .5 * (.01 + .02 * i) / .22)) for i in range(9)],
                          f"-0.01 {y} {z}", f'valueType="displacement" value="{value}"').replace('name="cable"', f'name="cable{k}"')
                    for k, (y, z, value) in enumerate(((0, .011, .006), (.0095, -.0055, 0), (-.0095, -.0055, 0))))
    return body(bent((45, 9, 9), tapered), tets(3e5, .43, "svd"), EULER, T, 1080, more=drawn)


def jaws():
    """Two rigid jaws that close on a lobe of an organ-like block and draw it up."""
    def jaw(name, y, close):
        path = f"0 0 0  0 0 0   0 {close} 0  0 0 0   0 {close} 0  0 0 0   0 {close} 0.012  0 0 0"
        return (f'<Node name="{name}"><MechanicalObject name="frame" template="Rigid3" position="0 {y} 0.02 0 0 0 1"/>'
                '<UniformMass totalMass="0.02" inertia="1e-6 1e-6 1e-6"/><LinearMovementProjectiveConstraint indices="0" '
                f'keyTimes="0 0.06 0.08 0.3" outside="hold" movements="{path}"/>'
                '<Node name="pad"><MeshTopology name="mesh" position="-0.006 -0.002 -0.006  0.006 -0.002 -0.006  -0.006 0.002 -0.006  '
                '0.006 0.002 -0.006  -0.006 -0.002 0.006  0.006 -0.002 0.006  -0.006 0.002 0.006  0.006 0.002 0.006" '
                'triangles="0 2 1  1 2 3  4 5 6  5 7 6  0 1 4  1 5 4  2 6 3  3 6 7  0 4 2  2 4 6  1 3 5  3 7 5"/>'
                '<MechanicalObject name="dofs"/><RigidMapping/></Node></Node>')

    def lobe(u, v, w):
        ridge = .03 * math.exp(-18 * (v - .5) ** 2)
        return .09 * (u - .5), .07 * (v - .5), w * (.004 + ridge) - .01
    tissue = body(bent((21, 21, 7), lobe), law("StableNeoHookean", 'youngModulus="1e4" poissonRatio="0.45"'), "", T, 1050, solver="",
                  wall="-1 -1 -1 1 1 -0.00999")
    touch = ('<BarrierContact name="grip" mstate="@body/dofs" topology="@body/tetrahedra" other="@left/pad/dofs @right/pad/dofs" '
             'contactDistance="0.0015" friction="0.7" slipVelocity="2e-3" selfContact="false"/>')
    return newton(1e-4, 40) + "@SOLVER@" + tissue + jaw("left", -.022, .0075) + jaw("right", .022, -.0075) + touch


def drum():
    """A membrane that is held all around and blown up."""
    edges = "-1 -1 -1 0.0001 1 1  0.2499 -1 -1 1 1 1  -1 -1 -1 1 0.0001 1  -1 0.1999 -1 1 1 1"
    return (f'<Node name="body">{newton(1e-5, 30)}@SOLVER@<RegularGridTopology name="grid" n="51 41 1" min="0 0 0" max="0.25 0.2 0" '
            'computeTriangleList="true"/><TriangleSetTopologyContainer name="sheet" position="@grid.position" '
            'triangles="@grid.triangles"/><MechanicalObject name="dofs" position="@grid.position"/>'
            '<MeshMatrixMass topology="@sheet" massDensity="1.2" lumping="true"/>'
            '<TriangularFEMForceField name="fem" topology="@sheet" youngModulus="6e5" poissonRatio="0.35" thickness="0.0012"/>'
            '<FastTriangularBendingSprings name="bending" topology="@sheet" bendingStiffness="1e-4"/>'
            '<SurfacePressureForceField name="air" topology="@sheet" pressure="300"/>' + held(edges) + "</Node>")


def plug():
    """Nearly incompressible hexahedra that are sheared and pressed."""
    field = ('<HexahedronHyperelasticityFEMForceField name="fem" materialName="NeoHookean" youngModulus="6e4" poissonRatio="0.499" '
             'dilatation="mean"/>')
    return body(grid((19, 15, 15), (.06, .05, .05)), field, newton(1e-5, 30), density=1100,
                more=moved_end(.0599, "0 0.2", "0 0 0  -0.008 0.01 0"))


def carved():
    """A ball carves a groove into tissue that is held at both ends."""
    tool = ('<CarvingRegion name="tool" sphere="0.05 0.004 0.03 0.008" velocity="0 0.2 0" begin="0.04" end="0.24" every="0.02"/>')
    return body(grid((29, 15, 9), (.1, .05, .03)), hexas(2e4, .42, "svd"), wall="-1 -1 -1 0.0001 1 1 0.0999 -1 -1 1 1 1", more=tool)


def dice():
    """Thirty-six cubes in a heap that falls on a plane: one mesh of pieces that touch one another."""
    n, side, gap = 5, .012, .0165
    points, cells = [], []
    for c in range(36):
        at = (gap * (c % 3) + .002 * (c // 9 % 2), gap * (c // 3 % 3), .003 + gap * (c // 9))
        first = len(points)
        points += [tuple(a + side * m / (n - 1) for a, m in zip(at, (i, j, k))) for k in range(n) for j in range(n) for i in range(n)]
        cells += [first + (i + a) + n * ((j + b) + n * (k + d)) for k in range(n - 1) for j in range(n - 1) for i in range(n - 1)
                  for a, b, d in CORNERS]
    mesh = f'<MeshTopology name="grid" position="{numbers(a for p in points for a in p)}" hexahedra="{" ".join(map(str, cells))}"/>'
    return (newton(1e-3, 40) + "@SOLVER@" + unheld(body(mesh, hexas(2e5, .35, "polar"), "", H, 1000, solver="", wall=NOWHERE))
            + '<BarrierContact name="touch" mstate="@body/dofs" topology="@body/grid" planes="0 0 1 0" contactDistance="0.001" '
            'friction="0.3" slipVelocity="5e-3"/>')


def leg_statics():
    labels = (loaded("leg") + '<ValuesFromLabels name="stiffness" labels="@loader.tetrahedraGroups" table="1 1.5e4 2 1.5e6 3 1.5e6"/>'
              '<ValuesFromLabels name="compression" labels="@loader.tetrahedraGroups" table="1 0.47 2 0.3 3 0.3"/>')
    push = ('<BoxROI name="skin" box="-1 -1 0.15 1 -0.04 0.25" position="@dofs.rest_position"/>'
            '<LinearMovementProjectiveConstraint name="hand" indices="@skin.indices" keyTimes="0 5" movements="0 0 0  0.004 0.01 0"/>')
    return body(labels, tets("@stiffness.values", "@compression.values", "svd"), STATIC, density=1060,
                wall="-0.030 -0.015 0.320 0.016 0.032 0.346  -0.026 -0.016 0.018 0.030 0.026 0.040", more=push)


def blind():
    yield "pressed_pair", "contact: soft block that falls on a softer one, `svd`, 3,401 nodes", 20, root(pressed_pair(), .005, "0 0 -9.81")
    yield ("unstructured", "statics in five steps: leg from a file, bones 1:100, `svd`, pushed aside", 5,
           root(leg_statics(), 1, "0 0 -9.81"))
    yield "chamber", "finger of hexahedra with a pressurised chamber, `polar`, 2,127 nodes", 20, root(chamber(), .01)
    yield "trunk", "trunk of tetrahedra with three cables, `svd`, 3,645 nodes", 15, root(trunk(), .02)
    yield "jaws", "tissue between two rigid jaws with friction, stable neo-Hookean, 3,087 nodes", 20, root(jaws(), .01, "0 0 -9.81")
    yield "drum", "membrane that is blown up, Newton's method, 2,091 nodes", 25, root(drum(), .005, "0 0 -9.81")
    yield ("plug", "hexahedra, Poisson's ratio 0.499, neo-Hookean, Newton's method, 4,275 nodes", 10, root(plug(), .02))
    block = quadratics("13 6 6", "0.16 0.05 0.05", STATIC, "8e4", 0.42)
    yield ("quadratic_pulled", "statics in four steps: quadratic tetrahedra whose end is moved, `svd`", 4,
           root(block.replace(held("-0.0001 -1 -1 0.0001 1 1"), held("-0.0001 -1 -1 0.0001 1 1")
                              + moved_end(.1599, "0 4", "0 0 0  0.01 0.03 0.01")), 1))
    yield "carved", "cutting: hexahedra that a ball carves, `svd`, 3,915 nodes", 25, root(carved(), .01)
    yield "dice_heap", "thirty-six cubes of hexahedra that fall on one another, `polar`, 4,500 nodes", 20, root(dice(), .005, "0 0 -9.81")
