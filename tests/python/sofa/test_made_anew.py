# SPDX-License-Identifier: LGPL-2.1-or-later
"""A scene whose tree changes while it runs is made anew, and what has not changed goes on to the bit: the same scenes run with and
without a node that has nothing to do with them and comes in the middle."""
import numpy as np
import pytest
import Sofa
from playing import animate

TETRAHEDRON = {"position": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], "tetrahedra": [[0, 1, 2, 3]],
               "triangles": [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]}


def body(root, solver="EulerImplicitSolver", linear="SparseLDLSolver", position=((0, 0, 0), (1, 0, 0)), **options):
    node = root.addChild("body")
    node.addObject(solver, name="ode", **options)
    if linear:
        node.addObject(linear, name="linear")
    node.addObject("MechanicalObject", name="state", position=[list(p) for p in position])
    node.addObject("UniformMass", totalMass=1)
    return node


def with_conditions(root):
    root.addObject("FreeMotionAnimationLoop")
    root.addObject("GenericConstraintSolver", tolerance=1e-12, maxIterations=1000)


def cable(root):
    with_conditions(root)
    node = body(root)
    node.addObject("GenericConstraintCorrection")
    node.addObject("RestShapeSpringsForceField", stiffness=100)
    node.addObject("CableConstraint", indices=[1], pullPoint=[0, 0, 0], value=[0.2])


def cable_by_weights(root):
    """Through points that a mapping places: its length is measured in the first step."""
    with_conditions(root)
    node = body(root, position=TETRAHEDRON["position"])
    node.addObject("GenericConstraintCorrection")
    node.addObject("MeshTopology", tetrahedra=[[0, 1, 2, 3]], position=TETRAHEDRON["position"])
    node.addObject("RestShapeSpringsForceField", stiffness=100)
    points = node.addChild("points")
    points.addObject("MechanicalObject", name="points", position=[[0.2, 0.2, 0.2], [0.6, 0.1, 0.1]])
    points.addObject("CableConstraint", indices=[0, 1], pullPoint=[-1, 0, 0], value=[0.2])
    points.addObject("BarycentricMapping")


def cavity(root):
    with_conditions(root)
    node = body(root, position=TETRAHEDRON["position"])
    node.addObject("GenericConstraintCorrection")
    node.addObject("RestShapeSpringsForceField", stiffness=1000)
    node.addObject("SurfacePressureConstraint", triangles=TETRAHEDRON["triangles"], value=0.05, valueType="volumeGrowth")


def driven(root):
    node = body(root)
    node.addObject("LinearVelocityConstraint", indices=[0], keyTimes=[0, 1], velocities=[[0, 1, 0], [0, 3, 0]])
    node.addObject("SpringForceField", spring="0 1 100 1 1")


def moved(root):
    node = body(root)
    node.addObject("LinearMovementConstraint", indices=[0], keyTimes=[0, 1], movements=[[0, 0, 0], [0, 3, 0]])
    node.addObject("SpringForceField", spring="0 1 100 1 1")


LATE = {
    "LinearMovementConstraint": dict(indices=[0], keyTimes=[0, 0.05, 1], movements=[[0, 0, 0], [0, 0.5, 0], [0, 0.7, 0]]),
    "LinearVelocityConstraint": dict(indices=[0], keyTimes=[0, 0.05, 1], velocities=[[0, 1, 0], [0, 3, 0], [0, -1, 0]]),
    "ParabolicConstraint": dict(indices=[0], P1=[0, 0, 0], P2=[1, 2, 0], P3=[2, 0, 0], BeginTime=0, EndTime=0.4),
    "HermiteSplineConstraint": dict(indices=[0], BeginTime=0, EndTime=0.4, X0=[0, 0, 0], dX0=[3, 0, 0], X1=[1, 1, 0], dX1=[0, 3, 0],
                                    SX0=[0, 0], SX1=[1, 1]),
    "OscillatorConstraint": dict(oscillators="0  0 0 0  0.1 0 0  20 0"),
}


