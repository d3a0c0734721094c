// SPDX-License-Identifier: LGPL-2.1-or-later
// Whether the bodies that a solver solves for apart are there, and apart.
#pragma once
#include <algorithm>
#include <functional>
#include <string>
#include <vector>

#include "framework/algebra/linear_solver.h"
#include "framework/mechanics/state.h"
#include "framework/scene/names.h"
#include "framework/scene/node.h"

namespace stroma {

/// Each is the path of a node below `root` with states in or below it, and none is within another.
inline void checkBodies(const Node& root, const std::vector<std::string>& bodies) {
  std::vector<std::string> paths;
  const std::function<void(const Node&)> collect = [&](const Node& in) {
    std::vector<State*> states;
    in.collect(states);
    if (!states.empty()) paths.push_back(in.path());
    for (const auto& child : in.children()) collect(*child);
  };
  for (const auto& child : root.children()) collect(*child);
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (std::find(paths.begin(), paths.end(), bodies[i]) == paths.end())
      throw ComponentError("bodies: there is no node " + bodies[i] + " with a mechanical state in or below it",
                           "paths of nodes, as \"/body\"", nearest(bodies[i], paths));
    for (std::size_t j = 0; j < bodies.size(); ++j)
      if (i != j && (bodies[i] + "/").starts_with(bodies[j] + "/"))
        throw ComponentError("bodies: " + bodies[i] + " is " + (bodies[i] == bodies[j] ? "there twice" : "within " + bodies[j]),
                             "nodes that have no states in common");
  }
}

/// `part_of`: of each row. Throws where the matrix couples rows of two parts; `solver`: its path.
inline void refuseTies(SystemMatrix& matrix, const std::vector<std::size_t>& part_of, const std::string& solver) {
  const BlockMatrix& pattern = matrix.pattern();
  for (Index row = 0; row < pattern.rows(); ++row)
    for (Index slot = pattern.rowStart()[row]; slot < pattern.rowStart()[row + 1]; ++slot)
      if (const Index other = pattern.columns()[slot]; part_of[other] != part_of[row])
        throw ComponentError(solver + ": bodies are solved for apart, and something ties " + matrix.describeRow(row) + " to " +
                                 matrix.describeRow(other),
                             "no bodies where a spring, a contact or a constraint acts between them");
}

}  // namespace stroma
