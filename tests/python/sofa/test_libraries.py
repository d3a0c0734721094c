# SPDX-License-Identifier: LGPL-2.1-or-later
"""Libraries that scenes import and that come with Stroma where no folder has them: rotations against scipy, scenes that they build."""
import itertools
import os
import subprocess
import sys

import numpy as np
import pytest
from playing import PATIENCE, SCENES, animate

Rotation = pytest.importorskip("scipy.spatial.transform").Rotation
MESH = SCENES / "data" / "mesh"


def bar(file):
    """Three cubes in a row along x, from -1 to 2, each cut into six tetrahedra."""
    places = [(x - 1, y, z) for z in range(2) for y in range(2) for x in range(4)]
    corner = lambda x, way: places.index((x - 1 + way[0], *way[1:]))  # noqa: E731
    cells = []
    for x in range(3):
        for order in itertools.permutations(range(3)):
            ways = [(0, 0, 0)]
            for axis in order:
                ways.append(tuple(each + (k == axis) for k, each in enumerate(ways[-1])))
            even = order in ((0, 1, 2), (1, 2, 0), (2, 0, 1))
            cells.append([corner(x, ways[k]) + 1 for k in ((0, 1, 2, 3) if even else (0, 2, 1, 3))])
    nodes = "".join(f"{k + 1} {x} {y} {z}\n" for k, (x, y, z) in enumerate(places))
    lines = "".join(f"{k + 1} 4 2 0 1 {' '.join(map(str, cell))}\n" for k, cell in enumerate(cells))
    file.write_text(f"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{len(places)}\n{nodes}$EndNodes\n"
                    f"$Elements\n{len(cells)}\n{lines}$EndElements\n")
    return str(file)


def root_node():
    import Sofa

    root = Sofa.Core.Node("root")
    root.addObject("DefaultAnimationLoop")
    return root


def test_rotations_are_those_of_scipy():
    import Sofa  # noqa: F401
    from splib3.numerics import Quat, Vec3
    from splib3.numerics.quat import AXES

    assert len(AXES) == 24
    generator = np.random.default_rng(5)
    for axes in AXES:
        for angles in generator.uniform(-1.4, 1.4, (4, 3)):
            turn = Rotation.from_euler(axes[1:] if axes[0] == "s" else axes[1:].upper(), angles)
            q = Quat.createFromEuler(angles, axes)
            np.testing.assert_allclose(q.getMatrix(), turn.as_matrix(), atol=1e-14)
            np.testing.assert_allclose(Quat.createFromEuler(q.getEulerAngles(axes), axes).getMatrix(), turn.as_matrix(), atol=1e-13)
    a, b = Rotation.from_rotvec([0.3, -0.8, 0.5]), Rotation.from_rotvec([1.0, 0.2, -0.4])
    qa, qb = Quat(a.as_quat()), Quat(b.as_quat())
    np.testing.assert_allclose(Quat.product(qa, qb).getMatrix(), (a * b).as_matrix(), atol=1e-14)
    np.testing.assert_allclose(qa.rotate([1, 2, 3]), a.apply([1, 2, 3]), atol=1e-14)
    axis, angle = qa.getAxisAngle()
    np.testing.assert_allclose(axis * angle, a.as_rotvec(), atol=1e-14)
    np.testing.assert_allclose(Quat.product(qa, qa.getInverse()), [0, 0, 0, 1], atol=1e-14)
    np.testing.assert_allclose(Vec3(1, 2, 3).rotateFromQuat(qb), b.apply([1, 2, 3]), atol=1e-14)
    v, w = Vec3(1, 2, 3), Vec3(3, 0, -1)
    turned = Quat.createFromVectors(v, w).rotate(w)
    np.testing.assert_allclose(turned / np.linalg.norm(turned), v / v.getNorm(), atol=1e-14)
    assert Quat(0, 0, 0, -1).flip() == Quat() and Vec3(2.0) == [2, 2, 2] and Vec3([1, 2, 3]).toList() == [1, 2, 3]
    np.testing.assert_allclose(Quat.createFromEuler([0, 0, 90], inDegree=True), np.sqrt([0, 0, 0.5, 0.5]))


