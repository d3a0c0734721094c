# SPDX-License-Identifier: LGPL-2.1-or-later
"""What nodes and objects share: a name, data by name, a place in the tree, and messages that name where a scene made them."""
import itertools
import os
import sys

from . import _messages, _values
from ._data import Data, DataDict, made

_PACKAGE = os.path.dirname(os.path.abspath(__file__))


class NoData(AttributeError):
    """There is nothing of that name. Its sentence is made when somebody reads it: libraries ask for much that is not there."""

    def __init__(self, thing, name):
        super().__init__(name)
        self._s_asked = thing, name

    def __str__(self):
        thing, name = self._s_asked
        return thing._s_no_data(name)


NoData.__name__ = NoData.__qualname__ = AttributeError.__name__  # as which it is told


def caller():
    """(file, line) of the code outside of this package that is running."""
    frame = sys._getframe(1)
    while frame and os.path.abspath(frame.f_code.co_filename).startswith(_PACKAGE):
        frame = frame.f_back
    return (frame.f_code.co_filename, frame.f_lineno) if frame else ("", 0)


#: no two alike, for whatever changes
_versions = itertools.count(1)
#: data of everything
_COMMON = {"name": "", "printLog": False, "listening": False, "tags": "", "bbox": None, "componentState": "Valid"}


class LinkPath(str):
    """`object.linkpath`: a link as text, which knows what it leads to."""

    def target(self):
        return self._s_target

    def isPointingToData(self):
        return isinstance(self._s_target, Data)


def link_path_of(thing):
    found = LinkPath(thing.getLinkPath())
    found._s_target = thing
    return found


