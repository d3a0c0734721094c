# SPDX-License-Identifier: LGPL-2.1-or-later
"""An elastic body around a mesh."""


def ElasticMaterialObject(attachedTo, name="ElasticMaterialObject", n=(2, 2, 2), low=(0, 0, 0), high=(1, 1, 1), totalMass=1.0, youngModulus=1e3,
                          poissonRatio=0.3):
    body = attachedTo.addChild(name) if attachedTo is not None else None
    body.addObject("RegularGridTopology", name="loader", n=list(n), min=list(low), max=list(high))
    body.addObject("HexahedronSetTopologyContainer", src=body.loader.getLinkPath(), name="container")
    body.addObject("MechanicalObject", template="Vec3", name="dofs", showObject=False, showObjectScale=5.0)
    body.addObject("UniformMass", totalMass=totalMass, name="mass")
    body.addObject("HexahedronFEMForceField", template="Vec3", method="large", name="forcefield", poissonRatio=poissonRatio,
                   youngModulus=youngModulus)
    return body
