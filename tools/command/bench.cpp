// SPDX-License-Identifier: LGPL-2.1-or-later
// stroma bench: hands over to the program stroma-bench beside this one, so that nothing else links the benchmark
// library.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>

#include "framework/scene/services.h"
#include "tools/command/options.h"

namespace stroma::command {
namespace {

const Manual bench_manual{
    "stroma bench [options]",
    "Measures the limits of this machine and, as shares of them, what Stroma does: products, forces, assembly, whole "
    "steps,\nstart-up. Prints a table; never fails because something was slow. Every option of Google Benchmark is "
    "passed on, as\n--benchmark_list_tests and --benchmark_repetitions=N.",
    "  stroma bench\n"
    "  stroma bench --benchmark_filter='product|force' --json figures.json\n"
    "  stroma bench --accuracy --csv figures.csv\n"};

CommandLine benchLine() {
  const auto text = [](const char* word) { return po::value<std::string>()->value_name(word); };
  OptionList options("options");
  options.add_options()                                                                                  //
      ("json", text("FILE"), "write everything, each repetition too")                                    //
      ("scenes", text("DIR"), "the folder that contains benchmarks/, examples/ and meshes/")                //
      ("accuracy", po::value<std::string>()->implicit_value("")->value_name("PROBLEM"),
       "error against run time of the standing set instead, or of one: beam, cube, beads, block, cook, twist, chamber, ventricle, "
       "muscle, column, organ, leg, memory, vibration; column/20,40: of some of its sizes")                    //
      ("csv", text("FILE"), "with --accuracy: write the figures to a file")                                    //
      ("against", text("FILE"), "with --accuracy: report changes since --csv wrote this file")           //
      ("beads", text("FILE"), "with --accuracy: the truth cube's measured beads, without which beads is left out")  //
      ("benchmark_filter", text("EXPR"), "only the figures that match, as in --benchmark_filter=step");  //
  return {bench_manual, options, {}};
}

int bench(const Arguments& arguments) {
  const auto asksForHelp = [](const std::string& word) { return word == "--help" || word == "-h"; };
  if (std::ranges::any_of(arguments, asksForHelp)) return parseOptions(benchLine(), {"--help"}), exit_done;
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

}  // namespace

const Subcommand bench_command{"bench", "measure the speed of the kernels and solvers", Group::checks, bench, benchLine};

}  // namespace stroma::command
