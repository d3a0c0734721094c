# SPDX-License-Identifier: LGPL-2.1-or-later
"""Ways in which scenes are written, a createScene(root) for each. What one returns is called after ten steps, to look at them."""
import json
import math
import os
from dataclasses import dataclass, field

import numpy as np
import Sofa
import Sofa.Core
from Sofa.constants import Key
from Sofa.SofaDeformable import LinearSpring

MESH = "mesh/finger.vtk"  # 80 x 20 x 20, of 81 nodes


def solvers(node, **damping):
    node.addObject("EulerImplicitSolver", name="odesolver", **damping)
    return node.addObject("CGLinearSolver", iterations=50, tolerance=1e-12, threshold=1e-14)


def particle(parent, name="body", position=((0.0, 0.0, 0.0),), mass=2.0):
    node = parent.addChild(name)
    solvers(node)
    node.addObject("MechanicalObject", name="mo", position=position)
    node.addObject("UniformMass", name="mass_", totalMass=mass)
    return node


def block(parent, n=(4, 3, 3), young=1e4, name="beam"):
    node = parent.addChild(name)
    solvers(node)
    node.addObject("RegularGridTopology", name="grid", n=n, min=[0, 0, 0], max=[i - 1 for i in n])
    node.addObject("MechanicalObject", name="mo")
    node.addObject("UniformMass", totalMass=1)
    node.addObject("HexahedronFEMForceField", name="fem", youngModulus=young, poissonRatio=0.3, method="large")
    return node


def soft(parent, name="soft", young=500, mass=0.05):
    node = parent.addChild(name)
    node.addObject("EulerImplicitSolver", rayleighStiffness=0.1, rayleighMass=0.1)
    node.addObject("SparseLDLSolver", template="CompressedRowSparseMatrixMat3x3d", parallelInverseProduct=True)
    node.addObject("MeshVTKLoader", name="loader", filename=MESH)
    node.addObject("TetrahedronSetTopologyContainer", name="container", src=node.loader.getLinkPath())
    node.addObject("TetrahedronSetTopologyModifier")
    node.addObject("MechanicalObject", name="dofs", template="Vec3", showObject=True, showObjectScale=1)
    node.addObject("UniformMass", totalMass=mass)
    node.addObject("TetrahedronFEMForceField", name="fem", template="Vec3", method="large", poissonRatio=0.4, youngModulus=young)
    node.addObject("BoxROI", name="roi", box=[-1, -1, -1, 1, 21, 21], drawBoxes=True, doUpdate=False)
    node.addObject("FixedProjectiveConstraint", indices=node.roi.indices)
    return node


def lagrangian(root):
    root.addObject("FreeMotionAnimationLoop", parallelODESolving=True)
    return root.addObject("GenericConstraintSolver", name="cs", maxIterations=1000, tolerance=1e-10, computeConstraintForces=True)


class Each(Sofa.Core.Controller):
    """Calls functions at the beginning and at the end of steps, with the number of the step."""

    def __init__(self, begin=None, end=None, **named):
        Sofa.Core.Controller.__init__(self, **named)
        self.begin, self.end, self.count = begin, end, 0

    def onAnimateBeginEvent(self, event):
        self.count += 1
        if self.begin:
            self.begin(self.count)

    def onAnimateEndEvent(self, event):
        if self.end:
            self.end(self.count)


# ---- values ----

def numbers_as_people_have_them(root):
    """Floats for integers, NumPy's numbers, generators, maps, ranges, one number for a list, text of lists."""
    n = root.addChild("n")
    n.addObject("EulerImplicitSolver", rayleighMass="0.1")
    n.addObject("CGLinearSolver", iterations=100.0, tolerance="1e-10", threshold=np.float32(1e-10))
    n.addObject("RegularGridTopology", name="grid", n=[4.0, 3.0, 3.0], min=np.zeros(3), max=np.array([3, 2, 2]))
    n.addObject("MechanicalObject", name="mo", template="Vec3d", position=n.grid.position.value * 1.0)
    n.addObject("UniformMass", totalMass=np.int32(2))
    n.addObject("HexahedronFEMForceField", name="ff", youngModulus=np.float64(1e4), poissonRatio=".3", method="large")
    n.addObject("FixedProjectiveConstraint", name="fc", indices=np.where(n.grid.position.value[:, 0] < 1e-6)[0])
    n.addObject("ConstantForceField", name="c1", indices=np.arange(3, 6, dtype=float), forces=np.ones((3, 3), dtype=np.float32))
    n.addObject("ConstantForceField", name="c2", indices=7, totalForce=(0, 0, 1))
    n.addObject("ConstantForceField", name="c3", indices=(str(i) for i in (8, 9)), forces=map(lambda i: [i, 0, 0], range(2)))
    n.addObject("ConstantForceField", name="c4", indices=str([10, 11]).strip("[]").replace(",", " "), forces="0 0 1 0 0 1")
    n.addObject("BoxROI", name="b", box=np.array([[-1, -1, -1, 1, 1, 1], [2, 2, 2, 3, 3, 3]]), strict=False, computeTetrahedra=False)
    n.addObject("RestShapeSpringsForceField", points=[1, 2], stiffness=[100, 200], angularStiffness=1)
    assert n.c1.indices.value.tolist() == [3, 4, 5] and n.c2.indices.value.tolist() == [7]
    assert n.c3.forces.value.tolist() == [[0, 0, 0], [1, 0, 0]] and n.c4.indices.value.tolist() == [10, 11]
    held = [i for i, place in enumerate(n.grid.position.value) if place[0] == 0]

    def check():
        assert n.fc.indices.value.tolist() == held and n.b.box.value.shape == (2, 6) and n.mo.position.value.shape == (36, 3)
    return check


def data_of_every_kind(root):
    """addData() with the kinds of SOFA; links to it as text and as data."""
    for name, kind, value in (("a", "Vec3d", [1., 2, 3]), ("b", "vector<Vec3d>", [[1, 2, 3], [4, 5, 6]]), ("c", "vector<int>", [1, 2]),
                              ("d", "string", "x"), ("e", "bool", True), ("f", "int", 3), ("g", "vector<string>", ["a", "b"]),
                              ("h", "double", 1.5), ("i", "Vec<3,double>", [0, 0, 1]), ("k", "Rigid3d::VecCoord", [[0] * 7]),
                              ("l", None, np.eye(3)), ("m", "map", None)):
        d = root.addData(name=name, type=kind, value=value, help="of " + name, group="g")
        assert d is root.getData(name) and d.getHelp() == "of " + name and d.getOwner() is root
        d.value, d.getValueString(), d.typeName(), str(d), repr(d), d.isSet(), d.hasParent()
    root.f.value += 1
    root.a.value[1] = 5.0
    root.h.value = "3.5"
    assert (root.f.value, root.a.value[1], root.h.value, root.b[0][1], root.b[1, 2]) == (4, 5, 3.5, 2, 6)
    n = root.addChild("n")
    n.addData("up", value=root.h.getLinkPath(), type="double")
    n.addData("direct", value=root.h)
    root.h.value = 4.0
    assert n.direct.value == 4.0 and n.up.value == 4.0
    n.addObject("EulerExplicitSolver")
    n.addObject("MechanicalObject", name="mo", position=root.b)
    n.addObject("UniformMass", name="mass_", totalMass=n.direct)

    def check():
        assert n.mass_.totalMass.value == 4.0 and n.mo.position.value[:, 0].tolist() == [1, 4]
    return check


