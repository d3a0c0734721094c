# SPDX-License-Identifier: LGPL-2.1-or-later
"""Functions of a factor from 0 to 1 over a time: animate(onUpdate, params, duration, mode, onDone)."""
import Sofa
import Sofa.Core
from Sofa import _libraries, _messages

_libraries.same_module(__name__, "animate")
manager = None


class Animation:
    """onUpdate(factor=..., **params) in each step of `duration` s; then onDone(), or anew ("loop"), or back ("pingpong")."""

    def __init__(self, duration, mode, onUpdate=None, params=None, onDone=None, cb=None):
        self.duration, self.mode = duration, mode
        self.onUpdate = onUpdate if onUpdate is not None else cb
        self.params, self.onDone = params or {}, onDone
        self.startTime = self.params.get("startTime")
        self.factor, self.direction = 1.0, 1.0

    def doOnDone(self, currentTime):
        self.onDone(factor=self.factor, **self.params)

    def update(self, currentTime):
        if self.startTime is None:
            self.startTime = currentTime
        passed = (currentTime - self.startTime) / self.duration if self.duration else 1.0
        if self.duration and self.direction < 0:
            passed = 1.0 - passed
        self.factor = min(max(passed, 0.0), 1.0)
        self.onUpdate(factor=self.factor, **self.params)

    def goesOn(self):
        """After an update: whether there is a step to come."""
        if (self.factor < 1.0 and self.direction > 0) or (self.factor > 0.0 and self.direction < 0):
            return True
        if self.mode not in ("loop", "pingpong"):
            return False
        if self.mode == "pingpong":
            self.direction = -self.direction
        self.startTime = None
        return True


class AnimationManagerController(Sofa.Core.Controller):
    """Its time is that of steps that have begun: dt in the first."""

    def __init__(self, *args, **kwargs):
        Sofa.Core.Controller.__init__(self, *args, **kwargs)
        self.listening = True
        self.name = "AnimationManager"
        self.node = args[0]
        self.totalTime, self.animations = 0.0, []
        self.placed_here = None  # until an animation runs, when it was put in the node by AnimationManager()

    def addAnimation(self, animation):
        self.animations.append(animation)

    def removeAnimation(self, animation):
        """Also from a callback: one that has ended, or is taken out twice, is gone all the same."""
        if animation in self.animations:
            self.animations.remove(animation)

    def clearAnimations(self):
        self.animations = []

    def onAnimateBeginEvent(self, event):
        self.totalTime += self.node.getRoot().dt.value
        if self.animations and self.placed_here is not None:
            if self.placed_here == self._s_order:  # the scene has not added it again
                _messages.note("animations run, though the scene adds their manager to no node: in SOFA's Python 3 they never would, "
                               "without addObject(AnimationManager(root))")
            self.placed_here = None
        tried = {}  # what a callback starts has its first factor in the same step; none has two of them
        while (each := next((one for one in self.animations if id(one) not in tried), None)) is not None:
            tried[id(each)] = each
            each.update(self.totalTime)
            if each in self.animations and not each.goesOn():
                self.animations.remove(each)
                if each.onDone is not None:
                    each.doOnDone(self.totalTime)


def AnimationManager(node):
    """The one of the scene, whose animations end when it is asked for again. It is in the node at once, as in Python 2: in SOFA's
    Python 3 one that no scene adds by addObject(AnimationManager(root)) is never called."""
    global manager
    if manager is not None and manager.node is node:
        manager.clearAnimations()
        return manager
    manager = AnimationManagerController(node)
    node.addObject(manager)
    manager.placed_here = manager._s_order
    return manager


def _managed():
    if manager is None:
        raise Exception("there is no AnimationManager in this scene: AnimationManager(rootNode) makes it")
    return manager


def animate(onUpdate=None, params=None, duration=1.0, mode="once", onDone=None, cb=None):
    _managed().addAnimation(Animation(duration, mode, onUpdate, params, onDone, cb))


def removeAnimation(animation):
    _managed().removeAnimation(animation)
