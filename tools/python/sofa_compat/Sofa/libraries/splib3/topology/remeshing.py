# SPDX-License-Identifier: LGPL-2.1-or-later
"""Points in order along an axis, in rings of a tube, and around these; cells that follow their numbers; lids of holes."""
import numpy as np


def default_indices(length):
    return list(range(length))


def _numbers(points, indices):
    """Those given, as many as points, or 0, 1, ..."""
    numbers = default_indices(len(points)) if indices is None else list(indices)
    if len(numbers) != len(points):
        raise RuntimeError(f"there are {len(points)} points and {len(numbers)} indices: expected as many of each")
    return numbers


def index_from_axis(points, axis, old_indices=None):
    """(points by their coordinate `axis`, the indices that they had)."""
    numbers = _numbers(points, old_indices)
    order = sorted(range(len(points)), key=lambda at: points[at][axis])
    return [points[at] for at in order], [numbers[at] for at in order]


def reindex_mesh(ind_tab, mesh):
    """Cells of numbers before as cells of places in ind_tab."""
    place = {number: at for at, number in reversed(list(enumerate(ind_tab)))}
    lost = sorted({number for cell in mesh for number in cell} - set(place))
    if lost:
        raise IndexError(f"the cells name points that the list of indices does not have: {lost[:5]}")
    return [[place[number] for number in cell] for cell in mesh]


def conv_tab_from_ind_tab(ind_tab):
    return [[at, number] for at, number in enumerate(ind_tab)]


def new_idx_from_conv_tab(mesh, conv_tab):
    """Cells by the second number of each pair in place of the first."""
    table = {first: second for first, second in reversed(list(conv_tab))}
    return [[table[number] for number in cell] for cell in mesh]


def quad_2_triangles(quads):
    return [triangle for a, b, c, d in quads for triangle in ([a, b, c], [c, d, a])]


def circle_detection_regular(points, pt_per_slice, indices=None):
    """Rings of so many points each, in the order of the points: (rings of points, rings of indices)."""
    numbers, rings = _numbers(points, indices), len(points) // pt_per_slice
    if rings * pt_per_slice != len(points):
        print(f"warning: {len(points)} points are no rings of {pt_per_slice}")
    cut = [slice(ring * pt_per_slice, (ring + 1) * pt_per_slice) for ring in range(rings)]
    return [points[part] for part in cut], [numbers[part] for part in cut]


def circle_detection_axis(points, axis, tolerance=0, indices=None):
    """Rings of points whose coordinates along the axis follow each other by no more than the tolerance."""
    ordered, numbers = index_from_axis(points, axis, indices)
    rings, ring_numbers = [], []
    for at, (point, number) in enumerate(zip(ordered, numbers)):
        if at == 0 or abs(point[axis] - ordered[at - 1][axis]) > tolerance:
            rings.append([]), ring_numbers.append([])
        rings[-1].append(point), ring_numbers[-1].append(number)
    return rings, ring_numbers


def remesh_from_axis(points, mesh, axis, old_indices=None):
    """(points in order along the axis, the indices that they had, the cells of their new ones)."""
    ordered, numbers = index_from_axis(points, axis, old_indices)
    return ordered, numbers, reindex_mesh(numbers, mesh)


def ordering_circle(circle, ind_tab, x_ref=1, y_ref=2):
    """Around the centre: those beyond it along x_ref by y_ref upwards, then the others downwards."""
    middle = np.mean([point[x_ref] for point in circle])
    pairs = list(zip(circle, ind_tab))
    beyond = sorted((pair for pair in pairs if pair[0][x_ref] > middle), key=lambda pair: pair[0][y_ref])
    before = sorted((pair for pair in pairs if not pair[0][x_ref] > middle), key=lambda pair: pair[0][y_ref], reverse=True)
    return [point for point, _ in beyond + before], [number for _, number in beyond + before]


def ordering_cylinder(circle_tab, ind_tab, axis=0):
    """Each ring of a tube along `axis`."""
    x_ref, y_ref = [other for other in range(3) if other != axis]
    both = [ordering_circle(circle, numbers, x_ref, y_ref) for circle, numbers in zip(circle_tab, ind_tab)]
    return [points for points, _ in both], [numbers for _, numbers in both]


def invers_normal(mesh):
    return [list(cell)[::-1] for cell in mesh]


def shift_tab(tab):
    return tab[1:] + [tab[0]]


def close_surface(ind_tab):
    """Triangles over a hole with this rim: each cuts off every second point, and so on with the points that are left."""
    ring, triangles = list(ind_tab), []
    for at in range(0, len(ring) - 1, 2):
        triangles.append([ring[at], ring[at + 1], ring[(at + 2) % len(ring)]])
    left = ring[0::2]
    return triangles + (close_surface(left) if len(left) >= 3 else [])
