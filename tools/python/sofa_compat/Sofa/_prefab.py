# SPDX-License-Identifier: LGPL-2.1-or-later
"""Prefabs: nodes with parameters, which a class of the scene fills."""
import weakref

from . import _messages, _values
from ._base import _kind_of
from ._data import Data
from ._node import Node


class RawPrefab(Node):
    """Its init() fills it; parameters are data that it declares by addPrefabParameter()."""

    def __init__(self, *arguments, **values):
        object.__setattr__(self, "_s_given", dict(values))
        super().__init__(*arguments[:1], **{name: value for name, value in values.items() if name in ("name", "gravity", "dt")})
        object.__setattr__(self, "_s_parameters", [])

    def addPrefabParameter(self, name, default=None, type=None, help="", group="", *_):
        if name == "name":
            self.setName(self._s_given.get("name", default) or self._s_name)
            return self.findData("name")
        given = self._s_given.get(name, default)
        kind = _kind_of(type, given)
        if isinstance(given, str) and isinstance(kind, (int, float)) and not len(_values.numbers_of(given)) and given.lower() not in (
                "true", "false"):
            raise ValueError(f"{self._s_place()}.{name}: '{given}' is no {type}")
        data = self.addData(name, value=given, type=type, help=help, group=group)
        self._s_parameters.append(name)
        self._s_follow_source(given)
        return data

    def _s_follow_source(self, source):
        """It is filled anew when data that give a parameter its value have another one."""
        while isinstance(source, Data):
            source._s_owner.__dict__.setdefault("_s_followers", {}).setdefault(source._s_name, weakref.WeakSet()).add(self)
            source = source._s_raw

    def setSourceTracking(self, *_):
        """SOFA fills it anew when this file changes, while its window is open."""

    def init(self):
        """Fills the prefab."""

    def reinit(self):
        self.doReInit()

    def doReInit(self):
        """Parameters have other values: it is filled anew."""
        for thing in list(self._s_objects):
            self.removeObject(thing)
        for child in list(self._s_children):
            self.removeChild(child)
        self.init()

    def _s_write(self, data, value):
        super()._s_write(data, value)
        if data._s_name in self.__dict__.get("_s_parameters", ()):
            self._s_follow_source(value)
            self._s_source_changed()

    def _s_source_changed(self):
        if self.__dict__.get("_s_filled"):
            self.doReInit()


class Prefab(RawPrefab):
    """Parameters in a list of the class: prefabParameters = [{"name": ..., "type": ..., "help": ..., "default": ...}]."""

    prefabParameters = []
    prefabData = []
    properties = []

    def __init__(self, *arguments, **values):
        super().__init__(*arguments, **values)
        if "name" not in values and not arguments:
            self.setName(type(self).__name__)
        self.addData("prefabname", value=type(self).__name__, type="string", group="Infos", help="name of the prefab")
        self.addData("docstring", value=type(self).__doc__ or "", type="string", group="Infos", help="what it is")
        for parent in values.get("parents") or ([values["parent"]] if values.get("parent") is not None else []):
            parent.addChild(self)
        for each in [*self.properties, *self.prefabParameters]:
            self.addPrefabParameter(name=each["name"], type=each.get("type"), help=each.get("help", ""), default=each.get("default"))
        for each in self.prefabData:
            self.addData(each["name"], value=values.get(each["name"], each.get("default")), type=each.get("type"),
                         help=each.get("help", ""), group=each.get("group", ""))
        self._s_tell_of_mistakes(values)
        self.init()
        object.__setattr__(self, "_s_filled", True)

    def _s_tell_of_mistakes(self, values):
        """Other arguments are those of the class itself, unless they are nearly the name of a parameter."""
        names = [*self._s_parameters, *(each["name"] for each in self.prefabData)]
        for name in values:
            near = _messages.nearest(name, names) if name not in (*names, "name", "parent", "parents") else ""
            if near:
                _messages.warn(f"{self._s_place()}: {type(self).__name__} has no parameter '{name}'; did you mean '{near}'?")


def PrefabBuilder(function):
    """A function whose arguments are the parameters of a prefab, which it fills: f(self, radius=1.0)."""
    import inspect

    names = inspect.getfullargspec(function)
    defaults = dict(zip(names.args[len(names.args) - len(names.defaults or ()):], names.defaults or ()))

    def build(*arguments, **values):
        prefab = RawPrefab(*arguments, **{"name": function.__name__, **values})
        for name, default in defaults.items():
            prefab.addPrefabParameter(name=name, default=default)
        function(prefab, **{name: prefab.findData(name).value for name in defaults})
        return prefab

    build.__original__ = function
    return build
