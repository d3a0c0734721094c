# SPDX-License-Identifier: LGPL-2.1-or-later
"""Data of the scene's own: on a controller and on a node, and components that take their values from them."""
import Sofa


class Material(Sofa.Core.Controller):
    def __init__(self, *args, **kwargs):
        Sofa.Core.Controller.__init__(self, *args, **kwargs)
        self.addData("stiffness", type="float", value=kwargs.get("stiffness", 100.0), help="of the spring", group="Material")
        self.addData("names", type="vector<string>", value=["a", "b"])
        self.addData("on", type="bool", value=True)


def createScene(root):
    root.addObject("DefaultAnimationLoop")
    root.gravity = [0, 0, 0]
    root.dt = 0.01
    root.addData(name="start", type="vector<Vec3d>", value=[[0.5, 0, 0]])
    material = root.addObject(Material(name="material", stiffness=50.0))
    body = root.addChild("body")
    body.addObject("EulerImplicitSolver")
    body.addObject("CGLinearSolver", iterations=20, tolerance=1e-14, threshold=1e-14)
    body.addObject("MechanicalObject", name="dofs", position="@/.start" if False else root.start, rest_position=[0, 0, 0])
    body.addObject("UniformMass", totalMass=2)
    body.addObject("RestShapeSpringsForceField", name="spring", stiffness=material.stiffness, points=[0])
