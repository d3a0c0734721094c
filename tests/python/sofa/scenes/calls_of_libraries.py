# SPDX-License-Identifier: LGPL-2.1-or-later
"""Calls of the libraries of SOFA's plugins that no other scene makes: parts of a mesh by links that are assigned, a scene in XML
read by a program, nodes that wrap others, functions as attributes of a node, a goal without mass, frames written by their rows."""
import re
import xml.etree.ElementTree as ET

import Sofa
import SofaRuntime

CUBE = [[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)]
PARTS = [[0, 1, 2, 4], [3, 2, 1, 7], [5, 1, 4, 7], [6, 4, 2, 7], [1, 2, 4, 7]]
FACES = [[0, 2, 1], [1, 2, 3]]


def part_of_mesh(parent, container, region, kind, name):
    """Cells of a region with a stiffness of their own; the region is a link assigned after the container was made."""
    which = re.search(r"\.(\w+)InROI", region).group(1)
    part = parent.addChild(name)
    part.addObject(kind + "SetTopologyContainer", name="container", position=container)
    part.getObject("container").findData(which).value = region
    part.addObject(kind + "FEMForceField", name="FEM", method="large", poissonRatio=0.3, youngModulus=18000)
    return part


def read_xml(element, node, given):
    for name, value in element.attrib.items():
        if name in node.__data__:
            node.findData(name).read(value)
    for child in element:
        if child.tag == "Node":
            read_xml(child, node.addChild(child.attrib["name"]), given)
        else:
            child.attrib.update({name: value for name, value in given.items() if name in child.attrib})
            node.addObject(child.tag, **child.attrib)


class Wrapper:
    """Hands everything to a node, objects with other values."""

    def __init__(self, node, changed):
        self.node, self.changed = node, changed

    def addObject(self, type, **values):
        return self.node.addObject(type, **{**values, **self.changed.get(type, {})})

    def addChild(self, name):
        return Wrapper(self.node.addChild(name), self.changed)

    def __getattr__(self, name):
        try:
            return self.node.__getattr__(name)
        except AttributeError:
            return self.node.__getattribute__(name)


def set_in_tree(target, pattern, **values):
    if isinstance(target, Sofa.Core.Node):
        for child in list(target.children) + list(target.objects):
            set_in_tree(child, pattern, **values)
    elif re.search(pattern, target.getLinkPath()):
        for name, value in values.items():
            if target.getData(name) is not None:
                target.getData(name).value = value


class Mover(Sofa.Core.Controller):
    """Moves a frame by the rows of its positions, and looks at the rest when it is time."""

    def __init__(self, *arguments, **values):
        Sofa.Core.Controller.__init__(self, *arguments, **values)
        self.listening = True
        self.name = "Mover"
        self.node = arguments[0]
        self.steps = 0

    def onAnimateBeginEvent(self, event):
        self.steps += 1
        place = self.node.Frame.dofs.getData("position")
        value = [[float(number) for number in row] for row in place.value]
        value[0] = [0.1 * self.steps] + value[0][1:]
        self.node.Frame.dofs.position = value

    def onAnimateEndEvent(self, event):
        root = self.node.getRoot()
        assert abs(root.Frame.dofs.position.value[0][0] - 0.1 * self.steps) < 1e-12
        assert abs(root.Frame.rider.dofs.position.value[0][0] - 0.1 * self.steps - 1) < 1e-12, "what rides follows"
        fallen = 9.81 * root.dt.value ** 2 * self.steps * (self.steps + 1) / 2
        drop = root.ofTheFile.drop.dofs.position.value[0][1]
        assert abs(drop + fallen) < 1e-9, "each step adds g dt to the velocity, then moves by it"
        assert len(root.Body.container.position.value) == 8
        goal = root.Goal.MechanicalObject.position.value[0]
        assert max(abs(goal[0] - 1), abs(goal[1] - 2), abs(goal[2] - 3)) < 1e-12, "a goal without mass or force stays"