def test_the_angles_of_a_turn_without_a_unique_answer_give_it_back():
    import Sofa  # noqa: F401
    from splib3.numerics import Quat
    from splib3.numerics.quat import AXES

    for axes in AXES:
        for second in (0.0, np.pi / 2, -np.pi / 2):
            q = Quat.createFromEuler([0.4, second, -0.9], axes)
            np.testing.assert_allclose(Quat.createFromEuler(q.getEulerAngles(axes), axes).getMatrix(), q.getMatrix(), atol=1e-7)


def test_boxes_and_points_that_are_moved():
    import Sofa  # noqa: F401
    from splib3.numerics import RigidDof, getOrientedBoxFromTransform, to_radians, transformPositions

    moved = transformPositions([[1, 0, 0], [0, 2, 0]], translation=[1, 2, 3], eulerRotation=[0, 0, 90], scale=[2, 3, 4])
    np.testing.assert_allclose(moved, [[1, 4, 3], [-5, 2, 3]], atol=1e-14)
    assert getOrientedBoxFromTransform(scale=[2, 3, 4]) == [[-1, 0, -2], [-1, 0, 2], [1, 0, 2], 3]
    assert to_radians([180.0, 90.0]) == [np.pi, np.pi / 2]
    root = root_node()
    frame = RigidDof(root.addObject("MechanicalObject", template="Rigid3", position=[[1, 2, 3, 0, 0, 0, 1], [0, 0, 0, 0, 0, 0, 1]]))
    frame.translate([1, 0, 0])
    frame.rotateAround([0, 0, 1], np.pi / 2)
    np.testing.assert_allclose(frame.position, [2, 2, 3])
    np.testing.assert_allclose(frame.orientation, np.sqrt([0, 0, 0.5, 0.5]))
    np.testing.assert_allclose(frame.left, [0, 1, 0], atol=1e-14)
    frame.setPosition([7, 8, 9], index=1)
    np.testing.assert_allclose(frame.getPosition(1), [7, 8, 9])


def test_animations_go_forth_back_and_anew():
    """The time of a manager is dt in the first step, where what starts has the factor 0."""
    import Sofa
    from splib3.animation import AnimationManager, animate as start

    root, seen = root_node(), {}
    root.dt = 0.25
    root.addObject(AnimationManager(root))
    for mode in ("once", "loop", "pingpong"):
        start(lambda factor, mode: seen.setdefault(mode, []).append(factor), {"mode": mode}, 0.5, mode=mode,
              onDone=lambda factor, mode: seen[mode].append("done"))
    Sofa.Simulation.init(root)
    animate(root, 7)
    assert seen["once"] == [0, 0.5, 1, "done"]
    assert seen["loop"] == [0, 0.5, 1, 0, 0.5, 1, 0]
    assert seen["pingpong"] == [0, 0.5, 1, 1, 0.5, 0, 0]


def test_animations_that_follow_one_another():
    """What the end of one starts has the factor 0 in the same step; what a callback takes out is not called again."""
    import Sofa
    from splib3 import animation

    root, seen = root_node(), []
    root.dt = 0.25
    root.addObject(animation.AnimationManager(root))

    def link(name, follower=None):
        animation.animate(lambda factor: seen.append((step, name, factor)), {}, 0.5,
                          onDone=lambda factor: follower and link(*follower))

    link("a", ("b", ("c",)))
    once = animation.Animation(5, "loop", lambda factor: (seen.append((step, "once", factor)), animation.removeAnimation(once)))
    animation.manager.addAnimation(once)
    ends = animation.Animation(0.25, "once", lambda factor: None, onDone=lambda factor: animation.removeAnimation(ends))
    animation.manager.addAnimation(ends)
    Sofa.Simulation.init(root)
    for step in range(1, 8):
        animate(root, 1)
    assert [each[:2] for each in seen if each[1] == "once"] == [(1, "once")]
    assert [each for each in seen if each[1] != "once"] == [
        (1, "a", 0), (2, "a", 0.5), (3, "a", 1), (3, "b", 0), (4, "b", 0.5), (5, "b", 1), (5, "c", 0), (6, "c", 0.5), (7, "c", 1)]
    assert animation.manager.animations == []


