// SPDX-License-Identifier: LGPL-2.1-or-later
// stroma bench: hands over to the program stroma-bench beside this one, so that nothing else links the benchmark
// library.
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "framework/scene/services.h"
#include "tools/command/command.h"

namespace stroma::command {

int bench(const Arguments& arguments) {
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe").parent_path() / "stroma-bench";
  std::string name = program.string();
  std::vector<std::string> copies = arguments;
  std::vector<char*> values{name.data()};
  for (std::string& copy : copies) values.push_back(copy.data());
  values.push_back(nullptr);
  execv(name.c_str(), values.data());
  throw UsageError(fmt::format(
      "cannot start {} ({}): {}", name, std::strerror(errno),
      howToGet("stroma-bench", "`tools/setup build` in the sources installs Google Benchmark and builds it")));
}

}  // namespace stroma::command
