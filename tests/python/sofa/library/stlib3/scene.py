# SPDX-License-Identifier: LGPL-2.1-or-later
"""A header of scenes."""


class Scene:
    """Wraps the root: what it does not have itself is asked of the node."""

    def __init__(self, node, gravity=(0.0, -9.81, 0.0), dt=0.01, plugins=()):
        self.node = node
        node.gravity = list(gravity)
        node.dt = dt
        node.addObject("RequiredPlugin", pluginName=list(plugins))
        node.addChild("Settings")
        node.addChild("Modelling")
        self.Simulation = node.addChild("Simulation")
        self.Simulation.addObject("EulerImplicitSolver", name="TimeIntegrationSchema")
        self.Simulation.addObject("CGLinearSolver", name="LinearSolver", iterations=50, tolerance=1e-14, threshold=1e-14)

    def addMainHeader(self):
        self.node.addObject("VisualStyle")
        self.node.addObject("DefaultAnimationLoop")

    def __getattr__(self, name):
        return getattr(self.node, name)
