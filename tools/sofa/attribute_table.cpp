// SPDX-License-Identifier: LGPL-2.1-or-later
// Facts about SOFA's components that decide what an attribute or a type of its scenes means here.
#include <algorithm>
#include <array>
#include <map>

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

}  // namespace

bool isAcceptedType(std::string_view type) {
  static const List accepted = {
      // where matrices and their orderings live
      "NaturalOrderingMethod", "AMDOrderingMethod", "COLAMDOrderingMethod", "MatrixLinearSystem", "MatrixFreeSystem",
      "ConstantSparsityPatternSystem", "ConstantSparsityProjectionMethod", "PreconditionedMatrixFreeSystem",
      "RotationMatrixSystem", "CompositeLinearSystem", "GlobalSystemMatrixImage", "GlobalSystemMatrixExporter",
      "LinearSystemImage", "*MatrixExporter",
      // windows, mice and pictures
      "*ButtonSetting", "TaskSchedulerSettings", "ViewerSetting", "Ogl*", "*Camera", "Compositing*", "CylinderVisualModel",
      "VisualManager*", "VisualTetrahedralModel", "VisualMesh", "Visual3DText", "*ColorMap", "PointSplatModel",
      "RenderingOrder*", "ArucoCamera", "ClipPlane", "SceneDisplay", "GuiManager", "DisplayFlags", "*Light",
      "LightManager", "MeshNormals", "TextureInterpolation", "DrawV*", "FPSCounter", "ImGui*", "CSVExporter",
      "PauseAnimation*", "SofaDefaultPathSetting", "StatsSetting", "EvalSurfaceDistance", "EvalPointsDistance",
      // files that are written
      "OBJExporter", "STLExporter", "MeshExporter", "BlenderExporter", "BatchExporter", "OffSequenceLoader",
      "InputEventReader", "RecordedState", "WriteTopology", "ReadTopology", "CompareTopology", "CompareState",
      // what finds and answers contacts: CollisionPipeline watches for them
      "BruteForceBroadPhase", "BVHNarrowPhase", "BruteForceDetection", "DirectSAP*", "IncrSAP*", "RayTrace*",
      "CollisionResponse", "DefaultContactManager", "RuleBasedContactManager", "CollisionGroupManager",
      "DefaultCollisionGroupManager", "*ConstraintSolver", "*ConstraintCorrection", "*LocalMinDistanceFilter",
      "ContactListener", "CubeCollisionModel", "RayCollisionModel", "CollisionMonitor", "ConstraintAnimationLoop",
      // companions
      "*SetTopologyModifier", "*SetTopologyAlgorithms", "*SetGeometryAlgorithms", "MultithreadingPlugin",
      "DefaultPauseAnimationLoop", "NodeToggleController", "Python*", "TopologyChecker", "TopologyBoundingTrasher",
      "MessageHandlerComponent", "CudaVectorOperations"};
  static const List with_effect = {"OglVolumetricModel"};
  return !contains(with_effect, type) &&
         std::any_of(accepted.begin(), accepted.end(), [&](std::string_view each) { return matches(each, type); });
}

bool isContactAnswer(std::string_view type) {
  return type == "CollisionResponse" || type == "DefaultContactManager" || type == "RuleBasedContactManager";
}

std::string_view typeHere(std::string_view type) {
  static const std::map<std::string_view, std::string_view> types = {
      {"PointProjectiveConstraint", "ProjectToPointProjectiveConstraint"},
      {"LineProjectiveConstraint", "ProjectToLineProjectiveConstraint"},
      {"PlaneProjectiveConstraint", "ProjectToPlaneProjectiveConstraint"},
      {"ProjectToPointConstraint", "ProjectToPointProjectiveConstraint"},
      {"ProjectToLineConstraint", "ProjectToLineProjectiveConstraint"},
      {"ProjectToPlaneConstraint", "ProjectToPlaneProjectiveConstraint"},
      {"AsyncSparseLDLSolver", "SparseLDLSolver"},
      {"BTDLinearSolver", "SparseLDLSolver"},
      {"QuadularBendingSprings", "QuadBendingSprings"},
      {"BlockGaussSeidelConstraintSolver", "GenericConstraintSolver"},
      {"ProjectedGaussSeidelConstraintSolver", "GenericConstraintSolver"},
      {"NNCGConstraintSolver", "GenericConstraintSolver"},
      {"ParallelTetrahedronFEMForceField", "TetrahedronFEMForceField"},
      {"ParallelHexahedronFEMForceField", "HexahedronFEMForceField"},
      {"ParallelCGLinearSolver", "CGLinearSolver"},
      {"ParallelMeshSpringForceField", "MeshSpringForceField"},
      {"ParallelSpringForceField", "SpringForceField"},
      {"ParallelStiffSpringForceField", "SpringForceField"},
      {"DefaultPipeline", "CollisionPipeline"},
      {"CollisionLoop", "CollisionPipeline"},
      {"TriangleModel", "TriangleCollisionModel"},
      {"TriangleSet", "TriangleCollisionModel"},
      {"TriangleMesh", "TriangleCollisionModel"},
      {"TTriangleModel", "TriangleCollisionModel"},
      {"Triangle", "TriangleCollisionModel"},
      {"LineModel", "LineCollisionModel"},
      {"LineSet", "LineCollisionModel"},
      {"LineMesh", "LineCollisionModel"},
      {"TLineModel", "LineCollisionModel"},
      {"Line", "LineCollisionModel"},
      {"PointModel", "PointCollisionModel"},
      {"PointSet", "PointCollisionModel"},
      {"PointMesh", "PointCollisionModel"},
      {"TPointModel", "PointCollisionModel"},
      {"Point", "PointCollisionModel"},
      {"SphereModel", "SphereCollisionModel"},
      {"TSphereModel", "SphereCollisionModel"},
      {"Sphere", "SphereCollisionModel"},
      {"ParallelBVHNarrowPhase", "BVHNarrowPhase"},
      {"ParallelBruteForceBroadPhase", "BruteForceBroadPhase"},
  };
  const auto found = types.find(type);
  return found == types.end() ? type : found->second;
}

