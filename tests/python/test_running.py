# SPDX-License-Identifier: LGPL-2.1-or-later
"""Simulations: steps, attributes that change, functions that are called, memory, threads."""
import copy
import http.client
import json
import os
import re
import signal
import subprocess
import sys
import threading
import time
import traceback
import types
import urllib.parse
import warnings

import numpy
import pytest
import stroma
from conftest import EXAMPLES, PATIENCE, block


def test_steps_and_times(simulation):
    report = simulation.step()
    assert report.linear_iterations > 0 and not report.diverged and simulation.steps == 1
    report = simulation.run(steps=4)
    assert report.steps == 4 and len(report.step_ms) == 4 and report.end == "done"
    simulation.run(until=0.1)
    assert simulation.steps == 10 and simulation.time == pytest.approx(0.1, abs=1e-15)
    simulation.step(dt=0.02)
    assert simulation.dt == 0.02 and simulation.time == pytest.approx(0.12, abs=1e-15)
    with pytest.raises(ValueError):
        simulation.run()
    for wrong in ("three", 1.5):
        with pytest.raises(TypeError):
            simulation.run(wrong)
    for wrong in ({"steps": -1}, {"until": 0.01}, {"until": float("nan")}):
        with pytest.raises(ValueError, match="expected"):
            simulation.run(**wrong)
    assert simulation.run(0).steps == 0 and simulation.run(until=simulation.time).steps == 0
    for wrong in (lambda: simulation[3], lambda: simulation.state(3), lambda: stroma.load(3), lambda: stroma.Node("r")[3]):
        with pytest.raises(TypeError):
            wrong()
    with pytest.raises(stroma.SceneError, match="scene in Python.*stroma run"):
        stroma.load("scene.py")


def test_attributes_change_or_say_why_not(simulation):
    fem = simulation["/body/fem"]
    assert fem.youngModulus.tolist() == [5000] if isinstance(fem.youngModulus, numpy.ndarray) else fem.youngModulus == 5000
    other = stroma.load(block(youngModulus="12 kPa"))
    fem.youngModulus = "12 kPa"
    simulation.run(3), other.run(3)
    assert numpy.allclose(simulation.state().x, other.state().x, rtol=0, atol=1e-9)
    with pytest.raises(stroma.SceneError, match="loaded"):
        simulation["/body/grid"].n = [2, 2, 2]
    with pytest.raises(stroma.SceneError, match="did you mean '?youngModulus"):
        fem.youngModulos = 3
    with pytest.raises(AttributeError, match="did you mean '?youngModulus"):
        fem.youngModulos
    with pytest.raises(stroma.SceneError):
        fem.youngModulus = -3
    with pytest.raises(stroma.SceneError, match="did you mean '?/body/fem"):
        simulation["/body/fme"]
    simulation.gravity = (0, 0, -1)
    assert simulation.gravity.tolist() == [0, 0, -1] and simulation.node("/").gravity.tolist() == [0, 0, -1]
    assert all(isinstance(one, stroma.Problem) for one in simulation.set("/body/fem.poissonRatio", 0.4))


def test_functions_are_called_around_steps(simulation):
    calls = []
    begin = simulation.on_step_begin(lambda sim: calls.append(("begin", sim.steps)))
    simulation.on_step_end(lambda sim: calls.append(("end", sim.steps)))
    simulation.run(2)
    assert calls == [("begin", 0), ("end", 1), ("begin", 1), ("end", 2)]
    begin.remove()
    simulation.step()
    assert calls[4:] == [("end", 3)]


def test_functions_may_do_what_may_be_done_between_steps(simulation):
    def act(sim):
        sim["/body/fem"].youngModulus = 5000 + sim.steps
        sim.state().set(v=numpy.zeros((100, 3)))
        sim.checkpoint()
    simulation.on_step_begin(act)
    simulation.run(3)
    assert simulation.steps == 3
    simulation.on_step_end(lambda sim: sim.step())
    with pytest.raises(stroma.StromaError, match="under way"):
        simulation.step()


def test_what_a_function_throws_comes_out(simulation):
    def fail(sim):
        if sim.steps == 3:
            raise KeyError("my own")
    simulation.on_step_end(fail)
    with pytest.raises(KeyError) as caught:
        simulation.run(10)
    assert simulation.steps == 3
    assert "fail" in "".join(traceback.format_tb(caught.value.__traceback__))
    simulation.run(1)


