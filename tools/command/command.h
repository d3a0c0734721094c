// SPDX-License-Identifier: LGPL-2.1-or-later
// The subcommands of `stroma`, one .cpp each.
#pragma once
#include <stdexcept>
#include <string>
#include <vector>

namespace stroma::command {

/// What the command returns to the shell.
enum ExitCode : int {
  exit_done = 0,
  exit_comparison_failed = 1,
  exit_bad_input = 2,      ///< or an output that cannot be written: nothing was run
  exit_diverged = 3,       ///< or no equilibrium, or broken constraints, or an action of a replay was refused; the last
                           ///< state was written and named. Of a strict run: or a result in doubt
  exit_output_failed = 4,  ///< an output could not be written any more; what the files have is whole up to there
  // 128 + the number of SIGINT or SIGTERM: stopped after a whole step; what was recorded is complete
};

using Arguments = std::vector<std::string>;  ///< what follows the subcommand

/// A mistake in the arguments: a sentence for the user, exit code 2.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

int run(const Arguments& arguments);
int check(const Arguments& arguments);
int explain(const Arguments& arguments);
int list(const Arguments& arguments);
int doc(const Arguments& arguments);
int regress(const Arguments& arguments);
int mesh(const Arguments& arguments);
int bench(const Arguments& arguments);
int view(const Arguments& arguments);
int picture(const Arguments& arguments);

}  // namespace stroma::command
