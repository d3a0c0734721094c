# SPDX-License-Identifier: LGPL-2.1-or-later
"""Small scenes as SOFA's examples begin, one or more for each folder of components. SCENES maps a name to its text; where a
component is not available, MISSING maps the name to the words that the refusal must hold."""

PLUGINS = ('<RequiredPlugin pluginName="Sofa.Component.ODESolver.Backward Sofa.Component.LinearSolver.Iterative"/>'
           '<VisualStyle displayFlags="showBehaviorModels showForceFields"/>')
LOOP = '<DefaultAnimationLoop name="loop" computeBoundingBox="0"/>'
FREE = '<FreeMotionAnimationLoop/><ProjectedGaussSeidelConstraintSolver maxIterations="500" tolerance="1e-9"/>'
ODE = '<EulerImplicitSolver name="ode" rayleighStiffness="0.1" rayleighMass="0.1"/>'
CG = '<CGLinearSolver name="cg" iterations="25" tolerance="1e-5" threshold="1e-5"/>'
LDL = '<SparseLDLSolver name="ldl" template="CompressedRowSparseMatrixMat3x3d"/>'
GRID = ('<RegularGridTopology name="grid" nx="4" ny="3" nz="3" xmin="0" xmax="3" ymin="0" ymax="1" zmin="0" zmax="1"/>'
        '<MechanicalObject name="dofs" template="Vec3d" showObject="1"/>')
SHEET = '<RegularGridTopology name="grid" n="4 4 1" min="0 0 0" max="3 3 0"/><MechanicalObject name="dofs"/>'
HOLD = '<BoxROI name="box" box="-0.1 -9 -9 0.1 9 9" drawBoxes="1"/><FixedProjectiveConstraint indices="@box.indices"/>'
HEXA = '<HexahedronFEMForceField name="fem" method="large" youngModulus="3000" poissonRatio="0.3"/>'
POINTS = '<MechanicalObject name="dofs" position="0 0 0  1 0 0  2 0 0  3 0 0"/><UniformMass totalMass="4"/>'
FRAMES = '<MechanicalObject name="dofs" template="Rigid3d" position="0 0 0 0 0 0 1  1 0 0 0 0 0 1  2 0 0 0 0 0 1"/>'
TETRA = ('<MeshGmshLoader name="loader" filename="mesh/block.msh"/><TetrahedronSetTopologyContainer name="cells" src="@loader"/>'
         '<TetrahedronSetTopologyModifier/><TetrahedronSetGeometryAlgorithms template="Vec3"/><MechanicalObject name="dofs" '
         'src="@loader"/><DiagonalMass massDensity="1"/>')
DETECT = '<CollisionPipeline depth="6" verbose="0" draw="0"/><BruteForceBroadPhase/><BVHNarrowPhase/>'
NEAR = '<LocalMinDistance name="proximity" alarmDistance="0.3" contactDistance="0.1" angleCone="0.0"/>'
ANSWER = '<CollisionResponse name="response" response="PenalityContactForceField"/>'
FLOOR = ('<Node name="floor"><MeshTopology position="-9 -2 -7  9 -2 -9  9 -2 9  -9 -2 9" triangles="0 2 1  0 3 2"/>'
         '<MechanicalObject/><TriangleCollisionModel moving="0" simulated="0"/><LineCollisionModel moving="0" simulated="0"/>'
         '<PointCollisionModel moving="0" simulated="0"/></Node>')


def root(content, loop=LOOP, gravity="0 -9.81 0"):
    return f'<?xml version="1.0"?>\n<Node name="root" gravity="{gravity}" dt="0.01">{PLUGINS}{loop}{content}</Node>\n'


def body(content, solver=ODE + CG, loop=LOOP, more=""):
    return root(f'{more}<Node name="body">{solver}{content}</Node>', loop)


def block(content="", solver=ODE + CG, field=HEXA, mass='<UniformMass totalMass="36"/>', loop=LOOP, more=""):
    return body(GRID + mass + field + HOLD + content, solver, loop, more)


def sheet(content, solver=ODE + CG):
    return body(SHEET + '<DiagonalMass massDensity="1"/>' + content + HOLD, solver)


def touching(detection=DETECT, near=NEAR, answer=ANSWER, model="Point", loop=LOOP, more=""):
    ball = f'{GRID}<UniformMass totalMass="36"/>{HEXA}<{model}CollisionModel name="model"/>{more}'
    return root(f'{detection}{answer}{near}{FLOOR}<Node name="ball">{ODE}{CG}{ball}</Node>', loop)


def chain(content, loop=FREE, solver=ODE + LDL, correction="<LinearSolverConstraintCorrection/>"):
    """Two bodies of points, and what joins them."""
    one = (f'<Node name="one">{solver}<MechanicalObject name="dofs" position="0 0 0  1 0 0  2 0 0"/><UniformMass totalMass="3"/>'
           f'<MeshTopology position="0 0 0  1 0 0  2 0 0" edges="0 1  1 2"/><MeshSpringForceField linesStiffness="500" '
           f'linesDamping="1"/><FixedProjectiveConstraint indices="0"/>{correction}</Node>')
    other = (f'<Node name="other">{solver}<MechanicalObject name="dofs" position="2 0 0"/><UniformMass totalMass="1"/>'
             f'{correction}</Node>')
    return root(one + other + content, loop)


def mapped(content, state='template="Vec3" position="0.5 0.5 0.5  1.2 0.3 0.9"', more=""):
    return block(f'<Node name="child"><MechanicalObject name="mapped" {state}/>{content}</Node>' + more)


def numbers(content):
    """Points whose distances, areas and the like are held by springs."""
    return body('<MeshTopology name="net" position="0 0 0  1 0 0  0 1 0  0 0 1" edges="0 1  1 2" triangles="0 1 2" '
                'tetrahedra="0 1 2 3"/><MechanicalObject name="dofs"/><UniformMass totalMass="4"/><FixedProjectiveConstraint '
                f'indices="0"/><Node name="child"><MechanicalObject name="y" template="Vec1d"/>{content}'
                '<RestShapeSpringsForceField stiffness="100"/></Node>', ODE + LDL)


def engine(content, link, held=""):
    """What an engine makes is where points start."""
    return root(content + f'<Node name="body">{ODE}{CG}<MechanicalObject name="dofs" position="@../{link}"/>'
                f'<UniformMass totalMass="1"/>{held}</Node>')


def selected(content, link="roi.indices"):
    return body(GRID + '<UniformMass totalMass="36"/>' + HEXA + content + f'<FixedProjectiveConstraint indices="@{link}"/>')


NET = '<MeshTopology name="net" position="0 0 0  1 0 0  1 1 0  0 1 0" triangles="0 1 2  0 2 3" quads="0 1 2 3" edges="0 1  1 2"/>'
SHELL = ('<MeshTopology name="shell" position="0 0 0  1 0 0  0 1 0  0 0 1" triangles="0 2 1  0 1 3  1 2 3  2 0 3" '
         'tetrahedra="0 1 2 3"/>')

