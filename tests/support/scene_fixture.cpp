// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tests/support/scene_fixture.h"

namespace stroma::test {

Factory& factory() {
  static Factory instance;
  return instance;
}
Modules& modules() {
  static Modules instance(factory());
  return instance;
}

Scene sceneFromText(const std::string& text) {
  Diagnostics diagnostics;
  SceneDescription description;
  description.file = "test.xml";
  description.root = readXml(text, description.file, {}, diagnostics);
  return instantiate(std::move(description), factory(), modules(), std::move(diagnostics));
}
Simulation simulationFromText(const std::string& text) { return Simulation(sceneFromText(text)); }

std::string problemsOf(const std::string& text) {
  return problemsIn([&] { simulationFromText(text); });
}

void expectContains(const std::string& text, const std::string& part) {
  EXPECT_NE(text.find(part), std::string::npos) << "\"" << part << "\" is not in:\n" << text;
}

}  // namespace stroma::test