def test_a_run_is_stopped_by_a_function(simulation):
    simulation.on_step_end(lambda sim: sim.stop("far enough") if sim.steps == 4 else None)
    simulation.run(100)
    assert simulation.steps == 4 and simulation.stop_reason == "far enough"
    simulation.run(1)
    assert simulation.stop_reason == ""  # that of the last run
    simulation.stop("before a run")
    simulation.run(1)
    assert simulation.stop_reason == ""


def test_ctrl_c_ends_a_run(folder):
    root = block()
    root["body"].add("WriteState", filename="steps.state")
    simulation, written = stroma.load(root), folder / "steps.state"

    def interrupt():
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end and not (written.exists() and written.read_text().count("T=") > 3):
            time.sleep(0.01)  # until it is in the middle of its steps
        os.kill(os.getpid(), signal.SIGINT)
    thread = threading.Thread(target=interrupt)
    thread.start()
    with pytest.raises(KeyboardInterrupt):
        simulation.run(10**9)
    thread.join()
    steps = simulation.steps
    assert steps > 2
    simulation.run(1)
    assert simulation.steps == steps + 1
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_divergence_is_an_error_with_the_last_good_state():
    root = stroma.Node("root", dt=1, gravity=(0, 0, 0))
    root.add("EulerExplicitSolver")
    root.add("MechanicalObject", name="dofs", position=[[0, 0, 0], [1.5, 0, 0]])
    root.add("UniformMass", totalMass=1)
    root.add("StiffSpringForceField" if stroma.is_known("StiffSpringForceField") else "SpringForceField", spring="0 1 1e9 0 1")
    simulation = stroma.load(root)
    with pytest.raises(stroma.StepError, match="step") as caught:
        simulation.run(1000)
    assert caught.value.report.end == "diverged" and numpy.isfinite(simulation.state().x).all()
    report = simulation.run(1000, check=False)
    assert report.end == "diverged" and "step" in report.reason


def test_memory(simulation):
    simulation.run(3)
    mark = simulation.checkpoint()
    simulation.run(4)
    after = simulation.hash
    simulation.restore(mark)
    assert simulation.steps == 3
    simulation.run(4)
    assert simulation.hash == after
    twin = copy.copy(simulation)
    assert twin.hash == simulation.hash and twin.steps == simulation.steps
    twin.run(3)
    assert simulation.hash == after and twin.hash != after
    simulation.run(3)
    assert twin.hash == simulation.hash
    for broken in (mark[:-9], b"nothing", mark[:200] + b"x" + mark[201:]):
        with pytest.raises(stroma.StromaError):
            simulation.restore(broken)


def test_forces_from_outside(simulation):
    state = simulation.state()
    free = stroma.load(block())
    push = simulation.add_force(state, [0, 1], force=(5, 0, 0))
    simulation.run(3), free.run(3)
    assert simulation.state().x[0, 0] > free.state().x[0, 0]
    push.change(force=(-5, 0, 0))
    simulation.run(6), free.run(6)
    assert simulation.state().v[0, 0] < free.state().v[0, 0]
    push.remove()
    assert '"input"' in simulation.actions()
    with pytest.raises(stroma.SceneError, match="node"):
        simulation.add_force(state, [1000])
    with pytest.raises(ValueError, match="3 numbers, not 6.*ConstantForceField"):
        simulation.add_force(state, [0], force=(0, 0, 0, 0, 0, 1))
    ended = simulation.add_force(state, [0], force=(5, 0, 0))
    simulation.reset()
    with pytest.raises(stroma.SceneError, match="reset"):
        ended.change(force=(1, 0, 0))


def test_a_component_stands_in_the_place_of_another():
    point = stroma.Node("root", dt=0.02, gravity=(0, -10, 0))
    point.add("EulerImplicitSolver", name="solver", rayleighMass=3)
    point.add("CGLinearSolver", name="linear", iterations=20, tolerance=1e-9)
    point.add("MechanicalObject", position=[[0, 0, 0]])
    point.add("UniformMass", totalMass=1)
    simulation = stroma.load(point, set={"/solver": "TrapezoidalRuleSolver", "/linear": "SparseLDLSolver"})
    simulation.run(10)
    assert simulation["/solver"].type == "TrapezoidalRuleSolver" and simulation["/linear"].type == "SparseLDLSolver"
    assert simulation.state().x[0, 1] == pytest.approx(-0.5 * 10 * 0.2 ** 2, rel=1e-12)
    with pytest.raises(stroma.SceneError, match="TrapezoidalRuleSolver"):
        stroma.load(point, set={"/solver": "TrapezodalRuleSolver"})
    with pytest.raises(stroma.SceneError, match="names no attribute"):
        stroma.load(point, set={"/solver": 3})


