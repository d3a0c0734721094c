# SPDX-License-Identifier: LGPL-2.1-or-later
"""Time from all its places; results in a file that is written when Python ends; numbers formatted in many ways."""
import atexit
import json
import os
import tempfile
from datetime import datetime

import Sofa

result = {"start": datetime.now().isoformat(), "t": [], "u": []}
folder = tempfile.TemporaryDirectory()  # goes at the end, after save()
out = os.path.join(folder.name, "result.json")


@atexit.register
def save():
    with open(out, "w") as file:
        json.dump(result, file, indent=1)


class Log(Sofa.Core.Controller):
    def onAnimateEndEvent(self, event):
        root = self.getContext().getRootContext()
        t = root.getTime()
        assert t == root.time.value == self.getContext().findData("time").value == root.findData("time").value
        assert abs(event["dt"] - root.dt.value) < 1e-15 and root.getDt() == root.dt.value
        u = root.n.mo.position.value[0] - root.n.mo.rest_position.value[0]
        result["t"].append(round(t, 6))
        result["u"].append(u.tolist())
        print("t={:.2f} u=({:.3e}, {:.3e}, {:.3e}) {}".format(t, *u, "%.2f" % root.dt.value), f"{root.time.value:>8.3f}|{root.dt}")


def createScene(root):
    root.dt.value = 0.05
    root.animate = False
    root.addObject("DefaultAnimationLoop")
    n = root.addChild("n")
    n.addObject("EulerImplicitSolver")
    n.addObject("CGLinearSolver", iterations=10, tolerance=1e-9, threshold=1e-9)
    n.addObject("MechanicalObject", name="mo", position=[0, 0, 0])
    n.addObject("UniformMass", totalMass=1)
    root.addObject(Log(name="log", listening=True))
