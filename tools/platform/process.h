// SPDX-License-Identifier: LGPL-2.1-or-later
// Starts another program in a separate process.
#pragma once
#include <sys/types.h>

#include <string>
#include <vector>

namespace stroma {

/// The program to start. It inherits streams and folder that are not set here. No signal is blocked in it.
struct Program {
  std::vector<std::string> words;     ///< its name, searched in PATH if it has no slash, and its arguments
  std::string folder = {};            ///< working directory
  std::string input = {};             ///< file for standard input
  std::string output = {};            ///< file for standard output
  std::string errors = {};            ///< file for standard error
  std::vector<int> cores = {};        ///< processors that it may use; empty: any
  std::string file = {};              ///< the executable, if it is not the first of the words
  int signal_with_parent = 0;         ///< the signal it gets when this process ends in any way; 0: none
  bool has_group_of_its_own = false;  ///< this process then handles Ctrl-C on the terminal
};

/// Starts it, and returns when it runs. Throws std::system_error (std::errc::no_such_file_or_directory: there is no such program).
pid_t start(const Program& program);
/// Waits for its end. Returns its exit code as a shell does: 128 plus the number of a signal that ended it.
int exitCodeOf(pid_t process);
/// Converts a status of waitpid() to an exit code as a shell does.
int exitCodeOfStatus(int status);

}  // namespace stroma
