# SPDX-License-Identifier: LGPL-2.1-or-later
"""Nodes: objects, children, and the time and gravity of what is below."""
import numpy as np

from . import _boxes, _catalogue, _messages, _values
from ._base import Base, _versions, caller
from ._data import Data
from ._mapping import Mapping
from ._objects import ForceField, Object, take

_CONTEXT = {"gravity": np.array([0.0, -9.81, 0.0]), "dt": 0.01, "time": 0.0, "animate": False, "activated": True, "sleeping": False,
            "canChangeSleepingState": False, "is_activated": True}


class Sequence:
    """`node.objects`, `node.children`: by number or by name."""

    def __init__(self, node, items, remove):
        self._s_node, self._items, self._remove = node, items, remove

    def __len__(self):
        return len(self._items)

    def __iter__(self):
        return iter(list(self._items))

    def __getitem__(self, key):
        if isinstance(key, str):
            for each in self._items:
                if each._s_name == key:
                    return each
            raise KeyError(key)
        return self._items[key]

    at = __getitem__

    def __contains__(self, key):
        return any(each._s_name == key or each is key for each in self._items)

    def __getattr__(self, name):
        if name.startswith("_"):
            raise AttributeError(name)
        try:
            return self[name]
        except KeyError:
            raise AttributeError(f"{self._s_node._s_place()}: has no '{name}'") from None

    def getValueString(self):
        """As a link of SOFA tells what it leads to."""
        return " ".join(each.getLinkPath() for each in self._items)

    def getSize(self):
        return len(self._items)

    def remove_at(self, index):
        self._remove(self._items[index])

    def __repr__(self):
        return f"<{', '.join(each._s_name for each in self._items)}>"


