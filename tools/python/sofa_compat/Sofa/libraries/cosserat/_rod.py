# SPDX-License-Identifier: LGPL-2.1-or-later
"""What both prefabs of rods share."""
import Sofa
from useful.utils import addEdgeCollision, addPointsCollision, addSlidingPoints


class Rod(Sofa.Prefab):
    """rigidBaseNode: the frame of its foot. cosseratCoordinateNode: strains of its sections, with their elasticity. cosseratFrame: the
    frames along it, which follow both."""

    def init(self):
        """All is made when it is constructed, of what is given then."""

    def _find_solver(self, add):
        parent = self.parent
        if parent is None:
            raise ValueError(f"{type(self).__name__} needs parent=, the node of its solvers or the one that gets them")
        self.solverNode = parent if parent.hasObject("EulerImplicitSolver") else add(parent)

    def _add_foot(self, places, moved, shown, is_held):
        node = self.addChild("rigidBase")
        node.addObject("MechanicalObject", template="Rigid3d", name="RigidBaseMO", position=places, showObject=shown, **moved)
        if is_held:
            node.addObject("RestShapeSpringsForceField", name="spring", stiffness=1e8, angularStiffness=1e8, external_points=0,
                           mstate="@RigidBaseMO", points=0, template="Rigid3d")
        return node

    def _add_strains(self, bendings, elasticity):
        node = self.addChild("cosseratCoordinate")
        node.addObject("MechanicalObject", template="Vec3d", name="cosseratCoordinateMO", position=bendings)
        node.addObject("BeamHookeLawForceField", **elasticity)
        return node

    def _add_frames(self, frames, ends, along, mass, shown):
        node = self.rigidBaseNode.addChild("cosseratInSofaFrameNode")
        self.cosseratCoordinateNode.addChild(node)
        state = node.addObject("MechanicalObject", template="Rigid3d", name="FramesMO", position=frames, showObject=shown)
        if mass:
            node.addObject("UniformMass", totalMass=mass)
        node.addObject("DiscreteCosseratMapping", name="cosseratMapping", curv_abs_input=ends, curv_abs_output=along,
                       input1=self.cosseratCoordinateNode.cosseratCoordinateMO.getLinkPath(),
                       input2=self.rigidBaseNode.RigidBaseMO.getLinkPath(), output=state.getLinkPath(), debug=0, radius=self.radius)
        return node

    def _edges(self):
        return [[i, i + 1] for i in range(len(self.frames3D) - 1)]

    def addCollisionModel(self):
        return addEdgeCollision(self.cosseratFrame, self.frames3D, self._edges())

    def addPointCollisionModel(self, nodeName="CollisionPoints"):
        return addPointsCollision(self.cosseratFrame, self.frames3D, self._edges(), nodeName)

    def addSlidingPoints(self):
        return addSlidingPoints(self.cosseratFrame, self.frames3D)

    def addSlidingPointsWithContainer(self):
        node = self.cosseratFrame.addChild("slidingPoint")
        node.addObject("PointSetTopologyContainer")
        node.addObject("PointSetTopologyModifier")
        node.addObject("MechanicalObject", name="slidingPointMO", position=self.frames3D)
        node.addObject("IdentityMapping")
        return node

    _addPointCollisionModel, _addSlidingPoints, _addSlidingPointsWithContainer = (
        addPointCollisionModel, addSlidingPoints, addSlidingPointsWithContainer)
