# SPDX-License-Identifier: LGPL-2.1-or-later
"""A controller that removes points by the modifier of the topology, where it has the call."""
import Sofa


class Cut(Sofa.Core.Controller):
    def __init__(self, *args, **kwargs):
        Sofa.Core.Controller.__init__(self, *args, **kwargs)
        self.modifier, self.container = kwargs["modifier"], kwargs["container"]

    def onAnimateBeginEvent(self, event):
        if self.getContext().getRoot().time.value > 0.02:
            self.modifier.removePoints([0, 1], True)


def createScene(root):
    root.addObject("DefaultAnimationLoop")
    body = root.addChild("body")
    body.addObject("EulerImplicitSolver")
    body.addObject("CGLinearSolver", iterations=30, tolerance=1e-9, threshold=1e-9)
    body.addObject("MeshVTKLoader", name="loader", filename="mesh/finger.vtk")
    container = body.addObject("TetrahedronSetTopologyContainer", name="topo", src="@loader")
    modifier = body.addObject("TetrahedronSetTopologyModifier")
    body.addObject("MechanicalObject", name="dofs")
    body.addObject("UniformMass", totalMass=1)
    body.addObject("TetrahedronFEMForceField", youngModulus=1e4, poissonRatio=0.3)
    body.addObject(Cut(modifier=modifier, container=container))
