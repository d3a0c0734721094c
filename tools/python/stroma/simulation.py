# SPDX-License-Identifier: LGPL-2.1-or-later
"""Simulations: a scene that runs."""
import contextlib
import operator
import os
import re
import threading
import warnings
import weakref
from typing import TYPE_CHECKING, Any, Callable, Dict, Iterator, List, Optional, Sequence, Tuple, Union

import numpy

from . import _stroma
from .errors import OutputError, Problem, SceneError, SceneWarning, StepError, StromaError, refusal
from .tree import Node, caller
from .types import Attribute, TypeInfo, nearest, type_info

if TYPE_CHECKING:
    from .linear import Gradient, Modes
    from .mesh import Mesh
    from .pictures import Picture
    from .studies import Recording

StepReport = _stroma.StepReport
RunReport = _stroma.RunReport
_STEPS_TO_JUDGE = 20  # what a look at the shapes costs is then little beside them


def load(scene: Union[str, os.PathLike, Node], set: Optional[Dict[str, Any]] = None, dialect: Optional[str] = None,
         observers: bool = True, quiet: bool = False) -> "Simulation":
    """Loads a scene: a file (.xml, .scn) or a tree. `set` has attributes that are to be others, {"/liver/fem.youngModulus": "12 kPa",
    "dt": 0.005}, and components in the place of others, {"/liver/solver": "BDFOdeSolver order=2"}. `dialect`: "sofa" or "native". `observers=False`: nothing writes files.
    Warnings about it, and later about its runs, are those of Python (SceneWarning), unless it is `quiet`. Throws SceneError with every problem found."""
    overrides = [_override(key, value, whole=True) for key, value in (set or {}).items()]
    if dialect is not None:
        overrides.append(("/", "dialect", dialect))
    if not isinstance(scene, (str, os.PathLike, Node)):
        raise TypeError(f"a scene is a file or a stroma.Node, not {type(scene).__name__}")
    if not isinstance(scene, Node) and os.fspath(scene).endswith(".py"):
        raise refusal(f"{os.fspath(scene)} is a scene in Python", "a file of XML, or a tree that the program makes",
                      "`stroma run` plays it where it has createScene(root)", caller())
    if isinstance(scene, Node):
        engine = _stroma.Engine.of_tree(scene._tuple(), scene.where[0] or "scene.py", overrides, observers)
    else:
        engine = _stroma.Engine.of_file(os.fspath(scene), overrides, observers)
    simulation = Simulation(engine, quiet)
    simulation._warn([problem.text.replace(": warning: ", ": ", 1) for problem in simulation.problems if problem.severity == "warning"])
    return simulation


def _override(key: str, value: Any, whole: bool = False) -> tuple:
    path, dot, attribute = key.rpartition(".")
    if whole and not dot and "/" in key and isinstance(value, str) and value.strip()[:1].isupper():
        return (key if key.startswith("/") else "/" + key, "", value)
    if not dot and "/" in key:
        raise refusal(f"'{key}' names no attribute", "a path and an attribute, as /liver/fem.youngModulus", where=caller())
    if not attribute:
        raise refusal(f"'{key}' names no attribute", "a path and an attribute, as /liver/fem.youngModulus", where=caller())
    path = path or "/"
    return (path if path.startswith("/") else "/" + path, attribute, value)


class Token:
    """A function that is called; remove() ends that."""

    def __init__(self, functions: list, function: Callable):
        self._functions, self._function = functions, function

    def remove(self) -> None:
        if self._function in self._functions:
            self._functions.remove(self._function)


class Watching(Token):
    """An observer that looks on; remove() ends that, and it sees its end."""

    def __init__(self, simulation: "Simulation", step: Callable, end: Callable):
        super().__init__(simulation._end, step)
        self._simulation, self._last = weakref.ref(simulation), end

    def remove(self) -> None:
        super().remove()
        simulation = self._simulation()
        if simulation is not None and self._last in simulation._finish:
            simulation._finish.remove(self._last)
            self._last(simulation)


class Observer:
    """Looks at a run: begin(simulation) when it is added, step(simulation) after steps, end(simulation) when the run is finished.
    It reads, and changes nothing. Derive from it, override what is of use, and call simulation.add_observer()."""

    every = 1  #: steps from one call to the next

    def begin(self, simulation: "Simulation") -> None:
        """The start, or the instant at which it was added."""

    def step(self, simulation: "Simulation") -> None:
        """After a step."""

    def end(self, simulation: "Simulation") -> None:
        """finish() was called."""


