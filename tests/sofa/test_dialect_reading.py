# SPDX-License-Identifier: LGPL-2.1-or-later
"""How a scene in SOFA's dialect is read: names, prefabs, values, links, and what is said of what SOFA does not know.
Usage: test_dialect_reading.py STROMA [WORD]."""
import itertools
import os
import re
import tempfile

import numpy as np

from dialect import BODY, EXACT, FALL, STROMA, X4, X4_TEXT, Run, agree, case, differ, fallen, falls, main, node, root
from reference import euler, gravity, tetrahedra, together


@case
def free_fall_without_an_animation_loop():
    falls(Run(root(EXACT + BODY), 10))


@case
def dialect_on_the_command_line_and_on_the_node():
    falls(Run(root(EXACT + BODY + '<NaturalOrderingMethod/>'), 10, name="a.xml", args=["--dialect", "sofa"]))
    falls(Run(root(EXACT + BODY + '<NaturalOrderingMethod/>', FALL + ' dialect="sofa"'), 10, name="a.xml"))
    Run(root(EXACT + BODY + '<NaturalOrderingMethod/>'), 1, name="a.xml").fails(2, "NaturalOrderingMethod")
    Run(root(EXACT + BODY, FALL + ' dialect="sofia"'), 1, name="a.xml").fails(2, "is no dialect")


@case
def quirk_child_gravity():
    scene = root(f'<Node name="child" gravity="0 -1 0" dt="0.5">{EXACT}{BODY}</Node>')
    falls(Run(scene, 10), "child.dofs")
    falls(Run(scene, 10, args=["--without-quirk", "child-gravity"]), "child.dofs", g=1)


@case
def gravity_component():
    falls(Run(root(f'<Node name="child"><Gravity gravity="0 -3 0"/>{EXACT}{BODY}</Node>'), 10), "child.dofs", g=3)


@case
def prefab_beside_the_scene_and_on_the_data_path():
    prefab = '<Node name="Group"><EulerImplicitSolver rayleighMass="0.1"/><SparseLDLSolver/></Node>'
    decay = np.cumsum(list(itertools.accumulate([0.0] * 10, lambda v, _: (v - 0.1) / 1.001, initial=0.0)))[-1] * 0.01
    for place in ("Objects/Mine.xml", "data/Objects/Mine.xml"):
        run = Run(root("<Mine/>" + BODY), 10, {place: prefab})
        agree(run.x()[:, 1], [decay, decay])


@case
def prefab_of_a_name_that_was_removed():
    prefab = '<Node name="Group"><BoxROI name="box" box="-1 -1 -1 1 1 1"/><FixedProjectiveConstraint indices="@box.indices"/></Node>'
    run = Run(root(EXACT + BODY + '<BoxConstraint box="0.5 -1 -1 2 1 1"/>'), 10, {"Objects/BoxConstraint.xml": prefab})
    agree(run.x()[:, 1], [fallen(10), 0])


@case
def include_with_overrides():
    part = f'<Node name="part"><EulerImplicitSolver name="ode" rayleighMass="7"/><SparseLDLSolver/>{BODY}</Node>'
    run = Run(root('<include href="part.xml" name="mine" ode__rayleighMass="0" nobody="3"/>'), 10, {"part.xml": part})
    falls(run, "mine.dofs")
    run.says("nobody", "dropped")


@case
def include_of_a_group_and_a_merge():
    falls(Run(root('<include href="g.xml" name="other"/>' + BODY), 10, {"g.xml": f'<Group>{EXACT}</Group>'}))
    merge = '<Node name="_Merge_"><MechanicalObject name="dofs" position="5 0 0"/></Node>'
    agree(Run(root(EXACT + BODY + '<include href="m.xml"/>', 'gravity="0 0 0"'), 1, {"m.xml": merge}).x(), [[5, 0, 0]])


@case
def object_and_attribute_elements():
    falls(Run(root(EXACT + '<Object type="MechanicalObject" name="dofs"><Attribute type="position">0 0 0</Attribute></Object>'
                   '<UniformMass totalMass="1"/>'), 10))


@case
def links_by_place_by_number_and_to_the_first_of_two_names():
    scene = root('<MeshTopology position="0 0 0  3 0 0" edges="0 1"/><MeshTopology position="9 9 9" name="twin"/>'
                 '<MeshTopology position="8 8 8" name="twin"/>'
                 f'<Node name="a">{EXACT}<MechanicalObject name="dofs" position="@../MeshTopology1.position"/>'
                 '<UniformMass totalMass="1"/></Node>'
                 f'<Node name="b">{EXACT}<MechanicalObject name="dofs" position="@twin.position"/>'
                 '<UniformMass totalMass="1"/></Node>'
                 f'<Node name="c">{EXACT}<MeshTopology position="1 2 3"/><MechanicalObject name="dofs" position="@[-1].position"/>'
                 '<UniformMass totalMass="1"/></Node>', 'gravity="0 0 0"')
    run = Run(scene, 1)
    agree(run.x("a.dofs"), [[0, 0, 0], [3, 0, 0]])
    agree(run.x("b.dofs"), [[9, 9, 9]])
    agree(run.x("c.dofs"), [[1, 2, 3]])


@case
def values_as_a_stream_reads_them():
    scene = root('<EulerImplicitSolver trapezoidalScheme="0" firstOrder="F"/><SparseLDLSolver template="CompressedRowSparseMatrixMat3x3d"/>'
                 '<MechanicalObject name="dofs" template="Vec3d" position="[0 0 0] [1 0 0] [2 0 0] [3 0 0]" velocity="0 1 0"/>'
                 '<UniformMass totalMass="1"/><FixedConstraint indices="0-1"/>', 'gravity="0 0 0"')
    agree(Run(scene, 10).x()[:, 1], [0.1, 0.1, 0.1, 0.1])  # what is held keeps its velocity


@case
def typos_run_without_and_say_so():
    run = Run(root('<EulerImplicitSolver rayleighMas="9"/><SparseLDLSolver/>' + BODY), 10)
    falls(run)
    run.says("rayleighMas", "did you mean 'rayleighMass'")
    run = Run(root('<EulerImplicitSolver rayleighMass="much"/><SparseLDLSolver/>' + BODY), 10)
    falls(run)
    run.says("much", "keeps the default")