class Base:
    """Has data. Attributes of Python are those of its class, then its data, then what a scene keeps on it."""

    def __new__(cls, *_arguments, **_keywords):
        # here and not in __init__, which classes of a scene may forget to call
        self = super().__new__(cls)
        put = object.__setattr__
        put(self, "_s_data", {})
        put(self, "_s_name", "")
        put(self, "_s_parents", [])
        put(self, "_s_lead", None)
        put(self, "_s_where", caller())
        put(self, "_s_version", next(_versions))
        put(self, "_s_revision", 0)
        put(self, "_s_shape", 0)
        return self

    # ---- the name and the place ----
    def getName(self):
        return self._s_name

    def setName(self, name):
        object.__setattr__(self, "_s_name", str(name))
        self._s_changed()

    def _s_above(self):
        """The parent of which values are asked: the first, unless that hangs nowhere and another does not."""
        if self._s_lead is not None and self._s_lead in self._s_parents:
            return self._s_lead
        return self._s_parents[0] if self._s_parents else None

    def _s_node(self):
        return self._s_above()

    def getRoot(self):
        found = self
        while found._s_parents:
            found = found._s_above()
        return found

    def getContext(self):
        return self._s_node()

    def getPathName(self):
        parts, found = [], self
        while found._s_parents:
            parts.append(found._s_name)
            found = found._s_parents[0]
        return "/" + "/".join(reversed(parts))

    def getLinkPath(self):
        return "@" + self.getPathName()

    # ---- where it comes from: where the scene made it, unless the scene says otherwise. Messages name the line that made it. ----
    def _s_said_place(self, kind, part, value=None):
        place = self.__dict__.setdefault("_s_said_places", {}).setdefault(kind, list(self._s_where))
        if value is not None:
            place[part] = value
        return place[part]

    def getDefinitionSourceFileName(self):
        return self._s_said_place("definition", 0)

    def setDefinitionSourceFileName(self, name):
        self._s_said_place("definition", 0, str(name))

    def getDefinitionSourceFilePos(self):
        return self._s_said_place("definition", 1)

    def setDefinitionSourceFilePos(self, line):
        self._s_said_place("definition", 1, int(line))

    def getInstanciationSourceFileName(self):
        return self._s_said_place("instance", 0)

    getInstanciationFileName = getInstanciationSourceFileName

    def setInstanciationSourceFileName(self, name):
        self._s_said_place("instance", 0, str(name))

    def getInstanciationSourceFilePos(self):
        return self._s_said_place("instance", 1)

    def setInstanciationSourceFilePos(self, line):
        self._s_said_place("instance", 1, int(line))

    def _s_place(self):
        return f"{self._s_where[0]}:{self._s_where[1]}: {self.getPathName()}"

    def _s_engine(self):
        return getattr(self.getRoot(), "_s_running", None)

    def _s_changed(self):
        """It has other values: what was computed from them is computed again."""
        object.__setattr__(self, "_s_version", next(_versions))
        self._s_tell_root([self], False)

    def _s_tell_root(self, changed, is_other_tree=True):
        """Objects came, went or have other values."""
        root = self.getRoot()
        object.__setattr__(root, "_s_revision", next(_versions))
        if is_other_tree:
            object.__setattr__(root, "_s_shape", next(_versions))
        register = root.__dict__.get("_s_register")
        if register is not None:
            register.fresh.update((id(each), each) for each in changed)

    # ---- data ----
    def _s_sample_of(self, name):
        """(a value of the data's kind, help) of data that exist though a scene does not write them, or None."""
        return (_COMMON[name], "") if name in _COMMON else None

    def _s_present_name(self, name):
        """The name under which the data is kept: aliases are one data."""
        return name

    def _s_data_names(self):
        return sorted(set(self._s_data) | set(_COMMON))

    def findData(self, name):
        name = self._s_present_name(str(name))
        if name in self._s_data:
            return self._s_data[name]
        found = self._s_sample_of(name)
        if found is None:
            return None
        data = self._s_data[name] = made(self, name, None, *found)
        return data

    def getData(self, name, *_):
        return self.findData(name)

    def _s_no_data(self, name):
        if name in ("getKineticEnergy", "getPotentialEnergy"):
            return f"{self._s_place()}: {name}() is not offered here: computeEnergy() of a node has both energies of the whole scene"
        if name in ("A", "b", "W"):
            return f"{self._s_place()}: {name}() is one of " + (
                "constraint solvers" if name == "W" else "linear solvers and linear systems") + f", and not of a {self.getClassName()}"
        near = _messages.nearest(name, self._s_data_names() + [each for each in dir(type(self)) if each[0] != "_"])
        return f"{self._s_place()}: has no data '{name}'" + (f"; did you mean '{near}'?" if near else "")

    def getDataFields(self):
        return [self.findData(name) for name in self._s_data_names()]

    getDataList = getDataFieldsList = getDataFields

    @property
    def __data__(self):
        return DataDict((name, self.findData(name)) for name in self._s_data_names())

    def getLinks(self):
        """Data that lead to an object or a node."""
        return [data for data in self.getDataFields() if data.isSet() and data.getLinkedBase() is not None]

    def findLink(self, name):
        return self.findData(name)

    def addData(self, name, value=None, default=None, help="", group="", type=None, *_):
        known = name._s_name if isinstance(name, Data) else str(name)
        if self._s_sample_of(known) is None:  # the component has none of that name: it is the program's alone
            self.__dict__.setdefault("_s_added", set()).add(known)
        if isinstance(name, Data):  # addData(data)
            return self._s_add_data(name._s_name, name, None, name._s_help, name._s_group)
        given = value if value is not None else default
        return self._s_add_data(known, given, _kind_of(type, given), help, group)

    def addLink(self, name, value=None, help="", *_):
        """Data that lead to an object or a node."""
        return self.addData(name, value=value, help=help)

    def addNewData(self, name, group="", help="", type=None, value=None):
        return self.addData(name, value=value, type=type, help=help, group=group)

    def _s_add_data(self, name, given, sample, help, group):
        raw = given if isinstance(given, Data) or given is None else _values.copied(given)
        data = made(self, name, raw, sample, help, group)
        self.__dict__.pop(name, None)  # what the scene kept under this name
        self._s_data[name] = data
        return data

    def setDataValues(self, **values):
        for name, value in values.items():
            self._s_assign(name, value)

    def _s_assign(self, name, value):
        """As an argument: data and objects are links."""
        data = self.findData(name)
        if data is None:
            raise NoData(self, name)
        if isinstance(value, Data):
            data.setParent(value)
        else:
            data.value = value

    # ---- how data are read and written; objects of a running scene do it otherwise ----
    def _s_read(self, data):
        if data._s_name == "name":
            return self._s_name
        raw = data._s_raw
        if isinstance(raw, Data):
            return self._s_formed(data, raw.value)
        if _values.is_link_text(raw):
            target = self._s_linked(raw, data._s_name)
            if isinstance(target, Data) and target is not data:
                return self._s_formed(data, target.value)
            if target is not None or isinstance(data._s_sample, str):
                return raw
        if raw is None:
            return _values.copied(data._s_sample)
        return self._s_formed(data, raw)

    def _s_formed(self, data, value):
        return _values.by_itself(value) if data._s_sample is None else _values.like(data._s_sample, value)

    def _s_write(self, data, value):
        if data._s_name == "name":
            return self.setName(value)
        from ._node import followed_paths

        data._s_raw = followed_paths(self, data, value) if isinstance(value, (str, list, tuple)) and len(value) else value
        self._s_changed()
        for prefab in list(self.__dict__.get("_s_followers", {}).get(data._s_name, ())):
            prefab._s_source_changed()
        return None

    # ---- links ----
    def _s_linked(self, text, own_name=None):
        """What a link leads to from here: an object, a node, data, or None."""
        links = _values.links_in(text)
        if len(links) != 1:
            return None
        path, data = links[0][1:], None
        tail = path.rsplit("/", 1)[-1]
        dot = tail.find(".", tail.find("]") + 1)  # of [-1].position after the number
        if dot >= 0 and tail not in (".", ".."):
            path, data = path[: len(path) - len(tail) + dot], tail[dot + 1:]
        found = None if data and " " in data else self._s_follow(path)
        return found.findData(data) if found is not None and data else found

    def _s_follow(self, path):
        from ._node import Node

        here = self if isinstance(self, Node) else self._s_node()
        if here is None:
            return None
        if path.startswith("/"):
            return self.getRoot()._s_walk([step for step in path.split("/") if step])
        if path.startswith("["):  # counted from here: [-1] is the one before
            objects = here._s_objects
            index = (objects.index(self) if self in objects else 0) + int(path.strip("[]") or 0)
            return objects[index] if 0 <= index < len(objects) else None
        steps = [step for step in path.split("/") if step]
        if not steps or steps[0] in (".", ".."):
            return here._s_walk(steps)
        while here is not None:
            found = here._s_walk(steps)
            if found is not None:
                return found
            here = here._s_node()
        return None

    # ---- attributes of Python ----
    def __getattr__(self, name):
        if name.startswith("__") or name in ("_s_running", "_s_revision", "_s_shape", "_s_version", "_s_data"):
            raise AttributeError(name)
        found = link_path_of(self) if name == "linkpath" else self._s_attribute(name)
        if found is None:
            raise NoData(self, name)
        return found

    def _s_attribute(self, name):
        return self.findData(name)

    def __dir__(self):
        return sorted({*super().__dir__(), *(name for name in self._s_data_names() if name.isidentifier())})

    def __setattr__(self, name, value):
        if name == "name":
            return self.setName(value.value if isinstance(value, Data) else value)
        is_own = name.startswith("_") or name in self.__dict__ or hasattr(type(self), name)
        if not is_own and self.findData(name) is not None:
            return self._s_assign(name, value)
        if not is_own:
            self._s_keeps(name)
        return object.__setattr__(self, name, value)

    def _s_keeps(self, name):
        """A scene keeps something of its own on this."""

    @property
    def name(self):
        return self.findData("name")

    # ---- what SOFA's objects answer ----
    def getClassName(self):
        return type(self).__name__

    def getTemplateName(self):
        return ""

    def getClass(self):
        return type(self)

    def getHelp(self):
        return ""

    # ---- messages that a scene has sent in its name, by Sofa.Helper.msg_error(object, text) ----
    def _s_logged(self, kind, text):
        self.__dict__.setdefault("_s_messages", []).append(f"[{kind}] {text}")

    def clearLoggedMessages(self):
        self.__dict__.pop("_s_messages", None)

    def countLoggedMessages(self, *_):
        return len(self.__dict__.get("_s_messages", ()))

    def getLoggedMessagesAsString(self, *_):
        return "\n".join(self.__dict__.get("_s_messages", ()))

    def getTags(self):
        return str(self.findData("tags")).split()

    def hasTag(self, tag):
        return str(tag) in self.getTags()

    def addTag(self, tag):
        if not self.hasTag(tag):
            self.findData("tags").value = " ".join([*self.getTags(), str(tag)])

    def removeTag(self, tag):
        self.findData("tags").value = " ".join(each for each in self.getTags() if each != str(tag))

    def computeBBox(self, *_):
        """`bbox` is computed when it is read."""

    def sendEvent(self, value, name="PythonScript", *_):
        """onPythonScriptEvent() of all controllers hears it, with the sender, the name and the value."""
        from . import _events

        _events.user_event(self, name, value)

    def getAsACreateObjectParameter(self):
        return self.getLinkPath()

    def __getitem__(self, path):
        """"data", or of a node "child.object.data"."""
        found = self
        for step in str(path).replace("/", ".").split("."):
            if not step:
                continue
            found = found._s_attribute(step) if isinstance(found, Base) else None
            if found is None:
                raise KeyError(f"{self._s_place()}: has no '{path}'")
        return found

    def __repr__(self):
        return f"<{self.getClassName()} {self.getPathName()}>"


def _kind_of(word, given):
    """A value of the kind that addData() names: "vector<float>", "bool"."""
    import numpy as np

    if word is None:
        return None
    word = str(word).replace(" ", "")
    plain = {"bool": False, "int": 0, "unsignedint": 0, "float": 0.0, "double": 0.0, "string": "", "PrefabLink": ""}
    if word in plain:
        return plain[word] if not _values.is_link_text(given) or word == "string" else None
    if word.startswith("vector<vector"):  # rows of different lengths
        return None
    if "string" in word:
        return []
    if word.startswith("vector<") and any(each in word for each in ("<int", "<unsigned", "<bool")):
        return np.zeros(0, dtype=np.int32)
    if word.startswith(("Quat", "RigidCoord", "RigidDeriv")):
        return np.zeros(0)
    for columns in (2, 3, 4, 6, 7):
        if f"Vec{columns}" in word and word.startswith("vector"):
            return np.zeros((0, columns))
    return np.zeros(0) if word.startswith(("vector", "Vec")) else None
