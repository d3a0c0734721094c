# SPDX-License-Identifier: LGPL-2.1-or-later
"""A file of Python with createScene(root): it is executed, and everything that it cannot do here is told at once."""
import ast
import functools
import importlib.util
import os
import sys
import traceback
import types

from . import _catalogue, _messages, _python_2
from ._node import Node

#: where libraries come from that scenes import
_LIBRARIES = {
    "stlib3": "the library of SOFA's plugin STLIB", "stlib": "the library of SOFA's plugin STLIB",
    "splib3": "the library of SOFA's plugin STLIB", "splib": "the library of SOFA's plugin STLIB",
    "softrobots": "the library of SOFA's plugin SoftRobots", "cosserat": "the library of SOFA's plugin Cosserat",
    "CosseratBase": "the library of SOFA's plugin Cosserat", "sofagym": "the library SofaGym", "modelorderreduction": "SOFA's plugin "
    "ModelOrderReduction", "mor": "SOFA's plugin ModelOrderReduction",
}


class SceneFileError(RuntimeError):
    """What is wrong with a scene file: a list of sentences, each with file and line."""

    def __init__(self, problems):
        self.problems = problems
        count = len(problems)
        super().__init__("\n".join(f"{file}:{line}: error: {text}" for file, line, text in problems)
                         + f"\n{count} error{'' if count == 1 else 's'}: nothing was run")


def load(file):
    """The root of the scene."""
    file = os.path.abspath(file)
    if not os.path.isfile(file):
        raise SceneFileError([(file, 0, "there is no such file")])
    if not file.endswith((".py", ".pyscn", ".pyscn.py")):
        return _from_xml(file)
    folder = os.path.dirname(file)
    if folder not in sys.path:
        sys.path.insert(0, folder)
    os.environ["STROMA_SCENE_FOLDER"] = folder
    _python_2.convert_imports(folder)
    _search_in(folder)
    root = Node("root")
    object.__setattr__(root, "_s_where", (file, 1))
    try:
        module = _execute(file)
        _maker(module, file)(root)
    except SceneFileError:
        raise
    except SystemExit as stop:
        raise SceneFileError([*_lacking(file, root), (file, _line_in(file, stop), f"the scene ends the program: sys.exit({stop.code})")]
                             ) from stop
    except Exception as error:
        raise SceneFileError([*_lacking(file, root), *_sentence(file, error)]) from error
    return root


def _search_in(folder):
    """Relative names of files start there, whatever file of Python writes them."""
    folders = [each for each in os.environ.get("STROMA_DATA_PATH", "").split(os.pathsep) if each]
    if folder not in folders:
        os.environ["STROMA_DATA_PATH"] = os.pathsep.join([folder, *folders])


def import_sofa_python_scene(path):
    """The module of a file with createScene(): looked for beside the scene."""
    folders = [os.getcwd(), *os.environ.get("STROMA_DATA_PATH", "").split(os.pathsep)]
    found = next((each for each in (os.path.join(folder, str(path)) for folder in folders) if os.path.isfile(each)), str(path))
    if not os.path.isfile(found):
        raise FileNotFoundError(f"there is no file '{path}', in none of {', '.join(folder for folder in folders if folder)}")
    module = _execute(os.path.abspath(found))
    _maker(module, found)
    return module


def unloadModules():
    """Modules stay: a scene is loaded in a process of its own."""


def _execute(file):
    name = os.path.splitext(os.path.basename(file))[0]
    module = types.ModuleType(name)
    module.__file__ = file
    with open(file, "rb") as source:
        text = source.read()
    code = _compiled(file, text)
    if name not in sys.modules:
        sys.modules[name] = module
    exec(code, module.__dict__)
    return module


def _compiled(file, text):
    try:
        return _python_2.compiled(text, file)
    except (SyntaxError, ValueError) as error:
        raise SceneFileError([(file, getattr(error, "lineno", 0) or 0, f"{error.args[0]}")]) from error


def _maker(module, file):
    for name in ("createScene", "createSceneAndController", "createGraph"):
        found = getattr(module, name, None)
        if callable(found):
            return found
    raise SceneFileError([(file, 1, "there is no function createScene(root); a program of its own is run by python3")])


# ---- what is wrong ----

def _line_in(file, error):
    """The last line of the scene file that was being executed."""
    lines = [frame.lineno for frame in traceback.extract_tb(error.__traceback__) if os.path.abspath(frame.filename) == file]
    return lines[-1] if lines else 0


def _sentence(file, error):
    import stroma

    if isinstance(error, stroma.SceneError):  # the scene initialises itself
        return [(each.file, each.line, _told(each)) for each in error.problems if each.severity == "error"]
    if isinstance(error, ModuleNotFoundError) and error.name:
        known = error.name.split(".")[0]
        imports = [name for each in own_files(file) for name, _line in _imports(each)]
        if any(name.split(".")[0] == known and not _is_there(name) for name in imports):
            return []  # with those that are missing
    text = str(error) or type(error).__name__
    where = _messages.place_of(error) or (file, _line_in(file, error))
    if text.startswith(f"{where[0]}:{where[1]}: "):
        text = text[len(f"{where[0]}:{where[1]}: "):]
    line = _line_in(file, error)
    through = f", called at {file}:{line}" if line and os.path.abspath(where[0]) != file else ""
    return [(*where, f"{type(error).__name__}: {text}{through}; what the scene does after this line is not known")]


