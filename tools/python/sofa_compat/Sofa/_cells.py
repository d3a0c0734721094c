# SPDX-License-Identifier: LGPL-2.1-or-later
"""Edges and sides of cells, which SOFA's topologies list though a scene does not write them."""
import numpy as np

#: which nodes of a cell make its edges, and its sides
TETRAHEDRON_EDGES = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)]
_EDGES = {"tetrahedra": TETRAHEDRON_EDGES, "triangles": [(1, 2), (2, 0), (0, 1)], "quads": [(0, 1), (1, 2), (2, 3), (3, 0)],
          "hexahedra": [(0, 1), (0, 3), (0, 4), (1, 2), (1, 5), (2, 3), (2, 6), (3, 7), (4, 5), (4, 7), (5, 6), (6, 7)]}
_SIDES = {"tetrahedra": [(1, 2, 3), (0, 3, 2), (1, 3, 0), (0, 2, 1)],
          "hexahedra": [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]}
#: lists that are made where they are empty: of which cells, the next of them where there are none of the first
_FROM = {"edges": (_EDGES, ("tetrahedra", "hexahedra"), ("triangles", "quads")), "triangles": (_SIDES, ("tetrahedra",)),
         "quads": (_SIDES, ("hexahedra",))}
NODES = {"edges": 2, "triangles": 3, "quads": 4, "tetrahedra": 4, "hexahedra": 8}


def parts_of(name):
    """The lists of what a kind of cells has for sides and edges."""
    return [part for part in ("triangles", "quads", "edges") if any(name in kinds for kinds in _FROM[part][1:])]


def keys_of(name, rows, part):
    """The sides or edges of cells, each as its nodes in ascending order."""
    table = _FROM[part][0][name]
    return {tuple(sorted(row[k] for k in nodes)) for row in rows.tolist() for nodes in table}


def are_made(name):
    return name in _FROM


def cells(topology, name):
    """One row of nodes for each."""
    data = topology.findData(name)
    return np.reshape([] if data is None else np.asarray(data.value), (-1, NODES[name])).astype(np.int32)


def made(topology, name):
    """Each once, in the order of the cells. Edges and triangles begin with their lowest node."""
    table, *dimensions = _FROM[name]
    for kinds in dimensions:
        parts = [np.stack([rows[:, part] for part in table[kind]], axis=1).reshape(-1, NODES[name])
                 for kind in kinds for rows in [cells(topology, kind)] if len(rows)]
        if parts:
            return _from_lowest(name, _each_once(np.concatenate(parts)))
    return np.zeros((0, NODES[name]), np.int32)


def _each_once(parts):
    _, first = np.unique(np.sort(parts, axis=1), axis=0, return_index=True)
    return parts[np.sort(first)]


def _from_lowest(name, parts):
    if name == "edges":
        return np.sort(parts, axis=1)
    if name == "quads":
        return parts
    turn = (np.argmin(parts, axis=1)[:, None] + np.arange(parts.shape[1])) % parts.shape[1]
    return np.take_along_axis(parts, turn, axis=1)
