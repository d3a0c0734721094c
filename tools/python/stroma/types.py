# SPDX-License-Identifier: LGPL-2.1-or-later
"""The types of components: what a scene can name, and the attributes of each."""
import inspect
import keyword
from typing import Any, Dict, Iterable, List, Optional

from . import _stroma


class Attribute:
    """An attribute of a type, or of a component."""

    def __init__(self, facts: Dict[str, Any]):
        self.name: str = facts["name"]
        self.type: str = facts["type"]  #: in words: "list of 3 reals"
        self.unit: str = facts["unit"]
        self.default: str = facts["default"]
        self.range: str = facts["range"]
        self.help: str = facts["help"]
        self.aliases: List[str] = facts["aliases"]
        self.required: bool = facts["required"]
        self.output: bool = facts["output"]
        self.link: bool = facts["link"]
        self.file: bool = facts["file"]
        self.words: List[str] = facts["words"]  #: of a choice
        self.change: str = facts["change"]  #: in a run: "at once", "remade", or "restart"
        self.value: Any = facts["value"]
        self.given: bool = facts["given"]

    @property
    def kind(self) -> str:
        """A word for the value in Python: "real", "integer", "truth", "text", "choice", "link", "file" or "array"."""
        import numpy
        if self.link:
            return "link"
        if self.file:
            return "file"
        if self.words:
            return "choice"
        if isinstance(self.value, bool):
            return "truth"
        if isinstance(self.value, int):
            return "integer"
        if isinstance(self.value, float):
            return "real"
        return "array" if isinstance(self.value, numpy.ndarray) else "words" if isinstance(self.value, list) else "text"

    def line(self) -> str:
        """One line of help."""
        unit = f" [{self.unit}]" if self.unit not in ("", "-") else ""
        default = " (computed)" if self.output else f" = {self.default}" if self.default and len(self.default) < 40 else ""
        return f"{self.name}{default}{unit}: {self.help}"

    def __repr__(self) -> str:
        return f"<attribute {self.line()}>"


def _plain(text: str) -> Any:
    """A number where it is one."""
    try:
        return float(text)
    except ValueError:
        return text


class TypeInfo:
    """A type of components. Its attributes are looked up when they are asked for: that opens the module which has it."""

    def __init__(self, type: str, module: str, help: str):
        self.type, self.module, self.help = type, module, help
        self._facts: Optional[Dict[str, Any]] = None
        self._attributes: List[Attribute] = []
        self._by_name: Dict[str, Attribute] = {}

    def _look(self) -> Dict[str, Any]:
        if self._facts is None:
            self._facts = _stroma.type_info(self.type) or {}
            self._attributes = [Attribute(facts) for facts in self._facts.get("attributes", [])]
            for attribute in reversed(self._attributes):
                for alias in attribute.aliases:
                    self._by_name[alias] = attribute
            for attribute in self._attributes:
                self._by_name[attribute.name] = attribute
        return self._facts

    @property
    def role(self) -> str:
        return self._look().get("role", "")

    @property
    def manual(self) -> str:
        """The page that `stroma doc` shows."""
        return self._look().get("manual", "")

    @property
    def attributes(self) -> List[Attribute]:
        self._look()
        return self._attributes

    def find(self, name: str) -> Optional[Attribute]:
        """By its name, another accepted one, or the one that it once had in SOFA."""
        facts = self._look()
        return self._by_name.get(name) or self._by_name.get(facts.get("renamed", {}).get(name, ""))

    def accepts(self, name: str) -> bool:
        """Whether a scene may write it, also without effect."""
        return self.find(name) is not None or name.startswith(("_", "NO")) or _stroma.is_accepted(self.type, name)

    def names(self) -> List[str]:
        self._look()
        return list(self._by_name)

    def signature(self) -> inspect.Signature:
        """The arguments of its class: what editors and notebooks complete."""
        kind = inspect.Parameter
        arguments = [kind(name, kind.POSITIONAL_OR_KEYWORD, default=None) for name in ("name", "where")]
        for one in self.attributes:
            if one.output or one.name in ("name", "where") or not one.name.isidentifier() or keyword.iskeyword(one.name):
                continue
            default = one.value if isinstance(one.value, (bool, int, float, str)) else _plain(one.default)
            arguments.append(kind(one.name, kind.KEYWORD_ONLY, default=kind.empty if one.required else default))
        return inspect.Signature([*arguments, kind("others", kind.VAR_KEYWORD)])

    def text(self) -> str:
        """What help() shows."""
        lines = [self.help, ""] + [attribute.line() for attribute in self.attributes]
        return "\n".join(lines + (["", self.manual] if self.manual else []))

    def __repr__(self) -> str:
        return f"<type {self.type}: {self.help}>"


_types: Dict[str, TypeInfo] = {}


def types() -> Dict[str, TypeInfo]:
    """All types, by name. No module is opened."""
    if not _types:
        for type, module, help in _stroma.types():
            _types.setdefault(type, TypeInfo(type, module, help))
    return _types


def type_info(type: str) -> Optional[TypeInfo]:
    """A type by its present or an old name; None when there is none."""
    known = types()
    found = known.get(type) or known.get(_stroma.present_type(type))
    if found is None:
        facts = _stroma.type_info(type)  # of a module that was opened by its path
        if facts is not None:
            found = known[type] = TypeInfo(facts["type"], facts["module"], facts["help"])
    return found


def nearest(word: str, candidates: Iterable[str]) -> str:
    """The candidate that is most like the word; empty when none is like it."""
    return _stroma.nearest(word, list(candidates))


present_type = _stroma.present_type
is_known = _stroma.is_known
has_no_effect = _stroma.has_no_effect
advice = _stroma.advice
