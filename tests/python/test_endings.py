# SPDX-License-Identifier: LGPL-2.1-or-later
"""What a program has no name for any more is gone at once, whatever was asked of it; and signals end a program."""
import gc
import os
import pathlib
import signal
import subprocess
import sys
import time
import weakref

import numpy
import pytest
import stroma
from conftest import PATIENCE, block, held


def used(simulation):
    """Everything of which a simulation keeps a part."""
    simulation.on_step_end(lambda _: None)
    simulation.run(2)
    parts = [simulation.state("/body"), simulation["/body/fem"], simulation["/body"], simulation.components(), simulation.states(),
             simulation.state().mesh(), simulation.add_force("/body", [1], force=(0, 1, 0)), simulation.checkpoint(), simulation.plan]
    assert simulation.state("/body") is parts[0] and simulation["/body/fem"] is parts[1], "while somebody has it"
    return parts


def test_a_simulation_ends_with_its_last_name():
    gc.disable()
    try:
        simulation = stroma.load(block())
        parts = used(simulation)
        ended = weakref.ref(simulation)
        del simulation
        assert ended() is not None, "its parts hold it"
        state = parts[0]
        del parts
        state.simulation.step()
        x = state.x
        del state
        assert ended() is None, "nothing waits for the collector"
        assert numpy.isfinite(x).all(), "its arrays stay"
    finally:
        gc.enable()


def test_many_simulations_take_the_memory_of_one():
    gc.disable()
    try:
        sizes = []
        for _ in range(6):
            for _ in range(10):
                used(stroma.load(block(), set={"/body/grid.n": "12 12 12"}))
            sizes.append(held())
        assert sizes[-1] - sizes[1] < 3 << 20, f"bytes after each ten: {sizes}"
    finally:
        gc.enable()


# ---- signals ----

PROGRAM = """
import signal, sys, stroma
HANDLER
sys.path.insert(0, sys.argv[1])
from conftest import block
print("loaded", flush=True)
while True:
    root = block()
    root.remove(root["linear"])
    root.insert(0, "SparseLDLSolver", name="linear")
    simulation = stroma.load(root, set={"/body/grid.n": "24 24 24"})
    ENDING
"""


def caught_by(process):
    """Whether SIGTERM has a handler in the process now."""
    for line in pathlib.Path(f"/proc/{process.pid}/status").read_text().splitlines():
        if line.startswith("SigCgt:"):
            return bool(int(line.split()[1], 16) >> (signal.SIGTERM - 1) & 1)
    return False


def program(handler="", ending="simulation.step()"):
    text = PROGRAM.replace("HANDLER", handler).replace("ENDING", ending)
    process = subprocess.Popen([sys.executable, "-c", text, os.path.dirname(os.path.abspath(__file__))], stdout=subprocess.PIPE, text=True)
    assert process.stdout.readline() == "loaded\n"
    return process


def test_sigterm_ends_a_program_while_metis_orders_a_matrix():
    """METIS has a handler of its own then, and takes the signal for an error: the program must end all the same."""
    process = program()
    end = time.monotonic() + PATIENCE
    while not caught_by(process):
        assert time.monotonic() < end and process.poll() is None, "METIS was never at work"
        time.sleep(0.001)
    process.send_signal(signal.SIGTERM)
    try:
        assert process.wait(PATIENCE) == -signal.SIGTERM
    finally:
        process.kill()


def test_sigterm_is_heard_by_a_handler_of_the_program():
    """It stops the run as Ctrl-C does, then the handler is called: here it ends the program."""
    tell = "simulation.on_step_end(lambda sim: print('steps', flush=True) if sim.steps == 1 else None)"
    process = program("signal.signal(signal.SIGTERM, lambda *_: sys.exit(7))", tell + "; simulation.run(10**9)")
    try:
        assert process.stdout.readline() == "steps\n", "it is in the middle of its run"
        process.send_signal(signal.SIGTERM)
        assert process.wait(PATIENCE) == 7
    finally:
        process.kill()


def test_a_handler_hears_what_comes_in_a_run_and_between_runs():
    heard = []
    before = signal.signal(signal.SIGTERM, lambda *_: heard.append(True))
    try:
        simulation = stroma.load(block())
        simulation.on_step_end(lambda sim: os.kill(os.getpid(), signal.SIGTERM) if sim.steps == 3 else None)
        simulation.run(10)
        assert heard == [True] and simulation.steps == 3, "it stops the run as Ctrl-C does"
        simulation.run(7)
        os.kill(os.getpid(), signal.SIGTERM)
        assert heard == [True, True]
        assert signal.SIGTERM not in signal.pthread_sigmask(signal.SIG_BLOCK, [])
        simulation.run(1)
        assert simulation.steps == 11 and len(heard) == 2
    finally:
        signal.signal(signal.SIGTERM, before)


def test_a_forked_process_runs(simulation):
    simulation.step()
    child = os.fork()
    if child == 0:
        try:
            simulation.run(3)
            os._exit(simulation.steps)
        finally:
            os._exit(99)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 4
    simulation.run(1)


@pytest.mark.parametrize("what", [lambda sim: sim.state().x, lambda sim: sim["/body/dofs"].position, lambda sim: sim.gravity])
def test_nobody_looks_into_a_step_of_another_thread(simulation, what):
    import threading

    inside, go_on = threading.Event(), threading.Event()
    simulation.on_step_begin(lambda _: (inside.set(), go_on.wait(PATIENCE)))
    thread = threading.Thread(target=simulation.step)
    thread.start()
    assert inside.wait(PATIENCE)
    with pytest.raises(stroma.StromaError, match="another thread"):
        what(simulation)
    go_on.set()
    thread.join()
    what(simulation)
