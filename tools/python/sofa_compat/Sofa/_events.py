# SPDX-License-Identifier: LGPL-2.1-or-later
"""Events to what a scene writes in Python: a method on...Event(self, event), else onEvent(self, event)."""
from . import _values
from ._objects import Object


def listeners(root):
    """Objects of Python in active nodes, in the order of the tree."""
    for node in root._s_all_nodes():
        active = node._s_data.get("activated")
        if active is not None and active._s_raw is not None and not active.value:
            continue
        for each in list(node._s_objects):
            if not each._s_type:
                yield each


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


def send(root, name, values):
    """`name`: "AnimateBeginEvent"."""
    for each in list(listeners(root)):
        if not _hears(each):
            continue
        event = {"type": name, "isHandled": False, **values}
        handler = _handler(each, "on" + name)
        if handler is not None:
            handler(event)
            continue
        handler = getattr(each, "onEvent", None)
        if handler is not None:
            handler(event)


def user_event(sender, name, value):
    send(sender.getRoot(), "PythonScriptEvent", {"sender": sender, "event_name": name, "userData": value})


def key(root, character, pressed=True):
    send(root, "KeypressedEvent" if pressed else "KeyreleasedEvent", {"key": character})


def call(root, method, *arguments):
    """`method` of all objects of Python that have one."""
    for each in list(listeners(root)):
        found = getattr(each, method, None)
        code = getattr(getattr(type(each), method, None), "__code__", None)
        if found is not None and not (code is not None and code.co_argcount == 0 and not code.co_flags & 4):  # written without self
            found(*arguments)
