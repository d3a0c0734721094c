// SPDX-License-Identifier: LGPL-2.1-or-later
// `stroma sweep` in a folder of its own, with scenes whose answers are known.
#pragma once
#include <nlohmann/json.hpp>

#include <map>

#include "tests/support/shell.h"
#include "tests/sweep/hanging_bar.h"

namespace stroma::test {

inline bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

inline constexpr const char* bar_meshes = " --vary '/bar/grid.n=2 3 2,2 5 2,2 9 2,2 17 2' -n 1 --repeat 1 -q ";
inline constexpr const char* bar_formula = " --reference '0; -0.01*(1-y-(1-y)^2/2); 0' ";

/// x = 0.1 sin(10 t): a mass on a spring that starts with 1 m/s.
inline constexpr const char* oscillator = R"(<Node name="root" gravity="0 0 0" dt="0.01">
  <EulerImplicitSolver name="solver" rayleighMass="0" rayleighStiffness="0"/>
  <CGLinearSolver name="linear" iterations="100" tolerance="1e-14" threshold="1e-30"/>
  <MechanicalObject name="dofs" position="0 0 0" velocity="1 0 0"/>
  <UniformMass totalMass="1"/>
  <RestShapeSpringsForceField name="spring" stiffness="100"/>
</Node>)";

class Sweep : public CommandTest {
 protected:
  nlohmann::json table(const std::string& folder) const {
    return nlohmann::json::parse(readText(folder_ / folder / "table.json"));
  }
  nlohmann::json tableOf(const std::string& arguments) {
    const Finished run = stroma("sweep " + arguments + " -o out");
    EXPECT_EQ(run.code, 0) << run.err;
    nlohmann::json json = table("out");
    std::filesystem::remove_all(folder_ / "out");
    return json;
  }
  /// The files that say that a run is whole, and when they were written.
  std::map<std::string, std::filesystem::file_time_type> outcomes(const std::string& folder) const {
    std::map<std::string, std::filesystem::file_time_type> found;
    if (!std::filesystem::exists(folder_ / folder / "runs")) return found;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder_ / folder / "runs"))
      if (entry.path().string().ends_with(".outcome.json")) found[entry.path().string()] = entry.last_write_time();
    return found;
  }
  Finished shell(const std::string& line) const {
    write("line.sh", line + "\n");
    const int status = std::system(("cd '" + folder_.string() + "' && sh line.sh >.out 2>.err").c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, readText(folder_ / ".out"), readText(folder_ / ".err")};
  }
};

}  // namespace stroma::test
