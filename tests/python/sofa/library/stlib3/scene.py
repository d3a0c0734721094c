# SPDX-License-Identifier: LGPL-2.1-or-later
"""Headers of scenes."""
import Sofa
from splib3.animation import AnimationManager


class Scene:
    """Wraps the root: what it does not have itself is asked of the node."""

    def __init__(self, node, gravity=(0.0, -9.81, 0.0), dt=0.01, plugins=()):
        self.node = node
        node.gravity = list(gravity)
        node.dt = dt
        node.addObject("RequiredPlugin", pluginName=list(plugins))
        node.addChild("Settings")
        node.addChild("Modelling")
        self.Simulation = node.addChild("Simulation")
        self.Simulation.addObject("EulerImplicitSolver", name="TimeIntegrationSchema")
        self.Simulation.addObject("CGLinearSolver", name="LinearSolver", iterations=50, tolerance=1e-14, threshold=1e-14)

    def addMainHeader(self):
        self.node.addObject("VisualStyle")
        self.node.addObject("DefaultAnimationLoop")

    def __getattr__(self, name):
        return getattr(self.node, name)


def MainHeader(node, gravity=[0.0, -9.8, 0.0], dt=0.01, plugins=[], repositoryPaths=[], doDebug=False):
    node.addObject("VisualStyle")
    node.findData("gravity").value = gravity
    node.findData("dt").value = dt
    node.addObject("DefaultVisualManagerLoop")
    if not isinstance(plugins, list):
        Sofa.msg_error("MainHeader", "'plugins' is a list, not " + str(type(plugins)))
        return node
    config = node.addChild("Config")
    for name in plugins:
        config.addObject("RequiredPlugin", name=name, printLog=False)
    for number, repository in enumerate(repositoryPaths):
        config.addObject("AddDataRepository", name="AddDataRepository" + str(number), path=repository)
    config.addObject("OglSceneFrame", style="Arrows", alignment="TopRight")
    AnimationManager(node)
    return node


def ContactHeader(applyTo, alarmDistance, contactDistance, frictionCoef=0.0):
    if applyTo.hasObject("CollisionPipeline") is False:
        applyTo.addObject("CollisionPipeline")
    applyTo.addObject("BruteForceBroadPhase")
    applyTo.addObject("BVHNarrowPhase")
    applyTo.addObject("RuleBasedContactManager", responseParams="mu=" + str(frictionCoef), name="Response",
                      response="FrictionContactConstraint")
    applyTo.addObject("LocalMinDistance", alarmDistance=alarmDistance, contactDistance=contactDistance, angleCone=0.01)
    if applyTo.hasObject("FreeMotionAnimationLoop") is False:
        applyTo.addObject("FreeMotionAnimationLoop")
    if applyTo.hasObject("GenericConstraintSolver") is False:
        applyTo.addObject("GenericConstraintSolver", tolerance=1e-6, maxIterations=1000)
    return applyTo


class Interaction:
    def __init__(self, parent, targets):
        self.node = parent.addChild("Interaction")
        self.node.addObject("EulerImplicitSolver")
        self.node.addObject("CGLinearSolver", iterations=25, tolerance=1e-5, threshold=1e-5)
        for target in targets:
            self.node.addChild(target)
