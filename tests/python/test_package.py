# SPDX-License-Identifier: LGPL-2.1-or-later
"""The package as editors and programs see it."""
import ast
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


def test_what_is_public_is_documented():
    for name in ("load", "Node", "Component", "Simulation", "State", "ForceField", "sweep", "from_xml", "to_xml", "type_info"):
        thing = getattr(stroma, name)
        assert thing.__doc__, name
        for member, value in vars(thing).items() if isinstance(thing, type) else ():
            if callable(value) and not member.startswith("_"):
                assert value.__doc__ or member in ("get", "set", "insert", "node", "info", "component", "mesh"), f"{name}.{member}"


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
