# SPDX-License-Identifier: LGPL-2.1-or-later
"""Many runs of a scene, and what recorded runs hold."""
import functools
import itertools
import multiprocessing
import os
import pickle
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from typing import Any, Callable, Dict, Iterable, List, NamedTuple, Optional, Sequence, Union

import numpy

from . import _stroma
from .errors import StromaError
from .simulation import Simulation, load
from .tree import Node


class Run(NamedTuple):
    """One of the runs of a sweep."""

    values: Dict[str, Any]  #: of the attributes
    result: Any  #: what the function returned
    error: Optional[Exception]  #: what it threw


def sweep(scene: Union[str, os.PathLike, Node], values: Dict[str, Iterable[Any]], run: Callable[[Simulation], Any],
          threads: Optional[int] = None, processes: Optional[int] = None) -> List[Run]:
    """Loads the scene with every combination of values, {"/fem.youngModulus": [3e3, 6e3], "dt": [0.01]}, and calls run(simulation)
    for each, in several threads: a run leaves the interpreter to the others while it steps. Results are in the order of the
    combinations, whatever the number of threads; what a run throws is in it, and the others go on. Where functions of Python take the
    most time, `processes` of their own do not wait for each other: `run` is then a function of a module or of the program's file, which
    makes its runs below `if __name__ == "__main__":`, and the scene is a file or a tree without parts in Python."""
    names = list(values)
    combinations = [dict(zip(names, chosen)) for chosen in itertools.product(*(list(values[name]) for name in names))]

    if processes is None:
        each = functools.partial(_one, scene, run)
        chosen = _stroma.choose_threads(False)  # the runs share the cores
        try:
            with ThreadPoolExecutor(threads or os.cpu_count()) as pool:
                return list(pool.map(each, combinations))
        finally:
            if chosen:
                _stroma.choose_threads(True)
    if threads is not None:
        raise ValueError("a sweep has threads or processes, not both")
    if processes < 1:
        raise ValueError(f"a sweep in {processes} processes: expected 1 or more")
    each = functools.partial(_one_sent, scene, run)
    # processes that start afresh: one that is forked has the engine's threads by name only
    with ProcessPoolExecutor(processes, multiprocessing.get_context("spawn"), _one_thread) as pool:
        return list(pool.map(each, combinations))


def _one_thread() -> None:
    _stroma.choose_threads(False)


def _one(scene: Any, run: Callable[[Simulation], Any], chosen: Dict[str, Any]) -> Run:
    try:
        return Run(chosen, run(load(scene, set=chosen, observers=False)), None)
    except Exception as error:  # noqa: BLE001 pylint: disable=broad-except
        return Run(chosen, None, error)


def _one_sent(scene: Any, run: Callable[[Simulation], Any], chosen: Dict[str, Any]) -> Run:
    """In a process: what cannot be sent back, such as an exception that holds a report, is replaced by a StromaError that names it."""
    made = _one(scene, run, chosen)
    try:
        pickle.loads(pickle.dumps(made))
        return made
    except Exception as reason:  # noqa: BLE001 pylint: disable=broad-except
        if made.error is not None:
            return Run(chosen, None, StromaError(f"{type(made.error).__name__}: {made.error}"))
        return Run(chosen, None, StromaError(f"the result, a {type(made.result).__name__}, cannot be sent from its process ({reason}): expected "
                                             "numbers, arrays, or lists and dictionaries of them"))


def jacobian(function: Callable[[numpy.ndarray], Any], at: Sequence[float], step: float = 1e-4) -> numpy.ndarray:
    """The derivative of an array by parameters, (values, parameters), by central differences of `step` times each parameter (of
    `step` where it is zero)."""
    at = numpy.asarray(at, float)
    if at.ndim != 1 or not numpy.isfinite(at).all():
        raise ValueError(f"parameters {at} are no list of numbers")
    columns = []
    for index, value in enumerate(at):
        h = step * (abs(value) or 1.0)
        ends = []
        for side in (+h, -h):
            moved = at.copy()
            moved[index] += side
            ends.append(numpy.array(function(moved), float).ravel())
        columns.append((ends[0] - ends[1]) / (2 * h))
    return numpy.stack(columns, axis=1)


class Recording(NamedTuple):
    """What a recorded run has of one state."""

    times: numpy.ndarray  #: (instants,) [s]
    x: Optional[numpy.ndarray]  #: positions, (instants, nodes, 3) [m]
    v: Optional[numpy.ndarray]  #: velocities [m/s]
    f: Optional[numpy.ndarray]  #: forces [N]
    unfinished: str  #: why it has no end, or empty


class Table(NamedTuple):
    """What a monitor has written."""

    times: numpy.ndarray  #: (instants,) [s]
    values: numpy.ndarray  #: (instants, columns); of a Monitor (instants, nodes, numbers of each)
    head: List[str]  #: the lines of comment: what the columns are, and their units


def read_monitor(path: Union[str, os.PathLike]) -> Table:
    """A file of a Monitor or an EnergyMonitor."""
    with open(path, encoding="utf-8") as file:
        lines = file.read().splitlines()
    head = [line[1:].strip() for line in lines if line.startswith("#")]
    rows = [line.split() for line in lines if line.strip() and not line.startswith("#")]
    if any(len(row) != len(rows[0]) for row in rows):
        raise ValueError(f"{os.fspath(path)}: rows have different numbers of columns")
    numbers = numpy.array(rows, float).reshape(len(rows), -1)
    times, values = numbers[:, 0] if rows else numpy.zeros(0), numbers[:, 1:]
    nodes = next((line.partition(" of nodes ")[2].split() for line in head if " of nodes " in line), [])
    return Table(times, values.reshape(len(rows), len(nodes), -1) if nodes and rows else values, head)


def read_recording(path: Union[str, os.PathLike], state: Optional[str] = None) -> Recording:
    """A file of WriteState, or that of the state of this path in a folder of `stroma run --record`. Of points."""
    path = os.fspath(path)
    if os.path.isdir(path):
        if state is None:
            files = [name for name in os.listdir(path) if name.endswith(".state.gz")]
            if len(files) != 1:
                have = ", ".join(sorted(name[:-len(".state.gz")] for name in files))
                choice = f"{len(files)} recorded states: name one by its path (there are {have})" if files else "no recorded state"
                raise ValueError(f"{path} has {choice}")
            path = os.path.join(path, files[0])
        else:
            path = os.path.join(path, _stroma.recorded_name(state))
    return Recording(*_stroma.recording(path))
