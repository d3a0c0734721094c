# SPDX-License-Identifier: LGPL-2.1-or-later
"""Sofa.Helper: messages of scenes, to standard error."""
import sys


def _message(kind):
    def tell(*arguments):
        emitter, text = (arguments[0], arguments[1]) if len(arguments) > 1 else ("", arguments[0] if arguments else "")
        name = emitter if isinstance(emitter, str) else emitter.getPathName() if hasattr(emitter, "getPathName") else str(emitter)
        sys.stdout.flush()
        print(f"[{kind}] [{name or 'SofaPython3'}] {text}", file=sys.stderr)

    return tell


msg_info = _message("INFO")
msg_warning = _message("WARNING")
msg_error = _message("ERROR")
msg_deprecated = _message("DEPRECATED")
msg_fatal = _message("FATAL")
msg_advice = _message("SUGGESTION")


class MessageHandler:
    """with MessageHandler(): messages go on as they are."""

    def __enter__(self):
        return self

    def __exit__(self, *_):
        return False

    def process(self, *_):
        pass


def GetVersion():
    import Sofa

    return Sofa.version


def getMessageHandlerComponents():
    return []


class System:
    """Folders of SOFA: there are none."""

    class DataRepository:
        pass


class Vector:
    @staticmethod
    def getName():
        return "Vector"
