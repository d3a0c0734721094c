# SPDX-License-Identifier: LGPL-2.1-or-later
"""An arm of two joints whose angles are numbers; a controller moves their rest, frames and a tip follow."""
from math import radians

import Sofa


def createScene(root):
    root.addObject("FreeMotionAnimationLoop")
    root.addObject("GenericConstraintSolver", tolerance=1e-9, maxIterations=1000)
    arm = root.addChild("arm")
    arm.addObject("EulerImplicitSolver")
    arm.addObject("SparseLDLSolver")
    arm.addObject("GenericConstraintCorrection")
    arm.addObject("MechanicalObject", name="dofs", template="Vec1", position=[[0.], [0.]])
    arm.addObject("RestShapeSpringsForceField", stiffness=1e5, points=[0, 1])
    arm.addObject("ArticulatedHierarchyContainer")
    for i in range(2):
        c = arm.addChild("center%d" % i)
        c.addObject("ArticulationCenter", parentIndex=i, childIndex=i + 1, posOnParent=[10. if i else 0, 0, 0], posOnChild=[0, 0, 0])
        a = c.addChild("articulation")
        a.addObject("Articulation", translation=False, rotation=True, rotationAxis=[0, 0, 1], articulationIndex=i)
    r = arm.addChild("rigid")
    r.addObject("MechanicalObject", name="dofs", template="Rigid3",
                position=[[0, 0, 0, 0, 0, 0, 1], [0, 0, 0, 0, 0, 0, 1], [10, 0, 0, 0, 0, 0, 1]])
    r.addObject("UniformMass", totalMass=0.1)
    r.addObject("ArticulatedSystemMapping", input1=arm.dofs.getLinkPath(), output=r.dofs.getLinkPath())

    class Turn(Sofa.Core.Controller):
        def onAnimateBeginEvent(self, e):
            first, second = (each[0] for each in arm.dofs.rest_position.value)
            arm.dofs.rest_position.value = [[min(first + radians(2), 1)], [second - radians(1)]]
    root.addObject(Turn())
