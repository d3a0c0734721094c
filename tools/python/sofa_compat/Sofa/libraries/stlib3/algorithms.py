# SPDX-License-Identifier: LGPL-2.1-or-later
"""Nodes by paths, and files of points."""
from splib3.loaders import getLoadingLocation, loadPointListFromFile  # noqa: F401
from splib3.scenegraph import find, get, getLinkPath  # noqa: F401
