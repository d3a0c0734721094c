// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/scene/change_table.h"

namespace stroma {

const std::vector<TypeChange>& typeChanges() {
  static const std::vector<TypeChange> table = {
      // constraints were split into projective and Lagrangian ones
      {"FixedConstraint", "FixedProjectiveConstraint", "24.06"},
      {"PartialFixedConstraint", "PartialFixedProjectiveConstraint", "24.06"},
      {"LinearMovementConstraint", "LinearMovementProjectiveConstraint", "24.06"},
      {"PartialLinearMovementConstraint", "PartialLinearMovementProjectiveConstraint", "24.06"},
      {"AffineMovementConstraint", "AffineMovementProjectiveConstraint", "24.06"},
      {"OscillatorConstraint", "OscillatorProjectiveConstraint", "24.06"},
      {"FixedPlaneConstraint", "FixedPlaneProjectiveConstraint", "24.06"},
      {"AttachConstraint", "AttachProjectiveConstraint", "24.06"},
      {"FixedTranslationConstraint", "FixedTranslationProjectiveConstraint", "24.06"},
      {"FixedRotationConstraint", "FixedRotationProjectiveConstraint", "24.06"},
      {"HermiteSplineConstraint", "HermiteSplineProjectiveConstraint", "24.06"},
      {"ParabolicConstraint", "ParabolicProjectiveConstraint", "24.06"},
      {"LinearVelocityConstraint", "LinearVelocityProjectiveConstraint", "24.06"},
      {"StiffSpringForceField", "SpringForceField", "24.06"},
      {"ShewchukPCGLinearSolver", "PCGLinearSolver", "24.12"},
      // short names
      {"Mesh", "MeshTopology", "24.12"},
      {"RegularGrid", "RegularGridTopology", "24.12"},
      {"SparseGrid", "SparseGridTopology", "24.12"},
      {"MeshObjLoader", "MeshOBJLoader", "24.12"},
      {"MeshLoader", "MeshOBJLoader", "24.12"},
      {"EulerImplicit", "EulerImplicitSolver", "24.12"},
      {"ImplicitEuler", "EulerImplicitSolver", "24.12"},
      {"ImplicitEulerSolver", "EulerImplicitSolver", "24.12"},
      {"EulerSolver", "EulerExplicitSolver", "20.06"},
      {"Euler", "EulerExplicitSolver", "20.06"},
      {"EulerExplicit", "EulerExplicitSolver", "20.06"},
      {"ExplicitEuler", "EulerExplicitSolver", "20.06"},
      {"ExplicitEulerSolver", "EulerExplicitSolver", "20.06"},
      {"RungeKutta4", "RungeKutta4Solver", "24.12"},
      {"RungeKutta2", "RungeKutta2Solver", "24.12"},
      {"CentralDifference", "CentralDifferenceSolver", "24.12"},
      {"Static", "StaticSolver", "24.12"},
      {"NewmarkImplicit", "NewmarkImplicitSolver", "24.12"},
      {"CGSolver", "CGLinearSolver", "24.12"},
      {"ConjugateGradient", "CGLinearSolver", "24.12"},
  };
  return table;
}

const std::vector<TypeRemoval>& typeRemovals() {
  static const std::vector<TypeRemoval> table = {
      {"BoxConstraint", "write a BoxROI and a FixedProjectiveConstraint with indices=\"@BoxROI.indices\""},
      {"FixedBoxConstraint", "write a BoxROI and a FixedProjectiveConstraint with indices=\"@BoxROI.indices\""},
      {"DataMonitor", "use Monitor for states"},
      {"VolumeFromTetrahedrons", "the mesh report of 'stroma check' gives the volume"},
  };
  return table;
}

std::string_view presentType(std::string_view type) {
  for (const TypeChange& change : typeChanges())
    if (change.old_type == type) return change.new_type;
  return type;
}

const std::vector<AttributeChange>& attributeChanges() {
  static const std::vector<AttributeChange> table = {
      {"UniformMass", "totalmass", "totalMass"},
      {"UniformMass", "mass", "vertexMass"},
      {"ConstantForceField", "points", "indices"},
  };
  return table;
}

std::string_view adviceOn(std::string_view attribute) {
  static const std::vector<AttributeRemoval> table = {
      {"updateStiffness", "nothing: parameters of the material are read once, before the first step"},
      {"initialPoints", "rest_position=\"...\" of the MechanicalObject"},
      {"linearSystem", "nothing: a solver finds its system by itself"},
      {"linearSystemName", "nothing: a solver finds its system by itself"},
      {"orderingMethod", "nothing: CHOLMOD chooses the ordering"},
      {"stopAt", "a run that ends there: stroma run --until T"},
      {"keperiod", "nothing: EnergyMonitor writes energies"},
  };
  for (const AttributeRemoval& removal : table)
    if (removal.attribute == attribute) return removal.advice;
  return {};
}

const std::vector<std::string_view>& acceptedWithoutEffect() {
  static const std::vector<std::string_view> list = {
      // what only draws
      "VisualStyle", "OglModel", "VisualModelImpl", "VisualModel", "VisualMesh", "BackgroundSetting", "ViewerSetting",
      "InteractiveCamera", "Camera", "BaseCamera", "RecordedCamera", "LightManager", "DirectionalLight",
      "PositionalLight", "SpotLight", "OglSceneFrame", "OglLabel", "OglGrid", "VisualGrid", "LineAxis", "OglLineAxis",
      "OglViewport", "OglColorMap", "OglTexture", "OglTexture2D", "OglShader", "OglShadowShader", "OglCylinderModel",
      "OglRenderingSRGB", "OglOITShader", "OrderIndependentTransparencyManager", "CompositingVisualLoop",
      "PostProcessManager", "ClipPlane", "MergeVisualModels", "Visual3DText", "VisualBoundingBox", "VisualTransform",
      "TrailRenderer", "DataDisplay", "SlicedVolumetricModel", "TransformationGizmo", "VisualPointCloud",
      "VisualVectorField", "StatsSetting", "SofaDefaultPathSetting",
      // what loads, schedules or keeps books
      "RequiredPlugin", "APIVersion", "AddResourceRepository", "AddDataRepository", "AddFrameRepository",
      "DefaultAnimationLoop", "FreeMotionAnimationLoop", "DefaultVisualManagerLoop", "VisualManagerLoop",
      "InfoComponent", "MessageHandlerComponent", "FileMessageHandlerComponent",
      // companions of a topology that are needed only to change it or to draw it
      "PointSetTopologyModifier", "EdgeSetTopologyModifier", "TriangleSetTopologyModifier", "QuadSetTopologyModifier",
      "TetrahedronSetTopologyModifier", "HexahedronSetTopologyModifier", "PointSetGeometryAlgorithms",
      "EdgeSetGeometryAlgorithms", "TriangleSetGeometryAlgorithms", "QuadSetGeometryAlgorithms",
      "TetrahedronSetGeometryAlgorithms", "HexahedronSetGeometryAlgorithms", "PointSetTopologyAlgorithms",
      "EdgeSetTopologyAlgorithms", "TriangleSetTopologyAlgorithms", "QuadSetTopologyAlgorithms",
      "TetrahedronSetTopologyAlgorithms", "HexahedronSetTopologyAlgorithms"};
  return list;
}

bool servesVisualModels(std::string_view type) {
  return type.ends_with("Mapping") || type.ends_with("Loader") || type.ends_with("Topology") ||
         type.ends_with("SetTopologyContainer") || type == "Mesh";
}

const std::vector<std::string_view>& visualModels() {
  static const std::vector<std::string_view> list = {"OglModel",   "VisualModelImpl",  "VisualModel",
                                                     "VisualMesh", "OglCylinderModel", "SlicedVolumetricModel"};
  return list;
}

const std::vector<std::string_view>& visualAttributes() {
  static const std::vector<std::string_view> list = {"showObject",
                                                     "showObjectScale",
                                                     "showIndices",
                                                     "showIndicesScale",
                                                     "showVectors",
                                                     "showVectorsScale",
                                                     "showColor",
                                                     "drawMode",
                                                     "drawing",
                                                     "drawSize",
                                                     "drawROI",
                                                     "drawBoxes",
                                                     "drawPoints",
                                                     "drawEdges",
                                                     "drawTriangles",
                                                     "drawQuads",
                                                     "drawTetrahedra",
                                                     "drawHexahedra",
                                                     "drawColor1",
                                                     "drawColor2",
                                                     "drawColor3",
                                                     "drawColor4",
                                                     "drawPercentageOffset",
                                                     "drawHeterogeneousTetra",
                                                     "drawForceScale",
                                                     "showForces",
                                                     "showGravityCenter",
                                                     "showAxisSizeFactor",
                                                     "showInitialCenterOfGravity",
                                                     "showX0",
                                                     "showArrowSize",
                                                     "showStressColorMap",
                                                     "showStressAlpha",
                                                     "showVonMisesStressPerNode",
                                                     "showVonMisesStressPerElement",
                                                     "showElementGapScale",
                                                     "showPositions",
                                                     "showVelocities",
                                                     "showTrajectories",
                                                     "PositionsColor",
                                                     "VelocitiesColor",
                                                     "ForcesColor",
                                                     "TrajectoriesColor",
                                                     "sizeFactor",
                                                     "showMinThreshold",
                                                     "TrajectoriesPrecision",
                                                     "threadSafeVisitor",
                                                     "depend",
                                                     "multiThreadSimulation",
                                                     "displayFlags",
                                                     "gatherPt",
                                                     "gatherBsize",
                                                     "isToPrint"};
  return list;
}

}  // namespace stroma
