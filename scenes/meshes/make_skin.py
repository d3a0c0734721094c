#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Makes the example patch of skin: fat of hexahedra, a layer of pyramids and tetrahedra, and skin of prisms on top. It is half of a
patch, up to a plane of symmetry.

Every cell between fat and skin has a node in its middle: five pyramids stand on its quads below and around, and two tetrahedra on
the halves of its top, on which the prisms stand. The same arguments give the same file, byte for byte.

  make_skin.py --out skin.msh            12 x 6 cells
  make_skin.py --cells 24 --out fine.msh

Lengths are metres; y points out of the skin, the plane of symmetry is z = 0. Exit codes: 0 written, 2 bad arguments.
"""
import argparse

HALF, CUP = 0.020, 0.0082                # half the width of the patch, the radius of the cup [m]
FAT, MIDDLE, SKIN = (0, 0.003, 0.006), 0.0085, (0.0094, 0.0103)
ROUND = 0.6                              # 0: a square, 1: a disc
GMSH = {"triangle": 2, "tetrahedron": 4, "hexahedron": 5, "prism": 6, "pyramid": 7}


class Patch:
    def __init__(self, cells):
        self.cells, self.nodes, self.elements = cells, [], []
        self.levels = [self.level(z) for z in (*FAT, MIDDLE, *SKIN)]

    def level(self, z):
        """The nodes of a height: numbers by (i, j)."""
        numbers = {}
        for j in range(self.cells // 2, self.cells + 1):
            for i in range(self.cells + 1):
                u, v = 2 * i / self.cells - 1, 2 * j / self.cells - 1
                x, y = u * ((1 - ROUND) + ROUND * (1 - v * v / 2) ** 0.5), v * ((1 - ROUND) + ROUND * (1 - u * u / 2) ** 0.5)
                numbers[i, j] = self.add((HALF * x, z, -HALF * y))
        return numbers

    def add(self, place):
        self.nodes.append(place)
        return len(self.nodes)

    def fill(self):
        for j in range(self.cells // 2, self.cells):
            for i in range(self.cells):
                corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)]
                for low, high in zip(self.levels[:2], self.levels[1:3]):
                    self.put("hexahedron", 1, [low[c] for c in corners] + [high[c] for c in corners])
                self.between([self.levels[2][c] for c in corners], [self.levels[3][c] for c in corners], (i + j) % 2)
                for half in self.halves(corners, (i + j) % 2):
                    for low, high in zip(self.levels[3:5], self.levels[4:]):
                        self.put("prism", 2, [low[c] for c in half] + [high[c] for c in half])
                    self.load([self.levels[5][c] for c in half])

    @staticmethod
    def halves(quad, turned):
        a, b, c, d = quad
        return ((a, b, d), (b, c, d)) if turned else ((a, b, c), (a, c, d))

    def between(self, low, high, turned):
        places = [self.nodes[n - 1] for n in low + high]
        top = self.add(tuple(sum(p[k] for p in places) / 8 for k in range(3)))
        self.put("pyramid", 1, [*low, top])
        for k in range(4):
            m = (k + 1) % 4
            self.put("pyramid", 1, [low[m], low[k], high[k], high[m], top])
        for a, b, c in self.halves(high, turned):
            self.put("tetrahedron", 1, [a, c, b, top])

    def load(self, triangle):
        x, y = (sum(self.nodes[n - 1][k] for n in triangle) / 3 for k in (0, 2))
        if x * x + y * y < CUP * CUP:
            self.put("triangle", 3, triangle)

    def put(self, kind, group, nodes):
        self.elements.append((GMSH[kind], group, nodes))

    def text(self):
        lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", "3", '3 1 "fat"', '3 2 "skin"', '2 3 "cup"',
                 "$EndPhysicalNames", "$Nodes", str(len(self.nodes))]
        lines += [f"{n} {x:.6g} {y:.6g} {z:.6g}" for n, (x, y, z) in enumerate(self.nodes, 1)]
        lines += ["$EndNodes", "$Elements", str(len(self.elements))]
        for n, (kind, group, nodes) in enumerate(self.elements, 1):
            lines.append(f"{n} {kind} 2 {group} {group} " + " ".join(map(str, nodes)))
        return "\n".join(lines + ["$EndElements", ""])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cells", type=int, default=12, help="along the plane of symmetry, an even number (default: 12)")
    parser.add_argument("--out", required=True, help="a .msh file, Gmsh's format 2.2")
    arguments = parser.parse_args()
    if arguments.cells < 2 or arguments.cells % 2:
        parser.error("--cells: an even number, at least 2")
    patch = Patch(arguments.cells)
    patch.fill()
    with open(arguments.out, "w", encoding="ascii") as file:
        file.write(patch.text())


if __name__ == "__main__":
    main()
