# SPDX-License-Identifier: LGPL-2.1-or-later
"""Objects of a scene: components of the engine, and those that a scene writes in Python."""
import re

import numpy as np

from . import _boxes, _catalogue, _cells, _grids, _messages, _regions, _values
from ._base import Base
from ._data import Data


class Object(Base):
    """A component, by the name of its type. Classes of a scene derive from Controller and the like."""

    def __init__(self, *_arguments, **values):
        take(self, values)

    # ---- its type ----
    @property
    def _s_type(self):
        return self.__dict__.get("_s_type_word", "")

    @property
    def _s_facts(self):
        return _catalogue.facts(self._s_type) if self._s_type else None

    def _s_is_state(self):
        return self._s_facts is not None and self._s_facts.role == "mechanical state"

    def _s_is_drawn(self):
        return self._s_facts is not None and self._s_facts.besides is _catalogue.DRAWN

    def _s_template(self):
        data = self._s_data.get("template")
        raw = data._s_raw if data is not None else None
        return raw if isinstance(raw, (str, Data)) and raw else ""

    def _s_template_of_state(self):
        """Of what acts on a state: that of the state here, or of the next one above, as SOFA chooses it."""
        node = self._s_node() if self._s_facts.role in ("force field", "projective constraint") else None
        while node is not None and node.getMechanicalState() is None:
            node = node._s_node()
        return "" if node is None else node.getMechanicalState()._s_template()

    def getClassName(self):
        return self._s_type or type(self).__name__

    def getTemplateName(self):
        """In full, as SOFA has it: Rigid3 is "Rigid3d"."""
        given = self._s_template() or (self._s_template_of_state() if self._s_type else "")
        if not isinstance(given, str):
            given = str(given.value)
        words = [_values.plain_template(word) for word in given.split(",") if word.strip()]
        return ",".join(word + "d" if word in _values.COORDINATES else word for word in words) or ("Vec3d" if self._s_type else "")

    def getCategories(self):
        return [self._s_facts.role] if self._s_facts else []

    def _s_present_name(self, name):
        facts = self._s_facts
        found = facts.find(name) if facts else None
        return found.name if found else name

    def _s_sample_of(self, name):
        facts = self._s_facts
        if facts is not None:
            if name == "template":
                return "", ""
            sample = facts.sample(name, self._s_template() or self._s_template_of_state())
            if sample is not None:
                found = facts.find(name)
                return sample, found.help if found else ""
            if facts.info is None and name not in ("", None) and (facts.missing or name in ("src",)):
                return None, ""  # what Stroma lacks may have any data; they can be written, and are linked to
        found = super()._s_sample_of(name)
        return found

    def _s_data_names(self):
        return sorted(set(super()._s_data_names()) | set(self._s_facts.names() if self._s_facts else []))

    def findData(self, name):
        found = super().findData(name)
        if found is None and self._s_accepts_all():
            name = str(name)
            if not name.startswith("_") and name not in _NEVER_DATA:
                found = self._s_data[name] = Data(self, name)
        return found

    def findLink(self, name):
        return self.findData(name)

    def _s_attribute(self, name):
        """Calls that are not here are no data, even of what may have any: a scene may ask for them by hasattr()."""
        return None if _CALLS.match(name) and name not in self._s_data and self._s_accepts_all() else super()._s_attribute(name)

    def _s_no_data(self, name):
        is_call = _CALLS.match(name) and self._s_accepts_all()
        return f"{self._s_place()}: {self._s_type} has no '{name}()' here" if is_call else super()._s_no_data(name)

    def _s_accepts_all(self):
        return self._s_facts is not None and self._s_facts.accepted and self._s_facts.info is None

    # ---- values ----
    def _s_read(self, data):
        facts = self._s_facts
        if facts is not None and facts.role == "selection" and _regions.lists(data._s_name):
            given = self._s_given(data)
            found = None if given is not None and len(given) else _regions.chosen(self, data._s_name)
            return given if found is None else self._s_formed(data, found)
        if not _cells.are_made(data._s_name) or facts is None or facts.role != "topology":
            return self._s_given(data)
        if facts.info.type == "RegularGridTopology" and data._s_raw is None:
            return self._s_formed(data, _grids.list_of(self, data._s_name))
        given = self._s_given(data)
        return given if len(given) else self._s_formed(data, _cells.made(self, data._s_name))

    def _s_given(self, data):
        """What the scene or the engine has of it."""
        engine = self._s_engine()
        facts = self._s_facts
        if data._s_name == "nbPoints" and facts is not None and facts.role == "topology" and data._s_raw is None:
            return self.getNbPoints()
        if engine is not None and engine.knows(self, data):
            return engine.read(self, data)
        if data._s_name == "bbox" and (self._s_is_state() or self._s_is_drawn()) and (data._s_raw is None or engine is not None):
            found = _boxes.around([self])
            return super()._s_read(data) if found is None else found
        if facts is None or data._s_name == "name":
            return super()._s_read(data)
        if engine is not None and facts.besides is _catalogue.CONSTRAINTS and data._s_name in _catalogue.OF_CONSTRAINTS:
            return engine.of_constraints(data._s_name)
        if data._s_name == "size" and facts.role == "mechanical state":
            return self.getSize()
        if data._s_raw is None and self._s_is_computed(data):
            from . import _previews

            value = _previews.value_of(self, data)
            if value is not None:
                return self._s_formed(data, value)
        if data._s_raw is None and facts.missing:
            raise MissingType(f"{self._s_place()}: '{self._s_type}' is not in Stroma: its data '{data._s_name}' cannot be read")
        is_drawn = self._s_is_drawn() and data._s_name in ("position", "vertices", "normal")
        if is_drawn and engine is not None and data._s_name != "normal":
            value = engine.drawn(self)
            if value is not None:
                return value
        if data._s_raw is None and engine is not None and (is_drawn or data._s_name in _catalogue.NOT_COMPUTED):
            instead = ("; it is where a controller's own code names it, or the program imports Sofa.SofaConstraintSolver; `lambda` has the "
                       "impulses on its nodes") if data._s_name == "constraint" else ""
            _messages.warn(f"{self._s_place()}.{data._s_name}: is read, and not computed here: what is read stays as at the start{instead}")
        value = self._s_of_source(data) if data._s_raw is None and self._s_is_drawn() else None
        return super()._s_read(data) if value is None else self._s_formed(data, value)

    def _s_of_source(self, data):
        """What `src` of a visual model gives for data that are not written; None: nothing."""
        given = self._s_data.get("src")
        raw = given._s_raw if given is not None and given is not data else None
        source = raw if isinstance(raw, Object) else self._s_linked(raw, "src") if _values.is_link_text(raw) else None
        found = source.findData(data._s_name) if isinstance(source, Object) and data._s_name != "name" else None
        return None if found is None else found.value

    def _s_is_computed(self, data):
        info = self._s_facts.info
        found = self._s_facts.find(data._s_name)
        if info is None or found is None or found.link:
            return False
        empty = isinstance(data._s_sample, (list, np.ndarray)) and len(data._s_sample) == 0
        return found.output or (empty and info.role in _catalogue.COMPUTED_ROLES)

    def _s_write(self, data, value):
        engine = self._s_engine()
        if engine is not None and data._s_name == "externalForce":
            _messages.warn(f"{self._s_place()}: written while the scene runs, externalForce has no effect: write 'forces' of a "
                           "ConstantForceField instead")
        if engine is not None and data._s_name != "name" and engine.knows(self, data):
            return engine.write(self, data, value)
        if engine is not None:
            engine.write_to_sweeps(self, data, value)
        return super()._s_write(data, value)

    def _s_keeps(self, name):
        if self._s_type and self._s_facts.info is not None:
            near = _messages.nearest(name, self._s_facts.names())
            if near:
                _messages.warn(f"{self._s_place()}: {self._s_type} has no data '{name}': it is kept as an attribute of Python; "
                               f"did you mean '{near}'?")

    # ---- what SOFA's objects answer ----
    def init(self):
        """Called when the scene is initialised."""

    def bwdInit(self):
        pass

    def reinit(self):
        engine = self._s_engine()
        if engine is not None:
            engine.reinit(self)

    def reset(self):
        pass

    def cleanup(self):
        pass

    def storeResetState(self):
        """Of a state: reset() comes back to its present positions and velocities."""
        engine = self._s_engine()
        if engine is not None:
            engine.store_start(self)

    def draw(self, *_):
        pass

    def setSrc(self, text, other=None):
        self._s_add_data("src", other.getLinkPath() if other is not None else text, "", "", "")
        self._s_changed()

    def getMaster(self):
        return self.__dict__.get("_s_master")

    def getSlaves(self):
        return list(self.__dict__.get("_s_slaves", ()))

    def addSlave(self, other):
        """Tells nothing but who belongs to whom, as in SOFA."""
        self.__dict__.setdefault("_s_slaves", []).append(other)
        object.__setattr__(other, "_s_master", self)

    def getTarget(self):
        return self._s_type

    def getState(self):
        return self._s_node().getMechanicalState() if self._s_node() else None

    def getMechanicalState(self):
        return self.getState()

    def assembleKMatrix(self):
        """dF/dx of a force field, as a sparse matrix of SciPy."""
        return self._s_matrix()

    def assembleMMatrix(self):
        return self._s_matrix()

    def _s_matrix(self):
        engine = self._s_engine()
        if engine is None:
            raise RuntimeError(f"{self._s_place()}: there is no matrix before the scene is initialised")
        return engine.matrix_of(self)

    # ---- of states ----
    def getSize(self):
        return len(self.findData("position").value)

    # ---- of springs ----
    def addSpring(self, *spring):
        """A LinearSpring, or its numbers: two indices, stiffness, damping, length at rest."""
        self.addSprings([spring[0] if len(spring) == 1 else spring])

    def addSprings(self, springs):
        data = self.findData("spring")
        if data is None:
            raise AttributeError(f"{self._s_place()}: {self._s_type} has no springs that can be added")
        data.value = [*np.ravel(data.value).tolist(), *(number for spring in springs for number in spring)]

    def removeSpring(self, number):
        data = self.findData("spring")
        if data is None:
            raise AttributeError(f"{self._s_place()}: {self._s_type} has no springs that can be taken away")
        rows = np.reshape(data.value, (-1, 5))
        if not 0 <= int(number) < len(rows):
            raise IndexError(f"{self._s_place()}: there is no spring {number}: there are {len(rows)}")
        data.value = np.delete(rows, int(number), axis=0).ravel()

    # ---- of topologies ----
    def _s_count(self, name):
        data = self.findData(name)
        return 0 if data is None else len(data.value)

    def getNbPoints(self):
        return self._s_count("position")

    def getNbEdges(self):
        return self._s_count("edges")

    def getNbLines(self):
        return self.getNbEdges()

    def getNbTriangles(self):
        return self._s_count("triangles")

    def getNbQuads(self):
        return self._s_count("quads")

    def getNbTetrahedra(self):
        return self._s_count("tetrahedra")

    getNbTetras = getNbTetrahedra

    def getNbHexahedra(self):
        return self._s_count("hexahedra")

    getNbHexas = getNbHexahedra

    def getEdge(self, index):
        return _cells.cells(self, "edges")[index].tolist()

    def getTetrahedron(self, index):
        return _cells.cells(self, "tetrahedra")[index].tolist()

    def getLocalEdgesInTetrahedron(self, index):
        return list(_cells.TETRAHEDRON_EDGES[index])

    def getEdgesInTetrahedron(self, index):
        """The numbers of its edges, in the order of getLocalEdgesInTetrahedron."""
        numbers = {frozenset(edge): i for i, edge in enumerate(_cells.cells(self, "edges").tolist())}
        nodes = self.getTetrahedron(index)
        return [numbers[frozenset(nodes[k] for k in pair)] for pair in _cells.TETRAHEDRON_EDGES]


