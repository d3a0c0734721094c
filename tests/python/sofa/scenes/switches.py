# SPDX-License-Identifier: LGPL-2.1-or-later
"""A part of the tree is switched off, with controllers in it, and objects are looked for by all ways."""
import Sofa


class Heard(Sofa.Core.Controller):
    def __init__(self, *a, **k):
        Sofa.Core.Controller.__init__(self, *a, **k)
        self.count = 0

    def onAnimateBeginEvent(self, event):
        self.count += 1


def createScene(root):
    root.addObject("DefaultAnimationLoop")
    off = root.addChild("off")
    off.activated = False
    below = off.addChild("below")
    root.never = below.addObject(Heard(name="never"))
    root.always = root.addObject(Heard(name="always"))
    on = root.addChild("on", activated=True)
    on.addObject("MechanicalObject", name="dofs", position=[0, 0, 0])
    assert root.getChild("on").getObject("dofs") is root.on.dofs is root["on.dofs"] is on.objects["dofs"] is on.objects[0]
    assert root.getChild("on").getMechanicalState() is on.dofs and on.dofs.getContext() is on and on.dofs.getRoot() is root
    assert root.hasChild("on") and not root.hasChild("nothing") and on.hasObject("dofs") and root.getObject("on/dofs") is on.dofs
    assert [each.name.value for each in root.children] == ["off", "on"] and len(root.children) == 2 and root.children[1] is on
    assert on.dofs.position.getLinkPath() == on.dofs.position.linkpath == "@/on/dofs.position"
    assert on.dofs.getLinkPath() == on.dofs.linkpath and on.getLinkPath() == on.linkpath == "@/on"
    assert on.dofs.getPathName() == "/on/dofs" and root.getRoot() is root and on.getRootPath() == "../"
    for child in list(root.children):
        for thing in child.objects:
            thing.getClassName(), thing.getTemplateName(), thing.getCategories(), str(thing), repr(thing)
