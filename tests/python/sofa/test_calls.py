# SPDX-License-Identifier: LGPL-2.1-or-later
"""Calls of SofaPython3, and of SofaPython before it, that few scenes use: each does what its documentation says."""
import os
import subprocess
import sys

import numpy as np
import pytest
import Sofa
import SofaRuntime
import stroma
from playing import PATIENCE


def falling(node, name="dofs", **values):
    node.addObject("EulerExplicitSolver")
    state = node.addObject("MechanicalObject", name=name, **{"position": [[0, 0, 0], [1, 0, 0]], **values})
    node.addObject("UniformMass", totalMass=1)
    return state


@pytest.fixture
def root():
    made = Sofa.Core.Node("root")
    made.addObject("DefaultAnimationLoop")
    return made


def test_where_things_come_from(root):
    line = sys._getframe().f_lineno + 1
    body = root.addChild("body")
    for name, place in (("Definition", __file__), ("Instanciation", __file__)):
        assert getattr(body, f"get{name}SourceFilePos")() == line
        assert getattr(body, "getInstanciationFileName" if name == "Instanciation" else "getDefinitionSourceFileName")() == place
        getattr(body, f"set{name}SourceFileName")("other.py"), getattr(body, f"set{name}SourceFilePos")(7)
    assert body.getDefinitionSourceFileName() == body.getInstanciationSourceFileName() == "other.py"
    assert body.getDefinitionSourceFilePos() == body.getInstanciationSourceFilePos() == 7
    root.setDefinitionSourceFilePos(3)
    assert root.getInstanciationSourceFilePos() != 3


def test_messages_of_an_object(root, capsys):
    body = root.addChild("body")
    Sofa.Helper.msg_warning(body, "one"), Sofa.Helper.msg_error(body, "two", "file.py", 3)
    Sofa.Helper.msg_error("three", "file.py", 3)
    assert body.countLoggedMessages() == 2 and root.countLoggedMessages() == 0
    assert body.getLoggedMessagesAsString() == "[WARNING] one\n[ERROR] two"
    body.clearLoggedMessages()
    assert body.countLoggedMessages() == 0 and body.getLoggedMessagesAsString() == ""
    assert capsys.readouterr().err.splitlines() == ["[WARNING] [/body] one", "[ERROR] [/body] two", "[ERROR] [SofaPython3] three"]
    with pytest.raises(TypeError, match="1 to 4"):
        Sofa.Helper.msg_error()


def test_links_of_data(root):
    a, b = falling(root.addChild("a")), root.addChild("b").addObject("MechanicalObject", name="dofs")
    assert a.position.linkpath.isPointingToData() and not a.linkpath.isPointingToData()
    b.findData("position").setParent(a.findData("position"))
    data = b.findData("position")
    assert data.getLinkedPath() == "@/a/dofs.position" and data.getLinkedData() is a.findData("position") and not data.isMultiLink()
    assert data.getOwnerBase() is b and data.getLinkedBase() is a and data in b.getLinks()
    link = b.addLink("friend", value=a)
    assert link.getLinkedBase() is a and link.getLinkedPath() in ("@/a/dofs", str(a.getLinkPath()))
    link.setLinkedBase(root)
    assert link.getLinkedBase() is root


def test_data_that_change(root):
    source = root.addData("source", value=1.0)
    data = root.addData("data", value=2.0)
    assert not data.hasChanged() and not data.isDirty() and data.getValue() == 2.0
    data.setParent(source)
    assert data.hasChanged() and not data.hasChanged()
    before = source.getCounter()
    source.value = 5.0
    assert source.getCounter() > before and data.hasChanged() and not data.hasChanged() and data.value == 5.0
    assert data.isPersistent() and not data.isReadOnly() and not data.isRequired()
    data.setPersistent(False), data.setReadOnly(True)
    assert data.isReadOnly() and not data.isPersistent()
    data.setReadOnly(False), data.setPersistent(True)
    assert not data.isReadOnly() and data.isPersistent()
    data.setHelp("what it is")
    assert data.getHelp() == "what it is"


