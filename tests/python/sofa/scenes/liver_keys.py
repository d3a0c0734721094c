# SPDX-License-Identifier: LGPL-2.1-or-later
"""Points are moved by keys, entry by entry, with the keys compared as characters; a handler that asks for what was pressed."""
import Sofa
from Sofa.constants import *


class KeyboardController(Sofa.Core.Controller):
    """ This is a custom controller to change values of Data by keyboard events. """

    def __init__(self, *args, **kwargs):
        Sofa.Core.Controller.__init__(self, *args, **kwargs)
        print(" Python::__init__::" + str(self.name.value))
        self.mo = kwargs.get("mo")
        self.mechanical_object = self.mo
        self.pressed = 0

    def onKeypressedEvent(self, event):
        key = event['key']
        if ord(key) == 19:  # up
            print("You pressed the Up key")
        elif ord(key) == 21:
            print("down")
        if key == Key.A:
            self.pressed += 1
            with self.mo.position.writeable() as wa:
                wa[0] += [0, 0.1, 0]
        elif key == 'B':
            self.mo.velocity = [[0., 1., 0.]] * len(self.mo.position)
        if key == Key.I:
            print(self.mo.position.value[0][0], self.mo.position[0])

    def onKeyreleasedEvent(self, event):
        print("released", event["key"])

    def onAnimateBeginEvent(self, e):
        self.onKeypressedEvent({"key": "A"})
        self.onKeypressedEvent({"key": Key.uparrow})
        self.onKeypressedEvent(dict(key=Key.I))


def createScene(root):
    root.gravity = [0, 0, 0]
    root.dt = 0.01
    root.addObject("DefaultAnimationLoop")
    root.addObject("DefaultVisualManagerLoop")
    liver = root.addChild("Liver")
    liver.addObject("EulerImplicitSolver", name="cg_odesolver", printLog="0")
    liver.addObject("CGLinearSolver", name="linear solver", iterations="25", tolerance="1e-9", threshold="1e-9")
    liver.addObject("MeshVTKLoader", name="loader", filename="mesh/finger.vtk", scale=0.01)
    liver.addObject("TetrahedronSetTopologyContainer", src="@loader")
    liver.addObject("TetrahedronSetGeometryAlgorithms", template="Vec3d", name="GeomAlgo")
    mo = liver.addObject("MechanicalObject", name="MechanicalModel", template="Vec3d", tags="mecha")
    liver.addObject("DiagonalMass", name="diagonalmass", massDensity="1.0")
    liver.addObject("TetrahedralCorotationalFEMForceField", name="FEM", template="Vec3d", youngModulus="3000", poissonRatio="0.3",
                    method="large", computeGlobalMatrix="0")
    liver.addObject("FixedConstraint", template="Vec3d", name="FixedConstraint", indices="3 39 64")
    liver.addObject(KeyboardController(name="KeyboardController", mo=mo))
    visu = liver.addChild("Visu")
    visu.addObject("OglModel", template="ExtVec3f", name="VisualModel", filename="mesh/finger.stl", scale3d="0.01 0.01 0.01")
    visu.addObject("BarycentricMapping", name="VisualMapping", input="@../MechanicalModel", output="@VisualModel")
    surf = liver.addChild("Surf")
    surf.addObject("MechanicalObject", name="spheres", position=[[0.1, 0.1, 0.1], [0.5, 0.1, 0.1]])
    surf.addObject("SphereCollisionModel", name="CollisionModel", radius=[0.05, 0.04])
    surf.addObject("BarycentricMapping", name="CollisionMapping", input="@../MechanicalModel", output="@spheres")
    return root
