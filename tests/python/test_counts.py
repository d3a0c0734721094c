# SPDX-License-Identifier: LGPL-2.1-or-later
"""What the module costs, by counts that no load of the machine changes: calls of Python, objects and bytes for each step."""
import gc
import os
import subprocess
import sys
import tracemalloc

import numpy
import stroma
from conftest import block


def calls_in(run):
    """Calls of functions of Python, and of C from Python."""
    found = {"call": [], "c_call": []}

    def see(frame, event, argument):
        if event == "call":
            found["call"].append(frame.f_code.co_name)
        elif event == "c_call":
            found["c_call"].append(getattr(argument, "__name__", ""))
    sys.setprofile(see)
    try:
        run()
    finally:
        sys.setprofile(None)
    return found


def nothing(_):
    pass


def test_a_step_of_a_run_calls_the_function_and_nothing_else(simulation):
    few, many = (calls_in(lambda steps=steps: simulation.run(steps)) for steps in (1, 51))
    assert len(many["call"]) == len(few["call"]) and len(many["c_call"]) == len(few["c_call"]), "a step alone is none of Python's"
    simulation.on_step_begin(nothing), simulation.on_step_end(nothing)
    one, more = (calls_in(lambda steps=steps: simulation.run(steps)) for steps in (1, 51))
    assert more["call"].count("nothing") == 102 and len(more["call"]) - len(one["call"]) == 100
    assert len(more["c_call"]) == len(one["c_call"])


def test_a_run_makes_no_objects(simulation):
    simulation.on_step_end(nothing)
    simulation.run(10)
    gc.collect()
    before = sys.getallocatedblocks()
    simulation.run(500)
    assert sys.getallocatedblocks() - before < 100, "a few for the report"


def test_reading_positions_allocates_no_copy():
    simulation = stroma.load(block(), set={"/body/grid.n": "20 20 20"})
    state = simulation.state()
    state.x  # what is made once
    tracemalloc.start()
    try:
        views = [state.x for _ in range(100)]
        size = sum(each.size for each in tracemalloc.take_snapshot().filter_traces([tracemalloc.Filter(True, "*")]).statistics("filename"))
    finally:
        tracemalloc.stop()
    assert size < 100 * 1000 < views[0].size * 8, "of each a head, none of its 64,000 numbers"
    assert {view.ctypes.data for view in views} == {state._state.address}


FAULTS_OF_WRITING = """
import resource
import numpy, stroma
root = stroma.Node("root", dt=0.01)
root.add("EulerExplicitSolver")
root.add("RegularGridTopology", n=(20, 20, 50), min=(0, 0, 0), max=(1, 1, 1))
root.add("MechanicalObject")
root.add("UniformMass", totalMass=1)
state = stroma.load(root).state()
positions = numpy.array(state.x)
state.x = positions  # what is reserved once
before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
for _ in range(100): state.x = positions
pages = positions.nbytes // resource.getpagesize()
print((resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before) / pages)
"""


def test_writing_positions_touches_no_new_memory():
    """Where memory goes back to the system after each call, a page fault for every page of the arrays comes with the next one. In a process
    of its own: one in which large arrays were freed before keeps memory too."""
    environment = {name: value for name, value in os.environ.items() if name != "GLIBC_TUNABLES"}
    said = subprocess.run([sys.executable, "-c", FAULTS_OF_WRITING], env=environment, capture_output=True, text=True, check=True).stdout
    assert float(said) < 50, "of 100 times as many pages"


def test_episodes_leave_nothing(simulation):
    """A hundred thousand is the sum of many thousand: what a thousand leave is what one would."""
    def episodes(count):
        for _ in range(count):
            simulation.reset()
            simulation.step()
            numpy.asarray(simulation.state().x)
    episodes(100)
    gc.collect()
    before = sys.getallocatedblocks()
    episodes(1000)
    gc.collect()
    assert sys.getallocatedblocks() - before < 200
