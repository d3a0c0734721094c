# SPDX-License-Identifier: LGPL-2.1-or-later
"""A device that is missing, with a listener of contacts and a carving manager."""
import Sofa


class Watch(Sofa.Core.Controller):
    def __init__(self, *args, **kwargs):
        Sofa.Core.Controller.__init__(self, *args, **kwargs)
        self.listener = kwargs["root"].addObject("ContactListener", name="listener", collisionModel1="@tool/model",
                                                 collisionModel2="@tool/model")

    def onAnimateEndEvent(self, event):
        if self.listener.getNumberOfContacts() != 0:
            print(self.listener.getContactPoints())


def createScene(root):
    root.addObject("RequiredPlugin", name="Geomagic")
    root.addObject("GeomagicDriver", name="GeomagicDevice", deviceName="Default Device", scale="1", drawDeviceFrame="1")
    root.addObject("DefaultAnimationLoop")
    tool = root.addChild("tool")
    tool.addObject("MechanicalObject", template="Rigid3d", name="instrumentState", position="@../GeomagicDevice.positionDevice")
    tool.addObject("SphereCollisionModel", name="model", radius=1, tags="CarvingTool")
    root.addObject("CarvingManager", active="true", carvingDistance="0.1")
    root.addObject(Watch(name="watch", root=root))
