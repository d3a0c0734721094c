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

/// What is accepted without effect, and has one in SOFA where it is not the usual value.
void Rewriting::warnOfIgnored(const Element& element) {
  struct Ignored {
    std::string_view type, attribute, usual, effect;
  };
  static constexpr Ignored all[] = {
      {"LocalMinDistance", "angleCone", "0", "keeps contacts within a cone in SOFA: here those of the nearest places"},
      {"LocalMinDistance", "filterIntersection", "1", "switches a filter of contacts off in SOFA, and here it stays on"},
      {"LocalMinDistance", "useLMDFilters", "0", "filters contacts in SOFA by components of their own: here it does not"},
      {"LMDNewProximityIntersection", "angleCone", "0", "keeps contacts within a cone in SOFA: here those of the nearest places"},
      {"CCDTightInclusionIntersection", "continuousCollisionType", "None",
       "finds contacts on the way of a step in SOFA: here where it starts"},
      {"MeshOBJLoader", "handleSeams", "0", "splits nodes at the seams of textures in SOFA: here they stay one"},
      {"LineCollisionModel", "LineActiverPath", "", "leaves some lines out of contacts in SOFA: here all take part"},
      {"PointCollisionModel", "PointActiverPath", "", "leaves some points out of contacts in SOFA: here all take part"},
  };
  for (const Ignored& each : all) {
    const AttributeDescription* given = element.is(each.type) ? element.find(each.attribute) : nullptr;
    if (!given || given->typed) continue;
    const std::string_view value = trimmed(given->value);
    const bool is_number = !each.usual.empty() && each.usual[0] != 'N';
    const bool is_usual = value == each.usual || value.empty() || (is_number && each.usual == "1" && saysYes(value)) ||
                          (is_number && each.usual == "0" && (saysNo(value) || std::atof(std::string(value).c_str()) == 0));
    if (!is_usual || (each.usual == "0" && saysYes(value)))
      warn(given->where, element, std::string(each.attribute), std::string(each.effect));
  }
}

}  // namespace stroma::sofa