class Simulation:
    """A scene that runs. One thread at a time uses it; several simulations run in several threads."""

    def __init__(self, engine: Any, quiet: bool = False):
        self._engine = engine
        self.quiet = quiet  #: nothing is warned of
        self._told: set = set()  # of runs, but for the numbers
        self._begin: List[Callable] = []
        self._end: List[Callable] = []
        self._finish: List[Callable] = []
        # states and components hold the simulation, so it does not hold them: it ends with the last name that leads to it
        self._found_states: Optional[Dict[str, Any]] = None
        self._facts: Optional[Dict[str, tuple]] = None
        self._states: "weakref.WeakValueDictionary[str, State]" = weakref.WeakValueDictionary()
        self._parts: "weakref.WeakValueDictionary[str, LiveComponent]" = weakref.WeakValueDictionary()
        self.stop_reason = ""  #: what stop() was given in the last run

    # ---- stepping ----
    def step(self, dt: Optional[float] = None, check: bool = True) -> StepReport:
        """One step, of the scene's dt or of another one, which stays. Throws StepError when it has no result: the states are
        then those before it. `check=False`: the report says so."""
        if dt is not None and float(dt) != self._engine.dt:
            self.dt = float(dt)
        return self._run(1, None, check).last

    def run(self, steps: Optional[int] = None, until: Optional[float] = None, check: bool = True) -> RunReport:
        """Steps until a number of steps, or a time [s], whichever comes first. Other threads go on meanwhile, and Ctrl-C ends
        it. Throws StepError as step() does."""
        if steps is None and until is None:
            raise ValueError("run() needs steps=..., until=... or both")
        if steps is not None and not hasattr(steps, "__index__"):
            raise TypeError(f"run() makes {steps!r} steps: expected a whole number, or until=... for a time [s]")
        if steps is not None and operator.index(steps) < 0:
            raise ValueError(f"run() makes {steps} steps: expected 0 or more")
        if until is not None and not float(until) >= self.time:
            raise ValueError(f"run() until {until}: expected a time from {self.time:g} s on")
        report = self._run(steps, until, check)
        if not self.quiet:
            self._warn_of_run(report)
        return report

    def _warn_of_run(self, report: RunReport) -> None:
        """Once of each kind: runs of a few steps, as of an episode, follow each other by the thousand, and do not look for doubts."""
        found = report.warnings + (self._engine.doubts if report.steps >= _STEPS_TO_JUDGE else [])
        # numbers of figures, not of names as /liver2/fem
        news = {re.sub(r"(?<![\w/.])[-+]?\d[\d.]*(e[-+]?\d+)?", "#", text): text for text in found}
        self._warn([text for kind, text in news.items() if kind not in self._told], 4)
        self._told.update(news)

    def _warn(self, texts: List[str], level: int = 3) -> None:
        if texts and not self.quiet:
            warnings.warn("\n".join(texts), SceneWarning, stacklevel=level)

    def _run(self, steps, until, check):
        is_main = threading.current_thread() is threading.main_thread()
        self.stop_reason = ""
        report = self._engine.run(steps, until, self._begin, self._end, self, is_main)
        if check and report.end not in ("done", "stopped"):
            if report.end == "output failed":
                raise OutputError(report.reason)
            raise StepError(report.reason or report.last.reason, report)
        return report

    def stop(self, reason: str = "") -> None:
        """In a function that a run calls: the run ends with its present step. From another thread: request_stop()."""
        self.stop_reason = reason
        self._engine.end_after_step()

    def request_stop(self) -> None:
        """From any thread: the run ends at once; a step under way is given up, and the state is that before it."""
        self._engine.request_stop()

    def on_step_begin(self, function: Callable[["Simulation"], Any]) -> Token:
        """`function(simulation)` is called before each step. What it throws ends the run, and comes out of it."""
        self._begin.append(function)
        return Token(self._begin, function)

    def on_step_end(self, function: Callable[["Simulation"], Any]) -> Token:
        """`function(simulation)` is called after each step. What it throws ends the run; the step stands."""
        self._end.append(function)
        return Token(self._end, function)

    def doubts(self) -> List[str]:
        """Why the present shapes may be no result, as `stroma run` says it at its end: elements inside out, strains beyond a law,
        energy from nowhere, a mesh that has folded. run() warns of it."""
        return self._engine.doubts

    def reset(self) -> None:
        """Back to the start, to the bit. Attributes that were set stay, forces that were added end."""
        self._engine.reset()

    def add_observer(self, observer: Observer) -> Token:
        """From now on it looks on; remove() of what is returned lets it see its end."""
        if not isinstance(observer, Observer):
            raise TypeError(f"an observer is a stroma.Observer, not {type(observer).__name__}")
        if operator.index(observer.every) < 1:
            raise ValueError(f"an observer looks every {observer.every} steps: expected 1 or more")

        def step(simulation: "Simulation") -> None:
            if simulation.steps % observer.every == 0:
                observer.step(simulation)
        observer.begin(self)
        self._end.append(step)
        self._finish.append(observer.end)
        return Watching(self, step, observer.end)

    def finish(self) -> None:
        """Observers see the end: their files are whole."""
        self._engine.finish()
        for function in list(self._finish):
            function(self)

    # ---- time ----
    @property
    def time(self) -> float:
        """[s]"""
        return self._engine.time

    @property
    def steps(self) -> int:
        """How many have been made."""
        return self._engine.steps

    @property
    def dt(self) -> float:
        """[s]"""
        return self._engine.dt

    @dt.setter
    def dt(self, value: float) -> None:
        self._engine.set("/", "dt", value)

    @property
    def gravity(self) -> numpy.ndarray:
        """Of the outermost node [m/s^2]."""
        return self._engine.node_value("/", "gravity")

    @gravity.setter
    def gravity(self, value: Sequence[float]) -> None:
        self._engine.set("/", "gravity", value)

    # ---- parts ----
    def components(self) -> List["LiveComponent"]:
        """All, in the order of the scene."""
        return [self._live(path) for path in self._all_facts()]

    def _all_facts(self) -> Dict[str, tuple]:
        if self._facts is None:
            self._facts = {facts[0]: facts for facts in self._engine.components()}
        return self._facts

    def _live(self, path: str) -> "LiveComponent":
        found = self._parts.get(path)
        if found is None:
            found = self._parts[path] = LiveComponent(self, self._all_facts()[path])
        return found

    def component(self, path: str) -> "LiveComponent":
        wanted = self._absolute(path)
        if wanted not in self._all_facts():
            raise refusal(f"the scene has no component {path}", "a path of the scene", self._nearest(wanted, list(self._all_facts())),
                          caller())
        return self._live(wanted)

    def node(self, path: str = "/") -> "LiveNode":
        wanted = self._absolute(path)
        nodes = self._engine.nodes()
        for found, name in nodes:
            if found == wanted or (found == "/" and wanted == "/" + name):
                return LiveNode(self, found, name)
        raise refusal(f"the scene has no node {path}", "a path of the scene", self._nearest(wanted, [one for one, _ in nodes]), caller())

    @staticmethod
    def _nearest(wanted: str, paths: List[str]) -> str:
        """A path that ends in what was asked for, as "fem" for /beam/fem, or one that is like it."""
        return next((path for path in paths if path.endswith(wanted)), "") or nearest(wanted, paths)

    @staticmethod
    def _absolute(path: str) -> str:
        if not isinstance(path, str):
            raise TypeError(f"a path is a text, as \"/liver/fem\", not {type(path).__name__}")
        return path if path.startswith("/") else "/" + path

    def __getitem__(self, path: str) -> Union["LiveComponent", "LiveNode"]:
        if isinstance(path, str) and path in self._all_facts():
            return self._live(path)
        try:
            return self.component(path)
        except SceneError as error:
            try:
                return self.node(path)
            except SceneError as of_node:
                raise (error if error.nearest else of_node) from None

    def states(self) -> List["State"]:
        """Those that move, in the order of the scene."""
        return [self._state_at(path) for path in self._all_states()]

    def _all_states(self) -> Dict[str, Any]:
        if self._found_states is None:
            self._found_states = {state.path: state for state in _stroma.states_of(self._engine)}
        return self._found_states

    def _state_at(self, path: str) -> "State":
        found = self._states.get(path)
        if found is None:
            found = self._states[path] = State(self, self._all_states()[path])
        return found

    def state(self, path: Optional[str] = None) -> "State":
        """That of a path, or of the node of this path; without one, the only one of the scene."""
        states = self._all_states()
        if path is None:
            if len(states) == 1:
                return self._state_at(next(iter(states)))
            raise refusal(f"the scene has {len(states)} states", "the path of one", next(iter(states), ""), caller())
        wanted = self._absolute(path)
        if wanted in states:
            return self._state_at(wanted)
        inside = [name for name in states if name.rpartition("/")[0] == wanted.rstrip("/")]
        if len(inside) == 1:
            return self._state_at(inside[0])
        raise refusal(f"no state that moves is called {path}", "the path of a state", self._nearest(wanted, list(states)), caller())

    def set(self, attribute: str, value: Any) -> List[Problem]:
        """set("/liver/fem.youngModulus", "12 kPa"): as the attribute of a component that runs. Returns warnings and notes."""
        path, name, value = _override(attribute, value)
        return [Problem(*problem) for problem in self._engine.set(path, name, value)]

    # ---- what is known of it ----
    @property
    def problems(self) -> List[Problem]:
        """Warnings and notes of the scene."""
        return [Problem(*problem) for problem in self._engine.problems()]

    @property
    def no_effect(self) -> List[str]:
        """What was accepted and has no effect."""
        return self._engine.no_effect()

    @property
    def plan(self) -> List[str]:
        """What runs each step, and what was left out and why: the lines of `stroma explain`."""
        return self._engine.plan()

    @property
    def scene_file(self) -> str:
        return self._engine.scene_file

    @property
    def hash(self) -> int:
        """64 bits of all positions and velocities: that of `stroma run --json`."""
        return self._engine.hash()

    def energies(self) -> Dict[str, float]:
        """kinetic, elastic and gravity [J]."""
        return self._engine.energies()

    def request_forces(self) -> None:
        """From now on state.f has the net force, which costs one more evaluation per step."""
        _stroma.request_forces(self._engine)

    def actions(self) -> str:
        """What was done to the run, as `stroma run --replay` reads it."""
        return self._engine.actions()

    # ---- looking at it ----
    def view(self, host: str = "127.0.0.1", port: int = 0, fps: float = 60, at_once: bool = False, paused: bool = False,
             browser: bool = True, framed_by: Optional[Sequence[str]] = None) -> str:
        """Shows it live in the browser, as `stroma view`, until Ctrl-C: it runs, is stopped, pulled at and changed there. It begins
        when a page is there to see it, or `at_once`. Functions of on_step_begin() and on_step_end() are called. A notebook of Jupyter
        on this machine shows it below the cell, in a frame; `framed_by` names other pages that may, as http://localhost:8888, or none
        of them. Returns why the run has ended by itself, or nothing."""
        from . import notebook
        origins = list(notebook.origins(host) if framed_by is None else framed_by)

        def opened(address: str) -> None:
            print(address, flush=True)
            if not notebook.show(address, origins) and browser:
                import webbrowser
                webbrowser.open(address)
        return _stroma.serve(self._engine, host, port, fps, at_once, paused, origins, opened, self._begin, self._end, self)

    def page(self, file: Union[str, os.PathLike], steps: int = 100, every: int = 1, fields: Sequence[str] = (),
             inside: bool = False) -> "Page":
        """Makes steps, with the functions that are called before and after each, and writes them as an HTML file that plays them
        without a server; in Jupyter it is shown."""
        report = _stroma.write_page(self._engine, os.fspath(file), steps, every, list(fields), inside, self._begin, self._end, self)
        if report.end != "done":
            raise StepError(report.reason, report)
        return Page(os.fspath(file))

    def picture(self, file: Union[str, os.PathLike, None] = None, **look: Any) -> "Picture":
        """Draws the present state; Jupyter shows what is returned, and `file` has it as PNG. How it looks: `field`, as "vonMises", and its
        `range` (low, high), `colours`, `views` (names as "front", or (azimuth, elevation) in degrees), `size` (width, height) in pixels,
        `edges`, `flat`, `ghost`, `shaded`, `cut` ("x", 0.02), `exaggerate`, `hide` and `frame` (paths of nodes), `title`,
        `transparent`, `legend`, `bare`: as the options of `stroma picture`."""
        from .pictures import picture_of
        made = picture_of(self, look)
        if file is not None:
            made.save(file)
        return made

    def film(self, file: Union[str, os.PathLike, None] = None, steps: Optional[int] = None, until: Optional[float] = None, every: int = 1,
             fps: float = 20, **look: Any) -> "Picture":
        """Makes steps as run() does and draws the first state and then one every so many steps: an animated PNG. It looks as picture() says."""
        from .pictures import film_of
        made = film_of(self, steps, until, every, fps, look)
        if file is not None:
            made.save(file)
        return made

    def record(self, steps: Optional[int] = None, until: Optional[float] = None, every: int = 1,
               state: Union["State", str, None] = None) -> "Recording":
        """Makes steps as run() does and keeps the first state and then one every so many steps: times (instants,) [s], x and v
        (instants, nodes, 3) [m, m/s], of frames 7 and 6 numbers. Of one state, by its path; without one, of the only one."""
        from .studies import Recording
        seen = state if isinstance(state, State) else self.state(state)
        if operator.index(every) < 1:
            raise ValueError(f"record() keeps a state every {every} steps: expected 1 or more")
        first, kept = self.steps, []

        def keep(simulation: "Simulation") -> None:
            if (simulation.steps - first) % every == 0:
                kept.append((simulation.time, numpy.array(seen.x), numpy.array(seen.v)))
        keep(self)
        token = self.on_step_end(keep)
        try:
            self.run(steps, until)
        finally:
            token.remove()
        times, x, v = zip(*kept)
        if len({len(each) for each in x}) > 1:
            raise StromaError(f"{seen.path} got another number of nodes in the run: its states make no array")
        return Recording(numpy.array(times), numpy.stack(x), numpy.stack(v), None, "")

    # ---- memory ----
    def checkpoint(self) -> bytes:
        """All that the run remembers. Restored in the same scene, it goes on with the same bits."""
        return self._engine.checkpoint()

    def restore(self, checkpoint: bytes) -> List[str]:
        """Returns notes, as of another build that wrote it."""
        return self._engine.restore(bytes(checkpoint))

    def copy(self) -> "Simulation":
        """The same scene at the same moment, on its own from then on. Functions are not called by it, and it writes no files."""
        return Simulation(self._engine.copy(), self.quiet)

    __copy__ = copy

    def __deepcopy__(self, memo: dict) -> "Simulation":
        return self.copy()

    def __reduce__(self):
        raise TypeError("a simulation cannot be pickled: keep its checkpoint() and load the scene again")

    # ---- forces from outside ----
    def add_force(self, state: Union["State", str], nodes: Union[int, Sequence[int]], force: Any = (0, 0, 0),
                  targets: Sequence[Sequence[float]] = (), stiffness: float = 0, damping: float = 0) -> "Force":
        """A force [N] on each of these nodes, the same of three numbers or (nodes, 3) one for each, or a pull of each to its target [m] by
        a spring [N/m, N s/m], from the next step on. For forces on hundreds of nodes that change in each step a ConstantForceField, whose
        `forces` may change, takes less time."""
        path = state.path if isinstance(state, State) else self.state(state).path
        return Force(self, path, nodes, force, targets, stiffness, damping)

    # ---- matrices ----
    def matrix(self, kind: str = "stiffness", constrained: bool = False, integrator: str = ""):
        """"stiffness" K = dF/dx, "mass" M or "damping" C = dF/dv at the present state, as scipy.sparse.bsr_matrix of 3x3 blocks,
        three rows for each row of a state. `constrained`: P A P + (I - P), with the projector P of what is held. It is computed
        in a copy: no bit of the run changes."""
        from scipy.sparse import bsr_matrix, identity

        def of(what: str):
            blocks, columns, starts = _stroma.matrix_of(self._engine, what, constrained, integrator)
            return bsr_matrix((blocks, columns, starts), shape=(3 * (len(starts) - 1),) * 2)

        found = of(kind)
        if not constrained:
            return found
        held = of("-held-")  # I - P; what `found` has there is in the size of its other numbers
        free = identity(held.shape[0], format="bsr") - held
        return bsr_matrix(free @ found @ free + held, blocksize=(3, 3))

    def matrix_of(self, component: Union["LiveComponent", str], whole: bool = False):
        """K = dF/dx of a force field or M of a mass alone, at the present state, as scipy.sparse.bsr_matrix of the rows of its
        state; `whole`: of all rows of its integrator. Computed in a copy."""
        from scipy.sparse import bsr_matrix
        path = component.path if isinstance(component, LiveComponent) else self.component(component).path
        (blocks, columns, starts), first, count = _stroma.matrix_of_part(self._engine, path)
        size = 3 * (len(starts) - 1)
        found = bsr_matrix((blocks, columns, starts), shape=(size, size))
        own = slice(3 * first, 3 * (first + count))
        return found if whole else found.tocsr()[own, own].tobsr((3, 3))

    def solve(self, b: Any, mass: float = 0, damping: float = 0, stiffness: float = -1, integrator: str = "") -> numpy.ndarray:
        """x of (mass M + damping C + stiffness K) x = b, with what is held, by the linear solver of the scene: (rows, 3), as force()
        has them. solve(force()) is how far a linear body goes under its forces. In a copy: no bit of the run changes."""
        return _stroma.solution_of(self._engine, b, float(mass), float(damping), float(stiffness), integrator)

    def force(self, integrator: str = "") -> numpy.ndarray:
        """The net force at the present state, (rows, 3) [N], gravity included; computed in a copy."""
        return _stroma.force_of(self._engine, integrator)

    def free_directions(self, integrator: str = ""):
        """T, a matrix of scipy.sparse, (3 rows, directions), whose columns are what may move: T.T @ K @ T is K of what is free, and
        x = T @ q is no movement of what is held. Where nodes are held along the axes they are those of the identity."""
        from scipy.sparse import bsr_matrix

        from .linear import free_directions
        blocks, columns, starts = _stroma.matrix_of(self._engine, "-held-", True, integrator)
        return free_directions(bsr_matrix((blocks, columns, starts), shape=(3 * (len(starts) - 1),) * 2))

    def modes(self, count: int = 6, integrator: str = "") -> "Modes":
        """The lowest modes of vibration about the present state: frequencies (count,) [Hz] and shapes (count, rows, 3), of mass 1. What
        is held stays; Lagrangian constraints and damping are no part of it."""
        from .linear import modes_of
        return modes_of(self, operator.index(count), integrator)

    def gradient(self, of: Any, parameters: Union[str, Sequence[str]] = (), step: float = 1e-4, integrator: str = "") -> "Gradient":
        """The derivative of a number J(x) at an equilibrium, as a StaticSolver finds it, by the adjoint method. `of`: dJ/dx, (rows, 3);
        `parameters`: attributes that may change in a run, as "/beam/fem.youngModulus", "gravity". Of each a number, or an array of the
        attribute's shape; a number for each cell is as cheap as a few. `forces`: the derivative by a force on each node. dF/dp is taken by
        central differences of `step` times the parameter. Warns where the present state is no equilibrium. Computed in a copy."""
        from .linear import gradient_of
        return gradient_of(self, of, parameters, step, integrator)

    def rows(self, integrator: str = "") -> Dict[str, slice]:
        """Which rows of force() are of which state; times three, of matrix()."""
        for path, states in _stroma.systems_of(self._engine):
            if integrator in ("", path):
                return {state: slice(first, first + count) for state, first, count in states}
        raise refusal(f"{integrator} is no integrator", "the path of an integrator")

    def __repr__(self) -> str:
        return f"<simulation of {self.scene_file} at {self.time:g} s, step {self.steps}>"