def test_two_threads_step_without_the_lock():
    """Each steps a simulation of its own while this thread goes on, and results are those of one. Longer runs where the machine
    gave this thread no time meanwhile: one that waits for the lock gets none in any of them."""
    simulations = [stroma.load(block()) for _ in range(2)]
    alone = stroma.load(block())
    failures, count = [], 0

    def work(simulation, steps):
        try:
            simulation.run(steps)
        except BaseException as error:  # noqa: BLE001 pylint: disable=broad-except
            failures.append(error)
    for steps in (200, 800, 3200, 12800):
        threads = [threading.Thread(target=work, args=(simulation, steps)) for simulation in simulations]
        for thread in threads:
            thread.start()
        while any(thread.is_alive() for thread in threads):
            count += all(thread.is_alive() for thread in threads)
            time.sleep(0)
        for thread in threads:
            thread.join()
        alone.run(steps)
        assert not failures and {simulation.hash for simulation in simulations} == {alone.hash}
        if count > 10:
            break
    assert count > 10, "this thread went on meanwhile"


def test_another_thread_is_refused(simulation):
    inside, go_on = threading.Event(), threading.Event()

    def wait(_):
        inside.set()
        go_on.wait(PATIENCE)
    simulation.on_step_begin(wait)
    thread = threading.Thread(target=simulation.step)
    thread.start()
    assert inside.wait(PATIENCE)
    with pytest.raises(stroma.StromaError, match="another thread"):
        simulation.step()
    with pytest.raises(stroma.StromaError, match="another thread"):
        simulation["/body/fem"].youngModulus = 1
    go_on.set()
    thread.join()
    assert simulation.steps == 1


def test_energies_fields_and_plans(simulation):
    simulation.run(5)
    energies = simulation.energies()
    assert energies["kinetic"] > 0 and energies["elastic"] > 0
    assert any("fem" in line for line in simulation.plan)
    assert simulation["/body/fem"].role == "force field"
    organ = stroma.load(EXAMPLES / "cantilever.xml", observers=False)
    organ.run(2)
    fem = next(one for one in organ.components() if one.fields)
    values = fem.field(fem.fields[0])
    assert values.ndim == 1 and len(values) > 10
    with pytest.raises(stroma.SceneError):
        fem.field("vonMeses")


def test_a_page_plays_the_run(simulation, folder):
    begun, ended = [], []
    simulation.on_step_begin(lambda sim: begun.append(sim.steps))
    simulation.on_step_end(lambda sim: ended.append(sim.steps))
    try:
        page = simulation.page("run.html", steps=6, every=2)
    except stroma.StromaError as error:
        if "view" in str(error):
            pytest.skip("the live view is not built")
        raise
    assert (begun, ended) == ([0, 1, 2, 3, 4, 5], [1, 2, 3, 4, 5, 6])
    assert simulation.steps == 6 and (folder / "run.html").stat().st_size > 10000
    assert page._repr_html_().startswith("<iframe")


