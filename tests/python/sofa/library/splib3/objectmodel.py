# SPDX-License-Identifier: LGPL-2.1-or-later
"""A node as the member of an object."""
import functools
import inspect


def setData(d, **kwargs):
    for k in kwargs:
        d.getData(str(k)).value = kwargs[k]


class SofaPrefab:
    """Of a class whose objects have a node: what they do not have is asked of it."""

    def __init__(self, cls):
        self.cls = cls
        functools.update_wrapper(self, cls)

    def __call__(self, *args, **kwargs):
        made = self.cls(*args, **kwargs)
        made.node.addNewData("Prefab type", "Infos", "", "string", str(made.__class__.__name__))
        made.node.addNewData("Help", "Infos", "", "string", str(inspect.getdoc(made)))
        setattr(self.cls, "__getattr__", lambda self, name: getattr(self.node, name))
        return made

    def __getattr__(self, name):
        return getattr(self.cls, name)


class SofaObject:
    def __init__(self, node, name):
        self.node = node.addChild(name)

    def __getattr__(self, name):
        return getattr(self.node, name)
