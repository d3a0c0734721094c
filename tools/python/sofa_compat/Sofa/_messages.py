# SPDX-License-Identifier: LGPL-2.1-or-later
"""What is told, each thing once."""
import difflib
import os
import sys
import sysconfig
import traceback

_told = set()


def tell(kind, text):
    """To standard error, once: "warning: ..."."""
    if (kind, text) in _told:
        return
    _told.add((kind, text))
    sys.stdout.flush()
    print(f"{kind}: {text}", file=sys.stderr, flush=True)


def note(text):
    tell("note", text)


def warn(text):
    tell("warning", text)


def nearest(word, candidates):
    """The most similar of `candidates`, or empty."""
    found = difflib.get_close_matches(str(word), list(candidates), 1, 0.75)
    return found[0] if found else ""


_OTHERS = (os.path.dirname(os.path.abspath(__file__)), sysconfig.get_paths()["stdlib"], "<frozen")


def place_of(error):
    """(file, line) where an error arose: in the scene or a library of scenes rather than in Python's own; None: nowhere."""
    frames = traceback.extract_tb(error.__traceback__)
    own = [frame for frame in frames if not os.path.abspath(frame.filename).startswith(_OTHERS)
           and not frame.filename.startswith("<") and "-packages" not in frame.filename]
    last = (own or [frame for frame in frames if not os.path.abspath(frame.filename).startswith(_OTHERS[0])] or [None])[-1]
    return (last.filename, last.lineno) if last else None
