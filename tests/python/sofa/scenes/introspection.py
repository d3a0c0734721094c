# SPDX-License-Identifier: LGPL-2.1-or-later
"""What editors and students do: print everything of everything, look for names, ask factories and classes."""
import inspect

import Sofa
import Sofa.Core


def tree(node, depth=0):
    print("  " * depth + node.name.value, node.getPathName(), node.getLinkPath())
    for obj in node.objects:
        print("  " * (depth + 1) + obj.getClassName() + " " + obj.getName(), obj.getTemplateName(), obj.getHelp(), obj.getCategories())
        for data in obj.getDataFields():
            found = obj.findData(data) if isinstance(data, str) else data
            (found.getName(), found.getHelp(), found.getValueTypeString(), found.isSet(), found.isPersistent(), str(found.value)[:20],
             repr(found), found.getOwner() is obj, found.getGroup(), found.typeName())
        for link in obj.getLinks():
            print(link)
        for name in dir(obj):
            getattr(obj, name, None)
    for child in node.children:
        tree(child, depth + 1)
    for name in dir(node):
        getattr(node, name, None)


class Nothing(Sofa.Core.Controller):
    """Help of nothing"""


def createScene(root):
    root.addObject("DefaultAnimationLoop")
    n = root.addChild("n")
    n.addObject("EulerImplicitSolver")
    n.addObject("CGLinearSolver", iterations=10, tolerance=1e-9, threshold=1e-9)
    n.addObject("RegularGridTopology", n=[2, 2, 2], min=[0, 0, 0], max=[1, 1, 1])
    n.addObject("MechanicalObject")
    n.addObject("UniformMass", totalMass=1)
    n.addObject("HexahedronFEMForceField", youngModulus=1e3, poissonRatio=0.3)
    root.addObject(Nothing(name="nothing"))
    tree(root)
    assert inspect.isclass(Sofa.Core.Controller) and inspect.getdoc(Nothing) == "Help of nothing"
    names = [each.className for each in Sofa.Core.ObjectFactory.components]
    assert "MechanicalObject" in names and Sofa.Core.ObjectFactory.getComponent("NothingOfAll") is None
    assert root.findData("gravity") is not None and root.findData("nothing") is None and root.getObject("nothing") is not None
    assert "position" in n.MechanicalObject.__data__ and n.getObject("MechanicalObject") == n.MechanicalObject
    assert n.MechanicalObject in list(n.objects) and n != root and {n: 1}[n] == 1