def arrays_are_read_in_every_way(root):
    """[i][j], [i, j], tolist(), means, masks, differences; `with` and without; what is not there is None or an AttributeError."""
    body = block(root)
    mo = body.mo

    def begin(step):
        same = {mo.position.value[3][1], mo.position[3][1], mo.getData("position").value[3, 1], mo.findData("position").value[3].tolist()[1]}
        assert len(same) == 1
        with mo.position.writeable() as p:
            p[3] += np.array([0, 1e-3, 0])
            p[:, 0] *= 1.0
        with mo.velocity.writeableArray() as v:
            v *= 0.5
        mo.velocity.value = mo.velocity.value * 0.9
        mo.velocity = mo.velocity.value.tolist()
        assert abs(mo.position.value[3][1] - same.pop() - 1e-3) < 1e-15
        assert mo.getData("nothing") is None and not hasattr(mo, "nope") and getattr(mo, "nope", 3) == 3
        kept = mo.position.array()
        kept[:] = 7
        assert mo.position.value.max() < 7 and mo.position.value[mo.position.value[:, 0] > 2].shape[1] == 3

    def end(step):
        json.dumps(mo.position.value.tolist())
        f"{mo.position} {root.dt} {root.time.value:.3f} {mo.name} {mo.position.getValueString()}"
        assert np.linalg.norm(mo.position.value - mo.rest_position.value, axis=1).max() < 1 and len(mo.__data__) == len(mo.getDataList())
    root.addObject(Each(begin, end, name="each", listening=True))


# ---- the tree ----

def a_tree_that_is_walked_and_cut(root):
    """objects and children by number, name and at(); removed, detached, hung elsewhere, renamed."""
    a, b, c = root.addChild("a"), root.addChild("b"), particle(root, "c")
    for node in (a, b):
        node.addObject("MechanicalObject", name="mo", position=[[0, 0, 0]])
        node.addObject("UniformMass", totalMass=1)
    b.removeObject(b.mo)
    b.removeObject(b.getObject("UniformMass"))
    root.removeChild("c")
    c = particle(root, "c", mass=1)
    b.detach()
    d = Sofa.Core.Node("d")
    d.addObject("MechanicalObject", name="m")
    a.addChild(d)
    a.mo.setName("renamed")
    a.renamed.name = "mo"
    assert [each.name.value for each in root.children] == ["a", "c"] and root.children["a"] is root.children[0] is root.children.at(0) is a
    assert root.a.d.m is root["a.d.m"] is root.getChild("a").getChild("d").getObject("m") and d.m.getContext() is d
    assert (c.getMechanicalState(), c.getMass(), c.getForceField(0)) == (c.mo, c.mass_, None) and c.hasODESolver()

    def walk(node):
        yield node.getPathName()
        for each in node.objects:
            yield f"{each.getClassName()} {each.name.value} {each.getPathName()} {each.getTemplateName()} {each.getCategories()}"
        for child in node.children:
            yield from walk(child)
    lines = list(walk(root))
    assert {"/a/d", "UniformMass mass_ /c/mass_ Vec3d ['mass']"} < set(lines), lines
    Sofa.Simulation.print(root)

    def check():
        assert c.mo.position.value[0][1] < 0
    return check


def types_are_asked_for(root):
    """isinstance() with the classes of Sofa.Core, and the factory."""
    n = block(root)
    assert isinstance(n.mo, Sofa.Core.Object) and isinstance(n, Sofa.Core.Node) and isinstance(n.mo.position, Sofa.Core.Data)
    assert isinstance(n.mo, Sofa.Core.BaseMechanicalState) and not isinstance(n.mo, Sofa.Core.BaseMass)
    assert [each.getClassName() for each in n.objects if isinstance(each, Sofa.Core.BaseForceField)] == ["HexahedronFEMForceField"]
    assert isinstance(n.UniformMass, Sofa.Core.Mass) and isinstance(n.grid, Sofa.Core.BaseMeshTopology) and not isinstance(n, Sofa.Core.Mass)
    assert "BoxROI" in [each.className for each in Sofa.Core.ObjectFactory.components]
    assert Sofa.Core.ObjectFactory.getComponent("Nothing") is None


def bodies_that_come_and_go(root):
    """Nodes and objects come, go and are let loose while it runs."""
    root.addObject("EulerImplicitSolver")
    root.addObject("CGLinearSolver", iterations=20, tolerance=1e-12, threshold=1e-14)
    first = root.addChild("first")
    first.addObject("MechanicalObject", name="mo", position=[0, 0, 0])
    first.addObject("UniformMass", totalMass=1)
    first.addObject("FixedProjectiveConstraint", name="fix", indices=0)
    made = []

    def end(step):
        if step % 3 == 0:
            made.append(root.addChild(f"ball{step}"))
            made[-1].addObject("MechanicalObject", name="mo", template="Vec3", position=[[0, step, 0]])
            made[-1].addObject("UniformMass", totalMass=0.1)
            made[-1].init()
        if step == 5:
            first.removeObject(first.fix)
        if step == 8:
            root.removeChild(made[0])
    root.addObject(Each(end=end, name="maker"))

    def check():
        h2g = 9.81 * root.dt.value ** 2
        assert first.mo.position.value[0][1] == approx(-h2g * 5 * 6 / 2)
        assert made[1].mo.position.value[0][1] == approx(6 - h2g * 4 * 5 / 2)
        assert [child.getName() for child in root.children] == ["first", "ball6", "ball9"]
    return check


def functions_that_make_parts(root, *_, config=None, **__):
    """createScene() with more arguments; functions, lambdas and dictionaries of arguments; attributes that a scene keeps on nodes."""
    def Body(node, name="Body", *, mass=1.0):
        self = particle(node, name, mass=mass)
        self.load = self.addObject("ConstantForceField", name="load", indices=0, **{"totalForce": [0, 0, 0]})
        self.act = lambda force: setattr(self.load.totalForce, "value", force)
        return self
    root.gravity = [0, 0, 0]
    bodies = [Body(root, name=f"b{i}", mass=i + 1) for i in range(3)]
    root.add(Body, name="byAdd")
    root.settings = {"a": 1}
    root.addObject(Each(lambda step: [body.act([body.load.getContext().mass_.totalMass.value, 0, 0]) for body in bodies]))

    def check():
        assert [body.mo.position.value[0][0] for body in bodies] == approx([55 * root.dt.value ** 2] * 3) and root.settings["a"] == 1
        assert root.byAdd.mo.position.value[0][0] == 0
    return check


# ---- prefabs ----

