# SPDX-License-Identifier: LGPL-2.1-or-later
"""Names: given, of the type, the second of a type, a name twice, names as words; paths by attribute and by index."""


def createScene(root):
    root.addObject("DefaultAnimationLoop")
    root.gravity = [0, 0, 0]
    body = root.addChild("body")
    body.addObject("EulerImplicitSolver")
    body.addObject("CGLinearSolver", iterations=20, tolerance=1e-9, threshold=1e-9)
    body.addObject("MechanicalObject", position=[[0, 0, 0], [1, 0, 0]])
    body.addObject("UniformMass", totalMass=1)
    first = body.addObject("ConstantForceField", indices=[0], forces=[1, 0, 0])
    second = body.addObject("ConstantForceField", indices=[1], forces=[0, 1, 0])
    third = body.addObject("ConstantForceField", name="same", indices=[0], forces=[0, 0, 1])
    fourth = body.addObject("ConstantForceField", name="same", indices=[1], forces=[0, 0, 1])
    assert (first.getName(), second.getName()) == ("ConstantForceField", "ConstantForceField1")
    assert body.same is third and fourth in list(body.objects)
    assert body.MechanicalObject.position.getLinkPath() == "@/body/MechanicalObject.position"
    assert root["body.ConstantForceField1.indices"].value.tolist() == [1]
    assert body.objects[2].name.value == "MechanicalObject" and len(body.objects) == 8
    assert root.getChild("body").getObject("UniformMass").getClassName() == "UniformMass"
    assert body.getMechanicalState() is body.MechanicalObject and body.getForceField(0) is first
    assert first.getContext() is body and first.getRoot() is root and body.parents[0] is root
    assert first.name == "ConstantForceField" and f"{first.name}" == "ConstantForceField"