class Page:
    """An HTML file that plays a run; Jupyter shows it."""

    def __init__(self, file: str):
        self.file = file

    def _repr_html_(self) -> str:
        import html
        with open(self.file, encoding="utf-8") as text:
            return f'<iframe srcdoc="{html.escape(text.read())}" width="100%" height="480" frameborder="0"></iframe>'

    def __repr__(self) -> str:
        return f"<page {self.file}>"


class LiveComponent:
    """A component of a simulation. What its attributes hold can be read; what may change while it runs can be set."""

    _fixed = frozenset(("simulation", "path", "type", "name", "role", "where", "_names"))
    simulation: "Simulation"
    path: str
    type: str
    name: str
    role: str
    where: Tuple[str, int]

    def __init__(self, simulation: Simulation, facts: tuple):
        for key, value in zip(("simulation", "path", "type", "name", "role", "where", "_names"),
                              (simulation, *facts[:4], (facts[4], facts[5]), None)):
            object.__setattr__(self, key, value)

    def get(self, attribute: str, found: bool = False) -> Any:
        return self.simulation._engine.get(self.path, attribute, found)

    def set(self, attribute: str, value: Any) -> List[Problem]:
        """From the next step on. Throws SceneError with the reason where it cannot change in a run."""
        return [Problem(*problem) for problem in self.simulation._engine.set(self.path, attribute, value)]

    @property
    def attributes(self) -> List[str]:
        return self.simulation._engine.attributes(self.path)

    def info(self, attribute: str) -> Attribute:
        return Attribute(self.simulation._engine.info(self.path, attribute))

    @property
    def type_info(self) -> Optional[TypeInfo]:
        return type_info(self.type)

    @property
    def fields(self) -> List[str]:
        """Names of its fields of cells, as vonMises."""
        return self.simulation._engine.cell_fields(self.path)

    def field(self, name: str) -> numpy.ndarray:
        """A number for each cell, (n,); six of a symmetric tensor as stress, (n, 6): xx yy zz xy yz zx; three principal values,
        (n, 3), the largest first. At the present positions; stress is Cauchy's, in the axes of the world."""
        return self.simulation._engine.cell_field(self.path, name)

    def __getattr__(self, attribute: str) -> Any:
        if attribute.startswith("__"):
            raise AttributeError(attribute)
        try:
            return self.get(attribute)
        except SceneError as error:
            from .tree import _missing
            raise _missing(error, attribute) from None

    def __setattr__(self, attribute: str, value: Any) -> None:
        if attribute in self._fixed or isinstance(getattr(type(self), attribute, None), property):
            raise AttributeError(f"{attribute} cannot be set")
        told = self.set(attribute, value)
        self.simulation._warn([problem.text.replace("warning: ", "", 1) for problem in told if problem.severity == "warning"])

    def __dir__(self) -> List[str]:
        return sorted(set(super().__dir__()) | set(self.attributes))

    def __repr__(self) -> str:
        return f"<{self.type} {self.path}>"


