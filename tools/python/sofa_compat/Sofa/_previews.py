# SPDX-License-Identifier: LGPL-2.1-or-later
"""Values before there is a simulation: what components compute, on the part of the tree that they depend on."""
from . import _catalogue, _messages, _values
from ._base import Base
from ._data import Data
from ._mirror import Mirror
from ._node import Node
from ._objects import Object

#: roles of what others find without a link, in their node or above
_LOOKED_UP = ("topology", "mechanical state", "topological mapping", "mapping")
#: of those that fill what their output names, wherever that is
_FILLING = {"topological mapping", "mapping"}
#: of those that are left out of a scene where nothing reads them
_IDLE = {"engine", "mesh engine"}


def value_of(thing, data):
    """The value that init() of a component computes, on what the tree has now; None when it cannot."""
    root = thing.getRoot()
    if root is thing or not _is_wanted(thing):
        return None
    register = _register_of(root)
    kept = thing.__dict__.get("_s_preview")
    if kept is None or kept.revision != root._s_revision:
        part = _Part(root, register, thing)
        if kept is None or kept.stamp != part.stamp:
            kept = _Kept(part.stamp)
            object.__setattr__(thing, "_s_preview", kept)
        kept.revision = root._s_revision
    if data._s_name not in kept.values:
        scene = kept.scene or register.scene
        if scene is None or scene.stamps.get(id(thing)) != kept.stamp:
            scene = _scene_for(root, register, thing, kept)
        value = _computed(scene, thing, data)
        if value is None:
            return None
        kept.values[data._s_name] = value
    return kept.values[data._s_name]


def forget(root):
    """The scene runs: what was kept of the time before is not needed any more."""
    root.__dict__.pop("_s_register", None)
    for each in root._s_all_objects():
        each.__dict__.pop("_s_preview", None)


class _Kept:
    """Values of one component. `stamp`: of the part that they come from; `scene`: of a loader, which has one for itself."""

    def __init__(self, stamp):
        self.stamp, self.revision, self.values, self.scene = stamp, None, {}, None


class _Scene:
    """A part of a tree in the engine. `stamps`: by id, of each component whose part is in it as a whole."""

    def __init__(self, root, parts):
        things, nodes, self.stamps = {}, {}, {}
        for part in parts:
            things.update(part.things), nodes.update(part.nodes)
            self.stamps[id(part.thing)] = part.stamp
        self.mirror = Mirror(root, keep_loaders=True, part=(things, nodes))
        self.preview = self.mirror.root.preview()


def _scene_for(root, register, thing, kept):
    """With all that came or changed since the last one, so that each comes once; a loader reads its file once, and no other's."""
    part = _Part(root, register, thing)
    if thing._s_facts.role == "mesh loader":
        kept.scene = _Scene(root, [part])
        return kept.scene
    unseen, register.unseen = register.unseen, {}
    others = [_Part(root, register, each) for each in unseen.values() if each is not thing and each.getRoot() is root and _is_wanted(each)]
    register.scene = _Scene(root, [*others, part])
    return register.scene


def _computed(scene, thing, data):
    path = scene.mirror.paths.get(id(thing))
    try:
        return None if path is None else scene.preview.get(path, data._s_name)
    except RuntimeError as error:  # told when the scene is loaded; but a loader that nothing else reads is not
        if "is not found" in str(error):
            _messages.warn(str(error).splitlines()[0].replace(": error: ", ": ", 1))
        return None


# ---- what a component depends on ----

def _is_wanted(thing):
    return isinstance(thing, Object) and bool(thing._s_type) and thing._s_facts.role in _catalogue.COMPUTED_ROLES


