# SPDX-License-Identifier: LGPL-2.1-or-later
"""A scene as it runs: the engine under a tree of nodes."""
import gc
import re
import weakref

import numpy as np
import stroma
from stroma import _stroma

from . import _carving, _equations, _events, _messages, _previews, _values
from ._contacts import rows_of
from ._data import Data
from ._drawn import Drawing
from ._mirror import Mirror
from ._objects import DataEngine, Object, Unavailable

#: values of a state that steps change
_STATE = {"position", "velocity", "rest_position", "force", "free_position", "free_velocity", "reset_position", "reset_velocity",
          "lambda"}

_NUMBER = re.compile(r"[-+]?\d[\d.]*(e[-+]?\d+)?")

#: data of force fields that are fields of cells here; of nodes they are means over the cells around
_FIELDS = {"vonMisesPerElement": "vonMises", "vonMisesPerNode": "vonMises"}

#: attributes that say the same in several ways
_ONE_OF = {"ConstantForceField": ("forces", "force", "totalForce")}

#: what sweeps over constraints take of a constraint solver
_OF_SWEEPS = {"maxIterations", "maxIt", "tolerance", "scaleTolerance", "allVerified", "sor", "regularizationTerm", "resolutionMethod"}
#: their methods by SOFA's numbers
_METHODS = ("ProjectedGaussSeidel", "UnbuiltGaussSeidel", "NonsmoothNonlinearConjugateGradient")

_SPRINGS_TO_REST = "RestShapeSpringsForceField"
#: force fields that read the rest positions in every step
_READS_REST = {"BeamHookeLawForceField", "BeamHookeLawForceFieldRigid"}


# ---- a scene that runs ----

class WrongShape(ValueError, IndexError):
    """An array of other rows than the state has."""


def _as_rows(thing, name, numbers, shape):
    if numbers.size != shape[0] * shape[1]:
        raise WrongShape(f"{thing._s_place()}.{name}: {numbers.size} numbers for {shape[0]} rows of {shape[1]}")
    return numbers.reshape(shape)


class TreeChanged(RuntimeError):
    """What takes a new simulation."""


_alive = weakref.WeakSet()