def test_studies_and_recordings(folder):
    def deflection(sim):
        sim.run(5)
        return sim.state().x.copy()
    runs = stroma.sweep(block(), {"/body/fem.youngModulus": [4000, "8 kPa"], "dt": [0.01, 0.005]}, deflection, threads=2)
    assert [tuple(run.values.values()) for run in runs] == [(4000, 0.01), (4000, 0.005), ("8 kPa", 0.01), ("8 kPa", 0.005)]
    assert not any(run.error for run in runs)
    alone = stroma.sweep(block(), {"/body/fem.youngModulus": [4000, "8 kPa"], "dt": [0.01, 0.005]}, deflection, threads=1)
    assert all(numpy.array_equal(one.result, other.result) for one, other in zip(runs, alone))
    wrong = stroma.sweep(block(), {"/body/fem.poissonRatio": [0.3, 0.7]}, deflection)
    assert wrong[0].error is None and isinstance(wrong[1].error, stroma.SceneError)
    derivative = stroma.jacobian(lambda p: [p[0] ** 2, p[0] * p[1]], [3.0, 0.0])
    assert numpy.allclose(derivative, [[6, 0], [0, 3]], atol=1e-6)

    root = block()
    root["body"].add("WriteState", name="writer", filename="block.state", writeX=True, writeV=True, period=0.01)
    simulation = stroma.load(root)
    simulation.run(3)
    simulation.finish()
    recording = stroma.read_recording("block.state")
    assert recording.x.shape[1:] == (100, 3) and recording.times[-1] == pytest.approx(0.03) and not recording.unfinished
    assert numpy.array_equal(recording.x[-1], simulation.state().x) and numpy.array_equal(recording.v[-1], simulation.state().v)
    with pytest.raises(stroma.StromaError):
        stroma.read_recording("none.state")
    (folder / "picture.png").write_bytes(b"\x89PNG\r\n\x1a\n\xff\xfe")  # a message quotes what it has read
    with pytest.raises(stroma.StromaError, match="picture.png:1: .* is not a line of a state file"):
        stroma.read_recording("picture.png")
    with pytest.raises(ValueError, match="has no recorded state"):
        stroma.read_recording(".")
    for name in ("b.dofs.state.gz", "a.dofs.state.gz"):
        (folder / name).touch()
    with pytest.raises(ValueError, match="there are a.dofs, b.dofs"):
        stroma.read_recording(".")


def test_files_of_monitors_are_arrays(folder):
    root = block()
    root["body"].add("Monitor", name="tip", indices=(3, 7), ExportPositions=True, ExportVelocities=True)
    root.add("EnergyMonitor", name="energy", filename="energy.txt")
    simulation = stroma.load(root)
    start = simulation.state().start
    simulation.run(4)
    simulation.finish()
    x, v, energy = (stroma.read_monitor(name) for name in ("tip_x.txt", "tip_v.txt", "energy.txt"))
    assert x.times.tolist() == pytest.approx([0, 0.01, 0.02, 0.03, 0.04]) and x.values.shape == v.values.shape == (5, 2, 3)
    assert numpy.array_equal(x.values[0], start[[3, 7]]) and numpy.array_equal(x.values[-1], simulation.state().x[[3, 7]])
    assert numpy.array_equal(v.values[-1], simulation.state().v[[3, 7]]) and "positions" in x.head[0]
    assert energy.values.shape == (5, 5) and energy.values[-1, 0] == pytest.approx(simulation.energies()["kinetic"], rel=1e-12)
    with pytest.raises(FileNotFoundError):
        stroma.read_monitor("none.txt")
    (folder / "cut.txt").write_text("# head\n0 1 2\n0.1 1\n")
    with pytest.raises(ValueError, match="different numbers of columns"):
        stroma.read_monitor("cut.txt")


def test_several_threads_load_at_once():
    hashes, threads = [], []
    for _ in range(4):
        threads.append(threading.Thread(target=lambda: hashes.append([stroma.load(block()).hash for _ in range(5)])))
        threads[-1].start()
    for thread in threads:
        thread.join()
    assert len(hashes) == 4 and len({one for some in hashes for one in some}) == 1


def test_a_view_runs_until_it_is_interrupted(simulation, capsys):
    steps = []

    def seen(sim):
        steps.append(sim.steps)
        if sim.steps == 20:
            os.kill(os.getpid(), signal.SIGINT)
    begun = []
    token, other = simulation.on_step_end(seen), simulation.on_step_begin(lambda sim: begun.append(sim.steps))
    try:
        simulation.view(at_once=True, browser=False)
    except stroma.StromaError as error:
        if "view" in str(error):
            pytest.skip("the live view is not built")
        raise
    assert capsys.readouterr().out.startswith("http://127.0.0.1:") and steps[:20] == list(range(1, 21))
    assert begun[:20] == list(range(20)), "before each step"
    other.remove()
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    before = simulation.steps
    token.remove()
    simulation.run(2)
    assert simulation.steps == before + 2


def warned(call):
    """Of a scene or a run, with the file that it blames."""
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        call()
    assert all(each.category is stroma.SceneWarning and each.filename == __file__ for each in found)
    return [str(each.message) for each in found]