class LiveNode:
    """A node of a simulation: gravity may be set, and dt of the outermost one."""

    _fixed = frozenset(("simulation", "path", "name"))
    simulation: "Simulation"
    path: str
    name: str

    def __init__(self, simulation: Simulation, path: str, name: str):
        for key, value in (("simulation", simulation), ("path", path), ("name", name)):
            object.__setattr__(self, key, value)

    def get(self, attribute: str) -> Any:
        return self.simulation._engine.node_value(self.path, attribute)

    def set(self, attribute: str, value: Any) -> List[Problem]:
        return [Problem(*problem) for problem in self.simulation._engine.set(self.path, attribute, value)]

    gravity = property(lambda self: self.get("gravity"), lambda self, value: self.set("gravity", value), doc="[m/s^2]")
    dt = property(lambda self: self.get("dt"), lambda self, value: self.set("dt", value), doc="[s]")

    @property
    def components(self) -> List[LiveComponent]:
        return [one for one in self.simulation.components() if (one.path.rpartition("/")[0] or "/") == self.path]

    @property
    def children(self) -> List["LiveNode"]:
        return [LiveNode(self.simulation, path, name) for path, name in self.simulation._engine.nodes()
                if path != "/" and (path.rpartition("/")[0] or "/") == self.path]

    def __getitem__(self, path: str) -> Union[LiveComponent, "LiveNode"]:
        return self.simulation["" if path.startswith("/") else ("" if self.path == "/" else self.path) + "/" + path]

    def __setattr__(self, attribute: str, value: Any) -> None:
        if attribute not in ("gravity", "dt"):
            raise refusal(f"a node has no attribute '{attribute}' that may change while the scene runs", "gravity or dt",
                          nearest(attribute, ["gravity", "dt"]))
        self.set(attribute, value)

    def __repr__(self) -> str:
        return f"<node {self.path}>"


