// SPDX-License-Identifier: LGPL-2.1-or-later
// The tool that draws the picture of docs/validation.md works from the scenes as they are.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>

namespace {

TEST(Picture, ToolDrawsTheDeflectionCurves) {
  if (std::system("/usr/bin/python3 -c 'import numpy, matplotlib' > /dev/null 2>&1") != 0)
    GTEST_SKIP() << "numpy and matplotlib are not installed";
  const std::string picture = STROMA_BINARY_DIR "/validation_test.png";
  std::filesystem::remove(picture);
  const std::string tool =
      "/usr/bin/python3 '" STROMA_SOURCE_DIR "/docs/plots/validation_picture.py' --stroma '" STROMA_COMMAND "'";
  EXPECT_EQ(std::system((tool + " --cells 2 --out '" + picture + "' > /dev/null").c_str()), 0);
  ASSERT_TRUE(std::filesystem::exists(picture));
  EXPECT_GT(std::filesystem::file_size(picture), 10000u);
  EXPECT_NE(std::system((tool + " --cells 3 --out '" + picture + "' > /dev/null 2>&1").c_str()), 0) << "an odd number";
}

}  // namespace
