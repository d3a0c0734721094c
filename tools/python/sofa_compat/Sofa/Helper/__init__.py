# SPDX-License-Identifier: LGPL-2.1-or-later
"""Sofa.Helper: messages of scenes, to standard error."""
import sys

from .._base import Base
from .._repository import FileRepository


def _message(kind):
    def tell(*arguments):
        """(text), (emitter, text), (text, file, line) or (emitter, text, file, line)."""
        if not 1 <= len(arguments) <= 4:
            raise TypeError(f"a message has 1 to 4 arguments, not {len(arguments)}: expected (text), (emitter, text), and perhaps file and line")
        emitter, text = arguments[:2] if len(arguments) in (2, 4) else ("", arguments[0])
        if isinstance(emitter, Base):
            emitter._s_logged(kind, text)
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


class System:
    """Lists of folders."""

    FileRepository = FileRepository
