// SPDX-License-Identifier: LGPL-2.1-or-later
// User actions on a run as a text file, with one JSON object per line:
//   {"stroma":"actions","version":1,"scene":"organ.xml"}
//   {"step":12,"input":1,"state":"/organ/dofs","nodes":[40],"force":[0,0,0],"targets":[[0.1,0.2,0.3]],"stiffness":500,"damping":2}
//   {"step":13,"input":2,"state":"/organ/dofs","ball":[0.1,0.2,0.3,0.05],"stiffness":500,"damping":2}
//   {"step":15,"set":"/organ/fem","attribute":"youngModulus","value":"9000"}
//   {"step":20,"end":1}
// A ball is its centre and radius [m]; it excludes nodes, force and targets. "force" (zero), "targets" (none),
// "stiffness" and "damping" (0) may be omitted. Steps ascend.
#pragma once
#include <iosfwd>
#include <string>
#include <vector>

#include "framework/simulation/run_events.h"

namespace stroma {

/// The maximum number of problems reported for one file.
constexpr int told_action_problems = 20;

struct RecordedActions {
  std::string scene;  ///< the name of its file
  std::vector<RunEvent> events;
};

/// The text of such a file; numbers read back to the same bits. Throws std::runtime_error for text that is not UTF-8, a
/// non-finite number, an input with both nodes and a ball, and a state set by a program.
std::string printActions(const RecordedActions& actions);
/// Throws SceneError with every problem (the first told_action_problems), each with `file`, line and what was expected.
RecordedActions parseActions(std::istream& text, const std::string& file);
/// The same for a file; throws std::runtime_error if it cannot be opened.
RecordedActions readActions(const std::string& file);

}  // namespace stroma