def test_data_as_their_values(root):
    number, text, numbers = root.addData("n", value=2.5), root.addData("t", value="word"), root.addData("v", value=[1.0, 4.0])
    assert float(number) == 2.5 and int(number) == 2 and f"{number:.2f}" == "2.50" and bool(number) and f"{text:>6}" == "  word"
    assert number < 3 and number <= 2.5 and number > 2 and number >= 2.5 and not number < 1
    doubled = numbers.value * 2
    assert type(doubled) is np.ndarray and doubled.tolist() == [2, 8] and float(np.sum(numbers.value)) == 5
    part = numbers.value[1:]
    part[0] = 7
    assert numbers.value.tolist() == [1, 7]
    assert numbers.getValue(1) == 7 and not root.addData("empty", value=[])


def test_boxes(root):
    falling(root.addChild("body"))
    box = root.addData("bbox", value=[[0, 0, 0], [1, 1, 1]])
    assert isinstance(box, Sofa.Types.BoundingBox)
    box.setMin([-1, 0, 0]), box.setMax([3, 2, 1])
    assert (box.getMin(), box.getMax(), box.getCenter()) == ([-1, 0, 0], [3, 2, 1], [1, 1, 0.5])
    body = root.body
    body.computeBBox(), body.dofs.computeBBox()
    assert body.bbox.getMax() == [1, 0, 0]


def test_what_a_node_tells(root, capsys):
    body = root.addChild("body")
    state = falling(body)
    mesh = body.addObject("MeshTopology", edges=[[0, 1]], position="@dofs.position")
    assert not root.isInitialized() and body.getObjects()[0].getClassName() == "EulerExplicitSolver"
    assert body.getMeshTopologyLink() is body.getMeshTopology() is mesh and mesh.getNbLines() == mesh.getNbEdges() == 1
    root.setGravity([0, 0, -2])
    assert body.getGravity().tolist() == [0, 0, -2]
    root.setAnimate(True)
    assert root.getAnimate() and body.getAnimate() and not body.isSleeping()
    body.setActive(False)
    assert not body.isActive() and not body.activated.value
    body.setActive(True)
    body.setSleeping(True)
    assert body.isSleeping() and "do not sleep" in capsys.readouterr().err
    other = root.addChild("other")
    child = body.addChild("child")
    other.moveChild(child, body)
    assert child.getParents() == [other] and not body.hasChild("child")
    other.children.remove_at(0)
    assert len(other.children) == 0 and child.getParents() == []
    assert state.getClass() is type(state) and state.getTarget() == "MechanicalObject"
    root.simulationStep(0.25)
    assert root.isInitialized() and root.getTime() == pytest.approx(0.25)


def test_who_belongs_to_whom(root):
    class Helper(Sofa.Core.Controller):
        pass

    one, two = root.addObject(Helper(name="one")), root.addObject(Helper(name="two"))
    assert one.getSlaves() == [] and one.getMaster() is None
    one.addSlave(two)
    assert one.getSlaves() == [two] and two.getMaster() is one