class _Part:
    """What a component depends on: `things` and `nodes`, by id. `stamp`: another one when any of it changes."""

    def __init__(self, root, register, thing):
        self.thing, self.things, self.nodes, self._looked = thing, {}, {}, set()
        self._root, self._register, self._waits, self._is_mixed = root, register, [thing], False
        while self._waits:
            each = self._waits.pop()
            if id(each) not in self.things:
                self.things[id(each)] = each
                self._take_above(each._s_node(), each._s_facts.role != "mesh loader")
                self._take_sources(each)
        for each in register.asking(thing):
            self.things[id(each)] = each
            self._take_above(each._s_node())
        stamp = [each._s_version for each in (*self.things.values(), *self.nodes.values())]
        self.stamp = tuple(stamp + [root._s_revision] if self._is_mixed else stamp)

    def _take_sources(self, thing):
        for _, target, is_data in self._register.links_of(thing):
            is_here = target.getRoot() is self._root
            if is_here and _is_wanted(target):
                self._waits.append(target)
            elif is_here and not is_data and isinstance(target, Node):
                self._take_above(target)
            else:  # a value that Python gives: it may come from anywhere
                self._is_mixed = True
        self._waits += self._register.filling(thing)

    def _take_above(self, node, looks=True):
        """The node and those above; `looks`: with what is found in them without a link. False: none leads to the root."""
        if id(node) in (self._looked if looks else self.nodes):
            return True
        above = [parent for parent in node._s_parents if self._take_above(parent, looks)]
        if node is not self._root and not above:
            return False
        self.nodes[id(node)] = node
        if looks:
            self._looked.add(id(node))
            roles = node._s_roles()
            self._waits += [each for role in _LOOKED_UP for each in roles.get(role, ())]
        return True


def _register_of(root):
    register = root.__dict__.get("_s_register")
    if register is None:
        register = _Register()
        for each in root._s_all_objects():
            register.fresh[id(each)] = each
        object.__setattr__(root, "_s_register", register)
    register.update(root)
    return register


class _Register:
    """Of a tree: who links to what. `fresh`: what came or changed since it was brought up; `unseen`: since the last scene."""

    def __init__(self):
        self.fresh, self.unseen, self.scene, self.revision = {}, {}, None, None
        self._links, self._readers, self._fillers, self._by_text = {}, {}, {}, {}

    def update(self, root):
        if self.revision == root._s_revision:
            return
        fresh, self.fresh, self.revision = self.fresh, {}, root._s_revision
        for each in fresh.values():
            if isinstance(each, Object):
                self.unseen[id(each)] = each
        for each in [*fresh.values(), *(each for key, each in self._by_text.items() if key not in fresh)]:
            self._take(each, each.getRoot() is root and _is_wanted(each))

    def _take(self, thing, is_here):
        links, by_text = _links_of(thing) if is_here else ((), False)
        if links != self._links.get(id(thing), ()):
            for _, target, _ in self._links.pop(id(thing), ()):
                for known in (self._readers, self._fillers):
                    known.get(id(target), {}).pop(id(thing), None)
            for name, target, _ in links:
                self._readers.setdefault(id(target), {})[id(thing)] = thing
                if name.startswith("output") and thing._s_facts.role in _FILLING:
                    self._fillers.setdefault(id(target), {})[id(thing)] = thing
            self._links[id(thing)] = links
        if by_text:
            self._by_text[id(thing)] = thing
        else:
            self._by_text.pop(id(thing), None)

    def links_of(self, thing):
        return self._links.get(id(thing), ())

    def filling(self, thing):
        """Mappings that name it as what they fill."""
        return list(self._fillers.get(id(thing), {}).values())

    def asking(self, thing, seen=()):
        """Of an engine: one that reads it and is never left out, with those between; empty where there is none."""
        if thing._s_facts.role not in _IDLE:
            return []
        for each in self._readers.get(id(thing), {}).values():
            if each is thing or each in seen:
                continue
            if each._s_facts.role not in _IDLE:
                return [each]
            found = self.asking(each, (*seen, thing))
            if found:
                return [each, *found]
        return []


def _links_of(thing):
    """([(name, what it leads to, whether it is data)], whether a link is a text, which leads elsewhere when the tree grows)."""
    found, by_text = [], False
    for name, data in thing._s_data.items():
        raw = data._s_raw
        for item in _values.flat(raw) if isinstance(raw, (list, tuple)) else (raw,):
            if isinstance(item, (Base, Data)):
                found.append((name, *_end_of(item)))
            elif name != "name" and _values.is_link_text(item):
                by_text = True
                found += [(name, *_end_of(target)) for target in _led_to(thing, name, item) if target is not data]
    return found, by_text


def _end_of(target):
    return (target._s_owner, True) if isinstance(target, Data) else (target, False)


def _led_to(thing, name, text):
    for link in _values.links_in(text):
        target = thing._s_linked(link, name)
        words = link.split() if target is None else []
        for each in [target, *(thing._s_linked(word, name) for word in words if word.startswith("@"))]:
            if each is not None:
                yield each
