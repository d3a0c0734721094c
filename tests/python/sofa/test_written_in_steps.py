# SPDX-License-Identifier: LGPL-2.1-or-later
"""What controllers write in each step acts at once: the scene is not made anew, and moves as one that has the value from the start."""
import numpy as np
import pytest
import Sofa
from playing import animate

BOX = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]
FACES = [[0, 2, 1], [0, 3, 2], [4, 5, 6], [4, 6, 7], [0, 1, 5], [0, 5, 4], [1, 2, 6], [1, 6, 5], [2, 3, 7], [2, 7, 6], [3, 0, 4], [3, 4, 7]]


def robot():
    root = Sofa.Core.Node("root")
    root.gravity, root.dt = [0, -9.81, 0], 0.01
    root.addObject("FreeMotionAnimationLoop")
    root.addObject("GenericConstraintSolver", name="solver", tolerance=1e-9, maxIterations=1000)
    body = root.addChild("body")
    body.addObject("EulerImplicitSolver", name="ode", rayleighStiffness=0.1, rayleighMass=0.1)
    body.addObject("SparseLDLSolver")
    body.addObject("RegularGridTopology", name="grid", n=[6, 3, 3], min=[0, 0, 0], max=[5, 1, 1])
    body.addObject("MechanicalObject", name="state")
    body.addObject("UniformMass", name="mass", totalMass=1)
    body.addObject("HexahedronFEMForceField", name="elastic", youngModulus=2000, poissonRatio=0.3)
    body.addObject("RestShapeSpringsForceField", name="springs", points=[0, 6, 12], stiffness=1000)
    body.addObject("PartialFixedProjectiveConstraint", name="held", indices=[0], fixedDirections=[1, 1, 1])
    body.addObject("ConstantForceField", name="load", indices=[5], forces=[[0, 0, 1]])
    body.addObject("LinearSolverConstraintCorrection")
    cable = body.addChild("cable")
    cable.addObject("MechanicalObject", position=[[1, 0.9, 0.5], [3, 0.9, 0.5], [4.9, 0.9, 0.5]])
    cable.addObject("CableConstraint", name="cable", indices=[0, 1, 2], pullPoint=[-1, 0.9, 0.5], value=0.3, valueType="displacement")
    cable.addObject("BarycentricMapping")
    cavity = body.addChild("cavity")
    cavity.addObject("MechanicalObject", position=(np.array(BOX) * [1, 0.4, 0.4] + [3, 0.3, 0.3]).tolist())
    cavity.addObject("SurfacePressureConstraint", name="pressure", triangles=FACES, value=20, valueType="pressure")
    cavity.addObject("BarycentricMapping")
    return root


#: (object, attribute): a value other than the scene's
WRITTEN = {
    "body.cable.cable.value": [0.6],
    "body.cable.cable.valueType": "force",
    "body.cable.cable.maxForce": 2.0,
    "body.cable.cable.maxPositiveDisp": 0.02,
    "body.cable.cable.maxDispVariation": 0.01,
    "body.cable.cable.pullPoint": [-1, 3, 0.5],
    "body.cavity.pressure.value": [5.0],
    "body.cavity.pressure.valueType": "volumeGrowth",
    "body.cavity.pressure.maxPressure": 5.0,
    "body.cavity.pressure.maxPressureVariation": 1.0,
    "body.load.indices": [11, 17],
    "body.load.forces": [[0, 3, 0]],
    "body.springs.points": [0, 6, 12, 17, 11],
    "body.springs.stiffness": [10.0],
    "body.held.indices": [0, 5],
    "body.held.fixedDirections": [1, 0, 0],
    "body.held.fixAll": True,
    "body.elastic.youngModulus": 5000.0,
    "body.elastic.poissonRatio": 0.1,
    "body.mass.totalMass": 3.0,
    "body.ode.rayleighStiffness": 0.5,
    "gravity": [0, 0, 9.81],
}
#: with other values beside it where it matters
BESIDE = {"body.held.fixAll": {"body.cable.cable.value": [0.0]},
          "body.cable.cable.maxPositiveDisp": {"body.cable.cable.valueType": "force", "body.cable.cable.value": 3.0},
          "body.cavity.pressure.valueType": {"body.cavity.pressure.value": 0.02}}


