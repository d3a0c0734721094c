// SPDX-License-Identifier: LGPL-2.1-or-later
// The order of siblings in a scene has no meaning: example scenes whose elements are shuffled move alike.
#include <gtest/gtest.h>
#include <tinyxml2.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <map>
#include <random>
#include <set>

#include "tests/support/scene_fixture.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

using namespace tinyxml2;

const std::string scenes = STROMA_SOURCE_DIR "/scenes/";

/// Shuffles the children of every element; what writes files is left out.
void shuffle(XMLNode& node, std::mt19937& random) {
  std::vector<XMLNode*> children, writers;
  for (XMLNode* child = node.FirstChild(); child; child = child->NextSibling())
    (child->ToElement() && std::string(child->Value()) == "VTKExporter" ? writers : children).push_back(child);
  for (XMLNode* writer : writers) node.DeleteChild(writer);
  std::shuffle(children.begin(), children.end(), random);
  for (XMLNode* child : children) {
    node.InsertEndChild(child);  // moves it
    shuffle(*child, random);
  }
}

std::string shuffled(const std::string& name, unsigned seed) {
  std::ifstream file(scenes + "examples/" + name);
  std::string text((std::istreambuf_iterator<char>(file)), {});
  for (std::size_t at; (at = text.find("\"../meshes/")) != std::string::npos;)
    text.replace(at, 11, "\"" + scenes + "meshes/");
  XMLDocument document;
  EXPECT_EQ(document.Parse(text.c_str()), XML_SUCCESS) << name;
  std::mt19937 random(seed);
  shuffle(*document.RootElement(), random);
  XMLPrinter printer;
  document.Print(&printer);
  return printer.CStr();
}

/// Positions of every state after three steps, by the state's path.
std::map<std::string, std::vector<Vec3>> after(const std::string& text) {
  Simulation simulation = simulationFromText(text);
  for (int step = 0; step < 3; ++step) {
    const StepReport report = simulation.step();
    EXPECT_FALSE(report.diverged) << report.reason;
  }
  std::map<std::string, std::vector<Vec3>> positions;
  for (const State* state : simulation.states())
    for (Index i = 0; i < state->size(); ++i) positions[state->path()].push_back(state->x()[i]);
  return positions;
}

class SiblingOrder : public testing::TestWithParam<const char*> {};

TEST_P(SiblingOrder, HasNoMeaning) {
  std::ifstream file(scenes + "examples/" + GetParam());
  ASSERT_TRUE(file.good());
  const auto expected = after(shuffled(GetParam(), 0));
  ASSERT_FALSE(expected.empty());
  std::set<std::string> texts;
  for (unsigned seed = 1; seed <= 8; ++seed) {
    const std::string text = shuffled(GetParam(), seed);
    texts.insert(text);
    const auto found = after(text);
    ASSERT_EQ(found.size(), expected.size());
    for (const auto& [path, positions] : expected) {
      ASSERT_EQ(found.at(path).size(), positions.size()) << path;
      double error = 0, size = 0;
      for (std::size_t i = 0; i < positions.size(); ++i) {
        error = std::max(error, (found.at(path)[i] - positions[i]).norm());
        size = std::max(size, positions[i].norm());
      }
      // sums are taken in another order, and iterative solvers stop elsewhere within their tolerance
      EXPECT_LT(error, 1e-7 * size) << path << ", seed " << seed;
    }
  }
  EXPECT_GT(texts.size(), 5u) << "nothing was shuffled";
}

INSTANTIATE_TEST_SUITE_P(Examples, SiblingOrder,
                         testing::Values("organ.xml", "organ_static.xml", "breathing.xml", "partial_fixed.xml",
                                         "mesh_matrix_mass.xml", "organ_hyperelastic.xml", "ten_tetrahedra.xml"),
                         [](const auto& tested) {
                           std::string name = tested.param;
                           std::replace_if(
                               name.begin(), name.end(), [](unsigned char c) { return !std::isalnum(c); }, '_');
                           return name;
                         });

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
