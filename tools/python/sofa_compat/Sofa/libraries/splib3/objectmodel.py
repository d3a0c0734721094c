# SPDX-License-Identifier: LGPL-2.1-or-later
"""Data of objects by keywords, and nodes as members of objects."""
import functools
import inspect
import re

import Sofa


def setData(d, **kwargs):
    for name, value in kwargs.items():
        d.getData(name).value = value


def setTreeData(target, pathregex, **params):
    """Of all objects in a tree whose path matches."""
    if isinstance(target, Sofa.Core.Node):
        for child in target.children:
            setTreeData(child, pathregex, **params)
        for each in target.objects:
            setTreeData(each, pathregex, **params)
    elif re.search(pathregex, target.getLinkPath()):
        setData(target, **{name: value for name, value in params.items() if target.findData(name) is not None})


class SofaPrefab:
    """Of a class whose objects have a node: what they do not have is asked of it."""

    def __init__(self, cls):
        self.cls = cls
        functools.update_wrapper(self, cls)

    def __call__(self, *args, **kwargs):
        made = self.cls(*args, **kwargs)
        made.node.addNewData("Prefab type", "Infos", "", "string", type(made).__name__)
        made.node.addNewData("Help", "Infos", "", "string", str(inspect.getdoc(made)))
        self.cls.__getattr__ = lambda self, name: getattr(self.node, name)
        return made

    def __getattr__(self, name):
        return getattr(self.cls, name)


class SofaObject:
    def __init__(self, node, name):
        self.node = node.addChild(name)

    def __getattr__(self, name):
        return getattr(self.node, name)