def test_warnings_of_a_scene_and_of_its_runs_are_those_of_python():
    made = []
    root = block()
    del root["body/mass"].attributes["totalMass"]
    told, = warned(lambda: made.append(stroma.load(root, set={"/linear.iterations": 1})))
    assert "conftest.py:" in told and "/body/mass" in told and "totalMass" in told and "warning:" not in told
    simulation, = made
    told, = warned(lambda: simulation.run(3))
    assert told in simulation.run(3).warnings[0] or "3 of 3" in told
    assert not warned(lambda: simulation.run(7)), "the same, with other numbers"
    report = simulation.run(3)
    assert repr(report).startswith("<run of 3 steps: done, ") and repr(report).endswith(", 1 warning>")
    assert not warned(lambda: stroma.load(block())) and not warned(lambda: stroma.load(block()).run(30))

    def silent():
        quiet = stroma.load(root, set={"/linear.iterations": 1}, quiet=True)
        quiet.run(30)
        quiet.copy().run(1)
    assert not warned(silent)


def test_doubts_about_a_result_are_told(simulation):
    assert simulation.doubts() == []
    state = simulation.state()
    state.set(x=state.x * (1, 1, -1))
    doubt, = simulation.doubts()
    assert doubt.startswith("/body/fem at t = 0 s: 48 of 48 elements are inverted or flat")
    assert not warned(lambda: simulation.run(19)), "an episode of a few steps is not looked at"
    told, = warned(lambda: simulation.run(20))
    assert "elements are strained beyond 50 %" in told and told.splitlines() == simulation.doubts()
    assert not warned(lambda: simulation.run(20)), "the same, with other numbers"


def test_bodies_whose_names_have_numbers_are_told_apart():
    root = block()
    root.children[0].name = "body1"
    other = block().children[0]
    other.name = "body2"
    root.add_child(other)
    simulation = stroma.load(root)
    for state in simulation.states():
        state.set(x=state.x * (1, 1, -1))
    told, = warned(lambda: simulation.run(20))
    assert told.count("/body1/fem at t") == 1 and told.count("/body2/fem at t") == 1
    assert not warned(lambda: simulation.run(20))
    simulation.reset()
    for state in simulation.states():
        state.set(x=state.x * (1, 1, -1))
    assert not warned(lambda: simulation.run(20)), "episodes by the thousand are not told one by one"


def viewed(simulation, **how):
    """Until a function of the program interrupts it."""
    try:
        simulation.view(at_once=True, browser=False, **how)
    except stroma.StromaError as error:
        if "tools/setup view" in str(error):
            pytest.skip("the live view is not built")
        raise


def interrupt(*_):
    os.kill(os.getpid(), signal.SIGINT)


@pytest.fixture(name="shown")
def cell(monkeypatch):
    """A notebook: what IPython's display() is given; a plain interpreter has no IPython."""
    shown = []
    monkeypatch.setitem(sys.modules, "IPython", types.SimpleNamespace(get_ipython=lambda: types.SimpleNamespace(kernel=object())))
    monkeypatch.setitem(sys.modules, "IPython.display", types.SimpleNamespace(HTML=str, display=shown.append))
    return shown


def jupyter(monkeypatch, folder, **described):
    """The server that has started this kernel, as it describes itself."""
    (folder / "jpserver-4711.json").write_text(json.dumps(described))
    monkeypatch.setenv("JPY_PARENT_PID", "4711")
    monkeypatch.setitem(sys.modules, "jupyter_core", types.ModuleType("jupyter_core"))
    monkeypatch.setitem(sys.modules, "jupyter_core.paths", types.SimpleNamespace(jupyter_runtime_dir=lambda: str(folder)))


@pytest.mark.parametrize("described", [{}, {"port": 8888, "secure": True}, {"port": "8888; evil", "secure": False}, {"port": 0}])
def test_a_view_is_linked_below_its_cell(simulation, shown, monkeypatch, tmp_path, described):
    jupyter(monkeypatch, tmp_path, **described)
    simulation.on_step_end(interrupt)
    viewed(simulation)
    assert len(shown) == 1 and shown[0].startswith('<a href="http://127.0.0.1:') and "iframe" not in shown[0]
    assert 'simulation.page("run.html")' in shown[0], "what a notebook by https can show"


def headers_of(address, **sent):
    """Status and headers of an answer, without following it."""
    at = urllib.parse.urlsplit(address)
    connection = http.client.HTTPConnection(at.hostname, at.port, timeout=PATIENCE)
    connection.request("GET", at.path + ("?" + at.query if at.query else ""), headers=sent)
    answer = connection.getresponse()
    answer.read()
    connection.close()
    return answer.status, answer.headers