def write(root, path, value):
    if path == "gravity":
        root.gravity = value
    else:
        root[path].value = value


def run(path, when):
    root = robot()
    for other, value in BESIDE.get(path, {}).items():
        write(root, other, value)
    if when == "before":
        write(root, path, WRITTEN[path])
    Sofa.Simulation.init(root)
    made = root._s_running.sim
    if when == "after":
        write(root, path, WRITTEN[path])
    animate(root, 15)
    assert root._s_running.sim is made, "the scene was loaded again"
    return np.array(root.body.state.position.value)


@pytest.mark.parametrize("path", WRITTEN)
def test_it_acts_at_once(path):
    before = run(path, "before")
    assert np.abs(run(path, "after") - before).max() < 1e-12
    assert np.abs(run(path, "never") - before).max() > 1e-9


def test_springs_take_other_points_also_where_the_rest_shape_leads():
    ends = []
    for when in ("before", "after"):
        root = robot()
        if when == "before":
            write(root, "body.springs.points", [0, 6, 17])
        Sofa.Simulation.init(root)
        rest = np.array(root.body.state.rest_position.value) + [0, 0.5, 0]
        root.body.state.rest_position.value = rest
        if when == "after":
            write(root, "body.springs.points", [0, 6, 17])
        animate(root, 15)
        ends.append(np.array(root.body.state.position.value))
    assert np.abs(ends[0] - ends[1]).max() < 1e-12


