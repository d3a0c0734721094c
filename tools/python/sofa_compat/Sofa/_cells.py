# SPDX-License-Identifier: LGPL-2.1-or-later
"""Edges and sides of cells, which SOFA's topologies make when they are asked for them."""

#: which nodes of a cell make its edges, and its sides
TETRAHEDRON_EDGES = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)]
_EDGES = {"tetrahedra": TETRAHEDRON_EDGES, "triangles": [(1, 2), (2, 0), (0, 1)], "quads": [(0, 1), (1, 2), (2, 3), (3, 0)],
          "hexahedra": [(0, 1), (0, 3), (0, 4), (1, 2), (1, 5), (2, 3), (2, 6), (3, 7), (4, 5), (4, 7), (5, 6), (6, 7)]}
_SIDES = {"tetrahedra": [(1, 2, 3), (0, 3, 2), (1, 3, 0), (0, 2, 1)],
          "hexahedra": [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]}


def cells(topology, name):
    data = topology.findData(name)
    return [] if data is None else [[int(node) for node in cell] for cell in data.value]


def _parts(topology, table, *dimensions):
    """Each once, in the order of the cells; of those of the first dimension of which there are any."""
    for kinds in dimensions:
        found = {}
        for kind in kinds:
            for cell in cells(topology, kind):
                for part in table[kind]:
                    nodes = [cell[k] for k in part]
                    found.setdefault(frozenset(nodes), nodes)
        if found:
            return list(found.values())
    return []


def edges(topology):
    """Those that are given, or those of the cells, each with the lower node first."""
    return cells(topology, "edges") or [sorted(pair) for pair in _parts(topology, _EDGES, ("tetrahedra", "hexahedra"), ("triangles", "quads"))]


def triangles(topology):
    return cells(topology, "triangles") or _parts(topology, _SIDES, ["tetrahedra"])


def quads(topology):
    return cells(topology, "quads") or _parts(topology, _SIDES, ["hexahedra"])
