#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Forty scenes as people write them, with default settings, against closed forms and CalculiX.

    docs/validate/everyday.py --stroma build/release/bin/stroma [NAME ...]

runs scenes/validation/everyday/*.xml and prints for each the quantity, its reference and the error. A scene is right when
the error is below 3 %, or when the run says in a sentence that it is not to be relied on. Closed forms are below, with their
sources. References of CalculiX are in references.json beside the scenes, with its version; --calculix makes them again, on
meshes of quadratic hexahedra (C3D20R) of their own: on one, and on one with cells half as much again along each axis,
whose value is the reference. How far the two are apart is in the table. Meshes that no grid component makes are written by
--meshes."""
import argparse
import gzip
import json
import math
import os
import subprocess
import sys
import tempfile

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
SCENES = os.path.join(ROOT, "scenes", "validation", "everyday")
RIGHT = 0.03


# ---- bricks: structured meshes, with holes and curved ----

CORNERS = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))
EDGES = ((0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7))
FACES = ((0, 1, 2, 3), (4, 7, 6, 5), (0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0))  # in CalculiX's order


REFINED = 1  # times as many cells along each axis, in bricks of quadratic cells


def graded(*parts):
    """Coordinates of the cells' ends, from parts (from, to, cells, small at the start, small at the end): each cell twice
    as long as its neighbour on the small side."""
    ends = [parts[0][0]]
    for start, end, cells, at_start, at_end in parts:
        cells = round(cells * REFINED)
        far = [min(i if at_start else cells, cells - 1 - i if at_end else cells) for i in range(cells)]
        sizes = [2.0 ** (f if at_start or at_end else 0) for f in far]
        for size in sizes:
            ends.append(ends[-1] + size * (end - start) / sum(sizes))
        ends[-1] = end
    return ends


class Brick:
    """Cells of a grid n over a box, or between the coordinates `axes` of their ends; `keep(centre)` leaves holes,
    `curve(point)` bends it."""

    def __init__(self, n=None, size=None, keep=lambda c: True, curve=lambda p: p, quadratic=False, axes=None):
        self.nodes, self.cells, self.centres, number = [], [], [], {}
        if axes is None:
            if quadratic:
                n = [round(k * REFINED) for k in n]
            axes = [[s * i / k for i in range(k + 1)] for s, k in zip(size, n)]
        n = [len(ends) - 1 for ends in axes]

        def place(half):
            return tuple(ends[h // 2] if h % 2 == 0 else (ends[h // 2] + ends[h // 2 + 1]) / 2
                         for h, ends in zip(half, axes))

        def node(half):  # in halves of cells
            if half not in number:
                number[half] = len(self.nodes)
                self.nodes.append(curve(place(half)))
            return number[half]

        for k in range(n[2]):
            for j in range(n[1]):
                for i in range(n[0]):
                    centre = place((2 * i + 1, 2 * j + 1, 2 * k + 1))
                    if not keep(centre):
                        continue
                    halves = [tuple(2 * (a + b) for a, b in zip((i, j, k), corner)) for corner in CORNERS]
                    cell = [node(h) for h in halves]
                    if quadratic:
                        cell += [node(tuple((a + b) // 2 for a, b in zip(halves[p], halves[q]))) for p, q in EDGES]
                    self.cells.append(cell)
                    self.centres.append(centre)
        self.corner = sorted({c for cell in self.cells for c in cell[:8]})

    def boundary(self):
        """(cell, face, its four corners) of faces with one cell."""
        seen = {}
        for c, cell in enumerate(self.cells):
            for f, face in enumerate(FACES):
                corners = [cell[a] for a in face]
                seen.setdefault(tuple(sorted(corners)), []).append((c, f, corners))
        return [found[0] for found in seen.values() if len(found) == 1]


def write_msh(path, brick, loaded, tetrahedra=False):
    """Gmsh 2.2: cells of group 1 and the loaded faces, outward, of group 2."""
    elements = []
    for cell in brick.cells:
        if tetrahedra:  # six around the diagonal 0-6
            ring = (1, 2, 3, 7, 4, 5)
            elements += [f"4 2 1 1 {cell[0]+1} {cell[ring[i]]+1} {cell[ring[(i+1) % 6]]+1} {cell[6]+1}" for i in range(6)]
        else:
            elements.append("5 2 1 1 " + " ".join(str(c + 1) for c in cell))
    for c, f, corners in brick.boundary():
        if not loaded(brick.centres[c], [brick.nodes[n] for n in corners]):
            continue
        quad = [n + 1 for n in corners[::-1]]  # FACES are seen from inside
        if tetrahedra:  # the diagonal of the tetrahedra's face is that with corner 0 or 6
            cell = brick.cells[c]
            at = next(i for i, n in enumerate(quad) if n - 1 in (cell[0], cell[6]))
            quad = quad[at:] + quad[:at]
            elements += [f"2 2 2 2 {quad[0]} {quad[1]} {quad[2]}", f"2 2 2 2 {quad[0]} {quad[2]} {quad[3]}"]
        else:
            elements.append("3 2 2 2 " + " ".join(map(str, quad)))
    with open(path, "w") as out:
        out.write('$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n3 1 "body"\n2 2 "loaded"\n$EndPhysicalNames\n')
        out.write(f"$Nodes\n{len(brick.nodes)}\n")
        out.writelines(f"{i+1} {p[0]:.12g} {p[1]:.12g} {p[2]:.12g}\n" for i, p in enumerate(brick.nodes))
        out.write(f"$EndNodes\n$Elements\n{len(elements)}\n")
        out.writelines(f"{i+1} {e}\n" for i, e in enumerate(elements))
        out.write("$EndElements\n")


def quarter_tube(p):
    """(radius - a, angle share, z) -> a quarter of a tube of inner radius 10."""
    r, angle = 10 + p[0], p[1] * math.pi / 2
    return (r * math.cos(angle), r * math.sin(angle), p[2])


def in_channel(c):
    """Of the finger, 60 x 12 x 16 mm: a closed channel 4 x 4 mm wide near its top, walls of 4 mm."""
    return 4 < c[0] < 56 and 4 < c[1] < 8 and 8 < c[2] < 12


def finger():
    """Eight cells over a wall."""
    return Brick((60, 24, 32), (60, 12, 16), keep=lambda c: not in_channel(c))


def half_finger(poisson):
    """Up to the plane y = 6, with cells that become small towards the edges of the channel, where strains have no bound."""
    axes = (graded((0, 4, 3, 0, 1), (4, 30, 6, 1, 0), (30, 56, 6, 0, 1), (56, 60, 2, 1, 0)),
            graded((0, 4, 3, 0, 1), (4, 6, 2, 1, 0)),
            graded((0, 8, 4, 0, 1), (8, 12, 5, 1, 1), (12, 16, 3, 1, 0)))
    return Deck(Brick(axes=axes, keep=lambda c: not in_channel(c), quadratic=True), [(500, poisson)],
                lambda p: (1, 2, 3) if p[0] < 1e-9 else (2,) if abs(p[1] - 6) < 1e-9 else (), pressure=2,
                pressed=lambda c, q: on_channel(c, q) and not all(abs(p[1] - 6) < 1e-9 for p in q))


def cavity_walls(c):
    return max(c) > 10


def on_cavity(centre, points):
    return any(all(abs(p[a] - 10) < 1e-9 for p in points) for a in range(3)) and all(max(p) < 10.01 for p in points)


def quarter_ring(p):
    """(radius - 40, angle share, z)"""
    r, angle = 40 + p[0], p[1] * math.pi / 2
    return (r * math.cos(angle), r * math.sin(angle), p[2])


def in_angle(c):
    return c[0] < 10 or c[2] < 10


def on_channel(centre, points):
    return all(3.99 < p[0] < 56.01 and 3.99 < p[1] < 8.01 and 7.99 < p[2] < 12.01 for p in points)


def over_channel(p):
    return abs(p[0] - 30) < 1e-6 and abs(p[1] - 6) < 1e-6 and abs(p[2] - 16) < 1e-6


def on_bore(centre, points):
    return all(abs(math.hypot(p[0], p[1]) - 10) < 1e-6 for p in points)


def write_meshes(folder):
    write_msh(os.path.join(folder, "finger.msh"), finger(), on_channel)
    write_msh(os.path.join(folder, "finger_tetrahedra.msh"), finger(), on_channel, tetrahedra=True)
    write_msh(os.path.join(folder, "cavity.msh"), Brick((16, 16, 16), (20, 20, 20), keep=cavity_walls), on_cavity)
    nowhere = lambda centre, points: False
    write_msh(os.path.join(folder, "arch.msh"), Brick((8, 56, 8), (10, 1, 10), curve=quarter_ring), nowhere)
    write_msh(os.path.join(folder, "bracket.msh"), Brick((40, 8, 40), (50, 10, 50), keep=in_angle), nowhere)
    tube = Brick((8, 24, 1), (5, 1, 1), curve=quarter_tube)
    write_msh(os.path.join(folder, "tube.msh"), tube, on_bore)
    write_msh(os.path.join(folder, "tube_tetrahedra.msh"), tube, on_bore, tetrahedra=True)


# ---- CalculiX ----

class Deck:
    """A static problem for ccx. Faces and nodes are chosen by predicates on points."""

    def __init__(self, brick, materials, held, layer=lambda c: 0, gravity=None, density=0, pressure=0,
                 pressed=lambda c, p: False, moved=None, large=False, hyperelastic=False):
        self.__dict__.update(locals())

    def text(self):
        b, out = self.brick, ["*NODE,NSET=ALL"]
        out += [f"{i+1},{p[0]:.10e},{p[1]:.10e},{p[2]:.10e}" for i, p in enumerate(b.nodes)]
        for m, material in enumerate(self.materials):
            out.append(f"*ELEMENT,TYPE=C3D20R,ELSET=E{m}")
            for c, cell in enumerate(b.cells):
                if self.layer(b.centres[c]) == m:
                    ids = [str(n + 1) for n in cell]
                    out += [f"{c+1}," + ",".join(ids[:10]) + ",", ",".join(ids[10:])]
            out.append(f"*MATERIAL,NAME=M{m}")
            if self.hyperelastic:
                out += ["*HYPERELASTIC,NEO HOOKE", f"{material[0]},{material[1]}"]
            else:
                out += ["*ELASTIC", f"{material[0]},{material[1]}"]
            if self.density:
                out += ["*DENSITY", f"{self.density}"]
            out.append(f"*SOLID SECTION,ELSET=E{m},MATERIAL=M{m}")
        out.append("*STEP,NLGEOM,INC=500" if self.large else "*STEP")
        out += ["*STATIC", "0.2,1" if self.large else "1,1", "*BOUNDARY"]
        for i, p in enumerate(b.nodes):
            out += [f"{i+1},{axis},{axis},0" for axis in self.held(p)]
            if self.moved:
                out += [f"{i+1},{axis},{axis},{value:.10e}" for axis, value in self.moved(p)]
        out.append("*DLOAD")
        if self.gravity:
            size = math.sqrt(sum(g * g for g in self.gravity))
            direction = ",".join(str(g / size) for g in self.gravity)
            out += [f"E{m},GRAV,{size},{direction}" for m in range(len(self.materials))]
        for c, f, corners in b.boundary():
            if self.pressure and self.pressed(b.centres[c], [b.nodes[n] for n in corners]):
                out.append(f"{c+1},P{f+1},{self.pressure}")
        out += ["*NODE PRINT,NSET=ALL,FREQUENCY=1000", "U", "*END STEP", ""]
        return "\n".join(out)

    def solve(self):
        """Displacements of all nodes at the end."""
        with tempfile.TemporaryDirectory() as folder:
            with open(os.path.join(folder, "deck.inp"), "w") as out:
                out.write(self.text())
            done = subprocess.run(["ccx", "deck"], cwd=folder, capture_output=True, text=True)
            moved = {}
            with open(os.path.join(folder, "deck.dat")) as lines:
                for line in lines:
                    words = line.split()
                    if len(words) == 4 and words[0].isdigit():
                        moved[int(words[0]) - 1] = tuple(map(float, words[1:]))
            if len(moved) < len(self.brick.nodes):
                raise RuntimeError(done.stdout[-2000:])
            return moved


def mean(points, moved, where, axis):
    chosen = [i for i, p in points if where(p)]
    return sum(moved[i][axis] for i in chosen) / len(chosen)


# ---- the scenes ----

def at(axis, value):
    return lambda p: abs(p[axis] - value) < 1e-6 * max(1, abs(value))


def clamp(p):
    return (1, 2, 3) if abs(p[0]) < 1e-9 else ()


def beam(n, size, young, poisson, density, g, **more):
    return Deck(Brick(n, size, quadratic=True), [(young, poisson)], clamp, gravity=(0, 0, -g), density=density, **more)


def neo_hooke(young, poisson):
    """C10 and D1 of CalculiX: W = C10 (I1' - 3) + (J - 1)^2 / D1."""
    return (young / 4 / (1 + poisson), 6 * (1 - 2 * poisson) / young)


def lame_tube(young, poisson, pressure, a=10.0, b=15.0):
    """Plane strain, radial displacement of the bore (Lame; Timoshenko and Goodier 1970, section 28)."""
    return pressure * a * (1 + poisson) / young * ((1 - 2 * poisson) * a * a + b * b) / (b * b - a * a)


def mooney_rivlin_bar(c1, c2, force, area, length):
    """End displacement of an incompressible Mooney-Rivlin bar under a dead load: P = 2 (l - l^-2)(c1 + c2 / l) A."""
    low, high = 1.0, 3.0
    for _ in range(100):
        l = (low + high) / 2
        low, high = (l, high) if 2 * (l - l ** -2) * (c1 + c2 / l) * area < force else (low, l)
    return (low - 1) * length


def loaded_tip(young, poisson, traction, length, side):
    """Timoshenko's beam of a square section, clamped, under a traction along its end (Cowper 1966 for the shear)."""
    force, inertia, shear = traction * side ** 2, side ** 4 / 12, 10 * (1 + poisson) / (12 + 11 * poisson)
    return (force * length ** 3 / (3 * young * inertia)
            + force * length / (shear * young / 2 / (1 + poisson) * side ** 2))


class Case:
    """`where`, `axis`: the quantity is the mean displacement of these nodes of the rest shape. `reference`: a number (closed
    form) or a Deck; `source`: what it is. `cheap`: takes a second or so. `steps`: until it is at rest."""

    def __init__(self, where, axis, reference, source="CalculiX", state=None, cheap=False, steps=1):
        self.where, self.axis, self.reference, self.source = where, axis, reference, source
        self.state, self.cheap, self.steps = state, cheap, steps


FINE = (30, 4, 4)  # cells of quadratic beams
CASES = {
    "slender_si": Case(at(0, 1), 2, lambda: beam(FINE, (1, .1, .1), 1e5, .3, 1000, .05)),
    "slender_kpa": Case(at(0, 100), 2, lambda: beam(FINE, (100, 10, 10), 30, .45, 1e-6, 100)),
    "slender_mpa": Case(at(0, 100), 2, lambda: beam(FINE, (100, 10, 10), .05, .49, 1e-9, 100)),
    "slender_0499": Case(at(0, 1), 2, lambda: beam(FINE, (1, .1, .1), 1e5, .499, 1000, .05)),
    "slender_tetrahedra": Case(at(0, 1), 2, lambda: beam(FINE, (1, .1, .1), 1e5, .3, 1000, .05)),
    "slender_tetrahedra_049": Case(at(0, 100), 2, lambda: beam(FINE, (100, 10, 10), .05, .49, 1e-9, 100)),
    "slender_tetrahedra_0499": Case(at(0, 1), 2, lambda: beam(FINE, (1, .1, .1), 1e5, .499, 1000, .05)),
    "stout_si": Case(at(0, .2), 2, lambda: beam((12, 6, 6), (.2, .1, .1), 1e4, .3, 1000, .5), cheap=True),
    "stout_kpa": Case(at(0, 20), 2, lambda: beam((12, 6, 6), (20, 10, 10), 10, .495, 1e-6, 500), cheap=True),
    "stout_tetrahedra": Case(at(0, 20), 2, lambda: beam((12, 6, 6), (20, 10, 10), 10, .45, 1e-6, 500), cheap=True),
    "plate": Case(lambda p: abs(p[0] - 50) < 1e-6 and abs(p[1] - 50) < 1e-6, 2, lambda: Deck(
        Brick((14, 14, 4), (50, 50, 10), quadratic=True), [(100, .4)],
        lambda p: [a for a, on in ((1, p[0] < 1e-9 or p[1] < 1e-9 or abs(p[0] - 50) < 1e-6),
                                   (2, p[0] < 1e-9 or p[1] < 1e-9 or abs(p[1] - 50) < 1e-6),
                                   (3, p[0] < 1e-9 or p[1] < 1e-9)) if on],
        pressure=.05, pressed=lambda c, q: all(abs(p[2] - 10) < 1e-6 for p in q))),
    "bridge": Case(at(0, .5), 2, lambda: Deck(
        Brick((28, 4, 4), (1, .1, .1), quadratic=True), [(2e4, .49)],
        lambda p: (1, 2, 3) if p[0] < 1e-9 or abs(p[0] - 1) < 1e-9 else (), gravity=(0, 0, -.05), density=1000)),
    "elastica": Case(at(0, 1), 2, -.30172, "elastica, P L^2/EI = 1"),
    "bent_far": Case(at(0, 1), 2, lambda: beam(FINE, (1, .1, .1), 1e5, .45, 1000, .5, large=True)),
    "pressed_cube": Case(lambda p: abs(p[0] - 80) < 1e-6 and abs(p[2] - 40) < 1e-6, 0, lambda: Deck(
        Brick((8, 8, 8), (80, 80, 80), quadratic=True), [neo_hooke(14.9, .499)],
        lambda p: (1, 2, 3) if p[2] < 1e-9 else (1, 2) if abs(p[2] - 80) < 1e-6 else (), large=True, hyperelastic=True,
        moved=lambda p: [(3, -8)] if abs(p[2] - 80) < 1e-6 else []), cheap=True),
    "neo_hookean_beam": Case(at(0, 100), 2, lambda: beam(FINE, (100, 10, 10), 30, .49, 1e-6, 1000, large=True)),
    "neo_hookean_tetrahedra": Case(at(0, 100), 2, lambda: beam(FINE, (100, 10, 10), 30, .49, 1e-6, 1000, large=True)),
    "pad": Case(at(2, 10), 2, lambda: Deck(
        Brick((10, 10, 5), (40, 40, 10), quadratic=True), [(50, .499)], lambda p: (1, 2, 3) if p[2] < 1e-9 else (),
        pressure=1, pressed=lambda c, q: all(abs(p[2] - 10) < 1e-6 for p in q))),
    "stretched_bar": Case(at(0, .1), 0, mooney_rivlin_bar(5e3, 2e3, 2., 1e-4, .1), "Mooney-Rivlin, incompressible", cheap=True),
    "layers": Case(at(2, 16), 2, lambda: Deck(
        Brick((6, 6, 8), (16, 16, 16), quadratic=True), [(5, .45), (100, .3)], lambda p: (1, 2, 3) if p[2] < 1e-9 else (),
        layer=lambda c: int(c[2] > 8), pressure=.1, pressed=lambda c, q: all(abs(p[2] - 16) < 1e-6 for p in q)), cheap=True),
    "sandwich": Case(at(0, 120), 2, lambda: Deck(
        Brick((30, 4, 6), (120, 8, 12), quadratic=True), [(100, .49), (5, .49), (40, .45)], clamp,
        layer=lambda c: 0 if c[2] > 8 else 1 if c[2] > 4 else 2, gravity=(0, 0, -100), density=1e-6)),
    "hanging_column": Case(at(2, 0), 2, -1000 * 9.81 * 1 / (2 * 1e6), "rho g L^2 / 2E"),
    "hanging_cloth": Case(at(2, 0), 2, -200 * 9.81 * 1 / (2 * 1e6), "rho g L^2 / 2E", cheap=True),
    "tube": Case(lambda p: abs(math.hypot(p[0], p[1]) - 10) < 1e-6 and p[1] < 1e-6, 0, lame_tube(100, .3, 1), "Lame",
                 cheap=True),
    "tube_0499": Case(lambda p: abs(math.hypot(p[0], p[1]) - 10) < 1e-6 and p[1] < 1e-6, 0, lame_tube(100, .499, 1), "Lame",
                      cheap=True),
    "tube_tetrahedra": Case(lambda p: abs(math.hypot(p[0], p[1]) - 10) < 1e-6 and p[1] < 1e-6, 0, lame_tube(100, .499, 1),
                            "Lame", cheap=True),
    "finger": Case(over_channel, 2, lambda: half_finger(.45)),
    "finger_tetrahedra": Case(over_channel, 2, lambda: half_finger(.45)),
    "finger_0499": Case(over_channel, 2, lambda: half_finger(.499)),
    "attached_organs": Case(at(2, 20), 2, lambda: Deck(
        Brick((4, 4, 8), (10, 10, 20), quadratic=True), [(10, .45), (5, .49)], lambda p: (1, 2, 3) if p[2] < 1e-9 else (),
        layer=lambda c: int(c[2] > 10), gravity=(0, 0, -1000), density=1e-6), state="upper.dofs"),
    "three_blocks": Case(at(2, 30), 2, lambda: Deck(
        Brick((4, 4, 12), (10, 10, 30), quadratic=True), [(20, .3), (5, .499), (10, .45)],
        lambda p: (1, 2, 3) if p[2] < 1e-9 else (), layer=lambda c: int(c[2] // 10), gravity=(0, 0, -500), density=1e-6),
        state="third.dofs", cheap=True),
    "tip_traction": Case(at(0, 80), 2, -loaded_tip(1, .3, 1e-4, 80, 10), "Timoshenko's beam", cheap=True),
    "arch": Case(lambda p: p[0] < 1e-6, 1, lambda: Deck(
        Brick((4, 24, 4), (10, 1, 10), curve=quarter_ring, quadratic=True), [(30, .45)],
        lambda p: (1, 2, 3) if p[1] < 1e-9 else (), gravity=(0, -50, 0), density=1e-6, large=True)),
    "bracket": Case(at(0, 50), 2, lambda: Deck(
        Brick((20, 4, 20), (50, 10, 50), keep=in_angle, quadratic=True), [(50, .49)],
        lambda p: (1, 2, 3) if abs(p[2] - 50) < 1e-6 else (), gravity=(0, 0, -100), density=1e-6)),
    "cavity": Case(lambda p: abs(p[0] - 20) < 1e-6 and p[1] < 1e-6 and p[2] < 1e-6, 0, lambda: Deck(
        Brick(axes=[graded((0, 10, 4, 0, 1), (10, 20, 4, 1, 0))] * 3, keep=cavity_walls, quadratic=True), [(20, .49)],
        lambda p: [a + 1 for a in range(3) if p[a] < 1e-9], pressure=.2, pressed=on_cavity)),
    "pulled_gel": Case(lambda p: abs(p[0] - 15) < 1e-6 and p[1] < 1e-6 and abs(p[2] - 5) < 1e-6, 1, lambda: Deck(
        Brick((12, 4, 4), (30, 10, 10), quadratic=True), [neo_hooke(30, .49)],
        lambda p: (1, 2, 3) if p[0] < 1e-9 else (2, 3) if abs(p[0] - 30) < 1e-6 else (), large=True, hyperelastic=True,
        moved=lambda p: [(1, 15)] if abs(p[0] - 30) < 1e-6 else [])),
    "plate_tetrahedra": Case(lambda p: abs(p[0] - 20) < 1e-6 and abs(p[1] - 20) < 1e-6, 2, lambda: Deck(
        Brick((12, 12, 3), (20, 20, 4), quadratic=True), [(100, .3)],
        lambda p: [a for a, on in ((1, p[0] < 1e-9 or p[1] < 1e-9 or abs(p[0] - 20) < 1e-6),
                                   (2, p[0] < 1e-9 or p[1] < 1e-9 or abs(p[1] - 20) < 1e-6),
                                   (3, p[0] < 1e-9 or p[1] < 1e-9)) if on],
        pressure=.02, pressed=lambda c, q: all(abs(p[2] - 4) < 1e-6 for p in q))),
    "settled": Case(at(0, 60), 2, lambda: beam((20, 4, 4), (60, 10, 10), 30, .45, 1e-6, 100), steps=80),
    "hung_by_springs": Case(at(2, 10), 2, -(1 / (81 * .05) + 10 / (100 * 500) + 1e-3 * 100 / (2 * 500)), "weights over stiffness",
                            state="lower.dofs", cheap=True),
    "pad_tetrahedra": Case(at(2, 10), 2, lambda: Deck(
        Brick((10, 10, 5), (40, 40, 10), quadratic=True), [(50, .499)], lambda p: (1, 2, 3) if p[2] < 1e-9 else (),
        pressure=1, pressed=lambda c, q: all(abs(p[2] - 10) < 1e-6 for p in q))),
}


# ---- running ----

def read_states(folder):
    states = {}
    for name in os.listdir(folder):
        if name.endswith(".state.gz"):
            with gzip.open(os.path.join(folder, name), "rt") as lines:
                rows = [list(map(float, l.split("=")[1].split())) for l in lines if l.strip().startswith("X=")]
            states[name[:-len(".state.gz")]] = [[tuple(r[3 * i:3 * i + 3]) for i in range(len(r) // 3)] for r in rows]
    return states


def run(stroma, name, meshes):
    """(value, what the run said)."""
    case = CASES[name]
    scene = os.path.join(SCENES, name + ".xml")
    with tempfile.TemporaryDirectory() as folder:
        command = [stroma, "run", scene, "-n", str(case.steps), "--record", folder]
        with open(scene) as text:
            if "MeshGmshLoader" in text.read():
                mesh = "finger" if name == "finger_0499" else "tube" if name == "tube_0499" else name
                command += ["--set", f"/loader.filename={meshes}/{mesh}.msh"]
        done = subprocess.run(command, capture_output=True, text=True)
        said = [l.partition("note: ")[2] or l.partition("warning: ")[2] for l in done.stderr.splitlines()
                if "note: " in l or "warning: " in l]
        if done.returncode:
            return math.nan, [done.stderr.strip().splitlines()[-1] if done.stderr.strip() else "no result"]
        states = read_states(folder)
        frames = states[case.state] if case.state else next(iter(states.values()))
        rest, moved = frames[0], frames[-1]
        u = {i: tuple(b - a for a, b in zip(p, q)) for i, (p, q) in enumerate(zip(rest, moved))}
        return mean(list(enumerate(rest)), u, case.where, case.axis), said


def make_references(names):
    path = os.path.join(SCENES, "references.json")
    stored = json.load(open(path)) if os.path.exists(path) else {}
    version = subprocess.run(["ccx", "-v"], capture_output=True, text=True).stdout.split()[-1]
    for name in names:
        case = CASES[name]
        if not callable(case.reference):
            continue
        values = []
        for refined in (1, 1.5):
            globals()["REFINED"] = refined
            deck = case.reference()
            corners = [(i, deck.brick.nodes[i]) for i in deck.brick.corner]
            values.append(mean(corners, deck.solve(), case.where, case.axis))
        stored[name] = {"value": float(f"{values[1]:.6g}"), "program": "CalculiX " + version, "element": "C3D20R",
                        "cells": len(deck.brick.cells), "coarser": float(f"{values[0]:.6g}")}
        print(name, stored[name], flush=True)
        with open(path, "w") as out:
            json.dump(stored, out, indent=1, sort_keys=True)
            out.write("\n")


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("names", nargs="*", metavar="NAME")
    options.add_argument("--stroma", default="stroma")
    options.add_argument("--cheap", action="store_true", help="only those that take a second or so")
    options.add_argument("--calculix", action="store_true", help="make the references of CalculiX again")
    options.add_argument("--meshes", metavar="DIR", help="write the meshes there, and no more")
    given = options.parse_args()
    names = given.names or [n for n in CASES if CASES[n].cheap or not given.cheap]
    unknown = [n for n in names if n not in CASES]
    if unknown:
        options.error(f"there is no scene {unknown[0]}; those there are: {', '.join(CASES)}")
    if given.meshes:
        return write_meshes(given.meshes)
    if given.calculix:
        return make_references(names)
    with open(os.path.join(SCENES, "references.json")) as file:
        stored = json.load(file)
    wrong = 0
    print("| scene | value | reference | by | coarser | error | verdict |\n|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as meshes:
        write_meshes(meshes)
        for name in names:
            case = CASES[name]
            reference = stored[name]["value"] if callable(case.reference) else case.reference
            source = stored[name]["program"] if callable(case.reference) else case.source
            value, said = run(given.stroma, name, meshes)
            coarser = f"{100 * (stored[name]['coarser'] / reference - 1):+.2f} %" if callable(case.reference) else ""
            error = value / reference - 1
            sentence = next((s for s in said[::-1] if any(w in s for w in ("too stiff", "coarse", "cells lock", " locks"))), "")
            right = abs(error) < RIGHT
            verdict = "right" if right else "said: " + sentence if sentence else "wrong" + (": " + said[-1] if said else "")
            wrong += not (right or sentence)
            print(f"| {name} | {value:.5g} | {reference:.5g} | {source} | {coarser} | {100 * error:+.2f} % | {verdict} |", flush=True)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
