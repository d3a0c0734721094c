#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Makes notebooks of Jupyter of the scripts in scenes/python: what a script says at its top becomes text, and each of its paragraphs
a cell. What its tests check is left out. Usage: make_notebooks.py FOLDER SCRIPT..."""
import ast
import json
import os
import sys


def paragraphs(source):
    """(first line, last line) of the pieces that blank lines at the outer level divide, without the text at the top and check()."""
    tree, pieces = ast.parse(source), []
    lines = source.split("\n")
    for statement in tree.body:
        if isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Constant) and isinstance(statement.value.value, str):
            continue
        if isinstance(statement, ast.FunctionDef) and statement.name == "check":
            continue
        first = min([statement.lineno] + [one.lineno for one in getattr(statement, "decorator_list", [])])
        while first > 1 and lines[first - 2].startswith("#") and not lines[first - 2].startswith(("#!", "# SPDX")):
            first -= 1
        if pieces and not any(not line.strip() for line in lines[pieces[-1][1]:first - 1]):
            pieces[-1] = (pieces[-1][0], statement.end_lineno)
        else:
            pieces.append((first, statement.end_lineno))
    return pieces


def cell(kind, text, number):
    made = {"cell_type": kind, "id": f"cell-{number}", "metadata": {}, "source": text.splitlines(keepends=True)}
    return made if kind == "markdown" else {**made, "execution_count": None, "outputs": []}


def notebook(source, name):
    """The notebook as an object: format 4.5."""
    lines = source.split("\n")
    cells = [cell("markdown", f"# {name.replace('_', ' ')}\n\n{ast.get_docstring(ast.parse(source)) or ''}", 0)]
    cells += [cell("code", "\n".join(lines[first - 1:last]), number + 1) for number, (first, last) in enumerate(paragraphs(source))]
    return {"cells": cells, "metadata": {"kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"},
                                         "language_info": {"name": "python"}}, "nbformat": 4, "nbformat_minor": 5}


def main():
    folder, *scripts = sys.argv[1:]
    os.makedirs(folder, exist_ok=True)
    for script in scripts:
        name = os.path.splitext(os.path.basename(script))[0]
        with open(script, encoding="utf-8") as file:
            made = notebook(file.read(), name)
        with open(os.path.join(folder, name + ".ipynb"), "w", encoding="utf-8") as file:
            json.dump(made, file, indent=1, ensure_ascii=False)
            file.write("\n")


if __name__ == "__main__":
    main()
