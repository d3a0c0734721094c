# SPDX-License-Identifier: LGPL-2.1-or-later
"""Scenes as trees of Python objects: nodes hold components and other nodes. Nothing runs before stroma.load()."""
import os
import sys
from typing import Any, Dict, Iterator, List, Optional, Tuple, Union

from . import _stroma
from .errors import Problem, SceneError, refusal
from .played import Played
from .types import TypeInfo, nearest, present_type, type_info, types

Where = Tuple[str, int]
_HERE = os.path.dirname(os.path.abspath(__file__))


def caller() -> Where:
    """The file and the line outside this package that called."""
    frame = sys._getframe(1)
    while frame is not None and os.path.dirname(os.path.abspath(frame.f_code.co_filename)) == _HERE:
        frame = frame.f_back
    return (frame.f_code.co_filename, frame.f_lineno) if frame is not None else ("", 0)


def _folder(where: Where) -> str:
    return os.path.dirname(os.path.abspath(where[0])) if os.path.exists(where[0]) else os.getcwd()


def _names(items: List[Any], type_of) -> List[str]:
    """The names that the engine gives: as written, else the type, Type2, Type3 ..."""
    taken = {item.own_name for item in items if item.own_name}
    names, count = [], {}
    for item in items:
        name = item.own_name
        while not name:
            type = type_of(item)
            count[type] = count.get(type, 0) + 1
            name = type if count[type] == 1 else f"{type}{count[type]}"
            if name in taken:
                name = ""
            else:
                taken.add(name)
        names.append(name)
    return names


class _Written:
    """What a scene writes: attributes, with the place of each. They are attributes of the object too: what is not
    `_fixed` is written by set() of the kind."""

    _fixed: frozenset

    def __init__(self, where: Optional[Where]):
        self.where: Where = where or caller()
        self.attributes: Dict[str, Any] = {}
        self._places: Dict[str, Where] = {}
        self.parent: Optional["Node"] = None

    def __setattr__(self, attribute: str, value: Any) -> None:
        if attribute in self._fixed or isinstance(getattr(type(self), attribute, None), property):
            object.__setattr__(self, attribute, value)
        else:
            self.set(attribute, value)

    @property
    def own_name(self) -> str:
        return str(self.attributes.get("name", "") or "")

    def given(self, attribute: str) -> Any:
        """The value as it was given; None when there is none."""
        return self.attributes.get(attribute)

    def unset(self, attribute: str) -> None:
        if self.attributes.pop(attribute, None) is not None:
            self._changed()

    def _changed(self) -> None:
        root = self.root
        if root is not None:
            root._preview = None

    @property
    def root(self) -> Optional["Node"]:
        node = self if isinstance(self, Node) else self.parent
        while node is not None and node.parent is not None:
            node = node.parent
        return node

    def _put(self, attribute: str, value: Any, where: Optional[Where]) -> None:
        if value is None:
            self.attributes.pop(attribute, None)
        else:
            self.attributes[attribute] = value
            self._places[attribute] = where or caller()
        self._changed()

    def _written(self) -> list:
        return [(name, _value(value), *self._places.get(name, self.where)) for name, value in self.attributes.items()]


def _value(value: Any) -> Any:
    """As the engine takes it."""
    if isinstance(value, Component):
        return value.link()
    if isinstance(value, Node):
        return "@" + value.path
    if isinstance(value, (list, tuple)):
        if any(isinstance(item, (Component, Node)) for item in value):
            return " ".join(_value(item) if isinstance(item, (Component, Node)) else _stroma.text_of(item) for item in value)
        if len(value) > 64:
            import numpy
            try:
                array = numpy.asarray(value)
            except ValueError:  # rows of several lengths
                return value
            return array if array.dtype.kind in "fiu" else value
    return value


