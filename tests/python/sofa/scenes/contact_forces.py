# SPDX-License-Identifier: LGPL-2.1-or-later
"""Forces of contacts are read from the solver and from the text of a state's constraint, as SofaPython3's own example does."""
import numpy as np
import Sofa
import SofaRuntime


class AccessForces(Sofa.Core.Controller):
    def __init__(self, *args, **kwargs):
        Sofa.Core.Controller.__init__(self, *args, **kwargs)
        self.node = args[0]
        self.constraint_solver = args[1]
        self.rootNode = args[2]
        self.found = []

    def onAnimateEndEvent(self, event):
        lambda_vector = self.constraint_solver.constraintForces.value
        forcesNorm = self.rootNode.GenericConstraintSolver.constraintForces.value
        contactforce_x = contactforce_y = contactforce_z = 0.0
        for i in range(0, len(lambda_vector[:]), 3):
            contactforce_x += lambda_vector[i] / self.rootNode.dt.value
            contactforce_y += lambda_vector[i + 1] / self.rootNode.dt.value
            contactforce_z += lambda_vector[i + 2] / self.rootNode.dt.value
        self.found.append(contactforce_x)
        constraint = self.node.getObject("mstate").constraint.value
        H = constraint.splitlines()
        for line in H:
            print([float(each) for each in line.split()])
        if len(forcesNorm) > 0 and np.max(forcesNorm) > 0:
            print("contact", self.rootNode.time.value)


def createScene(rootNode):
    SofaRuntime.importPlugin("Sofa.Component.Constraint.Lagrangian.Solver")
    rootNode.dt.value = 0.02
    rootNode.gravity.value = [0.0, 0.0, -10.0]
    solver = rootNode.addObject("GenericConstraintSolver", maxIterations=1000, tolerance=1e-9, computeConstraintForces=True)
    rootNode.addObject("FreeMotionAnimationLoop")
    rootNode.addObject("CollisionPipeline", depth=6, verbose=0, draw=0)
    rootNode.addObject("BruteForceBroadPhase")
    rootNode.addObject("BVHNarrowPhase")
    rootNode.addObject("CollisionResponse", response="FrictionContactConstraint", responseParams="mu=0.1")
    rootNode.addObject("LocalMinDistance", name="Proximity", alarmDistance=0.2, contactDistance=0.05)

    floor = rootNode.addChild("Floor")
    floor.addObject("MeshTopology", name="Topology", position=[[-5, -5, 0], [5, -5, 0], [5, 5, 0], [-5, 5, 0]], triangles="0 1 2  0 2 3")
    floor.addObject("MechanicalObject", template="Vec3d")
    floor.addObject("TriangleCollisionModel", name="FloorModel", moving=False, simulated=False)

    ball = rootNode.addChild("Ball")
    ball.addObject("EulerImplicitSolver")
    ball.addObject("SparseLDLSolver")
    ball.addObject("MechanicalObject", name="mstate", template="Vec3d", position=[0.3, 0.2, 0.06])
    ball.addObject("UniformMass", totalMass=2)
    ball.addObject("LinearSolverConstraintCorrection")
    ball.addObject("PointCollisionModel", name="BallModel")
    ball.addObject(AccessForces(ball, solver, rootNode, name="forces"))
    return rootNode