@case
def all_that_is_missing_at_once():
    Run(root(EXACT + BODY + '<NoSuchThing/><OtherThing/>'), 1).fails(2, "NoSuchThing", "OtherThing")


@case
def parts_without_effect():
    run = Run(root('<FreeMotionAnimationLoop/><NaturalOrderingMethod name="order"/><MatrixLinearSystem name="system"/>'
                   '<GenericConstraintSolver maxIterations="100"/><LeftMouseButtonSetting/><EulerImplicitSolver/>'
                   '<SparseLDLSolver orderingMethod="@order" linearSystem="@system"/><UncoupledConstraintCorrection/>'
                   + BODY, FALL + ' showBoundingTree="1"'), 10)
    falls(run)
    run.says("accepted without effect", "NaturalOrderingMethod", "showBoundingTree")
    Run(root('<MatrixLinearSystem assembleStiffness="0"/>' + EXACT + BODY), 1).fails(2, "assembleStiffness")


@case
def drawing_needs_no_files():
    falls(Run(root(EXACT + BODY + '<Node name="seen"><MeshOBJLoader name="loader" filename="nowhere.obj"/>'
                   '<OglModel src="@loader"/><IdentityMapping/></Node>'), 10))


@case
def explain_lists_quirks():
    run = Run(root('<EulerImplicitSolver/><CGLinearSolver name="cg"/>' + BODY), 0, command="explain")
    run.says("cg-threshold", "/cg", "--without-quirk")
    Run(root(EXACT + BODY), 1, args=["--without-quirk", "cg-treshold"]).fails(2, "cg-threshold")


@case
def names_with_blanks():
    """A body and what follows it, with blanks in the names of nodes and components that links name."""
    def named(blank):
        follower = (f'<Node name="Collision{blank}Model"><MechanicalObject name="the{blank}points" position="1 0 0"/><SubsetMapping '
                    f'indices="1" input="@../my{blank}dofs" output="@the{blank}points"/><RestShapeSpringsForceField '
                    f'stiffness="100" mstate="@the{blank}points"/></Node>')
        return Run(root(f'<Node name="Soft{blank}Body"><EulerImplicitSolver linearSolver="@linear{blank}solver"/><SparseLDLSolver '
                        f'name="linear{blank}solver"/><StringMeshCreator name="mesh{blank}loader" resolution="2"/><MechanicalObject '
                        f'name="my{blank}dofs" position="@mesh{blank}loader.position"/><UniformMass totalMass="2"/>' + follower +
                        '</Node>'), 5)
    for name, plain in named("").states.items():
        agree(named(" ").states[name.replace("SoftBody", "Soft_Body").replace("mydofs", "my_dofs").replace(
            "CollisionModel", "Collision_Model").replace("thepoints", "the_points")], plain)


@case
def files_that_are_no_utf8():
    """Latin-1, with a declaration and without, in the scene and in what it includes."""
    declared = '<?xml version="1.0" encoding="ISO-8859-1"?>\n'
    scene = root('<!-- r\xe9gime, 20 \xb0C --><Node name="k\xf6rper">' + EXACT + BODY + '</Node>')
    for text in (declared + scene, scene):
        run = Run(text.encode("latin-1"), 10)
        run.says(f"scene.scn:{1 + text.startswith('<?xml')}:", "is no UTF-8: it is read as Latin-1")
        falls(run, "k\xf6rper.dofs")
        falls(Run(text.encode("latin-1").replace(b'dt="0.01"', b'dt="0.01" dialect="sofa"'), 10, name="a.xml"), "k\xf6rper.dofs")
        Run(text.encode("latin-1"), 1, name="a.xml").fails(2, "is not part of a UTF-8 text")
        assert "Latin-1" not in Run(text.replace("ISO-8859-1", "UTF-8"), 1).text
    falls(Run(root('<include href="part.xml"/>'), 10, files={"part.xml": (declared + f'<Node name="k\xf6rper">{EXACT}{BODY}</Node>').encode(
        "latin-1")}), "k\xf6rper.dofs")


@case
def names_of_other_years():
    tetra = ('<MeshTopology position="0 0 0  1 0 0  0 1 0  0 0 1" tetrahedra="0 1 2 3"/><MechanicalObject name="dofs"/><UniformMass '
             'totalMass="1"/><FixedConstraint indices="0 1 2"/><MJEDTetrahedralForceField materialName="{}" ParameterSet="3000 3000"/>')
    agree(Run(root(EXACT + tetra.format("BoyceAndArruda")), 3).x(), Run(root(EXACT + tetra.format("ArrudaBoyce")), 3).x())
    run = Run(root('<CompositeCollisionPipeline/><SubCollisionPipeline name="a"/>' + EXACT + BODY), 3)
    falls(run, steps=3)


