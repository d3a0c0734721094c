# SPDX-License-Identifier: LGPL-2.1-or-later
"""A prefab: a node with parameters, which its class fills; and one that is a function."""
import Sofa


class Body(Sofa.Prefab):
    prefabParameters = [
        {"name": "mass", "type": "float", "help": "of the body", "default": 1.0},
        {"name": "height", "type": "float", "help": "of its start", "default": 0.0},
    ]

    def __init__(self, *args, **kwargs):
        Sofa.Prefab.__init__(self, *args, **kwargs)

    def init(self):
        self.addObject("EulerImplicitSolver")
        self.addObject("CGLinearSolver", iterations=10, tolerance=1e-14, threshold=1e-14)
        self.addObject("MechanicalObject", name="dofs", position=[0, 0, self.height.value])
        self.addObject("UniformMass", totalMass=self.mass.value)


class Raw(Sofa.Core.RawPrefab):
    def __init__(self, *args, **kwargs):
        Sofa.Core.RawPrefab.__init__(self, *args, **kwargs)
        self.addPrefabParameter(name="mass", type="float", default=3.0, help="of the body")
        self.init()

    def init(self):
        self.addObject("EulerImplicitSolver")
        self.addObject("CGLinearSolver", iterations=10, tolerance=1e-14, threshold=1e-14)
        self.addObject("MechanicalObject", name="dofs", position=[0, 0, 0])
        self.addObject("UniformMass", name="uniform", totalMass=self.mass.value)


def Pair(node, name="pair"):
    child = node.addChild(name)
    child.addChild(Body(name="one", mass=2.0, height=1.0))
    child.addChild(Body(name="two"))
    return child


def createScene(root):
    root.gravity = [0, 0, -10]
    root.dt = 0.1
    root.addObject("DefaultAnimationLoop")
    Pair(root)
    root.addChild(Raw(name="raw"))
