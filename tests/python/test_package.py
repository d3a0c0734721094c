# SPDX-License-Identifier: LGPL-2.1-or-later
"""The package as editors and programs see it."""
import ast
import inspect
import pathlib
import subprocess
import sys

import pytest
import stroma
from conftest import PATIENCE

FOLDER = pathlib.Path(stroma.__file__).parent


def test_stubs_have_every_type():
    stub = FOLDER / "__init__.pyi"
    if not stub.exists():
        pytest.skip("the stubs are made when everything is built")
    tree = ast.parse(stub.read_text(encoding="utf-8"))
    classes = {node.name: node for node in tree.body if isinstance(node, ast.ClassDef)}
    assert set(stroma.types()) <= set(classes)
    assert "youngModulus" in ast.unparse(classes["TetrahedronFEMForceField"]) and ast.get_docstring(classes["BoxROI"])
    exported = {alias.asname for node in tree.body if isinstance(node, ast.ImportFrom) for alias in node.names if alias.asname}
    assert exported <= set(dir(stroma)) and {"load", "Node", "Simulation", "ForceField", "sweep"} <= exported


def test_stubs_take_what_programs_give():
    """Numbers where one or many values are allowed, and the reports of runs as types with all that they have."""
    stub = FOLDER / "__init__.pyi"
    if not stub.exists():
        pytest.skip("the stubs are made when everything is built")
    tree = ast.parse(stub.read_text(encoding="utf-8"))
    aliases = {node.targets[0].id: ast.unparse(node.value) for node in tree.body if isinstance(node, ast.Assign)}
    assert "float" in aliases["Array"] and "ndarray[Any, Any]" in aliases["Array"]
    extension = ast.parse((FOLDER / "_stroma.pyi").read_text(encoding="utf-8"))
    for made in (stroma.RunReport, stroma.StepReport):
        described = next(node for node in extension.body if isinstance(node, ast.ClassDef) and node.name == made.__name__)
        names = {node.target.id for node in described.body if isinstance(node, ast.AnnAssign)}
        assert names == {name for name, value in vars(made).items() if isinstance(value, property)}, made.__name__


def test_arguments_of_types_are_completed():
    """What editors and notebooks ask for: every attribute that a scene may write, with its default."""
    arguments = inspect.signature(stroma.TetrahedronFEMForceField).parameters
    assert list(arguments)[:2] == ["name", "where"] and arguments["poissonRatio"].default == 0.45 and arguments["method"].default == "large"
    written = {one.name for one in stroma.type_info("TetrahedronFEMForceField").attributes if not one.output}
    assert written <= set(arguments) and all(arguments[name].kind is inspect.Parameter.KEYWORD_ONLY for name in written - {"name"})
    for name in stroma.types():
        inspect.signature(getattr(stroma, name))

    class Own(stroma.UniformMass):
        def __init__(self, kilograms):
            super().__init__(totalMass=kilograms)

    assert list(inspect.signature(Own).parameters) == ["kilograms"] and Own(2).totalMass == 2
    assert "TetrahedronFEMForceField" in dir(stroma) and "youngModulus" in dir(stroma.TetrahedronFEMForceField())


def test_what_is_public_is_documented():
    for name in ("load", "Node", "Component", "Simulation", "State", "ForceField", "sweep", "from_xml", "to_xml", "type_info"):
        thing = getattr(stroma, name)
        assert thing.__doc__, name
        for member, value in vars(thing).items() if isinstance(thing, type) else ():
            if callable(value) and not member.startswith("_"):
                assert value.__doc__ or member in ("get", "set", "insert", "node", "info", "component", "mesh"), f"{name}.{member}"


def test_reports_and_their_numbers_are_documented():
    for made in (stroma.RunReport, stroma.StepReport):
        for name, value in vars(made).items():
            assert not isinstance(value, property) or value.__doc__, f"{made.__name__}.{name}"


def test_an_interpreter_ends_well_whatever_it_holds():
    """Views, simulations and force fields in globals at the end: no crash, no message."""
    program = """
import numpy, stroma
class Pull(stroma.ForceField):
    def force(self, x, v, t):
        return 0 * x
root = stroma.Node("root", dt=0.01)
root.add("EulerExplicitSolver")
root.add("MechanicalObject", position=[[0, 0, 0]])
root.add("UniformMass", totalMass=1)
root.add(Pull())
simulation = stroma.load(root)
simulation.on_step_end(lambda sim: None)
simulation.run(3)
x, again = simulation.state().x, simulation.copy()
preview = root.preview()
"""
    ended = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=PATIENCE)
    assert (ended.returncode, ended.stdout, ended.stderr) == (0, "", ""), ended.stderr
