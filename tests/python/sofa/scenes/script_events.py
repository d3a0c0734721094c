# SPDX-License-Identifier: LGPL-2.1-or-later
"""Controllers that talk by events of their own, and one that reacts to any event by its type; a state machine."""
import enum

import Sofa


class State(enum.Enum):
    APPROACH = 0
    GRASP = 1
    LIFT = 2


class Machine(Sofa.Core.Controller):
    state = State.APPROACH

    def onAnimateEndEvent(self, event):
        order = list(State)
        step = order.index(self.state)
        if step + 1 < len(order):
            self.state = order[step + 1]
            self.sendEvent({"state": self.state.name}, "changed")


class Ear(Sofa.Core.Controller):
    def __init__(self, *a, **k):
        Sofa.Core.Controller.__init__(self, *a, **k)
        self.heard, self.types = [], set()

    def onPythonScriptEvent(self, event):
        self.heard.append((event["sender"].getName(), event["event_name"], event["userData"]["state"]))

    def onEvent(self, event):
        self.types.add(event["type"])

    def onAnimateEndEvent(self, event):
        if self.getContext().time.value > 0.05:
            assert self.heard == [("machine", "changed", "GRASP"), ("machine", "changed", "LIFT")], self.heard


def createScene(root):
    root.addObject("DefaultAnimationLoop")
    root.addObject(Machine(name="machine"))
    root.addObject(Ear(name="ear"))
    n = root.addChild("n")
    n.addObject("EulerExplicitSolver", symplectic=True)
    n.addObject("MechanicalObject", position=[0, 0, 0])
    n.addObject("UniformMass", totalMass=1)