@case
def what_has_no_effect_here_and_one_in_sofa():
    touch = ('<CollisionPipeline/><BruteForceBroadPhase/><BVHNarrowPhase/>{}<CollisionResponse/><Node name="a">' + EXACT + BODY +
             '<PointCollisionModel {}/></Node>')
    near = '<LocalMinDistance alarmDistance="0.2" contactDistance="0.1" {}/>'
    for method, model, words in (
            (near.format('useLMDFilters="1"'), "", "useLMDFilters: filters contacts in SOFA"),
            ('<CCDTightInclusionIntersection continuousCollisionType="FreeMotion"/>', "", "finds contacts on the free motion of a step"),
            (near.format(""), 'PointActiverPath="@../x"', "PointActiverPath: leaves some points out of contacts in SOFA")):
        Run(root(touch.format(method, model)), 1).says(words)
    for words in ('angleCone="0.0" filterIntersection="true" useLMDFilters="0"', 'angleCone="0.1" filterIntersection="false"'):
        usual = Run(root(touch.format(near.format(words), "")), 1)
        assert "warning" not in usual.text, usual.text
    held = '<FixedLagrangianConstraint indices="0"/>'
    free = '<FreeMotionAnimationLoop {}/><GenericConstraintSolver tolerance="1e-10"/><Node name="a">' + EXACT + BODY + "{}{}</Node>"
    Run(root(free.format('solveVelocityConstraintFirst="1"', held, "")), 1).says("solveVelocityConstraintFirst: finds forces of constraint twice")
    for attribute, words in (('complianceFactor="0.5"', "changes how far SOFA's forces of constraint move"),
                             ('regularizationTerm="0.1"', "makes constraints soft")):
        Run(root(free.format("", held, f"<GenericConstraintCorrection {attribute}/>")), 1).says(words)
    assert "warning" not in Run(root(free.format("", held, '<GenericConstraintCorrection complianceFactor="1.0"/>')), 1).text
    for attributes, words in (('useOdeSolverIntegrationFactors="0"', 'useOdeSolverIntegrationFactors="false" has no effect'),
                              ('compliance="0.5" defaultCompliance="0.2"', "compliance has no effect: defaultCompliance is given"),
                              ('compliance="0.5 0.1" defaultCompliance="0.2"', "defaultCompliance has no effect: compliance is given")):
        Run(root(free.format("", held, f"<UncoupledConstraintCorrection {attributes}/>")), 1).says(words)
    Run(root(free.format("", '<CableConstraint indices="1" pullPoint="-1 0 0" value="0.1"/>', "")), 1).says(
        "finds forces of constraint until cables and cavities hold")
    moved = '<MechanicalObject name="dofs" template="Rigid3" position="0 0 0 0 0 0 1"/><UniformMass totalMass="2"/>'
    flow = 'keyTimes="{} 0.5" velocities="1 0 0 0 0 1  2 0 0 0 0 1"'
    Run(root(EXACT + moved + f'<LinearVelocityProjectiveConstraint indices="0" {flow.format(-0.1)}/>'), 1).says("begins before the start")
    Run(root(EXACT + moved + f'<LinearVelocityProjectiveConstraint indices="0" {flow.format(0)} continueAfterEnd="1"/>'), 1).says(
        "keeps the last velocity, and velocities of frames are those of the moment")
    Run(root(EXACT + moved + '<AffineMovementProjectiveConstraint indices="0" quaternion="0 0 0.6 0.8" endConstraintTime="1"/>'), 1).says(
        "turns frames on their way")
    Run(root(EXACT + '<MechanicalObject name="dofs" template="Rigid3" position="0 0 0 0 0 0 1  1 0 0 0 0 0 1"/><UniformMass totalMass="2"/>'
             '<AttachProjectiveConstraint indices1="0" indices2="1" twoWay="1"/>'), 1).says("SOFA solves with them free")
    Run(root(EXACT + '<MechanicalObject name="dofs" template="Rigid3" position="0 0 0 0 0 0 1  1 0 0 0 0 0 1"/><UniformMass totalMass="2"/>'
             '<BilateralLagrangianConstraint first_point="0" second_point="1" rest_vector="1 0 0" keepOrientationDifference="1"/>'),
        1).says("rest_vector has no effect: with keepCentreDifference")


@case
def what_is_accepted_and_may_do_something():
    run = Run(root(EXACT + BODY + '<PythonScriptController filename="a.py" classname="A"/>'), 2)
    run.says("is a script that SOFA runs")
    Run(root('<FreeMotionAnimationLoop/><GenericConstraintSolver regularizationTerm="0.1"/>' + EXACT + BODY), 1).says("makes constraints soft")
    held = '<FixedLagrangianConstraint indices="0"/><{}ConstraintCorrection/>'
    free = '<FreeMotionAnimationLoop/><GenericConstraintSolver tolerance="1e-10"/><Node name="a">'
    spring = '<SpringForceField spring="0 1 10 0 1"/>'
    for kind, word in (("Uncoupled", ""), ("Precomputed", "compliance of the start"), ("LinearSolver", "")):
        text = Run(root(free + EXACT + BODY + spring + held.format(kind) + '</Node>'), 2).text
        assert ("SOFA moves nodes by forces of constraint" in text) == bool(word) and word in text, text
        assert "SOFA moves nodes" not in Run(root(free + EXACT + BODY + held.format(kind) + '</Node>'), 2).text


@case
def files_that_an_included_file_names():
    """Beside the included file first, then beside the scene."""
    part = '<Node name="part"><MeshOBJLoader name="loader" filename="mesh.obj"/><MechanicalObject name="dofs" src="@loader"/></Node>'
    scene = root(EXACT + '<include href="parts/part.xml"/>')
    beside = {"parts/part.xml": part, "mesh.obj": "v 1 2 3\nv 4 5 6\nv 7 8 10\nf 1 2 3\n"}
    agree(Run(scene, 0, files=beside).x("part.dofs")[0], [1, 2, 3])
    first = {**beside, "parts/mesh.obj": "v 7 7 7\nv 8 8 8\nv 9 9 7\nf 1 2 3\n"}
    agree(Run(scene, 0, files=first).x("part.dofs")[0], [7, 7, 7])


@case
def fields_under_other_names():
    cells = ('<RegularGridTopology n="2 2 2" min="0 0 0" max="1 1 1"/><MechanicalObject name="dofs"/><UniformMass totalMass="8"/>'
             '<{} youngModulus="500" poissonRatio="0.3" {}/><FixedConstraint indices="0 1"/>')
    agree(Run(root(EXACT + cells.format("HexahedralFEMForceField", 'method="large"')), 5).x(),
          Run(root(EXACT + cells.format("HexahedronFEMForceField", 'method="large"')), 5).x(), 1e-12)
    fields = together(gravity(np.ones(4), [0, -10, 0]), tetrahedra([(0, 1, 2, 3)], X4, 200, 0.3))
    tensor = root(EXACT + f'<MeshTopology position="{X4_TEXT}" tetrahedra="0 1 2 3"/><MechanicalObject name="dofs"/>'
                  '<UniformMass totalMass="4"/><TetrahedralTensorMassForceField youngModulus="200" poissonRatio="0.3"/>'
                  '<FixedConstraint indices="0"/>')
    agree(Run(tensor, 20).x(), euler(X4, np.eye(4), fields, 20, 0.01, held=[0]), 1e-8)