class Node(Base):
    def __init__(self, name="", *_arguments, **values):
        object.__setattr__(self, "_s_objects", [])
        object.__setattr__(self, "_s_children", [])
        if name:
            self.setName(name)
        take(self, values)

    def __new__(cls, *arguments, **keywords):
        self = super().__new__(cls, *arguments, **keywords)
        object.__setattr__(self, "_s_objects", [])
        object.__setattr__(self, "_s_children", [])
        return self

    # ---- with node.addChild("name") as child: ----
    def __enter__(self):
        return self

    def __exit__(self, *_):
        """SOFA initialises the node here; what is read before the scene is initialised is computed when it is asked for."""
        return False

    # ---- data ----
    def _s_sample_of(self, name):
        return (_CONTEXT[name], "") if name in _CONTEXT else super()._s_sample_of(name)

    def _s_data_names(self):
        return sorted(set(super()._s_data_names()) | set(_CONTEXT))

    def _s_read(self, data):
        if data._s_name in ("gravity", "dt", "time", "animate"):
            engine = self._s_engine()
            if engine is not None and data._s_name in ("dt", "time", "gravity"):
                return engine.context(data._s_name)
            if data._s_raw is None and self._s_parents:
                return self._s_above().findData(data._s_name).value
        is_box = data._s_name == "bbox" and (data._s_raw is None or self._s_engine() is not None)
        found = _boxes.around(each for each in self._s_all_objects() if each._s_is_state()) if is_box else None
        return super()._s_read(data) if found is None else found

    def _s_write(self, data, value):
        is_link = _values.is_link_text(value) or hasattr(value, "getLinkPath")
        if data._s_name in ("dt", "gravity") and not is_link and len(_values.numbers_of(value)) == 0:
            return _messages.warn(f"{self._s_place()}.{data._s_name}: {value!r} is not a number: SOFA keeps {data.value}")
        if data._s_name == "sleeping" and value in (True, 1, "1", "true"):
            _messages.warn(f"{self._s_place()}.sleeping: bodies do not sleep here: they move on (activated=False takes them out)")
        was_active = data._s_name != "activated" or self.isActive()
        super()._s_write(data, value)
        if data._s_name in ("activated", "is_activated"):
            self._s_tell_root([self])
        engine = self._s_engine()
        if engine is not None and data._s_name == "activated" and was_active != self.isActive():
            engine.edited(f"{self._s_place()}.activated")
        if engine is not None and data._s_name in ("dt", "gravity") and not self._s_parents:
            engine.set_context(data._s_name, data)

    def getDt(self):
        return self.findData("dt").value

    def setDt(self, dt):
        self.findData("dt").value = dt

    def getTime(self):
        return self.findData("time").value

    def getGravity(self):
        return self.findData("gravity").value

    def setGravity(self, gravity):
        self.findData("gravity").value = gravity

    def getAnimate(self):
        return self.findData("animate").value

    def setAnimate(self, animate):
        self.findData("animate").value = animate

    def isActive(self):
        return bool(self.findData("activated").value)

    def setActive(self, active):
        self.findData("activated").value = active

    def isSleeping(self):
        return bool(self.findData("sleeping").value)

    def setSleeping(self, sleeping):
        self.findData("sleeping").value = sleeping

    # ---- objects ----
    def addObject(self, what, *arguments, **values):
        """`what`: the name of a type, an object, or a function that makes one in this node."""
        if isinstance(what, Base):
            return self._s_insert(what, values)
        if callable(what):
            made = what(self, *arguments, **values)
            return made if made is None or not isinstance(made, Object) or made._s_parents else self._s_insert(made, {})
        if not isinstance(what, str):
            raise TypeError(f"{self._s_place()}: addObject() takes the name of a type or an object, not a {type(what).__name__}")
        if what in ("PythonScriptController", "PythonController"):
            from . import _old_python

            return _old_python.controller(self, values)
        if _catalogue.facts(what).missing:
            from . import _scene_file

            where = caller()
            if _scene_file.is_caught(*where):  # the scene has another answer
                _messages.warn(f"{where[0]}:{where[1]}: {_scene_file.missing_sentence(what)}: the scene takes another one for it")
                raise ValueError(f"{self._s_place()}: {_scene_file.missing_sentence(what)}")
        made = _class_of(what)()
        object.__setattr__(made, "_s_type_word", what)
        return self._s_insert(made, values)

    createObject = addObject

    def add(self, what, *arguments, **values):
        """A node, an object, a class or a function of the scene, or a type by name."""
        if isinstance(what, Node):
            return self.addChild(what)
        if isinstance(what, type) and issubclass(what, Node):
            return self.addChild(what(*arguments, **values))
        if isinstance(what, type) and issubclass(what, Object):
            return self._s_insert(what(*arguments, **values), {})
        if callable(what) and not isinstance(what, (str, Base)):
            return what(self, *arguments, **values)
        return self.addObject(what, *arguments, **values)

    def _s_insert(self, thing, values):
        if isinstance(thing, Node):
            return self.addChild(thing)
        before = thing._s_node()
        if before is not None:
            before._s_take_out(thing)
        # a name that begins with nothing else is that of the type; the second has a number
        if "name" in values:
            name = values.pop("name")
            thing.setName(name.value if isinstance(name, Data) else " ".join(name) if isinstance(name, (list, tuple)) else name)
        if not thing._s_name:
            object.__setattr__(thing, "_s_name", self._s_free_name(thing.getClassName()))
        object.__setattr__(thing, "_s_parents", [self])
        object.__setattr__(thing, "_s_order", next(_versions))
        self._s_objects.append(thing)
        for name, value in sorted(values.items(), key=lambda item: item[0] != "template"):  # which says of what kind the others are
            self._s_give(thing, name, value)
        self._s_came_or_went(thing)
        return thing

    def _s_free_name(self, word):
        names = {each._s_name for each in self._s_objects}
        if word not in names:
            return word
        number = 1
        while f"{word}{number}" in names:
            number += 1
        return f"{word}{number}"

    @staticmethod
    def _s_give(thing, name, value):
        """An argument of addObject(). What no data takes is kept as it is written, to be told when the scene is loaded."""
        if isinstance(value, dict) or (callable(value) and not isinstance(value, (Data, Base))):
            raise TypeError(f"{thing._s_place()}: the value of '{name}' is a {type(value).__name__}")
        data = thing.findData(name)
        if data is None:
            data = thing._s_add_data(name, None, None, "", "")
        data._s_raw = value if isinstance(value, (Data, Base)) or value is None else _frozen(_followed(thing, data, value))

    def removeObject(self, thing):
        thing = self.getObject(thing) if isinstance(thing, str) else thing
        if thing not in self._s_objects:
            raise ValueError(f"{self._s_place()}: has no object {thing!r}")
        self._s_take_out(thing)
        object.__setattr__(thing, "_s_parents", [])
        self._s_came_or_went(thing)

    def _s_take_out(self, thing):
        self._s_objects.remove(thing)
        self.__dict__.pop("_s_kept_roles", None)

    def _s_came_or_went(self, thing):
        """A controller is no part of the simulation: it only hears events from now on, or no more."""
        object.__setattr__(thing, "_s_version", next(_versions))
        if thing._s_type or isinstance(thing, (ForceField, Mapping)):
            return self._s_edited([thing])
        if self._s_engine() is not None and thing._s_parents:
            thing.init()
        return self._s_tell_root([thing])

    def getObject(self, name, *_, **_options):
        """By its name, or by a path from here; None when there is none."""
        name = str(name)
        if "/" in name:
            found = self._s_walk([step for step in name.split("/") if step])
            return found if isinstance(found, Object) else None
        for each in self._s_objects:
            if each._s_name == name:
                return each
        return None

    def hasObject(self, name):
        return self.getObject(name) is not None

    @property
    def objects(self):
        return Sequence(self, self._s_objects, self.removeObject)

    def getObjects(self, *_):
        return list(self._s_objects)

    # ---- children ----
    def addChild(self, what, *_arguments, **values):
        """`what`: a name, or a node."""
        if isinstance(what, Data):
            what = str(what.value)
        if not isinstance(what, (Node, str)) and isinstance(getattr(what, "node", None), Node):
            what = what.node  # an object of a library that wraps a node
        child = what if isinstance(what, Node) else Node(str(what) if what is not None else "")
        if not isinstance(what, (Node, str)) and what is not None:
            raise TypeError(f"{self._s_place()}: addChild() takes a name or a node, not a {type(what).__name__}")
        if self._s_is_below(child):
            raise ValueError(f"{self._s_place()}: {child!r} is this node or above it, and cannot be its child")
        if not child._s_name:
            object.__setattr__(child, "_s_name", "unnamed")
        if self not in child._s_parents:
            child._s_parents.append(self)
        if child not in self._s_children:
            self._s_children.append(child)
        take(child, values)
        self._s_edited(child._s_all_objects())
        return child

    createChild = addChild

    def _s_is_below(self, other):
        return self is other or any(parent._s_is_below(other) for parent in self._s_parents)

    def removeChild(self, child):
        child = self.getChild(child) if isinstance(child, str) else child
        if child not in self._s_children:
            raise ValueError(f"{self._s_place()}: has no child {child!r}")
        self._s_children.remove(child)
        child._s_parents.remove(self)
        self._s_edited(child._s_all_objects())

    def moveChild(self, child, parent=None):
        """From `parent`, else from all that it has, to this node."""
        for before in list(child._s_parents) if parent is None else [parent]:
            before.removeChild(child)
        self.addChild(child)

    def detachFromGraph(self):
        for parent in list(self._s_parents):
            parent.removeChild(self)

    detach = detachFromGraph

    def getChild(self, name, *_, **_options):
        for each in self._s_children:
            if each._s_name == str(name):
                return each
        if "/" in str(name):
            found = self._s_walk([step for step in str(name).split("/") if step])
            return found if isinstance(found, Node) else None
        return None

    def hasChild(self, name):
        return self.getChild(name) is not None

    @property
    def children(self):
        return Sequence(self, self._s_children, self.removeChild)

    def getChildren(self):
        return list(self._s_children)

    @property
    def parents(self):
        return Sequence(self, self._s_parents, lambda parent: parent.removeChild(self))

    def getParents(self):
        return list(self._s_parents)

    def getAncestors(self):
        found, ancestors = self, []
        while found._s_parents:
            found = found._s_above()
            ancestors.append(found)
        return ancestors

    def hasParent(self, other=None):
        return bool(self._s_parents) if other is None else other in self._s_parents

    def getRootContext(self):
        return self.getRoot()

    def getContext(self):
        return self

    def getRootPath(self):
        return "../" * len(self.getAncestors())

    def _s_walk(self, steps):
        """Where the steps of a path lead from here: an object, a node, or None."""
        here = self
        for index, step in enumerate(steps):
            if step == ".":
                continue
            if step == "..":
                here = here._s_node()
            else:
                last = index + 1 == len(steps)
                found = here.getObject(step) if last else None
                here = found if found is not None else here.getChild(step)
            if here is None or (isinstance(here, Object) and index + 1 < len(steps)):
                return None if here is None or index + 1 < len(steps) else here
        return here

    def _s_attribute(self, name):
        data = self._s_data.get(name) or self.findData(name)
        if data is not None:
            return data
        for found in (self.getChild(name), self.getObject(name)):
            if found is not None:
                return found
        return self._s_by_role(name)

    def __dir__(self):
        return sorted({*super().__dir__(), *(each._s_name for each in self._s_objects + self._s_children if each._s_name.isidentifier())})

    def _s_no_data(self, name):
        names = [each._s_name for each in self._s_objects + self._s_children] + self._s_data_names()
        near = _messages.nearest(name, names)
        return f"{self._s_place()}: the node has no child, object or data '{name}'" + (f"; did you mean '{near}'?" if near else "")

    def _s_edited(self, moved):
        """Something came or went: a running scene is made anew before the next step."""
        self._s_tell_root(moved)
        engine = self._s_engine()
        if engine is not None:
            engine.edited()

    # ---- by their roles ----
    def _s_of_role(self, role):
        return list(self._s_roles().get(role, ()))

    def _s_roles(self):
        """Objects by their role. Kept, and longer with each that comes; begun anew when one has gone."""
        kept = self.__dict__.get("_s_kept_roles")
        if kept is None or kept[0] is not self._s_objects:
            object.__setattr__(self, "_s_kept_roles", kept := [self._s_objects, 0, {}])
        for each in self._s_objects[kept[1]:]:
            if each._s_type:
                kept[2].setdefault(each._s_facts.role, []).append(each)
        kept[1] = len(self._s_objects)
        return kept[2]

    def _s_first_of(self, role):
        found = self._s_of_role(role)
        return found[0] if found else None

    def getMechanicalState(self):
        return self._s_first_of("mechanical state")

    getState = getMechanicalState

    def getMass(self, *_):
        return self._s_first_of("mass")

    def getForceField(self, index=0):
        found = self._s_of_role("force field") + [each for each in self._s_objects if not each._s_type and hasattr(each, "addForce")]
        return found[index] if 0 <= index < len(found) else None

    def getMechanicalMapping(self, *_):
        return self._s_first_of("mapping") or next((each for each in self._s_objects if isinstance(each, Mapping)), None)

    def getODESolver(self, *_):
        return self._s_first_of("integrator")

    def hasODESolver(self):
        return self.getODESolver() is not None

    def getLinearSolver(self):
        return self._s_first_of("linear solver")

    def getMeshTopology(self, *_):
        return self._s_first_of("topology")

    getTopology = getMeshTopology

    def getMeshTopologyLink(self):
        return self.getMeshTopology()

    def _s_by_role(self, name):
        """`node.mass`, `node.forceField`: when nothing has that name."""
        if name in ("mass", "state", "mechanicalState", "odeSolver", "linearSolver", "meshTopology", "mechanicalMapping"):
            return {"mass": self.getMass, "odeSolver": self.getODESolver, "linearSolver": self.getLinearSolver,
                    "meshTopology": self.getMeshTopology, "mechanicalMapping": self.getMechanicalMapping}.get(
                        name, self.getMechanicalState)()
        role = {"forceField": "force field", "projectiveConstraintSet": "projective constraint"}.get(name)
        return Sequence(self, self._s_of_role(role), self.removeObject) if role else None

    # ---- running ----
    def init(self):
        from . import _engine

        if not self._s_parents:
            _engine.initialise(self)

    def isInitialized(self):
        return self._s_engine() is not None

    def reinit(self):
        engine = self._s_engine()
        if engine is not None:
            engine.edited()

    def reset(self):
        from . import _engine

        _engine.reset(self.getRoot())

    def simulationStep(self, dt=0.0):
        from . import _engine

        _engine.animate(self.getRoot(), dt)

    def computeEnergy(self):
        engine = self._s_engine()
        energies = engine.sim.energies() if engine is not None else {}
        return energies.get("kinetic", 0.0), energies.get("elastic", 0.0) + energies.get("gravity", 0.0)

    def getClassName(self):
        return "DAGNode" if type(self) is Node else type(self).__name__

    def _s_all_objects(self, seen=None):
        """In SOFA's order: objects of a node, then its children, each once."""
        seen = set() if seen is None else seen
        if id(self) in seen:
            return
        seen.add(id(self))
        yield from list(self._s_objects)
        for child in list(self._s_children):
            yield from child._s_all_objects(seen)

    def _s_prefer_parents_here(self):
        """Of several parents values are asked of the first in this tree: the first of all may hang nowhere. The list stays as it is."""
        nodes = list(self._s_all_nodes())
        here = {id(node) for node in nodes}
        for node in nodes:
            object.__setattr__(node, "_s_lead", next((parent for parent in node._s_parents if id(parent) in here), None))

    def _s_all_nodes(self, seen=None):
        seen = set() if seen is None else seen
        if id(self) in seen:
            return
        seen.add(id(self))
        yield self
        for child in list(self._s_children):
            yield from child._s_all_nodes(seen)


