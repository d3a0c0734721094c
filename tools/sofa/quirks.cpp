// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/sofa/quirks.h"

#include <fmt/format.h>

#include <algorithm>

#include "framework/scene/text.h"

namespace stroma::sofa {

const std::vector<Quirk>& allQuirks() {  // long because it is a table
  static const std::vector<Quirk> quirks = {
      {"child-gravity", "gravity and dt of a child node do not count",
       {{"Node", "gravity", ""}, {"Node", "dt", ""}}},
      {"cg-threshold", "conjugate gradients stop at an absolute p.Ap or, preconditioned, r.Br, in the units of the scene",
       {{"CGLinearSolver", "absoluteThreshold", "1e-05"}, {"PCGLinearSolver", "endsBySquares", "true"},
        {"NewmarkImplicitSolver", "fromZeroAcceleration", "true"}}},
      {"spring-length", "the constants of springs of a mesh are divided by their length",
       {{"MeshSpringForceField RegularGridSpringForceField", "perLength", "true"}, {"RegularGridSpringForceField", "gridLengths", "true"}}},
      {"meeting-ends", "springs do nothing where their ends meet, and have no stiffness there",
       {{"SpringForceField", "meetingEnds", "free"}}},
      {"explicit-damping", "damping of springs and obstacles is explicit; its tension, and Rayleigh factors of parts, are in the tangent",
       {{"*", "explicitDamping", "true"}, {"ConicalForceField", "towardsTip", "true"}, {"EulerImplicitSolver", "ownInMatrix", "true"},
        {"CentralDifferenceSolver", "dampsHeld", "true"}, {"NewmarkImplicitSolver", "undampedStart", "true"}}},
      {"edge-mass", "the mass matrix of a mesh has entries at vertices and edges only, and lumped cells give each node the same share",
       {{"MeshMatrixMass", "matrix", "edges"}, {"DiagonalMass MeshMatrixMass", "shares", "equal"}}},
      {"pair-mass", "hexahedra that are a mass too couple all pairs of their corners alike, with 19 times their mass",
       {{"MeshMatrixMass", "matrix", "pairs"}}},
      {"edge-polar", "rotations of tetrahedra and hexahedra are polar factors of edges instead of deformation gradients",
       {{"TetrahedronFEMForceField TetrahedralCorotationalFEMForceField FastTetrahedralCorotationalForceField "
         "HexahedronFEMForceField NonUniformHexahedronFEMForceField HexahedronCompositeFEMForceField "
         "PlasticStrainForceField",
         "polarOf", "edges"}, {"CorotationalFEMForceField", "polarOf", "nodes"}}},
      {"prism-points", "prisms have two points instead of six: a twist of their ends has no stiffness",
       {{"CorotationalFEMForceField LinearSmallStrainFEMForceField", "reducedIntegration", "true"}}},
      {"membrane-shape", "membranes rebuild their strains from the shape of the moment",
       {{"TriangularFEMForceField TriangleFEMForceField TriangularAnisotropicFEMForceField QuadBendingFEMForceField",
         "strain", "current"}, {"QuadBendingFEMForceField", "axes", "world"}}},
      {"fixed-fibres", "Costa's law has its fibre along x and its sheet along y, whatever AnisotropyDirections are given",
       {{"TetrahedronHyperelasticityFEMForceField StandardTetrahedralFEMForceField", "AnisotropyDirections", "1 0 0  0 1 0"}}},
      {"local-dilatation", "elements near incompressibility lock: no mean dilatation",
       {{"TetrahedronFEMForceField TetrahedralCorotationalFEMForceField HexahedronFEMForceField "
         "CorotationalFEMForceField FastTetrahedralCorotationalForceField LinearSmallStrainFEMForceField "
         "HyperelasticityFEMForceField",
         "dilatation", "local"}}},
      {"one-iteration", "statics make one iteration of Newton unless told more, forces of constraint one, variational steps few",
       {{"NewtonRaphsonSolver", "maxNbIterationsNewton", "1"}, {"StaticSolver", "newtonSolver", ""},
        {"VariationalSymplecticSolver", "byPositions", "true"}, {"EulerImplicitSolver", "oneRound", "true"},
        {"ConstraintSweeps", "tolerance", ""}, {"UncoupledConstraintCorrection", "compliance", ""}}},
      {"predicted-start", "BDFOdeSolver begins with order 1, and steps where velocities lead: if little is lacking they end",
       {{"BDFOdeSolver", "firstStep", "euler"}, {"BDFOdeSolver", "startFrom", "predicted"}, {"BDFOdeSolver", "restBelow", ""}}},
      {"trapezoidal-positions", "the trapezoidal rule moves positions with the new velocity",
       {{"EulerImplicitSolver", "moveByNewVelocity", "true"}}},
      {"whole-first-step", "central differences begin with a whole step of force instead of half of one",
       {{"CentralDifferenceSolver", "firstStep", "whole"}}},
      {"grid-origin", "p0 of a grid is its origin, whatever its box",
       {{"RegularGridTopology", "min", ""}, {"RegularGridTopology", "max", ""}}},
      {"moved-inertia", "the inertia of moved nodes, and of followers in explicit steps, reaches nobody; attached ends share velocities",
       {{"DiagonalMass FEMMass MeshMatrixMass UniformMass", "movedAlone", "true"}, {"AttachProjectiveConstraint", "meet", "halfway"}}},
      {"unheld-matrix", "assembled matrices leave nodes on lines, planes and given ways, and ends attached both ways, free within a step",
       {{"AffineMovementProjectiveConstraint AttachProjectiveConstraint DirectionProjectiveConstraint "
         "FixedProjectiveConstraint HermiteSplineProjectiveConstraint OscillatorProjectiveConstraint "
         "ParabolicProjectiveConstraint PatchTestMovementProjectiveConstraint ProjectToLineProjectiveConstraint "
         "ProjectToPlaneProjectiveConstraint",
         "inMatrix", "false"}}},
      {"total-mass", "of totalMass and vertexMass the total wins",
       {{"UniformMass", "totalMass", ""}, {"UniformMass", "vertexMass", ""}}},
      {"added-masses", "several masses of one state add up",
       {{"DiagonalMass FEMMass MeshMatrixMass UniformMass", "mstate", ""}}},
      {"fixed-inertia", "the inertia of rigid frames stays in fixed axes, without gyroscopic forces; nor have beams that are a mass any",
       {{"UniformMass", "turns", "false"}, {"AdaptiveBeamForceFieldAndMass", "turningForces", "false"}}},
      {"late-times", "movements and forces given at times are those of the start of a step",
       {{"*", "late", "true"}, {"LinearForceField", "keyTimes", ""}, {"OscillatingTorsionPressureForceField", "phase", ""},
        {"AffineMovementProjectiveConstraint", "velocity", "still"}, {"LinearVelocityProjectiveConstraint", "ahead", ""}}},
      {"impulse-values", "forces and pressures that cables and cavities are given, and tell, are those of a whole step, times dt",
       {{"*", "impulses", "true"}}},
      {"ellipsoid-ratio", "ellipsoids push by a ratio of lengths, and frames with ellipsoids feel it at their centre alone",
       {{"EllipsoidForceField InteractionEllipsoidForceField", "depth", "ratio"}, {"InteractionEllipsoidForceField", "onCentre", "true"}}},
      {"contact-lists", "contacts are those of SOFA's lists: by its formulas, in its order, without doubles; slides count from touch on",
       {{"CollisionResponse", "sofaLists", "true"}}},
      {"isolated-springs", "springs and penalties between bodies that no solver has in common have the force of a step's start",
       {{"*", "explicitForce", "true"}, {"CollisionResponse", "explicitBetween", "true"}}},
      {"first-end-beams", "beams have the axes of their first frame, whose x is their direction whichever way they lie",
       {{"BeamFEMForceField", "axes", "firstEnd"}}},
      {"no-centrifugal", "masses on what follows frames do not press outwards as it turns",
       {{"*", "convectiveInertia", "false"}}},
      {"centre-cells", "embedded points off a mesh follow the cell with the nearest centre; a grid holds them as it is written",
       {{"BarycentricMapping", "foundBy", "centres"}, {"BarycentricMapping", "cellsOf", ""}}},
      {"held-arms", "the arms of what follows frames are held in the tangent: it lacks how torques change as they turn",
       {{"RigidMapping RigidRigidMapping SkinningMapping BeamLinearMapping TubularMapping ArticulatedSystemMapping "
         "LineSetSkinningMapping DeformableOnRigidFrameMapping",
         "geometricStiffness", "None"}}},
      {"one-sided-turns", "springs that turn frames, teeth and joints do not balance their torques; held turns go on as velocities",
       {{"AngularSpringForceField GearSpringForceField", "oneSided", "true"}, {"JointSpringForceField", "unbalanced", "true"},
        {"FixedRotationProjectiveConstraint TwistConstraint", "FixedXRotation", ""},
        {"FixedTranslationProjectiveConstraint FixedProjectiveConstraint", "indices", ""}}},
      {"unturned-springs", "springs that turn frames back have a tangent that leaves out how their torques turn",
       {{"RestShapeSpringsForceField", "turnTangent", "unturned"}}},
      {"edge-bending", "bending springs have a stiffness that depends on the size of the triangles, not that of a plate",
       {{"FastTriangularBendingSprings", "method", "springs"}}},
      {"torsion-tangent", "forces about an axis, stresses on triangles, springs of polynomials have a tangent that is no derivative",
       {{"TorsionForceField", "tangent", "transverse"},
        {"TriangularQuadraticSpringsForceField LennardJonesForceField PolynomialSpringsForceField "
         "PolynomialRestShapeSpringsForceField",
         "tangent", "rough"}, {"TrianglePressureForceField", "useTangentStiffness", "false"}}},
      {"exact-borders", "what lies on the border of a region or of a load's box is compared exactly, without room for round-off",
       {{"*", "exactBorder", "true"}}},
      {"split-quads", "a pressure on quads is that on two triangles of each, and has no stiffness",
       {{"SurfacePressureForceField", "quads", "halves"}}},
      {"first-node", "constraints without indices hold node 0",
       {{"FixedProjectiveConstraint", "indices", "0"}}},
  };
  return quirks;
}

bool concerns(const QuirkPart& part, std::string_view type, const DataTable& attributes) {
  if (part.types == "*") return attributes.find(part.attribute) != nullptr;
  Words types(part.types);
  for (std::string_view each = types.next(); !each.empty(); each = types.next())
    if (each == type) return true;
  return false;
}

std::vector<std::string> quirkNames() {
  std::vector<std::string> names;
  for (const Quirk& quirk : allQuirks()) names.emplace_back(quirk.name);
  return names;
}

bool Quirks::isOn(std::string_view name) const { return std::find(off_.begin(), off_.end(), name) == off_.end(); }

bool Quirks::use(std::string_view name, const std::string& path) {
  std::vector<std::string>& paths = used_[std::string(name)];
  if (std::find(paths.begin(), paths.end(), path) == paths.end()) paths.push_back(path);
  return isOn(name);
}

std::vector<std::string> Quirks::lines() const {
  std::vector<std::string> lines;
  for (const Quirk& quirk : allQuirks()) {
    const auto used = used_.find(quirk.name);
    if (used == used_.end()) continue;
    const std::size_t count = used->second.size();
    const std::string others = count == 1 ? "" : fmt::format(" and {} more", count - 1);
    lines.push_back(fmt::format("{}: {} ({}{}){}", quirk.name, quirk.what, used->second.front(), others,
                                isOn(quirk.name) ? "" : "; switched off"));
  }
  return lines;
}

}  // namespace stroma::sofa
