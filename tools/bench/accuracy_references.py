#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""The references of `stroma bench --accuracy` that another program computed. Needs CalculiX (ccx).

    tools/bench/accuracy_references.py

Each problem is solved on two meshes of quadratic hexahedra with reduced integration (C3D20R), the finer with half as many cells
again along each axis. The finer value is the reference, and how far the two are apart its uncertainty. The organ and the leg are
solved on the scenes' own meshes of linear tetrahedra (C3D4): what is left between the two programs is the method and the solver.
accuracy_problems.cpp holds what this prints."""
import os
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "validate"))
import everyday  # noqa: E402
from everyday import Brick, Deck, FACES, EDGES, ROOT, at, clamp, neo_hooke  # noqa: E402


class LoadedDeck(Deck):
    """A dead load along an axis, spread evenly over the cells' faces whose corners `where` chooses (rest shape)."""

    def __init__(self, *arguments, load, where, axis, **more):
        super().__init__(*arguments, **more)
        self.__dict__.update(load=load, where=where, load_axis=axis)

    def text(self):
        b, forces = self.brick, {}
        faces = [(cell, f) for cell in b.cells for f, face in enumerate(FACES) if all(self.where(b.nodes[cell[k]]) for k in face)]
        for cell, f in faces:  # consistent: corners -1/12 each, the middles of the edges 1/3
            face = set(FACES[f])
            for k in face:
                forces[cell[k]] = forces.get(cell[k], 0) - self.load / len(faces) / 12
            for e, edge in enumerate(EDGES):
                if set(edge) <= face:
                    forces[cell[8 + e]] = forces.get(cell[8 + e], 0) + self.load / len(faces) / 3
        assert abs(sum(forces.values()) - self.load) < 1e-9 * abs(self.load)
        lines = "\n".join(f"{node + 1},{self.load_axis},{value:.10e}" for node, value in sorted(forces.items()))
        return super().text().replace("*DLOAD", "*CLOAD\n" + lines)


def cantilever():
    """scenes/benchmarks/cantilever.xml"""
    brick = Brick((30, 4, 4), (.2, .02, .02), quadratic=True)
    return LoadedDeck(brick, [(1e6, .3)], clamp, load=-1 / 3, where=at(0, .2), axis=2, large=True), at(0, .2), 1


def cook():
    """scenes/benchmarks/cook.xml: mm, N, MPa; plane strain, one cell thick"""
    brick = Brick((16, 16, 1), (48, 44, 1), quadratic=True,
                  curve=lambda p: (p[0], 44 * p[0] / 48 + p[1] / 44 * (44 - 28 * p[0] / 48), p[2]))
    shear, poisson = .4225, .4999
    held = lambda p: (1, 2, 3) if p[0] < 1e-9 else (3,)  # noqa: E731
    deck = LoadedDeck(brick, [neo_hooke(2 * shear * (1 + poisson), poisson)], held, load=.0625 * 16, where=at(0, 48), axis=2,
                      large=True, hyperelastic=True)
    return deck, lambda p: abs(p[0] - 48) < 1e-6 and abs(p[1] - 60) < 1e-6, 1


def cube():
    """scenes/benchmarks/pressed_cube.xml: mm, kPa"""
    case = everyday.CASES["pressed_cube"]
    return case.reference(), lambda p: all(abs(a - b) < 1e-6 for a, b in zip(p, (80, 40, 40))), case.axis


def read_msh(name):
    """Nodes, and tetrahedra by their label, of a mesh of the scenes (Gmsh 2.2)."""
    with open(os.path.join(ROOT, "scenes", "meshes", name)) as file:
        lines = file.read().split("\n")
    first, count = lines.index("$Nodes") + 2, int(lines[lines.index("$Nodes") + 1])
    nodes = [tuple(map(float, line.split()[1:4])) for line in lines[first:first + count]]
    first, count = lines.index("$Elements") + 2, int(lines[lines.index("$Elements") + 1])
    cells = {}
    for words in map(str.split, lines[first:first + count]):
        if words[1] == "4":
            cells.setdefault(int(words[3]), []).append(words[3 + int(words[2]):])
    return nodes, cells


