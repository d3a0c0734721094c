# SPDX-License-Identifier: LGPL-2.1-or-later
"""animate(onUpdate, params, duration): called in each step with a factor that grows from 0 to 1."""
import Sofa

_manager = []


class AnimationManagerController(Sofa.Core.Controller):
    def __init__(self, root):
        Sofa.Core.Controller.__init__(self)
        self.listening.value = True
        self.name = "AnimationManager"
        self.root, self.animations, self.totalTime = root, [], 0.0

    def onAnimateBeginEvent(self, event):
        self.totalTime += event["dt"]
        for each in list(self.animations):
            update, params, duration, mode, onDone, start = each
            factor = min((self.totalTime - start) / duration, 1.0)
            update(factor=factor, **params)
            if factor >= 1.0 and mode == "loop":
                each[-1] = self.totalTime
            elif factor >= 1.0:
                self.animations.remove(each)
                if onDone is not None:
                    onDone(factor=factor, **params)


def AnimationManager(root):
    _manager[:] = [AnimationManagerController(root)]
    root.addObject(_manager[0])
    return _manager[0]


def animate(onUpdate, params, duration, mode="once", onDone=None):
    _manager[0].animations.append([onUpdate, params, duration, mode, onDone, 0.0])
