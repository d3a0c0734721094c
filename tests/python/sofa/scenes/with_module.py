# SPDX-License-Identifier: LGPL-2.1-or-later
"""A module beside the scene, and a mesh in a folder that the scene names."""
import os

import SofaRuntime
from parts_of_scene import add_solver

SofaRuntime.DataRepository.addFirstPath(os.path.join(os.path.dirname(__file__), "data"))


def createScene(root):
    root.addObject("DefaultAnimationLoop")
    root.gravity = [0, 0, 0]
    body = root.addChild("body")
    add_solver(body)
    body.addObject("MeshOBJLoader", name="loader", filename="mesh/box.obj")
    body.addObject("MechanicalObject", name="dofs", src="@loader")
    body.addObject("UniformMass", totalMass=1)