def prefabs_of_all_kinds(root):
    """prefabParameters of every type, prefabData, links to parameters, add() with a class, a builder."""
    class Floor(Sofa.Prefab):
        """a floor"""
        prefabParameters = [
            {"name": "rotation", "type": "Vec3d", "help": "Rotation", "default": [0.0, 0.0, 0.0]},
            {"name": "translation", "type": "Vec3d", "help": "Translation", "default": [0.0, 0.0, 0.0]},
            {"name": "color", "type": "Vec4d", "help": "Color", "default": [1.0, 1.0, 1.0, 1.0]},
            {"name": "number", "type": "int", "help": "n", "default": 3},
            {"name": "flag", "type": "bool", "help": "n", "default": True},
            {"name": "text", "type": "string", "help": "n", "default": ""}]
        prefabData = [{"name": "stiff", "type": "float", "help": "", "default": 5.0}]

        def init(self):
            self.addObject("MechanicalObject", name="mo", template="Rigid3", translation=list(self.translation.value), rotation=self.rotation)
            self.visual = self.addChild("Visual")
            self.visual.addObject("MeshOBJLoader", name="loader", filename="mesh/cube.obj")
            self.visual.addObject("OglModel", src="@loader", color=self.color)
            self.visual.addObject("RigidMapping")
            self.addData("total", type="double", value=self.stiff.value * self.number.value)

    @Sofa.PrefabBuilder
    def Row(self, spacing=1.0, count=2):
        self.addObject("MechanicalObject", name="mo", position=[[i * spacing, 0, 0] for i in range(count)])

    first, second = root.addChild(Floor(name="MyFloor", translation=[0, -5, 0], color=[1.0, 0, 0, 1.0], stiff=2.0)), root.addChild(Floor())
    root.add(Floor, name="Third", number=7)
    row = root.addChild(Row(name="row", spacing=2.0))
    assert (first.total.value, second.total.value, root.Third.total.value) == (6, 15, 35) and first.flag.value is True
    assert isinstance(first, Sofa.Prefab) and isinstance(first, Sofa.Core.Node) and not isinstance(first.mo, Sofa.Core.Node)

    def check():
        assert first.mo.position.value[0].tolist() == [0, -5, 0, 0, 0, 0, 1] and row.mo.position.value[1][0] == 2
    return check


def a_servo_with_an_angle(root):
    """A prefab around an articulated joint, whose angle is a parameter that others write while it runs."""
    class ServoMotor(Sofa.Prefab):
        prefabParameters = [{"name": "angleIn", "type": "float", "help": "in", "default": 0.0}]
        prefabData = [{"name": "angleOut", "type": "float", "help": "out", "default": 0.0}]

        def init(self):
            base = self.addChild("BaseFrame")
            base.addObject("MechanicalObject", name="dofs", template="Rigid3", position=[[0, 0, 0, 0, 0, 0, 1]])
            base.addObject("FixedProjectiveConstraint", indices=0)
            joint = self.addChild("Articulation")
            joint.addObject("MechanicalObject", name="dofs", template="Vec1", position=[[self.angleIn.value]], rest_position=[self.angleIn.value])
            joint.addObject("RestShapeSpringsForceField", points=0, stiffness=1e9)
            joint.addObject("ArticulatedHierarchyContainer")
            wheel = joint.addChild("ServoWheel")
            wheel.addObject("MechanicalObject", name="dofs", template="Rigid3", position=[[0, 0, 0, 0, 0, 0, 1]] * 2)
            wheel.addObject("UniformMass", totalMass=0.01)
            wheel.addObject("ArticulatedSystemMapping", input1="@../dofs", input2="@../../BaseFrame/dofs", output="@./")
            center = joint.addChild("ArticulationCenter")
            center.addObject("ArticulationCenter", parentIndex=0, childIndex=1, posOnParent=[0., 0, 0], posOnChild=[0., 0, 0])
            center.addChild("Articulations").addObject("Articulation", translation=False, rotation=True, rotationAxis=[1, 0, 0], articulationIndex=0)
    simulation = root.addChild("Simulation")
    simulation.addObject("EulerImplicitSolver")
    simulation.addObject("SparseLDLSolver")
    servo = simulation.addChild(ServoMotor(name="ServoMotor", angleIn=0.5))
    lead = servo.Articulation.dofs.rest_position
    root.addObject(Each(lambda step: setattr(lead, "value", [[0.5 + 0.01 * step]])))

    def check():
        angle = servo.Articulation.dofs.position.value[0][0]
        assert 0.5 < angle <= 0.6 and servo.Articulation.ServoWheel.dofs.position.value[1][3:] == approx(
            [math.sin(angle / 2), 0, 0, math.cos(angle / 2)])
    return check


# ---- controllers ----

def controllers_without_manners(root):
    """Without super().__init__(), with positional arguments, with data and properties of their own, deaf ones."""
    class Forgot(Sofa.Core.Controller):
        def __init__(self, node):
            self.node, self.k = node, 3

        def onAnimateEndEvent(self, event):
            self.k += 1

    class WithData(Sofa.Core.Controller):
        def __init__(self, *args, **kwargs):
            Sofa.Core.Controller.__init__(self, args, kwargs)
            self.addData(name="pressure", type="float", value=kwargs.get("pressure", 1.0), help="in kPa", group="control")
            self.addData("on", None, False, "help", "group", "bool")
            self.addNewData("old", "group", "help", "f", 2.0)
            self.time, self.position, self.mass, self.state = 0, 5, None, "waiting"  # names that objects have

        @property
        def double(self):
            return 2 * self.pressure.value

        def onAnimateBeginEvent(self, event):
            self.pressure.value += 1
            self.pressure = self.pressure.value + 1
            self.time += event["dt"]
            self.state = "running"
            assert event["type"] == "AnimateBeginEvent" and not event["isHandled"] and self.double == 2 * float(self.pressure.value)

    forgot, data = root.addObject(Forgot(root)), root.addObject(WithData("Positional", root))
    named = root.addObject(WithData(name="named", pressure=7.0, listening=1, printLog=True))
    deaf = root.addObject(Each(name="deaf", listening=False))

    def check():
        assert (forgot.k, data.pressure.value, data.state, deaf.count) == (13, 21, "running", 0) and data.time == approx(0.1)
        assert (named.getName(), data.getName(), named.old.value, named.on.value) == ("WithData1", "WithData", 2.0, False)
    return check


def episodes_from_within(root):
    """A controller that puts everything back to its start every four steps."""
    body = particle(root)
    seen = []

    def end(step):
        seen.append(body.mo.position.value[0][1])
        if step % 4 == 0:
            Sofa.Simulation.reset(root)
    root.addObject(Each(end=end))

    def check():
        assert seen[:4] == seen[4:8] and seen[8:] == seen[:2] and seen[3] < seen[0] < 0
    return check


def an_animation_manager(root):
    """Functions with a factor from 0 to 1 over a duration, as splib has them."""
    class Manager(Sofa.Core.Controller):
        def __init__(self, root):
            Sofa.Core.Controller.__init__(self)
            self.listening.value, self.name, self.animations, self.totalTime, self.root = True, "AnimationManager", [], 0.0, root

        def onAnimateBeginEvent(self, event):
            self.totalTime += event["dt"]
            for function, params, duration in self.animations:
                function(factor=min(1.0, self.totalTime / duration), **params)
    body = particle(root)
    load = body.addObject("ConstantForceField", name="load", indices=[0], totalForce=[0, 0, 0])
    manager = root.addObject(Manager(root))
    manager.animations.append((lambda target, factor: setattr(target.totalForce, "value", [factor, 0, 0]), {"target": load}, 0.05))

    def check():
        forces = [min(1.0, i / 5) for i in range(1, 11)]
        assert body.mo.velocity.value[0][0] == approx(0.01 * sum(forces) / 2)
    return check


