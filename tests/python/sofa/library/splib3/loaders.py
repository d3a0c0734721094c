# SPDX-License-Identifier: LGPL-2.1-or-later
"""Files of points."""
import json


def loadPointListFromFile(filename):
    with open(filename, encoding="utf-8") as file:
        return json.load(file)