class Engine:
    """The simulation of a tree. `simulation`: given by who loads it (a command), else it is loaded here."""

    def __init__(self, root, simulation=None, mirror=None):
        if len(_alive) >= 4:  # of trees that nobody has any more: they are rings, and hold large simulations
            gc.collect()
        _alive.add(self)
        self.root, self._s_given = root, simulation is not None
        self._restart, self._remade, self.steps = False, False, 0
        self._pushed, self._last_dt, self._told = {}, 0.0, set()
        self._has_other_meshes = False  # than the tree says
        self._stood = {}  # states that nothing moves and the scene has put elsewhere: what it wrote of them at first, and their start
        self._asleep = {}  # positions and velocities of states in nodes that are switched off, which go on from there
        self.inertias = {}  # of frames that answer by themselves, where the last step began
        self._placed, self._places = None, []  # states that are written to while the scene is told that it is initialised; their start
        if simulation is None:
            mirror = Mirror(root)
            simulation = load(root, mirror)
        self._watches = _equations.are_wanted()
        self._take(simulation, mirror)
        self._dt = float(simulation.dt)

    def tell(self):
        """What was found when the scene was loaded, and was not told before."""
        self._tell(() if self._s_given else self.sim.problems)

    def _tell(self, problems):
        """Each once of a component, whatever numbers are in it: a controller may change one in each step."""
        known = set(self._told)
        for each in problems:
            key = each.path, _NUMBER.sub("#", str(each.message))
            if each.severity == "warning" and key not in known:
                self._told.add(key)
                _messages.warn(str(each.text).replace(": warning: ", ": ", 1))

    def _take(self, simulation, mirror):
        self._mesh_changes = simulation._engine.mesh_changes
        self.sim, self.mirror, self._drawing, self._solved = simulation, mirror, None, {}
        self._tells_gradients = self._watches or _equations.asks_for_gradients(_events.listeners(self.root))
        if self._tells_gradients:
            simulation._engine.watch_solves(self._watches)
        self.has_carving = bool(_carving.managers(self.root))
        self._components, self._attributes, self._states, self._rest = {}, {}, {}, {}
        self._waiting = set()  # data, by id, that have a value which the next simulation takes
        for key, thing in mirror.things.items():
            if not isinstance(thing, Object):
                continue
            component = _found(simulation.component, mirror.paths[key])
            if component is None:
                continue
            self._components[key] = component
            if thing._s_facts.role == "mechanical state":
                state = _found(simulation.state, mirror.paths[key])
                if state is not None:
                    self._states[key] = state
        self._pushed = {id(data): source._s_stamp for data, source in mirror.dependents}

    # ---- values ----
    def knows(self, thing, data):
        if id(thing) in self._asleep and data._s_name in ("position", "velocity"):
            return True
        component = self._components.get(id(thing))
        if component is None or id(data) in self._waiting:
            return False
        if id(thing) in self._states and (data._s_name in _STATE or (data._s_name == "constraint" and self._tells_gradients)):
            return True
        if data._s_name in _FIELDS:
            return _FIELDS[data._s_name] in component.fields
        names = self._attributes.get(id(thing))
        if names is None:  # the dialect may have put another component in its place
            names = self._attributes[id(thing)] = frozenset(component.attributes)
        return data._s_name in names

    def read(self, thing, data):
        if id(thing) in self._asleep:
            return np.array(self._asleep[id(thing)][data._s_name])
        state = self._states.get(id(thing))
        if state is not None and data._s_name == "constraint":
            return _equations.constraint_of(self, self.mirror.paths[id(thing)], _stroma) if self.steps else ""
        if state is not None and data._s_name in _STATE:
            return self._of_state(thing, state, data._s_name)
        if data._s_name in _FIELDS:
            component = self._components[id(thing)]
            values = np.array(component.field(_FIELDS[data._s_name]))
            return self._at_nodes(component, values) if data._s_name.endswith("PerNode") else values
        value = self._components[id(thing)].get(data._s_name)
        return value if data._s_sample is None else _values.like(data._s_sample, value)

    def _at_nodes(self, component, values):
        """The mean over the cells around each node; 0 where there is none."""
        state = self.sim.state(component.path.rpartition("/")[0] or "/")
        mesh = state.mesh()
        blocks = [cells for _, cells in mesh.blocks()] if mesh is not None else []
        if sum(len(cells) for cells in blocks) != len(values):
            raise RuntimeError(f"{component.path} has {len(values)} cells, and they are not those of the mesh beside it")
        sums, counts, first = np.zeros(state.nodes), np.zeros(state.nodes), 0
        for cells in blocks:
            for column in cells.T:
                np.add.at(sums, column, values[first:first + len(cells)])
                np.add.at(counts, column, 1)
            first += len(cells)
        return sums / np.maximum(counts, 1)

    def _of_state(self, thing, state, name):
        if name in ("position", "free_position"):
            return _dense(state.x)
        if name == "lambda":  # impulses, as those of a constraint solver
            return self._last_dt * state.constraint_forces
        if name in ("velocity", "free_velocity"):
            return _dense(state.v)
        if name == "force":
            return self._force(state)
        if name == "reset_velocity":
            return np.zeros_like(np.array(state.v))
        return np.array(self._rest.get(id(thing), state.rest))

    def _force(self, state):
        """Asked for the first time it is computed apart; from the next step on each step has it."""
        try:
            return np.array(state.f)
        except RuntimeError:
            self.sim.request_forces()
        try:
            rows = self.sim.rows()[state.path]
            return self.sim.force()[rows] if state.kind == "points" else np.array(state.f)
        except (RuntimeError, KeyError):
            return np.array(state.f)

    def write(self, thing, data, value):
        if data._s_name in _FIELDS:
            return _messages.warn(f"{thing._s_place()}.{data._s_name}: is computed: what is written does not count")
        if id(thing) in self._asleep:
            kept, numbers = self._asleep[id(thing)], np.asarray(_values.numbers_of(value), dtype=float)
            kept[data._s_name] = _as_rows(thing, data._s_name, numbers, kept[data._s_name].shape)
            return None
        state = self._states.get(id(thing))
        if state is not None and data._s_name in _STATE and not isinstance(value, Data) and not _values.is_link_text(value):
            return self._to_state(thing, state, data, value)
        if data._s_name == "position" and self._place_still(thing, data, value):
            return None
        before, data._s_raw = data._s_raw, value
        thing._s_changed()
        takes_another = self._has_put_aside(thing, data) or thing._s_facts.find(data._s_name).change == "restart"
        if takes_another or isinstance(value, Data) or _values.is_link_text(value):
            self._waiting.add(id(data))
            return self.edited(f"{thing._s_place()}.{data._s_name}")
        try:
            self._set(thing, data, value)
        except TreeChanged:
            raise
        except RuntimeError:
            data._s_raw = before
            raise
        finally:
            self._lead_again(thing, data)
        return None

    def _lead_again(self, thing, data):
        """Springs of other points pull these to where the scene has put the rest shape."""
        state = thing._s_node().getMechanicalState() if data._s_name == "points" else None
        component = self._components.get(id(thing))
        if state is not None and id(state) in self._rest and component is not None and component.type == _SPRINGS_TO_REST:
            self._lead(state, self._states[id(state)], self._rest[id(state)])

    def write_to_sweeps(self, solver, data, value):
        """A constraint solver is no part of the engine: the dialect has put sweeps in its place, where forces end at its tolerance."""
        if data._s_name not in _OF_SWEEPS or not solver.getClassName().endswith("ConstraintSolver") or id(solver) not in self.mirror.paths:
            return
        sweeps = _found(self.sim.component, "/sweeps_of_constraints")
        if sweeps is None or not _is_first(self.root, solver):
            return
        if isinstance(value, Data) or _values.is_link_text(value):
            return self.edited(f"{solver._s_place()}.{data._s_name}")
        if data._s_name == "regularizationTerm" and "Unbuilt" in sweeps.get("resolutionMethod"):
            return None  # as in SOFA, whose method of this name has none
        text = _values.to_text(value).strip()
        if data._s_name == "resolutionMethod" and text in ("0", "1", "2"):
            text = _METHODS[int(text)]
        if data._s_name == "tolerance" and text.startswith("-"):
            text = "0"  # which no sweep meets either
        try:
            sweeps.set(data._s_name, text)
        except stroma.SceneError as error:
            raise stroma.SceneError(str(error).replace("/sweeps_of_constraints", solver.getPathName())) from None
        return None

    def _place_still(self, thing, data, value):
        """Points that no integrator moves, and nothing follows, are put elsewhere without a new simulation: a tool that touches."""
        if thing._s_facts.role != "mechanical state" or isinstance(value, Data) or _values.is_link_text(value):
            return False
        numbers, path = np.asarray(_values.numbers_of(value), dtype=float), self.mirror.paths[id(thing)]
        start = None if id(thing) in self._stood else np.array(self._components[id(thing)].get("position"))
        if numbers.size % 3 or not _stroma.place_still(self.sim._engine, path, numbers.reshape(-1, 3)):
            return False
        self._stood.setdefault(id(thing), (thing, data._s_raw, start))
        data._s_raw = numbers.reshape(-1, 3)
        return True

    def _set(self, thing, data, value):
        """What is read only where a scene is loaded, as a region of nodes that a load has taken, takes a new simulation."""
        try:
            if data._s_name == "points" and self._components[id(thing)].type == _SPRINGS_TO_REST:
                self._components[id(thing)].set("targets", "")  # of the points before
            self._tell(self._components[id(thing)].set(data._s_name, _plain(value)))
        except stroma.LoadNeeded:
            self._waiting.add(id(thing.findData(data._s_name)))
            self.edited(f"{thing._s_place()}.{data._s_name}")

    @staticmethod
    def _has_put_aside(thing, data):
        """Of attributes of which one is given the last that was written counts."""
        group = _ONE_OF.get(thing._s_facts.info.type, ())
        others = [thing._s_data[name] for name in group if name in thing._s_data and thing._s_data[name] is not data
                  and thing._s_data[name]._s_raw is not None] if data._s_name in group else []
        for other in others:
            other._s_raw = None
        return bool(others)

    def _to_state(self, thing, state, data, value):
        name = data._s_name
        if name in ("position", "velocity"):
            now = np.array(state.x if name == "position" else state.v)
            value = np.asarray(_values.numbers_of(value), dtype=float)
            return self._put(thing, state, name, _as_rows(thing, name, value, now.shape))
        if name == "rest_position":
            return self._lead(thing, state, np.asarray(_values.numbers_of(value), dtype=float))
        _messages.warn(f"{thing._s_place()}.{name}: is computed in every step: what is written does not count")
        return None

    def initialised(self):
        """Tells so. What is written to states then is where they start, and where a reset leads back to."""
        self._placed = {}
        try:
            _events.send(self.root, "SimulationInitDoneEvent", {})
        finally:
            self._places = [(thing, np.array(state.x), np.array(state.v)) for thing, state in self._placed.values()]
            self._placed = None

    def _put(self, thing, state, name, value):
        """Writes positions or velocities; SOFA's constraints let positions be written."""
        if self._placed is not None:
            self._placed[id(thing)] = thing, state
        try:
            if name == "velocity":
                state.set(v=value)
                return
            if state.kind == "frames":
                value = _with_unit_quaternions(value)
            if state.set(x=value):
                _stroma.place_held(self.sim._engine, state.path, value)
        except stroma.SceneError as error:
            if "follow from another state" not in str(error):
                raise
            _messages.warn(f"{thing._s_place()}.{name}: a mapping places it in every step: what is written does not count")

    def _lead(self, thing, state, rest):
        """Springs to the rest shape pull to another one; elastic bodies keep theirs, as in SOFA."""
        now = self._rest.get(id(thing), np.array(state.rest))
        self._rest[id(thing)] = rest = _as_rows(thing, "rest_position", rest, now.shape)
        readers = 0
        for key, component in self._components.items():
            spring = self.mirror.things[key]
            if component.type != _SPRINGS_TO_REST or spring._s_node() is not thing._s_node():
                continue
            if component.get("external_rest_shape"):
                continue
            points = component.get("points")
            component.set("targets", (rest[np.asarray(points)] if len(points) else rest).ravel())
            readers += 1
        if any(each._s_type in _READS_REST for each in thing._s_node()._s_objects):
            thing.findData("rest_position")._s_raw = rest
            if not _stroma.lead_rest(self.sim._engine, self.mirror.paths[id(thing)], rest):
                self.edited(f"{thing._s_place()}.rest_position")
        elif not readers:
            _messages.warn(f"{thing._s_place()}.rest_position: nothing in this node reads it while the scene runs")

    def context(self, name):
        if name == "time":
            return self.sim.time
        if name == "dt":
            return float(self.sim.dt if self._s_given else self._dt)
        return np.array(self.sim.gravity)

    def set_context(self, name, data):
        if name == "dt":
            self._dt = self.sim.dt = float(_values.like(0.0, data._s_raw))
        else:
            self.sim.set("/.gravity", _plain(data._s_raw))

    def matrix_of(self, thing):
        component = self._components.get(id(thing))
        if component is None:
            raise RuntimeError(f"{thing._s_place()}: is no part of the simulation, and has no matrix")
        return self.sim.matrix_of(component).tocsr()

    # ---- equations of the last step (_equations.py) ----
    def _watch(self, thing):
        """As in SOFA's Python, whose objects have these calls where a module of theirs is imported. Else nothing is kept of a step."""
        if not self._watches:
            raise AttributeError(f"{thing._s_place()}: the equations of steps are kept where the program imports Sofa.SofaLinearSystem, "
                                 "Sofa.SofaLinearSolver or Sofa.SofaConstraintSolver before the scene is initialised, as in SOFA")

    def equations(self, thing):
        self._watch(thing)
        found = self._solved.get(id(thing))
        if found is None or found[0] != self.steps:
            found = self._solved[id(thing)] = self.steps, _equations.of(self, thing, _stroma)
        return found[1]

    def compliance(self, solver):
        self._watch(solver)
        return _equations.compliance(self, solver, _stroma)

    def state_paths(self):
        """Of states, in the order of the tree."""
        return [self.mirror.paths[key] for key in self._states]

    def plain_template_of(self, path):
        thing = next(thing for key, thing in self.mirror.things.items() if self.mirror.paths[key] == path)
        return _values.plain_template(thing._s_template())

    def integrators_of_constraints(self):
        """Of systems with Lagrangian constraints, which have looked for forces in the last step."""
        return [integrator for integrator, states in _stroma.systems_of(self.sim._engine)] if self.constraint_counts() else []

    def constraint_counts(self):
        """(component, how many forces) of each constraint, in the order of their rows."""
        found = []
        for component in self._components.values():
            if component.type == "CollisionResponse" and component.get("response").startswith("FrictionContact"):
                found.append((component, len(rows_of(component, self.types()))))
            elif component.role == "Lagrangian constraint":
                found.append((component, np.size(component.get("forces"))))
        return found

    def uncoupled(self):
        """(path of its state, component, object) of each correction whose nodes answer by a compliance of their own."""
        found = []
        for key, component in self._components.items():
            if component.type == "UncoupledConstraintCorrection":
                thing = self.mirror.things[key]
                link = thing.findData("mstate")
                state = link.getLinkedBase() if link is not None and link.isSet() else thing._s_node().getMechanicalState()
                found.append((self.mirror.paths[id(state)], component, thing))
        return found

    def of_constraints(self, name):
        """What a constraint solver of SOFA tells of the last step: of the search for the forces, where there was one."""
        if name == "constraintForces":
            return self.constraint_forces()
        if name == "currentNumConstraints":
            return len(self.constraint_forces())
        searches = [each for each in self._components.values() if "conditionIterations" in each.attributes]
        if name == "currentIterations":
            return sum(each.get("conditionIterations") for each in searches)
        return max((each.get("conditionResidual") for each in searches), default=0.0)

    def constraint_forces(self):
        """Of the last step, row by row, of constraint after constraint in the order of the scene. SOFA keeps impulses, f dt."""
        found = [np.zeros(0)]
        for component in self._components.values():
            if component.type == "CollisionResponse" and component.get("response").startswith("FrictionContact"):
                found.append(self._last_dt * rows_of(component, self.types()))
            elif component.role == "Lagrangian constraint":
                found.append(self._last_dt * np.ravel(component.get("forces")))
        return np.concatenate(found)

    def _position_of(self, key):
        """Positions of a state, also of one that is switched off."""
        if key in self._states:
            return np.array(self._states[key].x)
        return self._asleep[key]["position"] if key in self._asleep else None

    def drawn(self, thing):
        """The points of a visual model; None: they cannot be found."""
        if self._drawing is None:
            try:
                self._drawing = Drawing(self.root)
            except RuntimeError as error:
                self._drawing = error
        if isinstance(self._drawing, Exception):
            return None
        return self._drawing.position(thing, self._position_of)

    def types(self):
        """Of components, by their path."""
        return {self.mirror.paths[key]: component.type for key, component in self._components.items()}

    def contact_response(self):
        """What answers contacts; None: nothing does."""
        return next((each for each in self._components.values() if each.type == "CollisionResponse"), None)

    # ---- changes of the tree ----
    def edited(self, what=""):
        """What a running simulation cannot take: it is made anew before the next step, and goes on from where it is."""
        self._restart = True
        if self._s_given:
            raise TreeChanged(f"{what or 'the tree'}: changes while the scene runs, and takes a new simulation, which this command "
                              "cannot do")

    def _make_anew(self, from_start=False):
        mirror = Mirror(self.root)
        led, before = dict(self._rest), self.sim
        simulation = load(self.root, mirror, None if from_start else self.sim.time)
        self._restart = False  # a scene that cannot be loaded is told in every step
        self._remade = not from_start
        if simulation.dt != before.dt:
            simulation.dt = before.dt
        if not from_start:
            same = {path: mirror.paths[key] for key, path in self.mirror.paths.items() if key in mirror.paths}
            for path in _stroma.go_on(simulation._engine, before._engine, same, set(mirror.paths.values())):
                _messages.warn(f"{path}: the scene has changed, and what it remembers of the run begins anew")
        # with the object itself, so that no other one gets its id
        awake = {} if from_start else {key: {"object": self.mirror.things[key], "position": np.array(state.x),
                                             "velocity": np.array(state.v)} for key, state in self._states.items()}
        self._take(simulation, mirror)
        self._asleep = {} if from_start else self._asleep | {key: kept for key, kept in awake.items() if key not in self._states}
        for key in self._asleep.keys() & self._states.keys():
            kept = self._asleep.pop(key)
            for name in ("position", "velocity"):
                self._put(mirror.things[key], self._states[key], name, kept[name])
        for key, rest in led.items():
            if key in self._states:
                self._lead(mirror.things[key], self._states[key], rest)
        self.tell()

    def store_start(self, thing):
        """From now on reset() puts a state to where it is now."""
        state = self._states.get(id(thing))
        if state is not None:
            self._places = [kept for kept in self._places if kept[0] is not thing]
            self._places.append((thing, np.array(state.x), np.array(state.v)))

    def reinit(self, thing):
        """Attributes have been taken when they were set."""

    # ---- meshes that change at once, by the modifier of a topology ----
    def can_change_mesh(self, container):
        """The container stands in the engine as it is."""
        return id(container) in self._components and not self._restart

    def takes_lists(self):
        """Whether the lists of a container may be set: the engine is then made anew, which a command does not do."""
        return not self._has_other_meshes and not self._s_given

    def change_mesh(self, modifier, container, kind, removed=(), added=(), points=0, keeps_points=False):
        state = container._s_node().getMechanicalState()
        if len(added) == 0 and points and any(each._s_type and each._s_facts.role == "mapping" for each in container._s_node()._s_objects):
            raise RuntimeError(f"{modifier._s_place()}: points of {state.getPathName() if state else 'a state'}, which a mapping places, do "
                               "not come while the scene runs: where they would be in the body is not known")
        notes = self.sim._engine.change_mesh(self.mirror.paths[id(container)], kind, [int(each) for each in np.ravel(removed)],
                                             [[int(each) for each in cell] for cell in added], int(points), bool(keeps_points))
        for note in notes:
            _messages.warn(note)
        self._has_other_meshes = True
        self._look_again()

    def _look_again(self):
        """Components and states are others, at the same paths."""
        sim, mirror, pushed, waiting = self.sim, self.mirror, self._pushed, self._waiting
        sim._found_states = sim._facts = None
        sim._states.clear()
        sim._parts.clear()
        self._take(sim, mirror)
        self._pushed, self._waiting = pushed, waiting
        for thing, _, _ in self._stood.values():  # where the scene has put them, and not where they started
            self._put_still(thing, thing.findData("position")._s_raw)

    def _put_still(self, thing, places):
        if id(thing) in self._components:
            _stroma.place_still(self.sim._engine, self.mirror.paths[id(thing)], places)

    # ---- steps ----
    def begin_step(self, dt):
        self._last_dt = dt
        _events.begin_step(self.root, dt)
        self._update_engines()
        self._hand_on()
        if self._restart:
            self._make_anew()
        self.inertias = _equations.inertias(self) if self._watches else {}
        if self._s_given and self._tells_gradients:
            _stroma.watch_step(self.sim._engine, True)

    def end_step(self, dt):
        self.steps += 1
        if self._mesh_changes != self.sim._engine.mesh_changes:  # by a component of the scene
            self._has_other_meshes = True
            self._look_again()
        if self._s_given and self._tells_gradients:
            _stroma.watch_step(self.sim._engine, False)
        _events.end_step(self.root, dt)
        _carving.carve(self)  # who hears of the step's end sees the mesh that the step was made with

    def step(self, dt):
        """Of dt, or of the root's, which stays as it is."""
        given = float(dt or 0)
        dt = given if given > 0 else self._dt
        if not given >= 0:
            _messages.warn(f"Sofa.Simulation.animate({given:g}): a step of the root's dt is made, {dt:g}")
        if dt != self.sim.dt:
            self.sim.dt = dt
        self.begin_step(dt)
        self.sim.step()
        self.end_step(dt)

    def _hand_on(self):
        """Data of components that take values from data of Python."""
        for data, source in self.mirror.dependents:
            if self._pushed.get(id(data)) == source._s_stamp:
                continue
            self._pushed[id(data)] = source._s_stamp
            thing = data._s_owner
            found = thing._s_facts.find(data._s_name)
            if id(thing) not in self._components or found is None:
                continue
            if id(thing) in self._states and data._s_name in ("position", "velocity", "rest_position"):
                self._to_state(thing, self._states[id(thing)], data, source.value)
            elif found.change == "restart":
                self.edited(f"{thing._s_place()}.{data._s_name}")
            else:
                self._set(thing, data, source.value)

    def _update_engines(self):
        for each in _events.listeners(self.root):
            if isinstance(each, DataEngine):
                each._s_bring_up()

    def gone_back(self):
        """The view has reset the simulation."""
        if self._has_other_meshes:
            self._has_other_meshes = False
            self._look_again()
        self.restarted()

    def restarted(self):
        self.steps = 0
        for thing, position, velocity in self._places:
            state = self._states.get(id(thing))
            if state is not None and state.x.shape == position.shape:
                self._put(thing, state, "position", position)
                self._put(thing, state, "velocity", velocity)
        _events.call(self.root, "reset", only=_old_controller())

    def reset(self):
        stood = list(self._stood.values())
        for thing, raw, start in stood:
            thing.findData("position")._s_raw = raw
            if not self._remade:
                self._put_still(thing, start)
        self._stood.clear()
        if self._remade:  # the scene was made anew on the way: the start is that of the tree
            self._make_anew(from_start=True)
        self.sim.reset()
        if self._has_other_meshes:
            self._has_other_meshes = False
            self._look_again()
            for thing, _, start in stood:  # the mesh of the start has its own states
                self._put_still(thing, start)
        self.restarted()


