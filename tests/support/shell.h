// SPDX-License-Identifier: LGPL-2.1-or-later
// Runs the command as a user does, in a folder of its own.
#pragma once
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace stroma::test {

struct Finished {
  int code = -1;  ///< exit code; -1 when the command died by a signal
  std::string out, err;
};

inline std::string readText(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// A folder for one test: fresh, and the working directory of what it runs.
class CommandTest : public testing::Test {
 protected:
  void SetUp() override {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::path(testing::TempDir()) / (std::string(info->test_suite_name()) + "_" + info->name());
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override {
    if (!HasFailure()) std::filesystem::remove_all(folder_);
  }

  /// `stroma <arguments>` through the shell.
  Finished stroma(const std::string& arguments) const {
    const auto out = folder_ / ".out", err = folder_ / ".err";
    const std::string line = "cd '" + folder_.string() + "' && '" STROMA_COMMAND "' " + arguments + " >.out 2>.err";
    const int status = std::system(line.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, readText(out), readText(err)};
  }
  void write(const std::string& name, const std::string& text) const {
    std::filesystem::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name, std::ios::binary) << text;
  }
  bool exists(const std::string& name) const { return std::filesystem::exists(folder_ / name); }

  std::filesystem::path folder_;
};

/// Two free particles under gravity: needs no force field.
inline const char* const falling_scene = R"(<Node name="root" dt="0.01" gravity="0 -10 0">
  <EulerExplicitSolver/>
  <Node name="stone">
    <MechanicalObject name="dofs" position="0 0 0  1 0 0" velocity="0 0 0  0 2 0"/>
    <UniformMass totalMass="2"/>
  </Node>
</Node>
)";

}  // namespace stroma::test