@pytest.mark.parametrize("name", LATE)
def test_what_moves_by_the_start_of_a_step_goes_on_to_the_bit(name):
    """Its velocity changes where the scene is made anew, at 0.05 s."""
    def scene(root):
        node = body(root)
        node.addObject(name, **LATE[name])
        node.addObject("SpringForceField", spring="0 1 100 1 1")
    (x, v), (x_changed, v_changed) = ends_at(scene, False), ends_at(scene, True)
    assert np.array_equal(x, x_changed) and np.array_equal(v, v_changed)


def held_in_part(root):
    node = body(root, position=[(0, 0, 0), (1, 0, 0), (2, 0, 0)])
    node.state.velocity = [[0, 0, 0], [1, 1, 1], [1, 1, 1]]
    node.addObject("PartialFixedConstraint", indices=[1], fixedDirections=[0, 1, 0])
    node.addObject("LineProjectiveConstraint", indices=[2], origin=[2, 0, 0], direction=[1, 1, 0])


def of_second_order(root):
    body(root, "BDFOdeSolver", order=2).addObject("RestShapeSpringsForceField", stiffness=100)


def half_a_step_behind(root):
    body(root, "CentralDifferenceSolver", None).addObject("RestShapeSpringsForceField", stiffness=100)


def plastic(root):
    node = body(root, position=TETRAHEDRON["position"])
    node.addObject("MeshTopology", tetrahedra=TETRAHEDRON["tetrahedra"], position="@state.position")
    node.addObject("TetrahedronFEMForceField", youngModulus=100, poissonRatio=0.3, plasticMaxThreshold=0.5,
                   plasticYieldThreshold=1e-5, plasticCreep=0.5)
    node.addObject("FixedConstraint", indices=[0, 1, 2])


def attached(root):
    above = root.addChild("above")
    above.addObject("EulerImplicitSolver")
    above.addObject("SparseLDLSolver")
    for name, x in ("a", 0), ("b", 1):
        node = above.addChild(name)
        node.addObject("MechanicalObject", name="state", position=[[x, 0, 0], [x + 1, 0, 0]])
        node.addObject("UniformMass", totalMass=1)
        node.addObject("SpringForceField", spring="0 1 100 1 1")
    above.a.addObject("FixedConstraint", indices=[0])
    above.addObject("AttachConstraint", object1="@a", object2="@b", indices1=[1], indices2=[0], twoWay=True)


def condensed(root):
    node = root.addChild("body")
    node.addObject("CondensedDynamicSolver")
    node.addObject("RegularGridTopology", n=[3, 3, 3], min=[0, 0, 0], max=[0.1, 0.1, 0.1])
    node.addObject("MechanicalObject", name="state")
    node.addObject("UniformMass", totalMass=1)
    node.addObject("HexahedronFEMForceField", youngModulus=1000, poissonRatio=0.3, method="small")
    node.addObject("FixedConstraint", indices=[0, 2, 6, 8])


def root_of(scene):
    root = Sofa.Core.Node("root")
    root.gravity, root.dt = [0, -10, 0], 0.01
    scene(root)
    Sofa.Simulation.init(root)
    return root


def ends_at(scene, changed):
    root = root_of(scene)
    animate(root, 5)
    if changed:
        root.addChild("late").addObject("MechanicalObject", position=[[50, 50, 50]]).init()
    animate(root, 5)
    state = root.above.b.state if scene is attached else root.body.state
    return np.array(state.position.value), np.array(state.velocity.value)


@pytest.mark.parametrize("scene", [cable, cable_by_weights, cavity, driven, moved, held_in_part, of_second_order, half_a_step_behind, plastic, attached,
                                   condensed])
def test_what_has_not_changed_goes_on_to_the_bit(scene):
    (x, v), (x_changed, v_changed) = ends_at(scene, False), ends_at(scene, True)
    assert np.array_equal(x, x_changed) and np.array_equal(v, v_changed)


