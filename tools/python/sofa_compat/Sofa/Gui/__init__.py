# SPDX-License-Identifier: LGPL-2.1-or-later
"""Sofa.Gui: the live view in a browser. Without a display it does nothing, and says so once."""
import os

from .. import _engine, _messages


def _has_display():
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


class GUIManager:
    """SOFA's calls: Init(), createGUI(), SetDimension(), MainLoop(), closeGUI()."""

    _file = ""

    @staticmethod
    def Init(*_):
        return 0

    @staticmethod
    def createGUI(root=None, file="", *_):
        GUIManager._file = str(file)

    addGUI = createGUI

    @staticmethod
    def MainLoop(root, file="", *_):
        if _engine.is_commanded():
            _messages.note("a command runs the scene: Sofa.Gui opens no view of its own")
            return
        if not _has_display():
            _messages.note("there is no display: Sofa.Gui opens no view, and the program goes on")
            return
        _engine.initialise(root)
        _engine.view(root.getRoot())

    @staticmethod
    def SetDimension(*_):
        pass

    SetFullScreen = CenterWindow = SetBackground = SetDimension

    @staticmethod
    def closeGUI(*_):
        pass

    @staticmethod
    def ListSupportedGUI(*_):
        return "stroma"

    @staticmethod
    def GetValidGUIName():
        return "stroma"

    @staticmethod
    def SaveScreenshot(*_):
        _messages.note("Sofa.Gui saves no picture: stroma picture draws one")

    @staticmethod
    def GetGUI(*_):
        return GUIManager

    initialize = setDimension = SetDimension


class BaseGui:
    """The window of SOFA: the view has its own."""


class BaseViewer:
    pass
