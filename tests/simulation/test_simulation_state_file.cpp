// SPDX-License-Identifier: LGPL-2.1-or-later
// State files: the same bits back, whole or absent, damage is noticed.
#include "framework/simulation/state_file.h"

#include <bit>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>

#include "tests/support/folder_fixture.h"

namespace {

namespace fs = std::filesystem;
using namespace stroma;

class StateFile : public test::FolderTest {};

std::vector<Vec3> awkwardNumbers(int count) {
  std::mt19937_64 random(7);
  std::vector<Vec3> points{{0.1, -0.0, 5e-324}, {std::numeric_limits<double>::max(), 1.0 / 3, -1e-300}};
  while (int(points.size()) < count) {
    Vec3 point;
    for (double& number : point) {
      do number = std::bit_cast<double>(random());
      while (!std::isfinite(number));
    }
    points.push_back(point);
  }
  return points;
}

bool sameBits(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(Vec3)) == 0;
}

void writeFrames(const std::string& path, const std::vector<Vec3>& x, int frames) {
  StateWriter writer(path);
  for (int i = 0; i < frames; ++i) {
    writer.time(0.1 * i);
    writer.rows("X", x);
    writer.rows("V", x);
  }
  writer.close();
}

std::string messageOf(const std::string& path) {
  try {
    readStateFile(path);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return {};
}

TEST_F(StateFile, ReadsBackTheSameBits) {
  const auto x = awkwardNumbers(20000);  // more than one block of the compressor
  for (const char* name : {"a.state", "a.state.gz"}) {
    writeFrames(file(name), x, 3);
    const auto frames = readStateFile(file(name));
    ASSERT_EQ(frames.size(), 3u);
    for (int i = 0; i < 3; ++i) {
      EXPECT_EQ(std::bit_cast<std::uint64_t>(frames[i].time), std::bit_cast<std::uint64_t>(0.1 * i));
      EXPECT_TRUE(sameBits(frames[i].x, x));
      EXPECT_TRUE(sameBits(frames[i].v, x));
      EXPECT_TRUE(frames[i].f.empty());
    }
  }
  EXPECT_LT(fs::file_size(file("a.state.gz")), fs::file_size(file("a.state")));
}

TEST_F(StateFile, WritesRowsAndSubsets) {
  Vector rows(3);
  rows[0] = Vec3(1, 2, 3);
  rows[2] = Vec3(7, 8, 9);
  StateWriter writer(file("b.state"));
  writer.time(0);
  writer.rows("X", rows);
  writer.rows("F", rows, {2, 0});
  writer.close();
  const auto frames = readStateFile(file("b.state"));
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_TRUE(sameBits(frames[0].x, {{1, 2, 3}, {0, 0, 0}, {7, 8, 9}}));
  EXPECT_TRUE(sameBits(frames[0].f, {{7, 8, 9}, {1, 2, 3}}));
}

TEST_F(StateFile, LeavesNothingWithoutClose) {
  {
    StateWriter writer(file("c.state.gz"));
    writer.time(0);
    writer.rows("X", awkwardNumbers(10));
    EXPECT_FALSE(fs::exists(file("c.state.gz")));
  }
  EXPECT_TRUE(fs::is_empty(folder_));
}

TEST_F(StateFile, NoticesDamage) {
  writeFrames(file("d.state.gz"), awkwardNumbers(100), 2);
  fs::resize_file(file("d.state.gz"), fs::file_size(file("d.state.gz")) / 2);
  EXPECT_NE(messageOf(file("d.state.gz")).find("cut short"), std::string::npos);
  EXPECT_NE(messageOf(file("missing.gz")).find("cannot open"), std::string::npos);

  const std::pair<const char*, const char*> cases[] = {
      {"T= 0\n  X= 1 2\n", "d.state:2: point 0 is not three numbers"},
      {"T= 0\n  X= 1 2 3 4,5 5 6\n", "d.state:2: point 1 is not three numbers"},
      {"T= 0\n  X= 1 2 3", "the last line has no end"},
      {"T= zero\n", "d.state:1: T= must be followed by one number"},
      {"  X= 1 2 3\n", "before the first T="},
      {"T= 0\n  Y= 1 2 3\n", "is not a line of a state file"},
      {"T= 0\n  X= 1 2 3\n  X= 1 2 3\n", "twice"},
  };
  for (const auto& [text, expected] : cases) {
    std::ofstream(file("d.state")) << text;
    EXPECT_NE(messageOf(file("d.state")).find(expected), std::string::npos) << messageOf(file("d.state"));
  }
}

TEST_F(StateFile, ReadsNumbersThatAreNotFinite) {
  std::ofstream(file("e.state")) << "T= 0.5\n  X= nan 1 -inf\n";
  const auto frames = readStateFile(file("e.state"));
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_TRUE(std::isnan(frames[0].x[0][0]));
  EXPECT_TRUE(std::isinf(frames[0].x[0][2]));
}

TEST(StateFileName, IsTheStatesPath) {
  EXPECT_EQ(stateFileName("/liver/dofs"), "liver.dofs.state.gz");
  EXPECT_EQ(stateFileName("/dofs"), "dofs.state.gz");
}

}  // namespace
