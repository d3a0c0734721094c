# SPDX-License-Identifier: LGPL-2.1-or-later
"""A rest shape outside, moved along a spline of SciPy; a body that is pulled after it by stiff springs."""
import numpy as np
import Sofa
from scipy.interpolate import CubicSpline


class Follow(Sofa.Core.Controller):
    def __init__(self, *args, **kwargs):
        Sofa.Core.Controller.__init__(self, *args, **kwargs)
        self.rest, self.root = kwargs["rest"], kwargs["root"]
        t = np.linspace(0, 1, 5)
        self.s = CubicSpline(t, np.c_[np.sin(t), np.cos(t) - 1, 0 * t])

    def onAnimateBeginEvent(self, e):
        self.rest.position.value = self.s(self.root.time.value)[None, :]


def createScene(root):
    root.gravity = [0, 0, 0]
    root.addObject("DefaultAnimationLoop")
    target = root.addChild("target")
    mo = target.addObject("MechanicalObject", name="t", position=[[0, 0, 0]])
    n = root.addChild("n")
    n.addObject("EulerImplicitSolver", rayleighMass=1)
    n.addObject("CGLinearSolver", iterations=10, tolerance=1e-12, threshold=1e-20)
    n.addObject("MechanicalObject", name="mo", position=[[0, 0, 0]])
    n.addObject("UniformMass", totalMass=.01)
    n.addObject("RestShapeSpringsForceField", stiffness=1e4, external_rest_shape="@../target/t", points=[0], external_points=[0])
    root.addObject(Follow(name="f", rest=mo, root=root))
