# SPDX-License-Identifier: LGPL-2.1-or-later
"""What loaders, grids and regions compute is read while the scene is built."""
import os

import numpy as np

HERE = os.path.dirname(os.path.abspath(__file__))


def createScene(root):
    root.addObject("DefaultAnimationLoop")
    root.gravity = [0, 0, 0]
    body = root.addChild("body")
    loader = body.addObject("MeshOBJLoader", name="loader", filename=os.path.join(HERE, "tetrahedron.obj"), scale=2)
    loader.init()
    points = loader.position.value
    body.corners = np.array(points)
    body.faces = len(loader.triangles.value)
    grid = body.addObject("RegularGridTopology", name="grid", n=[3, 3, 3], min=[0, 0, 0], max=[2, 2, 2])
    roi = body.addObject("BoxROI", name="roi", box=[-1, -1, -1, 0.5, 3, 3], position="@grid.position")
    roi.init()
    body.chosen = [int(index) for index in roi.indices.value]
    body.nodes = grid.position.array().shape
    body.addObject("EulerImplicitSolver")
    body.addObject("CGLinearSolver", iterations=20, tolerance=1e-9, threshold=1e-9)
    body.addObject("MechanicalObject", name="dofs", position=(points + np.array([0, 0, 1])).tolist())
    body.addObject("UniformMass", vertexMass=0.1)
