# SPDX-License-Identifier: LGPL-2.1-or-later
"""The tree of a scene as the engine takes it: every component with its attributes, the line of the scene it comes from, and
links as absolute paths. Data of Python have no place there: their values are written, and handed on when they change."""
import os

import numpy as np
import stroma

from . import _messages, _values
from ._base import Base
from ._carving import CarvingManager
from ._data import Data
from ._mapping import Mapping, Played as PlayedMapping
from ._objects import ForceField, Object

_LONG = 64  # numbers that are handed on as an array


def _clean(name):
    """A name that a path can have."""
    return "".join("_" if each in " /.@[]\"'<>" else each for each in name) or "unnamed"


_here = None  # the folder that stands on the path for being the current one


def _search_here():
    """Relative names of files start in the current folder too, after all others: a program need not lie beside its meshes. A
    folder that it has left is searched no more."""
    global _here
    folders = [each for each in os.environ.get("STROMA_DATA_PATH", "").split(os.pathsep) if each]
    if _here in folders:
        folders.pop(len(folders) - 1 - folders[::-1].index(_here))
    _here = os.getcwd() if os.getcwd() not in folders else None
    os.environ["STROMA_DATA_PATH"] = os.pathsep.join([*folders, _here] if _here else folders)


class Mirror:
    """`root`: the engine's tree. `paths`: of each object and node, by id. `dependents`: (data of a component, data of Python that
    gives its value). `written_as`: (type, names of attributes) of what is written as another component, None of all else;
    where it is given, nodes that are switched off are there too. `part`: (objects, nodes) by id, of what alone is there."""

    def __init__(self, root, wanted=lambda thing: True, keep_loaders=False, written_as=None, part=None):
        _search_here()
        self.paths, self.dependents, self.things = {}, [], {}
        self._wanted, self._loaders, self._played = wanted, [], []
        self._keep_loaders, self._written_as = keep_loaders, written_as
        self._has_python = not keep_loaders and any(not each._s_type for each in root._s_all_objects())
        self._part = None if part is None else _by_node(part[0])
        self._reachable = set(part[1]) if part else {id(node) for node in root._s_all_nodes()}
        if self._has_python:
            self._acting = _ACTING if any(_looks_for_contacts(each) for each in root._s_all_objects()) else _ACTING - {"collision model"}
            self._has_integrator = any(_is_moved(node) for node in root._s_all_nodes())
        self._name_all(root, "")
        self.root = stroma.Node(_clean(root._s_name or "root"), strict=False, dialect="sofa", where=root._s_where)
        self._fill(root, self.root, set())
        if keep_loaders:  # what reads nothing but a loader leaves it in the scene
            for index, path in enumerate(self._loaders):
                child = self.root.add_child(f"preview_of_loaders_{index}")
                child.add("MeshTopology", name="mesh").set("src", "@" + path, where=root._s_where)

    def _objects_of(self, node):
        return node._s_objects if self._part is None else self._part.get(id(node), ())

    def _children_of(self, node):
        return [child for child in node._s_children if id(child) in self._reachable and self._place_of(child) is node]

    def _name_all(self, node, path):
        if id(node) in self.paths:
            return
        self.paths[id(node)] = path or "/"
        self.things[id(node)] = node
        taken = set()

        def free(name):
            name, number = _clean(name), 2
            while name in taken:
                name, number = f"{_clean(name)}_{number}", number + 1
            taken.add(name)
            return name

        for each in self._objects_of(node):
            if each._s_type and self._wanted(each):
                self.paths[id(each)] = f"{path}/{free(each._s_name)}"
                self.things[id(each)] = each
        for child in self._children_of(node):
            if id(child) not in self.paths:
                self._name_all(child, f"{path}/{free(child._s_name)}")

    def _place_of(self, node):
        """Of several parents the one below an integrator, which moves it there; else the first."""
        parents = [each for each in node._s_parents if id(each) in self._reachable]
        return next((each for each in parents if _is_moved(each)), parents[0])

    def _fill(self, node, copy, seen):
        seen.add(id(node))
        for name in ("gravity", "dt", "time", "activated"):
            data = node._s_data.get(name)
            if data is not None and data._s_raw is not None:
                value = data.value
                if name != "activated" or not (value or self._written_as):
                    copy.set(name, _values.to_text(value), where=node._s_where)
        for each in self._objects_of(node):
            if id(each) in self.paths and each._s_type and not isinstance(each, CarvingManager):
                self._add(each, copy)
            elif isinstance(each, ForceField) and not self._keep_loaders:
                self._add_force_field(each, copy)
            elif isinstance(each, Mapping) and not self._keep_loaders:
                self._add_mapping(each, copy)
        self._add_mover(node, copy)
        for child in self._children_of(node):
            if id(child) not in seen:
                path = self.paths[id(child)]
                self._fill(child, copy.add_child(path.rsplit("/", 1)[-1], where=child._s_where), seen)

    def _add(self, thing, copy):
        path = self.paths[id(thing)]
        kind, names = (self._written_as and self._written_as(thing)) or (thing._s_facts.written, None)
        component = copy.add(kind, name=path.rsplit("/", 1)[-1], where=thing._s_where)
        if thing._s_facts.role == "mesh loader":
            self._loaders.append(path)
        for name, data in thing._s_data.items():
            if name == "name" or data._s_raw is None or name in thing.__dict__.get("_s_added", ()):
                continue
            if name == "src" and self._gives_nothing(thing, data):
                continue
            value = self._value(thing, data)
            if value is not None and (names is None or name in names):
                component.set(names[name] if names else name, value, where=thing._s_where)

    @staticmethod
    def _gives_nothing(thing, data):
        """A source that has no attribute of this component: in SOFA nothing is taken from it."""
        raw = data._s_raw
        source = raw if isinstance(raw, Object) else thing._s_linked(raw, "src") if _values.is_link_text(raw) else None
        if not isinstance(source, Object) or source._s_facts is None or source._s_facts.info is None or thing._s_facts.info is None:
            return False
        taken = {"name", "src"}
        if (set(source._s_facts.names()) & set(thing._s_facts.names())) - taken:
            return False
        _messages.warn(f"{thing._s_place()}.src: {source.getPathName()} has no attribute of it: nothing is taken from there")
        return True

    def _add_mover(self, node, copy):
        """A state that nothing moves, in a scene with controllers: they may put it elsewhere, and springs follow it."""
        if not self._has_python or _is_moved(node):
            return
        states = _of_role(node, "mechanical state")
        if len(states) == 1 and not _acts(node, self._acting) and not self._is_held(node):
            copy.add("EulerExplicitSolver", name="moved_by_the_scene", where=states[0]._s_where)

    def _is_held(self, node):
        """Another state is mapped from the one here: the dialect holds it (tools/sofa/rewritten_bodies.cpp)."""
        below = [child for child in node._s_children if self._place_of(child) is node]
        return self._has_integrator and any(any(map(_is_mapping, child._s_objects)) and _of_role(child, "mechanical state") for child in below)

    def _add_force_field(self, field, copy):
        """One that the scene writes in Python."""
        from . import _force_field

        state = field._s_node().getMechanicalState()
        nodes = len(state.findData("position").value) if state is not None else 0
        played = _force_field.played(field, nodes)
        self._played.append(played)
        copy.add("PythonForceField", name=_clean(field._s_name), where=field._s_where).set("played", played.number, where=field._s_where)

    def _add_mapping(self, mapping, copy):
        """The same of one of those."""
        states = {name: self._path_to(mapping._s_state(name)) for name in ("input", "output") if mapping._s_state(name) is not None}
        played = PlayedMapping(mapping=mapping) if len(states) == 2 else None
        self._played.append(played)
        component = copy.add("PythonMapping", name=_clean(mapping._s_name), where=mapping._s_where)
        for name, value in {**states, "played": played and played.number}.items():
            if value is not None:
                component.set(name, value, where=mapping._s_where)
        for name in ("mapForces", "mapMasses"):  # what they mean is the dialect's
            if mapping.findData(name)._s_raw is not None:
                component.set(name, _values.to_text(mapping.findData(name)._s_raw), where=mapping._s_where)

    def _value(self, thing, data):
        raw = data._s_raw
        if isinstance(raw, Data):
            return self._link_to(raw, data)
        if isinstance(raw, Base):
            return self._path_to(raw)
        if _values.is_link_text(raw):
            return self._followed(thing, data, raw)
        if isinstance(raw, (list, tuple)):
            if any(isinstance(each, (Base, Data)) or _values.is_link_text(each) for each in _values.flat(raw)):
                return " ".join(str(self._item(thing, data, each)) for each in _values.flat(raw))
            try:
                array = np.array(raw)
            except ValueError:  # rows of different lengths
                array = None
            if array is not None and array.dtype.kind in "iuf" and array.size >= _LONG:
                raw = array
        if isinstance(raw, np.ndarray) and raw.size >= _LONG and raw.dtype.kind in "iuf":
            return raw
        return _values.to_text(raw)

    def _item(self, thing, data, item):
        if isinstance(item, Data):
            return self._link_to(item, data)
        if isinstance(item, Base):
            return self._path_to(item) or ""
        return self._followed(thing, data, item) if _values.is_link_text(item) else _values.to_text(item)

    def _followed(self, thing, data, text):
        """A link as text: absolute when it leads somewhere, else as it is, to be told."""
        links = _values.links_in(text)
        if len(links) > 1:
            return " ".join(self._followed(thing, data, link) or link for link in links)
        target = thing._s_linked(text, data._s_name)
        if target is None and len(text.split()) > 1:  # words behind a link
            return " ".join(self._followed(thing, data, word) if word.startswith("@") else word for word in text.split())
        if isinstance(target, Data):
            return self._link_to(target, data)
        return (self._path_to(target) if target is not None else None) or text

    def _path_to(self, thing):
        path = self.paths.get(id(thing))
        return None if path is None else "@" + path

    def _link_to(self, source, data):
        owner = source._s_owner
        path = self.paths.get(id(owner))
        is_theirs = isinstance(owner, Object) and owner._s_type and path is not None
        if is_theirs and (owner._s_facts.find(source._s_name) is not None or owner._s_facts.missing):
            return f"@{path}.{source._s_name}"
        self.dependents.append((data, source))
        value = source.value
        return value if isinstance(value, np.ndarray) and value.size >= _LONG else _values.to_text(value)


def _by_node(things):
    """Lists of a part, in the order of the scene."""
    found = {}
    for each in sorted(things.values(), key=lambda thing: thing._s_order):
        found.setdefault(id(each._s_node()), []).append(each)
    return found


_ACTING = {"collision model", "mass", "force field", "projective constraint", "position constraint", "integrator"}


def _acts(node, acting):
    """Whether a state here has forces, masses, constraints or surfaces that touch others, on it or below, or follows another."""
    return any(_is_mapping(each) for each in node._s_objects) or any(
        each._s_type and each._s_facts.role in acting for each in node._s_all_objects())


def _is_mapping(thing):
    return isinstance(thing, Mapping) or bool(thing._s_type and thing._s_facts.role == "mapping")


def _looks_for_contacts(thing):
    return bool(thing._s_type) and thing._s_facts.info is not None and thing._s_facts.info.type == "CollisionPipeline"


def _of_role(node, role):
    return [each for each in node._s_objects if each._s_type and each._s_facts.role == role]


def _is_moved(node):
    return any(each._s_type and each._s_facts.role == "integrator" for each in node._s_objects) or any(
        _is_moved(parent) for parent in node._s_parents)
