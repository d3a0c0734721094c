# SPDX-License-Identifier: LGPL-2.1-or-later
"""SOFA's Python scenes on Stroma. `createScene(root)` of a file builds a tree of nodes; `stroma run scene.py` runs it, and so does a
program of its own by Sofa.Simulation. It is found beside `stroma` only where a path says so, and hides no SOFA that is there."""
from . import Core, Helper, Simulation, Types, constants  # noqa: F401
from . import Components, Gui, _libraries  # noqa: F401
from ._errors import (  # noqa: F401
    getPythonCallingPoint, getPythonCallingPointAsString, getSofaFormattedStringFromException, getStackForSofa, formatStackForSofa,
    sendMessageFromException)
from ._scene_file import import_sofa_python_scene, unloadModules  # noqa: F401
from ._old_python import (  # noqa: F401
    PythonScriptController, PythonScriptDataEngine, getSofaPythonVersion, loadScene)
from ._prefab import PrefabBuilder  # noqa: F401
from .Core import Controller, ForceField, Node, Object, Prefab, RawPrefab  # noqa: F401
from .Helper import msg_deprecated, msg_error, msg_fatal, msg_info, msg_warning  # noqa: F401

_libraries.install()
__version__ = "24.12.0"
version = __version__


def timerSetInterval(*_):
    """SOFA's timers: nothing here is timed by them."""


timerSetEnabled = timerBegin = timerEnd = timerSetOutputType = timerSetInterval


def path():
    """The folder of this package."""
    import os

    return os.path.dirname(os.path.abspath(__file__))
