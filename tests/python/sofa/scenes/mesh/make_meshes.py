# SPDX-License-Identifier: LGPL-2.1-or-later
"""Makes the meshes of these scenes: a finger of tetrahedra, its surface, a cavity in it, a cube, cables."""
import itertools
import json
import os

import numpy as np

HERE = os.path.dirname(os.path.abspath(__file__))


def grid(low, high, counts):
    axes = [np.linspace(a, b, n) for a, b, n in zip(low, high, counts)]
    points = [(x, y, z) for z in axes[2] for y in axes[1] for x in axes[0]]

    def at(i, j, k):
        return i + counts[0] * (j + counts[1] * k)
    return points, at


def tetrahedra(counts, at):
    """Six around the diagonal of each cell."""
    found = []
    for i, j, k in itertools.product(*(range(n - 1) for n in counts)):
        for order in itertools.permutations(range(3)):
            step, path = [i, j, k], [at(i, j, k)]
            for axis in order:
                step[axis] += 1
                path.append(at(*step))
            odd = order in ((0, 2, 1), (1, 0, 2), (2, 1, 0))
            found.append((path[0], path[2], path[1], path[3]) if odd else tuple(path))
    return found


def surface(counts, at):
    """Two triangles on each face of a cell that is outside, seen from there counterclockwise."""
    found = []
    for axis in range(3):
        a, b = (axis + 1) % 3, (axis + 2) % 3
        for end in (0, counts[axis] - 1):
            for i, j in itertools.product(range(counts[a] - 1), range(counts[b] - 1)):
                def corner(u, v):
                    place = [0, 0, 0]
                    place[axis], place[a], place[b] = end, i + u, j + v
                    return at(*place)
                quad = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)]
                quad = quad if end else quad[::-1]
                found += [quad[:3], [quad[0], quad[2], quad[3]]]
    return found


def write_vtk(name, points, cells):
    with open(os.path.join(HERE, name), "w", encoding="ascii") as file:
        file.write(f"# vtk DataFile Version 3.0\n{name}\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS {len(points)} double\n")
        file.writelines(f"{x:g} {y:g} {z:g}\n" for x, y, z in points)
        file.write(f"CELLS {len(cells)} {5 * len(cells)}\n")
        file.writelines("4 " + " ".join(map(str, cell)) + "\n" for cell in cells)
        file.write(f"CELL_TYPES {len(cells)}\n" + "10\n" * len(cells))


def write_stl(name, points, triangles):
    with open(os.path.join(HERE, name), "w", encoding="ascii") as file:
        file.write(f"solid {name}\n")
        for triangle in triangles:
            file.write("facet normal 0 0 0\nouter loop\n")
            file.writelines("vertex {:g} {:g} {:g}\n".format(*points[node]) for node in triangle)
            file.write("endloop\nendfacet\n")
        file.write(f"endsolid {name}\n")


def write_obj(name, points, triangles):
    with open(os.path.join(HERE, name), "w", encoding="ascii") as file:
        file.writelines("v {:g} {:g} {:g}\n".format(*point) for point in points)
        file.writelines("f {} {} {}\n".format(*(node + 1 for node in triangle)) for triangle in triangles)


def main():
    counts = (9, 3, 3)
    points, at = grid((0, 0, 0), (80, 20, 20), counts)
    write_vtk("finger.vtk", points, tetrahedra(counts, at))
    write_stl("finger.stl", points, surface(counts, at))
    counts = (5, 2, 2)
    points, at = grid((8, 6, 6), (72, 14, 14), counts)
    write_stl("cavity.stl", points, surface(counts, at))
    counts = (2, 2, 2)
    points, at = grid((-1, -1, -1), (1, 1, 1), counts)
    write_obj("cube.obj", points, surface(counts, at))
    with open(os.path.join(HERE, "cable.json"), "w", encoding="ascii") as file:
        json.dump([[x, 18.0, 10.0] for x in (10.0, 30.0, 50.0, 70.0)], file)


if __name__ == "__main__":
    main()