SCENES = {
    # ---- AnimationLoop ----
    "AnimationLoop/DefaultAnimationLoop": block(),
    "AnimationLoop/FreeMotionAnimationLoop": block("<UncoupledConstraintCorrection/>", loop=FREE),
    "AnimationLoop/MultiStepAnimationLoop": block(loop='<MultiStepAnimationLoop collisionSteps="2" integrationSteps="3"/>'),
    "AnimationLoop/MultiTagAnimationLoop": block(loop="<MultiTagAnimationLoop/>"),
    # ---- Collision ----
    "Collision/Detection/BVHNarrowPhase": touching(),
    "Collision/Detection/BruteForceDetection": touching(detection='<DefaultPipeline/><BruteForceDetection/>'),
    "Collision/Detection/IncrSAP": touching(detection='<CollisionPipeline/><IncrSAP name="sap"/>'),
    "Collision/Detection/DirectSAP": touching(detection='<CollisionPipeline/><DirectSAP name="sap"/><DirectSAPNarrowPhase/>'),
    "Collision/Detection/RayTraceDetection": touching(detection='<CollisionPipeline/><RayTraceDetection/>'),
    "Collision/Detection/MinProximityIntersection": touching(near='<MinProximityIntersection alarmDistance="0.3" contactDistance="0.1"/>'),
    "Collision/Detection/NewProximityIntersection": touching(near='<NewProximityIntersection alarmDistance="0.3" contactDistance="0.1"/>'),
    "Collision/Detection/DiscreteIntersection": touching(near="<DiscreteIntersection/>", model="Sphere"),
    "Collision/Geometry/TriangleCollisionModel": touching(
        more='<Node name="skin"><TriangleSetTopologyContainer position="0 0 0  1 0 0  0 0 1" triangles="0 1 2"/><MechanicalObject/>'
             '<TriangleCollisionModel/><BarycentricMapping/></Node>'),
    "Collision/Geometry/LineCollisionModel": touching(model="Line"),
    "Collision/Geometry/SphereCollisionModel": touching(model="Sphere"),
    "Collision/Geometry/CylinderCollisionModel": touching(model="Cylinder"),
    "Collision/Geometry/TetrahedronCollisionModel": touching(model="Tetrahedron"),
    "Collision/Response/FrictionContactConstraint": touching(
        answer='<CollisionResponse response="FrictionContactConstraint" responseParams="mu=0.3"/>', loop=FREE,
        more="<UncoupledConstraintCorrection/>"),
    "Collision/Response/RuleBasedContactManager_rules": touching(
        answer='<RuleBasedContactManager variables="law" law="FrictionContactConstraint?mu=0.2" rules="model * $law$"/>', loop=FREE,
        more="<LinearSolverConstraintCorrection/>"),
    "Collision/Response/RuleBasedContactManager": touching(
        answer='<RuleBasedContactManager responseParams="mu=0" response="PenalityContactForceField"/>'),
    "Collision/Response/CollisionGroupManager": touching(more="<CollisionGroupManager/>"),
    # ---- Constraint ----
    "Constraint/Lagrangian/BilateralLagrangianConstraint": chain(
        '<BilateralLagrangianConstraint object1="@one/dofs" object2="@other/dofs" first_point="2" second_point="0"/>'),
    "Constraint/Lagrangian/BilateralInteractionConstraint_NNCG": chain(
        '<BilateralInteractionConstraint template="Vec3d" object1="@one/dofs" object2="@other/dofs" first_point="2" second_point="0"/>',
        loop='<FreeMotionAnimationLoop/><NNCGConstraintSolver tolerance="1e-9" maxIterations="500"/>'),
    "Constraint/Lagrangian/FixedLagrangianConstraint": body(
        POINTS + '<FixedLagrangianConstraint indices="0"/><LinearSolverConstraintCorrection/>', ODE + LDL, FREE),
    "Constraint/Lagrangian/SlidingLagrangianConstraint": chain(
        '<SlidingLagrangianConstraint object1="@other/dofs" object2="@one/dofs" sliding_point="0" axis_1="1" axis_2="2"/>'),
    "Constraint/Lagrangian/StopperLagrangianConstraint": body(
        '<MechanicalObject template="Vec1d" name="dofs" position="0" velocity="1"/><UniformMass totalMass="1"/>'
        '<StopperLagrangianConstraint index="0" min="-1" max="0.05"/><LinearSolverConstraintCorrection/>', ODE + LDL, FREE),
    "Constraint/Lagrangian/UniformLagrangianConstraint": body(
        POINTS + '<FixedProjectiveConstraint indices="0"/><Node name="lengths"><MeshTopology edges="0 1  1 2  2 3"/><MechanicalObject '
        'template="Vec1d"/><DistanceMapping/><UniformLagrangianConstraint template="Vec1d"/></Node><LinearSolverConstraintCorrection/>',
        ODE + LDL, FREE),
    "Constraint/Lagrangian/PrecomputedConstraintCorrection": chain(
        '<BilateralLagrangianConstraint object1="@one/dofs" object2="@other/dofs" first_point="2" second_point="0"/>',
        correction='<PrecomputedConstraintCorrection recompute="true"/>'),
    "Constraint/Projective/AffineMovementProjectiveConstraint": block(
        '<AffineMovementProjectiveConstraint indices="3 7 11" beginConstraintTime="0" endConstraintTime="1" '
        'rotation="1 0 0 0 1 0 0 0 1" translation="0.1 0 0"/>'),
    "Constraint/Projective/AttachProjectiveConstraint": root(
        f'<Node name="a">{ODE}{CG}<Node name="one">{POINTS}<FixedConstraint indices="0 1 2 3"/></Node><Node name="two">'
        '<MechanicalObject name="dofs" position="3 0 0  4 0 0"/><UniformMass totalMass="2"/></Node>'
        '<AttachProjectiveConstraint object1="@one" object2="@two" indices1="3" indices2="0" constraintFactor="1" twoWay="0"/></Node>'),
    "Constraint/Projective/BilinearMovementProjectiveConstraint": sheet(
        '<BilinearMovementProjectiveConstraint meshIndices="0 3 12 15" indices="0 3 12 15" beginConstraintTime="0" endConstraintTime="1" '
        'cornerPoints="0 0 0  3 0 0  3 3 0  0 3 0" cornerMovements="0 0 0  0.1 0 0  0.1 0.1 0  0 0 0"/>'),
    "Constraint/Projective/DirectionProjectiveConstraint": block('<DirectionProjectiveConstraint indices="3" direction="1 0 0"/>'),
    "Constraint/Projective/BoxConstraint": body(GRID + '<UniformMass totalMass="36"/>' + HEXA +
                                                '<BoxConstraint box="-0.1 -1 -1 0.1 2 2" drawSize="3"/>'),
    "Constraint/Projective/FixedPlaneProjectiveConstraint": block(
        '<FixedPlaneProjectiveConstraint direction="1 0 0" dmin="2.9" dmax="3.1" setRangeFromDMinDMax="1"/>'),
    "Constraint/Projective/FixedRotationProjectiveConstraint": body(
        FRAMES + '<UniformMass/><FixedRotationProjectiveConstraint FixedXRotation="1" FixedYRotation="0" FixedZRotation="0"/>'),
    "Constraint/Projective/FixedTranslationProjectiveConstraint": body(
        FRAMES + '<UniformMass/><FixedTranslationProjectiveConstraint indices="0"/>'),
    "Constraint/Projective/HermiteSplineProjectiveConstraint": body(
        POINTS + '<HermiteSplineProjectiveConstraint indices="0" BeginTime="0" EndTime="1" X0="0 0 0" dX0="1 0 0" X1="1 1 0" dX1="0 1 0"/>'),
    "Constraint/Projective/LineProjectiveConstraint": block('<LineProjectiveConstraint indices="3" origin="3 0 0" direction="0 1 0"/>'),
    "Constraint/Projective/LinearMovementProjectiveConstraint": block(
        '<LinearMovementProjectiveConstraint indices="3 7" keyTimes="0 1 3" movements="0 0 0  0.1 0 0  0 0.1 0" showMovement="1"/>'),
    "Constraint/Projective/LinearVelocityProjectiveConstraint": block(
        '<LinearVelocityProjectiveConstraint indices="3" keyTimes="0 1" velocities="0 0 0  0.1 0 0" coordinates="0"/>'),
    "Constraint/Projective/OscillatorProjectiveConstraint": body(POINTS + '<OscillatorConstraint oscillators="0  0 0 0  0 1 0  10 0"/>'),
    "Constraint/Projective/ParabolicProjectiveConstraint": body(
        POINTS + '<ParabolicProjectiveConstraint indices="0" P1="0 0 0" P2="1 1 0" P3="2 0 0" BeginTime="0" EndTime="1"/>'),
    "Constraint/Projective/PartialFixedProjectiveConstraint": block('<PartialFixedConstraint indices="3" fixedDirections="1 0 1"/>'),
    "Constraint/Projective/PartialLinearMovementProjectiveConstraint": block(
        '<PartialLinearMovementConstraint indices="3" keyTimes="0 1" movements="0 0 0  0.1 0 0" movedDirections="1 0 0"/>'),
    "Constraint/Projective/PatchTestMovementProjectiveConstraint": sheet(
        '<PatchTestMovementConstraint meshIndices="0 3" indices="0 3" beginConstraintTime="0" endConstraintTime="1" '
        'cornerPoints="0 0 0  3 0 0  3 3 0  0 3 0" cornerMovements="0 0 0  0.1 0 0  0.1 0 0  0 0 0"/>'),
    "Constraint/Projective/PlaneProjectiveConstraint": block('<PlaneProjectiveConstraint indices="3" origin="3 0 0" normal="1 0 0"/>'),
    "Constraint/Projective/PointProjectiveConstraint": block('<PointProjectiveConstraint indices="3" point="3 0 0"/>'),
    # ---- Controller, Diffusion, Haptics ----
    "Controller/MechanicalStateController": body(FRAMES + '<UniformMass/><MechanicalStateController index="0" onlyTranslation="1"/>'),
    "Controller/NodeToggleController": block("<NodeToggleController key=\"K\"/>"),
    "Diffusion/TetrahedronDiffusionFEMForceField": body(
        TETRA + '<Node name="heat"><MechanicalObject name="temperature" template="Vec1d" size="8"/><TetrahedronDiffusionFEMForceField '
        'template="Vec1d" constantDiffusionCoefficient="1" mechanicalObject="@../dofs"/></Node>'),
    "Haptics/LCPForceFeedback": body(FRAMES + '<UniformMass/><LCPForceFeedback activate="true" forceCoef="0.1"/>'),
    # ---- Engine ----
    "Engine/Analyze/HausdorffDistance": block('<HausdorffDistance testedPoints="@dofs.position" modelPoints="@grid.position"/>'),
    "Engine/Analyze/ShapeMatching": block('<ShapeMatching name="match" position="@dofs.position" iterations="1"/>'
                                          '<RestShapeSpringsForceField points="0" stiffness="1" external_points="0"/>'),
    "Engine/Analyze/ClusteringEngine": block('<ClusteringEngine name="clusters" position="@dofs.rest_position" radius="1"/>'),
    "Engine/Generate/ExtrudeSurface": engine(
        NET + '<ExtrudeSurface name="e" surfaceVertices="@net.position" triangles="@net.triangles" surfaceTriangles="0 1" heightFactor="0.5"/>',
        "e.extrusionVertices"),
    "Engine/Generate/ExtrudeQuadsAndGenerateHexas": engine(
        NET + '<ExtrudeQuadsAndGenerateHexas name="e" surfaceVertices="@net.position" surfaceQuads="@net.quads" thicknessOut="0.5"/>',
        "e.extrudedVertices"),
    "Engine/Generate/GenerateCylinder": body(
        '<GenerateCylinder name="e" radius="0.2" height="1" resCircumferential="6" resRadial="2" resHeight="4"/>'
        '<TetrahedronSetTopologyContainer name="cells" tetrahedra="@e.tetrahedra" position="@e.output_TetrahedraPosition"/>'
        '<MechanicalObject/><DiagonalMass massDensity="1"/><TetrahedralCorotationalFEMForceField youngModulus="1000" '
        'poissonRatio="0.3" method="large"/><BoxROI name="box" box="-1 -1 -0.1 1 1 0.1"/><FixedConstraint indices="@box.indices"/>'),
    "Engine/Generate/GenerateGrid": engine('<GenerateGrid name="e" min="0 0 0" max="1 1 1" resolution="2 2 2"/>', "e.output_position"),
    "Engine/Generate/GenerateRigidMass": body(
        SHELL + '<GenerateRigidMass name="e" position="@shell.position" triangles="@shell.triangles" density="1000"/>'
        '<MechanicalObject template="Rigid3d" position="0 0 0 0 0 0 1"/><UniformMass vertexMass="@e.rigidMass"/>'),
    "Engine/Generate/MergeMeshes": engine(
        NET + '<MergeMeshes name="e" nbMeshes="2" position1="@net.position" triangles1="@net.triangles" position2="@net.position" '
        'triangles2="@net.triangles"/>', "e.position"),
    "Engine/Generate/MergePoints": engine('<MergePoints name="e" template="Vec3d" position1="0 0 0" position2="1 0 0"/>', "e.points"),
    "Engine/Generate/MergeVectors": engine(
        '<MergeVectors name="e" template="vector&lt;Vec3d&gt;" nbInputs="2" input1="0 0 0" input2="1 0 0"/>', "e.output"),
    "Engine/Generate/MeshClosingEngine": engine(
        NET + '<MeshClosingEngine name="e" inputPosition="@net.position" inputTriangles="@net.triangles"/>', "e.position"),
    "Engine/Generate/MeshBarycentricMapperEngine": block(
        '<MeshBarycentricMapperEngine name="e" inputPositions="@grid.position" mappedPointPositions="0.5 0.5 0.5"/>'),
    "Engine/Generate/RandomPointDistributionInSurface": block(
        '<RandomPointDistributionInSurface vertices="@grid.position" triangles="@grid.triangles"/>'),
    "Engine/Generate/Spiral": engine('<Spiral name="e" rest_position="0 0 0  1 0 0"/>', "e.position"),
    "Engine/Generate/VolumeFromTriangles": block('<VolumeFromTriangles position="@dofs.position" quads="@grid.quads"/>'),
    "Engine/Generate/VolumeFromTetrahedrons": body(TETRA + '<VolumeFromTetrahedrons position="@dofs.position" '
                                                   'tetras="@cells.tetrahedra"/>'),
    "Engine/Generate/NormalsFromPoints": block('<NormalsFromPoints position="@dofs.position" triangles="@grid.triangles"/>'),
    "Engine/Select/BoxROI": selected('<BoxROI name="roi" box="-0.1 -0.1 -0.1 0.1 1.1 1.1" position="@dofs.rest_position" drawBoxes="1"/>'),
    "Engine/Select/BoxROI_oriented": selected('<BoxROI name="roi" orientedBox="0 -1 0  0 2 0  0 2 1  4"/>'),
    "Engine/Select/ComplementaryROI": selected('<BoxROI name="some" box="0.5 -1 -1 4 2 2"/><ComplementaryROI name="roi" '
                                               'position="@dofs.rest_position" nbSet="1" setIndices1="@some.indices"/>'),
    "Engine/Select/MeshBoundaryROI": sheet('<TriangularFEMForceField youngModulus="100" poissonRatio="0.3"/>'
                                           '<MeshBoundaryROI name="roi" triangles="@grid.triangles"/><FixedConstraint indices="@roi.indices"/>'),
    "Engine/Select/MeshROI": selected('<MeshROI name="roi" ROIposition="-1 -1 -1  3 -1 -1  -1 3 -1  -1 -1 3" '
                                      'ROItriangles="0 2 1  0 1 3  1 2 3  2 0 3"/>'),
    "Engine/Select/MeshSampler": block('<MeshSampler name="e" position="@dofs.rest_position" number="3"/>'),
    "Engine/Select/MeshSplittingEngine": block('<MeshSplittingEngine name="e" position="@dofs.rest_position" nbInputs="1"/>'),
    "Engine/Select/MeshSubsetEngine": engine(
        NET + '<MeshSubsetEngine name="e" inputPosition="@net.position" inputTriangles="@net.triangles" indices="0 1 2"/>', "e.position"),
    "Engine/Select/NearestPointROI": chain('<NearestPointROI name="near" object1="@one/dofs" object2="@other/dofs" radius="0.1"/>'
                                           '<StiffSpringForceField object1="@one/dofs" object2="@other/dofs" '
                                           'springsIndices1="@near.indices1" springsIndices2="@near.indices2" stiffness="100"/>',
                                           LOOP, ODE + CG, ""),
    "Engine/Select/PairBoxROI": selected('<PairBoxROI name="roi" inclusiveBox="-1 -1 -1 4 2 2" includedBox="0.5 -1 -1 4 2 2"/>'),
    "Engine/Select/PlaneROI": selected('<PlaneROI name="roi" plane="0 0 0  0 1 0  0 0 1  0.5"/>'),
    "Engine/Select/PointsFromIndices": engine(
        NET + '<PointsFromIndices name="e" position="@net.position" indices="0 2"/>', "e.indices_position"),
    "Engine/Select/ProximityROI": selected('<ProximityROI name="roi" centers="0 0 0  0 1 1" radii="0.6 0.6" N="4"/>'),
    "Engine/Select/SphereROI": selected('<SphereROI name="roi" centers="0 0.5 0.5" radii="0.8"/>'),
    "Engine/Select/SubsetTopology": block('<SubsetTopology name="e" box="-1 -1 -1 1 2 2" rest_position="@grid.position"/>'),
    "Engine/Select/ValuesFromPositions": block('<ValuesFromPositions name="e" inputValues="1 2" position="@dofs.rest_position"/>'),
    "Engine/Select/IndexValueMapper": block('<IndexValueMapper name="e" indices="0 1" value="5"/>'),
    "Engine/Transform/DisplacementMatrixEngine": block('<DisplacementMatrixEngine template="Rigid3d"/>'),
    "Engine/Transform/SmoothMeshEngine": engine(
        NET + '<SmoothMeshEngine name="e" topology="@net" input_position="@net.position" nb_iterations="2"/>', "e.output_position"),
    "Engine/Transform/TransformEngine": engine(
        NET + '<TransformEngine name="e" input_position="@net.position" translation="0 1 0" rotation="0 0 90" scale="1 2 3"/>',
        "e.output_position"),
    "Engine/Transform/TransformPosition": engine(
        NET + '<TransformPosition name="e" input_position="@net.position" method="translation" translation="0 1 0"/>', "e.output_position"),
    "Engine/Transform/TransformPosition_random": engine(
        NET + '<TransformPosition name="e" input_position="@net.position" method="random" maxRandomDisplacement="0.1"/>',
        "e.output_position"),
    "Engine/Transform/MathOp": engine(
        NET + '<MathOp name="e" template="Vec3d" nbInputs="2" input1="@net.position" input2="0 0 1" op="+"/>', "e.output"),
    # ---- IO ----
    "IO/Mesh/MeshOBJLoader": body('<MeshOBJLoader name="loader" filename="mesh/square.obj"/><TriangleSetTopologyContainer src="@loader"/>'
                                  '<MechanicalObject src="@loader"/><UniformMass totalMass="1"/><TriangularFEMForceField youngModulus="100" '
                                  'poissonRatio="0.3"/><FixedConstraint indices="0 1"/>'),
    "IO/Mesh/MeshGmshLoader": body(TETRA + '<TetrahedronFEMForceField youngModulus="1000" poissonRatio="0.3"/>' + HOLD),
    "IO/Mesh/MeshOffLoader": body('<MeshOffLoader name="loader" filename="mesh/square.off"/><MeshTopology src="@loader"/>'
                                  '<MechanicalObject/><UniformMass totalMass="1"/>'),
    "IO/Mesh/MeshSTLLoader": body('<MeshSTLLoader name="loader" filename="mesh/one.stl"/><MeshTopology src="@loader"/>'
                                  '<MechanicalObject/><UniformMass totalMass="1"/>'),
    "IO/Mesh/MeshVTKLoader": body('<MeshVTKLoader name="loader" filename="mesh/one.vtk"/><MeshTopology src="@loader"/>'
                                  '<MechanicalObject/><UniformMass totalMass="1"/>'),
    "IO/Mesh/MeshTrianLoader": body('<MeshTrianLoader name="loader" filename="mesh/one.trian"/><MeshTopology src="@loader"/>'
                                    '<MechanicalObject/><UniformMass totalMass="1"/>'),
    "IO/Mesh/MeshXspLoader": body('<MeshXspLoader name="loader" filename="mesh/one.xs3"/><MeshTopology src="@loader"/>'
                                  '<MechanicalObject/><UniformMass totalMass="1"/>'),
    "IO/Mesh/GIDMeshLoader": body('<GIDMeshLoader name="loader" filename="mesh/one.gid"/><MeshTopology src="@loader"/>'
                                  '<MechanicalObject/><UniformMass totalMass="1"/>'),
    "IO/Mesh/SphereLoader": body('<SphereLoader name="loader" filename="mesh/two.sph"/><MechanicalObject position="@loader.position"/>'
                                 '<UniformMass totalMass="1"/><SphereCollisionModel listRadius="@loader.listRadius"/>'),
    "IO/Mesh/GridMeshCreator": body('<GridMeshCreator name="loader" resolution="4 4" trianglePattern="1"/><MeshTopology src="@loader"/>'
                                    '<MechanicalObject src="@loader" scale="3"/><UniformMass totalMass="1"/><MeshSpringForceField '
                                    'linesStiffness="100" linesDamping="1"/><FixedConstraint indices="0 3"/>'),
    "IO/Mesh/StringMeshCreator": body('<StringMeshCreator name="loader" resolution="8"/><MeshTopology edges="@loader.edges"/>'
                                      '<MechanicalObject src="@loader"/><UniformMass totalMass="1"/><MeshSpringForceField '
                                      'linesStiffness="100" linesDamping="1"/><FixedConstraint indices="0"/>'),
    "IO/Mesh/VTKExporter": block('<VTKExporter filename="out/a" XMLformat="1" edges="0" hexas="1" exportEveryNumberOfSteps="5"/>'),
    "IO/Mesh/STLExporter": block('<STLExporter filename="out/b" exportEveryNumberOfSteps="5"/>'),
    # ---- LinearSolver, LinearSystem ----
    **{f"LinearSolver/Direct/{name}": block(solver=ODE + f"<{name}/>") for name in (
        "SparseLDLSolver", "AsyncSparseLDLSolver", "EigenSimplicialLDLT", "EigenSimplicialLLT", "EigenSparseLU", "EigenSparseQR",
        "CholeskySolver", "SparseCholeskySolver", "SparseLUSolver", "SVDLinearSolver", "PrecomputedLinearSolver")},
    "LinearSolver/Direct/BTDLinearSolver": body(
        FRAMES + '<UniformMass/><MeshTopology edges="0 1  1 2"/><BeamFEMForceField radius="0.1" youngModulus="1e6" poissonRatio="0.3"/>'
        '<FixedConstraint indices="0"/>', ODE + '<BTDLinearSolver template="BTDMatrix6d"/>'),
    "LinearSolver/Iterative/MinResLinearSolver": block(solver=ODE + '<MinResLinearSolver iterations="50" tolerance="1e-9"/>'),
    "LinearSolver/Iterative/CGLinearSolver_assembled": block(
        solver=ODE + '<CGLinearSolver template="CompressedRowSparseMatrixMat3x3d" iterations="25" tolerance="1e-9" threshold="1e-9"/>'),
    "LinearSolver/Ordering/AMDOrderingMethod": block(
        solver=ODE + '<AMDOrderingMethod name="order"/><EigenSimplicialLDLT orderingMethod="@order"/>'),
    **{f"LinearSolver/Preconditioner/{name}": block(
        solver=ODE + f'<PCGLinearSolver iterations="50" tolerance="1e-9" preconditioner="@pre"/><{name} name="pre"/>') for name in (
            "JacobiPreconditioner", "BlockJacobiPreconditioner", "SSORPreconditioner", "PrecomputedWarpPreconditioner")},
    "LinearSolver/Preconditioner/WarpPreconditioner": block(
        solver=ODE + '<PCGLinearSolver iterations="50" tolerance="1e-9" preconditioner="@warp"/><SparseLDLSolver name="exact"/>'
        '<RotationMatrixSystem name="turned"/><WarpPreconditioner name="warp" linearSystem="@turned" linearSolver="@exact"/>'),
    "LinearSystem/MatrixLinearSystem": block(solver=ODE + '<MatrixLinearSystem name="system" template="CompressedRowSparseMatrixMat3x3"/>'
                                             '<SparseLDLSolver linearSystem="@system"/>'),
    "LinearSystem/CompositeLinearSystem": block(
        solver=ODE + '<ConstantSparsityPatternSystem name="a"/><MatrixLinearSystem name="b"/><CompositeLinearSystem name="both" '
        'linearSystems="@a @b" solverLinearSystem="@a"/><SparseLDLSolver linearSystem="@both"/>'),
    # ---- Mapping ----
    "Mapping/Linear/BarycentricMapping": mapped('<BarycentricMapping input="@.." output="@."/>'),
    "Mapping/Linear/BarycentricTetraMapping": body(
        TETRA + '<TetrahedronFEMForceField youngModulus="1000" poissonRatio="0.3"/>' + HOLD +
        '<Node name="child"><MechanicalObject position="0.3 0.3 0.3"/><BarycentricMapping/></Node>'),
    "Mapping/Linear/CenterOfMassMultiMapping": body(
        '<Node name="a"><MechanicalObject name="dofs" position="0 0 0  2 0 0"/><UniformMass totalMass="2"/></Node><Node name="b">'
        '<MechanicalObject name="dofs" position="0 3 0"/><UniformMass totalMass="1"/></Node><Node name="c"><MechanicalObject '
        'name="centre" position="0 0 0"/><CenterOfMassMultiMapping template="Vec3d,Vec3d" input="@../a @../b" output="@."/>'
        '<RestShapeSpringsForceField stiffness="100"/></Node>'),
    "Engine/Generate/MeshTetraStuffing": body(
        '<MeshOBJLoader name="loader" filename="mesh/ball.obj"/><MeshTetraStuffing name="e" inputPoints="@loader.position" inputTriangles='
        '"@loader.triangles" inputQuads="@loader.quads" size="-4" snapPoints="true" splitTetras="true" draw="0"/>'
        '<TetrahedronSetTopologyContainer name="cells" position="@e.outputPoints" tetrahedra="@e.outputTetrahedra"/><MechanicalObject/>'
        '<UniformMass totalMass="1"/><TetrahedronFEMForceField youngModulus="1000" poissonRatio="0.3"/>'),
    "Engine/Generate/GenerateSphere": body(
        '<GenerateSphere name="e" radius="1" tessellationDegree="2"/><TetrahedronSetTopologyContainer name="cells" '
        'position="@e.output_TetrahedraPosition" tetrahedra="@e.tetrahedra"/><MechanicalObject/><DiagonalMass massDensity="1"/>'
        '<TetrahedronFEMForceField youngModulus="1000" poissonRatio="0.3"/>'),
    "Engine/Transform/TransformMatrixEngine": body(
        '<TranslateTransformMatrixEngine name="t" translation="0 1 0"/><RotateTransformMatrixEngine name="r" inT="@t.outT" '
        'rotation="0 0 90"/><ScaleTransformMatrixEngine name="s" inT="@r.outT" scale="2 2 2"/><MeshGmshLoader name="loader" '
        'filename="mesh/block.msh" transformation="@s.outT"/><TetrahedronSetTopologyContainer src="@loader"/><MechanicalObject '
        'src="@loader"/><DiagonalMass massDensity="1"/>'),
    "SolidMechanics/Spring/RepulsiveSpringForceField": body(POINTS + '<RepulsiveSpringForceField spring="0 1 10 0.1 1.5  1 2 10 0.1 0.5"/>'),
    "Mapping/Linear/CenterOfMassMapping": body(
        FRAMES + '<UniformMass vertexMass="2"/><Node name="child"><MechanicalObject name="mapped" position="0 0 0"/><CenterOfMassMapping '
        'template="Rigid3d,Vec3d"/><RestShapeSpringsForceField stiffness="10"/></Node>', ODE + CG),
    "Mapping/Linear/DeformableOnRigidFrameMapping": body(
        '<Node name="rigid">' + FRAMES + '<UniformMass vertexMass="1"/></Node><Node name="soft">' + POINTS +
        '<RestShapeSpringsForceField stiffness="100"/><Node name="child"><MechanicalObject name="m"/><DeformableOnRigidFrameMapping '
        'template="Vec3d,Rigid3d,Vec3d" input1="@../dofs" input2="@../../rigid/dofs" output="@m" index="1" '
        'rootAngularForceScaleFactor="1"/><PlaneForceField normal="0 1 0" d="-5"/></Node></Node>'),
    "Mapping/Linear/DistanceToPlaneMapping": numbers('<DistanceToPlaneMapping planeNormal="0 1 0" planePoint="0 0 0"/>'),
    "Mapping/Linear/IdentityMapping": mapped('<IdentityMapping input="@../dofs" output="@mapped"/>', 'src="@../grid"'),
    "Mapping/Linear/IdentityMultiMapping": root(
        f'<Node name="all">{ODE}{CG}<Node name="a">{POINTS}</Node><Node name="b">{POINTS}</Node><Node name="both"><MechanicalObject '
        'name="mapped"/><IdentityMultiMapping template="Vec3d,Vec3d" input="@../a/dofs @../b/dofs" output="@mapped"/>'
        '<SpringForceField spring="0 5 100 1 1"/></Node></Node>'),
    "Mapping/Linear/SkinningMapping": body(
        FRAMES + '<UniformMass/><FixedConstraint indices="0"/><Node name="child"><MechanicalObject position="0.5 0.2 0  1.5 0.2 0"/>'
        '<SkinningMapping nbRef="2"/></Node>'),
    "Mapping/Linear/SubsetMapping": mapped('<SubsetMapping indices="0 5"/>', ""),
    "Mapping/Linear/SubsetMultiMapping": root(
        f'<Node name="all">{ODE}{CG}<Node name="a">{POINTS}</Node><Node name="b">{POINTS}</Node><Node name="both"><MechanicalObject '
        'name="mapped" position="0 0 0  1 0 0"/><SubsetMultiMapping template="Vec3d,Vec3d" input="@../a/dofs @../b/dofs" '
        'output="@mapped" indexPairs="0 0  1 1"/><SpringForceField spring="0 1 100 1 1"/></Node></Node>'),
    "Mapping/Linear/TubularMapping": body(
        FRAMES + '<UniformMass/><MeshTopology name="line" edges="0 1  1 2"/><FixedConstraint indices="0"/><Node name="tube">'
        '<QuadSetTopologyContainer name="quads"/><Edge2QuadTopologicalMapping nbPointsOnEachCircle="8" radius="0.2" '
        'input="@../line" output="@quads"/><MechanicalObject/><TubularMapping nbPointsOnEachCircle="8" radius="0.2"/>'
        '<SurfacePressureForceField pressure="1"/></Node>'),
    "Mapping/Linear/BeamLinearMapping": body(
        FRAMES + '<UniformMass/><MeshTopology edges="0 1  1 2"/><BeamFEMForceField radius="0.1" youngModulus="1e6" poissonRatio="0.3"/>'
        '<FixedConstraint indices="0"/><Node name="child"><MechanicalObject position="0.5 0 0  1.5 0 0"/><BeamLinearMapping '
        'isMechanical="true"/></Node>', ODE + LDL),
    "Mapping/NonLinear/AreaMapping": numbers('<AreaMapping template="Vec3d,Vec1d" topology="@../net" applyRestPosition="true"/>'),
    "Mapping/NonLinear/VolumeMapping": numbers('<VolumeMapping template="Vec3d,Vec1d" topology="@../net" applyRestPosition="true"/>'),
    "Mapping/NonLinear/SquareMapping": body(
        '<MechanicalObject name="dofs" template="Vec1d" position="1 2"/><UniformMass totalMass="2"/><Node name="child"><MechanicalObject '
        'template="Vec1d"/><SquareMapping/><RestShapeSpringsForceField stiffness="10"/></Node>', ODE + LDL),
    "Mapping/NonLinear/DistanceMapping": numbers('<DistanceMapping topology="@../net" applyRestPosition="true"/>'),
    "Mapping/NonLinear/SquareDistanceMapping": numbers('<SquareDistanceMapping topology="@../net" applyRestPosition="true"/>'),
    "Mapping/NonLinear/DistanceFromTargetMapping": numbers(
        '<DistanceFromTargetMapping indices="1 2" targetPositions="3 0 0  0 3 0" restLengths="1 1"/>'),
    "Mapping/NonLinear/RigidMapping": body(
        FRAMES + '<UniformMass/><Node name="child"><MechanicalObject position="0 1 0  0 2 0"/><RigidMapping index="1" '
        'globalToLocalCoords="0"/></Node>'),
    "Mapping/NonLinear/RigidMapping2d": body(
        '<MechanicalObject template="Rigid2d" position="0 0 0"/><UniformMass/><Node name="child"><MechanicalObject template="Vec2d" '
        'position="0 1"/><RigidMapping template="Rigid2d,Vec2d"/></Node>'),
    "Mapping/NonLinear/RigidRigidMapping": body(
        FRAMES + '<UniformMass/><Node name="child"><MechanicalObject template="Rigid3d" position="0 1 0 0 0 0 1"/><RigidRigidMapping '
        'index="0"/></Node>'),
    "Mapping/MappedMatrix/MechanicalMatrixMapper": block(
        '<MechanicalMatrixMapper template="Vec3d,Vec3d" object1="@dofs" object2="@dofs" nodeToParse="@child"/><Node name="child">'
        '<MechanicalObject position="0.5 0.5 0.5"/><BarycentricMapping/><RestShapeSpringsForceField stiffness="5"/></Node>',
        solver=ODE + LDL),
    # ---- Mass ----
    "Mass/UniformMass": block(mass='<UniformMass vertexMass="1" printLog="0"/>'),
    "Mass/DiagonalMass": block(mass='<DiagonalMass massDensity="12" showGravityCenter="1"/>'),
    "Mass/MeshMatrixMass": body(TETRA.replace("<DiagonalMass massDensity", "<MeshMatrixMass massDensity") +
                                '<TetrahedronFEMForceField youngModulus="1000" poissonRatio="0.3"/>' + HOLD),
    "Mass/FEMMass": block(mass='<NodalMassDensity property="12"/><FEMMass template="Vec3,Hexahedron"/>', solver=ODE + LDL),
    # ---- MechanicalLoad ----
    "MechanicalLoad/ConstantForceField": block('<ConstantForceField indices="3 7" forces="1 0 0  0 1 0" showArrowSize="0.1"/>'),
    "MechanicalLoad/ConicalForceField": block('<ConicalForceField coneCenter="1 -1 0" coneHeight="0 1 0" coneAngle="10" stiffness="1"/>'),
    "MechanicalLoad/DiagonalVelocityDampingForceField": block('<DiagonalVelocityDampingForceField dampingCoefficient="1 1 1"/>'),
    "MechanicalLoad/EdgePressureForceField": sheet('<EdgePressureForceField edges="0 1" p_intensity="1" binormal="0 0 1"/>'
                                                   '<MeshSpringForceField stiffness="100"/>'),
    "MechanicalLoad/EllipsoidForceField": block('<EllipsoidForceField center="1 -3 0" vradius="2 2 2" stiffness="100"/>'),
    "MechanicalLoad/InteractionEllipsoidForceField": root(
        f'<Node name="a">{ODE}{CG}<Node name="rigid">{FRAMES}<UniformMass/></Node><Node name="soft">{POINTS}</Node>'
        '<InteractionEllipsoidForceField object1="@soft/dofs" object2="@rigid/dofs" center="0 0 0" vradius="1 1 1" stiffness="10"/></Node>'),
    "MechanicalLoad/LinearForceField": block('<LinearForceField points="3" times="0 1" forces="0 0 0  1 0 0" force="1"/>'),
    "MechanicalLoad/OscillatingTorsionPressureForceField": sheet(
        '<OscillatingTorsionPressureForceField moment="1" triangleList="0 1" axis="0 0 1" frequency="1"/>'),
    "MechanicalLoad/PlaneForceField": block('<PlaneForceField normal="0 1 0" d="-2" stiffness="100" showPlane="1"/>'),
    "MechanicalLoad/QuadPressureForceField": sheet('<QuadPressureForceField quadList="0" pressure="0 0 1"/><MeshSpringForceField '
                                                   'stiffness="100"/>'),
    "MechanicalLoad/SphereForceField": block('<SphereForceField center="1 -5 0" radius="3" stiffness="100"/>'),
    "MechanicalLoad/SurfacePressureForceField": block('<SurfacePressureForceField pressure="5" pulseMode="0"/>'),
    "MechanicalLoad/TaitSurfacePressureForceField": body(
        SHELL + '<MechanicalObject/><UniformMass totalMass="1"/><TaitSurfacePressureForceField p0="0" B="10" gamma="1.4" '
        'injectedVolume="0.1" topology="@shell"/><RestShapeSpringsForceField stiffness="100"/>'),
    "MechanicalLoad/TorsionForceField": block('<TorsionForceField indices="3" torque="1" axis="1 0 0" origin="0 0 0"/>'),
    "MechanicalLoad/TrianglePressureForceField": sheet('<TrianglePressureForceField triangleList="0" pressure="0 0 1" showForces="1"/>'
                                                       '<MeshSpringForceField stiffness="100"/>'),
    "MechanicalLoad/UniformVelocityDampingForceField": block('<UniformVelocityDampingForceField dampingCoefficient="1" implicit="1"/>'),
    # ---- ODESolver ----
    **{f"ODESolver/Backward/{name}": block(solver=f"<{name} {more}/>{LDL}") for name, more in (
        ("EulerImplicitSolver", 'trapezoidalScheme="1"'), ("NewmarkImplicitSolver", 'gamma="0.5" beta="0.25"'),
        ("BDFOdeSolver", 'order="2" rayleighStiffness="0"'), ("VariationalSymplecticSolver", 'steps="5" newtonError="1e-6"'))},
    "ODESolver/Backward/StaticSolver": block(solver='<StaticSolver name="static" newtonSolver="@newton"/><NewtonRaphsonSolver '
                                             f'name="newton" maxNbIterationsNewton="20" warnWhenDiverge="0"/>{LDL}'),
    **{f"ODESolver/Forward/{name}": block(solver=f"<{name} {more}/>") for name, more in (
        ("EulerExplicitSolver", 'symplectic="1"'), ("RungeKutta2Solver", ""), ("RungeKutta4Solver", ""),
        ("CentralDifferenceSolver", 'rayleighMass="0"'))},
    "ODESolver/Forward/DampVelocitySolver": block(solver='<EulerExplicitSolver/><DampVelocitySolver rate="0.9" threshold="0"/>'),
    # ---- Playback, Setting, StateContainer, Visual ----
    "Playback/WriteState": block('<WriteState filename="out/states.txt" period="0.05" writeX="1" writeV="1"/>'),
    "Playback/CompareState": block('<CompareState filename="mesh/none.state"/>'),
    "Setting/ViewerSetting": block(more='<ViewerSetting resolution="800 600"/><BackgroundSetting color="1 1 1 1"/>'
                                   '<StatsSetting dumpState="0"/><AttachBodyButtonSetting button="Left"/>'),
    "StateContainer/MechanicalObject": block(more='<Node name="alone"><MechanicalObject template="Vec3d" size="3"/></Node>'),
    "Visual/OglModel": block('<Node name="seen"><MeshOBJLoader name="loader" filename="mesh/none.obj"/><OglModel src="@loader" '
                             'color="red"/><BarycentricMapping/></Node>'),
    "Visual/InteractiveCamera": block(more='<InteractiveCamera position="0 0 9" lookAt="0 0 0"/><LightManager/><DirectionalLight/>'
                                      '<OglSceneFrame/><VisualGrid plane="z" nbSubdiv="10"/>'),
    # ---- SolidMechanics ----
    "SolidMechanics/FEM/HexahedronFEMForceField": block(),
    **{f"SolidMechanics/FEM/{name}_{method}": block(field=f'<{name} method="{method}" youngModulus="3000" poissonRatio="0.3" {more}/>',
                                                    mass=mass)
       for name, method, more, mass in (
           ("HexahedronFEMForceField", "polar", 'updateStiffnessMatrix="0"', '<UniformMass totalMass="36"/>'),
           ("HexahedralFEMForceField", "large", "", '<UniformMass totalMass="36"/>'),
           ("HexahedronFEMForceFieldAndMass", "large", 'density="1" lumpedMass="1"', ""),
           ("HexahedralFEMForceFieldAndMass", "large", 'density="1" lumpedMass="1"', ""),
           ("HexahedronCompositeFEMForceFieldAndMass", "large", 'density="1" lumpedMass="1" nbVirtualFinerLevels="1"', ""),
           ("NonUniformHexahedronFEMForceFieldAndMass", "large", 'density="1" nbVirtualFinerLevels="1"', ""))},
    **{f"SolidMechanics/FEM/{name}": body(TETRA + f'<{name} youngModulus="1000" poissonRatio="0.3" {more}/>' + HOLD) for name, more in (
        ("TetrahedronFEMForceField", 'method="large" computeVonMisesStress="1" listening="1"'),
        ("TetrahedralCorotationalFEMForceField", 'method="polar"'), ("FastTetrahedralCorotationalForceField", 'method="qr"'),
        ("CorotationalFEMForceField", 'template="Vec3,Tetrahedron"'), ("LinearSmallStrainFEMForceField", 'template="Vec3,Tetrahedron"'))},
    "SolidMechanics/FEM/TetrahedronFEMForceField_plasticity": body(
        TETRA + '<TetrahedronFEMForceField method="polar" youngModulus="1000" poissonRatio="0.3" plasticMaxThreshold="0.5" '
        'plasticYieldThreshold="0.01" plasticCreep="0.1"/>' + HOLD),
    "SolidMechanics/FEM/TetrahedronFEMForceField_grid": block(field='<TetrahedronFEMForceField youngModulus="3000" poissonRatio="0.3"/>'),
    **{f"SolidMechanics/FEM/TetrahedronHyperelasticityFEMForceField_{law}": body(
        TETRA + f'<TetrahedronHyperelasticityFEMForceField materialName="{law}" ParameterSet="{values}" AnisotropyDirections=""/>' + HOLD)
       for law, values in (("StVenantKirchhoff", "400 600"), ("NeoHookean", "400 600"), ("StableNeoHookean", "400 600"),
                           ("MooneyRivlin", "100 100 600"), ("ArrudaBoyce", "400 600"), ("Ogden", "400 2 600"),
                           ("VerondaWestman", "100 1 600"))},
    **{f"SolidMechanics/FEM/HyperelasticityFEMForceField_{law}": body(
        TETRA + f'<{law}Material name="material"/><HyperelasticityFEMForceField template="Vec3,Tetrahedron" material="@material"/>' + HOLD)
       for law in ("NeoHookean", "StVenantKirchhoff", "MooneyRivlin", "Ogden")},
    "SolidMechanics/FEM/StandardTetrahedralFEMForceField": body(
        TETRA + '<StandardTetrahedralFEMForceField materialName="StVenantKirchhoff" ParameterSet="400 600"/>' + HOLD),
    "SolidMechanics/FEM/BeamFEMForceField": body(
        FRAMES + '<MeshTopology name="lines" lines="0 1  1 2"/><UniformMass vertexMass="1 1 0.01 0 0 0 0.1 0 0 0 0.1"/>'
        '<FixedConstraint indices="0"/><BeamFEMForceField name="beam" radius="0.1" youngModulus="2e6" poissonRatio="0.49"/>', ODE + LDL),
    **{f"SolidMechanics/FEM/{name}": sheet(f'<{name} youngModulus="1000" poissonRatio="0.3" {more}/>') for name, more in (
        ("TriangularFEMForceField", 'method="large"'), ("TriangleFEMForceField", 'method="large"'), ("TriangularFEMForceFieldOptim", ""),
        ("QuadBendingFEMForceField", 'method="small"'))},
    "SolidMechanics/FEM/TriangularAnisotropicFEMForceField": sheet(
        '<TriangularAnisotropicFEMForceField youngModulus="100" transverseYoungModulus="300" poissonRatio="0.3" fiberAngle="30"/>'),
    "SolidMechanics/Spring/SpringForceField": body(POINTS + '<StiffSpringForceField spring="0 1 100 1 1  1 2 100 1 1  2 3 100 1 1"/>'
                                                   '<FixedConstraint indices="0"/>'),
    "SolidMechanics/Spring/MeshSpringForceField": block(field='<MeshSpringForceField stiffness="300" damping="1"/>'),
    "SolidMechanics/Spring/RegularGridSpringForceField": block(field='<RegularGridSpringForceField stiffness="300" damping="1"/>'),
    "SolidMechanics/Spring/RestShapeSpringsForceField": block('<RestShapeSpringsForceField points="3" stiffness="100" angularStiffness="1"/>'),
    "SolidMechanics/Spring/RestShapeSpringsForceField_external": block(
        '<RestShapeSpringsForceField points="3" stiffness="100" external_rest_shape="@../goal/dofs" external_points="0"/>',
        more='<Node name="goal"><MechanicalObject name="dofs" position="4 0 0"/></Node>'),
    "SolidMechanics/Spring/FixedWeakConstraint": body(POINTS + '<FixedWeakConstraint indices="0" stiffness="1000"/>'),
    "SolidMechanics/Spring/FrameSpringForceField": body(
        FRAMES + '<UniformMass/><FixedConstraint indices="0"/><FrameSpringForceField spring="BEGIN_SPRING 0 1 KS_T 100 KS_R 50 KD 1 VEC1 '
        '0.5 0 0 VEC2 -0.5 0 0 END_SPRING BEGIN_SPRING 1 2 KS_T 100 KS_R 50 END_SPRING"/>'),
    "SolidMechanics/Spring/JointSpringForceField": body(
        FRAMES + '<UniformMass/><FixedConstraint indices="0"/><JointSpringForceField spring="BEGIN_SPRING 0 1 FREE_AXIS 0 0 0 1 1 1 '
        'KS_T 0 1e4 KS_R 10 100 KS_B 100 KD 1 R_LIM_X -1 1 R_LIM_Y -1 1 R_LIM_Z -1 1 REST_T 1 0 0 END_SPRING"/>', ODE + LDL),
    **{f"SolidMechanics/Spring/{name}": sheet(f'<MeshSpringForceField stiffness="300"/><{name} {more}/>') for name, more in (
        ("TriangularBendingSprings", 'stiffness="10" damping="0"'), ("QuadBendingSprings", 'stiffness="10" damping="0"'),
        ("QuadularBendingSprings", 'stiffness="10" damping="0"'), ("FastTriangularBendingSprings", 'bendingStiffness="10"'),
        ("TriangularQuadraticSpringsForceField", 'youngModulus="100" poissonRatio="0.3"'),
        ("TriangularBiquadraticSpringsForceField", 'youngModulus="100" poissonRatio="0.3"'))},
    # the damping that is taken where none is written grows a hundredfold per step: round-off says when numbers end
    "SolidMechanics/Spring/GearSpringForceField":
        body(FRAMES + '<UniformMass/><GearSpringForceField spring="BEGIN_SPRING 0 1 0 2 KD 1 END_SPRING"/>'),
    "SolidMechanics/Spring/VectorSpringForceField": block(
        '<VectorSpringForceField template="Vec3d" useTopology="1" stiffness="300" viscosity="1"/>', field=""),
    "SolidMechanics/Spring/AngularSpringForceField": body(FRAMES + '<UniformMass/><AngularSpringForceField indices="0 1" '
                                                          'angularStiffness="10"/>'),
    "SolidMechanics/Spring/PolynomialRestShapeSpringsForceField": body(
        POINTS + '<PolynomialRestShapeSpringsForceField points="0" polynomialStiffness="10" polynomialDegree="1"/>'),
    "SolidMechanics/TensorMass/TetrahedralTensorMassForceField": body(
        TETRA + '<TetrahedralTensorMassForceField youngModulus="1000" poissonRatio="0.3"/>' + HOLD),
    "SolidMechanics/TensorMass/TriangularTensorMassForceField": sheet(
        '<TriangularTensorMassForceField youngModulus="100" poissonRatio="0.3"/>'),
    # ---- Topology ----
    "Topology/Container/Constant/CubeTopology": body(
        '<CubeTopology nx="3" ny="3" nz="3" min="0 0 0" max="1 1 1"/><MechanicalObject/><UniformMass totalMass="1"/>'
        '<MeshSpringForceField stiffness="100"/><FixedConstraint indices="0"/>'),
    "Topology/Container/Constant/MeshTopology": body(
        '<MeshTopology name="net" filename="mesh/block.msh"/><MechanicalObject/><DiagonalMass massDensity="1"/>'
        '<TetrahedronFEMForceField youngModulus="1000" poissonRatio="0.3"/>' + HOLD),
    "Topology/Container/Dynamic/TopologicalChangeProcessor": body(
        TETRA + '<TetrahedronFEMForceField youngModulus="1000" poissonRatio="0.3"/>' + HOLD +
        '<TopologicalChangeProcessor filename="mesh/changes.txt" listChanges="1"/>'),
    "Topology/Container/Grid/CylinderGridTopology": body(
        '<CylinderGridTopology nx="3" ny="3" nz="5" length="2" radius="0.5" axis="1 0 0"/><MechanicalObject/><UniformMass totalMass="1"/>'
        + HEXA + HOLD),
    "Topology/Container/Grid/CylinderGridTopology_springs": body(
        '<CylinderGridTopology nx="3" ny="3" nz="5" length="2" radius="0.5" axis="1 0 0"/><MechanicalObject/><UniformMass totalMass="1"/>'
        '<MeshSpringForceField linesStiffness="100" quadsStiffness="50"/>' + HOLD),
    "Topology/Container/Grid/SphereGridTopology": body(
        '<SphereGridTopology nx="3" ny="3" nz="3" radius="1"/><MechanicalObject/><UniformMass totalMass="1"/>' + HEXA),
    "Topology/Container/Grid/SparseGridTopology": body(
        '<SparseGridTopology n="4 4 4" fileTopology="mesh/ball.obj"/><MechanicalObject/><UniformMass totalMass="1"/>' + HEXA),
    "Topology/Container/Grid/SparseGridMultipleTopology": body(
        '<SparseGridMultipleTopology n="4 4 4" fileTopologies="mesh/ball.obj" stiffnessCoefs="1" massCoefs="1"/><MechanicalObject/>'
        '<UniformMass totalMass="1"/>' + HEXA),
    "Topology/Container/Grid/SparseGridRamificationTopology": body(
        '<SparseGridRamificationTopology n="4 4 4" fileTopology="mesh/ball.obj" nbVirtualFinerLevels="1" finestConnectivity="0"/>'
        '<MechanicalObject/><UniformMass totalMass="1"/>' + HEXA),
    "Topology/Container/Constant/SphereQuadTopology": body(
        '<SphereQuadTopology nx="4" ny="4" nz="4" radius="2" center="0 1 0"/><MechanicalObject/><UniformMass totalMass="1"/>'
        '<MeshSpringForceField stiffness="100"/><FixedConstraint indices="0"/>'),
    "Topology/Mapping/Hexa2TetraTopologicalMapping": body(
        GRID + '<TetrahedronSetTopologyContainer name="cells"/><TetrahedronSetTopologyModifier/><Hexa2TetraTopologicalMapping '
        'input="@grid" output="@cells" swapping="1"/><DiagonalMass massDensity="1"/><TetrahedronFEMForceField youngModulus="1000" '
        'poissonRatio="0.3"/>' + HOLD),
    "Topology/Mapping/Hexa2QuadTopologicalMapping": block(
        '<Node name="skin"><QuadSetTopologyContainer name="quads"/><QuadSetTopologyModifier/><Hexa2QuadTopologicalMapping '
        'input="@../grid" output="@quads"/><SurfacePressureForceField pressure="1"/><Node name="triangles">'
        '<TriangleSetTopologyContainer name="cells"/><Quad2TriangleTopologicalMapping input="@../quads" output="@cells"/></Node></Node>'),
    "Topology/Mapping/Tetra2TriangleTopologicalMapping": body(
        TETRA + '<TetrahedronFEMForceField youngModulus="1000" poissonRatio="0.3"/>' + HOLD +
        '<Node name="skin"><TriangleSetTopologyContainer name="faces"/><TriangleSetTopologyModifier/><Tetra2TriangleTopologicalMapping '
        'input="@../cells" output="@faces" flipNormals="0"/><TrianglePressureForceField triangleList="0" pressure="0 0 1"/></Node>'),
    "Topology/Mapping/Triangle2EdgeTopologicalMapping": sheet(
        '<TriangularFEMForceField youngModulus="100" poissonRatio="0.3"/><Node name="border"><EdgeSetTopologyContainer name="edges"/>'
        '<Triangle2EdgeTopologicalMapping input="@../grid" output="@edges"/><MeshSpringForceField linesStiffness="10"/></Node>'),
    "Topology/Mapping/Mesh2PointTopologicalMapping": body(
        TETRA + '<TetrahedronFEMForceField youngModulus="1000" poissonRatio="0.3"/>' + HOLD +
        '<Node name="points"><PointSetTopologyContainer name="cloud"/><Mesh2PointTopologicalMapping input="@../cells" output="@cloud" '
        'pointBaryCoords="0 0 0" tetraBaryCoords="0.25 0.25 0.25"/><MechanicalObject name="seen"/><Mesh2PointMechanicalMapping/>'
        '<ConstantForceField totalForce="1 0 0"/></Node>'),
    "Topology/Mapping/SubsetTopologicalMapping": body(
        TETRA + '<TetrahedronFEMForceField youngModulus="1000" poissonRatio="0.3"/>' + HOLD +
        '<Node name="part"><TetrahedronSetTopologyContainer name="some" position="@../loader.position" tetrahedra="0 1 2 3"/>'
        '<MechanicalObject/><SubsetTopologicalMapping input="@../cells" output="@some" samePoints="true"/><IdentityMapping/></Node>'),
    "Topology/Mapping/Edge2QuadTopologicalMapping": body(
        FRAMES + '<UniformMass/><MeshTopology name="line" edges="0 1  1 2"/><Node name="tube"><QuadSetTopologyContainer name="quads"/>'
        '<Edge2QuadTopologicalMapping nbPointsOnEachCircle="8" radius="0.2" input="@../line" output="@quads"/><MechanicalObject/>'
        '<TubularMapping nbPointsOnEachCircle="8" radius="0.2"/></Node>'),
    # ---- what once stopped a scene, or was told in vain ----
    "Demos/included_objects": root(
        f'<Node name="chain">{ODE}{CG}<include href="Objects/Body.xml" name="one" dx="2"/><include href="Objects/Body.xml" name="two" '
        'dx="5" color="red"/></Node>'),
    "Demos/models_by_their_first_names": root(
        DETECT + ANSWER + NEAR + "".join(
            f'<Node name="{model}"><Euler/><MechanicalObject name="dofs" template="{state}"/><UniformMass totalMass="1"/>'
            f'<MeshTopology position="{5 * i} 0 0  {5 * i + 1} 0 0  {5 * i} 1 0" edges="0 1" triangles="0 1 2"/><{model} {more}/></Node>'
            for i, (model, state, more) in enumerate((
                ("TriangleSetModel", "Vec3d", ""), ("TriangleMeshModel", "Vec3d", ""), ("LineSetModel", "Vec3d", ""),
                ("LineMeshModel", "Vec3d", ""), ("PointSetModel", "Vec3d", ""), ("PointMeshModel", "Vec3d", ""),
                ("Capsule", "Rigid3d", 'radii="0.1" heights="1"'), ("OBB", "Rigid3d", 'extents="0.1 0.1 0.1"')))) +
        f'<Node name="last"><NewmarkImplicit/>{CG}{POINTS}<PythonController filename="none.py" classname="None"/></Node>'),
    "Demos/an_object_alone": root(
        '<MechanicalObject name="frame" template="Rigid3d" position="0 0 0 0 0 0 1"/><UniformMass totalMass="1"/><Node name="skin">'
        '<MeshOBJLoader name="loader" filename="mesh/small.obj"/><MeshTopology src="@loader"/><MechanicalObject src="@loader"/>'
        '<TriangleCollisionModel/><RigidMapping/></Node>'),
    "Demos/spheres_with_velocities": body(
        '<SphereLoader name="loader" filename="mesh/two.sph"/><MechanicalObject position="@loader.position" velocity="@loader.velocity"/>'
        '<UniformMass totalMass="1"/><SphereCollisionModel listRadius="@loader.listRadius"/>'),
    "Carving/CarvingManager": body(
        TETRA + '<TetrahedronFEMForceField youngModulus="1000" poissonRatio="0.3"/>' + HOLD,
        more='<CarvingManager active="true" carvingDistance="0.02"/>'),
    "Engine/Transform/SmoothMeshEngine_unread": block(more='<SmoothMeshEngine input_position="0 0 0" nb_iterations="1"/>'),
    "Mapping/NonLinear/DistanceMapping_grid": body(
        SHEET + '<UniformMass totalMass="16"/>' + HOLD + '<Node name="lengths"><MechanicalObject template="Vec1"/><DistanceMapping '
        'topology="@../grid" applyRestPosition="1"/><RestShapeSpringsForceField template="Vec1" stiffness="100"/></Node>', ODE + LDL),
    "LinearSolver/Direct/AsyncSparseLDLSolver_assembled": block(solver=ODE + '<AsyncSparseLDLSolver enableAssembly="1"/>'),
    "SolidMechanics/FEM/HexahedronCompositeFEMForceFieldAndMass_seen": block(
        '<Node name="seen"><OglModel name="model" filename="mesh/none.obj"/><HexahedronCompositeFEMMapping input="@.." output="@model"/>'
        '</Node>', field='<HexahedronCompositeFEMForceFieldAndMass youngModulus="3000" poissonRatio="0.3" density="1" lumpedMass="1" '
        'nbVirtualFinerLevels="1" updateStiffnessMatrix="false"/>', mass=""),
    # ---- plug-ins: what their users write ----
    "SoftRobots/CableConstraint": root(
        f'<Node name="finger"><EulerImplicitSolver rayleighStiffness="0.1" rayleighMass="0.1"/><SparseLDLSolver/>{TETRA}'
        '<TetrahedronFEMForceField template="Vec3d" method="large" poissonRatio="0.3" youngModulus="600"/><BoxROI name="ROI1" '
        'box="-0.1 -1 -1 0.1 2 2" drawBoxes="1"/><RestShapeSpringsForceField points="@ROI1.indices" stiffness="1e12"/>'
        '<LinearSolverConstraintCorrection/><Node name="cable"><MechanicalObject position="0.2 0.9 0.5  0.5 0.9 0.5  0.9 0.9 0.5"/>'
        '<CableConstraint indices="0 1 2" pullPoint="0 0.9 0.5" value="0.01" valueType="displacement"/><BarycentricMapping/></Node>'
        '<Node name="seen"><OglModel filename="mesh/none.stl"/><BarycentricMapping/></Node></Node>',
        '<FreeMotionAnimationLoop/><GenericConstraintSolver maxIterations="1000" tolerance="1e-7"/>'),
    "SoftRobots/PositionConstraint": root(
        f'<Node name="body"><EulerImplicitSolver/><SparseLDLSolver/>{TETRA}<TetrahedronFEMForceField poissonRatio="0.3" '
        'youngModulus="600"/>' + HOLD + '<LinearSolverConstraintCorrection/><Node name="tip"><MechanicalObject position="0.5 0.9 0.5"/>'
        '<PositionConstraint indices="0" useDirections="0 1 0" value="0.01" valueType="displacement"/>'
        '<BarycentricMapping mapForces="0" mapMasses="0"/></Node></Node>',
        '<FreeMotionAnimationLoop/><GenericConstraintSolver maxIterations="1000" tolerance="1e-7"/>'),
    "SoftRobots/SurfacePressureConstraint": root(
        f'<Node name="net"><EulerImplicitSolver/><SparseLDLSolver/>{TETRA}<TetrahedronFEMForceField poissonRatio="0.3" '
        'youngModulus="600"/>' + HOLD + '<LinearSolverConstraintCorrection/><Node name="cavity"><MeshOBJLoader name="loader" '
        'filename="mesh/small.obj" triangulate="1"/><MeshTopology src="@loader"/><MechanicalObject name="cavity"/><SurfacePressureConstraint '
        'triangles="@loader.triangles" value="0.5" valueType="pressure"/><BarycentricMapping mapForces="0" mapMasses="0"/></Node></Node>',
        '<FreeMotionAnimationLoop/><GenericConstraintSolver maxIterations="100" tolerance="1e-5"/>'),
    "STLIB/Rigidify": root(
        f'<Node name="body">{ODE}{LDL}<Node name="free"><MechanicalObject name="dofs" position="1 0 0  1 1 0  1 0 1"/></Node>'
        '<Node name="rigid"><MechanicalObject name="dofs" template="Rigid3" position="0 0 0 0 0 0 1"/><UniformMass totalMass="0.1"/>'
        '<RestShapeSpringsForceField points="0" stiffness="1e5" angularStiffness="1e5"/><Node name="parts"><MechanicalObject name="dofs" '
        'position="0 0 0" template="Vec3"/><RigidMapping globalToLocalCoords="1"/></Node></Node><Node name="soft"><MeshTopology '
        'position="1 0 0  1 1 0  1 0 1  0 0 0" tetrahedra="3 0 1 2"/><MechanicalObject/><UniformMass totalMass="1"/>'
        '<TetrahedronFEMForceField youngModulus="1000" poissonRatio="0.3"/><SubsetMultiMapping template="Vec3,Vec3" '
        'input="@../free/dofs @../rigid/parts/dofs" output="@./" indexPairs="0 0  0 1  0 2  1 0"/></Node><MechanicalMatrixMapper '
        'template="Vec3,Rigid3" object1="@free/dofs" object2="@rigid/dofs" nodeToParse="@soft"/></Node>'),
    "Cosserat/DiscreteCosseratMapping": root(
        f'<Node name="rod"><EulerImplicitSolver rayleighStiffness="0.2" rayleighMass="0.1"/>{LDL}<Node name="rigidBase"><MechanicalObject '
        'template="Rigid3d" name="base" position="0 0 0 0 0 0 1"/><RestShapeSpringsForceField points="0" external_points="0" '
        'stiffness="1e8" angularStiffness="1e8" template="Rigid3d"/></Node><Node name="rateAngularDeform"><MechanicalObject '
        'template="Vec3d" name="strain" position="0 0 0  0 0 0  0 0 0"/><BeamHookeLawForceField '
        'crossSectionShape="circular" length="0.1 0.1 0.1" radius="0.01" youngModulus="1e7" poissonRatio="0.4"/><Node name="frames">'
        '<MechanicalObject template="Rigid3d" name="frames" position="0 0 0 0 0 0 1  0.15 0 0 0 0 0 1  0.3 0 0 0 0 0 1"/><UniformMass '
        'totalMass="0.1" showAxisSizeFactor="0"/><DiscreteCosseratMapping curv_abs_input="0 0.1 0.2 0.3" curv_abs_output="0 0.15 0.3" '
        'input1="@../strain" input2="@../../rigidBase/base" output="@frames" debug="0" radius="0.01"/></Node></Node></Node>'),
}


