#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""How long two simulations take on two threads beside one, and what a function of the program adds to a step.

    PYTHONPATH=build/release/python python3 tests/python/measure_threads.py

Wall times depend on what else the machine does: this is no test. The best of several is told. What threads would take from each other
(locks, memory that both write) is in the processor time of a run, which other programs hardly change."""
import os
import threading
import time

import stroma
from conftest import block


def best(run, times=5):
    found = []
    for _ in range(times):
        start = time.perf_counter()
        run()
        found.append(time.perf_counter() - start)
    return min(found)


def on_threads(simulations, steps):
    threads = [threading.Thread(target=simulation.run, args=(steps,)) for simulation in simulations]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()


def in_processes(simulations, steps):
    """The same without a lock that could be shared."""
    children = []
    for simulation in simulations:
        child = os.fork()
        if child == 0:
            simulation.run(steps)
            os._exit(0)
        children.append(child)
    for child in children:
        os.waitpid(child, 0)


def processor_times(simulations, steps, times=5):
    """Least processor time of a run: after each other, on two threads, and in two processes."""
    found = {"after each other": [], "on two threads": [], "in two processes": []}

    def one(simulation, times_of):
        start = time.clock_gettime(time.CLOCK_THREAD_CPUTIME_ID)
        simulation.run(steps)
        times_of.append(time.clock_gettime(time.CLOCK_THREAD_CPUTIME_ID) - start)

    for _ in range(times):
        for simulation in simulations:
            one(simulation, found["after each other"])
        threads = [threading.Thread(target=one, args=(simulation, found["on two threads"])) for simulation in simulations]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        reading, writing = os.pipe()
        for simulation in simulations:
            if os.fork() == 0:
                alone = []
                one(simulation, alone)
                os.write(writing, f"{alone[0]} ".encode())
                os._exit(0)
        for _ in simulations:
            os.wait()
        os.close(writing)
        found["in two processes"] += [float(word) for word in os.read(reading, 4096).split()]
        os.close(reading)
    return {way: min(all_of) for way, all_of in found.items()}


def main():
    simulations = [stroma.load(block(), set={"/body/grid.n": "8 8 8"}) for _ in range(2)]
    for simulation in simulations:
        simulation.run(5)
    steps = 200
    alone = best(lambda: simulations[0].run(steps))
    together = best(lambda: on_threads(simulations, steps))
    apart = best(lambda: in_processes(simulations, steps))
    print(f"{os.cpu_count()} cores: {steps} steps of one simulation {alone * 1e3:.0f} ms, of two on two threads {together * 1e3:.0f} ms, "
          f"in two processes {apart * 1e3:.0f} ms")
    print("processor time of a run: " + ", ".join(f"{way} {least * 1e3:.0f} ms" for way, least in processor_times(simulations, steps).items()))

    small = stroma.load(block())
    steps = 2000
    plain = best(lambda: small.run(steps)) / steps
    tokens = [small.on_step_begin(lambda _: None), small.on_step_end(lambda _: None)]
    with_functions = best(lambda: small.run(steps)) / steps
    for token in tokens:
        token.remove()
    one_by_one = best(lambda: [small.step() for _ in range(steps)]) / steps
    x = small.state()
    reading = best(lambda: [x.x for _ in range(10000)]) / 10000
    print(f"a step {plain * 1e6:.1f} us; with two empty functions {(with_functions - plain) * 1e6:+.2f} us; by step() instead of run() "
          f"{(one_by_one - plain) * 1e6:+.2f} us; reading x {reading * 1e6:.2f} us")


if __name__ == "__main__":
    main()
