// SPDX-License-Identifier: LGPL-2.1-or-later
// fork() and exec() rather than posix_spawn(), which has neither the signal of a parent's end nor the choice of cores.
#include "tools/platform/process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sched.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <optional>
#include <system_error>
#include <utility>

namespace stroma {
namespace {

bool opens(const std::string& file, int flags, int stream) {
  if (file.empty()) return true;
  const int opened = open(file.c_str(), flags | O_CLOEXEC, 0644);
  if (opened == stream) return fcntl(stream, F_SETFD, 0) == 0;  // this process has closed its own
  return opened >= 0 && dup2(opened, stream) >= 0;
}

/// In the child: system calls only, since locks of other threads may be held. False, with errno, where something fails.
bool becomesReady(const Program& program, const cpu_set_t& cores, pid_t parent) {
  if (program.signal_with_parent != 0) {
    prctl(PR_SET_PDEATHSIG, program.signal_with_parent);
    if (getppid() != parent) _exit(1);  // it has ended already
  }
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  if (program.has_group_of_its_own) setpgid(0, 0);
  if (!program.cores.empty()) sched_setaffinity(0, sizeof cores, &cores);
  if (!program.folder.empty() && chdir(program.folder.c_str()) != 0) return false;
  constexpr int written = O_WRONLY | O_CREAT | O_TRUNC;
  return opens(program.input, O_RDONLY, STDIN_FILENO) && opens(program.output, written, STDOUT_FILENO) &&
         opens(program.errors, written, STDERR_FILENO);
}

/// Closed by exec(): whoever reads from it learns that the program runs, or why it does not.
class Report {
 public:
  Report() {
    if (pipe2(ends_, O_CLOEXEC) != 0) throw std::system_error(errno, std::generic_category(), "no pipe can be made");
    for (int& end : ends_)  // where this process has closed its standard streams the numbers of these are free
      if (end <= STDERR_FILENO) close(std::exchange(end, fcntl(end, F_DUPFD_CLOEXEC, STDERR_FILENO + 1)));
  }
  Report(const Report&) = delete;
  ~Report() { close(ends_[0]), close(ends_[1]); }
  void tell(int error) const { [[maybe_unused]] const ssize_t count = write(ends_[1], &error, sizeof error); }
  /// 0: it runs.
  int hear() {
    close(ends_[1]);
    ends_[1] = -1;
    int error = 0;
    ssize_t count = 0;
    while ((count = read(ends_[0], &error, sizeof error)) < 0 && errno == EINTR) {
    }
    return count == ssize_t(sizeof error) ? error : 0;
  }

 private:
  int ends_[2] = {-1, -1};
};

/// waitpid() to the end.
std::optional<int> statusOf(pid_t process) {
  int status = 0;
  pid_t ended = 0;
  while ((ended = waitpid(process, &status, 0)) < 0 && errno == EINTR) {
  }
  return ended == process ? std::optional(status) : std::nullopt;
}

}  // namespace

pid_t start(const Program& program) {
  std::vector<char*> words;
  for (const std::string& word : program.words) words.push_back(const_cast<char*>(word.c_str()));
  words.push_back(nullptr);
  cpu_set_t cores;
  CPU_ZERO(&cores);
  for (const int core : program.cores) CPU_SET(core, &cores);
  Report report;
  const pid_t parent = getpid(), child = fork();
  if (child == 0) {
    if (becomesReady(program, cores, parent)) execvp(program.file.empty() ? words[0] : program.file.c_str(), words.data());
    report.tell(errno);
    _exit(127);
  }
  if (child < 0) throw std::system_error(errno, std::generic_category(), "no process can be made");
  if (const int error = report.hear(); error != 0) {
    statusOf(child);
    throw std::system_error(error, std::generic_category(), fmt::format("{} cannot be started", program.words[0]));
  }
  return child;
}

int exitCodeOfStatus(int status) { return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status); }

int exitCodeOf(pid_t process) {
  const std::optional<int> status = statusOf(process);
  return status ? exitCodeOfStatus(*status) : -1;
}

}  // namespace stroma
