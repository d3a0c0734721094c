# SPDX-License-Identifier: LGPL-2.1-or-later
"""Plain Python upon the same calls, as SOFA's plugins have it: a scene's header, a body, an animation."""
from splib3.animation import animate
from stlib3.scene import Scene


def elastic_block(attachedTo, name):
    body = attachedTo.addChild(name)
    body.addObject("RegularGridTopology", name="loader", n=[2, 2, 2], min=[0, 0, 0], max=[1, 1, 1])
    body.addObject("HexahedronSetTopologyContainer", src=body.loader.getLinkPath(), name="container")
    body.addObject("MechanicalObject", template="Vec3", name="dofs", showObject=False, showObjectScale=5.0)
    body.addObject("UniformMass", totalMass=4.0, name="mass")
    body.addObject("HexahedronFEMForceField", template="Vec3", method="large", name="forcefield", poissonRatio=0.3, youngModulus=1e3)
    return body


def pull(load, factor):
    load.totalForce = [8 * factor, 0, 0]


def createScene(rootNode):
    scene = Scene(rootNode, gravity=[0.0, 0.0, 0.0], dt=0.1, plugins=["Sofa.Component.SolidMechanics.FEM.Elastic"])
    scene.addMainHeader()
    scene.VisualStyle.displayFlags = "showBehavior"
    body = elastic_block(scene.Simulation, name="body")
    load = body.addObject("ConstantForceField", name="load", indices=list(range(8)), totalForce=[0, 0, 0])
    scene.Simulation.LinearSolver.tolerance = 1e-14
    scene.Simulation.LinearSolver.threshold = 1e-14
    scene.Simulation.TimeIntegrationSchema.rayleighStiffness = 0
    animate(pull, {"load": load}, duration=0.4)
