// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "tests/support/shell.h"
#include "tools/session/session.h"

namespace stroma::test {

/// A scene whose mesh is that of a loader.
inline std::string meshScene(const std::string& loader) {
  return "<Node name='root'>" + loader +
         "<MechanicalObject name='dofs' src='@mesh'/><MeshTopology name='topology' src='@mesh'/></Node>";
}

/// Scenes of a folder of the test's own, loaded or run by the session.
class UnitsFixture : public CommandTest {
 protected:
  std::uint64_t hashOf(const std::string& xml, const std::vector<Override>& overrides = {}) {
    Session session;
    Simulation& simulation = session.loadText(xml, (folder_ / "scene.xml").string(), overrides);
    session.run({.steps = 5});
    EXPECT_EQ(simulation.steps(), 5);
    return simulation.stateHash();
  }
  /// Warnings of a scene at load.
  std::vector<Problem> problemsOf(const std::string& xml, Severity severity = Severity::warning) {
    Session session;
    Simulation& simulation = session.loadText(xml, (folder_ / "scene.xml").string());
    std::vector<Problem> found;
    for (const Problem& problem : simulation.scene().diagnostics.problems())
      if (problem.severity == severity) found.push_back(problem);
    return found;
  }
  std::string errorOf(const std::string& xml) {
    try {
      Session session;
      session.loadText(xml, (folder_ / "scene.xml").string());
    } catch (const SceneError& error) {
      return error.what();
    }
    return {};
  }
};

}  // namespace stroma::test
