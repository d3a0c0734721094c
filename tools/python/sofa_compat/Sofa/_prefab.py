# SPDX-License-Identifier: LGPL-2.1-or-later
"""Prefabs: nodes with parameters, which a class of the scene fills."""
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
        data = self.addData(name, value=self._s_given.get(name, default), type=type, help=help, group=group)
        self._s_parameters.append(name)
        return data

    def setSourceTracking(self, *_):
        pass

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
        if data._s_name in self.__dict__.get("_s_parameters", ()) and self.__dict__.get("_s_filled"):
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
        self.init()
        object.__setattr__(self, "_s_filled", True)

    def definePrefabParameters(self, *_):
        pass


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