def test_a_node_that_is_held_from_now_on_goes_on_from_where_it_is():
    """FixedConstraint of SOFA takes changes of the velocity away, and not the velocity."""
    root = root_of(lambda root: body(root))
    animate(root, 5)
    root.body.addObject("FixedConstraint", name="held", indices=[0]).init()
    before = np.array(root.body.state.position.value)
    animate(root, 5)
    after = np.array(root.body.state.position.value)
    assert before[0][1] == pytest.approx(-10 * 0.01**2 * 15, rel=1e-12), "implicit Euler's sum 1 + 2 + ... + 5"
    assert after[0][1] == pytest.approx(before[0][1] - 5 * 0.01 * 0.5, rel=1e-12) and after[1][1] < after[0][1]


def two_balls(root):
    for x in 0, 10:
        ball = root.addChild("ball")
        ball.addObject("EulerImplicitSolver")
        ball.addObject("SparseLDLSolver")
        ball.addObject("MechanicalObject", name="state", position=[[x, 0, 0]])
        ball.addObject("UniformMass", totalMass=1)


def test_a_body_is_itself_whatever_its_name_and_its_parent():
    root = root_of(two_balls)
    animate(root, 5)
    first, second = root.children
    root.removeChild(first)
    animate(root, 1)
    assert second.state.position.value[0] == pytest.approx([10, -10 * 0.01**2 * 21, 0], rel=1e-12), "not the first one's state"
    second.name = "other"
    group = root.addChild("group")
    root.removeChild(second)
    group.addChild(second)
    animate(root, 1)
    assert second.state.position.value[0] == pytest.approx([10, -10 * 0.01**2 * 28, 0], rel=1e-12)


def test_what_is_remembered_of_a_node_is_not_another_ones():
    def held(root):
        with_conditions(root)
        node = body(root)
        node.addObject("GenericConstraintCorrection")
        node.addObject("SpringForceField", spring="0 1 100 1 1")
        node.addObject("FixedLagrangianConstraint", name="held", indices=[0])

    root = root_of(held)
    animate(root, 5)
    before = np.array(root.body.state.position.value)
    root.body.held.indices = [1]
    animate(root, 2)
    assert np.linalg.norm(root.body.state.position.value[1] - before[1]) < 0.05, "held where it is, not where node 0 was"


def test_a_cable_in_the_place_of_another_has_a_length_of_its_own():
    def pulled(root):
        with_conditions(root)
        node = body(root, position=[(0, 0, 0), (1, 0, 0), (3, 0, 0)])
        node.addObject("GenericConstraintCorrection")
        node.addObject("RestShapeSpringsForceField", stiffness=1000)
        node.addObject("CableConstraint", name="cable", indices=[1], pullPoint=[0, 0, 0], value=[0])

    root = root_of(pulled)
    animate(root, 5)
    root.body.removeObject(root.body.cable)
    root.body.addObject("CableConstraint", name="cable", indices=[2], pullPoint=[0, 0, 0], value=[0])
    animate(root, 2)
    assert root.body.state.position.value[2][0] == pytest.approx(3, abs=0.01)


def test_a_scene_that_cannot_be_loaded_is_told_in_every_step():
    root = root_of(lambda root: body(root))
    animate(root, 5)
    bad = root.body.addObject("TetrahedronFEMForceField", name="bad", youngModulus=-3)
    for _ in range(2):
        with pytest.raises(RuntimeError, match="youngModulus"):
            animate(root, 1)
    root.body.removeObject(bad)
    animate(root, 1)
    assert root.body.state.position.value[0][1] == pytest.approx(-10 * 0.01**2 * 21, rel=1e-12)


