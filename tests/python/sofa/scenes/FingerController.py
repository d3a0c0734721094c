# SPDX-License-Identifier: LGPL-2.1-or-later
"""Keys pull and release a cable."""
import Sofa.Core
from Sofa.constants import Key


class FingerController(Sofa.Core.Controller):
    def __init__(self, *a, **kw):
        Sofa.Core.Controller.__init__(self, *a, **kw)
        self.node = kw["node"]

    def onKeypressedEvent(self, e):
        inputvalue = self.node.aCableActuator.value
        displacement = inputvalue.value[0]
        if e["key"] == Key.plus:
            displacement += 1.
        elif e["key"] == Key.minus:
            displacement -= 1.
            if displacement < 0:
                displacement = 0
        inputvalue.value = [displacement]
