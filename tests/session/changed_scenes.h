// SPDX-License-Identifier: LGPL-2.1-or-later
// A bar that loses its first cell in a run, and what tests ask of it.
#pragma once
#include <string>

#include "tests/session/seen_runs.h"

namespace stroma::test {

inline std::string root(const std::string& content) {
  return "<Node name=\"root\" dt=\"0.01\" gravity=\"0 -10 0\"><EulerImplicitSolver/><SparseLDLSolver/>" + content + "</Node>";
}

inline std::string bar(const std::string& more, const std::string& fields =
                                             "<HexahedronFEMForceField name=\"h\" youngModulus=\"3000\" poissonRatio=\"0.4\"/>") {
  return root("<RegularGridTopology name=\"g\" n=\"6 2 2\" min=\"0 0 0\" max=\"5 1 1\"/><MechanicalObject name=\"s\"/>"
              "<DiagonalMass name=\"m\" massDensity=\"1\"/>" +
              fields + more);
}

/// The first cell of the bar goes before the step at t = 0.02.
inline const std::string knife = "<CarvingRegion name=\"knife\" box=\"0.1 -9 -9 0.9 9 9\" begin=\"0.02\" end=\"0.02\"/>";

/// The bar without its first cell as a grid of its own.
inline std::string shortBar(const std::string& more, const std::string& fields) {
  return root("<RegularGridTopology name=\"g\" n=\"5 2 2\" min=\"1 0 0\" max=\"5 1 1\"/><MechanicalObject name=\"s\"/>"
              "<DiagonalMass name=\"m\" massDensity=\"1\"/>" +
              fields + more);
}

/// The run of `text` after its change at step 2 against `reference`, started from the state of `text` there.
inline void expectSame(const std::string& text, const std::string& reference, const std::string& before_text = {},
                const std::string& path = "/s", long steps = 8) {
  Session session, before_session, other;
  session.loadText(text, "scene.xml");
  before_session.loadText(before_text.empty() ? text : before_text, "before.xml");
  const Seen cut = runFor(session, 2 + steps, path), before = runFor(before_session, 2, path);
  ASSERT_EQ(cut.report.end, RunEnd::done) << cut.report.reason;
  Simulation& simulation = other.loadText(reference, "reference.xml");
  const auto& state = dynamic_cast<const State&>(*findComponent(simulation.root(), path));
  Vector x(state.size()), v(state.size());
  for (Index i = 0; i < state.size(); ++i)
    for (std::size_t j = 0; j < before.rest.size(); ++j)
      if ((before.rest[j] - state.rest_position[std::size_t(i)]).norm() < 1e-12) x[i] = before.x[j], v[i] = before.v[j];
  simulation.setState(state, x, v);
  EXPECT_LT(farthest(cut, runFor(other, steps, path)), 1e-9) << text;
}

inline std::string reasonOf(const std::string& text, long steps = 6) {
  Session session;
  session.loadText(text, "scene.xml");
  const Seen seen = runFor(session, steps, "/s");
  EXPECT_EQ(seen.report.end, RunEnd::mesh_refused) << text;
  EXPECT_EQ(session.simulation().steps(), 2) << text;
  EXPECT_FALSE(session.simulation().hasChangedMeshes());
  return seen.report.reason;
}

inline const std::string hexes = "<HexahedronFEMForceField name=\"h\" youngModulus=\"3000\" poissonRatio=\"0.4\"/>";

}  // namespace stroma::test
