// SPDX-License-Identifier: LGPL-2.1-or-later
// Runs whose meshes change, and the states that they leave.
#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "framework/mechanics/state.h"
#include "tests/support/scene_fixture.h"
#include "tools/session/session.h"

namespace stroma::test {

struct Seen {
  RunReport report;
  std::vector<Vec3> rest, x, v;
};

/// The state at `path` now; empty where there is none.
inline Seen see(Session& session, const std::string& path) {
  Seen seen;
  const auto* state = dynamic_cast<const State*>(findComponent(session.simulation().root(), path));
  for (Index i = 0; state && i < state->size(); ++i) {
    seen.rest.push_back(state->rest_position[std::size_t(i)]);
    seen.x.emplace_back(state->x()[i]), seen.v.emplace_back(state->v()[i]);
  }
  return seen;
}

inline Seen runFor(Session& session, long steps, const std::string& path) {
  session.followMeshChanges();
  const RunReport report = session.run({.steps = steps});
  Seen seen = see(session, path);
  seen.report = report;
  return seen;
}

/// The largest difference of positions and velocities where rest positions are the same; 1e300 where a node of `a` has none in `b`.
inline double farthest(const Seen& a, const Seen& b) {
  EXPECT_EQ(a.x.size(), b.x.size());
  EXPECT_FALSE(a.x.empty());
  double largest = 0;
  for (std::size_t i = 0; i < a.x.size(); ++i) {
    std::size_t j = 0;
    while (j < b.x.size() && (b.rest[j] - a.rest[i]).norm() > 1e-12) ++j;
    if (j == b.x.size()) return 1e300;
    largest = std::max({largest, (b.x[j] - a.x[i]).norm(), (b.v[j] - a.v[i]).norm()});
  }
  return largest;
}

}  // namespace stroma::test
