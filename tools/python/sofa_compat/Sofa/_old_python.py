# SPDX-License-Identifier: LGPL-2.1-or-later
"""Calls of the older SofaPython, as scenes still have them: scripts as controllers, with their own names of events."""
import importlib.util
import os

from . import _python_2
from ._data import Data, RowsOfOne
from ._objects import Controller, DataEngine, take


_BUTTONS = {1: ("Left", True), 2: ("Left", False), 3: ("Right", True), 4: ("Right", False), 6: ("Middle", True), 7: ("Middle", False)}


class PythonScriptController(Controller):
    """onBeginAnimationStep(dt), onEndAnimationStep(dt), onKeyPressed(key), initGraph(node), createGraph(node), ..."""

    def __init_subclass__(cls, **values):
        super().__init_subclass__(**values)
        RowsOfOne.used = True

    def __new__(cls, *arguments, **values):
        from ._node import Node

        self = super().__new__(cls)
        if arguments and isinstance(arguments[0], Node):  # it is in the node from then on, whatever its class does
            self.node = arguments[0]
            arguments[0]._s_insert(self, {})
        return self

    def __init__(self, *_arguments, **values):
        take(self, values)

    def _s_old(self, method, *arguments):
        found = getattr(self, method, None)
        if callable(found):
            found(*arguments)

    def init(self):
        if self.__dict__.get("_s_by_file"):
            self._s_old("onLoaded", self._s_node())
            self._s_old("createGraph", self._s_node())
        self._s_old("initGraph", self._s_node())

    def bwdInit(self):
        self._s_old("bwdInitGraph", self._s_node())

    def onAnimateBeginEvent(self, event):
        self._s_old("onBeginAnimationStep", event["dt"])

    def onAnimateEndEvent(self, event):
        self._s_old("onEndAnimationStep", event["dt"])

    def onKeypressedEvent(self, event):
        self._s_old("onKeyPressed", event["key"])

    def onKeyreleasedEvent(self, event):
        self._s_old("onKeyReleased", event["key"])

    def onMouseEvent(self, event):
        state, place = event["State"], (event["mouseX"], event["mouseY"])
        if state == 0:
            self._s_old("onMouseMove", *place)
        elif state == 5:
            self._s_old("onMouseWheel", *place, event["wheelDelta"])
        else:
            button, pressed = _BUTTONS[state]
            self._s_old("onMouseButton" + button, *place, pressed)

    def onPythonScriptEvent(self, event):
        self._s_old("onScriptEvent", event["sender"], event["event_name"], event["userData"])


PythonScriptDataEngine = DataEngine


def _text(values, name):
    value = values.get(name, "")
    return str(value.value if isinstance(value, Data) else value)


def controller(node, values):
    """createObject("PythonScriptController", filename="x.py", classname="Y")"""
    file, word = _text(values, "filename"), _text(values, "classname") or _text(values, "controller_name")
    scene = os.environ.get("STROMA_SCENE_FOLDER", "")
    path = next((each for each in (file, os.path.join(scene, file)) if os.path.isfile(each)), None)
    if path is None:
        raise FileNotFoundError(f"{node._s_place()}: a PythonScriptController needs the file '{file}', which is not found")
    import sys

    module = next((each for each in list(sys.modules.values())
                   if getattr(each, "__file__", None) and os.path.abspath(each.__file__) == os.path.abspath(path)), None)
    if module is None:
        name = os.path.splitext(os.path.basename(path))[0]
        spec = importlib.util.spec_from_file_location(name, path, loader=_python_2.Loader(name, path))
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
    made = getattr(module, word)
    thing = made(node)
    if isinstance(thing, PythonScriptController):
        object.__setattr__(thing, "_s_by_file", True)
        if "name" in values:
            thing.setName(_text(values, "name"))
    return thing


def loadScene(filename, *_):
    from . import _scene_file

    return _scene_file.load(filename)


def getSofaPythonVersion():
    return "3"
