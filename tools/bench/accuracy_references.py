#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""The references of `stroma bench --accuracy` that another program computed. Needs CalculiX (ccx).

    tools/bench/accuracy_references.py

Each problem is solved on two meshes of quadratic hexahedra with reduced integration (C3D20R), the finer with half as many cells
again along each axis. The finer value is the reference, and how far the two are apart its uncertainty. accuracy_problems.cpp
holds what this prints."""
import os
import subprocess
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "validate"))
import everyday  # noqa: E402
from everyday import Brick, Deck, FACES, EDGES, at, clamp, neo_hooke  # noqa: E402


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


if __name__ == "__main__":
    main()