def test_source_of_a_topology(root, folder):
    (folder / "two.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    loader = root.addObject("MeshOBJLoader", name="loader", filename=str(folder / "two.obj"))
    mesh = root.addObject("MeshTopology", name="mesh")
    mesh.setSrc("@loader", loader)
    assert len(mesh.triangles.value) == 1 and mesh.getNbPoints() == 3


def test_reset_comes_back_to_a_stored_state(root):
    state = falling(root, position=[[0, 5, 0]])
    Sofa.Simulation.init(root)
    Sofa.Simulation.animateNSteps(root, 4, 0.1)
    there, speed = state.position.value.copy(), state.velocity.value.copy()
    state.storeResetState()
    Sofa.Simulation.animateNSteps(root, 3, 0.1)
    once = state.position.value.copy()
    Sofa.Simulation.reset(root)
    assert np.array_equal(state.position.value, there) and np.array_equal(state.velocity.value, speed) and there[0][1] < 5
    Sofa.Simulation.animateNSteps(root, 3, 0.1)
    assert state.position.value == pytest.approx(once, abs=1e-12)


def test_an_episode_whose_step_fails(root):
    """It ends by an exception with the last good state, and the next one begins after a reset."""
    body = root.addChild("body")
    state = falling(body, position=[[0, 0, 0], [1.5, 0, 0]])
    spring = body.addObject("SpringForceField", spring=[[0, 1, 1, 0, 1]])
    root.gravity, root.dt = [0, 0, 0], 0.5
    Sofa.Simulation.init(root)

    def episode(stiffness, steps):
        spring.spring = [[0, 1, stiffness, 0, 1]]
        for _ in range(steps):
            Sofa.Simulation.animate(root, root.dt.value)
        return state.position.value.copy()

    good = episode(1, 20)
    for _ in range(2):
        Sofa.Simulation.reset(root)
        with pytest.raises(stroma.StepError, match="step"):
            episode(1e12, 1000)
        assert np.isfinite(state.position.value).all()
        Sofa.Simulation.reset(root)
        assert np.array_equal(episode(1, 20), good)


def test_folders_of_files(folder, monkeypatch, capsys):
    monkeypatch.delenv("STROMA_DATA_PATH", raising=False)
    (folder / "meshes").mkdir()
    (folder / "meshes" / "a.obj").write_text("")
    folders = SofaRuntime.DataRepository
    assert not folders.findFile("a.obj") and folders.getFile("a.obj") == "a.obj" and folders.getFirstPath() == ""
    folders.addFirstPath("meshes"), folders.addLastPath(str(folder / "last"))
    assert folders.getPaths() == [str(folder / "meshes"), str(folder / "last")] and folders.getFirstPath() == str(folder / "meshes")
    assert folders.findFile("a.obj") and os.path.samefile(folders.getFile("a.obj"), folder / "meshes" / "a.obj")
    assert folders.findFileFromFile("a.obj", str(folder / "meshes" / "b.obj")) and not folders.findFile("b.obj")
    assert folders.getPathsJoined() == os.pathsep.join(folders.getPaths()) and folders.entrySeparator() == os.pathsep
    folders.print()
    assert capsys.readouterr().out.strip() == folders.getPathsJoined()
    assert folders.relativeToPath(str(folder / "meshes" / "a.obj"), str(folder)) == os.path.join("meshes", "a.obj")
    folders.removePath("meshes")
    assert folders.getPaths() == [str(folder / "last")]
    folders.clear()
    assert folders.getPaths() == []
    assert Sofa.Helper.System.FileRepository("SOFA_DATA_PATH").getPaths() == [] and Sofa.Helper.GetVersion() == Sofa.version


def test_timers_measure_nothing():
    assert not SofaRuntime.Timer().isEnabled("Animate")
    with pytest.raises(KeyError, match="--profile"):
        SofaRuntime.Timer().getRecords("Animate")["solve"]


def test_the_window(root, folder, capsys):
    gui = Sofa.Gui.GUIManager
    assert gui.ListSupportedGUI() == ["stroma"] and gui.ListSupportedGUI(",") == "stroma" and gui.createGUI(root, __file__) == 0
    gui.GetGUI().setBackgroundImage("clouds.png")
    gui.SaveScreenshot("early.png")
    assert "is not written" in capsys.readouterr().err and not (folder / "early.png").exists()
    falling(root)
    Sofa.Simulation.init(root)
    gui.SetScene(root, filename=__file__)
    gui.SaveScreenshot(str(folder / "shot.png"))
    assert (folder / "shot.png").read_bytes()[:4] == b"\x89PNG"


def test_prefabs_of_files(root):
    class Ball(Sofa.Prefab):
        prefabParameters = [{"name": "radius", "type": "double", "help": "", "default": 2.0}]

        def init(self):
            self.setSourceTracking(__file__)
            self.addObject("MechanicalObject", position=[[self.radius.value, 0, 0]])

    ball = root.addChild(Ball(name="ball"))
    assert ball.MechanicalObject.position.value[0][0] == 2 and ball.prefabname.value == "Ball"


def test_calls_without_a_meaning_here_are_refused(root):
    """A call that does nothing would hide what a scene needs."""
    for thing, names in ((root, "executeVisitor propagateEvent getTreeNode addParent addNewChild moveObject getNameAsString"),
                         (Sofa.Simulation, "createRoot setRoot loadFromFile exportXML"), (Sofa.Core, "CreateNode"),
                         (root.addData("d", value=1.0), "setDirty isDisplayed setGroup"), (SofaRuntime, "getMainFactory")):
        for name in names.split():
            with pytest.raises(AttributeError):
                getattr(thing, name)


def test_numbers_of_libraries(root):
    from splib3.animation.easing import LinearRamp
    from splib3.numerics import RigidDof, Transform, sadd, sdiv, smul, ssub, vadd, vsub
    from splib3.numerics.vec3 import Vec3
    from splib3.utils import deprecated_alias
    from stlib3.solver import DefaultSolver
    from stlib3.visuals import ShowGrid, VisualModel

    assert LinearRamp(1, 3, 0.25) == 1.5 and LinearRamp(2, 2) == 2
    assert vadd([1, 2, 3], [4, 5, 6]) == [5, 7, 9] and vsub([1, 2, 3], [4, 5, 7]) == [-3, -3, -4]
    assert (sadd([1, 2, 3], 1), ssub([1, 2, 3], 1), smul([1, 2, 3], 2), sdiv([2, 4, 6], 2)) == ([2, 3, 4], [0, 1, 2], [2, 4, 6], [1, 2, 3])
    assert np.array(Vec3(1, 0, 0).rotateFromAxisAngle([0, 0, 1], np.pi / 2)) == pytest.approx(np.array([0, 1, 0]), abs=1e-15)
    assert Transform([1, 2, 3]).toSofaRepr() == [1, 2, 3, 0, 0, 0, 1]
    half = np.sqrt(0.5)  # a quarter about z: x to y
    frame = RigidDof(root.addObject("MechanicalObject", template="Rigid3d", position=[[0, 0, 0, 0, 0, half, half]]))
    assert frame.getLeft() == pytest.approx([0, 1, 0], abs=1e-15) and frame.getUp() == pytest.approx([-1, 0, 0], abs=1e-15)

    @deprecated_alias(old="new")
    def named(new=0):
        return new

    assert named(old=3) == named(new=3) == 3
    direct, iterative = root.addChild("direct"), root.addChild("iterative")
    assert DefaultSolver(direct, iterative=False).getClassName() == "SparseLDLSolver"
    assert DefaultSolver(iterative).getClassName() == "CGLinearSolver" and direct.TimeIntegrationSchema.getClassName() == "EulerImplicitSolver"
    ShowGrid(root)
    (visual := root.addChild("v")).addChild(VisualModel(visualMeshPath="a.stl")).showGrid(5)
    assert root.hasObject("OglGrid") and visual.VisualModel.OglGrid.nbSubdiv.value in (5, "5")


def program(text, folder, *paths):
    here = [path for path in os.environ["PYTHONPATH"].split(os.pathsep) if path]
    return subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, timeout=PATIENCE, cwd=folder,
                          env={**os.environ, "PYTHONPATH": os.pathsep.join([*here, *map(str, paths)])})


