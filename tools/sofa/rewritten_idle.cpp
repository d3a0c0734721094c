// SPDX-License-Identifier: LGPL-2.1-or-later
// What SOFA does not create, or creates and leaves idle: the scene runs without it, and says so.
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

}  // namespace stroma::sofa
