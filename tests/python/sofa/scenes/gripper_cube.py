# SPDX-License-Identifier: LGPL-2.1-or-later
"""Two fingers around a rigid cube with friction: nodes by loops, contact parameters by keys of a dictionary."""
import Sofa

contact = {"alarmDistance": 5, "contactDistance": 2, "angleCone": 0.02}


class Close(Sofa.Core.Controller):
    def __init__(self, fingers, **kw):
        Sofa.Core.Controller.__init__(self, **kw)
        self.fingers = fingers

    def onAnimateBeginEvent(self, event):
        for finger in self.fingers:
            c = finger.cable.CableConstraint
            c.value.value = [c.value.value[0] + 0.5]


def createScene(root):
    root.gravity = [0, -9810, 0]
    root.dt = 0.005
    root.addObject("FreeMotionAnimationLoop")
    root.addObject("LCPConstraintSolver", mu="0.7", tolerance="1e-6", maxIt="1000", build_lcp=False)
    root.addObject("DefaultPipeline", verbose="0")
    root.addObject("BruteForceDetection", name="N2")
    root.addObject("DefaultContactManager", response="FrictionContact", responseParams="mu=0.7")
    root.addObject("LocalMinDistance", name="Proximity", **contact)
    fingers = []
    for i, (turn, dy) in enumerate(((0, -30), (180, 30))):
        finger = root.addChild(f"finger{i}")
        finger.addObject("EulerImplicit", name="odesolver")
        finger.addObject("SparseLDLSolver")
        finger.addObject("MeshVTKLoader", name="loader", filename="mesh/finger.vtk", rotation=[turn, 0, 0],
                         translation=[0, dy - 10 if turn == 0 else dy + 10, -10 if turn == 0 else 10])
        finger.addObject("TetrahedronSetTopologyContainer", src="@loader")
        finger.addObject("MechanicalObject", name="dofs", template="Vec3d")
        finger.addObject("UniformMass", totalMass="0.05")
        finger.addObject("TetrahedronFEMForceField", youngModulus=3000, poissonRatio=0.4)
        finger.addObject("BoxROI", name="box", box=[-1, -1000, -1000, 1, 1000, 1000])
        finger.addObject("FixedConstraint", indices=finger.box.findData("indices").getLinkPath())
        finger.addObject("LinearSolverConstraintCorrection")
        cable = finger.addChild("cable")
        side = 18 if turn == 0 else 2
        sign = 1 if turn == 0 else -1
        base = dy - 10 if turn == 0 else dy + 10
        line = [[x, base + sign * (side if turn == 0 else 18), 0] for x in (5, 40, 75)]
        cable.addObject("MechanicalObject", position=line)
        cable.addObject("CableConstraint", indices=[0, 1, 2], pullPoint=[0, line[0][1], 0])
        cable.addObject("BarycentricMapping")
        skin = finger.addChild("skin")
        skin.addObject("MeshSTLLoader", name="loader", filename="mesh/finger.stl", rotation=[turn, 0, 0],
                       translation=[0, dy - 10 if turn == 0 else dy + 10, -10 if turn == 0 else 10])
        skin.addObject("MeshTopology", src="@loader")
        skin.addObject("MechanicalObject")
        for model in ("TriangleModel", "LineModel", "PointModel"):
            skin.addObject(model, group=i + 1)
        skin.addObject("BarycentricMapping")
        fingers.append(finger)
    cube = root.addChild("cube")
    cube.addObject("EulerImplicit")
    cube.addObject("CGLinearSolver", iterations=25, tolerance=1e-9, threshold=1e-9)
    cube.addObject("MechanicalObject", template="Rigid3d", position=[50, 0, 0, 0, 0, 0, 1])
    cube.addObject("UniformMass", vertexMass=[0.01, 20., [1000., 0., 0., 0., 1000., 0., 0., 0., 1000.]])
    cube.addObject("UncoupledConstraintCorrection")
    touch = cube.addChild("touch")
    touch.addObject("MeshObjLoader", name="loader", filename="mesh/cube.obj", scale=14)
    touch.addObject("MeshTopology", src="@loader")
    touch.addObject("MechanicalObject")
    for model in ("TriangleModel", "LineModel", "PointModel"):  # fingers that are bent meet its edges
        touch.addObject(model, group=3)
    touch.addObject("RigidMapping", input="@..", output="@.")
    root.addObject(Close(fingers, name="close"))
