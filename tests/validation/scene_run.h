// SPDX-License-Identifier: LGPL-2.1-or-later
// Scenes of scenes/validation through the real loader, as numbers: what every test of this folder starts from.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "tests/support/scene_fixture.h"

namespace stroma::test {

using Settings = std::vector<std::string>;  ///< overrides, "/grid.n=81 5 5"

/// The scene `name` of scenes/validation (without ".xml") with overrides. Throws SceneError.
inline Simulation validationScene(const std::string& name, const Settings& settings) {
  std::vector<Override> overrides;
  for (const std::string& text : settings) overrides.push_back(Override::parse(text));
  return Simulation(
      loadScene(STROMA_SOURCE_DIR "/scenes/validation/" + name + ".xml", overrides, factory(), modules()));
}

/// Rest positions and displacements of the only state [m], after one step.
struct Displacements {
  std::vector<Vec3> rest, moved;
  StepReport report;
  std::vector<double> residuals;  ///< of the Newton iterations

  /// Mean displacement of the nodes that `choose` accepts by their rest position.
  Vec3 mean(const std::function<bool(const Vec3&)>& choose) const {
    Vec3 sum = Vec3::Zero();
    int count = 0;
    for (std::size_t i = 0; i < rest.size(); ++i)
      if (choose(rest[i])) sum += moved[i], ++count;
    return sum / count;
  }
  Vec3 meanAt(double x) const {
    return mean([x](const Vec3& p) { return std::abs(p.x() - x) < 1e-6; });
  }
};

inline std::vector<double> reals(Component& component, const char* attribute) {
  return *std::get<std::vector<double>*>(component.data().find(attribute)->pointer());
}

inline Displacements displacements(Simulation& simulation, const StepReport& report) {
  const State& state = *simulation.states().at(0);
  Displacements out;
  out.rest = state.rest_position;
  out.report = report;
  for (Index i = 0; i < state.size(); ++i) out.moved.push_back(state.x()[i] - state.rest_position[i]);
  if (Component* solver = findComponent(simulation.root(), "/beam/solver"))
    out.residuals = reals(*solver, "residualGraph");
  return out;
}

inline Displacements oneStep(const std::string& scene, const Settings& settings) {
  Simulation simulation = validationScene(scene, settings);
  const StepReport report = simulation.step();
  return displacements(simulation, report);
}

}  // namespace stroma::test