def _lacking(file, root):
    """Modules and components that the scene names and that are not there: those of its tree, and those in its text."""
    problems, told = [], set()
    files = own_files(file)
    for name, path, line in [(name, each, line) for each in files for name, line in _imports(each)]:
        top = name.split(".")[0]
        if top in told or _is_there(name):
            continue
        told.add(top)
        origin = f", {_LIBRARIES[top]}: its folder must be on PYTHONPATH" if top in _LIBRARIES else ""
        problems.append((path, line, f"the module '{name}' is not found{origin}"))
    for name, path, line, text in _lacking_in(root):
        if name not in told:
            told.add(name)
            problems.append((path, line, text))
    named = [(each._s_type, *each._s_where) for each in root._s_all_objects() if each._s_type]
    named += [(word, each, line) for each in files for word, line in _types_in(each)]
    for word, path, line in named:
        if word in told or not _catalogue.facts(word).missing:
            continue
        told.add(word)
        problems.append((path, line, missing_sentence(word)))
    return problems


def _lacking_in(root):
    """(name, file, line, sentence) of components and files that the engine misses in the tree as far as it goes."""
    import stroma

    from ._mirror import Mirror

    try:
        stroma.load(Mirror(root, keep_loaders=True).root, dialect="sofa", observers=False, quiet=True)
    except stroma.SceneError as error:
        kinds = {each.getPathName(): each._s_type for each in root._s_all_objects()}
        for each in error.problems:
            if each.severity == "error" and each.message.startswith("there is no component"):
                yield kinds.get(each.path, each.path), each.file, each.line, _told(each)
            elif each.severity == "error" and "is not found" in each.message:
                yield each.path, each.file, each.line, _told(each)
    except Exception:  # what else is wrong with half a tree is not said
        return


def _told(problem):
    return problem.text.split(": error: ", 1)[-1]


def missing_sentence(word):
    import stroma

    advice = stroma.advice(word)
    if advice:
        return f"there is no component '{word}': {advice}"
    near = _messages.nearest(word, stroma.types())
    return f"there is no component '{word}' (expected a name from 'stroma list'" + (f"; did you mean '{near}'?)" if near else ")")


def _tree(file):
    try:
        with open(file, "rb") as source:
            return ast.parse(source.read())
    except (SyntaxError, ValueError, OSError):
        return ast.Module([], [])


def _imports(file):
    """(module, line) of all that the file imports at its own level or in a function."""
    found = []
    for node in ast.walk(_tree(file)):
        if isinstance(node, ast.Import):
            found += [(each.name, node.lineno) for each in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            found.append((node.module, node.lineno))
    return found


def own_files(file):
    """The scene and what it imports from its own folder."""
    folder, found = os.path.dirname(file), [file] if os.path.isfile(file) else []
    for each in found:
        for name, _line in _imports(each):
            path = os.path.join(folder, *name.split("."))
            for candidate in (path + ".py", os.path.join(path, "__init__.py")):
                if os.path.isfile(candidate) and candidate not in found and len(found) < 100:
                    found.append(candidate)
    return found


def _is_there(name):
    try:
        return name in sys.modules or importlib.util.find_spec(name) is not None
    except Exception:
        return False


_SIMPLE = (ast.Expr, ast.Assign, ast.AnnAssign, ast.Break, ast.Return)


def _may_catch(handler):
    """Whether `except ...:` takes the ValueError that addObject() raises, and keeps it."""
    kinds = handler.type.elts if isinstance(handler.type, ast.Tuple) else [handler.type]
    takes = any(kind is None or getattr(kind, "id", "") in ("BaseException", "Exception", "ValueError") for kind in kinds)
    return takes and not any(isinstance(each, ast.Raise) for each in ast.walk(handler))


def _adds(handler):
    return any(isinstance(each, ast.Call) and getattr(each.func, "attr", "") in ("addObject", "createObject", "addChild", "add")
               for each in ast.walk(handler))


def _is_choice(node):
    """A `try` that tries one component, with another one for it: in its handler, or next in a loop that it would end. A scene that
    wraps much more, or does nothing instead, goes on without a part of itself, which is told as missing."""
    if len(node.body) > 3 or not all(isinstance(each, _SIMPLE) for each in node.body):
        return False
    ends_loop = isinstance(node.body[-1], (ast.Break, ast.Return)) or any(isinstance(each, (ast.Break, ast.Return)) for each in node.orelse)
    return any(_may_catch(each) and (ends_loop or _adds(each)) for each in node.handlers)


@functools.lru_cache(maxsize=200)
def _caught_lines(file):
    """(first, last) line of what a scene tries."""
    return [(node.body[0].lineno, node.body[-1].end_lineno) for node in ast.walk(_tree(file))
            if isinstance(node, ast.Try) and _is_choice(node)]


def is_caught(file, line):
    """Whether a scene tries a component there, and has another one for it where SOFA's addObject() raises."""
    return any(first <= line <= last for first, last in _caught_lines(file))


def _types_in(file):
    """(type, line) of addObject("Type", ...) with the type as a word, but for those that the scene can do without."""
    found = []
    for node in ast.walk(_tree(file)):
        if isinstance(node, ast.Call) and is_caught(file, node.lineno):
            continue
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr in ("addObject", "createObject"):
            first = node.args[0] if node.args else None
            if isinstance(first, ast.Constant) and isinstance(first.value, str):
                found.append((first.value, node.lineno))
    return found


# ---- a scene in XML as a tree of Python ----

def _from_xml(file):
    import stroma

    return _copied(stroma.from_xml(file))


def _copied(node):
    copy = Node(node.name or "root")
    object.__setattr__(copy, "_s_where", tuple(node.where))
    for name, value in node.attributes.items():
        if name != "name" and copy.findData(name) is not None:
            copy._s_data[name]._s_raw = value
    for component in node.components:
        thing = copy.addObject(component.type, **{"name": component.name, **dict(component.attributes)})
        object.__setattr__(thing, "_s_where", tuple(component.where))
    for child in node.children:
        copy.addChild(_copied(child))
    return copy
