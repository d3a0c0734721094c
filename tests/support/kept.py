# SPDX-License-Identifier: LGPL-2.1-or-later
"""Files of a person that a test overwrites for a while."""
import contextlib
import os


@contextlib.contextmanager
def kept(path):
    """The file as it was, whatever happens meanwhile."""
    before = None
    if os.path.exists(path):
        with open(path, "rb") as file:
            before = file.read()
    try:
        yield
    finally:
        if before is not None:
            with open(path, "wb") as file:
                file.write(before)
        elif os.path.exists(path):
            os.remove(path)