class Edited:
    """Copies of positions and velocities, to be written: State.edit()."""

    def __init__(self, x: numpy.ndarray, v: numpy.ndarray):
        self.x, self.v = x, v


class State:
    """The nodes of a body. x, v and f are read-only views of the engine's memory, (nodes, 3), which follow the steps; they keep
    the simulation alive. Frames are copied, (nodes, 7) and (nodes, 6): centre and quaternion x y z w, linear and angular."""

    def __init__(self, simulation: Simulation, state: Any):
        self.simulation, self._state = simulation, state
        self.path: str = state.path
        self.kind: str = state.kind  #: "points", "frames" or "numbers"

    @property
    def nodes(self) -> int:
        """How many there are; others, and x a copy, where a mesh has changed in the run."""
        return self._state.nodes

    @property
    def size(self) -> int:
        return self.nodes

    @property
    def x(self) -> numpy.ndarray:
        """Positions [m]."""
        return self._state.x

    @x.setter
    def x(self, value: Any) -> None:
        self.set(x=value)

    @property
    def v(self) -> numpy.ndarray:
        """Velocities [m/s]."""
        return self._state.v

    @v.setter
    def v(self, value: Any) -> None:
        self.set(v=value)

    @property
    def f(self) -> numpy.ndarray:
        """The net force of the present state [N], after simulation.request_forces(): that at the end of the last step. Before the
        first step, after reset(), and where set() has moved the body, a copy of the simulation computes it."""
        return self._state.f

    @property
    def constraint_forces(self) -> numpy.ndarray:
        """What Lagrangian constraints did in the last step, contacts with friction among them [N], a copy; with the forces on all that
        follows this state."""
        return self._state.constraint_forces

    @property
    def rest(self) -> numpy.ndarray:
        """The rest shape [m], a copy."""
        return self._state.rest

    @property
    def start(self) -> numpy.ndarray:
        """The positions before the first step [m], a copy."""
        return self._state.start

    @property
    def displacement(self) -> numpy.ndarray:
        """How far each node is from where it was before the first step [m], (nodes, 3), a copy; of frames how far their centres are."""
        return self.x[:, :3] - self.start[:, :3]

    def set(self, x: Any = None, v: Any = None, nodes: Optional[Sequence[int]] = None) -> int:
        """Writes positions or velocities between two steps, of all nodes or of those named. What constraints hold stays where it
        is, and mapped states follow; integrators begin anew, histories keep what they remember. Returns how many nodes
        constraints kept from where they were to be."""
        def whole(present: numpy.ndarray, given: Any) -> Any:
            if given is None or nodes is None:
                return given
            values = numpy.array(present)
            values[numpy.asarray(nodes)] = given
            return values
        return self._state.set(whole(self.x, x), whole(self.v, v))

    @contextlib.contextmanager
    def edit(self) -> Iterator["Edited"]:
        """with state.edit() as edited: edited.x[:, 2] += 0.01 - copies that may be written; what has changed is set at the end."""
        edited = Edited(numpy.array(self.x), numpy.array(self.v))
        yield edited
        changed = [None if numpy.array_equal(new, old) else new for new, old in ((edited.x, self.x), (edited.v, self.v))]
        if any(values is not None for values in changed):
            self.set(*changed)

    def mesh(self) -> Optional["Mesh"]:
        """The mesh of its cells; None where there is none."""
        from .mesh import Mesh
        found = self._state.mesh()
        return None if found is None else Mesh(self, *found)

    def __len__(self) -> int:
        return self.nodes

    def __repr__(self) -> str:
        return f"<state {self.path}: {self.nodes} {self.kind}>"


