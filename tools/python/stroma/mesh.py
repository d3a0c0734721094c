# SPDX-License-Identifier: LGPL-2.1-or-later
"""Meshes as arrays, and for other programs."""
import importlib
from typing import Any, Dict, Iterable, List, Optional, Tuple, Union

import numpy

from .errors import StromaError, refusal
from .types import nearest

#: Names of cells as meshio has them, and their numbers in VTK.
VTK_TYPES = {"line": 3, "triangle": 5, "quad": 9, "triangle6": 22, "tetra": 10, "hexahedron": 12, "wedge": 13, "pyramid": 14,
             "tetra10": 24}
_VOLUMES = ("tetra", "hexahedron", "wedge", "pyramid", "tetra10")
#: What meshio calls the cells that fields are on.
_KINDS = {"tetrahedron": "tetra", "hexahedron": "hexahedron", "prism": "wedge", "pyramid": "pyramid", "quadraticTetrahedron": "tetra10"}


def _package(name: str) -> Any:
    try:
        return importlib.import_module(name)
    except ImportError:
        raise StromaError(f"the Python package {name} is not installed: the arrays are mesh.points, mesh.blocks(), mesh.point_data() "
                          "and mesh.cell_data()") from None


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
        return {kind: cells for kind, cells in self.cells.items() if kind in _VOLUMES}

    def blocks(self, surface: bool = False) -> List[Tuple[str, numpy.ndarray]]:
        """[(kind, nodes of each cell)]: the cells of the volume, of a mesh without a volume all; or its boundary."""
        return list((self.surface if surface else self.volume_cells() or self.cells).items())

    # ---- data ----
    def field_names(self) -> List[str]:
        """Fields of cells that its force fields have, as "vonMises"."""
        return list(self._fields())

    def _fields(self) -> Dict[str, Any]:
        folder = self.state.path.rpartition("/")[0]
        found: Dict[str, Any] = {}
        for component in self.state.simulation.components():
            if component.role == "force field" and component.path.rpartition("/")[0] == folder:
                for name in component.fields:
                    found.setdefault(name, component)
        return found

    def point_data(self) -> Dict[str, numpy.ndarray]:
        """displacement [m] since the start, and velocity [m/s], (n, 3) each."""
        points = self.points
        return {"displacement": points - self.state.start[:, :3], "velocity": numpy.array(self.state.v[:, :3])}

    def cell_data(self, fields: Union[str, Iterable[str]] = "all") -> Dict[str, numpy.ndarray]:
        """Numbers of the volume's cells in the order of blocks(), (n,) or of tensors (n, 6) in the order xx yy zz xy yz zx;
        NaN where the force field of the name has no such cells. `fields`: their names, or "all"."""
        known = self._fields()
        wanted = list(known) if fields == "all" else [fields] if isinstance(fields, str) else list(fields)
        data = {}
        for name in wanted:
            if name not in known:
                raise refusal(f"no force field beside {self.state.path} has a field '{name}' of cells",
                              ", ".join(known) or "none has one", nearest(name, known))
            values = self._of_cells(known[name], name)
            if values is not None:
                data[name] = values
            elif fields != "all":
                raise refusal(f"the cells of '{name}' are not those of the mesh {self.topology}")
        return data

    def _of_cells(self, component: Any, name: str) -> Optional[numpy.ndarray]:
        """The field with its cells in their place among those of blocks(), None where the mesh has other cells."""
        values = component.field(name)
        kind = _KINDS.get(self.state.simulation._engine.cell_field_kind(component.path, name))
        volumes = self.volume_cells()
        if kind not in volumes or len(volumes[kind]) != len(values):
            return None
        return numpy.concatenate([values if of == kind else numpy.full((len(cells),) + values.shape[1:], numpy.nan)
                                  for of, cells in volumes.items()])

    # ---- for other programs ----
    def to_meshio(self, fields: Union[str, Iterable[str]] = "all") -> Any:
        """A meshio.Mesh of blocks(), with displacement, velocity and `fields` of cells."""
        meshio = _package("meshio")
        blocks, data = self.blocks(), self.cell_data(fields)
        ends = numpy.cumsum([len(nodes) for _, nodes in blocks])[:-1]
        return meshio.Mesh(self.points, blocks, point_data=self.point_data(),
                           cell_data={name: numpy.split(values, ends) for name, values in data.items()})

    def to_pyvista(self, fields: Union[str, Iterable[str]] = "all") -> Any:
        """The same as a pyvista.UnstructuredGrid."""
        pyvista = _package("pyvista")
        grid = pyvista.UnstructuredGrid(*self.vtk_cells(), self.points)
        for name, values in self.point_data().items():
            grid.point_data[name] = values
        for name, values in self.cell_data(fields).items():
            grid.cell_data[name] = values
        return grid

    def to_vtk(self, fields: Union[str, Iterable[str]] = "all") -> Any:
        """The same as a vtkUnstructuredGrid of VTK's own Python package."""
        vtk, support = _package("vtk"), _package("vtk.util.numpy_support")
        cells, types = self.vtk_cells()
        points, polygons, grid = vtk.vtkPoints(), vtk.vtkCellArray(), vtk.vtkUnstructuredGrid()
        points.SetData(support.numpy_to_vtk(self.points, deep=True))
        polygons.SetCells(len(types), support.numpy_to_vtkIdTypeArray(cells.astype(numpy.int64), deep=True))
        grid.SetPoints(points)
        grid.SetCells(support.numpy_to_vtk(types, deep=True, array_type=vtk.VTK_UNSIGNED_CHAR), polygons)
        for target, data in ((grid.GetPointData(), self.point_data()), (grid.GetCellData(), self.cell_data(fields))):
            for name, values in data.items():
                array = support.numpy_to_vtk(numpy.ascontiguousarray(values), deep=True)
                array.SetName(name)
                target.AddArray(array)
        return grid

    def vtk_cells(self) -> tuple:
        """(cells, types) as vtkUnstructuredGrid takes them: each cell as its number of nodes, then the nodes."""
        blocks = self.blocks()
        flat = [numpy.hstack([numpy.full((len(nodes), 1), nodes.shape[1]), nodes]).ravel() for _, nodes in blocks]
        types = [numpy.full(len(nodes), VTK_TYPES[kind], numpy.uint8) for kind, nodes in blocks]
        empty = numpy.zeros(0, int)
        return (numpy.concatenate(flat) if flat else empty), (numpy.concatenate(types) if types else empty.astype(numpy.uint8))

    def __repr__(self) -> str:
        cells = ", ".join(f"{len(cells)} {kind}" for kind, cells in self.cells.items())
        return f"<mesh of {self.state.path}: {self.state.nodes} points, {cells}>"
