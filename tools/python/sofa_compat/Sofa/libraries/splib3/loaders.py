# SPDX-License-Identifier: LGPL-2.1-or-later
"""Files of points, and where they are."""
import json
import os


def getLoadingLocation(filename, source=None):
    """The path of a file beside `source`, a folder or a file in it."""
    if source is None:
        return filename
    return os.path.join(os.path.dirname(os.path.abspath(source)) if os.path.isfile(source) else source, filename)


def loadPointListFromFile(s):
    with open(s, encoding="utf-8") as file:
        return json.load(file)
