// SPDX-License-Identifier: LGPL-2.1-or-later
// stroma --help, stroma help and stroma --version.
#include "tools/command/help.h"

#include <fmt/format.h>

#include <array>
#include <boost/version.hpp>

#include "framework/scene/diagnostics.h"
#include "framework/scene/modules.h"
#include "framework/scene/services.h"
#include "tools/command/options.h"

namespace stroma::command {
namespace {

constexpr std::array<std::pair<Group, const char*>, 4> groups{{
    {Group::runs, "run and see"},
    {Group::scenes, "make scenes"},
    {Group::checks, "compare and measure"},
    {Group::command, "the command itself"},
}};

const Manual help_manual{"stroma help [SUBCOMMAND]", "Prints what `stroma --help` prints, or the help of a subcommand.",
                    "  stroma help\n  stroma help run\n"};

CommandLine helpLine() { return {help_manual, OptionList("options"), {"SUBCOMMAND"}}; }

int help(const Arguments& arguments) {
  const auto values = parseOptions(helpLine(), arguments);
  if (!values) return exit_done;
  if (!values->count("SUBCOMMAND")) return printOverview(stdout), exit_done;
  return subcommandNamed((*values)["SUBCOMMAND"].as<std::string>()).call({"--help"});
}

}  // namespace

std::span<const std::pair<Group, const char*>> groupNames() { return groups; }

const Subcommand& subcommandNamed(const std::string& name) {
  if (const Subcommand* subcommand = findSubcommand(name)) return *subcommand;
  std::vector<std::string> names;
  for (const Subcommand* subcommand : subcommands())
    if (subcommand->group != Group::hidden) names.emplace_back(subcommand->name);
  const std::string near = nearest(name, names);
  throw UsageError(fmt::format("there is no subcommand '{}' ({})", name,
                               near.empty() ? fmt::format("expected one of: {}", fmt::join(names, ", "))
                                            : fmt::format("did you mean '{}'?", near)));
}

void printOverview(std::FILE* stream) {
  fmt::print(stream, "stroma {}: soft tissue from an XML scene\n\nusage: stroma SUBCOMMAND ...\n", STROMA_VERSION);
  for (const auto& [group, title] : groups) {
    fmt::print(stream, "\n{}\n", title);
    for (const Subcommand* subcommand : subcommands())
      if (subcommand->group == group) fmt::print(stream, "  {:10} {}\n", subcommand->name, subcommand->purpose);
  }
  fmt::print(
      stream,
      "\n`stroma SUBCOMMAND --help` prints its options and examples, `stroma doc scene` the file format.\n"
      "Exit codes: 0 done, 1 a comparison failed, 2 bad input (nothing was run), 3 no result (the last state is\n"
      "written and named), 4 an output could not be written any more, 129 ended by SIGHUP, 130 interrupted with\n"
      "Ctrl-C, 143 ended by SIGTERM.\n"
      "Environment: STROMA_MODULE_PATH folders of modules of your own, STROMA_DATA_PATH folders of files that scenes name\n"
      "(several with colons between), STROMA_LEVEL a lower instruction set than this machine's best.\n");
}

void printVersion() {
  Factory factory;
  const Modules modules(factory);
  fmt::print("stroma {}\n", STROMA_VERSION);
  fmt::print("compiled by GCC {}, {}\n", __VERSION__, STROMA_BUILD_TYPE);
  fmt::print("libraries: Eigen {}.{}.{}, Boost {}.{}, fmt {}.{}.{}\n", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION,
             EIGEN_MINOR_VERSION, BOOST_VERSION / 100000, BOOST_VERSION / 100 % 1000, FMT_VERSION / 10000,
             FMT_VERSION / 100 % 100, FMT_VERSION % 100);
  fmt::print("modules: {} with {} components in {}; this machine opens those for {}\n", modules.notOpened().size(),
             modules.index().size(), moduleFolder(), instructionLevel());
  fmt::print("licence: LGPL-2.1-or-later\n");
}

const Subcommand help_command{"help", "print this, or the help of a subcommand", Group::command, help, helpLine};

}  // namespace stroma::command
