# SPDX-License-Identifier: LGPL-2.1-or-later
"""SofaRuntime: plugins, which do nothing here, and folders of files."""
from Sofa import _messages
from Sofa._errors import (  # noqa: F401
    exceptHandler as sofaExceptHandler, formatStackForSofa, getPythonCallingPoint, getPythonCallingPointAsString,
    getSofaFormattedStringFromException, getStackForSofa, sendMessageFromException)
from Sofa._repository import FileRepository as Repository
from Sofa._scene_file import unloadModules  # noqa: F401


def importPlugin(*names):
    """Components are found by their names: nothing is to be imported."""
    _messages.note("importPlugin and RequiredPlugin have no effect: components are found by their names")
    return True


importPlugins = importPlugin


DataRepository = Repository("STROMA_DATA_PATH")
PluginRepository = Repository("STROMA_PLUGIN_PATH")
GuiDataRepository = Repository("STROMA_GUI_PATH")


class Records(dict):
    """What SOFA's timers have measured: nothing."""

    def __missing__(self, name):
        raise KeyError(f"SOFA's timers measure nothing here, and '{name}' neither: `stroma run --profile FILE` tells where the time goes")


class Timer:
    """SOFA's timers: nothing is timed by them."""

    def __getattr__(self, name):
        return lambda *_: {}

    @staticmethod
    def setEnabled(*_):
        pass

    setInterval = setOutputType = begin = end = clear = setEnabled

    @staticmethod
    def getRecords(*_):
        return Records()

    @staticmethod
    def isEnabled(*_):
        return False


class Input:
    """The state of keys and of the mouse: none is pressed. The view tells controllers of keys."""

    @staticmethod
    def isKeyPressed(*_):
        return False

    isMouseButtonPressed = isGamepadPresent = isGamepadButtonPressed = isKeyPressed

    @staticmethod
    def getMouseAxis(*_):
        return 0.0

    getGamepadAxis = getMouseAxis


def getCategories(name):
    from Sofa import _catalogue

    role = _catalogue.facts(str(name)).role
    return [role] if role else []


def init(*_):
    """Nothing is to be set up."""


formatStackForSofaPython = formatStackForSofa
