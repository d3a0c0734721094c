# SPDX-License-Identifier: LGPL-2.1-or-later
"""What draws a scene into a window of a program's own. Nothing is drawn here: the live view and `stroma picture` show scenes."""
from . import _messages


def draw(*_):
    _messages.note("Sofa.SofaGL draws nothing: the live view and stroma picture show scenes")


glewInit = getViewport = getProjectionMatrix = getModelViewMatrix = drawScene = draw
