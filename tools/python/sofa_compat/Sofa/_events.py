# SPDX-License-Identifier: LGPL-2.1-or-later
"""Events to what a scene writes in Python: a method on...Event(self, event), else onEvent(self, event)."""
from . import _catalogue, _messages, _values
from ._objects import Object


def listeners(root):
    """Objects of Python in active nodes, in the order of the tree. Nothing below a node that is switched off hears. Kept until the tree
    is another one: there are many events in a step, and many more objects that hear none."""
    kept = root.__dict__.get("_s_listeners")
    if kept is None or kept[0] != (root._s_revision if kept[2] else root._s_shape):
        linked = []
        found = list(_listening(root, set(), linked))
        kept = root._s_revision if linked else root._s_shape, found, bool(linked)
        object.__setattr__(root, "_s_listeners", kept)
    return kept[1]


def _listening(node, seen, linked):
    """`linked`: gets nodes that other data switch on and off."""
    active = node._s_data.get("activated")
    if active is not None and not isinstance(active._s_raw, (bool, int, type(None))):
        linked.append(node)
    if id(node) in seen or (active is not None and active._s_raw is not None and not active.value):
        return
    seen.add(id(node))
    for each in list(node._s_objects):
        if not each._s_type:
            yield each
    for child in list(node._s_children):
        yield from _listening(child, seen, linked)


def _hears(thing):
    data = thing._s_data.get("listening")
    return data is None or data._s_raw is None or _values.as_bool(data._s_raw)


def _handler(thing, method):
    """Its own: not the empty one that all have."""
    found = getattr(type(thing), method, None)
    if callable(found) and found is not getattr(Object, method, None):
        return getattr(thing, method)
    own = thing.__dict__.get(method)
    return own if callable(own) else None


def send(root, name, values, to_all=True):
    """`name`: "AnimateBeginEvent". `to_all`: also to those that have onEvent() alone."""
    for each in [each for each in listeners(root) if _hears(each)]:
        handler = _handler(each, "on" + name)
        if handler is None and to_all and getattr(type(each), "onEvent", None) is not None:
            handler = each.onEvent
        if handler is not None:
            handler({"type": name, "isHandled": False, **values})


#: what SOFA tells at the beginning and at the end of a step besides: here nothing happens between these moments
AT_BEGIN = ("CollisionBeginEvent", "CollisionEndEvent", "IntegrateBeginEvent")
AT_END = ("IntegrateEndEvent", "UpdateMappingEndEvent")
#: of a constraint solver, before those of the end
OF_CONSTRAINTS = ("BuildConstraintSystemEndEvent", "SolveConstraintSystemEndEvent")
#: of a scene as a whole. A run by a command starts and stops; a program's own loop does neither, as in SOFA
OF_SCENES = ("SimulationInitStartEvent", "SimulationInitDoneEvent", "SimulationInitTexturesDoneEvent", "SimulationStartEvent",
             "SimulationStopEvent")


def begin_step(root, dt):
    send(root, "AnimateBeginEvent", {"dt": dt})
    for name in AT_BEGIN:
        send(root, name, {"dt": dt}, to_all=False)


def end_step(root, dt):
    for name in (*OF_CONSTRAINTS, *AT_END) if _solves_constraints(root) else AT_END:
        send(root, name, {"dt": dt}, to_all=False)
    send(root, "AnimateEndEvent", {"dt": dt})


def _solves_constraints(root):
    return any(each._s_type and each._s_facts.besides is _catalogue.CONSTRAINTS for each in root._s_objects)


def of_scene(root, name):
    """One of OF_SCENES. Start and stop come to onEvent() too, as in SOFA."""
    send(root, name, {}, to_all=name in ("SimulationStartEvent", "SimulationStopEvent"))


_SENT = {"Event", "AnimateBeginEvent", "AnimateEndEvent", "KeypressedEvent", "KeyreleasedEvent", "MouseEvent", "PythonScriptEvent",
         *AT_BEGIN, *AT_END, *OF_CONSTRAINTS, *OF_SCENES}


def warn_of_unsent(root):
    """Methods that nothing will ever call are told, each once."""
    for each in listeners(root):
        for name in dir(type(each)):
            if name.startswith("on") and name.endswith("Event") and name[2:] not in _SENT and callable(getattr(type(each), name)):
                _messages.warn(f"{each._s_place()}: {name}() is not called: the engine has no {name[2:]}")


def user_event(sender, name, value):
    send(sender.getRoot(), "PythonScriptEvent", {"sender": sender, "event_name": name, "userData": value})


def key(root, character, pressed=True):
    from . import _carving

    _carving.hear_key(root, character, pressed)
    send(root, "KeypressedEvent" if pressed else "KeyreleasedEvent", {"key": character})


def mouse(root, state, x, y, wheel):
    send(root, "MouseEvent", {"State": state, "mouseX": x, "mouseY": y, "wheelDelta": wheel})


def call(root, method, only=Object):
    """`method` of all objects of Python, of a class `only`, that have one."""
    for each in [each for each in listeners(root) if isinstance(each, only)]:
        found = getattr(each, method, None)
        code = getattr(getattr(type(each), method, None), "__code__", None)
        if found is not None and not (code is not None and code.co_argcount == 0 and not code.co_flags & 4):  # written without self
            found()
