// SPDX-License-Identifier: LGPL-2.1-or-later
// The one table of subcommands, in the order of the help, and the call of any of them.
#include <algorithm>
#include <array>

#include "tools/command/command.h"
#include "tools/command/help.h"
#include "tools/command/run_command.h"
#include "tools/command/sofa_runs.h"

namespace stroma::command {

std::span<const Subcommand* const> subcommands() {
  static constexpr std::array table{
      // run and see
      &run_command,
      &watch_command,
      &view_command,
      &picture_command,
      // make scenes
      &check_command,
      &explain_command,
      &list_command,
      &doc_command,
      &schema_command,
      &migrate_command,
      &mesh_command,
      // compare and measure
      &regress_command,
      &sweep_command,
      &stress_command,
      &bench_command,
      // the command itself
      &help_command,
      &man_command,
      &completion_command,
      &complete_command,
  };
  return table;
}

const Subcommand* findSubcommand(std::string_view name) {
  const auto table = subcommands();
  const auto found = std::ranges::find(table, name, [](const Subcommand* one) { return std::string_view(one->name); });
  return found == table.end() ? nullptr : *found;
}

int runCommand(const Arguments& arguments) {
  return tellErrors([&]() -> int {
    if (arguments.empty()) return printOverview(stderr), exit_bad_input;
    if (arguments[0] == "--help" || arguments[0] == "-h") return printOverview(stdout), exit_done;
    if (arguments[0] == "--version") return printVersion(), exit_done;
    return subcommandNamed(arguments[0]).call({arguments.begin() + 1, arguments.end()});
  });
}

}  // namespace stroma::command
