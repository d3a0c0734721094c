# SPDX-License-Identifier: LGPL-2.1-or-later
"""Reads the points of a mesh that is not there, and goes wrong with them: both are told, and what else is missing."""


def createScene(root):
    loader = root.addObject("MeshOBJLoader", name="loader", filename="mesh/none.obj")
    root.addObject("CarvingNothing", name="first")
    first = loader.position.value[0]
    root.addObject("MechanicalObject", position=first)