bool hasNoEffect(std::string_view type, std::string_view attribute) {
  static const std::map<std::string_view, List> table = {
      {"*",
       {"printLog", "listening", "tags", "bbox", "componentState", "linearSystem", "linearSystemName", "orderingMethod",
        "parallelInverseProduct", "checkIndices", "isToPrint", "handleTopologyChange", "computeBoundingBox",
        "parallelODESolving", "threadSafeVisitor", "savingMatrixToFile", "savingMatrix", "verbose", "displayFlags",
        "numberOfThreads", "multithreading", "depend", "gatherPt", "gatherBsize",
        "isVisible", "reserve", "checkTopology", "checkConnexity", "computeAllBuffers", "debug", "applyTranslation",
        "highlightSurface", "drawing", "color", "schedulerThreads", "parallelizeBuildMatrix"}},
      {"MechanicalObject",
       {"force", "derivX", "free_position", "free_velocity", "constraint", "mappingJacobian", "reset_velocity",
        "reset_position", "dx_free", "vfree", "translationRotation", "listRadius"}},
      {"UniformMass", {"topology", "compute_mapping_inertia", "preserveTotalMass", "handleTopologicalChanges"}},
      {"FixedProjectiveConstraint", {"topology", "drawSize"}},
      {"TetrahedronFEMForceField",
       {"computeVonMisesStress", "updateStiffness", "assembling", "computeGlobalMatrix", "numMaterials"}},
      {"TetrahedralCorotationalFEMForceField", {"computeVonMisesStress", "assembling", "computeGlobalMatrix"}},
      {"TriangularFEMForceField", {"computePrincipalStress", "triangleInfo", "vertexInfo", "edgeInfo"}},
      {"BoxROI", {"doUpdate", "isVisible"}},
      {"SphereROI", {"doUpdate"}},
      {"EulerImplicitSolver", {"solveConstraint", "computeResidual"}},
  };
  for (const std::string_view key : {std::string_view("*"), type})
    if (const auto found = table.find(key); found != table.end() && contains(found->second, attribute))
      return true;
  return false;
}

bool isReadBySofa(std::string_view type, std::string_view attribute) {
  static const std::map<std::string_view, List> table = {
      {"MechanicalObject", {"externalForce", "filename"}},
      {"RestShapeSpringsForceField", {"external_points", "external_rest_shape", "pivot_points", "activeDirections"}},
      {"TetrahedronFEMForceField", {"initialPoints", "plasticYieldThreshold", "plasticCreep", "localStiffnessFactor"}},
      {"HexahedronFEMForceField", {"initialPoints"}},
      {"UniformMass", {"filename"}},
      {"DiagonalMass", {"filename", "fileMass"}},
      {"SpringForceField", {"filename", "fileSprings"}},
      {"ConstantForceField", {"indexFromEnd"}},
      {"AttachProjectiveConstraint", {"positionFactor", "velocityFactor", "responseFactor", "constraintFactor", "freeRotations",
                                      "lastFreeRotation", "restRotations", "lastPos", "lastDir", "clamp", "minDistance"}},
      {"LinearForceField", {"force"}},
      {"EulerExplicitSolver", {"optimizedForDiagonalMatrix"}},
      {"BarycentricMapping", {"mapper", "baseTriangulation"}},
      {"MeshOBJLoader", {"transformation"}},
  };
  const auto found = table.find(type);
  return found != table.end() && contains(found->second, attribute);
}

}  // namespace stroma::sofa
