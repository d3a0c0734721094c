# SPDX-License-Identifier: LGPL-2.1-or-later
"""Headers of scenes."""
import Sofa
import Sofa.Core
from Sofa import _libraries
from splib3.animation import AnimationManager

_libraries.same_module(__name__, "mainheader", "contactheader", "interaction", "scene", "wrapper")


def Node(parentNode, name):
    return parentNode.addChild(name)


def _settings(node, plugins, repositoryPaths, kind):
    for name in plugins:
        node.addObject("RequiredPlugin", name=name, printLog=False)
    for number, path in enumerate(repositoryPaths):
        node.addObject(kind, name=f"{kind}{number}", path=path)
    node.addObject("OglSceneFrame", style="Arrows", alignment="TopRight")


def _is_list(plugins):
    if not isinstance(plugins, list):
        Sofa.msg_error("MainHeader", f"'plugins' is a list, not {type(plugins)}")
    return isinstance(plugins, list)


def MainHeader(node, gravity=[0.0, -9.8, 0.0], dt=0.01, plugins=[], repositoryPaths=[], doDebug=False):
    """Gravity, time step, a manager of animations, and settings in a node Config."""
    node.addObject("VisualStyle")
    node.findData("gravity").value = gravity
    node.findData("dt").value = dt
    node.addObject("DefaultVisualManagerLoop")
    if _is_list(plugins):
        _settings(node.addChild("Config"), plugins, repositoryPaths, "AddDataRepository")
        AnimationManager(node)
    return node


def ContactHeader(applyTo, alarmDistance, contactDistance, frictionCoef=0.0):
    """Contact with friction, and the loop and the solver of constraints where there is none."""
    def missing(*names):
        return not any(applyTo.hasObject(name) for name in names)

    if missing("CollisionPipeline"):
        applyTo.addObject("CollisionPipeline")
    applyTo.addObject("BruteForceBroadPhase")
    applyTo.addObject("BVHNarrowPhase")
    applyTo.addObject("RuleBasedContactManager", name="Response", response="FrictionContactConstraint", responseParams=f"mu={frictionCoef}")
    applyTo.addObject("LocalMinDistance", alarmDistance=alarmDistance, contactDistance=contactDistance, angleCone=0.01)
    if missing("FreeMotionAnimationLoop"):
        applyTo.addObject("FreeMotionAnimationLoop")
    if missing("GenericConstraintSolver", "ProjectedGaussSeidelConstraintSolver"):
        applyTo.addObject("GenericConstraintSolver", tolerance=1e-6, maxIterations=1000)
    return applyTo


def Settings(plugins=[], repositoryPaths=[]):
    node = Sofa.Core.Node("Settings")
    _settings(node, plugins if _is_list(plugins) else [], repositoryPaths, "AddResourceRepository")
    node.addObject("AttachBodyButtonSetting", name="mouseButton")
    return node


def Scene(root, gravity=[0.0, -9.81, 0.0], dt=0.01, plugins=[], repositoryPaths=[], iterative=True):
    """The root with functions addMainHeader(), addSettings(), addModelling(), addSimulation(), addSolver(node), addContact()."""
    def addSolver(node):
        node.addObject("EulerImplicitSolver", name="TimeIntegrationSchema")
        node.addObject("CGLinearSolver" if iterative else "SparseLDLSolver", name="LinearSolver")
        return node

    def addSettings(plugins=plugins, repositoryPaths=repositoryPaths):
        root.addChild(Settings(plugins, repositoryPaths))
        return root

    def addModelling():
        root.addChild("Modelling")
        return root

    def addSimulation():
        addSolver(root.addChild("Simulation"))
        return root

    def addMainHeader(plugins=plugins, repositoryPaths=repositoryPaths, doDebug=False):
        root.addObject(AnimationManager(root))
        addSettings(plugins, repositoryPaths)
        addModelling()
        addSimulation()

    def addContact(alarmDistance=1.0, contactDistance=0.1, frictionCoef=1.0):
        return ContactHeader(root, alarmDistance, contactDistance, frictionCoef)

    root.gravity.value = gravity
    root.dt.value = dt
    root.addObject("VisualStyle")
    for each in (addSolver, addSettings, addModelling, addSimulation, addMainHeader, addContact):
        setattr(root, each.__name__, each)
    return root


class Interaction:
    """Bodies that bring no solver, under one."""

    def __init__(self, parent, targets):
        self.node = parent.addChild("Interaction")
        self.node.addObject("EulerImplicitSolver")
        self.node.addObject("CGLinearSolver", iterations=25, tolerance=1e-5, threshold=1e-5)
        for target in targets:
            self.node.addChild(target)

    def __getattr__(self, name):
        return getattr(self.node, name)


class Wrapper:
    """A node whose addObject() asks attachedFunction(node, type, datacache, arguments) first: another (type, arguments), or None."""

    def __init__(self, node, attachedFunction, datacache):
        self.node, self.attachedFunction, self.datacache = node, attachedFunction, datacache

    def addObject(self, type, **kwargs):
        other = self.attachedFunction(self.node, type, self.datacache, kwargs)
        return self.node.addObject(type, **kwargs) if other is None else self.node.addObject(other[0], **other[1])

    def addChild(self, name):
        return Wrapper(self.node.addChild(name), self.attachedFunction, self.datacache)

    createObject, createChild = addObject, addChild

    def __getattr__(self, name):
        return getattr(self.node, name)
