# SPDX-License-Identifier: LGPL-2.1-or-later
"""A body of which both ends are rigid: the body follows free nodes and nodes of two frames."""
from splib3.objectmodel import SofaObject, SofaPrefab, setData
from splib3.numerics import RigidDof
from stlib3.physics.deformable import ElasticMaterialObject
from stlib3.physics.mixedmaterial import Rigidify
from stlib3.scene import MainHeader
import Sofa


@SofaPrefab
class Arm(SofaObject):
    """Moves one of the frames."""

    def __init__(self, parent, dofs):
        SofaObject.__init__(self, parent, "arm")
        self.handle = RigidDof(dofs)


class Move(Sofa.Core.Controller):
    def __init__(self, arm):
        Sofa.Core.Controller.__init__(self)
        self.arm = arm

    def onAnimateBeginEvent(self, _):
        place = self.arm.handle.getPosition(1)
        self.arm.handle.setPosition(place + [0.1, 0, 0], 1)


def createScene(rootNode):
    MainHeader(rootNode, plugins=["SofaSparseSolver"], gravity=[0, 0, 0])
    rootNode.addObject("FreeMotionAnimationLoop")
    rootNode.addObject("GenericConstraintSolver")
    modelling = rootNode.addChild("Modelling")
    body = ElasticMaterialObject(volumeMeshFileName="mesh/finger.vtk", name="body", youngModulus=1000, totalMass=0.1)
    modelling.addChild(body)
    positions = body.container.position.value
    ends = [[i for i, p in enumerate(positions) if p[0] < 1], [i for i, p in enumerate(positions) if p[0] > 79]]
    o = Rigidify(modelling, body, name="RigidifiedStructure", groupIndices=ends, frames=[[0., 0., 0., 1.], [0., 0., 0., 1.]])
    setData(o.RigidParts.dofs, showObject=True, showObjectScale=1, drawMode=2)
    o.RigidParts.addObject("FixedConstraint", indices=0)
    simulation = rootNode.addChild("Simulation")
    simulation.addObject("EulerImplicitSolver", rayleighStiffness=0.1)
    simulation.addObject("SparseLDLSolver", template="CompressedRowSparseMatrixd")
    simulation.addChild(o)
    rootNode.addObject(Move(Arm(rootNode, o.RigidParts.dofs)))
    return rootNode
