// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tests/support/scene_fixture.h"

#include <cstdlib>
#include <fstream>

namespace stroma::test {

/// With STROMA_TEST_SCENES=FOLDER in the environment every scene of a test is kept there, as SUITE.TEST.NUMBER.xml: to run it by
/// itself, and to draw it.
static void keepForReaders(const std::string& text) {
  const char* folder = std::getenv("STROMA_TEST_SCENES");
  const ::testing::TestInfo* test = ::testing::UnitTest::GetInstance()->current_test_info();
  if (folder == nullptr || test == nullptr) return;
  static int number = 0;
  std::ofstream(std::string(folder) + "/" + test->test_suite_name() + "." + test->name() + "." + std::to_string(number++) + ".xml")
      << text;
}

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
Simulation simulationFromText(const std::string& text) {
  keepForReaders(text);
  return Simulation(sceneFromText(text));
}

std::string problemsOf(const std::string& text) {
  return problemsIn([&] { simulationFromText(text); });
}

void expectContains(const std::string& text, const std::string& part) {
  EXPECT_NE(text.find(part), std::string::npos) << "\"" << part << "\" is not in:\n" << text;
}

}  // namespace stroma::test