@case
def parts_that_programs_fill():
    """In a scene alone they hold and measure nothing."""
    run = Run(root(EXACT + BODY + '<UnilateralLagrangianConstraint/><AugmentedLagrangianConstraint/><DataMonitor/><TimeMonitor/>'
                   '<PerformanceMonitor/>'), 10)
    falls(run)
    run.says("UnilateralLagrangianConstraint", "AugmentedLagrangianConstraint", "PerformanceMonitor")
    frames = '<MechanicalObject name="dofs" template="Rigid3" position="0 0 0 0 0 0 1  1 0 0 0 0 0 1"/><UniformMass totalMass="2"/>'
    run = Run(root(EXACT + frames + '<GearSpringForceField template="Rigid3"/>'), 10)
    run.says("has no pair of wheels")
    agree(run.x(width=7)[:, 1], [fallen(10)] * 2)
    for name in ("SkeletalMotionConstraint", "SkeletalMotionProjectiveConstraint"):
        run = Run(root(EXACT + frames + f'<{name} animationSpeed="2"/>'), 10)
        run.says("has no joints")
        agree(run.x(width=7), [[0, 0, 0, 0, 0, 0, 1], [1, 0, 0, 0, 0, 0, 1]])
        agree(Run(root(EXACT + frames + f'<{name} active="0"/>'), 10).x(width=7)[:, 1], [fallen(10)] * 2)
        Run(root(EXACT + frames + f'<{name} joints="a"/>'), 10).fails(2, "the movement of a skeleton")
    run = Run(node(EXACT + '<SphereQuadTopology nx="3" ny="3" nz="3"/><MechanicalObject name="dofs"/><UniformMass totalMass="2"/>'), 1)
    run.says("is 0 in SOFA when not given")


@case
def names_that_loops_had():
    held = EXACT + BODY + '<LinearSolverConstraintCorrection/><UniformLagrangianConstraint constrainToRestPos="1"/>'
    for loop in ('<MasterContactSolver tolerance="1e-6" maxIt="100"/>', '<FreeMotionMasterSolver/><LCPConstraintSolver/>'):
        run = Run(root(loop + held), 5)
        agree(run.x(), [[0, 0, 0], [1, 0, 0]])
        assert "nothing finds forces of constraint" not in run.text, run.text
    falls(Run(root('<MasterSolver/>' + EXACT + BODY), 10))
    falls(Run(root('<MultiStepMasterSolver integrationSteps="2"/>' + EXACT + BODY), 10), h=0.005)


@case
def names_that_were_short():
    """The same scene with the names that SOFA had until 24.12 and those that it has."""
    pairs = (("SphereQuad", "SphereQuadTopology"), ("CylinderGrid", "CylinderGridTopology"), ("SphereGrid", "SphereGridTopology"))
    grid = '<{} nx="3" ny="3" nz="3" radius="1" length="2" axis="0 0 1"/><MechanicalObject name="dofs"/><UniformMass totalMass="27"/>'
    for short, name in pairs:
        agree(Run(root(EXACT + grid.format(short)), 3).x(), Run(root(EXACT + grid.format(name)), 3).x())
    for short, name in (("MinResSolver", "MinResLinearSolver"), ("MINRESSolver", "MinResLinearSolver"), ("SVD", "SVDLinearSolver"),
                        ("SVDLinear", "SVDLinearSolver")):
        falls(Run(root(f'<EulerImplicitSolver/><{short}/>' + BODY), 10))
    falls(Run(root('<Background/><Stats/><Viewer/><AttachBodyButton/><PointSplat/><IncrementalSAP/>' + EXACT + BODY), 10))
    slowed = BODY.replace("/><Uniform", ' velocity="1 0 0  1 0 0"/><Uniform')
    agree(Run(node(EXACT + slowed + '<DampVelocity rate="3"/>'), 5).x(), Run(node(EXACT + slowed + '<DampVelocitySolver rate="3"/>'), 5).x())
    variational = '<{} newtonError="1e-9" steps="9" rayleighMass="0" rayleighStiffness="0"/><SparseLDLSolver/>'
    agree(*(Run(root(variational.format(name) + BODY), 5).x() for name in ("VariationalSolver", "VariationalSymplecticSolver")))


@case
def attributes_that_would_change_the_result():
    """What SOFA reads and is not here is an error; at its default it is nothing."""
    mesh = '<MeshTopology position="0 0 0  1 0 0  0 1 0" triangles="0 1 2"/><MechanicalObject name="dofs"/><UniformMass totalMass="3"/>'
    falls(Run(root(EXACT + mesh + '<TriangularFEMForceFieldOptim youngModulus="10" poissonRatio="0.3" restScale="1" damping="0"/>'),
              10), start=(0, 0, 1))
    Run(root(EXACT + mesh + '<TrianglePressureForceField pressure="0 0 1" normal="0 1 1" dmin="-1" dmax="1"/>'), 1).fails(2, "dmin")


COMMENTED = """<?xml version="1.0"?>
<!-- of M\u00fcller's scene -->
<Node name="root" gravity="0 0 0" dt="0.01">
  <!-- of what has no effect -->
  <VisualStyle displayFlags="showAll"/>

  <!-- first -->
  <Node name="part"> <!-- of the state --> <MechanicalObject name="dofs" position="0 0 0"/>
    <UniformMass totalMass="1"/>
    <!-- at the end of part -->
  </Node>

  <!-- of the solver,
       on two lines -->
  <EulerImplicitSolver/>
  <SparseLDLSolver/>
  <OglModel/>
  <!-- last -->
</Node>
<!-- behind -->
"""


@case
def migration_keeps_comments_blank_lines_and_order():
    with tempfile.TemporaryDirectory() as folder:
        with open(os.path.join(folder, "a.scn"), "w", encoding="utf-8") as out:
            out.write(COMMENTED)
        done = STROMA.run(["migrate", "a.scn"], folder)
    assert done.returncode == 0, done.stderr
    text = done.stdout
    order = ["of M\u00fcller's scene", "<Node name=\"root\"", "of what has no effect", "<!-- first -->",
             "<Node name=\"part\"",
             "of the state", "<MechanicalObject", "<UniformMass", "at the end of part", "</Node>",
             "of the solver,\n       on two lines -->", "<EulerImplicitSolver", "<SparseLDLSolver", "<!-- last -->", "</Node>",
             "<!-- behind -->"]
    places = [text.index(order[0])]
    for words in order[1:]:
        places.append(text.find(words, places[-1] + 1))
        assert places[-1] > 0, f"'{words}' is not where it was:\n{text}"
    for words in order:
        if "Node" not in words:
            assert text.count(words) == 1, f"'{words}' stands there {text.count(words)} times:\n{text}"
    assert "\n\n  <!-- of the solver," in text, text
    assert '  <VisualStyle displayFlags="showAll"/>' in text, text
    assert max(len(line) for line in text.splitlines()[2:]) <= 140


