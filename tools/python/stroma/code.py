# SPDX-License-Identifier: LGPL-2.1-or-later
"""A scene as the text of a program that builds it."""
import itertools
import keyword
import math
import re
from typing import Iterator, List, Optional, Set

from . import _stroma
from .tree import Component, Node, _value
from .types import Attribute, type_info

_WIDTH = 100
_NUMBER = re.compile(r"[-+]?(0|[1-9]\d*)?(?P<real>\.\d*)?(?P<power>[eE][-+]?\d+)?$")


def _quoted(text: str) -> str:
    for character, escape in (("\\", "\\\\"), ('"', '\\"'), ("\n", "\\n"), ("\r", "\\r"), ("\t", "\\t")):
        text = text.replace(character, escape)
    return f'"{text}"'


def _is_number(word: str) -> bool:
    """Whether Python reads the same number: without a point, -0 would be 0 there."""
    return (bool(_NUMBER.match(word)) and any(character.isdigit() for character in word.lower().partition("e")[0])
            and math.isfinite(float(word)) and word != "-0")


_FRAMES = {"position": 7, "rest_position": 7, "velocity": 6}  # numbers of a rigid frame


def _pieces(text: str, attribute: Optional[Attribute], has_frames: bool) -> List[str]:
    """A value in Python, in pieces between which a line may end."""
    kind = attribute.kind if attribute else "array"  # of a node: dt, gravity
    words = text.replace(",", " ").split()
    if kind == "truth" and text in ("true", "false", "1", "0"):
        return ["True" if text in ("true", "1") else "False"]
    if kind not in ("real", "integer", "array") or not words or not all(map(_is_number, words)):
        return [_quoted(text)]
    value = attribute.value if attribute else None
    columns = value.shape[1] if getattr(value, "ndim", 1) == 2 else 0
    columns = _FRAMES.get(attribute.name, columns) if has_frames and attribute else columns
    if columns and len(words) % columns == 0:
        rows = ["(" + ", ".join(words[first:first + columns]) + ("," if columns == 1 else "") + ")"
                for first in range(0, len(words), columns)]
    elif len(words) == 1:
        return words
    else:
        rows = words
    opening, closing = "[]" if columns else "()"
    rows[0] = opening + rows[0]
    rows[-1] += closing
    return [row + "," for row in rows[:-1]] + rows[-1:]


def _arguments(item, name_first: bool) -> List[List[str]]:
    info = type_info(item.type) if isinstance(item, Component) else None
    found, others = [], []
    for name, value in item.attributes.items():
        text = _value(value)
        if not isinstance(text, str):
            text = _stroma.text_of(text)
        if name == "name":
            found.insert(0, [_quoted(text) if name_first else f"name={_quoted(text)}"])
            continue
        has_frames = str(item.attributes.get("template", "")).startswith("Rigid")
        pieces = _pieces(text, info.find(name) if info else None, has_frames)
        if name.isidentifier() and not keyword.iskeyword(name):
            found.append([f"{name}={pieces[0]}", *pieces[1:]])
        else:
            others.append(f"{_quoted(name)}: {' '.join(pieces)}")
    return found + ([["**{" + ", ".join(others) + "}"]] if others else [])


def _call(head: str, arguments: List[List[str]]) -> Iterator[str]:
    """The lines of a call."""
    pieces = [piece + ("," if last and index + 1 < len(arguments) else "") for index, argument in enumerate(arguments)
              for last, piece in ((at + 1 == len(argument), piece) for at, piece in enumerate(argument))]
    line, indent, is_new = head, " " * (len(head) if len(head) <= 32 else 4), True
    for index, piece in enumerate(pieces):
        if not is_new and len(line) + 1 + len(piece) + (index + 1 == len(pieces)) > _WIDTH:
            yield line
            line, is_new = indent, True
        line += ("" if is_new else " ") + piece
        is_new = False
    yield line + ")"


def _build(node: Node, variable: str, taken: Set[str]) -> Iterator[str]:
    for component in node.components:
        yield from _call(f"{variable}.add(", [[_quoted(component.type)], *_arguments(component, False)])
    for child in node.children:
        name = re.sub(r"\W", "_", child.own_name or "node")
        name = f"node_{name}" if keyword.iskeyword(name) or not name.isidentifier() else name
        free = next(each for number in itertools.count(1) if (each := name if number == 1 else f"{name}_{number}") not in taken)
        taken.add(free)
        yield ""
        yield from _call(f"{free} = {variable}.add_child(", _arguments(child, True))
        yield from _build(child, free, taken)


def to_python(root: Node) -> str:
    """The text of a program that builds this scene as `root`."""
    lines = ["import stroma", "", *_call("root = stroma.Node(", _arguments(root, True)), *_build(root, "root", {"root", "stroma"})]
    return "\n".join(lines) + "\n"
