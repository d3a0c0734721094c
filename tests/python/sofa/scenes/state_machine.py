# SPDX-License-Identifier: LGPL-2.1-or-later
"""A controller with states, whose handlers check what the events say; handlers of events that do not come here."""
from enum import Enum

import Sofa


class S(Enum):
    GO = 1
    STOP = 2


class Machine(Sofa.Core.Controller):
    def __init__(self, root, *a, **k):
        super().__init__(*a, **k)
        self.root, self.state, self.count, self.started = root, S.GO, 0, False
        self.root.n.mo.showObject = True

    def onSimulationInitDoneEvent(self, e):
        self.started = True

    def onAnimateBeginEvent(self, e):
        assert self.started and e["type"] == "AnimateBeginEvent"
        self.count += 1
        if self.count == 5:
            self.state = S.STOP
        self.root.n.f.forces.value = [[1 if self.state is S.GO else 0, 0, 0]]

    def onKeypressedEvent(self, e):
        pass

    def onMouseEvent(self, e):
        pass

    def onScriptEvent(self, e):
        pass


def createScene(root):
    root.gravity = [0, 0, 0]
    root.addObject("DefaultAnimationLoop")
    n = root.addChild("n")
    n.addObject("EulerExplicitSolver")
    n.addObject("MechanicalObject", name="mo", position=[0, 0, 0])
    n.addObject("UniformMass", totalMass=1)
    n.addObject("ConstantForceField", name="f", indices=0, forces=[[0, 0, 0]])
    root.addObject(Machine(root, name="m"))