@case
def names_of_integrators_to_come():
    falls(Run(root(EXACT.replace("EulerImplicitSolver", "EulerImplicitIntegrationScheme") + BODY), 10))


@case
def words_and_numbers_that_cannot_be():
    net = '<MeshTopology name="n" position="0 0 0  1 0 0"/>'
    Run(node(net + '<TransformPosition name="e" input_position="@n.position" method="fromFile"/>' + EXACT + BODY), 1).fails(2, "/e: ", "file")
    for number in ("1e300", "-1e300", "9999999999999", "2.5e9"):
        run = Run(root(EXACT + BODY + f'<FixedConstraint indices="0 {number}"/>'), 1)
        assert run.code in (0, 2), run.text
    Run(node(EXACT + '<IndexValueMapper name="e" indices="99999999" value="1"/>' + BODY), 1).fails(2, "indices names 99999999")


@case
def templates_of_old_scenes():
    frames = '<MechanicalObject template="Rigid" name="dofs" position="0 0 0 0 0 0 1"/><UniformMass/>'
    child = '<Node name="c"><MechanicalObject template="Vec3d" name="p" position="0 1 0"/><RigidMapping template="Rigid,Vec3d"/></Node>'
    run = Run(root(EXACT + frames + child), 10)
    agree(run.x("c.p"), [[0, 1 + fallen(10), 0]])


@case
def bools_in_other_cases():
    """As programs print them: what asks for a bool before the component exists reads the same words."""
    spring = '<RestShapeSpringsForceField stiffness="100" points="0 1"/>'
    half = '<EulerImplicitSolver trapezoidalScheme="{}"/><SparseLDLSolver/>' + BODY + spring
    agree(Run(root(half.format("True")), 10).x(), Run(root(half.format("1")), 10).x(), 1e-15)
    differ(Run(root(half.format("True")), 10).x(), Run(root(half.format("False")), 10).x(), 1e-6)
    falls(Run(root(EXACT + BODY + '<Node name="seen"><MechanicalObject name="dofs" position="0 0 0  1 0 0"/>'
                   '<IdentityMapping isMechanical="False"/><ConstantForceField indices="0" forces="0 99 0"/></Node>'), 10))
    falls(Run(root(EXACT + BODY + '<Node name="off" activated="False"><Nonsense/></Node>'), 10))
    weak = Run(root(EXACT + BODY + '<FixedWeakConstraint fixAll="True" stiffness="100"/>'), 10).x()
    agree(weak, Run(root(EXACT + BODY + '<FixedWeakConstraint fixAll="1" stiffness="100"/>'), 10).x(), 1e-15)


@case
def vectors_as_a_stream_reads_them():
    """The numbers at the start count, a word is zero, and what is not there stays."""
    for text, g in (("0 -3", [0, -3, 0]), ("0 0", [0, 0, 0]), ("5", [5, -9.81, 0]), ("0, -3, 0", [0, 0, 0]), ("1 down 2", [1, 0, 0]),
                    ("", [0, -9.81, 0])):
        run = Run(root(EXACT + BODY, f'gravity="{text}"'), 10)
        agree(run.x()[0], np.array(g) * 0.01**2 * 55, 1e-12)
        run.says("SOFA has")
    moved = Run(root(EXACT + BODY.replace("<MechanicalObject", '<MechanicalObject translation="1 2"'), 'gravity="0 0 0"'), 1)
    agree(moved.x()[0], [1, 2, 0])


@case
def names_that_a_scene_gives():
    falls(Run(root('<MakeAliasComponent targetcomponent="UniformMass" alias="Weight"/><MakeDataAliasComponent '
                   'componentname="MechanicalObject" dataname="position" alias="places"/>' + EXACT
                   + '<MechanicalObject name="dofs" places="0 0 0  1 0 0"/><Weight totalMass="2"/>'), 10))


@case
def templates_of_graphics_cards():
    text = EXACT + BODY.replace('name="dofs"', 'name="dofs" template="CudaVec3f"').replace("UniformMass", 'UniformMass template="CudaVec3f1"')
    run = Run(root(text), 10)
    falls(run)
    run.says("Cuda in the template of MechanicalObject")
    frames = '<MechanicalObject name="dofs" template="CudaRigid3f" position="0 0 0 0 0 0 1"/><UniformMass template="StdRigidTypes"/>'
    agree(Run(root(EXACT + frames), 10).x("dofs", 7), [[0, fallen(10), 0, 0, 0, 0, 1]])


@case
def files_of_the_tree_of_a_scene():
    """share/ and examples/ of the tree that a scene lies in are searched, as SOFA does."""
    square = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
    text = root(EXACT + '<MeshOBJLoader name="l" filename="mesh/{}.obj"/><MechanicalObject name="dofs" src="@l"/><UniformMass totalMass="3"/>')
    files = {"tree/share/mesh/a.obj": square, "tree/examples/mesh/b.obj": square, "tree/other/mesh/c.obj": square}
    for name in "ab":
        agree(Run(text.format(name), 10, files, name="tree/examples/some/folder/scene.scn").x()[:, 1],
              np.add([0, 0, 1], fallen(10)))
    Run(text.format("c"), 1, files, name="tree/examples/some/folder/scene.scn").fails(2, "mesh/c.obj", "share")
    # includes and prefabs too; an include may include others
    body = '<Node name="body"><include href="Objects/Inner.xml"/></Node>'
    inner = '<Node name="Group">' + BODY.replace('totalMass="2"', 'vertexMass="1"') + "<BoxConstraint/></Node>"
    prefab = '<Node name="Group"><FixedProjectiveConstraint indices="1"/></Node>'
    files = {"tree/share/mesh/a.obj": square, "tree/examples/Objects/Outer.xml": body, "tree/examples/Objects/Inner.xml": inner,
             "tree/examples/Objects/BoxConstraint.xml": prefab}
    run = Run(root(EXACT + '<include href="Objects/Outer.xml" name="one"/>'), 10, files, name="tree/examples/some/folder/scene.scn")
    agree(run.x("one.dofs")[:, 1], [fallen(10), 0])


