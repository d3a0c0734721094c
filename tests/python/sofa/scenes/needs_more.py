# SPDX-License-Identifier: LGPL-2.1-or-later
"""Modules that are not there, beside components that are not: one message."""
import gym_of_nobody
import numpy as np
import Sofa
from sofa_of_nobody.toolbox import Gripper


def createScene(root):
    root.addObject("FluidGridOfNobody", name="fluid")
    Gripper(root, np.zeros(3))
    gym_of_nobody.make(root)
    root.addObject("ShellOfNobody")
