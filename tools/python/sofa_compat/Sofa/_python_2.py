# SPDX-License-Identifier: LGPL-2.1-or-later
"""Files in Python 2, as 2to3 converts them: a scene, and what it imports from its folder. Whole numbers are divided as there."""
import ast
import importlib.machinery
import operator
import os
import re
import sys
import sysconfig
import warnings

import numpy as np

from . import _messages
from ._data import RowsOfOne


def compiled(text, file):
    """The code of a file. Raises SyntaxError where it is neither Python 3 nor Python 2."""
    try:
        return compile(text, file, "exec", dont_inherit=True)
    except (SyntaxError, ValueError) as error:
        converted = _converted(text)
        if converted is None:
            raise
        try:
            tree = ast.parse(converted, file)
            if not re.search(rb"^[ \t]*from[ \t]+__future__[ \t]+import[^\n]*\bdivision\b", text, re.MULTILINE):
                tree = ast.fix_missing_locations(_Divisions().of(tree))
            code = compile(tree, file, "exec", dont_inherit=True)
        except SyntaxError:
            raise error from None
        RowsOfOne.used = True
        _messages.note(f"{file} is written in Python 2: it was read as 2to3 converts it")
        return code


def _are_whole(*numbers):
    return all(isinstance(each, (int, np.integer)) or (isinstance(each, np.ndarray) and each.dtype.kind in "iu") for each in numbers)


def divided(a, b):
    """a / b of Python 2."""
    return a // b if _are_whole(a, b) else a / b


def divided_in_place(a, b):
    return operator.ifloordiv(a, b) if _are_whole(a, b) else operator.itruediv(a, b)


class _Divisions(ast.NodeTransformer):
    """Calls of the functions above in the place of divisions."""

    def of(self, tree):
        tree = self.visit(tree)
        first = 0
        for each in tree.body:  # behind what has to come first
            is_text = isinstance(each, ast.Expr) and isinstance(each.value, ast.Constant)
            if not is_text and not (isinstance(each, ast.ImportFrom) and each.module == "__future__"):
                break
            first += 1
        names = [ast.alias(name, f"__{name}__") for name in ("divided", "divided_in_place")]
        tree.body.insert(first, ast.ImportFrom("Sofa._python_2", names, 0))
        return tree

    @staticmethod
    def _call(name, node, *arguments):
        return ast.copy_location(ast.Call(ast.Name(f"__{name}__", ast.Load()), list(arguments), []), node)

    def visit_BinOp(self, node):
        self.generic_visit(node)
        return self._call("divided", node, node.left, node.right) if isinstance(node.op, ast.Div) else node

    def visit_AugAssign(self, node):
        self.generic_visit(node)
        if not isinstance(node.op, ast.Div) or any(isinstance(each, ast.Call) for each in ast.walk(node.target)):
            return node  # what a call in the target gives is asked for once
        now = ast.parse(ast.unparse(node.target), mode="eval").body
        return ast.copy_location(ast.Assign([node.target], self._call("divided_in_place", node, now, node.value)), node)


def _converted(text):
    """By lib2to3 where Python still has it."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            from lib2to3 import refactor

            tool = refactor.RefactoringTool(refactor.get_fixers_from_package("lib2to3.fixes"))
            source = text.decode("utf-8", "replace").expandtabs(8) + "\n"
            return str(tool.refactor_string(source, "scene"))
        except Exception:  # not Python 2 either, or no lib2to3
            return None


class Loader(importlib.machinery.SourceFileLoader):
    """Of one file."""

    def source_to_code(self, data, path, *, _optimize=-1):
        return compiled(bytes(data), path)

    def set_data(self, path, data, *, _mode=0o666):
        """No .pyc: plain Python would take that of a converted file for the file."""


_folders = set()  # of scenes
_OTHERS = tuple(os.path.realpath(sysconfig.get_paths()[name]) + os.sep for name in ("stdlib", "platstdlib"))
_find = importlib.machinery.FileFinder.path_hook((importlib.machinery.ExtensionFileLoader, importlib.machinery.EXTENSION_SUFFIXES),
                                                 (Loader, importlib.machinery.SOURCE_SUFFIXES),
                                                 (importlib.machinery.SourcelessFileLoader, importlib.machinery.BYTECODE_SUFFIXES))


def _hook(path):
    place = os.path.realpath(path or os.getcwd()) + os.sep
    if not any(place.startswith(each) for each in _folders) or place.startswith(_OTHERS) or "-packages" in place:
        raise ImportError(f"{path} is not of a scene")
    return _find(path)


def convert_imports(folder):
    """What is imported from the folder, or from packages in it, may be in Python 2."""
    folder = os.path.realpath(folder) + os.sep
    if folder in _folders:
        return
    _folders.add(folder)
    if _hook not in sys.path_hooks:
        sys.path_hooks.insert(0, _hook)
    sys.path_importer_cache.clear()