class Component(_Written):
    """A component of a scene that is being built. Its attributes are attributes of the object: fem.youngModulus = "12 kPa"."""

    _fixed = frozenset(("where", "attributes", "_places", "parent", "type", "_played"))

    def __init__(self, type: str, /, name: Optional[str] = None, where: Optional[Where] = None, **attributes: Any):
        object.__setattr__(self, "type", type)
        super().__init__(where)
        if name is not None:
            attributes = {"name": name, **attributes}
        for key, value in attributes.items():
            self._put(key, value, where)

    # ---- names ----
    @property
    def node(self) -> Optional["Node"]:
        return self.parent

    @property
    def name(self) -> str:
        if self.own_name or self.parent is None:
            return self.own_name or present_type(self.type)
        siblings = self.parent.components
        return _names(siblings, lambda item: present_type(item.type))[[item is self for item in siblings].index(True)]

    @name.setter
    def name(self, value: str) -> None:
        self._put("name", value, None)

    @property
    def path(self) -> str:
        if self.parent is None:
            return self.name
        above = self.parent.path
        return ("" if above == "/" else above) + "/" + self.name

    def link(self, attribute: Optional[str] = None) -> str:
        """What names this component, or the value of its attribute, in a scene."""
        return "@" + self.path + (f".{attribute}" if attribute else "")

    @property
    def info(self) -> Optional[TypeInfo]:
        """What is known of its type; None for a type that is not known."""
        return type_info(self.type)

    # ---- attributes ----
    def set(self, attribute: str, value: Any, where: Optional[Where] = None) -> None:
        """Writes an attribute; None takes it out."""
        root = self.root
        if root is not None and root.strict:
            _check_attribute(self, attribute, where or caller())
        self._put(attribute, value, where)

    def get(self, attribute: str, init: bool = True, found: bool = False) -> Any:
        """The value: given, else linked or computed, else the default. What is computed (of loaders, grids, regions) is so
        now, by a part of the scene. `init=False`: without that."""
        root = self.root
        if root is None or root.parent is not None:
            return self._alone(attribute)
        return root.preview(self)._get(self.path, attribute, init, found)

    def _alone(self, attribute: str) -> Any:
        if attribute in self.attributes:
            return self.attributes[attribute]
        info = self.info
        data = info.find(attribute) if info else None
        if data is None:
            raise self._no(attribute)
        return data.value

    def _no(self, attribute: str) -> SceneError:
        info = self.info
        return refusal(f"{self.type} has no attribute '{attribute}'", "one of those that stroma.type_info() lists" if info else "",
                       nearest(attribute, info.names()) if info else "", self.where, self.path)

    def __getattr__(self, attribute: str) -> Any:
        if attribute.startswith("__"):
            raise AttributeError(attribute)
        try:
            return self.get(attribute)
        except SceneError as error:
            raise _missing(error, attribute) from None

    def __dir__(self) -> List[str]:
        info = self.info
        return sorted(set(super().__dir__()) | {attribute.name for attribute in (info.attributes if info else [])})

    def __repr__(self) -> str:
        return f"<{self.type} {self.path}>"

    def _tuple(self) -> tuple:
        return (self.type, self._written(), *self.where, _folder(self.where))


class MissingAttribute(SceneError, AttributeError):
    """An attribute that a component does not have."""


def _missing(error: SceneError, attribute: str) -> Exception:
    return MissingAttribute(error.problems) if "has no attribute" in str(error) else error


