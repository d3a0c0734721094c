# SPDX-License-Identifier: LGPL-2.1-or-later
"""Two fingers of a library, a floor and a cube: contacts with friction, and keys that close the fingers."""
import os

import Sofa.Core
import Sofa.constants.Key as Key
from softrobots.actuators import PullingCable
from splib3.loaders import loadPointListFromFile
from stlib3.physics.collision import CollisionMesh
from stlib3.physics.constraints import FixedBox
from stlib3.physics.deformable import ElasticMaterialObject
from stlib3.physics.rigid import Cube, Floor
from stlib3.scene import ContactHeader, MainHeader

HERE = os.path.dirname(os.path.abspath(__file__))


class GripperController(Sofa.Core.Controller):
    def __init__(self, *args, **kwargs):
        Sofa.Core.Controller.__init__(self, *args, **kwargs)
        self.name = "FingerController"
        self.cables = kwargs["cables"]

    def onKeypressedEvent(self, event):
        for cable in self.cables:
            displacement = cable.CableConstraint.value[0]
            if event["key"] == Key.uparrow:
                cable.CableConstraint.value = [displacement + 1.]
            elif event["key"] == Key.downarrow:
                cable.CableConstraint.value = [max(0, displacement - 1.)]


def Finger(parentNode=None, name="Finger", rotation=[0.0, 0.0, 0.0], translation=[0.0, 0.0, 0.0], fixingBox=[-1, -1, -1, 1, 21, 21],
           pullPointLocation=[0.0, 18.0, 10.0]):
    finger = parentNode.addChild(name)
    eobject = ElasticMaterialObject(volumeMeshFileName="mesh/finger.vtk", poissonRatio=0.3, youngModulus=18000, totalMass=0.5,
                                    surfaceColor=[0.0, 0.8, 0.7, 1.0], surfaceMeshFileName="mesh/finger.stl", rotation=rotation,
                                    translation=translation)
    finger.addChild(eobject)
    FixedBox(eobject, atPositions=fixingBox, doVisualization=True)
    PullingCable(eobject, "PullingCable", pullPointLocation=pullPointLocation, rotation=rotation, translation=translation,
                 cableGeometry=loadPointListFromFile(os.path.join(HERE, "mesh", "cable.json")))
    CollisionMesh(eobject, name="CollisionMesh", surfaceMeshFileName="mesh/finger.stl", rotation=rotation, translation=translation,
                  collisionGroup=[1, 2])
    return finger


def createScene(rootNode):
    MainHeader(rootNode, gravity=[0.0, -981.0, 0.0], plugins=["SoftRobots"])
    ContactHeader(rootNode, alarmDistance=4, contactDistance=3, frictionCoef=0.08)
    rootNode.VisualStyle.displayFlags = "showBehavior showCollisionModels"
    first = Finger(rootNode, "Finger1")
    second = Finger(rootNode, "Finger2", translation=[0.0, 0.0, 60.0], fixingBox=[-1, -1, 59, 1, 21, 81],
                    pullPointLocation=[0.0, 18.0, 70.0])
    Floor(rootNode, name="Floor", color=[1.0, 0.0, 0.0, 1.0], translation=[0.0, -160.0, 0.0], uniformScale=60.0, isAStaticObject=True,
          surfaceMeshFileName="mesh/cube.obj")
    Cube(rootNode, name="Cube", uniformScale=20.0, color=[1.0, 1.0, 0.0, 1.0], totalMass=0.03, volume=20, translation=[0.0, -78.0, 0.0],
         inertiaMatrix=[1000.0, 0.0, 0.0, 0.0, 1000.0, 0.0, 0.0, 0.0, 1000.0])
    rootNode.addObject(GripperController(cables=[each.ElasticMaterialObject.PullingCable for each in (first, second)]))