#: names that programs ask of any object of Python: no data of what takes all data
_NEVER_DATA = {"value", "shape", "dtype", "size"}
#: words of calls, but for two that are data
_CALLS = re.compile("(?!createTangents$|removeIsolated$)(add|clear|create|find|get|insert|notify|remove|set)[A-Z]")


class MissingType(RuntimeError):
    """A scene needs a value of a component that Stroma does not have."""


def take(thing, values):
    """Arguments of a class of the scene: its data are set; of others the class takes care, as in SOFA."""
    for name, value in values.items():
        if name == "name":
            thing.setName(value)
        elif thing.findData(name) is not None:
            thing._s_assign(name, value)


class Controller(Object):
    """Told of events: a method onAnimateBeginEvent(self, event) is called when a step begins, and so on."""

    def init(self):
        pass

    def onEvent(self, event):
        """Any event for which the class has no method."""


def _stamp(data):
    """Changes with the value: of data that are linked with that of their source, of what steps change with its numbers."""
    source, owner = data.getParent(), data._s_owner
    if source is not None:
        return data._s_stamp, _stamp(source)
    if isinstance(owner, DataEngine):
        value = data.value if any(data is each for each in owner.__dict__.get("_s_outputs", ())) else None  # which brings it up
        return data._s_stamp, value is None
    engine = owner._s_engine() if isinstance(owner, Object) else None
    if engine is None or not engine.knows(owner, data):
        return data._s_stamp
    value = data.value
    return hash(value.tobytes() if isinstance(value, np.ndarray) else _values.to_text(value))