class Node(_Written):
    """A node of a scene: Node("root", dt=0.01, gravity=(0, 0, -9.81)). `strict`: what is wrong with a type or an attribute is
    told at the line that writes it; else load() tells all at once. `dialect="sofa"`: with SOFA's defaults and ways."""

    _fixed = frozenset(("where", "attributes", "_places", "parent", "components", "children", "strict", "_preview"))

    def __init__(self, name: Optional[str] = "root", where: Optional[Where] = None, strict: bool = True,
                 dialect: Optional[str] = None, **attributes: Any):
        for key, value in (("components", []), ("children", []), ("strict", strict), ("_preview", None)):
            object.__setattr__(self, key, value)
        super().__init__(where)
        if name is not None:
            self._put("name", name, where)
        if dialect is not None:
            self._put("dialect", dialect, where)
        for key, value in attributes.items():
            self.set(key, value, where)

    # ---- names ----
    @property
    def name(self) -> str:
        if self.own_name or self.parent is None:
            return self.own_name or "root"
        siblings = self.parent.children
        return _names(siblings, lambda item: "Node")[[item is self for item in siblings].index(True)]

    @name.setter
    def name(self, value: str) -> None:
        self._put("name", value, None)

    @property
    def path(self) -> str:
        if self.parent is None:
            return "/"
        above = self.parent.path
        return ("" if above == "/" else above) + "/" + self.name

    # ---- building ----
    def add_child(self, name: Union[str, "Node", None] = None, where: Optional[Where] = None, **attributes: Any) -> "Node":
        """A new node below this one; or one that was made before."""
        child = name if isinstance(name, Node) else Node(name, where, self.root.strict, **attributes)
        if isinstance(name, Node):
            for key, value in attributes.items():
                child.set(key, value, where)
        if child.parent is not None:
            child.parent.remove(child)
        child.parent = self
        self.children.append(child)
        return child

    def add(self, type: Union[str, Component, Played], /, name: Optional[str] = None, where: Optional[Where] = None,
            **attributes: Any) -> Component:
        """A new component in this node; or one that was made before, or a force field or a constraint in Python."""
        return self.insert(len(self.components), type, name, where, **attributes)

    def insert(self, index: int, type: Union[str, Component, Played], /, name: Optional[str] = None, where: Optional[Where] = None,
               **attributes: Any) -> Component:
        if isinstance(type, Played):
            component = Component(type.component, name, where, played=type.number, **attributes)
            object.__setattr__(component, "_played", type)
        elif isinstance(type, Component):
            component = type
            for key, value in ({"name": name, **attributes} if name is not None else attributes).items():
                component._put(key, value, where)
            if component.parent is not None:
                component.parent.remove(component)
        else:
            component = Component(type, name, where, **attributes)
        if self.root.strict:
            _check(component)
        component.parent = self
        root = self.root
        if root._preview is not None and (index < len(self.components) or _is_looked_up(component)):
            root._preview = None
        self.components.insert(index, component)
        return component

    def remove(self, item: Union[Component, "Node"]) -> None:
        """Takes a component or a node out of this one."""
        mine = self.children if isinstance(item, Node) else self.components
        places = [at for at, other in enumerate(mine) if other is item]
        if not places:
            raise refusal(f"{self.path} does not hold {item!r}", where=caller(), path=self.path)
        self._changed()
        del mine[places[0]]
        item.parent = None

    def set(self, attribute: str, value: Any, where: Optional[Where] = None) -> None:
        is_known = attribute in _stroma.node_attributes() + ["dialect", "withoutQuirks"] or attribute.startswith(("_", "show"))
        if self.strict and not is_known:
            raise refusal(f"a Node has no attribute '{attribute}'", "gravity, dt, time, name or activated",
                          nearest(attribute, _stroma.node_attributes()), where or caller(), self.path)
        self._put(attribute, value, where)

    def __getattr__(self, attribute: str) -> Any:
        attributes = self.__dict__.get("attributes", {})
        if attribute.startswith("__") or attribute not in attributes:
            found = None if attribute.startswith("_") else self.get(attribute)
            if found is None:
                raise AttributeError(f"node {self.__dict__.get('attributes', {}).get('name', '')} has nothing called '{attribute}'")
            return found
        return attributes[attribute]

    # ---- looking ----
    def get(self, path: str, default: Any = None) -> Any:
        """The component or node at a path: "fem", "child/fem", "../x", "/from/the/root"; `default` when there is none."""
        if not isinstance(path, str):
            raise TypeError(f"a path is a text, as \"/liver/fem\", not {type(path).__name__}")
        node: Optional[Node] = self.root if path.startswith("/") else self
        steps = [step for step in path.split("/") if step and step != "."]
        for index, step in enumerate(steps):
            if node is None:
                return default
            if step == "..":
                node = node.parent
                continue
            children = dict(zip(_names(node.children, lambda item: "Node"), node.children))
            if index == len(steps) - 1:
                mine = dict(zip(_names(node.components, lambda item: present_type(item.type)), node.components))
                return mine.get(step, children.get(step, default))
            is_root = index == 0 and path.startswith("/") and step == node.name and step not in children
            node = node if is_root else children.get(step)
        return default if node is None else node

    def __getitem__(self, path: str) -> Any:
        found = self.get(path)
        if found is None:
            paths = [item.path for item in self.root.walk()]
            raise refusal(f"the scene has no node or component {path}", "a path of the scene",
                          nearest(path if path.startswith("/") else f"{'' if self.path == '/' else self.path}/{path}", paths), caller())
        return found

    def walk(self) -> Iterator[Any]:
        """This node, its components, and the same of each node below, as the scene writes them."""
        yield self
        yield from self.components
        for child in self.children:
            yield from child.walk()

    def preview(self, newest: Optional[Component] = None) -> "Preview":
        """What its components compute before the scene runs."""
        root = self.root
        if root._preview is None or (newest is not None and not root._preview._knows(newest)):
            root._preview = Preview(root)
        return root._preview

    def __repr__(self) -> str:
        return f"<Node {self.path}>"

    def _tuple(self) -> tuple:
        return (self._written(), [component._tuple() for component in self.components],
                [child._tuple() for child in self.children], *self.where, _folder(self.where))


