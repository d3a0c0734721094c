#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Published benchmarks of contact (docs/contact.md) on meshes of any size: the forces for which programs have published numbers.

  contact_published.py spheres --cells 8 --friction 0.5
  contact_published.py twist --cells 10 --layers 3
  contact_published.py ironing --cells 40

--cells are those along an eighth of a great circle of the spheres, along a side of the block that is twisted, and along 10 mm of the slab
that is ironed. Every step is written to standard error; the table at the end says how many did not converge. Needs the Python package of
the build: PYTHONPATH=build/release/python.
"""
import argparse
import math
import sys
import time
import warnings

import numpy as np
import stroma

FAILED = []  # steps that did not converge


class Mesh:
    """Hexahedra, in layers over quads."""

    def __init__(self):
        self.points, self.cells, self.index = [], [], {}

    def node(self, p):
        key = tuple(round(c * 1e9) for c in p)
        if key not in self.index:
            self.index[key] = len(self.points)
            self.points.append(p)
        return self.index[key]

    def add(self, low, high):
        """A cell over a quad of nodes below and one above, both anticlockwise from above."""
        self.cells.append((*low, *high))


def brick(x, y, z):
    mesh = Mesh()
    for i in range(len(x) - 1):
        for j in range(len(y) - 1):
            for k in range(len(z) - 1):
                quads = [[mesh.node((x[a], y[b], z[c])) for a, b in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1))]
                         for c in (k, k + 1)]
                mesh.add(*quads)
    return mesh


def shell(sides, radii):
    """Parts of the sides of a cube around the middle of a sphere, drawn to spheres. A side has an axis, a sign, and angles
    along the other two axes."""
    mesh = Mesh()
    for axis, sign, u, v in sides:
        def at(a, b, r):
            p = np.zeros(3)
            p[axis] = sign
            p[1 if axis == 0 else 0], p[1 if axis == 2 else 2] = math.tan(a), math.tan(b)
            return mesh.node(tuple(r * p / np.linalg.norm(p)))
        right = (-1 if axis == 1 else 1) * sign > 0
        for i in range(len(u) - 1):
            for j in range(len(v) - 1):
                for k in range(len(radii) - 1):
                    corners = [(u[i], v[j]), (u[i + 1], v[j]), (u[i + 1], v[j + 1]), (u[i], v[j + 1])]
                    if not right:
                        corners = [corners[0], corners[3], corners[2], corners[1]]
                    mesh.add(*([at(a, b, r) for a, b in corners] for r in radii[k:k + 2]))
    return mesh


def numbers(rows, digits=12):
    return "  ".join(" ".join(f"{value:.{digits}g}" for value in row) for row in rows)


def indices(rows):
    return "  ".join(" ".join(map(str, row)) for row in rows)


def prism_cells(a):
    """A prism of nodes 0 1 2 below 3 4 5 in three tetrahedra; diagonals of sides start at the smallest node (Dompierre 1999)."""
    turns = ((0, 1, 2, 3, 4, 5), (1, 2, 0, 4, 5, 3), (2, 0, 1, 5, 3, 4), (3, 5, 4, 0, 2, 1), (4, 3, 5, 1, 0, 2), (5, 4, 3, 2, 1, 0))
    v = [a[i] for i in turns[min(range(6), key=lambda i: a[i])]]
    if min(v[1], v[5]) < min(v[2], v[4]):
        return [(v[0], v[1], v[2], v[5]), (v[0], v[1], v[5], v[4]), (v[0], v[4], v[5], v[3])]
    return [(v[0], v[1], v[2], v[4]), (v[0], v[4], v[2], v[5]), (v[0], v[4], v[5], v[3])]


def quadratic(mesh, radial):
    """(points, tetrahedra of ten nodes) of these hexahedra; with `radial` nodes on edges lie at the mean distance of the ends from the
    origin."""
    points, middle_of, cells = [np.array(p) for p in mesh.points], {}, []

    def middle(a, b):
        key = (min(a, b), max(a, b))
        if key not in middle_of:
            middle_of[key] = len(points)
            p = (points[a] + points[b]) / 2
            if radial:
                p = p * (np.linalg.norm(points[a]) + np.linalg.norm(points[b])) / 2 / np.linalg.norm(p)
            points.append(p)
        return middle_of[key]

    for cell in mesh.cells:
        low, high = cell[:4], cell[4:]
        first = min(range(4), key=lambda i: low[i])
        turn = [(first + i) % 4 for i in range(4)]
        for t in ((0, 1, 2), (0, 2, 3)):
            for a, b, c, d in prism_cells([low[turn[i]] for i in t] + [high[turn[i]] for i in t]):
                if np.dot(np.cross(points[b] - points[a], points[c] - points[a]), points[d] - points[a]) < 0:
                    a, b = b, a
                cells.append((a, b, c, d, middle(a, b), middle(b, c), middle(a, c), middle(a, d), middle(b, d), middle(c, d)))
    return points, cells


def body(name, mesh, young, poisson, rest, cells="hexahedra", radial=False):
    """A node with a state of this mesh. `rest` makes its constraints from the points and from which of them a condition holds for."""
    points, force = mesh.points, "HexahedronHyperelasticityFEMForceField"
    listed = f'hexahedra="{indices(mesh.cells)}"'
    if cells == "quadratic":
        points, tetrahedra = quadratic(mesh, radial)
        listed, force = f'quadraticTetrahedra="{indices(tetrahedra)}"', "QuadraticTetrahedronHyperelasticityFEMForceField"

    def where(condition):
        return [i for i, p in enumerate(points) if condition(p)]

    return (f'<Node name="{name}"><MeshTopology name="mesh" position="{numbers(points)}" {listed}/><MechanicalObject name="dofs"/>'
            f'<UniformMass totalMass="1"/><{force} materialName="NeoHookean" youngModulus="{young}" poissonRatio="{poisson}"/>'
            f'{rest(points, where)}</Node>')


def joined(items):
    return " ".join(map(str, items))


def scene(content, residual):
    return (f'<Node name="root" dt="1" gravity="0 0 0"><StaticSolver relative_residual_tolerance_threshold="{residual}"/>'
            f'<SparseLDLSolver/>{content}</Node>')


def barrier(name, bodies, gap, more):
    return f'<BarrierContact name="{name}" {bodies} selfContact="0" contactDistance="{gap}" {more}/>'


def opened(text):
    return stroma.load(stroma.from_xml_text(text), quiet=True)


def stepped(simulation, step, name):
    """The wrench on the first body of a contact after a step."""
    start = time.process_time()
    report = simulation.step()
    FAILED.extend([] if report.newton_converged else [step])
    wrench = np.array(simulation["/" + name].wrenches).reshape(-1)
    print(f"step {step}: {numbers([wrench[:6]], 5)}, {report.newton_iterations} iterations, {time.process_time() - start:.2f} s",
          file=sys.stderr, flush=True)
    return wrench


def spheres(asked):
    """Two hollow spheres, radii 10, 12 and 14 mm, between plates (Puso and Laursen 2004): an eighth, in mm, N and MPa."""
    gap, plate_gap = asked.gap or 0.025, 0.05
    angles, steps, way = np.linspace(0, math.pi / 4, asked.cells + 1), 30, 0.25

    def held(points, where):
        return "".join(f'<PartialFixedProjectiveConstraint indices="{joined(where(lambda p, a=axis: abs(p[a]) < 1e-9))}" '
                       f'fixedDirections="{joined(int(axis == b) for b in range(3))}"/>' for axis in range(3))

    def sphere(name, inner, outer):
        mesh = shell([(axis, 1, angles, angles) for axis in range(3)], np.linspace(inner, outer, asked.layers + 1))
        return body(name, mesh, 1, 0.3, held, asked.elements, True)

    simulation = opened(scene(
        sphere("outer", 12 + gap / 2, 14) + sphere("inner", 10, 12 - gap / 2) +
        barrier("between", 'mstate="@outer/dofs" topology="@outer/mesh" other="@inner/dofs"', gap,
                f'friction="{asked.friction}" slipVelocity="1e-3" frictionIterations="20"') +
        barrier("plate", 'mstate="@outer/dofs" topology="@outer/mesh"', plate_gap,
                f'stiffness="1" planes="0 0 -1 {-14 - plate_gap}" keyTimes="0 {steps}" movements="0 0 0  0 0 {-way * steps}"') +
        barrier("ground", 'mstate="@inner/dofs" topology="@inner/mesh"', plate_gap, f'stiffness="1" planes="0 0 1 {-plate_gap}"'),
        3e-4))
    rows = []
    for step in range(1, steps + 1):
        force = -stepped(simulation, step, "plate")[2]
        if way * step in (2.5, 5, 6, 7.5):
            rows.append((f"force after {way * step} mm", f"{force:.3f} N"))
    return rows


def twist(asked):
    """A half-sphere with radii 2/3 and 1 and E = 5 is pressed by 1 into a block of 2 x 2 x 2 with E = 1 without friction, and then turned
    with it (Sauer and De Lorenzis 2015). The sphere's middle is the origin, the block below it."""
    gap, n, per_step, pressing = asked.gap or 0.02, asked.cells, 4, 10
    # what closes of the gap: half of it, as the mean pressure is about that of kappa
    turning, depth = round(asked.degrees / per_step), 1 + 0.5 * gap
    whole, low = np.linspace(-math.pi / 4, math.pi / 4, n + 1), np.linspace(-math.pi / 4, 0, n // 2 + 1)
    across = np.linspace(-1, 1, n + 1)
    block = brick(across, across, np.linspace(-3 - gap, -1 - gap, n + 1))
    sphere = shell([(0, 1, whole, low), (0, -1, whole, low), (1, 1, whole, low), (1, -1, whole, low), (2, -1, whole, whole)],
                   np.linspace(2 / 3, 1, asked.layers + 1))

    def hand(points, where):
        text, angles = "", np.radians(per_step * np.arange(1, turning + 1))
        for i in where(lambda p: p[2] > -1e-9):
            x, y = points[i][0], points[i][1]
            moves = [(0, 0, 0), (0, 0, -depth)] + [(math.cos(a) * x - math.sin(a) * y - x, math.sin(a) * x + math.cos(a) * y - y, -depth)
                                                   for a in angles]
            text += (f'<LinearMovementProjectiveConstraint outside="hold" indices="{i}" movements="{numbers(moves)}" '
                     f'keyTimes="0 {joined(range(pressing, pressing + turning + 1))}"/>')
        return text

    def held(points, where):
        return f'<FixedProjectiveConstraint indices="{joined(where(lambda p: p[2] < -3 - gap + 1e-9))}"/>'

    bodies = body("block", block, 1, 0.3, held, asked.elements) + body("sphere", sphere, 5, 0.3, hand, asked.elements, True)

    def made(mu):
        return opened(scene(bodies + barrier("contact", 'mstate="@sphere/dofs" topology="@sphere/mesh" other="@block/dofs"', gap,
                                             f'friction="{mu}" slipVelocity="2e-4" frictionIterations="20"'), 1e-4))

    pressed, turned = made(0), made(0.5)
    for step in range(1, pressing + 1):
        wrench = stepped(pressed, step, "contact")
    rows = [("force when pressed", f"{wrench[2]:.3f}")]
    turned.restore(pressed.checkpoint())
    for step in range(1, turning + 1):
        wrench = stepped(turned, pressing + step, "contact")
        if step * per_step in (20, 40, 80, 120, 180):
            rubs = np.cross(np.array(turned.state("/sphere").x), np.array(turned["/contact"].frictionForces).reshape(-1, 3))
            rows.append((f"force and torque at {step * per_step} degrees, torque of the friction alone",
                         f"{wrench[2]:.3f} {-wrench[5]:.3f} {-rubs[:, 2].sum():.3f}"))
    return rows


def graded(h, even, growth, end):
    """From 0 in cells of size h up to `even`, then each `growth` times larger than the one before, up to `end`."""
    x = [0.0]
    while x[-1] < end:
        if x[-1] > even - 0.5 * h:
            h *= growth
        x.append(end if x[-1] + h > end - 0.5 * h else x[-1] + h)
    return x


def ironing(asked):
    """A block with a round lower side is pressed 1 mm into a slab of 12 x 4 mm with a tenth of its modulus, and drawn along by 10 mm
    (Fischer and Wriggers 2006); plane strain, in mm, N and MPa. The slab is 1.25 wide across that plane, so that no edges meet, and its
    modulus is divided by 1.25: forces are those for a width of 1. The block starts after 0.2 mm."""
    h, gap, young, beyond = 10 / asked.cells, asked.gap or 0.06, 689.6, 0.125
    pressing, drawing, depth = 8, 0 if asked.pressed else asked.cells, 0.8 + 0.4 * gap
    slab = brick(graded(h, 12, 1, 12), (-beyond, 1 + beyond), [-z for z in reversed(graded(0.6 * h, 1, 1.25, 4))])
    half, radius, n = 0.6, 0.75, round(3 / h)
    block = brick(np.linspace(-half, half, n + 1), (0, 1), np.linspace(0, 1, n // 2 + 1))
    for i, (x, y, t) in enumerate(block.points):
        angle = math.asin(half / radius) * x / half
        block.points[i] = (0.8 + (1 - t) * radius * math.sin(angle) + t * x, y,
                           gap + (1 - t) * radius * (1 - math.cos(angle)) + t * 1.2)
    plane = '<PartialFixedProjectiveConstraint fixAll="true" fixedDirections="0 1 0"/>'

    def held(_, where):
        return plane + f'<FixedProjectiveConstraint indices="{joined(where(lambda p: p[2] < -4 + 1e-9))}"/>'

    def hand(_, where):
        return plane + (f'<LinearMovementProjectiveConstraint indices="{joined(where(lambda p: p[2] > gap + 1.2 - 1e-9))}" outside="hold" '
                        f'keyTimes="0 {pressing} {pressing + asked.cells}" movements="0 0 0  0 0 {-depth}  10 0 {-depth}"/>')

    simulation = opened(scene(
        body("slab", slab, young / (1 + 2 * beyond), 0.32, held) + body("block", block, 10 * young, 0.32, hand) +
        barrier("contact", 'mstate="@block/dofs" topology="@block/mesh" other="@slab/dofs"', gap,
                'friction="0.3" slipVelocity="4e-2" frictionIterations="8"'), 1e-3))
    forces = [np.zeros(2)] + [stepped(simulation, step, "contact")[[2, 0]] * (1, -1) for step in range(1, pressing + drawing + 1)]
    rows = [("down and along when pressed", numbers([forces[pressing]], 4) + " N/mm")]
    if drawing:
        way = np.arange(drawing + 1) * h
        down, along = (np.interp(5, way, [force[k] for force in forces[pressing:]]) for k in range(2))
        rows.append(("down and along after 5 mm", f"{down:.1f} {along:.1f} N/mm"))
    return rows


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("benchmark", choices=["spheres", "twist", "ironing"])
    parser.add_argument("--cells", type=int, required=True)
    parser.add_argument("--layers", type=int, default=2, help="cells over the wall of a sphere")
    parser.add_argument("--elements", choices=["hexahedra", "quadratic"], default="hexahedra",
                        help="of spheres and twist; quadratic tetrahedra: each hexahedron cut in six")
    parser.add_argument("--gap", type=float, default=0, help="contactDistance between the bodies, if not that of the page")
    parser.add_argument("--friction", type=float, default=0, help="of the spheres")
    parser.add_argument("--degrees", type=float, default=180, help="of the twist")
    parser.add_argument("--pressed", action="store_true", help="the block is not drawn along")
    asked = parser.parse_args()
    warnings.simplefilter("ignore")
    rows = {"spheres": spheres, "twist": twist, "ironing": ironing}[asked.benchmark](asked)
    for name, value in rows:
        print(f"{name}: {value}")
    print(f"steps that did not converge: {len(FAILED)}")


if __name__ == "__main__":
    main()
