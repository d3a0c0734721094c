// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/sweep/process.h"

#include <sys/resource.h>
#include <sys/wait.h>

#include <cmath>
#include <utility>

namespace stroma::sweep {
namespace {

double secondsOf(const timeval& time) { return double(time.tv_sec) + 1e-6 * double(time.tv_usec); }

}  // namespace

Program silentProgram(std::vector<std::string> words, std::string folder, std::string log) {
  const std::string nothing = "/dev/null";
  // Ctrl-C on the terminal is the sweep's to answer; a sweep that is killed leaves no run that would disturb the next one
  Program program{std::move(words), std::move(folder), nothing, nothing, std::move(log)};
  program.signal_with_parent = SIGKILL;
  program.has_group_of_its_own = true;
  return program;
}

bool hasEnded(pid_t process, ProcessEnd& end) {
  int status = 0;
  rusage usage{};
  if (wait4(process, &status, WNOHANG, &usage) != process) return false;
  end.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  end.signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
  end.cpu_seconds = secondsOf(usage.ru_utime) + secondsOf(usage.ru_stime);
  end.preemptions = usage.ru_nivcsw;
  return true;
}

SignalGuard::SignalGuard() {
  sigemptyset(&set_);
  for (const int signal : {SIGCHLD, SIGINT, SIGTERM}) sigaddset(&set_, signal);
  struct sigaction of_terminal {};
  sigaction(SIGHUP, nullptr, &of_terminal);
  if (of_terminal.sa_handler != SIG_IGN) sigaddset(&set_, SIGHUP);  // nohup has it ignored
  sigprocmask(SIG_BLOCK, &set_, &before_);
  // a parent may have had it ignored: then nobody could wait for the runs
  struct sigaction usual {};
  usual.sa_handler = SIG_DFL;
  sigaction(SIGCHLD, &usual, &children_);
}

SignalGuard::~SignalGuard() {
  sigaction(SIGCHLD, &children_, nullptr);
  sigprocmask(SIG_SETMASK, &before_, nullptr);
}

int SignalGuard::wait(double seconds) const {
  const double whole = std::floor(seconds);
  const timespec time{time_t(whole), long(1e9 * (seconds - whole))};
  const int signal = sigtimedwait(&set_, nullptr, &time);
  return signal == SIGINT || signal == SIGTERM || signal == SIGHUP ? signal : 0;
}

}  // namespace stroma::sweep