def everything_changes_as_it_runs(root):
    """Moduli, loads, indices, gravity, the time step, a solver's settings, reinit()."""
    body = soft(root)
    load = body.addObject("ConstantForceField", name="load", indices=[80, 79], totalForce=[0, 0, 1])
    still = body.roi.indices.value.tolist()

    def begin(step):
        if step == 2:
            body.fem.youngModulus.value = 2000
        elif step == 3:
            body.fem.youngModulus, body.fem.poissonRatio.value = [3000.0], [0.2]
            body.fem.reinit()
        elif step == 4:
            root.gravity = [0, 0, 0]
        elif step == 5:
            root.dt = 0.02
        elif step == 6:
            load.forces.value = [[0, 0, 5.0]] * len(load.indices.value)
        elif step == 8:
            load.indices.value = [1, 2]
        elif step == 10:
            body.odesolver.rayleighStiffness.value = 0.3
    body.EulerImplicitSolver.name = "odesolver"
    root.addObject(Each(begin))

    def check():
        assert body.fem.youngModulus.value.tolist() == [3000] and root.time.value == approx(4 * 0.01 + 6 * 0.02)
        assert (body.dofs.position.value[still] == body.loader.position.value[still]).all() and np.isfinite(body.dofs.position.value).all()
    return check


# ---- bodies ----

def a_finger_with_four_cables(root):
    """Parameters in a dataclass, typed controllers, `value` written in place."""
    @dataclass
    class Params:
        young: float = 450.0
        angles: list = field(default_factory=lambda: [i * np.pi / 2 for i in range(4)])
    params, cs = Params(), lagrangian(root)
    root.gravity = [0.0, 0.0, -9810.0]
    body = soft(root, young=params.young)
    body.addObject("LinearSolverConstraintCorrection", linearSolver="@SparseLDLSolver", ODESolver="@EulerImplicitSolver")
    cables = []
    for i, a in enumerate(params.angles):
        cable = body.addChild("cable%d" % i)
        points = np.array([[x, 10 + 8 * np.cos(a), 10 + 8 * np.sin(a)] for x in np.linspace(10, 70, 4)])
        cable.addObject("MechanicalObject", name="points", position=points)
        cables.append(cable.addObject("CableConstraint", name="actuator", indices=np.arange(4), pullPoint=[0.0, 10 + 8 * np.cos(a), 10 + 8 * np.sin(a)],
                                      valueType="displacement", value=0.0, minForce=0, hasPullPoint=True, drawPullPoint=False))
        cable.addObject("BarycentricMapping", mapForces=False, mapMasses=False)

    def begin(step):
        with cables[0].value.writeable() as value:
            value[0] += 0.5
    root.addObject(Each(begin))

    def check():
        assert cables[0].displacement.value == approx(5, 1e-3) and cables[0].force.value > 0
        assert len(cs.constraintForces.value) == cs.currentNumConstraints.value == 4
        assert cs.constraintForces.value == approx([cable.force.value for cable in cables])
    return check


def a_cavity_and_a_cable_by_force(root):
    """Pressure, volume, length, tension and displacement are read; keys that do nothing else."""
    class Pressure(Sofa.Core.Controller):
        def __init__(self, *args, **kwargs):
            Sofa.Core.Controller.__init__(self, *args, **kwargs)
            self.node, self.seen = kwargs["node"], []
            self.constraints = [self.node.cavity.getObject("SurfacePressureConstraint")]

        def onAnimateBeginEvent(self, event):
            for constraint in self.constraints:
                pressure = constraint.value.value[0] + 0.01
                constraint.value = [pressure if pressure < 1.5 else 1.5]
            self.node.cable.c.value.value = self.node.cable.c.value.value + 0.2

        def onAnimateEndEvent(self, event):
            cavity, cable = self.constraints[0], self.node.cable.c
            self.seen.append([cavity.pressure.value, cavity.cavityVolume.value, cavity.volumeGrowth.value, cable.force.value,
                              cable.displacement.value, cable.cableLength.value])

        def onKeypressedEvent(self, event):
            if event["key"] == Key.plus:
                self.constraints[0].value.value = [0]
    lagrangian(root)
    node = soft(root)
    node.addObject("GenericConstraintCorrection")
    cavity = node.addChild("cavity")
    cavity.addObject("MeshSTLLoader", name="loader", filename="mesh/cavity.stl")
    cavity.addObject("MeshTopology", src="@loader", name="topo")
    cavity.addObject("MechanicalObject", name="cavity")
    cavity.addObject("SurfacePressureConstraint", name="SurfacePressureConstraint", template="Vec3", value=[0.0001], triangles="@topo.triangles",
                     drawPressure=0, drawScale=0.0002, valueType="pressure")
    cavity.addObject("BarycentricMapping", name="mapping", mapForces=False, mapMasses=False)
    cable = node.addChild("cable")
    cable.addObject("MechanicalObject", position="10 18 10  40 18 10  70 18 10")
    cable.addObject("CableConstraint", name="c", indices="0 1 2", pullPoint="0 18 10", valueType="force", value=0)
    cable.addObject("BarycentricMapping")
    control = root.addObject(Pressure(node=node))

    def check():
        pressure, volume, growth, tension, displacement, length = np.array(control.seen).T
        assert np.diff(pressure) == approx([0.01] * 9) and np.diff(tension) == approx([0.2] * 9)  # impulses, as in SoftRobots
        assert volume == approx(volume[0] - growth[0] + growth) and length == approx(70 - displacement) and displacement[-1] > 0
    return check


def ties_and_their_forces(root):
    """A held point, a free one and a tied one that is pulled: constraintForces are the impulses row by row."""
    cs = lagrangian(root)
    root.gravity = [0, -10, 0]
    pair = root.addChild("pair")
    tied = root.addChild("tied")
    for node, places, mass in ((pair, [[0, 0, 0], [1, 0, 0]], 4), (tied, [[1, 0, 0]], 3)):
        node.addObject("EulerImplicitSolver")
        node.addObject("SparseLDLSolver")
        node.addObject("GenericConstraintCorrection")
        node.addObject("MechanicalObject", name="mo", position=places)
        node.addObject("UniformMass", totalMass=mass)
    pair.addObject("FixedLagrangianConstraint", indices=[0])
    tied.addObject("ConstantForceField", indices=[0], totalForce=[5, 0, 0])
    root.addObject("BilateralLagrangianConstraint", object1="@pair/mo", object2=tied.mo, first_point=1, second_point=0)

    def check():
        # the row of a tie is of the second point: on the first, 2 kg of 5, acts 2 N of the 5 N, on the second -2 N
        rows = {tuple(np.round(each, 9)) for each in (np.array(cs.constraintForces.value).reshape(2, 3) / root.dt.value)}
        assert rows == {(0, 20, 0), (-2, 0, 0)}, rows
        assert tied.mo.velocity.value[0] == approx([0.1, -1, 0]) and cs.currentNumConstraints.value == 6
    return check


