// SPDX-License-Identifier: LGPL-2.1-or-later
// The subcommands of `stroma`, one .cpp each.
#pragma once
#include <filesystem>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace stroma::command {

namespace fs = std::filesystem;

/// What the command returns to the shell.
enum ExitCode : int {
  exit_done = 0,
  exit_comparison_failed = 1,
  exit_bad_input = 2,      ///< or an output that cannot be written: nothing was run
  exit_diverged = 3,       ///< or no equilibrium, or broken constraints, or an action of a replay was refused; the last
                           ///< state was written and named. Of a strict run: or a result in doubt
  exit_output_failed = 4,  ///< an output could not be written any more; what the files have is whole up to there
  // 128 + the number of SIGHUP, SIGINT or SIGTERM: stopped with the last whole step; what was recorded is complete
};

using Arguments = std::vector<std::string>;  ///< what follows the subcommand

/// What --help, shell completion and the manual say of a subcommand's arguments (options.h).
struct CommandLine;

/// Where `stroma --help` lists a subcommand. The order is that of the list.
enum class Group { runs, scenes, checks, command, hidden };

/// One subcommand, defined in its own .cpp.
struct Subcommand {
  const char* name;
  const char* purpose;  ///< half a line
  Group group;
  int (*call)(const Arguments& arguments);
  CommandLine (*line)();
};

/// A mistake in the arguments: a sentence for the user, exit code 2.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

extern const Subcommand run_command, watch_command, view_command, picture_command;
extern const Subcommand check_command, explain_command, list_command, doc_command, schema_command, mesh_command;
extern const Subcommand regress_command, sweep_command, stress_command, bench_command;
extern const Subcommand help_command, man_command, completion_command, complete_command;

/// The one table of subcommands (subcommands.cpp): a new one is a line in it and a declaration above. Help, completion and
/// the manual follow.
std::span<const Subcommand* const> subcommands();
/// Null when there is none.
const Subcommand* findSubcommand(std::string_view name);

}  // namespace stroma::command
