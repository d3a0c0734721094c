# SPDX-License-Identifier: LGPL-2.1-or-later
"""Stand-ins for libraries that scenes import: stlib3 and splib3 of SOFA's plugin STLIB, softrobots of its plugin for soft robots,
cosserat and useful of the one for rods.

They have the functions that build most scenes, in the folder `libraries`, and are found last: a library on PYTHONPATH counts before
them. The names of Python 2, stlib and splib, are the same modules. A file beside this package with the name of each opens it for programs
that import it before Sofa.
"""
import importlib
import importlib.abc
import importlib.machinery
import importlib.util
import os
import sys

from . import _messages

FOLDER = os.path.join(os.path.dirname(os.path.abspath(__file__)), "libraries")
_PLUGINS = {"stlib3": "STLIB", "splib3": "STLIB", "softrobots": "SoftRobots", "cosserat": "Cosserat", "useful": "Cosserat"}
_OLD = {"stlib": "stlib3", "splib": "splib3"}


def stands_in(name):
    """Whether the module of this name is one of these, and not the library."""
    module = sys.modules.get(name.split(".")[0])
    return getattr(module, "__file__", None) is not None and module.__file__.startswith(FOLDER)


def _present_name(name):
    top, *rest = name.split(".")
    return ".".join([_OLD[top], *rest])


class _SameModule(importlib.abc.Loader):
    """An old name of a module."""

    def create_module(self, spec):
        module = importlib.import_module(_present_name(spec.name))
        self.kept = module.__spec__
        return module

    def exec_module(self, module):
        module.__spec__ = self.kept


class _OldNames(importlib.abc.MetaPathFinder):
    """Parts of a library by its old name, where the new one stands in: before Python looks for files, or each would be there twice."""

    def find_spec(self, name, path=None, target=None):
        top, _, part = name.partition(".")
        if top not in _OLD or not part or not stands_in(_OLD[top]) or sys.modules.get(top) is not sys.modules.get(_OLD[top]):
            return None
        if importlib.util.find_spec(_present_name(name)) is None:
            return None
        return importlib.util.spec_from_loader(name, _SameModule(), is_package=True)


class _Libraries(importlib.abc.MetaPathFinder):
    """The libraries themselves: asked when no folder has one."""

    def find_spec(self, name, path=None, target=None):
        if name in _OLD:
            return importlib.util.spec_from_loader(name, _SameModule(), is_package=True)
        return _stand_in(name) if name in _PLUGINS else None


def _stand_in(name):
    folder = os.path.join(FOLDER, name)
    return importlib.util.spec_from_file_location(name, os.path.join(folder, "__init__.py"), submodule_search_locations=[folder])


def open_library(name):
    """Puts the library of this name in the place of the file that is being imported."""
    # no folder of packages as this one, of which a path may have several
    others = [folder for folder in sys.path if not os.path.exists(os.path.join(folder, "Sofa", os.path.basename(__file__)))]
    spec = importlib.machinery.PathFinder.find_spec(name, others) or _stand_in(name)
    sys.modules[name] = module = importlib.util.module_from_spec(spec)
    if spec.loader is not None:
        spec.loader.exec_module(module)


def told(name):
    """Says that the module stands in."""
    plugin = _PLUGINS[name]
    _messages.note(f"the library {name} of SOFA's plugin {plugin} is not on PYTHONPATH: functions of its names come with Stroma")


def same_module(name, *others):
    """The parts of a library that one file has here."""
    for other in others:
        sys.modules[f"{name}.{other}"] = sys.modules[name]


def install():
    sys.meta_path.insert(0, _OldNames())
    sys.meta_path.append(_Libraries())