def contacts_as_present_scenes_have_them(root):
    """A ball falls on a floor that nothing moves: parallel phases, friction with more parameters, a solver that keeps its forces."""
    root.addObject("FreeMotionAnimationLoop", parallelCollisionDetectionAndFreeMotion=True)
    for kind in ("CollisionPipeline", "ParallelBruteForceBroadPhase", "ParallelBVHNarrowPhase"):
        root.addObject(kind)
    root.addObject("LocalMinDistance", name="Proximity", alarmDistance=0.5, contactDistance=0.1, angleCone=0.01)
    root.addObject("CollisionResponse", response="FrictionContactConstraint", responseParams="mu=0.3&tol=1e-4")
    solver = root.addObject("ProjectedGaussSeidelConstraintSolver", name="cs", tolerance=1e-9, maxIterations=1000, computeConstraintForces=True)
    ball, floor = root.addChild("ball"), root.addChild("floor")
    ball.addObject("EulerImplicitSolver", rayleighStiffness=0, rayleighMass=0)
    ball.addObject("SparseLDLSolver", template="CompressedRowSparseMatrixd")
    ball.addObject("MechanicalObject", name="mstate", template="Rigid3", position=[0.3, 1.1, 0.1, 0, 0, 0, 1])
    ball.addObject("UniformMass", totalMass=2.0)
    ball.addObject("UncoupledConstraintCorrection")
    sphere = ball.addChild("collision")
    sphere.addObject("MechanicalObject", position=[0, 0, 0])
    sphere.addObject("SphereCollisionModel", radius=1.0)
    sphere.addObject("RigidMapping")
    floor.addObject("MeshTopology", position=[[-9, 0, -9], [-9, 0, 9], [9, 0, 9], [9, 0, -9]], triangles=[[0, 1, 2], [0, 2, 3]])
    floor.addObject("MechanicalObject", name="dofs")
    floor.addObject("TriangleCollisionModel", moving=False, simulated=False)
    listener = root.addObject("ContactListener", collisionModel1="@ball/collision/SphereCollisionModel",
                              collisionModel2=floor.TriangleCollisionModel.getLinkPath())
    turned = root.addObject("ContactListener", name="turned", collisionModel1="@floor/TriangleCollisionModel",
                            collisionModel2=sphere.SphereCollisionModel)
    root.addObject(Each(end=lambda step: solver.constraintForces.value))

    def check():
        assert ball.mstate.position.value[0] == approx([0.3, 1.1, 0.1, 0, 0, 0, 1], 1e-6) and root.CollisionResponse.contacts.value == 1
        # SOFA's lambda: of the normal and both tangents, times dt; the normal one holds the weight
        assert solver.constraintForces.value == approx([2 * 9.81 * 0.01, 0, 0], 1e-6) and solver.currentNumConstraints.value == 3
        assert listener.getNumberOfContacts() == 1 and listener.getDistances() == approx([0], 1e-9)
        (one, below, other, top), = listener.getContactPoints()  # the triangle first; the listener's first model is 0
        assert (one, other) == (1, 0) and top == approx([0.3, 0.1, 0.1], 1e-6) and below == approx([0.3, 0, 0.1], 1e-6)
        assert listener.getContactElements() == [(1, 1, 0, 0)]  # (0.3, 0, 0.1) is in the triangle 0 2 3
        assert turned.getContactElements() == [(0, 1, 1, 0)] and turned.getContactPoints()[0][2:] == (1, top)
        data = turned.getContactData()
        assert data["numberOfContacts"] == 1 and data["collisionElementsModel1"] == [1] and data["collisionPointsModel2"] == [top]
    return check


def a_contact_that_slides(root):
    """A particle slides down an oblique plane: the rows of its contact are SOFA's normal and tangents, and together its forces."""
    root.gravity, h, m, mu = [0, -10, 0], 0.01, 3.0, 0.25
    root.dt = h
    root.addObject("FreeMotionAnimationLoop")
    for kind in ("CollisionPipeline", "BruteForceBroadPhase", "BVHNarrowPhase"):
        root.addObject(kind)
    root.addObject("LocalMinDistance", alarmDistance=0.5, contactDistance=0.1)
    root.addObject("CollisionResponse", response="FrictionContactConstraint", responseParams=f"mu={mu}")
    solver = root.addObject("GenericConstraintSolver", name="cs", tolerance=1e-9, maxIterations=1000, computeConstraintForces=True)
    up = np.array([0.36, 0.8, 0.48])  # of length 1
    body, floor = root.addChild("body"), root.addChild("floor")
    body.addObject("EulerImplicitSolver")
    body.addObject("SparseLDLSolver")
    body.addObject("MechanicalObject", name="mo", position=[0.1 * up])
    body.addObject("UniformMass", totalMass=m)
    body.addObject("LinearSolverConstraintCorrection")
    body.addObject("PointCollisionModel")
    across = [np.cross(up, [0, 0, 1.0]), np.cross(up, np.cross(up, [0, 0, 1.0]))]
    floor.addObject("MeshTopology", position=[9 * a * across[0] + 9 * b * across[1] for a, b in ((-1, -2), (3, -1), (-1, 4))], triangles=[[0, 1, 2]])
    floor.addObject("MechanicalObject")
    floor.addObject("TriangleCollisionModel", moving=False, simulated=False)

    def check():
        weight = m * np.array(root.gravity.value)
        pushed = -(weight @ up) * up
        down = (weight + pushed) / np.linalg.norm(weight + pushed)
        rubbed = -mu * np.linalg.norm(pushed) * down
        assert body.mo.velocity.value[0] == approx(10 * h / m * (weight + pushed + rubbed), 1e-6)
        # UnilateralLagrangianConstraint: n from the triangle to the particle, t and s from its turned components; the forces are the
        # particle's
        n = up
        s = np.cross(n, [n[2], n[0], n[1]])
        s /= np.linalg.norm(s)
        rows = np.array(solver.constraintForces.value)
        assert rows == approx([h * (pushed + rubbed) @ each for each in (n, np.cross(s, n), s)], 1e-6) and rows[0] > 0
        assert np.hypot(rows[1], rows[2]) == approx(mu * rows[0], 1e-6)
    return check


def forces_of_contacts_on_nodes(root):
    """`lambda` of states is read and drawn: a ball on a soft body, which feels the opposite on its nodes."""
    root.dt, solver = 0.02, lagrangian(root)
    for kind in ("CollisionPipeline", "BruteForceBroadPhase", "BVHNarrowPhase", "DiscreteIntersection"):
        root.addObject(kind)
    root.addObject("CollisionResponse", response="FrictionContactConstraint", responseParams="mu=0.1")
    body = block(root)
    body.removeObject(body.CGLinearSolver)
    body.addObject("SparseLDLSolver")
    body.addObject("FixedProjectiveConstraint", indices=list(range(12)))
    body.addObject("LinearSolverConstraintCorrection")
    drawn = body.addChild("drawn").addObject("VisualVectorField", name="field", vectorScale="100", vector="@../mo.lambda", position="@../mo.position",
                                             color="orange", drawMode="Arrow")
    spheres = body.addChild("spheres")
    spheres.addObject("MechanicalObject", name="mo", position=[[1.5, 1, 1.8], [2, 0, 1.8]])
    spheres.addObject("SphereCollisionModel", radius=0.3)
    spheres.addObject("BarycentricMapping", input="@../mo", output="@mo")
    ball = root.addChild("ball")
    ball.addObject("EulerImplicitIntegrationScheme")
    ball.addObject("SparseLDLSolver")
    ball.addObject("MechanicalObject", name="mo", template="Rigid3d", position=[1.55, 2.3, 1.8, 0, 0, 0, 1])
    ball.addObject("UniformMass", totalMass=1)
    ball.addObject("SphereCollisionModel", radius=1.0)
    ball.addObject("UncoupledConstraintCorrection")
    seen, last = [], [np.zeros(3)]

    def end(step):
        on_ball, on_body = ball.mo.getData("lambda").value, body.mo.findData("lambda").value
        rows = solver.constraintForces.value
        assert on_body.shape == (36, 3) and np.linalg.norm(on_ball[0, :3]) == approx(np.linalg.norm(rows), 1e-9)
        assert on_body.sum(axis=0) == approx(-on_ball[0, :3], 1e-9)
        if len(rows):
            drawn.vector.value = -on_body
            drawn.vectorScale.value = 10 / np.max(rows)
            seen.append((on_ball[0, :3], last[0], np.array(ball.mo.velocity.value)[0, :3]))
        last[0] = np.array(ball.mo.velocity.value)[0, :3]
    root.addObject(Each(end=end))

    def check():
        assert len(seen) > 2
        for impulse, before, after in seen:
            assert impulse == approx(after - before + [0, 9.81 * 0.02, 0], 1e-9) and impulse[1] > 0, "what momentum lacks"
    return check


