# SPDX-License-Identifier: LGPL-2.1-or-later
"""A controller with a method for every event there is."""
import Sofa
import Sofa.Core


class EmptyController(Sofa.Core.Controller):
    def __init__(self, *args, **kwargs):
        Sofa.Core.Controller.__init__(self, *args, **kwargs)
        self.calls = []

    def onEvent(self, event):
        self.calls.append("other " + event["type"])

    def onAnimateBeginEvent(self, event):
        self.calls.append("begin")
        assert event["dt"] == self.getContext().getRoot().dt.value

    def onAnimateEndEvent(self, event):
        self.calls.append("end")

    def onIntegrateBeginEvent(self, event):
        self.calls.append("integrate")

    def onCollisionEndEvent(self, event):
        self.calls.append("collided")

    def onKeypressedEvent(self, event):
        print("pressed", event["key"])

    def onKeyreleasedEvent(self, event):
        print("released", event["key"])

    def onMouseEvent(self, event):
        print("mouse", event)

    def onScriptEvent(self, event):
        print("script", event)

    def onHapticDeviceEvent(self, event):
        print("felt")


def createScene(root):
    root.dt = 0.01
    root.addObject('DefaultVisualManagerLoop')
    root.addObject('DefaultAnimationLoop')
    root.addObject(EmptyController(name="MyEmptyController"))