def box(low, high):
    """Nodes of a box, x fastest, and its six faces, outward."""
    nodes = [(x, y, z) for z in (low, high) for y in (low, high) for x in (low, high)]
    return nodes, [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]


def obj_of(nodes, faces):
    return "".join("v %g %g %g\n" % p for p in nodes) + "".join("f " + " ".join(str(i + 1) for i in f) + "\n" for f in faces)


def gmsh_of(nodes, cells):
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$Nodes", str(len(nodes))]
    lines += ["%d %g %g %g" % (i + 1, *p) for i, p in enumerate(nodes)]
    lines += ["$EndNodes", "$Elements", str(len(cells))]
    lines += ["%d 4 2 1 1 %s" % (i + 1, " ".join(str(n + 1) for n in cell)) for i, cell in enumerate(cells)]
    return "\n".join(lines + ["$EndElements", ""])


SQUARE = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
FILES = {
    "mesh/block.msh": gmsh_of(box(0, 1)[0], [(0, 1, 3, 7), (0, 3, 2, 7), (0, 2, 6, 7), (0, 6, 4, 7), (0, 4, 5, 7), (0, 5, 1, 7)]),
    "mesh/ball.obj": obj_of(*box(-1, 1)),
    "mesh/small.obj": obj_of(*box(0.3, 0.7)),
    "mesh/square.obj": obj_of(SQUARE, [(0, 1, 2), (0, 2, 3)]),
    "mesh/square.off": "OFF\n4 2 0\n" + "".join("%g %g %g\n" % p for p in SQUARE) + "3 0 1 2\n3 0 2 3\n",
    "mesh/one.stl": "solid one\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid\n",
    "mesh/one.vtk": "# vtk DataFile Version 3.0\none\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 double\n0 0 0 1 0 0 0 1 0 0 0 1\n"
                    "CELLS 1 5\n4 0 1 2 3\nCELL_TYPES 1\n10\n",
    "mesh/one.trian": "3\n0 0 0\n1 0 0\n0 1 0\n1\n0 1 2 -1 -1 -1\n",
    "mesh/one.xs3": "Xsp 3.0\nnumm 2\nnums 1\nmass 1 v 5 0 0 0 0 0 1 0\nmass 2 v 6 0 0 0 0 0 1 0\nlspg 1 1 2 10 1 1\n",
    "mesh/one.gid": "MESH dimension 3 ElemType Tetrahedra Nnode 4\nCoordinates\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\nEnd Coordinates\n\n"
                    "Elements\n1 1 2 3 4\nEnd Elements\n",
    "mesh/two.sph": "sph 1.0\nsphe 0 0 0 0 0.5\nsphe 1 3 0 0 0.25\n",
    "mesh/changes.txt": "T= 0.05\nREMOVE= 1\n1\n",
    "Objects/Body.xml": '<Node name="Body"><MechanicalObject name="dofs" dx="0" position="0 0 0  1 0 0"/><UniformMass totalMass="2"/>'
                        '<SpringForceField spring="0 1 100 1 1"/><Node name="seen"><OglModel color="grey" dx="0"/></Node></Node>\n',
    "Objects/BoxConstraint.xml": '<Node name="Group"><BoxROI name="box" box="0 0 0 1 1 1"/><FixedProjectiveConstraint '
                                 'indices="@box.indices"/></Node>\n',
}

# What a refusal must name, where a part of SOFA is not there.
MISSING = {}
