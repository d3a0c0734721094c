# SPDX-License-Identifier: LGPL-2.1-or-later
"""Scenes built in Python: checked as XML is, with the line of Python in what is told."""
import inspect
import pathlib

import numpy
import pytest
import stroma
from conftest import EXAMPLES, block


def line():
    return inspect.currentframe().f_back.f_lineno


def test_a_tree_equals_its_xml(folder):
    tree = block()
    text = stroma.to_xml(tree)
    (folder / "block.xml").write_text(text)
    built, read = stroma.load(tree), stroma.load("block.xml")
    built.run(3), read.run(3)
    assert built.hash == read.hash
    assert stroma.to_xml(stroma.from_xml("block.xml")) == text
    assert stroma.to_xml(stroma.from_xml_text(text)) == text


def test_values_of_every_kind_are_what_they_were(folder):
    numbers = numpy.random.default_rng(1).normal(size=(500, 3))
    root = stroma.Node("root")
    state = root.add("MechanicalObject", name="dofs", position=numbers)
    cells = numpy.arange(400).reshape(100, 4)
    mesh = root.add("MeshTopology", name="mesh", position=numbers.tolist(), tetrahedra=cells)
    assert numpy.array_equal(state.position, numbers) and numpy.array_equal(mesh.position, numbers)
    assert numpy.array_equal(mesh.tetrahedra, cells) and mesh.tetrahedra.dtype == numpy.int32
    again = stroma.from_xml_text(stroma.to_xml(root))
    assert numpy.array_equal(again["dofs"].position, numbers), "with all their digits"
    held = root.add("FixedProjectiveConstraint", indices=range(3), endTime=numpy.float32(0.5))
    assert held.indices.tolist() == [0, 1, 2] and held.endTime == 0.5
    solver = root.add("StaticSolver", linearSolver=None)
    assert "linearSolver" not in solver.attributes


def test_a_large_array_is_checked_as_text_is():
    root = stroma.Node("root")
    points = numpy.zeros((100, 3))
    points[40, 1] = numpy.nan
    bad = root.add("MechanicalObject", name="dofs", position=points)
    with pytest.raises(stroma.SceneError, match="finite"):
        bad.position
    root.remove(bad)
    mesh = root.add("MeshTopology", name="mesh", position=numpy.zeros((100, 3)), tetrahedra=numpy.full((50, 4), -1))
    with pytest.raises(stroma.SceneError, match="count from 0"):
        mesh.tetrahedra
    mesh.tetrahedra = numpy.zeros((50, 3), int)[:, :1].repeat(77)  # 3850 = no multiple of 4
    with pytest.raises(stroma.SceneError, match="does not fit tetrahedra"):
        mesh.tetrahedra


def test_names_are_checked_where_they_are_written():
    root = stroma.Node("root")
    with pytest.raises(stroma.SceneError) as caught:
        root.add("TetrahedronFEMForceFeild"); at = line()
    at = inspect.currentframe().f_lineno - 1
    assert caught.value.nearest == "TetrahedronFEMForceField"
    assert caught.value.line == at and caught.value.file == __file__
    with pytest.raises(stroma.SceneError) as caught:
        root.add("TetrahedronFEMForceField", name="fem", youngModulos=3)
    assert caught.value.nearest == "youngModulus" and f":{inspect.currentframe().f_lineno - 1}:" in str(caught.value)
    assert not root.components, "what was refused is not in it"
    with pytest.raises(stroma.SceneError, match="did you mean '?gravity"):
        root.gravty = (0, 0, 0)
    with pytest.raises(AttributeError, match="did you mean '?TetrahedronFEMForceField"):
        stroma.TetrahedronFEMForceFeld
    fem = root.add(stroma.TetrahedronFEMForceField(name="fem", youngModulus=3e3))
    with pytest.raises(stroma.SceneError, match="did you mean '?poissonRatio"):
        fem.poissonRation = 0.4


def test_all_problems_are_told_at_once_with_lines_of_python():
    root = stroma.Node("root", strict=False)
    root.add("EulerImplicitSolvr")
    first = inspect.currentframe().f_lineno - 1
    root.add("MechanicalObject", positoin=[0, 0, 0])
    root.add("UniformMass", totalMass="much")
    with pytest.raises(stroma.SceneError) as caught:
        stroma.load(root)
    problems = [problem for problem in caught.value.problems if problem.severity == "error"]
    assert [problem.line for problem in problems] == [first, first + 2, first + 3]
    assert [problem.suggestion for problem in problems][:2] == ["EulerImplicitSolver", "position"]
    assert all(problem.file == __file__ for problem in problems)


