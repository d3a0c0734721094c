// SPDX-License-Identifier: LGPL-2.1-or-later
// Runs the command as a user does, in a folder of its own.
#pragma once
#include <sys/wait.h>

#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <vector>

#include "tests/support/folder_fixture.h"

namespace stroma::test {

struct Finished {
  int code = -1;  ///< exit code; -1 when the command died by a signal
  std::string out, err;
};

inline std::string readText(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// The numbers of a file of instants: of each its time, positions and velocities.
inline std::vector<double> instantsIn(const std::filesystem::path& file) {
  const std::string bytes = readText(file), data = bytes.substr(std::min(bytes.size(), bytes.find('\n') + 1));
  std::vector<double> numbers(data.size() / sizeof(double));
  std::memcpy(numbers.data(), data.data(), numbers.size() * sizeof(double));
  return numbers;
}

/// The folder is the working directory of what a test runs.
class CommandTest : public FolderTest {
 protected:
  /// `stroma <arguments>` through the shell.
  Finished stroma(const std::string& arguments) const { return shell("'" STROMA_COMMAND "' " + arguments); }
  /// Any command.
  Finished shell(const std::string& command) const {
    const auto out = folder_ / ".out", err = folder_ / ".err";
    const int status = std::system(("cd '" + folder_.string() + "' && " + command + " >.out 2>.err").c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, readText(out), readText(err)};
  }
  /// Whether a program is installed: tests that need another one skip without it.
  static bool isInstalled(const std::string& program) {
    return std::system(("command -v " + program + " >/dev/null").c_str()) == 0;
  }
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

/// A chain whose solves may take fewer iterations than they need.
const char* const capped_chain = R"(<Node name="root" dt="0.1" gravity="0 -10 0">
  <EulerImplicitSolver/><CGLinearSolver iterations="2" tolerance="1e-9"/>
  <MechanicalObject position="0 0 0  1 0 0  2 0 0  3 0 0  4 0 0  5 0 0"/><UniformMass totalMass="1"/>
  <SpringForceField springsIndices1="0 1 2 3 4" springsIndices2="1 2 3 4 5" stiffness="900" lengths="1 1 1 1 1"/>
  <FixedProjectiveConstraint indices="0"/></Node>)";

}  // namespace stroma::test
