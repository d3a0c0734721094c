# SPDX-License-Identifier: LGPL-2.1-or-later
"""A prefab whose links are made while it hangs nowhere, in a model that the node of the solver takes as a second parent."""
import Sofa


class Elastic(Sofa.Prefab):
    properties = [
        {"name": "name", "type": "string", "help": "of the node", "default": "Elastic"},
        {"name": "size", "type": "Vec3d", "help": "of the block", "default": [1.0, 1.0, 1.0]},
        {"name": "mesh", "type": "string", "help": "not used", "default": ""},
        {"name": "totalMass", "type": "double", "help": "of the block", "default": 1.0},
    ]

    def __init__(self, *args, **kwargs):
        Sofa.Prefab.__init__(self, *args, **kwargs)

    def init(self):
        self.loader = self.addObject("RegularGridTopology", name="loader", n=[2, 2, 2], min=[0, 0, 0], max=list(self.size.value))
        self.container = self.addObject("HexahedronSetTopologyContainer", src=self.loader.getLinkPath(), name="container")
        self.dofs = self.addObject("MechanicalObject", template="Vec3", name="dofs")
        self.mass = self.addObject("UniformMass", totalMass=self.totalMass.value, name="mass")
        self.field = self.addObject("HexahedronFEMForceField", name="field", youngModulus=1e4, poissonRatio=0.3, method="large")
        if self.mesh:
            raise ValueError("an empty text is false")
        points = self.container.position
        self.middle = [sum(points[i][k] for i in range(len(points))) / len(points) for k in range(3)]


def createScene(root):
    root.gravity = [0, 0, -10]
    root.dt = 0.1
    root.addObject("DefaultAnimationLoop")
    root.addChild("Modelling")
    simulation = root.addChild("Simulation")
    simulation.addObject("EulerImplicitSolver", name="TimeIntegrationSchema")
    simulation.addObject("CGLinearSolver", name="LinearSolver", iterations=50, tolerance=1e-12, threshold=1e-12)
    block = root.Modelling.addChild(Elastic(size=[2.0, 1.0, 1.0], totalMass=3.0))
    block.totalMass = 5.0  # a parameter: the block is filled anew
    inner = block.addChild(block.name)
    inner.addObject("MechanicalObject", name="marks", position=[block.middle])
    inner.addObject("BarycentricMapping")
    simulation.addChild(root.Modelling)
