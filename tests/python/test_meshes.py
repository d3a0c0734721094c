# SPDX-License-Identifier: LGPL-2.1-or-later
"""Meshes and fields as other programs take them: their arrays, and objects of packages where these are installed."""
import sys
import types

import numpy
import pytest
import stroma
from conftest import EXAMPLES, block


@pytest.fixture
def mesh(simulation):
    simulation.run(3)
    return simulation.state().mesh()


def test_arrays(mesh):
    assert [(kind, cells.shape) for kind, cells in mesh.blocks()] == [("hexahedron", (48, 8))]
    assert [(kind, cells.shape) for kind, cells in mesh.blocks(surface=True)] == [("quad", (80, 4))]
    data = mesh.point_data()
    state = mesh.state
    assert numpy.array_equal(data["displacement"], state.x - state.start) and numpy.array_equal(data["velocity"], state.v)
    assert data["displacement"].flags.owndata and numpy.abs(data["displacement"]).max() > 0
    # outward: the volume by the divergence theorem, of the shape at the start
    points = state.start
    quads = mesh.blocks(surface=True)[0][1]
    corners = points[quads]
    volume = sum(numpy.einsum("mi,mi", corners[:, 0], numpy.cross(corners[:, a], corners[:, b])) for a, b in ((1, 2), (2, 3))) / 6
    assert volume == pytest.approx(0.1 * 0.1 * 0.08, rel=1e-12)


def test_fields_of_cells():
    simulation = stroma.load(EXAMPLES / "organ.xml", observers=False)
    simulation.run(2)
    mesh = simulation.state("/organ").mesh()
    assert "vonMises" in mesh.field_names()
    data = mesh.cell_data()
    count = sum(len(cells) for _, cells in mesh.blocks())
    assert data["vonMises"].shape == (count,) and numpy.array_equal(data["vonMises"], mesh.cell_data("vonMises")["vonMises"])
    with pytest.raises(stroma.SceneError, match="did you mean '?vonMises"):
        mesh.cell_data(["vonMeses"])
    assert mesh.cell_data([]) == {}
    assert data["strain"].shape == (count, 6)


def test_fields_of_cells_of_two_kinds(tmp_path):
    """A hexahedron is pulled to a stress of 100 Pa, the stiff tetrahedron on it goes along: each has its own numbers."""
    (tmp_path / "mixed.xml").write_text("""<Node name="root" gravity="0 0 0" dt="1"><StaticSolver/><SparseLDLSolver/>
      <MeshTopology position="0 0 0  1 0 0  1 1 0  0 1 0  0 0 1  1 0 1  1 1 1  0 1 1  0.5 0.5 2"
                    hexahedra="0 1 2 3 4 5 6 7" tetrahedra="4 5 6 8"/><MechanicalObject name="state"/>
      <HexahedronFEMForceField name="hexa" method="small" youngModulus="1000" poissonRatio="0"/>
      <TetrahedronFEMForceField name="tetra" method="small" youngModulus="1e6" poissonRatio="0"/>
      <FixedProjectiveConstraint indices="0 1 2 3"/><ConstantForceField indices="4 5 6 7" totalForce="0 0 100"/></Node>""")
    simulation = stroma.load(tmp_path / "mixed.xml", observers=False)
    simulation.step()
    assert simulation["/hexa"].field("vonMises") == pytest.approx([100])
    assert simulation["/hexa"].field("stress") == pytest.approx(numpy.array([[0, 0, 100, 0, 0, 0]]), abs=1e-9)
    assert simulation["/hexa"].field("principalStress") == pytest.approx(numpy.array([[100, 0, 0]]), abs=1e-9)
    assert simulation["/hexa"].field("principalStrain") == pytest.approx(numpy.array([[0.1, 0, 0]]), abs=1e-12)
    mesh = simulation.state("/").mesh()
    stress, strain = mesh.cell_data()["vonMises"], mesh.cell_data()["strain"]
    assert [kind for kind, _ in mesh.blocks()] == ["tetra", "hexahedron"] and stress.shape == (2,) and strain.shape == (2, 6)
    assert numpy.isnan(stress[0]) and stress[1] == pytest.approx(100), "the first force field with the name is that of hexahedra"
    assert mesh.cell_data()["principalStress"].shape == (2, 3) and mesh.cell_data()["stress"].shape == (2, 6)
    assert numpy.isnan(strain[0]).all() and strain[1] == pytest.approx([0, 0, 0.1, 0, 0, 0], abs=1e-12)


@pytest.mark.parametrize("package, convert", [("meshio", "to_meshio"), ("pyvista", "to_pyvista"), ("vtk", "to_vtk")])
def test_a_package_that_is_not_there_is_told(mesh, monkeypatch, package, convert):
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(stroma.StromaError, match=f"{package} is not installed.*mesh.points"):
        getattr(mesh, convert)()


def test_what_meshio_and_pyvista_are_given(mesh, monkeypatch):
    """The arguments are those of their constructors: meshio.Mesh(points, cells, point_data, cell_data),
    pyvista.UnstructuredGrid(cells, types, points)."""
    class Mesh:
        def __init__(self, points, cells, point_data, cell_data):
            self.points, self.cells, self.point_data, self.cell_data = points, cells, point_data, cell_data

    class UnstructuredGrid:
        def __init__(self, *arguments):
            self.arguments, self.point_data, self.cell_data = arguments, {}, {}
    monkeypatch.setitem(sys.modules, "meshio", types.SimpleNamespace(Mesh=Mesh))
    monkeypatch.setitem(sys.modules, "pyvista", types.SimpleNamespace(UnstructuredGrid=UnstructuredGrid))
    written = mesh.to_meshio()
    assert written.points.flags.c_contiguous and written.cells[0][0] == "hexahedron"
    for values in written.cell_data.values():
        assert [len(each) for each in values] == [len(cells) for _, cells in written.cells]
    assert set(written.point_data) == {"displacement", "velocity"}
    cells, kinds, points = mesh.to_pyvista().arguments
    assert points.shape == (100, 3) and (kinds == 12).all() and len(cells) == 9 * len(kinds) and (cells[::9] == 8).all()


def test_a_grid_of_vtk(mesh):
    vtk = pytest.importorskip("vtk")
    grid = mesh.to_vtk()
    assert grid.GetNumberOfCells() == 48 and grid.GetNumberOfPoints() == 100
    assert grid.GetPoint(7) == pytest.approx(tuple(mesh.points[7]), abs=0)
    measured = vtk.vtkCellSizeFilter()
    measured.SetInputData(grid)
    measured.Update()
    volumes = measured.GetOutput().GetCellData().GetArray("Volume")
    total = sum(volumes.GetValue(i) for i in range(48))
    assert total == pytest.approx(0.1 * 0.1 * 0.08, rel=0.2), "of the bent shape"
    assert grid.GetPointData().GetArray("velocity").GetNumberOfTuples() == 100


def test_a_mesh_of_meshio(mesh):
    meshio = pytest.importorskip("meshio")
    assert isinstance(mesh.to_meshio(), meshio.Mesh)
