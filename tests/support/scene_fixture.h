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
Factory& factory();
Modules& modules();

/// Throws SceneError with every problem of the text.
Scene sceneFromText(const std::string& text);
Simulation simulationFromText(const std::string& text);

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
std::string problemsOf(const std::string& text);

void expectContains(const std::string& text, const std::string& part);

}  // namespace stroma::test