def test_a_body_with_all_that_holds_and_touches_it(tmp_path):
    import Sofa
    from splib3.objectmodel import setData, setTreeData
    from splib3.scenegraph import find, get
    from stlib3.components import addOrientedBoxRoi
    from stlib3.physics.collision import CollisionMesh
    from stlib3.physics.constraints import FixedBox, PartiallyFixedBox, SubTopology
    from stlib3.physics.deformable import ElasticMaterialObject
    from stlib3.scene import ContactHeader, MainHeader, Node
    from stlib3.scene.mainheader import MainHeader as same

    assert same is MainHeader
    root = Sofa.Core.Node("scene")
    MainHeader(root, gravity=[0, 0, -9.81], plugins=["SoftRobots"])
    ContactHeader(root, alarmDistance=0.1, contactDistance=0.01, frictionCoef=0.5)
    body = ElasticMaterialObject(attachedTo=Node(root, "world"), volumeMeshFileName=bar(tmp_path / "bar.msh"), name="bar",
                                 totalMass=2.0)
    assert body.node is body and root.world.bar is body and find(root, "/scene/world/bar/dofs") is body.dofs
    FixedBox(applyTo=body, atPositions=[-1.1, -1, -1, -0.9, 2, 2])
    PartiallyFixedBox(attachedTo=body, box=[-2, -1, -1, 5, 2, 2], fixedAxis=[0, 1, 0])
    box = addOrientedBoxRoi(body, position=[list(each) for each in body.dofs.rest_position.value], translation=[0, -1, 0],
                            scale=[2.5, 8, 8])
    SubTopology(attachedTo=body, containerLink="@../container.position", boxRoiLink="@../" + box.name.value + ".tetrahedraInROI",
                youngModulus=5e4)
    CollisionMesh(attachedTo=body, surfaceMeshFileName=str(MESH / "box.obj"), collisionGroup=1)
    setData(body.forcefield, youngModulus=2e4)
    setTreeData(root, "bar/mass", totalMass=4.0)
    assert get(root, "world/bar/mass.totalMass").value == 4.0 and get(root, "world/bar").mass is body.mass
    Sofa.Simulation.init(root)
    start = np.array(body.dofs.position.value)
    animate(root, 5)
    moved = body.dofs.position.value - start
    held = start[:, 0] < -0.9
    assert np.abs(moved[held]).max() < 1e-9 and np.abs(moved[~held]).max() > 1e-4
    assert np.abs(moved[:, 1]).max() < 1e-9


def test_a_scene_with_settings_and_rigid_bodies():
    import Sofa
    from stlib3.physics.rigid import Cube
    from stlib3.scene import Scene

    root = Sofa.Core.Node("root")
    scene = Scene(root, gravity=[0.0, 0.0, -10.0], dt=0.1, plugins=["SofaSparseSolver"], iterative=False)
    scene.addMainHeader()
    scene.addObject("FreeMotionAnimationLoop")
    scene.addObject("GenericConstraintSolver")
    scene.Settings.mouseButton.stiffness = 10
    scene.VisualStyle.displayFlags = "showBehavior"
    cube = Cube(scene.Modelling, surfaceMeshFileName=str(MESH / "box.obj"), translation=[0.0, 0.0, 5.0], totalMass=2.0)
    Sofa.Simulation.init(root)
    animate(root, 2)
    np.testing.assert_allclose(cube.mstate.position.value[0][:3], [0, 0, 5 - 10 * 0.1**2 * 3])


PROGRAM = """
import Sofa, Sofa.Core, sys
from stlib.scene import MainHeader
from splib.animation import animate, AnimationManager
import splib3.animation, stlib3.scene
assert stlib3.scene.MainHeader is MainHeader and splib3.animation.animate is animate
root, seen = Sofa.Core.Node("root"), []
MainHeader(root, gravity=[0, 0, 0])
animate(lambda factor: seen.append(factor), {}, 1.0)
Sofa.Simulation.init(root)
Sofa.Simulation.animate(root, 0.01)
assert seen == [0], seen
"""


def program(text, **environment):
    return subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, timeout=PATIENCE, env={**os.environ, **environment})


