# SPDX-License-Identifier: LGPL-2.1-or-later
"""The finger of the soft robots' tutorial with self-contact: groups, a sub-topology that is stiffer, functions with defaults."""
import os

import Sofa
import Sofa.constants.Key as Key
from splib3.numerics import Vec3  # noqa: F401
from stlib3.physics.collision import CollisionMesh
from stlib3.physics.constraints import FixedBox
from softrobots.actuators import PullingCable

dirPath = os.path.dirname(os.path.abspath(__file__)) + '/mesh/'


class FingerController(Sofa.Core.Controller):
    def __init__(self, *args, **kwargs):
        Sofa.Core.Controller.__init__(self, args, kwargs)
        self.cable = args[0]
        self.name = "FingerController"

    def onKeypressedEvent(self, e):
        displacement = self.cable.CableConstraint.value[0]
        if e["key"] == Key.plus:
            displacement += 1.
        elif e["key"] == Key.minus:
            displacement -= 1.
            if displacement < 0:
                displacement = 0
        self.cable.CableConstraint.value = [displacement]

    def onAnimateBeginEvent(self, event):
        self.onKeypressedEvent({"key": Key.plus})


def Finger(parentNode=None, name="Finger", rotation=[0.0, 0.0, 0.0], translation=[0.0, 0.0, 0.0],
           fixingBox=[-1., -1., -1., 1., 21., 21.], pullPointLocation=[0.0, 18.0, 10.0]):
    finger = parentNode.addChild(name)
    finger.addObject("MeshVTKLoader", name="loader", filename=dirPath + "finger.vtk", rotation=rotation, translation=translation)
    finger.addObject("MeshTopology", name="container", src="@loader")
    finger.addObject("MechanicalObject", name="dofs")
    finger.addObject("UniformMass", totalMass=0.05)
    finger.addObject("TetrahedronFEMForceField", name="FEM", youngModulus=18000, poissonRatio=0.3, method="large")
    FixedBox(finger, atPositions=fixingBox, doVisualization=True)
    stiff = finger.addObject("BoxROI", name="boxROISubTopo", box=[60, -1, -1, 81, 21, 21], strict=False)
    sub = finger.addChild("modelSubTopo")
    sub.addObject("MeshTopology", position="@loader.position", tetrahedra=stiff.tetrahedraInROI.getLinkPath(), name="container")
    sub.addObject("TetrahedronFEMForceField", template="Vec3", name="FEM", method="large", poissonRatio=0.3, youngModulus=150000)
    cable = PullingCable(finger, "PullingCable", pullPointLocation=pullPointLocation, rotation=rotation, translation=translation,
                         cableGeometry=[[10., 18., 10.], [30., 18., 10.], [50., 18., 10.], [70., 18., 10.]])
    finger.addObject(FingerController(cable))
    CollisionMesh(finger, name="CollisionMesh", surfaceMeshFileName=dirPath + "finger.stl", rotation=rotation, translation=translation,
                  collisionGroup=[1, 2])
    return finger


def createScene(rootNode):
    from stlib3.scene import MainHeader
    m = MainHeader(rootNode, plugins=["SoftRobots"])
    rootNode.removeObject(rootNode.getObject("DefaultAnimationLoop")) if rootNode.hasObject("DefaultAnimationLoop") else None
    rootNode.addObject("FreeMotionAnimationLoop")
    rootNode.addObject("GenericConstraintSolver", tolerance=1e-8, maxIterations=250)
    rootNode.gravity = [0., -981.0, 0.]
    rootNode.dt = 0.01
    simulation = rootNode.addChild("Simulation")
    simulation.addObject("EulerImplicitSolver", rayleighStiffness=0.1)
    simulation.addObject("SparseLDLSolver", template="CompressedRowSparseMatrixMat3x3d")
    simulation.addObject("GenericConstraintCorrection")
    Finger(simulation)
    assert m is not None or m is None
    return rootNode
