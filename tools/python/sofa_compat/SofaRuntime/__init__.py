# SPDX-License-Identifier: LGPL-2.1-or-later
"""SofaRuntime: plugins, which do nothing here, and folders of files."""
import os

from Sofa import _messages
from Sofa._errors import (  # noqa: F401
    exceptHandler as sofaExceptHandler, formatStackForSofa, getPythonCallingPoint, getPythonCallingPointAsString,
    getSofaFormattedStringFromException, getStackForSofa, sendMessageFromException)
from Sofa._scene_file import unloadModules  # noqa: F401


def importPlugin(*names):
    """Components are found by their names: nothing is to be imported."""
    _messages.note("importPlugin and RequiredPlugin have no effect: components are found by their names")
    return True


importPlugins = importPlugin


class Repository:
    """Folders in which files of scenes are looked for, after that of the scene."""

    def __init__(self, variable):
        self._variable = variable

    def _folders(self):
        return [each for each in os.environ.get(self._variable, "").split(os.pathsep) if each]

    def addFirstPath(self, folder):
        os.environ[self._variable] = os.pathsep.join([os.path.abspath(str(folder)), *self._folders()])

    def addLastPath(self, folder):
        os.environ[self._variable] = os.pathsep.join([*self._folders(), os.path.abspath(str(folder))])

    addPath = addLastPath

    def removePath(self, folder):
        os.environ[self._variable] = os.pathsep.join(each for each in self._folders() if each != os.path.abspath(str(folder)))

    def getPaths(self):
        return self._folders()

    def getPathsJoined(self):
        return os.pathsep.join(self._folders())

    def getFirstPath(self):
        return (self._folders() or [""])[0]

    def getFile(self, name):
        for folder in [os.getcwd(), *self._folders()]:
            if os.path.exists(os.path.join(folder, name)):
                return os.path.join(folder, name)
        return name

    def findFile(self, name, *_):
        return self.getFile(name)


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


def getMainFactory():
    return None


def init(*_):
    """Nothing is to be set up."""


formatStackForSofaPython = formatStackForSofa