def _old_controller():
    """SofaPython 3 calls no `reset` of Python's classes: environments have one that calls Sofa.Simulation.reset()."""
    from ._old_python import PythonScriptController

    return PythonScriptController


def _is_first(root, solver):
    """The constraint solver that counts."""
    return next(each for each in root._s_all_objects() if each.getClassName().endswith("ConstraintSolver")) is solver


def _dense(rows):
    """A copy. By columns: rows of three with a gap behind them take NumPy six times as long."""
    if rows.flags.c_contiguous:
        return np.array(rows)
    copy = np.empty(rows.shape)
    for column in range(rows.shape[1]):
        copy[:, column] = rows[:, column]
    return copy


def _found(search, path):
    try:
        return search(path)
    except (RuntimeError, KeyError):
        return None


def _with_unit_quaternions(frames):
    """Scenes write orientations of a few digits."""
    frames = np.array(frames, dtype=float)
    length = np.linalg.norm(frames[:, 3:7], axis=1)
    if not np.all(length > 0):
        raise ValueError("an orientation of length zero")
    frames[:, 3:7] /= length[:, None]
    return frames


def _plain(value):
    """As the engine takes it."""
    if isinstance(value, np.ndarray):
        return np.asarray(value)
    return value if isinstance(value, str) else _values.to_text(value)


