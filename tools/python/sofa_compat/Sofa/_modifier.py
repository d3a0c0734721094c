# SPDX-License-Identifier: LGPL-2.1-or-later
"""Cells that go and come by the modifier of a topology: the lists of its container are set, and a running scene is made anew. Where
points go or come the running engine changes its mesh at once, as CarvingRegion does; the tree of the scene keeps its lists, so that it
cannot be made anew after that. Numbers are SOFA's: those that go are sorted, the largest first, and the last of the list takes the
number that is free."""
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

    def _s_running(self, container):
        """The engine whose mesh changes at once, or None: before the scene runs the lists of the container are set."""
        engine = self._s_engine()
        return engine if engine is not None and engine.can_change_mesh(container) else None

    def _s_remove(self, name, numbers, *_):
        container = self._s_container()
        engine = self._s_running(container)
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
        if engine is not None and gone and (lost or not engine.takes_lists()):
            return engine.change_mesh(self, container, name, removed=gone)
        if lost:
            raise ValueError(f"{self._s_place()}: point {lost[0]} would lose its last cell, and points go while the scene runs alone")
        for part in _cells.parts_of(name):
            self._s_drop_parts(container, part, _cells.keys_of(name, removed, part) - _cells.keys_of(name, kept, part))
        self._s_set(container, name, rows)
        return None

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
        engine = self._s_running(container)
        if engine is not None and len(new) and not engine.takes_lists():
            return engine.change_mesh(self, container, name, added=new)
        self._s_set(container, name, np.concatenate([_cells.cells(container, name), new]))
        return None

    def _s_points(self):
        """(the engine, the container) of points that come or go."""
        container = self._s_container()
        engine = self._s_running(container)
        if engine is None:
            raise RuntimeError(f"{self._s_place()}: points come and go while the scene runs: before, write `position` of the container")
        return engine, container

    def addPoints(self, number, *_):
        """At the origin, as SOFA puts them there; whoever adds them writes their positions then."""
        engine, container = self._s_points()
        if not isinstance(number, (int, np.integer)) or number < 0:
            raise TypeError(f"{self._s_place()}: addPoints() takes how many points come, not {number!r}")
        if number:
            engine.change_mesh(self, container, "points", points=number)

    def removePoints(self, numbers, *_):
        """Points without cells."""
        engine, container = self._s_points()
        if len(np.ravel(numbers)):
            engine.change_mesh(self, container, "points", removed=numbers)

    def removeItems(self, numbers, *_):
        """Cells of the container's own kind."""
        kind = self._s_container()._s_type
        name = next((name for word, name in _MAIN.items() if kind.startswith(word)), None)
        if name is None:
            return self.removePoints(numbers)
        return self._s_remove(name, numbers)


for _each in _cells.NODES:
    setattr(Modifier, f"remove{_each.capitalize()}", partialmethod(Modifier._s_remove, _each))
    setattr(Modifier, f"add{_each.capitalize()}", partialmethod(Modifier._s_add, _each))
Modifier.removeTetras, Modifier.removeHexas = Modifier.removeTetrahedra, Modifier.removeHexahedra