def on_own_mesh(name, materials, held, loaded, force, large):
    """Mean displacement along y of the nodes `loaded`, which share a force along y; `materials` by label."""
    nodes, cells = read_msh(name)
    chosen = [i + 1 for i, p in enumerate(nodes) if loaded(p)]
    out = ["*NODE,NSET=ALL"] + [f"{i+1},{p[0]:.12e},{p[1]:.12e},{p[2]:.12e}" for i, p in enumerate(nodes)]
    number = 0
    for label, (young, poisson) in materials.items():
        out.append(f"*ELEMENT,TYPE=C3D4,ELSET=E{label}")
        for cell in cells[label]:
            number += 1
            out.append(f"{number}," + ",".join(cell))
        out += [f"*MATERIAL,NAME=M{label}", "*ELASTIC", f"{young},{poisson}", f"*SOLID SECTION,ELSET=E{label},MATERIAL=M{label}"]
    out += ["*STEP,NLGEOM,INC=500" if large else "*STEP", "*STATIC", "0.1,1" if large else "1,1"]
    if large:  # force residual and correction, as shares
        out += ["*CONTROLS,PARAMETERS=FIELD", "1e-8,1e-8"]
    out += ["*BOUNDARY"] + [f"{i+1},1,3,0" for i, p in enumerate(nodes) if held(p)]
    out += ["*CLOAD"] + [f"{i},2,{force / len(chosen):.12e}" for i in chosen]
    out += ["*NODE PRINT,NSET=ALL,FREQUENCY=1000", "U", "*END STEP", ""]
    with tempfile.TemporaryDirectory() as folder:
        with open(os.path.join(folder, "deck.inp"), "w") as file:
            file.write("\n".join(out))
        done = subprocess.run(["ccx", "deck"], cwd=folder, capture_output=True, text=True)
        moved = {}
        with open(os.path.join(folder, "deck.dat")) as lines:
            for words in map(str.split, lines):
                if len(words) == 4 and words[0].isdigit():
                    moved[int(words[0])] = float(words[2])
    if len(moved) < len(nodes):
        raise RuntimeError(done.stdout[-2000:])
    return sum(moved[i] for i in chosen) / len(chosen)


def inside(low, high):
    return lambda p: all(a <= c <= b for a, c, b in zip(low, p, high))


def organ():
    """scenes/benchmarks/pulled_organ.xml"""
    _, cells = read_msh("organ_600.msh")
    return on_own_mesh("organ_600.msh", {label: (1e4, .45) for label in cells}, lambda p: p[0] <= -.06, lambda p: p[0] >= .085, -3, True)


def leg():
    """scenes/benchmarks/condensed_leg.xml"""
    knee, ankle = inside((-.030, -.015, .320), (.016, .032, .346)), inside((-.026, -.016, .018), (.030, .026, .040))
    band = inside((-.060, .020, .150), (.060, .060, .190))
    return on_own_mesh("leg.msh", {1: (2e4, .45), 2: (2e7, .3), 3: (2e7, .3)}, lambda p: knee(p) or ankle(p), band, -1.5, False)


def main():
    version = subprocess.run(["ccx", "-v"], capture_output=True, text=True).stdout.split()[-1]
    for problem in (cantilever, cook, cube):
        values = []
        for refined in (1, 1.5):
            everyday.REFINED = refined
            deck, where, axis = problem()
            corners = [(i, deck.brick.nodes[i]) for i in deck.brick.corner]
            values.append(everyday.mean(corners, deck.solve(), where, axis))
        print(f"{problem.__name__}: {values[1]:.6g}, {100 * abs(values[1] / values[0] - 1):.2g} % from {values[0]:.6g}; "
              f"CalculiX {version}, {len(deck.brick.cells)} C3D20R", flush=True)
    for problem in (organ, leg):
        print(f"{problem.__name__}: {problem():.7g}; CalculiX {version}, C3D4 of the same mesh", flush=True)


if __name__ == "__main__":
    main()