def check(root):
    """Raises for what a scene writes in Python and the engine has no door for."""
    from ._scene_file import SceneFileError

    found = [(*each._s_where, f"{type(each).__name__} is {each._s_what}: SofaPython3 has no class that does this in Python, and neither has "
              "Stroma (a force field, a mapping, a controller or a DataEngine can be written)")
             for each in root._s_all_objects() if isinstance(each, Unavailable)]
    if found:
        raise SceneFileError(found)


def load(root, mirror, time=None):
    """At a time other than that of the scene. Throws SceneError with every problem of the scene."""
    check(root)
    return stroma.load(mirror.root, dialect="sofa", set={} if time is None else {"time": time}, quiet=True)


# ---- what Sofa.Simulation does ----

def begin(root):
    """What comes before the engine: Python's objects are initialised, and may still change the scene."""
    root._s_prefer_parents_here()
    _events.of_scene(root, "SimulationInitStartEvent")
    _events.call(root, "init")
    for each in _events.listeners(root):
        if isinstance(each, DataEngine):
            each._s_bring_up()


def bind(root, engine):
    object.__setattr__(root, "_s_running", engine)
    _previews.forget(root)
    _events.warn_of_unsent(root)
    engine.tell()
    _events.call(root, "bwdInit")
    engine.initialised()


def initialise(root):
    root = root.getRoot()
    if getattr(root, "_s_running", None) is not None:
        return
    begin(root)
    bind(root, Engine(root))


def animate(root, dt=0.0):
    root = root.getRoot()
    initialise(root)
    root._s_running.step(float(dt))


def reset(root):
    engine = root.getRoot()._s_engine()
    if engine is not None:
        engine.reset()


_commanded = []


def is_commanded():
    """Whether this process is a command that runs a scene."""
    return bool(_commanded)


def view(root):
    """The live view of a tree, until it is closed."""
    from stroma import _command

    from .Gui import GUIManager
    from .command import Program

    _commanded.append(True)
    try:
        _command.main(["view", GUIManager._file or "scene.py"], Program(root))
    finally:
        _commanded.pop()
        unload(root)  # its simulation ended with the view


def unload(root):
    object.__setattr__(root.getRoot(), "_s_running", None)