@pytest.mark.parametrize("name,part", [("stlib3", "physics.deformable"), ("splib3", "numerics"), ("softrobots", "actuators"), ("cosserat", "CosseratBase"),
                                       ("useful", "params")])
def test_libraries_before_sofa(name, part, folder):
    done = program(f"import {name}.{part}\nimport Sofa\nfrom Sofa import _libraries\nprint(_libraries.stands_in('{name}'))", folder)
    assert (done.returncode, done.stdout.strip()) == (0, "True"), done.stderr
    # two folders of these packages on the path, as of a build and of an installation
    (folder / "twice").mkdir()
    for one in (f"{name}.py", "Sofa", "SofaRuntime", "SofaTypes"):
        (folder / "twice" / one).symlink_to(os.path.join(os.path.dirname(os.path.dirname(Sofa.__file__)), one))
    done = program(f"import {name}.{part}", folder, folder / "twice")
    assert done.returncode == 0, done.stderr
    # the library itself, wherever it is on the path
    (folder / "lib" / name).mkdir(parents=True)
    (folder / "lib" / name / "__init__.py").write_text("own = 3\n")
    (folder / "lib" / name / "part.py").write_text("value = 4\n")
    done = program(f"import {name}.part, {name}\nprint({name}.own, {name}.part.value)\nimport Sofa\nimport {name}.part", folder, folder / "lib")
    assert (done.returncode, done.stdout.strip(), done.stderr) == (0, "3 4", "")