class Force:
    """A force from outside that acts until remove(), or until the simulation is reset or restored to an instant without it."""

    def __init__(self, simulation: Simulation, state: str, nodes, force, targets, stiffness, damping):
        self._simulation, self.state = simulation, state
        self._given: Dict[str, Any] = dict(nodes=nodes, force=force, targets=targets, stiffness=stiffness, damping=damping)
        self._numbers: List[int] = []
        for arguments in self._arguments():
            try:
                self._numbers.append(simulation._engine.add_input(state, *arguments))
            except Exception:
                self.remove()
                raise

    def _arguments(self) -> List[tuple]:
        """Of each of the engine's inputs: one, or where each node has a force of its own one for each."""
        given = self._given
        if numpy.asarray(given["nodes"]).dtype == bool:
            raise TypeError("a force acts on nodes by their numbers, not on a mask: expected numbers, as numpy.flatnonzero(mask)")
        nodes = [operator.index(node) for node in numpy.atleast_1d(given["nodes"]).tolist()] if numpy.size(given["nodes"]) else []
        force, targets = numpy.array(given["force"], float), [[float(c) for c in target] for target in given["targets"]]
        pull = float(given["stiffness"]), float(given["damping"])
        if force.shape == (3,):
            return [(nodes, force.tolist(), targets, *pull)]
        if force.shape == (len(nodes), 3) and nodes:
            if targets and len(targets) != len(nodes):
                raise ValueError(f"{len(targets)} targets for {len(nodes)} nodes: expected one for each")
            return [([node], one.tolist(), targets[i:i + 1], *pull) for i, (node, one) in enumerate(zip(nodes, force))]
        given = str(force.size) if force.ndim < 2 else f"an array {force.shape}"
        raise ValueError(f"a force has 3 numbers, not {given}, or an array ({len(nodes)}, 3) with some for each node. It acts on the centre of a "
                         "frame, and a ConstantForceField, whose forces may change in a run, has torques")

    def change(self, **given: Any) -> None:
        """nodes, force, targets, stiffness or damping are others from the next step on."""
        unknown = [name for name in given if name not in self._given]
        if unknown:
            raise TypeError(f"a force has no {unknown[0]}: expected nodes, force, targets, stiffness or damping")
        before, self._given = self._given, {**self._given, **given}
        engine = self._simulation._engine
        try:
            arguments = self._arguments()
            if len(arguments) != len(self._numbers):
                raise ValueError(f"{len(arguments)} forces in the place of {len(self._numbers)}: remove() this one and add another")
            for number, each in zip(self._numbers, arguments):
                engine.change_input(number, self.state, *each)
        except Exception:
            self._given = before
            if len(self._numbers) > 1:
                for number, each in zip(self._numbers, self._arguments()):
                    engine.change_input(number, self.state, *each)
            raise

    def remove(self) -> None:
        for number in self._numbers:
            self._simulation._engine.remove_input(number)
