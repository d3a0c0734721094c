# SPDX-License-Identifier: LGPL-2.1-or-later
"""Sofa.Gui: the live view in a browser. Without a display it does nothing, and says so once."""
import os

from .. import _engine, _messages


def _has_display():
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


class GUIManager:
    """SOFA's calls: Init(), createGUI(), SetDimension(), MainLoop(), closeGUI()."""

    _root = None

    @staticmethod
    def Init(*_):
        return 0

    @staticmethod
    def createGUI(root=None, *_):
        GUIManager.SetScene(root)
        return 0

    addGUI = createGUI

    @staticmethod
    def SetScene(root, *_, **_options):
        """The scene of the next MainLoop() and SaveScreenshot()."""
        GUIManager._root = root

    @staticmethod
    def MainLoop(root, *_):
        GUIManager.SetScene(root)
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
    def ListSupportedGUI(separator=None):
        """A list; with a separator a text, as in SOFA."""
        return ["stroma"] if separator is None else "stroma"

    @staticmethod
    def SaveScreenshot(filename, *_):
        """A PNG file of the scene as it is now."""
        root = GUIManager._root
        engine = root.getRoot()._s_engine() if root is not None else None
        if engine is None:
            return _messages.warn(f"Sofa.Gui: {filename} is not written: there is no scene that runs (GUIManager.createGUI(root) or SetScene(root) "
                                  "tell which)")
        return engine.sim.picture(filename)

    @staticmethod
    def GetGUI(*_):
        return BaseGUI()

    initialize = setDimension = SetDimension


class BaseGUI:
    """The window of SOFA: the view has its own."""

    def setBackgroundImage(self, *_):
        """The view has a background of its own."""
