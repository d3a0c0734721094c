// SPDX-License-Identifier: LGPL-2.1-or-later
// Facts about SOFA's components that decide what an attribute or a type of its scenes means here.
#include <algorithm>
#include <array>
#include <charconv>
#include <map>

#include "framework/scene/change_table.h"
#include "framework/scene/common_attributes.h"
#include "framework/scene/text.h"
#include "tools/sofa/declared_attributes.h"
#include "tools/sofa/rewriting.h"

namespace stroma::sofa {

namespace {

using List = std::vector<std::string_view>;

bool contains(const List& list, std::string_view word) {
  return std::find(list.begin(), list.end(), word) != list.end();
}

/// "Ogl*" stands for all that begin so, "*Setting" for all that end so.
bool matches(std::string_view pattern, std::string_view word) {
  if (pattern.ends_with('*')) return word.starts_with(pattern.substr(0, pattern.size() - 1));
  if (pattern.starts_with('*')) return word.ends_with(pattern.substr(1));
  return pattern == word;
}

/// What SOFA's component computes and keeps in an attribute: saved with the scene, and computed again from the rest.
bool isKeptBySofa(std::string_view type, std::string_view attribute) {
  static const std::map<std::string_view, List> table = {
      {"BoxROI", {"nbrborder"}}, {"NonUniformHexahedronFEMForceField", {"stiffnessMatrices"}},
      {"HexahedronCompositeFEMForceField", {"stiffnessMatrices"}},
      {"SphereForceField", {"contacts"}},
      {"ConicalForceField", {"contacts"}},
      {"OscillatingTorsionPressureForceField", {"trianglePressureMap"}},
      {"InteractionEllipsoidForceField", {"contacts"}},
      {"TriangularQuadraticSpringsForceField", {"triangleInfo", "edgeInfo"}},
      {"TriangularBiquadraticSpringsForceField", {"triangleInfo", "edgeInfo"}},
      {"TriangularTensorMassForceField", {"edgeInfo"}},
      {"EllipsoidForceField", {"contacts"}},
      {"TriangularFEMForceFieldOptim", {"damping", "triangleInfo", "triangleState", "vertexInfo", "edgeInfo"}},
      {"FastTetrahedralCorotationalForceField", {"pointInfo", "edgeInfo", "tetrahedronInfo"}},
      {"TetrahedronFEMForceField", {"vonMisesPerElement", "vonMisesPerNode", "vonMisesStressColors", "edgeInfo", "initialPoints"}},
      {"TetrahedralCorotationalFEMForceField", {"vonMisesPerElement", "vonMisesPerNode", "tetrahedronInfo"}},
      {"HexahedronFEMForceField", {"stiffnessMatrices", "hexahedronInfo", "initialPoints"}},
      {"MeshSpringForceField",  // which makes its springs of the mesh
       {"spring", "springsIndices1", "indices1", "springsIndices2", "indices2", "lengths", "length", "elongationOnly", "enabled"}},
      {"TriangularBendingSprings", {"edgeInfo"}},
      {"FastTriangularBendingSprings", {"edgeInfo"}},
      {"EulerImplicitSolver", {"residual", "reverseAccumulateOrder"}},
      {"MeshMatrixMass", {"graph"}}, {"VariationalSymplecticSolver", {"hamiltonianEnergy"}},
      {"NewtonRaphsonSolver", {"status", "residualGraph"}}, {"CGLinearSolver", {"graph"}}, {"PCGLinearSolver", {"graph"}},
      {"MinResLinearSolver", {"graph"}}, {"EdgePressureForceField", {"edgePressureMap"}},
      {"TriangularAnisotropicFEMForceField", {"localFibersDirection", "triangleInfo", "vertexInfo"}},
      {"TetrahedronHyperelasticityFEMForceField", {"tetrahedronInfo", "edgeInfo"}},
      {"FEMMass", {"elementMassMatrix"}},
      {"SubsetMapping", {"resizeToModel"}},  // to its indices, as it has anyway
      {"LineCollisionModel", {"displayFreePosition"}},
      {"PointCollisionModel", {"displayFreePosition"}},
      {"Mesh2PointTopologicalMapping",
       {"tetrahedraMappedFromTetra", "tetraSource", "pointMappedFromPoint", "pointMappedFromEdge", "pointSource"}},
      {"HexahedronSetTopologyContainer",  // of voxels
       {"resolution", "voxelSize", "idxInRegularGrid", "valuesIndexedInRegularGrid", "level", "valuesIndexedInTopology",
        "idInRegularGrid2IndexInTopo", "coarseComponents", "fineComponents"}},
  };
  const auto found = table.find(type);
  return found != table.end() && contains(found->second, attribute);
}

}  // namespace

bool isAcceptedType(std::string_view type) {
  static const List accepted = {
      // where matrices and their orderings live
      "*OrderingMethod", "MatrixLinearSystem", "TypedMatrixLinearSystem", "MatrixFreeSystem", "MatrixProjectionMethod*",
      "ConstantSparsityPatternSystem", "ConstantSparsityProjectionMethod", "PreconditionedMatrixFreeSystem",
      "RotationMatrixSystem", "CompositeLinearSystem", "PrecomputedMatrixSystem", "GlobalSystemMatrixImage", "GlobalSystemMatrixExporter",
      "LinearSystemImage", "*MatrixExporter", "MechanicalMatrixMapper*", "MappingGeometricStiffnessForceField", "MatrixImageExporter",
      "ComplianceMatrixImage", "FillReductionOrdering", "NestedDissection",
      // windows, mice and pictures
      "*ButtonSetting", "*Button", "Background", "SofaDefaultPath", "Stats", "Viewer", "PointSplat", "TaskSchedulerSettings",
      "ViewerSetting", "Ogl*", "*Camera", "Compositing*", "CylinderVisualModel",
      "VisualManager*", "VisualTetrahedralModel", "VisualMesh", "Visual3DText", "*ColorMap", "PointSplatModel",
      "RenderingOrder*", "ArucoCamera", "ClipPlane", "SceneDisplay", "GuiManager", "DisplayFlags", "*Light",
      "LightManager", "MeshNormals", "TextureInterpolation", "DrawV*", "FPSCounter", "ImGui*", "CSVExporter",
      "PauseAnimation*", "SofaDefaultPathSetting", "StatsSetting", "EvalSurfaceDistance", "EvalPointsDistance",
      // files that are written
      "BlenderExporter", "BatchExporter", "ConstraintForceExporter",
      "NotificationCenter", "SceneDAGExporter", "DevAngleCollisionMonitor", "DevTensionMonitor", "MappedMassMatrixObserver",
      "InputEventReader", "RecordedState", "WriteTopology", "ReadTopology", "CompareTopology", "CompareState",
      // what finds and answers contacts: CollisionPipeline and CollisionResponse do
      "BruteForceBroadPhase", "BVHNarrowPhase", "ParallelBruteForceBroadPhase", "ParallelBVHNarrowPhase", "BruteForceDetection",
      "SubCollisionPipeline", "DirectSAP*", "IncrSAP*", "Incremental*", "RayTrace*", "CollisionGroupManager", "CollisionGroup",
      "TreeCollisionGroupManager", "DefaultCollisionGroupManager", "*ConstraintSolver", "*ConstraintCorrection", "*LocalMinDistanceFilter",
      "CarvingManager", "ContactListener",
      "UnilateralLagrangianConstraint", "UnilateralInteractionConstraint",  // SOFA fills them from contacts alone
      "AugmentedLagrangianConstraint", "CylinderCollisionModel", "CylinderModel", "Cylinder", "TetrahedronCollisionModel",
      "TetrahedronModel",
      "TetrahedronSet", "Tetrahedron", "CubeCollisionModel", "CubeModel", "RayCollisionModel", "RayModel", "CollisionMonitor",
      "ConstraintAnimationLoop", "MultiTagAnimationLoop",
      // companions
      "*SetTopologyModifier", "*SetTopologyAlgorithms", "*SetGeometryAlgorithms", "MultithreadingPlugin",
      "DynamicSparseGridTopologyModifier", "DynamicSparseGridTopologyAlgorithms", "DynamicSparseGridGeometryAlgorithms",
      "DefaultPauseAnimationLoop", "NodeToggleController", "Python*", "TopologyChecker", "TopologyBoundingTrasher",
      "MessageHandlerComponent", "CudaVectorOperations", "MechanicalStateController*", "ArticulatedHierarchyController",
      "SlicedVolumetricModel",
      "*ForceFeedback", "NullForceFeedbackT", "AttachBodyPerformer*", "TopologicalChangeManager",
      "TextureInterpolation", "VisualManagerPass", "VisualManagerSecondaryPass", "TransparencyManager*", "Distances",
      "ExtraMonitor", "DataMonitor", "TimeMonitor", "PerformanceMonitor", "TimeProfiler*", "CameraCalibration*", "SceneChecker*",
      "AssetLoader*", "AddPluginRepository",
      "AnimationLoopParallelScheduler", "DataExchange", "TetrahedronHyperelasticityFEMDrawing",
      // what a mouse does
      "*MouseInteractor", "RayPickInteractor", "RemovePrimitivePerformer*",
      "InciseAlongPathPerformer*", "*BodyPerformer", "AddFramePerformer", "FixParticlePerformer",
      "StartNavigationPerformer", "SuturePerformer"};
  return std::any_of(accepted.begin(), accepted.end(), [&](std::string_view each) { return matches(each, type); });
}

bool isEngineOfSofa(std::string_view type) {
  static const List engines = {
      "AverageCoord", "ClusteringEngine", "ComplementaryROI", "DifferenceEngine", "DilateEngine", "DisplacementMatrixEngine",
      "DisplacementTransformEngine", "ExtrudeSurface", "FixedTopology*", "GroupFilterYoungModulus", "HausdorffDistance",
      "IndexValueMapper", "Indices2ValuesMapper", "IndicesFromValues", "InvertTransformMatrixEngine", "JoinPoints",
      "LinearToHigherOrderElements", "MapIndices", "MathOp", "MergeROIs", "MergeSets", "MergeVectors", "MergePoints",
      "MeshBarycentricMapperEngine", "MeshClosingEngine", "MeshROI", "MeshSampler", "MeshSplittingEngine", "MeshSubsetEngine",
      "MeshTetraStuffing", "NearestPointROI", "NearestTexcoordsMap", "NormEngine", "NormalsFromPoints",
      "ProjectiveTransformEngine", "ProximityROI", "QuatToRigidEngine", "RandomPointDistributionInSurface",
      "RigidToQuatEngine", "ROIValueMapper", "RotateTransformMatrixEngine", "ScaleTransformMatrixEngine",
      "SelectConnectedLabelsROI", "SelectLabelROI", "ShapeMatching", "SmoothMeshEngine", "Spiral", "SubsetTopology",
      "SumEngine", "TextureInterpolation", "TransformMatrixEngine", "TransformPosition", "TranslateTransformMatrixEngine",
      "ValuesFromIndices", "ValuesFromPositions", "Vertex2Frame", "VolumeFromTetrahedrons", "VolumeFromTriangles",
      "VolumeFromVolumetricElements", "Generate*", "GridMeshCreator", "StringMeshCreator", "ExtrudeEdgesAndGenerateQuads",
      "ExtrudeQuadsAndGenerateHexas", "VoxelGridLoader", "MeshXspLoader", "MeshTrianLoader", "GIDMeshLoader", "SphereLoader",
      "ArrayValues*", "MeanComputation"};
  return std::any_of(engines.begin(), engines.end(), [&](std::string_view each) { return matches(each, type); });
}

bool isContactAnswer(std::string_view type) {
  return type == "CollisionResponse" || type == "DefaultContactManager" || type == "RuleBasedContactManager";
}

std::string_view typeHere(std::string_view type) {
  static const std::map<std::string_view, std::string_view> types = {
      {"PointProjectiveConstraint", "ProjectToPointProjectiveConstraint"},
      {"LineProjectiveConstraint", "ProjectToLineProjectiveConstraint"}, {"ProjectToLineConstraint", "ProjectToLineProjectiveConstraint"},
      {"PlaneProjectiveConstraint", "ProjectToPlaneProjectiveConstraint"},
      {"ProjectToPointConstraint", "ProjectToPointProjectiveConstraint"}, {"SlidingConstraint", "SlidingLagrangianConstraint"},
      {"ProjectToPlaneConstraint", "ProjectToPlaneProjectiveConstraint"}, {"StopperConstraint", "StopperLagrangianConstraint"},
      {"BilateralInteractionConstraint", "BilateralLagrangianConstraint"}, {"ProjectDirectionConstraint", "DirectionProjectiveConstraint"},
      {"ProjectDirectionProjectiveConstraint", "DirectionProjectiveConstraint"}, {"MultiCollisionPipeline", "CollisionPipeline"},
      {"PatchTestMovementConstraint", "PatchTestMovementProjectiveConstraint"}, {"EigenCholmodSupernodalLLT", "SparseLDLSolver"},
      {"BilinearMovementConstraint", "PatchTestMovementProjectiveConstraint"}, {"UniformConstraint", "UniformLagrangianConstraint"},
      {"BilinearMovementProjectiveConstraint", "PatchTestMovementProjectiveConstraint"}, {"MappedObject", "MechanicalObject"},
      {"PositionBasedDynamicsConstraint", "PositionBasedDynamicsProjectiveConstraint"}, {"LULinearSolver", "SparseLUSolver"},
      {"FixedWeakConstraint", "RestShapeSpringsForceField"}, {"NodalLinearDampingForceField", "DiagonalVelocityDampingForceField"},
      {"TriangleBendingSprings", "TriangularBendingSprings"}, {"SparsePARDISOSolver", "SparseLDLSolver"},
      {"SparseTAUCSSolver", "SparseLDLSolver"}, {"SparseTAUCSLLtSolver", "SparseLDLSolver"}, {"CudaSparseLDLSolver", "SparseLDLSolver"},
      {"LMDNewProximityIntersection", "LocalMinDistance"},
      {"BeamLinearMapping_mt", "BeamLinearMapping"}, {"ManifoldEdgeSetTopologyContainer", "EdgeSetTopologyContainer"},
      {"ManifoldTriangleSetTopologyContainer", "TriangleSetTopologyContainer"},
      {"ManifoldTetrahedronSetTopologyContainer", "TetrahedronSetTopologyContainer"},
      {"DynamicSparseGridTopologyContainer", "HexahedronSetTopologyContainer"},
      {"MultilevelHexahedronSetTopologyContainer", "HexahedronSetTopologyContainer"},
      {"NonUniformHexahedralFEMForceFieldAndMass", "HexahedronFEMForceField"}, {"SkeletalMotionConstraint", "FixedProjectiveConstraint"},
      {"SkeletalMotionProjectiveConstraint", "FixedProjectiveConstraint"}, {"CenterOfMassMulti2Mapping", "CenterOfMassMultiMapping"},
      {"CenterPointTopologicalMapping", "Mesh2PointTopologicalMapping"}, {"CenterPointMechanicalMapping", "Mesh2PointMechanicalMapping"},
      {"SimpleTesselatedTetraTopologicalMapping", "Mesh2PointTopologicalMapping"}, {"DistanceFromTargetMapping", "DistanceFromTarget"},
      {"SimpleTesselatedTetraMechanicalMapping", "Mesh2PointMechanicalMapping"}, {"EulerImplicitIntegrationScheme", "EulerImplicitSolver"},
      {"EulerExplicitIntegrationScheme", "EulerExplicitSolver"}, {"StaticIntegrationScheme", "StaticSolver"},
      {"NewmarkImplicitIntegrationScheme", "NewmarkImplicitSolver"}, {"CentralDifferenceIntegrationScheme", "CentralDifferenceSolver"},
      {"RungeKutta2IntegrationScheme", "RungeKutta2Solver"}, {"RungeKutta4IntegrationScheme", "RungeKutta4Solver"},
      {"AsyncSparseLDLSolver", "SparseLDLSolver"}, {"BTDLinearSolver", "SparseLDLSolver"}, {"VisualModelOBJExporter", "OBJExporter"},
      {"QuadularBendingSprings", "QuadBendingSprings"}, {"TetrahedralTensorMassForceField", "TetrahedronFEMForceField"},
      {"HexahedralFEMForceField", "HexahedronFEMForceField"}, {"HexahedronFEMForceFieldAndMass", "HexahedronFEMForceField"},
      {"HexahedralFEMForceFieldAndMass", "HexahedronFEMForceField"}, {"RepulsiveSpringForceField", "SpringForceField"},
      {"NonUniformHexahedronFEMForceFieldAndMass", "NonUniformHexahedronFEMForceField"},
      {"HexahedronCompositeFEMForceFieldAndMass", "HexahedronCompositeFEMForceField"}, {"ParallelCGLinearSolver", "CGLinearSolver"},
      {"HexahedronCompositeFEMMapping", "BarycentricMapping"}, {"ParallelTetrahedronFEMForceField", "TetrahedronFEMForceField"},
      {"ParallelHexahedronFEMForceField", "HexahedronFEMForceField"}, {"ParallelMeshSpringForceField", "MeshSpringForceField"},
      {"ParallelSpringForceField", "SpringForceField"}, {"ParallelStiffSpringForceField", "SpringForceField"},
      {"OffSequenceLoader", "MeshOffLoader"}, {"SubsetTopology", "BoxROI"}, {"CompositeCollisionPipeline", "CollisionPipeline"},
      {"DefaultPipeline", "CollisionPipeline"}, {"CollisionLoop", "CollisionPipeline"}, {"DefaultContactManager", "CollisionResponse"},
      {"RuleBasedContactManager", "CollisionResponse"}, {"TriangleModel", "TriangleCollisionModel"},
      {"TriangleSetModel", "TriangleCollisionModel"}, {"TriangleMeshModel", "TriangleCollisionModel"},
      {"LineSetModel", "LineCollisionModel"}, {"LineMeshModel", "LineCollisionModel"}, {"PointSetModel", "PointCollisionModel"},
      {"PointMeshModel", "PointCollisionModel"}, {"TriangleSet", "TriangleCollisionModel"}, {"TriangleMesh", "TriangleCollisionModel"},
      {"TTriangleModel", "TriangleCollisionModel"}, {"TriangleOctreeModel", "TriangleCollisionModel"}, {"LineModel", "LineCollisionModel"},
      {"TriangleOctree", "TriangleCollisionModel"}, {"TriangleOctreeCollisionModel", "TriangleCollisionModel"},
      {"TriangleModelInRegularGrid", "TriangleCollisionModel"}, {"Triangle", "TriangleCollisionModel"}, {"LineSet", "LineCollisionModel"},
      {"LineMesh", "LineCollisionModel"}, {"TLineModel", "LineCollisionModel"}, {"Line", "LineCollisionModel"},
      {"PointModel", "PointCollisionModel"}, {"PointSet", "PointCollisionModel"}, {"PointMesh", "PointCollisionModel"},
      {"TPointModel", "PointCollisionModel"}, {"Point", "PointCollisionModel"}, {"SphereModel", "SphereCollisionModel"},
      {"TSphereModel", "SphereCollisionModel"}, {"Sphere", "SphereCollisionModel"}};
  const auto found = types.find(type);
  return found == types.end() ? type : found->second;
}

/// Lists that SOFA's loaders fill from their files.
static bool isOfFile(std::string_view type, std::string_view attribute) {
  static const List lists = {"position", "polylines", "edges", "triangles", "quads", "polygons", "tetrahedra", "tetras", "hexahedra",
                             "hexas", "prisms", "pentas", "pentahedra", "pyramids", "normals", "edgesOnBorder", "trianglesOnBorderList",
                             "faceList", "normalsIndex", "texcoordsIndex", "positionsDefinition", "texcoordsDefinition",
                             "normalsDefinition", "vertPosIdx", "vertNormIdx"};
  if (!type.ends_with("Loader")) return false;
  return contains(lists, attribute) || attribute.ends_with("Groups") || attribute.starts_with("highOrder");
}

/// Lists that SOFA's grids make themselves. A sparse one takes a surface.
static bool isOfGrid(std::string_view type, std::string_view attribute) {
  static const List lists = {"edges", "lines", "tetrahedra", "tetras", "hexahedra", "hexas", "prisms", "pentahedra", "pentas", "pyramids",
                             "uv", "texcoords", "computePointList", "createTexCoords"};
  const bool is_surface = isAnyOf(attribute, {"position", "points", "triangles", "quads", "filename", "fileTopology"});
  if (type == "RegularGridTopology") return is_surface || contains(lists, attribute);
  return type == "SparseGridTopology" && contains(lists, attribute);
}

bool hasNoEffect(std::string_view type, std::string_view attribute) {  // long because it is a table
  static const std::map<std::string_view, List> table = {
      {"*",
       {"printLog", "listening", "tags", "bbox", "componentState", "linearSystem", "linearSystemName", "orderingMethod",
        "parallelInverseProduct", "checkIndices", "isToPrint", "handleTopologyChange", "computeBoundingBox",
        "parallelODESolving", "threadSafeVisitor", "savingMatrixToFile", "savingMatrix", "verbose", "displayFlags",
        "numberOfThreads", "multithreading", "depend", "gatherPt", "gatherBsize",
        "isVisible", "reserve", "checkTopology", "checkConnexity", "computeAllBuffers", "debug", "applyTranslation",
        "L_nnz", "savingPrecision", "subpartSolve", "isCompliance", "arrowSizeCoef",
        "highlightSurface", "drawing", "color", "schedulerThreads", "parallelizeBuildMatrix", "numberOfContacts", "previous", "next",
        "constraintIndex"}},
      {"MechanicalObject",
       {"force", "derivX", "free_position", "free_velocity", "constraint", "mappingJacobian", "reset_velocity",
        "reset_position", "dx_free", "vfree", "translationRotation", "listRadius"}},
      {"UniformMass", {"topology", "compute_mapping_inertia", "preserveTotalMass", "handleTopologicalChanges"}},
      {"FixedProjectiveConstraint", {"topology", "drawSize"}},
      {"TetrahedronFEMForceField",
       {"computeVonMisesStress", "updateStiffness", "assembling", "computeGlobalMatrix", "numMaterials"}},
      {"TetrahedralCorotationalFEMForceField", {"computeVonMisesStress", "assembling", "computeGlobalMatrix"}},
      {"TriangularFEMForceField", {"computePrincipalStress", "triangleInfo", "vertexInfo", "edgeInfo", "hosfordExponant", "criteriaValue"}},
      {"SparseLDLSolver", {"applyPermutation", "saveMatrixToFile", "blockSize", "verification", "problem", "showProblem"}},
      {"EigenSimplicialLDLT", {"ordering"}}, {"EigenSimplicialLLT", {"ordering"}},
      {"EigenSparseLU", {"ordering"}}, {"EigenSparseQR", {"ordering"}}, {"SparseLUSolver", {"tolerance"}},
      {"PrecomputedLinearSolver", {"use_file", "jmjt_twostep"}},
      {"PCGLinearSolver", {"update_step", "build_precond", "use_precond"}},
      {"WarpPreconditioner", {"update_step", "updateStep", "solverName"}},
      {"PrecomputedWarpPreconditioner",
       {"jmjt_twostep", "use_file", "updateStep", "share_matrix",
        "maxMaxIterations", "use_rotations", "draw_rotations", "init_MaxIter", "init_Tolerance",
        "init_Threshold", "solverName"}},
      {"CorotationalFEMForceField", {"elementStiffness", "computeForceStrategy", "computeForceDerivStrategy", "elementSpace"}},
      {"ThinCellsFEMForceField", {"elementStiffness", "computeForceStrategy", "computeForceDerivStrategy", "elementSpace"}},
      {"HyperelasticityFEMForceField", {"computeForceStrategy", "computeForceDerivStrategy", "elementSpace"}},
      {"LinearSmallStrainFEMForceField", {"elementStiffness", "computeForceStrategy", "computeForceDerivStrategy", "elementSpace"}},
      {"BeamFEMForceField", {"beamsData", "useSymmetricAssembly"}}, {"MeshMatrixMass", {"printMass"}},
      {"MeshOBJLoader", {"loadMaterial", "defaultMaterial", "materials", "computeMaterialFaces"}},
      {"Edge2QuadTopologicalMapping", {"toQuadContainer", "toQuadModifier"}}, {"AngularSpringForceField", {"limit"}},
      {"TriangleCollisionModel", {"useCurvature", "size"}},
      {"LineCollisionModel", {"size"}}, {"PointCollisionModel", {"size"}},
      {"SphereCollisionModel", {"showImpostors", "size"}}, {"WriteState", {"stopAt", "keperiod"}},
      {"PartialLinearMovementProjectiveConstraint",
       {"mainIndice", "minDepIndice", "maxDepIndice", "X0", "Y0", "Z0", "imposedDisplacmentOnMacroNodes"}},
      {"SkinningMapping", {"applyRestPosition"}}, {"BeamLinearMapping", {"applyRestPosition"}},
      {"RigidRigidMapping", {"axisLength"}}, {"ClusteringEngine", {"fixedRadius", "outFile"}},
      {"PositionBasedDynamicsProjectiveConstraint", {"velocity", "old_position", "topology"}},
      {"RestShapeSpringsForceField", {"topology"}}, {"SpringForceField", {"topology"}},
      {"LinearForceField", {"topology"}}, {"AttachProjectiveConstraint", {"topology1", "topology2"}},
      {"UncoupledConstraintCorrection", {"ODESolver"}},
      {"BilateralLagrangianConstraint",
       {"activateAtIteration", "merge", "derivative", "topology1", "topology2"}},
      {"SlidingLagrangianConstraint", {"force"}},
      {"BarycentricMapping", {"applyRestPosition"}}, {"IdentityMapping", {"applyRestPosition"}},
      {"SubsetMapping", {"applyRestPosition"}}, {"SphereROI", {"doUpdate"}}, {"BoxROI", {"doUpdate", "isVisible"}},
      {"EulerImplicitSolver", {"solveConstraint", "computeResidual"}},
      {"EulerExplicitSolver", {"optimizedForDiagonalMatrix"}},
      {"HexahedronCompositeFEMForceField",
       {"homogenizationMethod", "completeInterpolation", "useRamification", "drawType", "drawColor", "drawSize", "finestToCoarse"}},
  };
  for (const std::string_view key : {std::string_view("*"), type})
    if (const auto found = table.find(key); found != table.end() && contains(found->second, attribute))
      return true;
  if (type.ends_with("Mass") && attribute == "rayleighStiffness" && !type.ends_with("AndMass")) return true;
  return isOfFile(type, attribute) || isOfGrid(type, attribute) || isKeptBySofa(type, attribute);
}

/// What other passes take, which go before that over the attributes.
static bool isTranslated(std::string_view type, std::string_view attribute) {
  static const std::map<std::string_view, List> table = {
      {"MechanicalObject", {"externalForce", "filename"}}, {"SpringForceField", {"filename", "fileSprings"}},
      {"DiagonalMass", {"filename", "fileMass"}}, {"RigidMapping", {"filename", "fileRigidMapping"}},
      {"SphereCollisionModel", {"filename", "fileSphere"}}, {"BilateralLagrangianConstraint", {"numericalTolerance"}},
      {"TetrahedronFEMForceField", {"plasticYieldThreshold", "plasticCreep"}}, 
      {"SubsetTopology", {"localIndices", "centers", "radii", "direction", "normal", "edgeAngle", "triAngle"}}};
  if (attribute == "isMechanical") return type.ends_with("Mapping");
  if (attribute == "filename" || attribute == "fileTopology")
    if (type == "MeshTopology" || type.starts_with("SparseGrid") || type.ends_with("TopologyContainer")) return true;
  if (type.starts_with("SparseGrid") && isAnyOf(attribute, {"xmin", "xmax", "ymin", "ymax", "zmin", "zmax"})) return true;
  const auto found = table.find(type);
  return found != table.end() && contains(found->second, attribute);
}

Treatment treatmentOf(std::string_view type, std::string_view attribute, const DataTable& here) {
  const std::string_view ours = typeHere(type);
  const bool is_common = std::ranges::find(commonAttributes(), attribute) != commonAttributes().end();
  if (here.find(attribute) || is_common || isTranslated(type, attribute)) return Treatment::read;
  const bool draws = contains(visualAttributes(), attribute) || attribute.starts_with("show") || attribute.starts_with("draw");
  return draws || here.isVisualOnly(attribute) || hasNoEffect(ours, attribute) ? Treatment::no_effect : Treatment::refused;
}

bool isReadBySofa(std::string_view type, std::string_view attribute) {
  static const std::map<std::string_view, List> table = {
      {"MechanicalObject", {"externalForce", "filename"}}, {"SparseLDLSolver", {"enableAssembly"}},
      {"NonUniformHexahedronFEMForceField", {"updateStiffnessMatrix"}}, {"HexahedronCompositeFEMForceField", {"updateStiffnessMatrix"}},
      {"RestShapeSpringsForceField", {"external_points", "external_rest_shape", "pivot_points", "activeDirections"}},
      {"TetrahedronFEMForceField", {"plasticYieldThreshold", "plasticCreep", "localStiffnessFactor"}},
      {"NonUniformHexahedronFEMForceFieldAndMass", {"initialPoints"}},
      {"UniformMass", {"filename"}},
      {"DiagonalMass", {"filename", "fileMass"}},
      {"VectorSpringForceField", {"filename"}},
      {"SpringForceField", {"filename", "fileSprings"}},
      {"TrianglePressureForceField", {"normal", "dmin", "dmax"}},
      {"RigidMapping", {"filename", "fileRigidMapping"}},
      {"SphereCollisionModel", {"filename", "fileSphere"}},
      {"RigidRigidMapping", {"filename"}},
      {"ClusteringEngine", {"fixedPosition", "inFile"}},
      {"DeformableOnRigidFrameMapping",
       {"repartition", "globalToLocalCoords", "rootAngularForceScaleFactor", "rootLinearForceScaleFactor"}},
      {"PartialLinearMovementProjectiveConstraint", {"linearMovementBetweenNodesInIndices"}},
      {"MeshSpringForceField", {"object1", "object2"}},
      {"RegularGridSpringForceField", {"object1", "object2"}},
      {"QuadBendingSprings", {"object1", "object2"}},
      {"LinearForceField", {"force"}},
      {"BarycentricMapping", {"mapper", "baseTriangulation"}},
      {"MeshOBJLoader", {"transformation"}},
      {"TaitSurfacePressureForceField", {"initialVolume"}},
      {"TriangularQuadraticSpringsForceField", {"initialPoints"}},
      {"TriangularBiquadraticSpringsForceField", {"initialPoints", "matrixRegularization"}},
      {"InteractionEllipsoidForceField", {"object2_invert"}},
      {"FastTriangularBendingSprings", {"quadraticBendingModel"}},
      {"TriangularFEMForceField", {"initialTransformation"}},
      {"JointSpringForceField", {"infile", "period", "reinit"}},
  };
  const auto found = table.find(type);
  return found != table.end() && contains(found->second, attribute);
}

bool isSofasDefault(std::string_view attribute, std::string_view value) {
  static const std::map<std::string_view, List> table = {
      {"damping", {"0"}}, {"enableAssembly", {"1", "true"}}, {"updateStiffnessMatrix", {"0", "false"}},
      {"linearMovementBetweenNodesInIndices", {"0", "false"}}, {"edgeAngle", {"0"}},
      {"triAngle", {"0"}}, {"repartition", {""}}, {"filename", {"", "unused"}},
      {"force", {"1"}}, {"maxInjectionRate", {"1000"}}, {"initialVolume", {"0"}},
      {"infile", {""}}, {"period", {"0"}}, {"reinit", {"0", "false"}},
      {"matrixRegularization", {"0.4"}}, {"object2_invert", {"0", "false"}},
      {"quadraticBendingModel", {"0", "false"}}, {"globalToLocalCoords", {"0", "false"}}, {"rootAngularForceScaleFactor", {"1"}},
      {"rootLinearForceScaleFactor", {"1"}}, {"externalForce", {"0"}},
      {"direction", {"0"}}, {"normal", {"0"}}, {"dmin", {"0"}}, {"dmax", {"0"}}};
  const auto found = table.find(attribute);
  if (found == table.end()) return false;
  if (contains(found->second, value)) return true;
  Words words(value);  // of lists each: 1 1.0 1
  bool all = !value.empty();
  for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
    double number = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
    all = all && error == std::errc() && end == word.data() + word.size() && contains(found->second, printReal(number));
  }
  return all;
}

}  // namespace stroma::sofa