# ---- what a constraint solver's sweeps read ----
def tied(**values):
    root = Sofa.Core.Node("root")
    root.gravity, root.dt = [0, -9.81, 0], 0.01
    root.addObject("FreeMotionAnimationLoop")
    root.addObject("GenericConstraintSolver", name="solver", **{"tolerance": 1e-3, "maxIterations": 1000, **values})
    body = root.addChild("body")
    body.addObject("EulerImplicitSolver")
    body.addObject("SparseLDLSolver")
    body.addObject("MechanicalObject", name="state", position=[[i // 2 + i % 2, 0, 0] for i in range(16)])
    body.addObject("UniformMass", totalMass=1)
    body.addObject("SpringForceField", spring=" ".join(f"{2 * i} {2 * i + 1} 500 0.1 1" for i in range(8)))
    body.addObject("LinearSolverConstraintCorrection")
    body.addObject("FixedLagrangianConstraint", indices=[0])
    for i in range(7):
        body.addObject("BilateralLagrangianConstraint", object1="@state", object2="@state", first_point=2 * i + 1, second_point=2 * i + 2)
    return root


@pytest.mark.parametrize("name, value", [("tolerance", 1e-10), ("sor", 0.5), ("regularizationTerm", 0.01), ("scaleTolerance", False),
                                         ("resolutionMethod", 2), ("resolutionMethod", "UnbuiltGaussSeidel")])
def test_a_constraint_solver_takes_it_at_once(name, value):
    ends = []
    for when in ("before", "after", "never"):
        root = tied(**({name: value} if when == "before" else {}))
        Sofa.Simulation.init(root)
        made = root._s_running.sim
        if when == "after":
            root.solver.findData(name).value = value
        animate(root, 20)
        assert root._s_running.sim is made, "the scene was loaded again"
        ends.append(np.array(root.body.state.position.value))
    assert np.abs(ends[0] - ends[1]).max() == 0
    assert np.abs(ends[0] - ends[2]).max() > 1e-6


@pytest.mark.parametrize("name, value", [("maxIterations", 0), ("sor", 2.5), ("tolerance", "abc"), ("resolutionMethod", "Jacobi")])
def test_what_it_cannot_take_is_told_by_its_own_name(name, value):
    root = tied()
    Sofa.Simulation.init(root)
    with pytest.raises(RuntimeError, match=rf"test_written_in_steps\.py:\d+: .*/solver\.{name}"):
        root.solver.findData(name).value = value
    animate(root, 1)


# ---- others whose values are taken at once ----
def muscle(parameters=(1000, 1e4)):
    root = Sofa.Core.Node("root")
    root.gravity, root.dt = [0, -9.81, 0], 0.01
    body = root.addChild("body")
    body.addObject("EulerImplicitSolver")
    body.addObject("SparseLDLSolver")
    body.addObject("RegularGridTopology", name="grid", n=[5, 3, 3], min=[0, 0, 0], max=[1, 0.3, 0.3])
    body.addObject("TetrahedronSetTopologyContainer", name="cells")
    body.addObject("TetrahedronSetTopologyModifier")
    body.addObject("Hexa2TetraTopologicalMapping", input="@grid", output="@cells")
    body.addObject("MechanicalObject", name="state", src="@grid")
    body.addObject("UniformMass", totalMass=0.2)
    body.addObject("TetrahedronHyperelasticityFEMForceField", name="law", materialName="NeoHookean", ParameterSet=list(parameters))
    body.addObject("FixedProjectiveConstraint", indices=list(range(0, 45, 5)))
    return root


def rod(rest=0.0):
    root = Sofa.Core.Node("root")
    root.gravity, root.dt = [0, -9.81, 0], 0.01
    body = root.addChild("body")
    body.addObject("EulerImplicitSolver", rayleighStiffness=0.1)
    body.addObject("SparseLDLSolver")
    body.addObject("MechanicalObject", name="state", position=[[0, 0, 0]] * 3, rest_position=[[0, 0, rest]] * 3)
    body.addObject("UniformMass", totalMass=0.1)
    body.addObject("BeamHookeLawForceField", length=[1, 1, 1], radius=0.1, youngModulus=1e5, poissonRatio=0.4)
    return root


def chain(springs=(0, 1, 100, 1, 1)):
    root = Sofa.Core.Node("root")
    root.gravity, root.dt = [0, -9.81, 0], 0.01
    body = root.addChild("body")
    body.addObject("EulerImplicitSolver")
    body.addObject("SparseLDLSolver")
    body.addObject("MechanicalObject", name="state", position=[[0, 0, 0], [1, 0, 0], [2, 0.5, 0]])
    body.addObject("UniformMass", totalMass=3)
    body.addObject("SpringForceField", name="springs", spring=list(springs))
    return root


OTHERS = {"chain": (chain, "body.springs.spring", (0, 1, 100, 1, 1, 1, 2, 300, 0, 0.5)),
          "muscle": (muscle, "body.law.ParameterSet", (3000, 1e4)), "rod": (rod, "body.state.rest_position", 0.2)}


@pytest.mark.parametrize("name", OTHERS)
def test_so_do_laws_rods_and_springs(name):
    scene, path, value = OTHERS[name]
    ends = []
    for when in ("before", "after", "never"):
        root = scene(value) if when == "before" else scene()
        Sofa.Simulation.init(root)
        made = root._s_running.sim
        if when == "after":
            root[path].value = [[0, 0, value]] * 3 if name == "rod" else list(value)
        animate(root, 10)
        assert root._s_running.sim is made, "the scene was loaded again"
        ends.append(np.array(root.body.state.position.value))
    assert np.abs(ends[0] - ends[1]).max() < 1e-12
    assert np.abs(ends[0] - ends[2]).max() > 1e-6


def test_what_is_told_of_a_value_is_told_once(capfd):
    root = muscle()
    Sofa.Simulation.init(root)
    for step in range(5):
        root.body.law.ParameterSet.value = [1000 + step, 1e4]
        animate(root, 1)
    assert capfd.readouterr().err.count("the cells lock at Poisson's ratio") <= 1
