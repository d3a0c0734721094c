# SPDX-License-Identifier: LGPL-2.1-or-later
"""A program of its own: a root that is made, initialised, stepped, and shown where there is a display."""
import sys

import Sofa
import Sofa.Core
import Sofa.Gui
import Sofa.Simulation
import SofaRuntime

USE_GUI = "gui" in sys.argv


def main():
    SofaRuntime.importPlugin("SofaComponentAll")
    root = Sofa.Core.Node("root")
    createScene(root)
    Sofa.Simulation.init(root)
    if not USE_GUI:
        for _ in range(10):
            Sofa.Simulation.animate(root, root.dt.value)
        print("height", root.body.dofs.position.value[0][2])
        Sofa.Simulation.reset(root)
        print("start", root.body.dofs.position.value[0][2], root.time.value)
    else:
        Sofa.Gui.GUIManager.Init("scene", "qglviewer")
        Sofa.Gui.GUIManager.createGUI(root, __file__)
        Sofa.Gui.GUIManager.SetDimension(1080, 1080)
        Sofa.Gui.GUIManager.MainLoop(root)
        Sofa.Gui.GUIManager.closeGUI()
        print("closed")


def createScene(root):
    root.gravity = [0, 0, -10]
    root.dt = 0.1
    root.addObject("DefaultAnimationLoop")
    body = root.addChild("body")
    body.addObject("EulerImplicitSolver")
    body.addObject("CGLinearSolver", iterations=10, tolerance=1e-14, threshold=1e-14)
    body.addObject("MechanicalObject", name="dofs", position=[0, 0, 5])
    body.addObject("UniformMass", totalMass=1)
    return root


if __name__ == "__main__":
    main()