def calls_that_are_not_here(root):
    """Scenes ask for a call by hasattr() before they use it; addKToMatrix() with other arguments beside an addDForce()."""
    body = particle(root)
    modifier = body.addObject("TetrahedronSetTopologyModifier", name="modifier")
    shown = body.addObject("OglModel", name="shown")
    assert hasattr(modifier, "addPoints") and not hasattr(modifier, "setPoints") and not hasattr(shown, "setColor")
    assert hasattr(shown, "color") and hasattr(shown, "createTangents") and hasattr(modifier, "removeIsolated")
    try:
        modifier.removePoints([0])
        raise AssertionError("there is no container")
    except RuntimeError as error:
        assert "/body/modifier: there is no container beside it" in str(error)

    class Rest(Sofa.Core.ForceFieldVec3d):
        def init(self):
            self.start = self.mstate.position.array().copy()

        def addForce(self, m, force, position, velocity):
            with force.writeableArray() as f:
                f[:] += 100 * (self.start - position.value)

        def addDForce(self, m, df, dx):
            with df.writeableArray() as f:
                f[:] -= 100 * dx.value * m["kFactor"]

        def addKToMatrix(self, a, b):
            print("addKToMatrix: ", a, b)
    body.addObject(Rest(name="rest"))

    def check():
        y = v = 0.0
        for _ in range(10):  # implicit Euler of a mass of 2 at a spring of 100
            v = (v + 0.01 * (-9.81 - 50 * y)) / (1 + 0.01 ** 2 * 50)
            y += 0.01 * v
        assert body.mo.position.value[0] == approx([0, y, 0])
    return check


def rigid_bodies_by_vertex_mass(root):
    """STLIB's RigidObject written out: vertexMass of nested lists, translation2 and rotation2, a mesh of collision, a visual model."""
    def rigid(name, translation, rotation=(0., 0., 0.), totalMass=1., volume=1., inertiaMatrix=(1., 0., 0., 0., 1., 0., 0., 0., 1.)):
        node = root.addChild(name)
        node.addObject("EulerImplicitSolver", name="odesolver")
        node.addObject("CGLinearSolver", name="Solver", iterations=25, tolerance=1e-12, threshold=1e-14)
        node.addObject("MechanicalObject", name="mstate", template="Rigid3", translation2=translation, rotation2=list(rotation))
        node.addObject("UniformMass", name="mass", vertexMass=[totalMass, volume, list(inertiaMatrix)])
        node.addObject("UncoupledConstraintCorrection", compliance="1e-3 1e-3 0 0 1e-3 0 1e-3")
        collision = node.addChild("collision")
        collision.addObject("MeshOBJLoader", name="loader", filename="mesh/cube.obj", scale=1.0, triangulate=True)
        collision.addObject("MeshTopology", src="@loader")
        collision.addObject("MechanicalObject")
        for kind in ("Triangle", "Line", "Point"):
            collision.addObject(kind + "CollisionModel", group=0, contactStiffness=10, selfCollision=False)
        collision.addObject("RigidMapping")
        return node
    first, second = rigid("Cube", [0., 3., 0.]), rigid("Cube2", [5., 3, 0], [0, 90., 0.], 0.2, inertiaMatrix=(10., 0, 0, 0, 10., 0, 0, 0, 10.))
    first.mstate.velocity = [[0, 0, 0, 0, 0, 1]]

    def check():
        fallen = 3 - 9.81 * 0.01 ** 2 * 55
        assert first.mstate.position.value[0] == approx([0, fallen, 0, 0, 0, math.sin(0.05), math.cos(0.05)])
        assert second.mstate.position.value[0] == approx([5, fallen, 0, 0, math.sin(math.pi / 4), 0, math.cos(math.pi / 4)])
    return check


def frames_that_are_turned(root):
    """A class around a frame that writes its orientation, as splib's RigidDof; points that ride on it."""
    class RigidDof:
        def __init__(self, rigidobject):
            self.__dict__["rigidobject"] = rigidobject

        def __setattr__(self, key, value):
            data = self.rigidobject.getData("rest_position")
            data.value = [data.value[0].tolist()[:3] + list(value)]
    root.gravity.value = [0, 0, 0]
    n = root.addChild("n")
    solvers(n)
    mo = n.addObject("MechanicalObject", name="mo", template="Rigid3d", position=[[0, 0, 0, 0, 0, 0, 1]])
    n.addObject("UniformMass", totalMass=1)
    n.addObject("RestShapeSpringsForceField", stiffness=1e9, angularStiffness=1e9, points=0)
    points = n.addChild("points").addObject("MechanicalObject", name="p", position=[[1, 0, 0]])
    n.points.addObject("RigidMapping", index=0)
    frame = RigidDof(mo)
    root.addObject(Each(lambda step: setattr(frame, "orientation", [0, math.sin(0.05 * step), 0, math.cos(0.05 * step)])))

    def check():
        assert points.position.value[0] == approx([math.cos(1), 0, -math.sin(1)], 1e-4)
    return check


def springs_of_all_lists(root):
    """Rows, text and objects of Sofa.SofaDeformable as springs; a stiffness that a controller writes."""
    solvers(root)
    root.gravity = [0, 0, 0]
    a, b = root.addChild("a"), root.addChild("b")
    a.addObject("MechanicalObject", name="mo", position=[[0, 0, 0], [1, 0, 0]])
    a.addObject("UniformMass", totalMass=1)
    a.addObject("FixedConstraint", indices=[0, 1])
    b.addObject("MechanicalObject", name="mo", position=[[0, -1, 0], [1, -1, 0]])
    b.addObject("UniformMass", totalMass=2)
    root.addObject("StiffSpringForceField", object1=a.mo.getLinkPath(), object2="@b/mo", spring=[[0, 0, 50, 0, 0.9]])
    root.addObject("SpringForceField", name="text", object1=a.mo, object2=b.mo, spring="1 1 50 0 0.9")
    springs = [LinearSpring(index1=i, index2=i, springStiffness=50, dampingFactor=0, restLength=0.9) for i in range(2)]
    root.addObject("SpringForceField", name="objects", object1="@a/mo", object2="@b/mo", spring=springs)
    follower = b.addObject("RestShapeSpringsForceField", stiffness=[0], points=[0, 1])
    root.addObject(Each(lambda step: setattr(follower.stiffness, "value", [0.0])))

    def check():
        u = v = 0.0  # along the springs: two of 50 N/m on 1 kg, 0.1 m too long
        for _ in range(10):
            v = (v + 0.01 * 100 * (0.1 - u)) / (1 + 0.01 ** 2 * 100)
            u += 0.01 * v
        assert b.mo.position.value[:, 1] == approx([-1 + u] * 2) and b.mo.position.value[:, 0] == approx([0, 1])
    return check