@pytest.mark.parametrize("given", [None, ["http://localhost:8888", "http://127.0.0.1:8888"]])
def test_a_view_is_shown_in_its_cell_to_this_notebook_alone(simulation, shown, monkeypatch, tmp_path, given):
    jupyter(monkeypatch, tmp_path, port=8888, secure=False, url="http://localhost:8888/")
    told = []

    def look(_):
        if told or not shown:  # the first steps may come before the address
            return
        try:
            address = re.search(r'href="([^"]+)"', shown[0])[1]
            for with_token in (address, address.split("?")[0], address[:-1]):
                told.append(headers_of(with_token))
            told.append(headers_of(address.split("?")[0], Cookie=told[0][1]["Set-Cookie"].split(";")[0]))
            told.append(headers_of(address, Origin="http://localhost:8888"))
        finally:
            interrupt()
    simulation.on_step_end(look)
    viewed(simulation, framed_by=given)
    assert 'createElement("iframe")' in shown[0] and '["http://localhost:8888", "http://127.0.0.1:8888"]' in shown[0]
    (first, redirect), (no_token, refused), (wrong_token, _), (page, served), (foreign, _) = told[:5]
    assert (first, no_token, wrong_token, page, foreign) == (303, 403, 403, 200, 403)
    for headers in (redirect, served):
        assert "frame-ancestors http://localhost:8888 http://127.0.0.1:8888;" in headers["Content-Security-Policy"]
        assert "X-Frame-Options" not in headers
    assert "frame-ancestors 'none';" in refused["Content-Security-Policy"] and refused["X-Frame-Options"] == "DENY"
    assert "SameSite=Strict" in redirect["Set-Cookie"] and "HttpOnly" in redirect["Set-Cookie"]


def test_no_page_may_show_a_view_where_none_is_named(simulation, shown, monkeypatch, tmp_path):
    jupyter(monkeypatch, tmp_path, port=8888, secure=False)
    told = []

    def look(_):
        if told or not shown:  # the first steps may come before the address
            return
        try:
            address = re.search(r'href="([^"]+)"', shown[0])[1]
            told.append(headers_of(address))
        finally:
            interrupt()
    simulation.on_step_end(look)
    viewed(simulation, framed_by=[])
    assert "iframe" not in shown[0]
    assert "frame-ancestors 'none';" in told[0][1]["Content-Security-Policy"] and told[0][1]["X-Frame-Options"] == "DENY"
    with pytest.raises(stroma.StromaError, match="'http://a;script-src .' is no origin of a page: expected one as http://localhost"):
        simulation.view(browser=False, framed_by=["http://a;script-src *"])


@pytest.mark.parametrize("when", ["on_step_begin", "on_step_end"])
def test_after_an_interrupt_within_a_function_of_the_program_it_goes_on(simulation, when):
    def interrupted(sim):
        if sim.steps == 3:
            os.kill(os.getpid(), signal.SIGINT)
    token = getattr(simulation, when)(interrupted)
    with pytest.raises(KeyboardInterrupt):
        simulation.run(10)
    token.remove()
    before = simulation.steps
    assert before in (3, 4)
    simulation.run(2)
    assert simulation.steps == before + 2


def test_threads_of_a_step_change_no_bit():
    alone = stroma.load(EXAMPLES / "cantilever.xml", observers=False)
    alone.run(3)
    assert stroma.threads() == 1
    stroma.set_threads(2)
    try:
        several = stroma.load(EXAMPLES / "cantilever.xml", observers=False)
        several.run(3)
    finally:
        stroma.set_threads(1)
    assert several.hash == alone.hash
    with pytest.raises(ValueError, match="threads"):
        stroma.set_threads(0)


SEVERAL_THREADS = """
import os
import stroma

LARGE = {"/block/grid.n": "21 21 21"}


def threads(simulation):
    simulation.step()
    return stroma.threads()


if __name__ == "__main__":
    scene = os.environ["SCENE"]
    small, large = stroma.load(scene, {"/block/grid.n": "5 5 5"}), stroma.load(scene, LARGE)
    print(threads(small), threads(large), threads(small))
    for how in ({"threads": 2}, {"processes": 2}):
        print(*(run.result for run in stroma.sweep(scene, {"/block/grid.n": ["21 21 21", "22 21 21"]}, threads, **how)))
    print(threads(large))
    stroma.set_threads(3)
    print(threads(small), threads(large))
"""