@case
def parts_that_do_nothing():
    """What acts on no state, attaches no nodes, or never moves."""
    run = Run(root(EXACT + '<UniformMass totalMass="7"/><Node name="body">' + BODY + '<AttachConstraint/><LinearMovementConstraint '
                   'indices="0"/><UniformVelocityDampingForceField dampingCoefficient="0"/></Node>'), 10)
    falls(run, "body.dofs")
    run.says("has no state to act on", "names no nodes", "has no two times")
    falls(Run(root(f'<Node name="empty">{EXACT}</Node>' + EXACT.join(["<Node name='body'>", BODY + "</Node>"])), 10), "body.dofs")


@case
def attributes_that_are_empty():
    """As a program saves them: an empty list is that of nobody's."""
    frames = ('<MechanicalObject name="dofs" template="Rigid3" position="0 0 0 0 0 0 1" externalForce="" derivX="" restScale="1"/>'
              '<UniformMass vertexMass="1 1 1 0 0 0 1 0 0 0 1" filename="unused" indices=""/><Node name="c"><MechanicalObject name="p" '
              'position="1 0 0"/><RigidMapping initialPoints="" rigidIndexPerPoint="" filename=""/><PlaneForceField normal="0 1 0" d="-99" '
              'indices=""/></Node>')
    agree(Run(root(EXACT + frames), 10).x("c.p"), [[1, fallen(10), 0]])


@case
def prefabs_that_the_scene_does_not_bring():
    """Of a node that is held and one that falls; and the damping of the integrator in CGImplicit."""
    run = Run(root(EXACT + BODY + '<BoxConstraint box="-0.1 -0.1 -0.1 0.1 0.1 0.1"/>'), 10)
    agree(run.x(), [[0, 0, 0], [1, fallen(10), 0]])
    run.says("is a prefab of SOFA")
    run = Run(root(EXACT + BODY + '<FixedBoxConstraint name="held" box="0.9 -0.1 -0.1 1.1 0.1 0.1"/>'), 10)
    agree(run.x(), [[0, fallen(10), 0], [1, 0, 0]])
    for mass, name in ((0.1, "CGImplicit"), (2, "CGImplicit"), (0.1, "CGImplicitSolver")):
        y = v = 0.0
        for _ in range(10):
            v = (v - 10 * 0.01) / (1 + mass * 0.01)
            y += v * 0.01
        given = "" if mass == 0.1 else f'rayleighMass="{mass}"'
        run = Run(root(f"<{name} {given}/>{BODY}"), 10)
        agree(run.x()[:, 1], [y, y], 1e-6)
    run = Run(root(f'<CGImplicit name="mine" foo="7" warmStart="true"/>{BODY}'), 10)
    run.says("/mine", "foo")
    assert "warmStart" not in run.text, run.text
    triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
    mesh = '<MeshLoader name="loader" filename="one.{}"/><MeshTopology src="@loader"/><MechanicalObject name="dofs"/><UniformMass totalMass="1"/>'
    falls(Run(root(EXACT + mesh.format("obj")), 10, {"one.obj": triangle}), start=[0, 0, 1])
    old = ("# vtk DataFile Version 2.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 3 float\n0 0 0 1 0 0 0 1 0\n"
           "CELLS 1 4\n3 0 1 2\nCELL_TYPES 1\n5\n")
    falls(Run(root(EXACT + mesh.format("vtk")), 10, {"one.vtk": old}), start=[0, 0, 1])


@case
def labels_select():
    """[0 1] and [1 2] as lists of three nodes' labels, and pairs of labels that meet."""
    body = '<MechanicalObject name="dofs" position="0 0 0  1 0 0  2 0 0"/><UniformMass totalMass="3"/>'
    merged = '<MergeROIs name="m" nbROIs="2" indices1="4 7" indices2="2"/><MergeROIs name="n" nbROIs="3" indices1="1" indices2="2 1"/>'
    for engine, link, still in (('<SelectLabelROI template="unsigned int" name="e" labels="@m.roiIndices" selectLabels="2 9"/>', "indices", [1]),
                                ('<SelectLabelROI name="e" labels="@n.roiIndices" selectLabels="1"/>', "indices", [0, 1]),
                                ('<SelectConnectedLabelsROI name="e" nbLabels="2" labels1="[1] [2,5] []" labels2="[1] [5,1] [2]" '
                                 'connectLabels="1 2"/>', "indices", [1]),
                                ('<MapIndices name="e" in="7 1" indices="5 6 7"/>', "out", [1, 2]),
                                ('<MapIndices name="e" in="0 2" indices="2 1 1" transpose="1"/>', "outStr", [1, 2])):
        y = Run(root(EXACT + merged + engine + body + f'<FixedConstraint indices="@e.{link}"/>'), 10).x()[:, 1]
        agree(y, [0 if i in still else fallen(10) for i in range(3)])
    Run(root(EXACT + body + '<SelectLabelROI name="e" labels="1 2 3" selectLabels="1"/><FixedConstraint indices="@e.indices"/>'), 1).fails(
        2, "in brackets")
    Run(root(EXACT + body + '<MergeROIs nbROIs="1" indices1="3"/>'), 1).says("which nothing with an effect reads")


@case
def groups_with_a_name():
    """The element says what it is."""
    falls(Run(root('<include href="g.xml"/>' + BODY), 10, {"g.xml": f'<Group name="any">{EXACT}</Group>'}))


@case
def fractions_and_writers_of_nothing():
    """A stream reads what stands before a stroke; and what has nothing to write is not created."""
    run = Run('<Node name="root" dt="0.04/2" gravity="0 -10 0"><VTKExporter filename="a"/><WriteState filename="b"/><Node name="n">' + EXACT +
              '<MechanicalObject name="dofs" position="0 0 0"/><UniformMass totalMass="1/3"/><ConstantForceField force="0 2 0"/></Node></Node>',
              10)
    run.says("'0.04/2' is no value: SOFA has 0.04", "'1/3' is no value: SOFA has 1 of it", "VTKExporter", "has nothing to write")
    agree(run.x("n.dofs")[0, 1], (2 - 10) * 0.04**2 * 55)
    run = Run(root(EXACT + '<MechanicalObject name="dofs" position="0 0 0" translation="1/4 0 0"/><UniformMass totalMass="1"/>'), 1)
    run.says("'1/4 0 0' is no value: SOFA has 1")
    agree(run.x()[0, 0], 1)
    idle = '<VectorSpringForceField stiffness="9"/><Node name="b"><RigidMapping/></Node>'
    run = Run(root(EXACT + BODY + idle), 10)
    falls(run)
    run.says("joins each node to itself", "has no state that follows")


