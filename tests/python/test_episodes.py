# SPDX-License-Identifier: LGPL-2.1-or-later
"""Episodes: back to the start to the bit, any number of times, without growth."""
import gc
import os
import runpy

import numpy
import pytest
import stroma
from conftest import SOURCE, block, held


def test_resets_are_to_the_bit(simulation):
    start, hashes = simulation.hash, set()
    for _ in range(5):
        simulation.run(7)
        hashes.add(simulation.hash)
        simulation.state().set(v=numpy.ones((100, 3)))
        simulation.run(2)
        simulation.reset()
        assert simulation.hash == start and simulation.time == 0
    assert len(hashes) == 1


def test_resets_do_not_grow():
    root = stroma.Node("root", dt=0.01)
    root.add("EulerImplicitSolver")
    root.add("CGLinearSolver")
    root.add("MechanicalObject", name="dofs", position=[[0, 0, 0]])
    root.add("UniformMass", totalMass=1)
    simulation = stroma.load(root)
    state = simulation.state()

    def episodes(count):
        for _ in range(count):
            simulation.reset()
            state.set(v=[[1, 0, 0]])
            simulation.step()
            state.x
    episodes(2000)
    gc.collect()
    before = held()
    episodes(20000)
    gc.collect()
    assert held() - before < 1 << 20


def test_loading_again_does_not_grow():
    def loads(count):
        for _ in range(count):
            simulation = stroma.load(block())
            simulation.step()
            simulation.state().x
    loads(10)
    gc.collect()
    before = held()
    loads(60)
    gc.collect()
    assert held() - before < 4 << 20


def test_many_simulations_in_one_process():
    simulations = [stroma.load(block()) for _ in range(60)]
    for simulation in simulations:
        simulation.run(2)
    assert len({simulation.hash for simulation in simulations}) == 1


def test_notebooks_do_what_the_scripts_do(folder, capsys):
    """Of one script, cell by cell; all of them are whole."""
    made = runpy.run_path(str(SOURCE / "tools" / "python" / "make_notebooks.py"))["notebook"]
    for script in (SOURCE / "scenes" / "python").glob("*.py"):
        notebook = made(script.read_text(encoding="utf-8"), script.stem)
        code = ["".join(cell["source"]) for cell in notebook["cells"] if cell["cell_type"] == "code"]
        assert notebook["cells"][0]["cell_type"] == "markdown" and len(code) > 2 and not any("def check" in cell for cell in code)
        if script.stem == "control":
            names = {"__name__": "__main__"}
            for cell in code:
                exec(compile(cell, script.stem, "exec"), names)  # pylint: disable=exec-used
            assert "the tip is where it should be" in capsys.readouterr().out


@pytest.mark.parametrize("script", sorted(path.name for path in (SOURCE / "scenes" / "python").glob("*.py")))
def test_the_examples_run(script, folder, monkeypatch):
    pytest.importorskip("scipy")
    monkeypatch.setenv("STROMA_SHARED_DATA", os.environ.get("STROMA_SHARED_DATA", ""))
    try:
        result = runpy.run_path(str(SOURCE / "scenes" / "python" / script), run_name="__main__")
    except SystemExit as ended:
        if ended.code == 77:
            pytest.skip("the measured data are not here")
        raise
    if "check" in result:
        result["check"]()