def moduli_by_numpy(root):
    """A mesh read before it is used; cells chosen and moduli made by NumPy."""
    X = np.array(root.addChild("m").addObject("MeshVTKLoader", name="l", filename=MESH).position.value)
    T = np.asarray(root.m.l.findData("tetrahedra").value)
    stiff = np.where(X[T].mean(axis=1)[:, 0] > 40, 1000.0, 100.0)
    fixed = np.flatnonzero(X[:, 0] < X[:, 0].min() + 1e-6)
    n = root.addChild("n")
    n.addObject("EulerImplicitSolver")
    n.addObject("SparseLDLSolver", template="CompressedRowSparseMatrixMat3x3d")
    n.addObject("TetrahedronSetTopologyContainer", position=X, tetrahedra=T)
    n.addObject("MechanicalObject", name="mo", position=X.tolist())
    n.addObject("UniformMass", totalMass=0.1)
    n.addObject("TetrahedronFEMForceField", name="f", youngModulus=stiff, poissonRatio=0.4 * np.ones(1), method="large")
    n.addObject("FixedProjectiveConstraint", indices=fixed)
    n.addObject("ConstantForceField", indices=[int(np.argmax(X[:, 0]))], forces=[0, 0, 1])

    def check():
        assert np.array_equal(n.f.youngModulus.value, stiff) and np.array_equal(n.mo.position.value[fixed], X[fixed])
    return check


def chains_of_engines(root):
    """From a loader by a transformation and a region to moduli, a surface and pressures."""
    n = root.addChild("n")
    n.addObject("EulerImplicitSolver")
    n.addObject("SparseLDLSolver")
    n.addObject("MeshVTKLoader", name="loader", filename=MESH)
    n.addObject("TransformEngine", name="t", input_position="@loader.position", rotation=[0, 0, 90], translation="1 2 3", scale=[2, 2, 2])
    n.addObject("TetrahedronSetTopologyContainer", name="c", position="@t.output_position", tetrahedra="@loader.tetrahedra")
    n.addObject("MechanicalObject", name="mo", src="@c")
    n.addObject("UniformMass", totalMass=1.0)
    n.addObject("BoxROI", name="r", box=[-100, -1, -100, 100, 43, 100], position="@mo.rest_position", tetrahedra="@c.tetrahedra")
    n.addObject("IndexValueMapper", name="m", indices="@r.tetrahedronIndices", value=500.0, inputValues=[100.0] * len(n.loader.tetrahedra.value))
    n.addObject("TetrahedronFEMForceField", name="f", youngModulus="@m.outputValues", poissonRatio=0.4, method="large")
    n.addObject("FixedProjectiveConstraint", indices=n.r.indices.value)
    n.addObject("MergePoints", name="merged", position1="@mo.rest_position", position2=[[0, 0, 0]])
    n.addObject("ValuesFromIndices", name="chosen", template="Vec3d", indices=[2, 0], **{"in": "@loader.position"})
    n.addObject("MergeVectors", name="twice", template="vector<Vec3d>", nbInputs=2, input1="@chosen.out", input2=[[1, 2, 3]])
    n.addObject("ValuesFromIndices", name="numbers", template="double", indices=[1, 0], **{"in": [4.0, 5.0]})
    n.addObject("MergeMeshes", name="meshes", nbMeshes=2, position1="@loader.position", tetrahedra1="@loader.tetrahedra",
                position2=[[9, 9, 9]])
    s = n.addChild("s")
    s.addObject("TriangleSetTopologyContainer", name="c")
    s.addObject("TriangleSetTopologyModifier")
    s.addObject("Tetra2TriangleTopologicalMapping", input="@../c", output="@c")
    s.addObject("TrianglePressureForceField", name="p", pressure=[0, 0, -0.001], triangleList="0 1 2")
    X = n.loader.position.value
    assert n.t.output_position.value == approx(np.stack([1 - 2 * X[:, 1], 2 + 2 * X[:, 0], 3 + 2 * X[:, 2]], axis=1))

    def rows():  # values of a template are rows of it, before and after init
        assert n.chosen.out.value == approx(X[[2, 0]]) and n.chosen.indices.value.tolist() == [2, 0]
        assert n.twice.output.value == approx(np.vstack([X[[2, 0]], [[1, 2, 3]]])) and n.numbers.out.value.tolist() == [5, 4]
        assert n.meshes.position.value == approx(np.vstack([X, [[9, 9, 9]]]))
        assert n.meshes.tetrahedra.value.shape == n.loader.tetrahedra.value.shape
    rows()

    def check():
        rows()
        young = n.f.youngModulus.value
        assert sorted(set(young)) == [100, 500] and (young == 500).sum() == len(n.r.tetrahedronIndices.value) and len(n.merged.points.value) == 82
    return check


def laws_by_lists(root):
    """Hyperelastic laws with parameters as lists, text and tuples, on grids that are cut."""
    bodies = []
    for i, (law, parameters) in enumerate((("StVenantKirchhoff", [3448.27, 31034.4]), ("NeoHookean", "3448 31034"), ("MooneyRivlin", (1000.0, 100, 30000)))):
        n = root.addChild("n%d" % i)
        solvers(n, rayleighStiffness=0.1)
        n.addObject("RegularGridTopology", name="grid", n=[4, 3, 3], min=[i * 3, 0, 0], max=[i * 3 + 2, 1, 1])
        n.addObject("TetrahedronSetTopologyContainer", name="c", position="@grid.position")
        n.addObject("TetrahedronSetTopologyModifier")
        n.addObject("Hexa2TetraTopologicalMapping", input="@grid", output="@c")
        n.addObject("MechanicalObject", name="mo", position="@grid.position")
        n.addObject("MeshMatrixMass", totalMass=1, topology="@c")
        n.addObject("TetrahedronHyperelasticityFEMForceField", materialName=law, ParameterSet=parameters, topology="@c")
        n.addObject("FixedProjectiveConstraint", indices=[0, 4, 8])
        bodies.append(n)

    def check():
        for n in bodies:
            assert 0 < np.abs(n.mo.position.value - n.grid.position.value).max() < 0.1
    return check


def beams_and_their_skin(root):
    """Frames with beams between them, a tube of points that follows."""
    root.gravity = [0, -9.81, 0]
    n = root.addChild("beam")
    n.addObject("EulerImplicitSolver", rayleighStiffness=0.1, rayleighMass=0.1, printLog=False)
    n.addObject("BTDLinearSolver", template="BTDMatrix6d")
    places = [[i * 0.1, 0, 0] + [0, 0, 0, 1] for i in range(8)]
    n.addObject("MeshTopology", name="lines", lines=[[i, i + 1] for i in range(7)], position=[place[:3] for place in places])
    n.addObject("MechanicalObject", template="Rigid3d", name="DOFs", position=places, showObject=True, showObjectScale=0.1)
    n.addObject("UniformMass", totalMass=0.1)
    n.addObject("BeamFEMForceField", name="FEM", radius=0.01, youngModulus=1e8, poissonRatio=0.4, radiusInner="0")
    n.addObject("FixedProjectiveConstraint", indices=[0])
    n.addObject("PartialFixedProjectiveConstraint", indices=[3], fixedDirections=[0, 0, 1, 1, 1, 0])
    n.addObject("ConstantForceField", indices=[7], forces=[[0, 1, 0, 0, 0, 0]], showArrowSize=0.1)
    skin = n.addChild("skin")
    skin.addObject("CubeTopology", nx=8, ny=2, nz=2, min="0 -.01 -.01", max=".7 .01 .01")
    skin.addObject("MechanicalObject", name="mo")
    skin.addObject("BeamLinearMapping", isMechanical=True)

    def check():
        assert n.DOFs.position.value[0].tolist() == places[0] and n.DOFs.position.value[7][1] > 0
        assert skin.mo.position.value[:, 1].max() > n.DOFs.position.value[7][1]
    return check


