// SPDX-License-Identifier: LGPL-2.1-or-later
// What a sparse grid says of its cells: their volume is not that of the surface.
#include <fmt/format.h>

#include "tests/support/scene_fixture.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// A box of 8 x 1 x 1 in a grid of its own.
std::string told(const std::string& attributes, const std::string& triangles) {
  return sceneFromText(fmt::format(R"(<Node name="root"><SparseGridTopology name="grid" {} triangles="{}"
      position="0 0 0 8 0 0 8 1 0 0 1 0 0 0 1 8 0 1 8 1 1 0 1 1"/></Node>)",
                                   attributes, triangles))
      .diagnostics.text();
}

TEST(SparseGrid, SaysThatItsCellsHaveAnotherVolume) {
  const std::string box = "0 2 1 0 3 2 4 5 6 4 6 7 0 1 5 0 5 4 1 2 6 1 6 5 2 3 7 2 7 6 3 0 4 3 4 7";
  // 1 % more on each side: 8.16 x 1.02 x 1.02, of which 64 x 8 x 8 cells less 62 x 6 x 6 are on the border
  const double all = 8.16 * 1.02 * 1.02 / 8, weighted = all * (1 - 0.5 * (1 - 62. * 36 / (64 * 64)));
  const std::string said = told("n='65 9 9'", box);
  expectContains(said, fmt::format("its cells have {:.0f} % of the volume of the surface, and with cellFactors {:.0f} %", 100 * all,
                                   100 * weighted));
  expectContains(said, "nbVirtualFinerLevels");
  EXPECT_EQ(told("n='9 2 2' min='0 0 0' max='8 1 1' fillWeighted='false'", box).find("of the volume"), std::string::npos)
      << "cells that are the box";
  EXPECT_EQ(told("n='9 2 2' min='0 0 0' max='8 1 1'", box.substr(0, box.size() - 12)).find("of the volume"), std::string::npos)
      << "an open surface has none";
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