def test_old_names_are_the_same_modules():
    done = program(PROGRAM)
    assert done.returncode == 0, done.stderr
    never = "in SOFA's Python 3 they never would"
    assert done.stderr.count(never) == 1, "nothing adds the manager"
    added = program(PROGRAM.replace("Sofa.Simulation.init(root)", "root.addObject(splib3.animation.manager)\nSofa.Simulation.init(root)"))
    assert added.returncode == 0 and never not in added.stderr, added.stderr
    assert "the library stlib3 of SOFA's plugin STLIB is not on PYTHONPATH: functions of its names come with Stroma" in done.stderr


def test_a_library_of_the_path_counts_first(tmp_path):
    (tmp_path / "stlib3").mkdir()
    (tmp_path / "stlib3" / "__init__.py").write_text("whose = 'ours'\n")
    for path in (f"{tmp_path}:{os.environ['PYTHONPATH']}", f"{os.environ['PYTHONPATH']}:{tmp_path}"):
        done = program("import Sofa, stlib3; print(stlib3.whose)", PYTHONPATH=path)
        assert done.stdout == "ours\n" and "STLIB" not in done.stderr, done.stderr


def test_what_a_stand_in_has_not_is_told(tmp_path):
    scene = tmp_path / "scene.py"
    scene.write_text("from softrobots.inverse.actuators import PullingCable\nfrom stlib3.nothing import here\n"
                     "def createScene(root):\n    pass\n")
    done = program("import sys, Sofa\nfrom Sofa import _scene_file\ntry:\n"
                   f"    _scene_file.load({str(scene)!r})\nexcept Exception as e:\n    print(e)")
    for line, module, plugin in ((1, "softrobots.inverse.actuators", "SoftRobots"), (2, "stlib3.nothing", "STLIB")):
        assert f"scene.py:{line}: error: the module '{module}' is not found, the library of SOFA's plugin {plugin}" in done.stdout


def test_a_prefab_makes_parts_of_its_body_rigid_before_it_has_a_parent(tmp_path):
    """Links that it writes as a list of paths lead to what they named then, wherever it is put."""
    import Sofa
    from stlib3.physics.deformable import ElasticMaterialObject
    from stlib3.physics.mixedmaterial import Rigidify

    class Arm(Sofa.Prefab):
        def init(self):
            body = ElasticMaterialObject(volumeMeshFileName=bar(tmp_path / "bar.msh"), name="bar", totalMass=2.0)
            self.addChild("elastic").addChild(body)
            ends = [[i for i, place in enumerate(body.dofs.rest_position.value) if abs(place[0] - x) < 0.1] for x in (-1, 2)]
            self.whole = Rigidify(self, body, name="whole", groupIndices=ends, frames=[[0, 0, 0], [0, 0, 0, 0, 0, 90]])
            self.whole.RigidParts.addObject("FixedProjectiveConstraint", indices=0)

    root = Sofa.Core.Node("root")
    root.gravity = [0, -10, 0]
    arm = root.addChild("modelling").addChild(Arm(name="arm"))
    simulation = root.addChild("simulation")
    simulation.addObject("EulerImplicitSolver")
    simulation.addObject("SparseLDLSolver", template="CompressedRowSparseMatrixd")
    simulation.addChild(arm.whole)
    Sofa.Simulation.init(root)
    frames = np.array(arm.whole.RigidParts.dofs.position.value)
    np.testing.assert_allclose(frames, [[-1, 0.5, 0.5, 0, 0, 0, 1], [0, 0, 0, 0, 0, *np.sqrt([0.5, 0.5])]], atol=1e-12)
    body = arm.whole.RigidParts.RigidifiedParticules.bar
    start = np.array(body.dofs.position.value)
    animate(root, 5)
    moved = np.array(body.dofs.position.value) - start
    assert np.abs(moved[start[:, 0] < -0.9]).max() < 1e-9 and moved[start[:, 0] > 1.9][:, 1].max() < -1e-5
    ends = np.array(body.dofs.position.value)[start[:, 0] > 1.9]
    np.testing.assert_allclose(np.linalg.norm(ends[0] - ends[-1]), np.sqrt(2), rtol=1e-12)