def forces_in_python(root):
    """addForce() with writeableArray(); addKToMatrix() with rows (i, j, k), as a whole matrix of depth 1 and with nothing."""
    class Springs(Sofa.Core.ForceFieldVec3d):
        def __init__(self, *args, **kwargs):
            Sofa.Core.ForceFieldVec3d.__init__(self, *args, **kwargs)
            self.ks = kwargs.get("ks", 1.0)

        def init(self):
            self.start = self.mstate.position.array() + [0.1, 0, 0]

        def addForce(self, m, out_force, pos, vel):
            with out_force.writeableArray() as wa:
                wa[:] += (self.start - pos.value) * self.ks

        def addDForce(self, df, dx, params, bFactor):
            with df.writeableArray() as wa:
                wa[:] -= self.ks * dx.value * params["kFactor"]

        def addKToMatrix(self, mparams, nNodes, nDofs):  # nDofs: the numbers of one node
            return np.array([[nDofs * node + i, nDofs * node + i, -self.ks] for node in range(nNodes) for i in range(nDofs)], dtype=float)

    class Whole(Springs):
        def addKToMatrix(self, mparams, nNodes, nDofs):
            return -self.ks * np.eye(nNodes * nDofs)[:, :, None]

    class Constant(Sofa.Core.ForceFieldVec3d):
        def addForce(self, m, out_force, pos, vel):
            with out_force.writeableArray() as wa:
                wa += np.array([0, 0, 1.0])

        def addDForce(self, *arguments):
            pass

        def addKToMatrix(self, mparams, nNodes, nDofs):
            pass
    root.gravity = [0, 0, 0]
    pulled, pushed = particle(root, "pulled", mass=1), particle(root, "pushed", mass=1)
    others = [root.addChild(f"others{i}") for i in range(2)]
    for node, kind in zip(others, (Springs, Whole)):
        node.addObject("EulerImplicitSolver")
        node.addObject("SparseLDLSolver")
        node.addObject("MechanicalObject", name="mo", position=[[0, 0, 0], [1, 0, 0]])
        node.addObject("UniformMass", vertexMass=1)
        node.addObject(kind(name="springs", ks=5.0))
    pulled.addObject(Springs(name="springs", ks=5.0))
    pushed.addObject(Constant(name="constant"))

    def check():
        u = v = 0.0
        for _ in range(10):
            v = (v + 0.01 * 5 * (0.1 - u)) / (1 + 0.01 ** 2 * 5)
            u += 0.01 * v
        for node in others:
            assert node.mo.position.value == approx(np.array([[u, 0, 0], [1 + u, 0, 0]]))
        assert pulled.mo.position.value[0] == approx([u, 0, 0]) and pushed.mo.position.value[0] == approx([0, 0, 0.01 ** 2 * 55])
    return check


def parts_rigid_and_soft(root):
    """A mesh whose nodes are partly those of a soft body and partly those of a frame, by SubsetMultiMapping and two parents."""
    lagrangian(root)
    sim = root.addChild("sim")
    sim.addObject("EulerImplicitSolver")
    sim.addObject("SparseLDLSolver")
    sim.addObject("GenericConstraintCorrection")
    loader = root.addObject("MeshVTKLoader", name="l", filename=MESH)
    X = loader.position.value
    held = [i for i, place in enumerate(X) if place[0] < 21]
    free = [i for i in range(len(X)) if i not in held]
    soft_part, rigid = sim.addChild("DeformableParts"), sim.addChild("RigidParts")
    soft_part.addObject("MechanicalObject", template="Vec3", name="dofs", position=[X[i].tolist() for i in free])
    rigid.addObject("MechanicalObject", template="Rigid3", name="dofs", position=[[10, 10, 10, 0, 0, 0, 1]])
    rigid.addObject("RestShapeSpringsForceField", stiffness=1e9, angularStiffness=1e9)
    particles = rigid.addChild("RigidifiedParticules")
    particles.addObject("MechanicalObject", template="Vec3", name="dofs", position=[X[i].tolist() for i in held])
    particles.addObject("RigidMapping", globalToLocalCoords=True, rigidIndexPerPoint=[0] * len(held))
    pairs = np.zeros((len(X), 2), int)
    for part, nodes in enumerate((free, held)):
        for k, i in enumerate(nodes):
            pairs[i] = [part, k]
    body = soft_part.addChild("body")
    particles.addChild(body)
    body.addObject("TetrahedronSetTopologyContainer", name="c", src=loader.getLinkPath())
    body.addObject("MechanicalObject", name="mo", template="Vec3")
    body.addObject("UniformMass", totalMass=0.1)
    body.addObject("TetrahedronFEMForceField", youngModulus=1000, poissonRatio=0.4)
    body.addObject("SubsetMultiMapping", template="Vec3,Vec3", input=["@" + soft_part.dofs.getPathName(), "@" + particles.dofs.getPathName()],
                   output="@./mo", indexPairs=pairs.tolist())

    def check():
        assert body.mo.position.value[free] == approx(soft_part.dofs.position.value) and body.mo.position.value[held] == approx(X[held], 1e-5)
        assert (body.mo.position.value[free] - X[free])[:, 1].min() < -1e-4
    return check


def what_writes_files(root):
    """Monitors, exporters and recorders with SOFA's attributes of every kind."""
    n = block(root)
    n.addObject("Monitor", name="mon", template="Vec3d", listening=1, indices=[0, 1], showPositions=1, PositionsColor=[1, 0, 0, 1], ExportPositions=True,
                ExportVelocities=True, ExportForces=True, showTrajectories=True, sizeFactor=1, fileName="mon")
    n.addObject("VTKExporter", filename="vtk", listening=True, edges=0, triangles=0, tetras=0, hexas=1, quads=0, XMLformat=True,
                exportEveryNumberOfSteps=2, exportAtBegin=False, exportAtEnd=True, pointsDataFields="mo.position", overwrite=True)
    n.addObject("WriteState", filename="state.txt", writeX=True, writeV=True, writeX0=False, time=0, interval=0.02, period=0.02)

    def check():
        names = os.listdir()
        assert all(any(name.startswith(word) for name in names) for word in ("mon", "vtk", "state")), names
    return check


def steps_while_it_is_built(root):
    """init() of loaders and nodes, Sofa.Simulation.init() and steps before createScene() has ended."""
    n = root.addChild("n")
    solvers(n)
    loader = n.addObject("MeshVTKLoader", name="l", filename=MESH)
    loader.init()
    topology = n.addObject("MeshTopology", name="t", src=loader.linkpath)
    topology.init()
    assert (len(loader.position.value), topology.getNbPoints(), topology.getNbTetrahedra()) == (81, 81, len(topology.tetrahedra.value))
    mo = n.addObject("MechanicalObject", name="mo")
    mo.init()
    n.init()
    n.addObject("UniformMass", totalMass=1)
    Sofa.Simulation.init(root)
    Sofa.Simulation.animate(root, 0.01)
    Sofa.Simulation.animateNSteps(root, 3, 0.01)
    assert mo.position.value[0][1] == approx(-9.81 * 0.01 ** 2 * 10)
    return lambda: np.isfinite(mo.position.value).all()


def approx(expected, tolerance=1e-9):
    import pytest

    return pytest.approx(expected, rel=tolerance, abs=tolerance)


SCENES = [made for name, made in list(globals().items()) if getattr(made, "__module__", None) == __name__ and made.__doc__
          and name not in ("Each",)]
