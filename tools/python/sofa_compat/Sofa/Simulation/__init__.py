# SPDX-License-Identifier: LGPL-2.1-or-later
"""Sofa.Simulation: a program's own loop over a scene."""
from .. import _engine, _events

_current = [None]


def init(root, *_):
    """Loads the scene into the engine. Everything that is wrong with it is told at once, as a stroma.SceneError."""
    _current[0] = root
    _engine.initialise(root)


initRoot = initNode = init


def animate(root, dt=0.0, *_):
    """One step, of dt or of the root's."""
    _engine.animate(root, 0.0 if dt is None else float(dt))


def animateNSteps(root, steps=1, dt=0.0, *_):
    for _step in range(int(steps)):
        animate(root, dt)


def reset(root, *_):
    """Back to the start."""
    _engine.reset(root)


def load(filename, *_):
    """The root of a scene: a file of Python with createScene(), or XML."""
    from .. import _scene_file

    return _scene_file.load(str(filename))


def unload(root, *_):
    _engine.unload(root)
    if _current[0] is root:
        _current[0] = None


def getRoot():
    return _current[0]


def print(root, *_):  # noqa: A001
    """The tree, a line for each node and object."""
    import builtins

    def tell(node, indent):
        builtins.print("  " * indent + f"Node {node.getName()}")
        for each in node.objects:
            builtins.print("  " * (indent + 1) + f"{each.getClassName()} {each.getName()}")
        for child in node.children:
            tell(child, indent + 1)

    tell(root, 0)


dumpState = dumpScene = printAll = print


def sendEvent(root, name, value=None):
    _events.user_event(root, name, value)


def initTextures(root, *_):
    """Controllers hear of it; what draws has no effect."""
    _events.of_scene(root.getRoot(), "SimulationInitTexturesDoneEvent")


def initVisual(*_):
    """What draws has no effect."""


updateVisual = draw = drawing = exportOBJ = exportGraph = glewInit = initVisual


def updateContext(*_):
    pass


updateMapping = initGraph = updateContext