def test_what_comes_late_is_warned_of_as_at_the_start(capfd):
    root = Sofa.Core.Node("root")
    body(root).addObject("FixedConstraint", name="bad", indices=[77])
    Sofa.Simulation.init(root)
    assert "no node is held" in capfd.readouterr().err
    root = root_of(lambda root: body(root))
    root.body.addObject("FixedConstraint", name="bad", indices=[77])
    animate(root, 1)
    assert "no node is held" in capfd.readouterr().err


def test_an_actuator_with_another_kind_of_value_keeps_its_first_length():
    root = root_of(cable)
    animate(root, 5)
    pulled = float(root.body.CableConstraint.displacement.value)
    root.body.CableConstraint.valueType = "force"
    root.body.CableConstraint.value = [float(root.body.CableConstraint.force.value)]
    animate(root, 1)
    assert float(root.body.CableConstraint.displacement.value) == pytest.approx(pulled, abs=0.02)


def test_files_of_observers_go_on(folder):
    def watched(root):
        body(root).addObject("Monitor", fileName=str(folder / "fall"), indices=[0], ExportPositions=True)

    root = root_of(watched)
    animate(root, 5)
    root.addChild("late").addObject("MechanicalObject", position=[[50, 50, 50]]).init()
    animate(root, 5)
    Sofa.Simulation.unload(root)
    times = np.loadtxt(next(folder.glob("fall*x*")), usecols=0)
    assert np.allclose(np.diff(times), 0.01) and len(times) >= 10


def cube_of(root, name):
    node = root.addChild(name)
    node.addObject("EulerImplicitSolver")
    node.addObject("SparseLDLSolver")
    node.addObject("MechanicalObject", name="dofs", position=[[0.5, 0, 0]], rest_position=[[0, 0, 0]])
    node.addObject("UniformMass", totalMass=1)
    node.addObject("RestShapeSpringsForceField", stiffness=10, points=[0])
    return node


def test_what_is_switched_off_stays_and_goes_on():
    """Of two equal bodies one is switched off for four steps: it goes on as the other one did, to the bit."""
    root = Sofa.Core.Node("root")
    one, two = cube_of(root, "one"), cube_of(root, "two")
    Sofa.Simulation.init(root)
    states = []
    for step in range(12):
        animate(root, 1)
        states.append((one.dofs.position.array(), one.dofs.velocity.array()))
        if step == 2:
            two.activated = False
        if 3 <= step < 7:
            assert (two.dofs.position.array() == states[2][0]).all() and (two.dofs.velocity.array() == states[2][1]).all()
        if step == 6:
            two.activated = True
        if step >= 7:
            assert (two.dofs.position.array() == states[step - 4][0]).all(), step
            assert (two.dofs.velocity.array() == states[step - 4][1]).all(), step


def test_what_is_taken_off_and_put_back_goes_on():
    root = Sofa.Core.Node("root")
    one, two = cube_of(root, "one"), cube_of(root, "two")
    Sofa.Simulation.init(root)
    animate(root, 3)
    before = one.dofs.position.array(), one.dofs.velocity.array()
    root.removeChild(two)
    animate(root, 2)
    root.addChild(two)
    animate(root, 1)
    after = two.dofs.position.array()
    assert (one.dofs.position.array() != after).any()
    two.dofs.position.value, two.dofs.velocity.value = before
    animate(root, 1)
    assert (two.dofs.position.array() == after).all(), "it went on from where it was taken off"


def test_what_is_switched_off_takes_positions():
    root = Sofa.Core.Node("root")
    body = cube_of(root, "body")
    cube_of(root, "other")
    Sofa.Simulation.init(root)
    animate(root, 1)
    body.activated = False
    animate(root, 1)
    with pytest.raises(ValueError, match="6 numbers for 1 rows of 3"):
        body.dofs.position.value = [[3, 0, 0], [4, 0, 0]]
    body.dofs.position.value = [[3, 0, 0]]
    assert body.dofs.position.array().tolist() == [[3, 0, 0]]
    body.activated = True
    animate(root, 1)
    assert 2.9 < body.dofs.position.array()[0, 0] < 3, "it goes on from there"