@case
def the_page_has_a_picture_of_each_quirk():
    """The names in the table, and those in the titles of the pictures, are those that the program knows."""
    said = Run(root(EXACT + BODY), 1, args=["--without-quirk", "none-such"]).text
    known = sorted(re.search(r"expected one of: ([a-z, -]+)", said)[1].split(", "))
    tutorials = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "docs", "tutorials")
    with open(os.path.join(tutorials, "sofa.md"), encoding="utf-8") as file:
        page = file.read()
    assert sorted(re.findall(r"(?m)^\| `([a-z-]+)` \|", page)) == known
    drawn = []
    for picture in re.findall(r"!\[[^]]+\]\((quirks/\d+\.png)\)", page):
        with open(os.path.join(tutorials, picture), "rb") as file:
            chunks = file.read()
        at = chunks.index(b"tEXtTitle\0")
        drawn += chunks[at + 10:at + 4 + int.from_bytes(chunks[at - 4:at], "big")].decode().split()
    assert sorted(drawn) == known, "docs/plots/quirk_pictures.py draws them"


@case
def what_has_no_effect_in_sofa_says_why():
    """ReadTopology, and models of cylinders and of tetrahedra, which SOFA's points with normals alone meet."""
    cells = '<MeshTopology position="0 0 0  1 0 0  0 1 0  0 0 1" tetrahedra="0 1 2 3"/>'
    ball = f'<Node name="a">{EXACT}{cells}<MechanicalObject name="dofs"/><UniformMass totalMass="1"/>{{}}</Node>'
    other = (f'<Node name="b">{EXACT}<MechanicalObject name="dofs" position="0.1 0.1 0.1  9 0 0"/><UniformMass totalMass="2"/>'
             '<PointCollisionModel {}/></Node>')
    detect = ('<CollisionPipeline/><BruteForceBroadPhase/><BVHNarrowPhase/><CollisionResponse response="PenalityContactForceField"/>'
              '{}')
    alone = Run(root(ball.format('<ReadTopology filename="none.data"/>')), 10)
    agree(alone.x("a.dofs")[0], [0, fallen(10), 0])
    alone.says("a/ReadTopology1: has no effect because SOFA reads its file into lists")
    Run(root(ball.format('<CylinderCollisionModel/>')), 1).says("has no effect because none of SOFA's own methods")

    def met(points, method, model=""):
        return Run(root(detect.format(method) + ball.format(f"<TetrahedronCollisionModel {model}/>") + other.format(points)), 1)
    says = "meets the points of /b/PointCollisionModel1 in SOFA"
    met('computeNormals="1"', "<DiscreteIntersection/>").fails(2, says)
    met('computeNormals="1"', "").fails(2, says)
    for quiet in (met("", "<DiscreteIntersection/>"), met('computeNormals="1" active="0"', "<DiscreteIntersection/>"),
                  met('computeNormals="1"', "<DiscreteIntersection/>", 'active="0"'),
                  met('computeNormals="1"', '<MinProximityIntersection alarmDistance="0.01" contactDistance="0.005"/>')):
        assert quiet.code == 0, quiet.text
        quiet.says("has no effect because SOFA's tetrahedra")


@case
def links_that_lead_nowhere_name_what_is_near():
    """Each of several, and one that starts in the wrong place: file, line and path, and the link that is right."""
    state = '<MechanicalObject name="dofs" position="0 0 0"/><UniformMass totalMass="1"/>'
    bodies = f'<Node name="left">{state}</Node><Node name="right">{state}</Node>'
    both = bodies + ('<Node name="both"><MechanicalObject name="all" position="0 0 0 0 0 0"/>\n<SubsetMultiMapping name="m" '
                     'input="@../left/dofs {}" indexPairs="0 0  1 0"/></Node>')
    for wrong, near in (("@../rigth/dofs", "@../right/dofs"), ("@../right/dof", "@../right/dofs"), ("@../../right/dofs", "@/right/dofs"),
                        ("@/rihgt/dofs", "@/right/dofs")):
        run = Run(root(EXACT + both.format(wrong)), 1)
        line = next((each for each in run.text.splitlines() if "leads nowhere" in each), run.text)
        assert line.startswith("scene.scn:2:") and f"/both/m.input: the link '{wrong}' leads nowhere" in line and f"'{near}'" in line, line
    agree(Run(root(EXACT + both.format("@../right/dofs")), 10).x("both.all")[:, 1], [fallen(10)] * 2)
    roi = '<BoxROI name="fixed" box="-1 -1 -1 1 1 1"/>'
    Run(root(EXACT + BODY + roi + '<FixedProjectiveConstraint indices="@fixd.indices"/>'), 1).says("'@fixed.indices'")


@case
def templates_that_do_not_fit_are_told():
    """SOFA takes another template where the one that is written does not exist or does not fit the state, and so is it here."""
    body = '<MechanicalObject name="dofs" position="0 0 0  1 0 0"/><UniformMass totalMass="2" template="{}"/>'
    for template, words in (("Rigid3d", "is Rigid3, and /dofs has Vec3: SOFA takes the one that fits"), ("Vac3", "did you mean 'Vec3'?")):
        run = Run(root(EXACT + body.format(template)), 10)
        falls(run)
        run.says("scene.scn:1:", "/UniformMass1.template: ", words)
    solver = '<EulerImplicitSolver/><SparseLDLSolver template="{}"/>' + body.format("Vec3d")
    run = Run(root(solver.format("CompresedRowSparseMatrixd")), 10)
    falls(run)
    run.says("'CompresedRowSparseMatrixd' is no template", "did you mean 'CompressedRowSparseMatrix'?")
    for fine in ("CompressedRowSparseMatrixMat3x3d", "CompressedRowSparseMatrix<Mat3x3d>", "CompressedRowSparseMatrixd", "BTDMatrix6d"):
        assert "template" not in Run(root(solver.format(fine)), 1).text
    frames = '<MechanicalObject template="{}" name="dofs" position="0 0 0 0 0 0 1"/><UniformMass template="Rigid3d,Rigid3dMass"/>'
    assert ".template" not in Run(root(EXACT + frames.format("Rigid3d")), 1).text
    Run(root(EXACT + frames.format("Rgid3d")), 1).fails(2, "nodes of type Rgid3d do not exist here", "did you mean 'Rigid3'?")