def test_threads_are_chosen_by_the_size_of_a_scene(folder):
    (folder / "program.py").write_text(SEVERAL_THREADS)
    environment = {**os.environ, "SCENE": str(EXAMPLES.parent / "benchmarks" / "block_320000.xml")}
    given = {**environment, "STROMA_THREADS": "2"}
    environment.pop("STROMA_THREADS", None)

    def lines(of):
        return subprocess.run([sys.executable, "program.py"], env=of, check=True, capture_output=True, text=True, timeout=PATIENCE).stdout.split("\n")

    several = lines(environment)
    assert several[0] in ("1 2 1", "1 1 1")  # of one core
    assert several[1:3] == ["1 1", "1 1"], "runs at once have one thread each"
    assert several[3] == several[0][2] and several[4] == "3 3"
    assert lines(given)[:2] == ["2 2 2", "2 2"]
    given["STROMA_THREADS"] = "many"
    with pytest.raises(subprocess.CalledProcessError) as caught:
        lines(given)
    assert "STROMA_THREADS is 'many': expected 1 to 1024" in caught.value.stderr


def test_problems_of_a_file_have_their_place(folder):
    (folder / "bad.xml").write_text('<Node name="root">\n  <MechanicalObject name="dofs" position="0 0 0"/>\n'
                                    '  <UniformMass name="mass" totalMas="1"/>\n</Node>\n')
    with pytest.raises(stroma.SceneError) as caught:
        stroma.load("bad.xml")
    error = caught.value
    assert error.file.endswith("bad.xml") and error.line == 3 and error.path == "/mass.totalMas" and error.nearest == "totalMass"
    assert "bad.xml:3:" in str(error) and isinstance(error, stroma.StromaError) and isinstance(error, RuntimeError)
    with pytest.raises(stroma.SceneError, match="not found"):
        stroma.load("none.xml")
    with pytest.raises(stroma.SceneError, match="did you mean '?/dofs"):
        stroma.load(stroma.from_xml_text('<Node><MechanicalObject name="dofs" position="0 0 0"/></Node>'), set={"/dosf.position": "1 1 1"})


def test_what_refuses_a_step_does_so_without_observers(folder):
    root = stroma.Node("root", dt=0.01)
    root.add("EulerExplicitSolver")
    root.add("RegularGridTopology", n=[2, 2, 2], min=[0, 0, 0], max=[1, 1, 1])
    root.add("MechanicalObject")
    root.add("UniformMass", totalMass=1)
    root.add("TopologicalChangeProcessor", useDataInputs=True, timeToRemove=0.05, hexahedraToRemove=0)
    for simulation in (stroma.load(root), stroma.load(root, observers=False), stroma.load(root).copy()):
        try:
            report = simulation.run(10)
            assert report.end != "done", simulation.time
        except stroma.StepError as error:
            assert "a planned change of a mesh is not possible" in str(error)
        assert simulation.time < 0.07


def test_states_follow_a_mesh_that_changes(folder):
    root = stroma.Node("root", dt=0.01, gravity=[0, -10, 0])
    root.add("EulerImplicitSolver")
    root.add("SparseLDLSolver")
    root.add("RegularGridTopology", n=[4, 2, 2], min=[0, 0, 0], max=[3, 1, 1])
    root.add("MechanicalObject", name="dofs")
    root.add("MeshMatrixMass", massDensity=1)
    root.add("CarvingRegion", box=[2.1, 0, 0, 3, 1, 1], begin=0.02)
    simulation = stroma.load(root)
    state = simulation.state("/dofs")
    before = state.x
    start = numpy.array(before)
    with pytest.warns(RuntimeWarning, match="arrays taken of a state before .* are of the mesh before"):
        simulation.run(5)
    assert state.nodes == 12 and state.x.shape == (12, 3) and state.size == 12
    assert before.shape == (16, 3) and numpy.isfinite(before).all(), "the view of before is that of the mesh before"
    left = start[start[:, 0] < 2.5]
    assert numpy.allclose(sorted(map(tuple, state.rest)), sorted(map(tuple, left)), atol=1e-14)
    assert numpy.allclose(state.x - state.rest, [0, -10 * 0.01**2 * 15, 0], atol=1e-12)
    later = state.x
    simulation.run(1)
    assert not numpy.allclose(later, state.x), "a copy, once meshes have changed"
    simulation.reset()
    assert state.nodes == 16 and numpy.array_equal(state.x, start)

    del state
    simulation = stroma.load(root)
    simulation.run(5)
    state = simulation.state("/dofs")
    assert state.nodes == 12, "asked for once its mesh has changed"
    simulation.reset()
    assert state.nodes == 16 and numpy.array_equal(state.x, start)


