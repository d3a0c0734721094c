# SPDX-License-Identifier: LGPL-2.1-or-later
"""Cells that go and come by the modifier of a topology: the lists of its container are set, and a running scene is made anew. Numbers
are SOFA's: those that go are sorted, the largest first, and the last of the list takes the number that is free."""
from functools import partialmethod

import numpy as np

from . import _cells
from ._objects import Object

#: the cells of a container, by the beginning of its type
_MAIN = {"Edge": "edges", "Triangle": "triangles", "Quad": "quads", "Tetrahedron": "tetrahedra", "Hexahedron": "hexahedra"}


class Modifier(Object):
    def _s_container(self):
        found = [each for each in self._s_node()._s_objects if each._s_type.endswith("SetTopologyContainer")]
        if not found:
            raise RuntimeError(f"{self._s_place()}: there is no container beside it whose cells it could change")
        return found[-1]

    def _s_set(self, container, name, rows):
        container.findData(name).value = np.reshape(rows, (-1, _cells.NODES[name])).astype(np.int32)

    def _s_remove(self, name, numbers, *_):
        container = self._s_container()
        rows = _cells.cells(container, name).tolist()
        gone = sorted({int(each) for each in np.ravel(numbers)}, reverse=True)
        if gone and not 0 <= gone[-1] <= gone[0] < len(rows):
            raise IndexError(f"{self._s_place()}: there are {len(rows)} {name}, and {gone[0] if gone[0] >= len(rows) else gone[-1]} is none")
        removed = np.array([rows[each] for each in gone], np.int32).reshape(-1, _cells.NODES[name])
        for each in gone:
            rows[each] = rows[-1]
            rows.pop()
        kept = np.array(rows, np.int32).reshape(-1, _cells.NODES[name])
        lost = sorted(set(removed.ravel().tolist()) - set(kept.ravel().tolist()))
        if lost:
            raise ValueError(f"{self._s_place()}: point {lost[0]} would lose its last cell, and points do not go by a scene in Python: a "
                             "TopologicalChangeProcessor or a CarvingRegion takes them away with their cells")
        for part in _cells.parts_of(name):
            self._s_drop_parts(container, part, _cells.keys_of(name, removed, part) - _cells.keys_of(name, kept, part))
        self._s_set(container, name, rows)

    def _s_drop_parts(self, container, name, gone):
        """Sides and edges that the container has of its own, and that no cell has any more."""
        data = container.findData(name)
        given = np.zeros(0) if data is None else np.asarray(container._s_given(data))
        rows = [row for row in given.tolist() if tuple(sorted(row)) not in gone]
        if len(rows) < len(given):
            self._s_set(container, name, rows)

    def _s_add(self, name, cells, *_):
        container = self._s_container()
        new = np.reshape(cells, (-1, _cells.NODES[name])).astype(np.int32)
        points = container.getNbPoints()
        if new.size and not 0 <= new.min() <= new.max() < points:
            raise IndexError(f"{self._s_place()}: a cell names node {new.max() if new.max() >= points else new.min()} of {points}")
        self._s_set(container, name, np.concatenate([_cells.cells(container, name), new]))

    def removeItems(self, numbers, *_):
        """Cells of the container's own kind."""
        kind = self._s_container()._s_type
        name = next((name for word, name in _MAIN.items() if kind.startswith(word)), None)
        if name is None:
            raise AttributeError(self._s_no_data("removePoints"))
        self._s_remove(name, numbers)

    def _s_no_data(self, name):
        if name in ("addPoints", "removePoints"):
            return (f"{self._s_place()}: points do not come or go by a scene in Python: a TopologicalChangeProcessor adds them and takes "
                    "them away")
        return super()._s_no_data(name)


for _each in _cells.NODES:
    setattr(Modifier, f"remove{_each.capitalize()}", partialmethod(Modifier._s_remove, _each))
    setattr(Modifier, f"add{_each.capitalize()}", partialmethod(Modifier._s_add, _each))
Modifier.removeTetras, Modifier.removeHexas = Modifier.removeTetrahedra, Modifier.removeHexahedra