class Preview:
    """A part of the engine's scene: components are initialised one by one, when something of theirs is asked for. It is that of
    the tree as it was when it was made."""

    def __init__(self, root: Node):
        self._root = root
        self._made = {id(item): item.path for item in root.walk()}
        self._scene = _stroma.Preview(root._tuple(), root.where[0] or "scene.py")

    def _knows(self, component: Component) -> bool:
        return self._made.get(id(component)) == component.path

    def _get(self, path: str, attribute: str, init: bool = True, found: bool = False) -> Any:
        try:
            return self._scene.get(path, attribute, init, found)
        except SceneError:
            if len(self._made) == sum(1 for _ in self._root.walk()):
                raise
        # what has come since may be what was missing
        self.__init__(self._root)
        return self._scene.get(path, attribute, init, found)

    def get(self, path: str, attribute: str, found: bool = False) -> Any:
        """The value of an attribute, when the component has been initialised."""
        return self._get(path, attribute, True, found)

    def ready(self, path: str) -> bool:
        """Whether it can be initialised as it is written; problems() says why not."""
        return self._scene.ready(path)

    def problems(self, path: Optional[str] = None) -> List[Problem]:
        """What was found so far, of this component and its attributes."""
        found = [Problem(*problem) for problem in self._scene.problems()]
        return [one for one in found if path is None or one.path == path or one.path.startswith(path + ".")]


def _is_looked_up(component: Component) -> bool:
    """Whether others find it without a link, so that what they have computed may be another with it."""
    info = component.info
    return info is not None and info.role in ("topology", "topological mapping", "mechanical state")


def _check(component: Component) -> None:
    """Tells at once what is wrong with the names in a component."""
    info = component.info
    if info is None:
        if _stroma.has_no_effect(component.type) or component.type in ("PythonForceField", "PythonConstraint"):
            return
        raise refusal(f"there is no component '{component.type}'", "a name from stroma.types()",
                      nearest(component.type, types()) or _stroma.advice(component.type), component.where)
    for attribute in component.attributes:
        _check_attribute(component, attribute, component._places.get(attribute, component.where))


def _check_attribute(component: Component, attribute: str, where: Where) -> None:
    info = component.info
    if info is None or info.accepts(attribute):
        return
    raise refusal(f"{component.type} has no attribute '{attribute}'", "one of those that stroma.type_info() lists",
                  nearest(attribute, info.names()), where, component.name)


# ---- XML ----

def _escaped(text: str) -> str:
    for character, entity in (("&", "&amp;"), ("<", "&lt;"), ('"', "&quot;"), ("\n", "&#10;"), ("\r", "&#13;"), ("\t", "&#9;")):
        text = text.replace(character, entity)
    return text


def _lines(node: Node, indent: str) -> Iterator[str]:
    def tag(type: str, written: _Written) -> str:
        return f"<{type}" + "".join(f' {name}="{_escaped(_stroma.text_of(_value(value)))}"' for name, value in written.attributes.items())

    yield f"{indent}{tag('Node', node)}>"
    for component in node.components:
        yield f"{indent}  {tag(component.type, component)}/>"
    for child in node.children:
        yield from _lines(child, indent + "  ")
    yield f"{indent}</Node>"


def to_xml(root: Node) -> str:
    """The scene as the text of a file: numbers have the digits that read back to the same bits."""
    return "\n".join(_lines(root, "")) + "\n"


def _from_tuple(node: tuple, strict: bool) -> Node:
    attributes, components, children, file, line, _ = node
    made = Node(None, (file, line), strict)
    for name, value, at_file, at_line in attributes:
        made._put(name, value, (at_file, at_line))
    for type, given, at_file, at_line, _ in components:
        component = Component(type, None, (at_file, at_line))
        for name, value, value_file, value_line in given:
            component._put(name, value, (value_file, value_line))
        component.parent = made
        made.components.append(component)
    for child in children:
        made.add_child(_from_tuple(child, strict))
    return made


def from_xml(file: Union[str, os.PathLike], strict: bool = False) -> Node:
    """The tree of a scene file, with what it includes."""
    return _from_tuple(_stroma.read_scene(os.fspath(file), None), strict)


def from_xml_text(text: str, name: str = "scene.xml", strict: bool = False) -> Node:
    """The same from a text; `name` stands for the file."""
    return _from_tuple(_stroma.read_scene(name, text), strict)