def test_data_before_init():
    """A loader has read, a region has found its nodes, while the scene is still being built."""
    root = stroma.Node("root")
    loader = root.add("MeshGmshLoader", name="loader", filename=next((EXAMPLES.parent / "meshes").glob("*.msh")))
    assert loader.position.shape[1] == 3 and len(loader.tetrahedra) > 0
    assert pathlib.Path(loader.get("filename", found=True)).is_absolute()
    body = root.add_child("body")
    state = body.add("MechanicalObject", name="dofs", position="@../loader.position")
    low = loader.position.min(axis=0)
    region = body.add("BoxROI", name="low", position="@../loader.position", box=[*(low - 1), *(low + (1e9, 1e-3, 1e9))])
    found = region.indices
    assert sorted(found) == sorted(numpy.flatnonzero(loader.position[:, 1] <= low[1] + 1e-3))
    assert numpy.array_equal(state.position, loader.position), "what a link gives"
    preview = root._preview
    body.add("UniformMass", totalMass=1)
    assert len(region.indices) == len(found) and root._preview is preview, "more components make nothing anew"
    late = root.add_child("late")
    dofs = late.add("MechanicalObject", name="dofs")
    assert len(dofs.position) == 1
    late.add("MeshTopology", position=[[0, 0, 0], [1, 0, 0]])
    assert len(dofs.position) == 2, "what is looked up counts when it comes later"
    root.remove(late)
    region.set("allowEmpty", True)
    region.box = [*(low - 2), *(low - 1)]
    assert len(region.indices) == 0
    region.box = "1 2 3"
    with pytest.raises(stroma.SceneError, match="box"):
        region.indices
    region.get("box", init=False)


def test_links_are_components():
    root = block()
    body = root["body"]
    body.remove(body["held"])
    body.add("FixedProjectiveConstraint", name="held", indices=body["top"].link("indices"), mstate=body["dofs"])
    other = stroma.load(block())
    linked = stroma.load(root)
    linked.run(2), other.run(2)
    assert linked.hash == other.hash
    assert linked["/body/held"].mstate == "/body/dofs"


def test_the_tree_is_a_tree():
    root = block()
    body = root["body"]
    assert root["body/fem"] is body["fem"] and body["../solver"] is root["solver"] and root["/body/fem"] is body["fem"]
    assert body["fem"].path == "/body/fem" and body.path == "/body" and root.path == "/"
    assert root.get("nothing") is None
    with pytest.raises(stroma.SceneError, match="did you mean '?/body/fem"):
        root["/body/fme"]
    unnamed = [stroma.Node("r").add("UniformMass") for _ in range(1)][0]
    assert unnamed.name == "UniformMass"
    node = stroma.Node("r")
    assert [node.add("BoxROI").name for _ in range(3)] == ["BoxROI", "BoxROI2", "BoxROI3"]
    moved = node.components[2]
    other = node.add_child("other")
    other.add(moved)
    assert moved.path == "/other/BoxROI" and len(node.components) == 2
    node.insert(0, "BoxROI", name="first")
    assert node.components[0].name == "first"
    with pytest.raises(stroma.SceneError, match="does not hold"):
        node.remove(moved)


def test_types_tell_their_attributes():
    info = stroma.type_info("TetrahedronFEMForceField")
    young = info.find("youngModulus")
    assert young.unit == "Pa" and young.kind == "array" and young.change != "restart"
    assert info.find("rayleighStiffness").kind == "real" and info.find("topology").kind == "link"
    assert info.find("method").words and info.find("method").kind == "choice"
    assert stroma.type_info("NoSuchThing") is None and not stroma.is_known("NoSuchThing")
    assert "youngModulus" in stroma.TetrahedronFEMForceField.__doc__ and "Pa" in stroma.TetrahedronFEMForceField.__doc__
    assert len(stroma.types()) > 100 and "TetrahedronFEMForceField" in dir(stroma)
    assert stroma.type_info("FixedConstraint").type == stroma.present_type("FixedConstraint") == "FixedProjectiveConstraint"
    assert "youngModulus" in dir(stroma.TetrahedronFEMForceField())
    for type in stroma.types():
        described = stroma.type_info(type)
        assert described.help and described.role, type


def test_sofas_dialect(folder):
    (folder / "fall.scn").write_text(
        '<Node name="root" dt="0.01" gravity="0 -9.81 0"><DefaultAnimationLoop/><EulerImplicitSolver/><CGLinearSolver/>'
        '<MechanicalObject position="0 1 0"/><UniformMass totalMass="1"/></Node>')
    tree = stroma.from_xml("fall.scn")
    tree.set("dialect", "sofa")
    by_file, by_tree = stroma.load("fall.scn"), stroma.load(tree)
    by_file.run(5), by_tree.run(5)
    assert by_file.hash == by_tree.hash


def test_a_solver_is_written_wherever_it_is_written():
    """Where a program adds it on the line of the integrator it is not taken for one that the scene leaves out."""
    def hash_of(*solvers):
        root = stroma.Node("root", dt=0.02, gravity=(0, -9.81, 0))
        for type, words in (("EulerImplicitSolver", {"newtonIterations": 30}), *solvers, ("MechanicalObject", {"name": "dofs"}),
                            ("UniformMass", {"totalMass": 4}), ("FixedProjectiveConstraint", {"indices": list(range(0, 81, 9))})):
            root.add(type, **words)
        root.add("RegularGridTopology", n=(9, 3, 3), min=(0, 0, 0), max=(0.4, 0.1, 0.1))
        root.add("HexahedronFEMForceField", youngModulus=30000, poissonRatio=0.4, method="svd")
        simulation = stroma.load(root)
        simulation.run(3)
        return simulation.hash

    tight = hash_of(("PCGLinearSolver", {"name": "solver"}))
    assert hash_of(("PCGLinearSolver", {})) == tight != hash_of()