def followed_paths(thing, data, value):
    """The same of what is set later, for whole paths: others stay right where the tree is put somewhere."""
    words = value if isinstance(value, (list, tuple)) else [value]
    return _followed(thing, data, value) if all(isinstance(each, str) and each.lstrip().startswith("@/") for each in words) else value


def _followed(thing, data, value):
    """Links as text: what they lead to now, wherever the tree is put later. What they do not reach yet stays text."""
    if isinstance(value, (list, tuple)) and any(_values.is_link_text(each) for each in value):
        return [_followed(thing, data, each) for each in value]
    if not isinstance(value, str) or not value.lstrip().startswith("@"):
        return value
    found = []
    for link in _values.links_in(value):
        target = thing._s_linked(link, data._s_name)
        if target is not None:
            found.append(link if target is data else target)
        else:  # words behind a link
            words = [(thing._s_linked(word, data._s_name) if word.startswith("@") else None, word) for word in link.split()]
            found += [word if leads is None or leads is data else leads for leads, word in words]
    return found[0] if len(found) == 1 else found


def _frozen(value):
    """As it is now: a scene may change its lists and arrays afterwards."""
    if isinstance(value, np.ndarray):
        return np.array(value)
    if isinstance(value, (list, tuple)) or (hasattr(value, "__iter__") and not isinstance(value, (str, bytes, Base, Data))):
        return [_frozen(each) for each in value]  # a range, or what can be read once only
    return value


def _class_of(word):
    """The class of Python for a type."""
    from ._carving import CarvingManager
    from ._contacts import ContactListener
    from ._equations import ConstraintSolver, Solves
    from ._modifier import Modifier

    if word.endswith("SetTopologyModifier"):
        return Modifier
    facts = _catalogue.facts(word)
    if word.endswith("LinearSystem") or facts.role == "linear solver":
        return Solves
    if facts.besides is _catalogue.CONSTRAINTS:
        return ConstraintSolver
    return {"ContactListener": ContactListener, "CarvingManager": CarvingManager}.get(word, Object)