def createScene(root):
    root.gravity.value = [0, -9.81, 0]
    root.dt.value = 0.01
    settings = Sofa.Core.Node("Settings")
    settings.addObject("RequiredPlugin", name="SoftRobots", printLog=False)
    settings.addObject("OglSceneFrame", style="Arrows", alignment="TopRight")
    root.addObject("VisualStyle")
    root.addObject("DefaultAnimationLoop")
    root.addSettings = lambda: root.addChild(settings)
    root.addSettings()
    assert root.Settings.getPathName() == "/Settings" and root.hasObject("VisualStyle") is True
    assert root.hasObject("CollisionPipeline") is False

    body = root.addChild("Body")
    body.addObject("EulerImplicitSolver", name="TimeIntegrationSchema")
    body.addObject("SparseLDLSolver", name="LinearSolver", template="CompressedRowSparseMatrixd")
    body.addObject("TetrahedronSetTopologyContainer", name="container", position=CUBE, tetrahedra=PARTS, triangles=FACES)
    body.addObject("MechanicalObject", name="dofs")
    body.addObject("UniformMass", totalMass=0.5)
    body.addObject("TetrahedronFEMForceField", method="large", poissonRatio=0.3, youngModulus=9000)
    body.addObject("BoxROI", name="boxROI", box=[-20, -20, -20, 20, 20, 20], drawBoxes=True)
    part_of_mesh(body, "@../container.position", "@../boxROI.tetrahedraInROI", "Tetrahedron", "Inside")
    part_of_mesh(body, "@../container.position", "@../boxROI.trianglesInROI", "Triangle", "Skin")
    held = body.addChild("Held")
    held.addObject("BoxROI", name="BoxROI", box=[-0.1, -0.1, -0.1, 1.1, 0.1, 1.1], drawBoxes=False, doUpdate=False)
    held.addObject("PartialFixedConstraint", indices="@BoxROI.indices", fixedDirections=[1, 1, 1], fixAll=False)
    assert len(body.Inside.container.tetrahedra.value) == 5 and len(body.Skin.container.triangles.value) == 2

    frame = root.addChild("Frame")
    frame.addObject("MechanicalObject", template="Rigid3", name="dofs", reserve=1, position=[[0, 0, 0, 0, 0, 0, 1]])
    rider = frame.addChild("rider")
    rider.addObject("MechanicalObject", template="Vec3", name="dofs", position=[[1, 0, 0]])
    rider.addObject("RigidMapping", name="mapping", globalToLocalCoords=True, rigidIndexPerPoint=[0])

    goal = root.addChild("Goal")
    goal.addObject("EulerImplicitSolver", firstOrder=True)
    goal.addObject("CGLinearSolver", threshold=1e-5, tolerance=1e-5)
    goal.addObject("MechanicalObject", template="Vec3", position=[1, 2, 3], rotation=[0.0, 0.0, 0.0], translation=[0.0, 0.0, 0.0],
                   scale=1.0, showObject="1", showObjectScale=0.1, drawMode="1", showColor="255 255 255 255")

    read = root.addChild("Read")
    with open(SofaRuntime.DataRepository.getFile("data/drop.xml"), encoding="utf-8") as file:
        read_xml(ET.parse(file).getroot(), read, {"totalMass": "2"})
    assert root.ofTheFile.drop.mass.totalMass.value == 2, "a name that is read; a value that was given, not that of the file"

    wrapped = Wrapper(root, {"UniformMass": {"totalMass": 3}}).addChild("Wrapped")
    wrapped.addObject("EulerExplicitSolver")
    wrapped.addObject("MechanicalObject", name="dofs", position=[[0, 0, 0]])
    wrapped.addObject("UniformMass", name="mass", totalMass=1)
    assert wrapped.name.value == "Wrapped" and wrapped.mass.totalMass.value == 3 and wrapped.getRoot() == root
    set_in_tree(root, "Frame.*/dofs", showObject=True, showObjectScale=5.0, ofNobody=1)
    assert root.Frame.dofs.showObject.value and root.Frame.rider.dofs.showObjectScale.value == 5
    Sofa.msg_info(root, "a message of a node")
    root.addObject(Mover(root))
