// SPDX-License-Identifier: LGPL-2.1-or-later
// A run as a process of its own.
#pragma once
#include <signal.h>

#include "tools/platform/process.h"

namespace stroma::sweep {

/// How a process ended, and what it took.
struct ProcessEnd {
  int exit_code = 0, signal = 0;  ///< of the signal that ended it, else 0
  double cpu_seconds = 0;
  long preemptions = 0;  ///< how often somebody else got its core
};

/// Silent but for its errors, which `log` gets. It ends with this process, whatever becomes of that.
Program silentProgram(std::vector<std::string> words, std::string folder, std::string log);
/// Whether it has ended; `end` tells how.
bool hasEnded(pid_t process, ProcessEnd& end);

/// Thrown where SIGINT, SIGTERM or SIGHUP has come and nothing is left to tell.
struct Stopped {
  int signal = 0;
};

/// While one lives, SIGCHLD, SIGINT, SIGTERM and SIGHUP come by wait() alone.
class SignalGuard {
 public:
  SignalGuard();
  SignalGuard(const SignalGuard&) = delete;
  ~SignalGuard();
  /// Waits until a process has ended, at most `seconds`. Returns SIGINT or SIGTERM when one came, else 0.
  int wait(double seconds) const;

 private:
  sigset_t before_{}, set_{};
  struct sigaction children_ {};
};

}  // namespace stroma::sweep
