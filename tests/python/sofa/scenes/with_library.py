# SPDX-License-Identifier: LGPL-2.1-or-later
"""Plain Python upon the same calls, as SOFA's plugins have it: a scene's header, a body, an animation."""
from splib3.animation import AnimationManager, animate
from stlib3.physics.deformable import ElasticBlock
from stlib3.scene import Scene


def pull(load, factor):
    load.totalForce = [8 * factor, 0, 0]


def createScene(rootNode):
    scene = Scene(rootNode, gravity=[0.0, 0.0, 0.0], dt=0.1, plugins=["Sofa.Component.SolidMechanics.FEM.Elastic"])
    scene.addMainHeader()
    scene.VisualStyle.displayFlags = "showBehavior"
    AnimationManager(rootNode)
    body = ElasticBlock(scene.Simulation, name="body", totalMass=4.0)
    load = body.addObject("ConstantForceField", name="load", indices=list(range(8)), totalForce=[0, 0, 0])
    scene.Simulation.TimeIntegrationSchema.rayleighStiffness = 0
    animate(pull, {"load": load}, duration=0.4)
