#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Makes the example organ: a liver-like body as a tetrahedral mesh of good quality.

The shape is implicit: a large right lobe and a thin left lobe (ellipsoids, smoothly joined), a hollow below where the
other organs lie and a notch for the gall bladder. It is filled by isosurface stuffing (Labelle and Shewchuk 2007): a
body-centred cubic lattice, lattice points near the surface moved onto it, and the cells that the surface still cuts
replaced by a few tetrahedra. The same arguments give the same file, byte for byte.

  make_organ.py --tets 600 --out organ_600.msh     about 600 tetrahedra (the lattice spacing is searched)
  make_organ.py --spacing 0.012 --out organ.msh    a spacing in metres
  make_organ.py --tets 300 --out organ_300.vtk     legacy VTK instead of Gmsh
  make_organ.py --report organ_600.msh             quality of an existing file of this tool

Lengths are metres; x points to the organ's left, y up, z to the front. Needs numpy only. Exit codes: 0 written, 1 the
mesh does not reach the quality asked for, 2 bad arguments.
"""
import argparse
import itertools
import sys

try:
    import numpy as np
except ImportError:
    print(f"{os.path.basename(__file__)}: error: the Python of {sys.executable} has no numpy: take another one, such as /usr/bin/python3 "
          "with Debian's python3-numpy, or install numpy for it", file=sys.stderr)
    sys.exit(2)

# A cut point nearer to a lattice point than this share of the edge moves the point onto the surface; the two values
# (axis-aligned "long" edges, diagonal "short" ones) are those for which the paper proves its bound on the angles.
ALPHA_LONG, ALPHA_SHORT = 0.24999, 0.41189
DECIMALS = 5  # 0.01 mm: far below the size of a cell, and the file stays small


# ---- the shape: negative inside, about the distance to the surface in metres ----

def ellipsoid(p, centre, radii):
    q = (p - centre) / radii
    k0 = np.linalg.norm(q, axis=-1)
    k1 = np.linalg.norm(q / radii, axis=-1)
    return np.where(k1 > 1e-9, k0 * (k0 - 1) / np.maximum(k1, 1e-9), -min(radii))


def smooth_min(a, b, width):
    """Minimum of a and b, rounded where they differ by less than `width`."""
    h = np.maximum(width - np.abs(a - b), 0) / width
    return np.minimum(a, b) - h * h * width / 4


def smooth_subtract(body, tool, width):
    return -smooth_min(-body, tool, width)


def organ(p):
    p = np.asarray(p, float)
    right = ellipsoid(p, np.array([-0.034, 0.0, 0.0]), np.array([0.066, 0.056, 0.062]))
    left = ellipsoid(p, np.array([0.052, 0.017, 0.008]), np.array([0.062, 0.030, 0.044]))
    body = smooth_min(right, left, 0.040)
    hollow = ellipsoid(p, np.array([0.060, -0.092, 0.0]), np.array([0.105, 0.094, 0.110]))
    body = smooth_subtract(body, hollow, 0.014)
    gall_bladder = ellipsoid(p, np.array([-0.002, -0.024, 0.050]), np.array([0.017, 0.026, 0.030]))
    return smooth_subtract(body, gall_bladder, 0.010)


LOW, HIGH = np.array([-0.11, -0.07, -0.075]), np.array([0.125, 0.07, 0.075])


# ---- the lattice ----

def lattice_cells(n):
    """Tetrahedra of the lattice over n cells as keys of doubled integer coordinates: corners even, centres odd. Each
    joins two neighbouring centres (long edge) to an edge of the face between them (long edge)."""
    cells = []
    for i, j, k in itertools.product(range(n[0]), range(n[1]), range(n[2])):
        centre = np.array([2 * i + 1, 2 * j + 1, 2 * k + 1])
        for axis in range(3):
            step = np.zeros(3, int)
            step[axis] = 2
            u, v = np.zeros(3, int), np.zeros(3, int)
            u[(axis + 1) % 3], v[(axis + 2) % 3] = 1, 1
            middle = centre + step // 2
            ring = [middle - u - v, middle + u - v, middle + u + v, middle - u + v]
            for a, b in zip(ring, ring[1:] + ring[:1]):
                cells.append([tuple(centre), tuple(centre + step), tuple(a), tuple(b)])
    return cells


def surface_points(inside, outside):
    """Where the surface crosses each segment, by bisection."""
    for _ in range(40):
        middle = (inside + outside) / 2
        is_inside = (organ(middle) < 0)[:, None]
        inside, outside = np.where(is_inside, middle, inside), np.where(is_inside, outside, middle)
    return (inside + outside) / 2


class Stuffing:
    """Points with a sign (-1 inside, 0 on the surface, 1 outside), cut points, and the tetrahedra between them."""

    def __init__(self, spacing):
        n = np.ceil((HIGH - LOW) / spacing).astype(int) + 1
        origin = (LOW + HIGH) / 2 - spacing * n / 2
        cells = lattice_cells(n)
        keys = sorted({key for cell in cells for key in cell})
        position = origin + spacing / 2 * np.array(keys)
        sign = np.where(organ(position) < 0, -1, 1)
        number = {key: index for index, key in enumerate(keys)}
        cells = np.array([[number[key] for key in cell] for cell in cells])
        cells = cells[(sign[cells] < 0).any(axis=1)]
        self.keys, self.position, self.sign, self.cells = keys, list(position), sign, cells
        self.cut = {}        # (inside, outside) -> index of the cut point
        self.tetrahedra = []

    def is_long(self, a, b):
        return sum(x != y for x, y in zip(self.keys[a], self.keys[b])) == 1

    def cut_edges(self):
        """Cut points of all lattice edges that the surface crosses: (a, b) with a inside -> (point, share from a)."""
        crossed = {}
        for cell in self.cells:
            for a, b in itertools.combinations(cell, 2):
                if self.sign[a] * self.sign[b] < 0:
                    crossed[(a, b) if self.sign[a] < 0 else (b, a)] = None
        ends = np.array([[self.position[a], self.position[b]] for a, b in crossed])
        edges = {}
        for (a, b), point in zip(crossed, surface_points(ends[:, 0], ends[:, 1])):
            length = np.linalg.norm(self.position[b] - self.position[a])
            edges[a, b] = point, np.linalg.norm(point - self.position[a]) / length
        return edges

    def warp(self):
        """Moves every lattice point that has a cut point too near onto the nearest such point."""
        edges = self.cut_edges()
        around = {}
        for (a, b), (point, share) in edges.items():
            around.setdefault(a, []).append((b, point, share))
            around.setdefault(b, []).append((a, point, 1 - share))
        for node in sorted(around):
            near = [(np.linalg.norm(point - self.position[node]), tuple(point))
                    for other, point, share in around[node]
                    if self.sign[other] and share < (ALPHA_LONG if self.is_long(node, other) else ALPHA_SHORT)]
            if near:
                self.position[node] = np.array(min(near)[1])
                self.sign[node] = 0
        for (a, b), (point, _) in edges.items():
            if self.sign[a] and self.sign[b]:
                self.cut[a, b] = len(self.position)
                self.position.append(point)

    def fill(self):
        for cell in self.cells:
            inside = [v for v in cell if self.sign[v] < 0]
            zero = [v for v in cell if self.sign[v] == 0]
            outside = [v for v in cell if self.sign[v] > 0]
            if not inside:
                continue
            if not outside:
                self.tetrahedra.append(list(cell))
            elif len(inside) == 1:
                self.tetrahedra.append(inside + zero + [self.cut[inside[0], v] for v in outside])
            elif len(inside) == 2 and len(outside) == 1:
                self.pyramid(*inside, outside[0], zero[0])
            elif len(inside) == 2:
                self.two_inside(inside, outside)
            else:
                self.three_inside(inside, outside[0])

    def diagonal(self, a, b, v):
        """The quadrilateral a, b, cut(b), cut(a) of a face whose vertex v is outside: the inside vertex from which its
        diagonal starts. It ends at the cut point of a long edge when there is one (it is the shorter one then), else at
        the vertex with the smaller key, so that both cells at the face agree."""
        if self.is_long(a, v):
            return b
        if self.is_long(b, v):
            return a
        return a if self.keys[a] < self.keys[b] else b

    def pyramid(self, a, b, v, apex):
        start = self.diagonal(a, b, v)
        other = b if start == a else a
        end = self.cut[other, v]
        self.tetrahedra += [[start, other, end, apex], [start, end, self.cut[start, v], apex]]

    def two_inside(self, inside, outside):
        """A prism between the inside edge and the surface; its third quadrilateral lies on the surface, so its diagonal
        is free: of the possible fillings the one with the better worst angle is taken."""
        a, b = inside
        v, w = outside
        prism = [a, self.cut[a, v], self.cut[a, w]], [b, self.cut[b, v], self.cut[b, w]]
        needed = [(self.diagonal(a, b, v), v), (self.diagonal(a, b, w), w)]
        required = {frozenset((start, self.cut[b if start == a else a, outer])) for start, outer in needed}
        self.fill_prism(*prism, required)

    def three_inside(self, inside, v):
        cuts = [self.cut[a, v] for a in inside]
        required = set()
        for a, b in itertools.combinations(inside, 2):
            start = self.diagonal(a, b, v)
            required.add(frozenset((start, self.cut[b if start == a else a, v])))
        self.fill_prism(inside, cuts, required)

    def fill_prism(self, bottom, top, required):
        """The best three tetrahedra of the prism bottom-top that contain all `required` diagonals."""
        best = None
        for order in itertools.permutations(range(3)):
            p, q, r = order
            filling = [[bottom[p], bottom[q], bottom[r], top[r]], [bottom[p], bottom[q], top[q], top[r]],
                       [bottom[p], top[p], top[q], top[r]]]
            diagonals = {frozenset((bottom[p], top[q])), frozenset((bottom[p], top[r])),
                         frozenset((bottom[q], top[r]))}
            if required <= diagonals:
                worst = dihedral_angles(np.array([[self.position[v] for v in tet] for tet in filling])).min()
                if best is None or worst > best[0] + 1e-9:
                    best = worst, filling
        assert best is not None, "the diagonals of a prism go round in a circle"
        self.tetrahedra += best[1]


def largest_body(tetrahedra):
    """The tetrahedra of the largest part connected through faces (a thin edge of the shape can break off)."""
    parent = list(range(len(tetrahedra)))

    def root(i):
        while parent[i] != i:
            parent[i] = parent[parent[i]]
            i = parent[i]
        return i

    faces = {}
    for index, tet in enumerate(tetrahedra):
        for face in itertools.combinations(sorted(tet), 3):
            if face in faces:
                parent[root(index)] = root(faces[face])
            faces[face] = index
    roots = [root(i) for i in range(len(tetrahedra))]
    biggest = max(sorted(set(roots)), key=roots.count)
    return [tet for tet, part in zip(tetrahedra, roots) if part == biggest], len(set(roots))


def make(spacing):
    """(positions, tetrahedra) with positive volumes, nodes sorted along x, no unused node."""
    stuffing = Stuffing(spacing)
    stuffing.warp()
    stuffing.fill()
    tetrahedra = np.array(largest_body(stuffing.tetrahedra)[0])
    position = np.round(np.array(stuffing.position), DECIMALS)
    used = sorted(set(tetrahedra.ravel()), key=lambda v: (tuple(position[v]), v))
    number = {old: new for new, old in enumerate(used)}
    tetrahedra = np.array([[number[v] for v in tet] for tet in tetrahedra])
    position = position[used] + 0.0
    flip = volumes(position[tetrahedra]) < 0
    tetrahedra[flip] = tetrahedra[flip][:, [0, 2, 1, 3]]
    return position, tetrahedra[np.lexsort(tetrahedra.T[::-1])]


def make_with_count(count):
    """The mesh with the number of tetrahedra nearest to `count` among spacings in steps of 1 %."""
    volume = 1.0e-3  # of the order of the organ's; the search corrects it
    spacing = (12 * volume / count) ** (1 / 3)
    for _ in range(6):
        got = len(make(spacing)[1])
        spacing *= (max(got, 1) / count) ** (1 / 3)
    candidates = [make(spacing * factor) for factor in np.linspace(0.94, 1.06, 13)]
    good = [mesh for mesh in candidates if dihedral_angles(mesh[0][mesh[1]]).min() > 10.5] or candidates
    return min(good, key=lambda mesh: abs(len(mesh[1]) - count))


# ---- quality ----

def volumes(corners):
    a, b, c, d = (corners[:, i] for i in range(4))
    return np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) / 6


def dihedral_angles(corners):
    """The six angles between faces of each tetrahedron, in degrees; shape (tetrahedra, 6)."""
    angles = []
    for i, j in itertools.combinations(range(4), 2):
        k, l = (m for m in range(4) if m not in (i, j))
        edge = corners[:, j] - corners[:, i]
        n1 = np.cross(edge, corners[:, k] - corners[:, i])
        n2 = np.cross(edge, corners[:, l] - corners[:, i])
        angles.append(np.degrees(np.arctan2(np.linalg.norm(np.cross(n1, n2), axis=1),
                                            np.einsum("ij,ij->i", n1, n2))))
    return np.array(angles).T


def report(position, tetrahedra):
    """Prints the quality of a mesh; true when it is good enough to simulate with."""
    corners = position[tetrahedra]
    volume, angles = volumes(corners), dihedral_angles(corners)
    bodies = largest_body([list(tet) for tet in tetrahedra])[1]
    size = position.max(axis=0) - position.min(axis=0)
    faces = {}
    for tet in tetrahedra:
        for face in itertools.combinations(sorted(tet), 3):
            faces[face] = faces.get(face, 0) + 1
    surface = [face for face, count in faces.items() if count == 1]
    edges = {}
    for face in surface:
        for edge in itertools.combinations(face, 2):
            edges[edge] = edges.get(edge, 0) + 1
    closed = all(count == 2 for count in edges.values())
    lengths = np.array([np.linalg.norm(corners[:, i] - corners[:, j], axis=1)
                        for i, j in itertools.combinations(range(4), 2)])
    print(f"{len(position)} nodes, {len(tetrahedra)} tetrahedra, {len(surface)} surface triangles")
    print(f"size {size[0]:.3f} x {size[1]:.3f} x {size[2]:.3f} m, volume {volume.sum() * 1e6:.1f} cm3, "
          f"smallest cell {volume.min() * 1e9:.2f} mm3")
    print(f"edges {lengths.min() * 1e3:.2f} to {lengths.max() * 1e3:.2f} mm, "
          f"dihedral angles {angles.min():.1f} to {angles.max():.1f} degrees")
    print(f"{bodies} connected bod{'y' if bodies == 1 else 'ies'}, surface "
          f"{'closed, two triangles at every edge' if closed else 'NOT a closed manifold'}")
    return volume.min() > 0 and angles.min() > 10 and bodies == 1 and closed


# ---- files ----

def write_msh(path, position, tetrahedra):
    """Gmsh format 2.2, ASCII; one physical volume named organ."""
    with open(path, "w", encoding="ascii", newline="\n") as file:
        file.write("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n")
        file.write('$PhysicalNames\n1\n3 1 "organ"\n$EndPhysicalNames\n')
        file.write(f"$Nodes\n{len(position)}\n")
        for index, point in enumerate(position, 1):
            file.write(f"{index} " + " ".join(f"{value:.{DECIMALS}f}" for value in point) + "\n")
        file.write(f"$EndNodes\n$Elements\n{len(tetrahedra)}\n")
        for index, tet in enumerate(tetrahedra, 1):
            file.write(f"{index} 4 2 1 1 " + " ".join(str(v + 1) for v in tet) + "\n")
        file.write("$EndElements\n")


def write_vtk(path, position, tetrahedra):
    """Legacy VTK, ASCII."""
    with open(path, "w", encoding="ascii", newline="\n") as file:
        file.write("# vtk DataFile Version 3.0\norgan\nASCII\nDATASET UNSTRUCTURED_GRID\n")
        file.write(f"POINTS {len(position)} double\n")
        for point in position:
            file.write(" ".join(f"{value:.{DECIMALS}f}" for value in point) + "\n")
        file.write(f"CELLS {len(tetrahedra)} {5 * len(tetrahedra)}\n")
        for tet in tetrahedra:
            file.write("4 " + " ".join(str(v) for v in tet) + "\n")
        file.write(f"CELL_TYPES {len(tetrahedra)}\n" + "10\n" * len(tetrahedra))


def read_msh(path):
    """Reads what write_msh wrote."""
    with open(path, encoding="ascii") as file:
        lines = file.read().split("\n")
    if lines[:2] != ["$MeshFormat", "2.2 0 8"]:
        sys.exit(f"{path}: expected Gmsh format 2.2 in ASCII")
    start = lines.index("$Nodes") + 2
    position = np.array([line.split()[1:] for line in lines[start:start + int(lines[start - 1])]], float)
    start = lines.index("$Elements") + 2
    cells = [[int(word) for word in line.split()] for line in lines[start:start + int(lines[start - 1])]]
    return position, np.array([cell[-4:] for cell in cells if cell[1] == 4]) - 1


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument("--tets", type=int, help="about so many tetrahedra (100 to 100000)")
    what.add_argument("--spacing", type=float, help="lattice spacing [m], 0.002 to 0.06")
    what.add_argument("--report", metavar="FILE.msh", help="only print the quality of a file")
    parser.add_argument("--out", help="file to write (.msh, or .vtk for legacy VTK)")
    arguments = parser.parse_args()
    if arguments.report:
        sys.exit(0 if report(*read_msh(arguments.report)) else 1)
    if not arguments.out:
        parser.error("--out FILE.msh is missing")
    if arguments.tets is not None and not 100 <= arguments.tets <= 100000:
        parser.error(f"--tets {arguments.tets}: expected 100 to 100000")
    if arguments.spacing is not None and not 0.002 <= arguments.spacing <= 0.06:
        parser.error(f"--spacing {arguments.spacing}: expected 0.002 to 0.06 m")
    position, tetrahedra = make_with_count(arguments.tets) if arguments.tets else make(arguments.spacing)
    good = report(position, tetrahedra)
    write = write_vtk if arguments.out.endswith(".vtk") else write_msh
    write(arguments.out, position, tetrahedra)
    print(f"written: {arguments.out}")
    sys.exit(0 if good else 1)


if __name__ == "__main__":
    main()
