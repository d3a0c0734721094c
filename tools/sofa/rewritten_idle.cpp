// SPDX-License-Identifier: LGPL-2.1-or-later
// What SOFA does not create, or creates and leaves idle: the scene runs without it, and says so.
#include <cstdlib>

#include "framework/scene/text.h"
#include "tools/sofa/rewriting.h"

namespace stroma::sofa {

/// SOFA does not create what acts where no state is, or where none follows, and what is drawn to itself does not move.
bool Rewriting::actsOnNothing(Element& element) {
  const std::string role = element.role(), &type = element.written->type;
  const auto has_no = [&element](const char* what) { return !element.place->nearest(what); };
  const bool acts = isAnyOf(role, {"force field", "mass", "projective constraint"}) && !movesElsewhere(element) &&
                    !isContactAnswer(type);
  const bool is_dead_load = isAnyOf(type, {"QuadPressureForceField", "TrianglePressureForceField"}) &&
                            !saysNo(element.text("useConstantForce"));
  const bool joins_itself = type == "VectorSpringForceField" && !element.find("object1") && !element.find("object2") &&
                            !element.find("filename") && !saysYes(element.text("useTopology"));
  std::string why;
  if (role == "mapping" && !element.find("output") && !element.place->has("mechanical state"))
    why = "has no state that follows in its node: SOFA does not create it, and the scene runs without it";
  else if (type == "WriteState" && !element.find("mstate") && has_no("mechanical state"))
    why = "has nothing to write";
  else if (type == "VTKExporter" && !element.find("topology") && has_no("topology"))
    why = "has nothing to write";
  else if (type == "GearSpringForceField" && !element.find("spring"))
    why = "has no pair of wheels: it does nothing";
  else if (type == "FrameSpringForceField" && !element.find("spring"))
    why = "has no spring: it does nothing";
  else if (type == "DiagonalVelocityDampingForceField" && trimmed(element.text("dampingCoefficient")).empty())
    why = "has no coefficient: it does nothing";
  else if (is_dead_load && !element.find("pressure"))
    why = "has no pressure, which is zero in SOFA then: it does nothing";
  else if (type == "MeshSpringForceField" && !element.find("topology") && has_no("topology"))
    why = "has no mesh that gives springs: it does nothing";
  else if (element.is("PositionBasedDynamicsProjectiveConstraint") && !element.find("position") && !element.find("cluster"))
    why = "has no places to go to: it does nothing";
  else if (joins_itself)
    why = "joins each node to itself: it does nothing";
  else if (acts && has_no("mechanical state"))
    why = "has no state to act on: SOFA does not create it, and the scene runs without it";
  if (why.empty()) return false;
  element.dropped = true;
  warn(element.written->where, element, {}, why);
  return true;
}

/// Attachments without nodes, and movements without two times: SOFA creates them, and they hold nobody.
bool Rewriting::holdsNothing(Element& element) {
  const bool attaches_none = element.is("AttachProjectiveConstraint") && !element.find("indices1") && !element.find("indices2");
  const std::string times = element.text("keyTimes");
  const bool never_moves = element.is("LinearMovementProjectiveConstraint") && !times.starts_with("@") &&
                           (!element.find("keyTimes") || element.writes("keyTimes")) &&
                           times.find_first_of(" \t\n") == std::string::npos;
  if (!attaches_none && !never_moves) return false;
  element.dropped = true;
  warn(element.written->where, element, {},
       std::string(attaches_none ? "names no nodes" : "has no two times") + ": it does nothing");
  return true;
}

/// What is accepted and changes nothing in SOFA either, where one might think that it does.
void Rewriting::sayWhyIdle(const Element& element) {
  const std::string& type = element.written->type;
  if (type == "ReadTopology")
    diagnostics_.note(element.written->where, element.path(),
                      "has no effect because SOFA reads its file into lists that nothing else has: the mesh stays as it is");
  if (type == "CarvingManager" && !element.text("active").empty() && !saysNo(element.text("active")))
    warn(element.written->where, element, "active",
         "in SOFA cells whose surface comes near the tool are removed: here nothing is removed", "CarvingRegion of a native scene");
  if (isAnyOf(type, {"CylinderCollisionModel", "CylinderModel", "Cylinder"}))
    diagnostics_.note(element.written->where, element.path(),
                      "has no effect because none of SOFA's own methods finds contacts of cylinders");
  if (isAnyOf(type, {"TetrahedronCollisionModel", "TetrahedronModel", "TetrahedronSet", "Tetrahedron"}))
    sayWhyTetrahedraDoNotTouch(element);
}

/// Tetrahedra meet points that have normals, by DiscreteIntersection alone.
void Rewriting::sayWhyTetrahedraDoNotTouch(const Element& model) {
  bool is_discrete = false, is_other = false, answers = false;
  const Element* points = nullptr;
  tree_->forEachPlace([&](Place& place) {
    for (const auto& each : place.elements) {
      const std::string_view type = typeHere(each->written->type);
      is_discrete = is_discrete || type == "DiscreteIntersection";
      is_other = is_other || type.ends_with("ProximityIntersection") || type == "LocalMinDistance";
      answers = answers || isContactAnswer(each->written->type);
      const bool is_here = each->place == model.place && !saysYes(model.text("selfCollision"));
      const bool is_met = saysYes(each->text("computeNormals")) && !saysNo(each->text("active")) && !is_here;
      if (type == "PointCollisionModel" && is_met) points = each.get();
    }
  });
  if (answers && points && !saysNo(model.text("active")) && (is_discrete || !is_other))
    return diagnostics_.error(model.written->where, model.path(),
                              "meets the points of " + points->path() + " in SOFA: contacts of tetrahedra are not found here",
                              "TriangleCollisionModel of the surface and a proximity method");
  diagnostics_.note(model.written->where, model.path(),
                    "has no effect because SOFA's tetrahedra meet only points with computeNormals=\"1\", by DiscreteIntersection");
}

/// SOFA's loader of a sequence has the next file after a time; of one file it is a loader as others.
void Rewriting::checkSequence(Element& loader) {
  warnOfIgnored(loader);
  const AttributeDescription* files = loader.find("nbOfFiles");
  if (files && std::atoi(files->value.c_str()) > 1)
    diagnostics_.error(files->where, loader.path() + ".nbOfFiles",
                       "SOFA reads another file after stepDuration: here a mesh is read once", "1");
  loader.remove("nbOfFiles"), loader.remove("stepDuration");
}

/// What is accepted without effect, and has one in SOFA where it is not the usual value.
void Rewriting::warnOfIgnored(const Element& element) {
  struct Ignored {
    std::string_view type, attribute, usual, effect;
  };
  static constexpr Ignored all[] = {
      {"LocalMinDistance", "useLMDFilters", "0", "filters contacts in SOFA by components of their own: here it does not"},
      {"LMDNewProximityIntersection", "angleCone", "0", "keeps contacts within a cone in SOFA: here those of the nearest places"},
      {"MeshOBJLoader", "handleSeams", "0", "splits nodes at the seams of textures in SOFA: here they stay one"},
      {"PreconditionedMatrixFreeSystem", "assemblingRate", "1",
       "keeps a preconditioner for as many steps in SOFA: here it is that of the step, and solves end elsewhere within their tolerance"},
      {"PCGLinearSolver", "update_step", "1",
       "keeps a preconditioner for as many steps in SOFA: here it is that of the step, and solves end elsewhere within their tolerance"},
      {"UncoupledConstraintCorrection", "correctionVelocityFactor", "1",
       "scales how forces of constraint change velocities in SOFA: here they change by the rule of the integrator"},
      {"UncoupledConstraintCorrection", "correctionPositionFactor", "1",
       "scales how forces of constraint move nodes in SOFA: here they move by the rule of the integrator"},
      {"LineCollisionModel", "LineActiverPath", "", "leaves some lines out of contacts in SOFA: here all take part"},
      {"PointCollisionModel", "PointActiverPath", "", "leaves some points out of contacts in SOFA: here all take part"},
  };
  if (element.is("CCDTightInclusionIntersection") && element.text("continuousCollisionType") == "FreeMotion")
    warn(element.find("continuousCollisionType")->where, element, "continuousCollisionType",
         "finds contacts on the free motion of a step in SOFA: here on straight paths, at the velocities of its start, and as far beside "
         "them as gravity moves in a step");
  for (const Ignored& each : all) {
    const AttributeDescription* given = element.is(each.type) ? element.find(each.attribute) : nullptr;
    if (!given || given->typed) continue;
    const std::string_view value = trimmed(given->value);
    const bool is_number = !each.usual.empty() && each.usual[0] != 'N';
    const double number = std::atof(std::string(value).c_str());
    const bool is_usual = value == each.usual || value.empty() || (is_number && each.usual == "1" && (saysYes(value) || number == 1)) ||
                          (is_number && each.usual == "0" && (saysNo(value) || number == 0));
    if (!is_usual || (each.usual == "0" && saysYes(value)))
      warn(given->where, element, std::string(each.attribute), std::string(each.effect));
  }
}

}  // namespace stroma::sofa
