// SPDX-License-Identifier: LGPL-2.1-or-later
// State files: the same bits back, whole or absent, damage is noticed.
#include "framework/simulation/state_file.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>

#include "framework/scene/output_file.h"
#include "tests/support/folder_fixture.h"

namespace STROMA_TEST_FILE {

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

std::string bytesOf(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

bool sameFrames(const std::vector<StateFrame>& part, const std::vector<StateFrame>& whole) {
  if (part.size() > whole.size()) return false;
  for (std::size_t i = 0; i < part.size(); ++i)
    if (part[i].time != whole[i].time || !sameBits(part[i].x, whole[i].x) || !sameBits(part[i].v, whole[i].v))
      return false;
  return true;
}

TEST_F(StateFile, HoldsEveryInstantFromItsEndOn) {
  const auto x = awkwardNumbers(1000);
  for (const char* name : {"c.state", "c.state.gz"}) {
    StateWriter writer(file(name));
    for (int i = 0; i < 3; ++i) {
      writer.time(i);
      writer.rows("X", x);
      writer.finish();
      const StateRecording recording = readRecording(file(name));
      ASSERT_EQ(recording.frames.size(), std::size_t(i + 1)) << name;
      EXPECT_TRUE(sameBits(recording.frames.back().x, x));
      EXPECT_NE(recording.unfinished.find("its last whole instant is T = " + std::to_string(i)), std::string::npos);
      EXPECT_NE(messageOf(file(name)).find("not finished"), std::string::npos) << "strict readers refuse it";
    }
    writer.close();
    EXPECT_EQ(readRecording(file(name)).unfinished, "");
    EXPECT_EQ(messageOf(file(name)), "");
  }
}

/// Wherever a kill, a full disk or a copy has cut a recording, what is left is a part of it, and said to be one.
TEST_F(StateFile, IsReadUpToTheLastWholeInstantWhereverItIsCut) {
  for (const char* name : {"c.state", "c.state.gz"}) {
    writeFrames(file(name), awkwardNumbers(3), 4);
    const StateRecording whole = readRecording(file(name));
    const std::string bytes = bytesOf(file(name));
    for (std::size_t size = 1; size < bytes.size(); ++size) {
      write(std::string("cut.") + name, bytes.substr(0, size));
      const auto ends = std::upper_bound(whole.ends.begin(), whole.ends.end(), size) - whole.ends.begin();
      try {
        const StateRecording cut = readRecording(file(std::string("cut.") + name));
        EXPECT_EQ(cut.frames.size(), std::size_t(ends)) << size;
        EXPECT_TRUE(sameFrames(cut.frames, whole.frames)) << size;
        EXPECT_NE(cut.unfinished, "") << size;
      } catch (const std::runtime_error&) {
        EXPECT_EQ(ends, 0) << size << ": before the first instant there is nothing to read";
      }
    }
  }
}

TEST_F(StateFile, NoticesEveryBitThatChangesAValue) {
  for (const char* name : {"c.state", "c.state.gz"}) {
    writeFrames(file(name), awkwardNumbers(2), 2);
    const std::vector<StateFrame> whole = readStateFile(file(name));
    const std::string bytes = bytesOf(file(name));
    int noticed = 0;
    for (std::size_t at = 0; at < bytes.size(); ++at) {
      std::string other = bytes;
      other[at] = char(other[at] ^ 1);
      write("flipped", other);
      if (!messageOf(file("flipped")).empty())
        ++noticed;
      else
        EXPECT_TRUE(sameFrames(readStateFile(file("flipped")), whole)) << name << " " << at;
    }
    EXPECT_GT(noticed, int(bytes.size()) / 2);
  }
}

TEST_F(StateFile, GoesOnWithTheBytesOfOneThatNeverStopped) {
  const auto x = awkwardNumbers(50);
  for (const char* name : {"c.state", "c.state.gz"}) {
    writeFrames(file(name), x, 6);
    const std::string whole = bytesOf(file(name));
    for (const std::size_t cut : {std::size_t(0), whole.size() / 4, whole.size() / 7}) {
      write(name, whole.substr(0, whole.size() - cut));
      StateWriter writer(file(name));
      EXPECT_EQ(writer.goOn(0.1 * 3, true), 0.1 * 3);
      for (int i = 4; i < 6; ++i) {
        writer.time(0.1 * i);
        writer.rows("X", x);
        writer.rows("V", x);
      }
      writer.close();
      EXPECT_TRUE(bytesOf(file(name)) == whole) << name << " " << cut;
    }
    StateWriter writer(file(name));
    EXPECT_EQ(writer.goOn(0.1 * 3, false), 0.1 * 2);
    EXPECT_EQ(writer.goOn(-1, true), std::nullopt);
  }
  write("foreign.state", "T= 0\n  X= 1 2 3\n");
  StateWriter writer(file("foreign.state"));
  EXPECT_THROW(writer.goOn(1, true), std::runtime_error);
}

/// Compressed by another program, all instants are one piece: good to read, not to append to.
TEST_F(StateFile, IsReadWhenItWasCompressedAnew) {
  const auto x = awkwardNumbers(50);
  writeFrames(file("c.state.gz"), x, 6);
  const std::string command =
      "cd '" + folder_.string() + "' && gzip -dc c.state.gz >c.state && gzip -c c.state >d.state.gz";
  ASSERT_EQ(std::system(command.c_str()), 0);
  const auto one = readStateFile(file("c.state.gz")), other = readStateFile(file("d.state.gz"));
  ASSERT_EQ(other.size(), 6u);
  for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(one[i].x, other[i].x);
  StateWriter writer(file("d.state.gz"));
  try {
    writer.goOn(0.1 * 3, true);
    ADD_FAILURE() << "went on in the middle of a piece";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("recompressed"), std::string::npos) << error.what();
  }
}

TEST_F(StateFile, TakesNothingFromTheFileBeforeUntilItHasAnInstant) {
  write("c.state", "T= 0\n  X= 1 2 3\n");
  {
    StateWriter old(file("c.state")), fresh(file("new.state.gz"));
    old.time(1);
  }
  EXPECT_EQ(readStateFile(file("c.state")).front().x.front(), Vec3(1, 2, 3));
  EXPECT_FALSE(exists("new.state.gz"));
}

TEST_F(StateFile, SaysWhyItCannotBeWritten) {
  const auto reason = [](auto&& write) {
    try {
      write();
    } catch (const OutputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  StateWriter full("/dev/full");
  full.time(0);
  EXPECT_EQ(reason([&] { full.finish(); }), "/dev/full: cannot write (No space left on device)");
  EXPECT_EQ(reason([&] { full.finish(), full.close(); }), "") << "said once";
  write("plain", "");
  EXPECT_EQ(reason([&] { StateWriter{file("plain/a.state")}; }),
            file("plain") + ": cannot make the folder (Not a directory)");
  EXPECT_EQ(reason([&] { StateWriter{folder_.string()}; }),
            folder_.string() + ": cannot open for writing (Is a directory)");
  StateWriter gone(file("gone/a.state"));
  gone.time(0);
  gone.finish();
  fs::remove_all(folder_ / "gone");
  gone.time(1);
  const std::string said = reason([&] { gone.finish(); });
  EXPECT_NE(said.find("gone/a.state: the file was removed while it was being written"), std::string::npos) << said;
}

TEST_F(StateFile, NoticesDamage) {
  // "T= 0\n  X= 1 2 3\n", compressed by gzip: whole, and without the last byte of its check sum. All of the text is there.
  constexpr unsigned char zipped[] = {31,  139, 8,  0,  0,  0,  0,  0,   2, 3, 11, 177, 85, 48, 224, 82, 80, 136,
                                      176, 85,  48, 84, 48, 82, 48, 230, 2, 0, 76, 112, 88, 73, 16,  0,  0,  0};
  const std::string bytes(zipped, zipped + sizeof zipped);
  EXPECT_EQ(readStateFile(write("d.state.gz", bytes)).size(), 1u);
  EXPECT_NE(messageOf(write("d.state.gz", bytes.substr(0, bytes.size() - 1))).find("cut short"), std::string::npos);
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

}  // namespace STROMA_TEST_FILE