CARVED = """<Node name="root" dt="0.01" gravity="0 -10 0"><EulerImplicitSolver/><SparseLDLSolver/>
  <RegularGridTopology n="6 2 2" min="0 0 0" max="5 1 1"/><MechanicalObject name="dofs"/><MeshMatrixMass massDensity="1"/>
  <HexahedronFEMForceField name="fem" method="svd" youngModulus="3000" poissonRatio="0.3"/>
  <BoxROI name="end" box="-1 -1 -1 0.1 2 2"/><FixedProjectiveConstraint indices="@end.indices"/>
  <CarvingRegion name="knife" box="4.1 -9 -9 9 9 9" velocity="-50 0 0" begin="0.02" end="0.05"/></Node>"""


def test_a_changed_mesh_goes_on_from_a_checkpoint_and_in_a_copy(folder):
    """A cell goes before the third step, and one before the fifth."""
    simulation = stroma.load(stroma.from_xml_text(CARVED))
    simulation.request_forces()
    state = simulation.state()
    marks, ends = {}, []
    for step in range(1, 9):
        simulation.step()
        marks[step] = simulation.checkpoint(), state.nodes, state.x.copy(), state.f.copy(), state.mesh()
        assert state.f.shape == state.x.shape == state.v.shape == state.rest.shape == (state.nodes, 3)
    assert [nodes for _, nodes, *_ in marks.values()] == [24, 24, 20, 20, 16, 16, 16, 16]
    end = simulation.hash
    for step in (5, 1, 7, 3, 2):
        mark, nodes, x, f, _ = marks[step]
        simulation.restore(mark)
        assert state.nodes == nodes and numpy.array_equal(state.x, x) and numpy.array_equal(state.f, f), step
        other = simulation.copy()
        assert other.state().nodes == nodes and numpy.array_equal(other.state().x, x), step
        for each in (other, simulation):
            each.run(8 - step)
            assert each.hash == end, step
        fresh = stroma.load(stroma.from_xml_text(CARVED))
        fresh.restore(mark)
        fresh.run(8 - step)
        assert fresh.hash == end, step
    simulation.reset()
    assert state.nodes == 24 and numpy.array_equal(state.x, state.start)


def test_a_refused_checkpoint_leaves_a_changed_run_as_it_was(folder):
    """Forces that were asked for are there, as before and after the next step."""
    other = stroma.load(stroma.from_xml_text(CARVED.replace('max="5 1 1"', 'max="5 1.5 1"')))
    simulation, same = (stroma.load(stroma.from_xml_text(CARVED)) for _ in range(2))
    for each in (other, simulation, same):
        each.request_forces()
        each.run(4)
    before, forces = simulation.hash, simulation.state().f.copy()
    with pytest.raises(Exception, match="than when its mesh changed"):
        simulation.restore(other.checkpoint())
    assert simulation.hash == before and simulation.state().f.shape == forces.shape
    for each in (simulation, same):
        each.run(3)
    assert simulation.hash == same.hash and numpy.array_equal(simulation.state().f, same.state().f)


def test_arrays_of_any_mesh_may_be_kept(folder):
    """None reads memory that has been given back, whatever becomes of the simulation: each has its numbers to the end."""
    simulation = stroma.load(stroma.from_xml_text(CARVED))
    state = simulation.state()
    kept, numbers = [], []
    def keep():
        for array in (state.x, state.v):
            kept.append(array)
            numbers.append(array.copy())
    mark = simulation.checkpoint()
    for _ in range(2):
        for _ in range(7):
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", RuntimeWarning)
                simulation.step()
            if state.nodes < 24:
                keep()
        simulation.restore(mark)
    assert {array.shape for array in kept} == {(20, 3), (16, 3)}
    del simulation, state
    for array, before in zip(kept, numbers):
        assert numpy.array_equal(array, before)
