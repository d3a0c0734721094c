// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/sweep/process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sched.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <cstring>
#include <stdexcept>

namespace stroma::sweep {
namespace {

double secondsOf(const timeval& time) { return double(time.tv_sec) + 1e-6 * double(time.tv_usec); }

/// In the child, between fork() and exec: system calls only.
[[noreturn]] void becomeRun(const ProcessRequest& request, char* const* words, const cpu_set_t& cores, pid_t parent) {
  constexpr int failed = 127;
  prctl(PR_SET_PDEATHSIG, SIGKILL);  // a sweep that is killed leaves no run that would disturb the next one
  if (getppid() != parent) _exit(failed);
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  setpgid(0, 0);  // Ctrl-C on the terminal is the sweep's to answer
  if (!request.cores.empty()) sched_setaffinity(0, sizeof cores, &cores);
  if (chdir(request.folder.c_str()) != 0) _exit(failed);
  const int nothing = open("/dev/null", O_RDWR);
  const int log = open(request.log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  if (nothing < 0 || log < 0) _exit(failed);
  dup2(nothing, STDIN_FILENO), dup2(nothing, STDOUT_FILENO), dup2(log, STDERR_FILENO);
  execv(words[0], words);
  _exit(failed);
}

}  // namespace

pid_t start(const ProcessRequest& request) {
  std::vector<char*> words;
  for (const std::string& word : request.words) words.push_back(const_cast<char*>(word.c_str()));
  words.push_back(nullptr);
  cpu_set_t cores;
  CPU_ZERO(&cores);
  for (const int core : request.cores) CPU_SET(core, &cores);
  const pid_t parent = getpid(), child = fork();
  if (child == 0) becomeRun(request, words.data(), cores, parent);
  if (child < 0) throw std::runtime_error(fmt::format("cannot start a process ({})", std::strerror(errno)));
  return child;
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