def _each(data):
    """Data, also those in lists."""
    for given in data:
        for each in given if isinstance(given, (list, tuple)) else (given,):
            if not isinstance(each, Data):
                raise TypeError(f"an engine's inputs and outputs are data, and not a {type(each).__name__}")
            yield each


class DataEngine(Object):
    """Computes data from data: `update` is called when the scene is initialised, and before each step when an input changed."""

    def addInput(self, *data):
        self.__dict__.setdefault("_s_inputs", []).extend(_each(data))

    def addOutput(self, *data):
        self.__dict__.setdefault("_s_outputs", []).extend(_each(data))

    def update(self):
        pass

    def _s_read(self, data):
        if any(data is each for each in self.__dict__.get("_s_outputs", ())):
            self._s_bring_up()
        return super()._s_read(data)

    def _s_bring_up(self):
        """update(), where an input has another value since."""
        stamp = tuple(_stamp(each) for each in self.__dict__.get("_s_inputs", []))
        if self.__dict__.get("_s_seen") != stamp:
            object.__setattr__(self, "_s_seen", stamp)
            self.update()


class ForceField(Object):
    """A force field written in Python: addForce(self, m, force, position, velocity), and for implicit steps
    addDForce(self, m, df, dx) or addKToMatrix(self, m, nodes, numbers of a node)."""

    def addForce(self, m, force, position, velocity):
        raise NotImplementedError(f"{self._s_place()}: a force field needs addForce()")

    def addDForce(self, *arguments):
        """Without a stiffness the force is explicit."""

    def addKToMatrix(self, *_):
        """The same as a matrix."""

    def _s_attribute(self, name):
        if name == "mstate":
            return self._s_node().getMechanicalState()
        return super()._s_attribute(name)


class Unavailable(Object):
    """A class that a scene derives from, and that SofaPython3 lets nobody derive from either: what it calls comes to no Python."""

    _s_what = ""


class Mass(Unavailable):
    _s_what = "a mass written in Python"


class Constraint(Unavailable):
    _s_what = "a constraint written in Python"
