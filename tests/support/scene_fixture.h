// SPDX-License-Identifier: LGPL-2.1-or-later
// Scenes for tests: a text goes through the real reader and loader, with the built modules and the test's own
// components.
#pragma once
#include <gtest/gtest.h>

#include <string>

#include "framework/scene/load.h"
#include "framework/simulation/simulation.h"

namespace stroma::test {

/// The factory and the modules of a test executable; register test-only components here before the first scene.
inline Factory& factory() {
  static Factory instance;
  return instance;
}
inline Modules& modules() {
  static Modules instance(factory());
  return instance;
}

/// Throws SceneError with every problem of the text.
inline Scene sceneFromText(const std::string& text) {
  Diagnostics diagnostics;
  SceneDescription description;
  description.file = "test.xml";
  description.root = readXml(text, description.file, {}, diagnostics);
  return instantiate(std::move(description), factory(), modules(), std::move(diagnostics));
}
inline Simulation simulationFromText(const std::string& text) { return Simulation(sceneFromText(text)); }

/// The text of all problems that `load` throws, or empty.
template <class Load>
std::string problemsIn(Load&& load) {
  try {
    load();
  } catch (const SceneError& error) {
    return error.diagnostics().text();
  }
  return {};
}
/// Of a scene that is loaded and compiled.
inline std::string problemsOf(const std::string& text) {
  return problemsIn([&] { simulationFromText(text); });
}

inline void expectContains(const std::string& text, const std::string& part) {
  EXPECT_NE(text.find(part), std::string::npos) << "\"" << part << "\" is not in:\n" << text;
}

}  // namespace stroma::test