@case
def typos_of_what_becomes_another_part():
    """Gravity, a damper after a solver and a loop of several steps are no components here."""
    run = Run(root('<MultiStepAnimationLoop integrationStep="4"/><Gravity gravty="0 -10 0" printLog="1"/><EulerImplicitSolver/>'
                   '<DampVelocitySolver rat="3"/><SparseLDLSolver/>' + BODY), 1)
    run.says("/Gravity1.gravty: Gravity has no attribute 'gravty'", "did you mean 'gravity'?", "no attribute 'rat'", "did you mean 'rate'?",
             "no attribute 'integrationStep'", "did you mean 'integrationSteps'?")
    assert "printLog: Gravity" not in run.text
    agree(run.x()[:, 1], [0, 0])


@case
def a_state_of_no_template_has_points():
    """Another one is taken where the one of the scene does not exist; those of a plug-in's own nodes are refused."""
    for word in ("vec3d", "Vec3d,Vec3d"):
        run = Run(root(EXACT + BODY.replace("<MechanicalObject", f'<MechanicalObject template="{word}"')), 5)
        falls(run, steps=5)
        run.says("is no template: SOFA takes Vec3, and so does this scene")
    Run(root(EXACT + BODY.replace("<MechanicalObject", '<MechanicalObject template="Affine"')), 1).fails(2, "nodes of type Affine do not exist here")


@case
def words_that_are_no_indices():
    """SOFA has 0 of each, also of "1.0" and "1,2", whose numbers count here. Of other lists it reads the numbers before a comma."""
    body = ('<MechanicalObject name="dofs" position="0 0 0  1 0 0  2 0 0  3 0 0  4 0 0"/><UniformMass totalMass="5"/>'
            '<FixedConstraint indices="{}"/>')
    none, counted = "'{}' is no whole number: SOFA has 0 of it, and so has", "SOFA has 0 of a word like '{}': here its numbers count"
    for text, held, said, word in (("-1 2", [0, 2], none, "-1"), ("1 - 3", [0, 1, 3], none, "-"), ("2 x 1e-1", [0, 1, 2], none, "x"),
                                   ("1,2 3", [1, 2, 3], counted, "1,2"), ("[1, 2]", [1, 2], counted, "[1,"),
                                   ("2 1.0 4", [1, 2, 4], counted, "1.0"),
                                   ("3-", [0, 1, 2, 3], none, "3-"), ("3-1", [1, 2, 3], "", ""), ("0-4-2", [0, 2, 4], "", ""), ("+1 4-2-2", [1, 2, 4], "", "")):
        run = Run(root(EXACT + body.format(text)), 10)
        run.says(said.format(word))
        assert said or "SOFA has 0" not in run.text, run.text
        agree(run.x()[:, 1], [0 if i in held else fallen(10) for i in range(5)])
    run = Run(root(EXACT + body.format("0-200000001")), 10)
    run.says("'0-200000001' is cut to 2000001 numbers")
    agree(run.x()[:, 1], [0] * 5)
    scene = root(EXACT + BODY + '<ConstantForceField indices="0 1" forces="0,1,0"/>')
    Run(scene, 1).says("/ConstantForceField1.forces: SOFA reads its numbers up to ',' alone")


@case
def attributes_that_sofa_declares_and_others():
    """Some of SOFA's are not here: refused unless they have their default, or no effect. A typo is one there too. Of a type whose
    attributes are not known nothing is said of SOFA."""
    body = EXACT + BODY + "<FixedLagrangianConstraint {}/>"
    Run(root(body.format('endTime="0.5"')), 1).fails(2, "/FixedLagrangianConstraint1.endTime: ",
                                                      "SOFA's FixedLagrangianConstraint reads 'endTime', which is not available here")
    for default in ("-1", "-1.0", "-1e0"):
        run = Run(root(body.format(f'endTime="{default}" constraintIndex="3"')), 1)
        assert run.code == 0 and "endTime: " not in run.text and "constraintIndex: " not in run.text, run.text
        run.says("FixedLagrangianConstraint.endTime", "FixedLagrangianConstraint.constraintIndex")  # in the list of what has no effect
    run = Run(root(body.format('endTim="0.5"')), 1)
    assert run.code == 0, run.text
    run.says("FixedLagrangianConstraint has no attribute 'endTim', nor has SOFA's: the scene runs without it", "did you mean 'endTime'?")
    run = Run(root(EXACT + BODY + '<LennardJonesForceField dmx="0.5"/>'), 1)
    run.says("LennardJonesForceField has no attribute 'dmx' here: the scene runs without it")
    mass = BODY.replace("<UniformMass", '<UniformMass rayleighStiffness="0.3" isCompliance="1"')
    falls(Run(root(EXACT + mass), 10))
    model = '<PointCollisionModel collisionElementActiver="@dofs" numberOfContacts="3"/>'
    Run(root(EXACT + BODY + model), 1).fails(2, "SOFA's PointCollisionModel reads 'collisionElementActiver'")
    grid = '<RegularGridTopology n="2 1 1" min="0 0 0" max="1 0 0" position="5 5 5"/><MechanicalObject name="dofs"/><UniformMass totalMass="2"/>'
    agree(Run(root(EXACT + grid), 10).x(), [[0, fallen(10), 0], [1, fallen(10), 0]])


@case
def factors_of_a_correction_that_are_not_one():
    """They scale what forces of constraint do in SOFA: that is told, and nothing where they are 1."""
    scene = root('<FreeMotionAnimationLoop/><GenericConstraintSolver/>' + EXACT + BODY + '<FixedLagrangianConstraint indices="0"/>'
                 '<UncoupledConstraintCorrection compliance="0.001" correctionVelocityFactor="{}" correctionPositionFactor="{}"/>')
    run = Run(scene.format("0.5", "1.0"), 1)
    run.says("correctionVelocityFactor: scales how forces of constraint change velocities in SOFA")
    assert "correctionPositionFactor: scales" not in run.text, run.text
    Run(scene.format("1", "0.2"), 1).says("correctionPositionFactor: scales how forces of constraint move nodes in SOFA")


main()
