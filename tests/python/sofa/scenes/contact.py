# SPDX-License-Identifier: LGPL-2.1-or-later
"""A ball between a controller that watches it and a floor that nothing moves, with SOFA's parts for contacts at the root."""
import Sofa


class Watch(Sofa.Core.Controller):
    lowest = 1.0

    def __init__(self, *args, **kwargs):
        Sofa.Core.Controller.__init__(self, *args, **kwargs)
        self.dofs = kwargs["dofs"]

    def onAnimateEndEvent(self, event):
        self.lowest = min(self.lowest, self.dofs.position.value[0][1])


def createScene(root):
    root.dt = 0.01
    root.gravity = [0, -10, 0]
    root.addObject("CollisionPipeline")
    root.addObject("BruteForceBroadPhase")
    root.addObject("BVHNarrowPhase")
    root.addObject("CollisionResponse", response="PenalityContactForceField")
    root.addObject("MinProximityIntersection", alarmDistance=0.5, contactDistance=0.2)
    floor = root.addChild("floor")
    floor.addObject("MeshTopology", position=[[-9, 0, -7], [9, 0, -9], [9, 0, 9], [-9, 0, 9]], triangles=[[0, 1, 2], [0, 2, 3]])
    floor.addObject("MechanicalObject", name="dofs")
    floor.addObject("TriangleCollisionModel", simulated=False, moving=False)
    ball = root.addChild("ball")
    ball.addObject("EulerImplicitSolver")
    ball.addObject("SparseLDLSolver")
    ball.addObject("MechanicalObject", name="dofs", position=[0, 1, 0])
    ball.addObject("UniformMass", totalMass=1)
    ball.addObject("PointCollisionModel")
    root.addObject(Watch(name="watch", dofs=ball.dofs))
