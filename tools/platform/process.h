// SPDX-License-Identifier: LGPL-2.1-or-later
// Another program, in a process of its own.
#pragma once
#include <sys/types.h>

#include <string>
#include <vector>

namespace stroma {

/// What is started, and what it has of this process: the streams and the folder that are not named. No signal is blocked in it.
struct Program {
  std::vector<std::string> words;     ///< its name, looked for in PATH where that has no slash, and its arguments
  std::string folder = {};            ///< where it works
  std::string input = {};             ///< file that it reads in place of the standard input
  std::string output = {};            ///< file that gets its standard output
  std::string errors = {};            ///< file that gets its standard error
  std::vector<int> cores = {};        ///< processors that it may use; empty: any
  std::string file = {};              ///< what runs, where that is not the first of the words
  int signal_with_parent = 0;         ///< what it gets when this process ends, whatever becomes of that; 0: nothing
  bool has_group_of_its_own = false;  ///< Ctrl-C on the terminal is then this process' to answer
};

/// Starts it, and returns when it runs. Throws std::system_error (std::errc::no_such_file_or_directory: there is no such program).
pid_t start(const Program& program);
/// Waits for its end. Returns its exit code, as a shell gives it: 128 and the number of the signal that ended it.
int exitCodeOf(pid_t process);
/// What a shell makes of the status that waitpid() gives.
int exitCodeOfStatus(int status);

}  // namespace stroma
