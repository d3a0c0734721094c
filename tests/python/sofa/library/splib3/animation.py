# SPDX-License-Identifier: LGPL-2.1-or-later
"""animate(onUpdate, params, duration): called in each step."""
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
        for update, params, duration in list(self.animations):
            factor = min(self.totalTime / duration, 1.0)
            update(factor=factor, **params)
            if factor >= 1.0:
                self.animations.remove((update, params, duration))


def AnimationManager(root):
    _manager[:] = [AnimationManagerController(root)]
    root.addObject(_manager[0])
    return _manager[0]


def animate(onUpdate, params, duration):
    _manager[0].animations.append((onUpdate, params, duration))
