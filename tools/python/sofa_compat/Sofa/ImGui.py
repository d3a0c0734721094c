# SPDX-License-Identifier: LGPL-2.1-or-later
"""Sofa.ImGui: what scenes of robots put into the windows of SOFA's interface. Here are none: what is shown or plotted there is taken
without effect, no slider moves, and no robot is connected."""
from . import _messages


class _Window:
    """Any call of it."""

    def __init__(self, name):
        self._name = name

    def __getattr__(self, name):
        if name.startswith("__"):
            raise AttributeError(name)
        return _call(f"{self._name}.{name}")


def _call(name):
    def call(*_, **__):
        _messages.note("Sofa.ImGui has no windows here: what a scene shows there has no effect, and no robot is connected")
        return "" if name.endswith("getSelectedPort") else False if name.rpartition(".")[2].startswith(("get", "is", "has")) else None

    call.__name__ = call.__qualname__ = name
    return call


MyRobotWindow, MoveWindow, PlottingWindow, ProgramWindow, IOWindow, SimulationState = (
    _Window(name) for name in ("MyRobotWindow", "MoveWindow", "PlottingWindow", "ProgramWindow", "IOWindow", "SimulationState"))


def __getattr__(name):
    if name.startswith("_"):
        raise AttributeError(name)
    if name.endswith(("Window", "State")):
        return _Window(name)
    if name.startswith(("add", "get", "set", "is", "has", "clear", "remove")):
        return _call(name)
    raise AttributeError(f"Sofa.ImGui has no '{name}'")
