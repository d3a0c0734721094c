# SPDX-License-Identifier: LGPL-2.1-or-later
"""Meshes as arrays, and for other programs."""
from typing import Any, Dict, Iterable

import numpy

#: Names of cells as meshio has them, and their numbers in VTK.
VTK_TYPES = {"line": 3, "triangle": 5, "quad": 9, "triangle6": 22, "tetra": 10, "hexahedron": 12, "tetra10": 24}


class Mesh:
    """Points and cells of a state: points are its present positions, cells[kind] are the nodes of each, as meshio has them."""

    def __init__(self, state: Any, topology: str, cells: Dict[str, numpy.ndarray], surface: Dict[str, numpy.ndarray]):
        self.state, self.topology = state, topology
        self.cells, self.surface = cells, surface

    @property
    def points(self) -> numpy.ndarray:
        """[m], (n, 3), contiguous."""
        return numpy.ascontiguousarray(self.state.x[:, :3])

    def volume_cells(self) -> Dict[str, numpy.ndarray]:
        return {kind: cells for kind, cells in self.cells.items() if kind in ("tetra", "hexahedron", "tetra10")}

    def _fields(self, fields: Iterable[str]) -> Dict[str, numpy.ndarray]:
        count = sum(len(cells) for cells in self.volume_cells().values())
        found = {}
        for component in self.state.simulation.components():
            for name in component.fields if component.role == "force field" else ():
                if name in fields and component.path.rpartition("/")[0] == self.state.path.rpartition("/")[0]:
                    values = component.field(name)
                    if len(values) == count:
                        found[name] = values
        return found

    def to_meshio(self, fields: Iterable[str] = ()) -> Any:
        """A meshio.Mesh of the volume cells, else of all; `fields` of cells by name, as ("vonMises",)."""
        import meshio
        cells = self.volume_cells() or self.cells
        at, data = 0, {name: [] for name in self._fields(fields)}
        for kind in cells:
            for name, values in self._fields(fields).items():
                data[name].append(values[at:at + len(cells[kind])])
            at += len(cells[kind])
        return meshio.Mesh(self.points, list(cells.items()), point_data={"velocity": numpy.array(self.state.v[:, :3])}, cell_data=data)

    def to_pyvista(self, fields: Iterable[str] = ()) -> Any:
        """A pyvista.UnstructuredGrid."""
        import pyvista
        connectivity, types = self.vtk_cells()
        grid = pyvista.UnstructuredGrid(connectivity, types, self.points)
        for name, values in self._fields(fields).items():
            grid.cell_data[name] = values
        return grid

    def vtk_cells(self) -> tuple:
        """(cells, types) as vtkUnstructuredGrid takes them: each cell as its number of nodes, then the nodes."""
        cells = self.volume_cells() or self.cells
        flat = [numpy.hstack([numpy.full((len(nodes), 1), nodes.shape[1]), nodes]).ravel() for nodes in cells.values()]
        types = [numpy.full(len(nodes), VTK_TYPES[kind], numpy.uint8) for kind, nodes in cells.items()]
        empty = numpy.zeros(0, int)
        return (numpy.concatenate(flat) if flat else empty), (numpy.concatenate(types) if types else empty.astype(numpy.uint8))

    def __repr__(self) -> str:
        cells = ", ".join(f"{len(cells)} {kind}" for kind, cells in self.cells.items())
        return f"<mesh of {self.state.path}: {self.state.nodes} points, {cells}>"