def test_rods_of_cosserat_stand_in():
    """By the names of now and of before; against the closed form of a rod that a moment bends to an arc."""
    import Sofa
    from cosserat.CosseratBase import CosseratBase
    from cosserat.cosseratObject import Cosserat
    from useful.header import addHeader, addSolverNode
    from useful.params import BeamGeometryParameters, BeamPhysicsParameters, Parameters

    ends = []
    for words in ("now", "before", "dict"):
        root = Sofa.Core.Node("root")
        root.gravity, root.dt = [0, 0, 0], 0.1
        addHeader(root)
        solvers = addSolverNode(root, rayleighStiffness=0.2, rayleighMass=1)
        if words == "dict":
            rod = Cosserat(parent=solvers, radius=0.5, youngModulus=1e4, poissonRatio=0.4, rayleighStiffness=0.2, cosseratGeometry={
                "init_pos": [0, 0, 0], "tot_length": 20, "nbSectionS": 4, "nbFramesF": 8, "beamMass": 0.01})
        else:
            geometry = {"beam_length": 20.0, "nb_section": 4, "nb_frames": 8} if words == "now" else {
                "beamLength": 20.0, "nbSection": 4, "nbFrames": 8}
            physics = {"young_modulus": 1e4, "poisson_ratio": 0.4, "beam_mass": 0.01, "beam_radius": 0.5} if words == "now" else {
                "youngModulus": 1e4, "poissonRatio": 0.4, "beamMass": 0.01, "beamRadius": 0.5}
            rod = CosseratBase(parent=solvers, params=Parameters(beam_geo_params=BeamGeometryParameters(**geometry),
                                                                 beamPhysicsParams=BeamPhysicsParameters(**physics)))
        solvers.addChild(rod)
        rod.cosseratFrame.addObject("ConstantForceField", indices=[8], forces=[[0, 0, 0, 0, 0, 30]])
        Sofa.Simulation.init(root)
        for _ in range(200):
            Sofa.Simulation.animate(root, 0.1)
        ends.append(np.array(rod.cosseratFrame.FramesMO.position.value[-1]))
    bending = 30 / (1e4 * np.pi / 4 * 0.5 ** 4)
    expected = [np.sin(20 * bending) / bending, (1 - np.cos(20 * bending)) / bending, 0]
    for end in ends:
        assert np.abs(end[:3] - expected).max() < 1e-3


def test_a_wrong_parameter_of_a_rod_is_told():
    from useful.params import BeamGeometryParameters

    with pytest.raises(TypeError, match="BeamGeometryParameters has no 'beamLenth'"):
        BeamGeometryParameters(beamLenth=1.0)


def test_rings_of_a_tube_stand_in():
    from splib3.topology import Remeshing_functions, remeshing

    assert Remeshing_functions is remeshing
    points = [[x, np.cos(a), np.sin(a)] for a in np.linspace(0, 2 * np.pi, 9)[:-1] for x in (2.0, 0.0, 1.0)]
    rings, numbers = remeshing.ordering_cylinder(*remeshing.circle_detection_axis(points, 0, tolerance=0.1), axis=0)
    assert [len(ring) for ring in rings] == [8, 8, 8]
    assert all(points[number] == point for ring, of_ring in zip(rings, numbers) for point, number in zip(ring, of_ring))
    around = np.unwrap([np.arctan2(point[2], point[1]) for point in rings[1]])
    assert len(set(np.sign(np.diff(around)))) == 1  # one way round
    sides = [[numbers[k][i], numbers[k][(i + 1) % 8], numbers[k + 1][(i + 1) % 8], numbers[k + 1][i]] for k in range(2) for i in range(8)]
    surface = (remeshing.quad_2_triangles(sides) + remeshing.invers_normal(remeshing.close_surface(numbers[0]))
               + remeshing.close_surface(numbers[2]))
    edges = [edge for a, b, c in surface for edge in ((a, b), (b, c), (c, a))]
    passed = [(edge[1], edge[0]) in edges for edge in edges]
    assert len(surface) == 44 and all(passed)  # closed, and all triangles turn the same way
    ordered, before, cells = remeshing.remesh_from_axis(points, surface, 0)
    assert all([before[at] for at in cell] == old for cell, old in zip(cells, surface))
    assert [point[0] for point in ordered] == sorted(point[0] for point in points)
    with pytest.raises(IndexError, match="the cells name points"):
        remeshing.reindex_mesh([0, 1], [[0, 5]])
