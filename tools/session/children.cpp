// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/session/children.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <fstream>
#include <stdexcept>
#include <vector>

namespace stroma {
namespace {

// the last byte: the text before it is all, of what was returned or thrown
constexpr char returned = '\x01', thrown = '\x02';

void writeAll(int pipe, const std::string& text) {
  for (std::size_t at = 0; at < text.size();) {
    const ssize_t count = write(pipe, text.data() + at, text.size() - at);
    if (count <= 0) return;
    at += std::size_t(count);
  }
}

/// What it prints goes nowhere.
[[noreturn]] void work(int pipe, pid_t parent, const std::function<std::string()>& call, double gigabytes) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(1);  // it has ended already
  rlimit memory{};
  getrlimit(RLIMIT_AS, &memory);
  memory.rlim_cur = std::min(memory.rlim_cur, rlim_t(std::min(gigabytes, 1e9) * double(1 << 30)));
  setrlimit(RLIMIT_AS, &memory);
  rlimit none{};
  setrlimit(RLIMIT_CORE, &none);
  if (const int nowhere = open("/dev/null", O_WRONLY); nowhere >= 0) dup2(nowhere, 1), dup2(nowhere, 2);
  try {
    writeAll(pipe, call() + returned);
  } catch (const std::exception& error) {
    writeAll(pipe, std::string(error.what()) + thrown);
  } catch (...) {  // not a word of it: the parent says that it ended
  }
  _exit(0);
}

/// Of a child and the programs that it runs, so far [s]; 0 where it cannot be known.
double processorSeconds(pid_t process) {
  clockid_t clock{};
  timespec time{};
  if (clock_getcpuclockid(process, &clock) != 0 || clock_gettime(clock, &time) != 0) return 0;
  double sum = double(time.tv_sec) + 1e-9 * double(time.tv_nsec);
  std::ifstream programs(fmt::format("/proc/{0}/task/{0}/children", process));
  for (pid_t program = 0; programs >> program;) sum += processorSeconds(program);
  return sum;
}

}  // namespace

Children::~Children() {
  for (auto& [number, child] : children_) {
    kill(child.process, SIGKILL);
    close(child.pipe);
    waitpid(child.process, nullptr, 0);
  }
}

void Children::start(long number, double seconds, const std::function<std::string()>& call, double gigabytes) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0)
    throw std::runtime_error(fmt::format("no pipe can be made: {}", std::strerror(errno)));
  std::fflush(nullptr);
  Child child;
  const pid_t parent = getpid();
  child.process = fork();
  if (child.process < 0) {
    const int reason = errno;
    close(ends[0]), close(ends[1]);
    throw std::runtime_error(fmt::format("no process can be made: {}", std::strerror(reason)));
  }
  if (child.process == 0) {
    close(ends[0]);
    work(ends[1], parent, call, gigabytes);
  }
  close(ends[1]);
  child.pipe = ends[0], child.seconds = seconds;
  child.last_work = Clock::now();
  children_.emplace(number, std::move(child));
}

ChildEnd Children::endOf(long number, Child& child) const {
  close(child.pipe);
  int status = 0;
  waitpid(child.process, &status, 0);
  ChildEnd end{number, {}, {}, child.is_late};
  const char last = child.text.empty() ? '\0' : child.text.back();
  if (last == returned || last == thrown) {
    child.text.pop_back();
    (last == returned ? end.text : end.failure) = std::move(child.text);
    end.is_late = false;
  } else if (child.is_late) {
    end.failure = fmt::format("abandoned after {:.3g} s of processor time", child.seconds);
  } else if (child.is_stuck) {
    end.failure = fmt::format("it hangs: no processor time used in {:.3g} s", patience_);
  } else if (WIFSIGNALED(status)) {
    end.failure = fmt::format("it crashes with SIG{}", sigabbrev_np(WTERMSIG(status)));
  } else {
    end.failure = fmt::format("its process ends with code {} and no message", WEXITSTATUS(status));
  }
  return end;
}

/// Ends those that are late, and those that stand still.
void Children::watch() {
  using Seconds = std::chrono::duration<double>;
  const auto now = Clock::now();
  const bool was_away = Seconds(now - last_watch_).count() > 0.5 * patience_;  // stopped itself, as by Ctrl-Z
  last_watch_ = now;
  for (auto& [number, child] : children_) {
    if (child.is_late || child.is_stuck) continue;
    const double used = processorSeconds(child.process);
    if (used > child.used + 1e-3 || was_away) child.used = used, child.last_work = now;
    child.is_late = used > child.seconds;
    child.is_stuck = !child.is_late && Seconds(now - child.last_work).count() > patience_;
    if (child.is_late || child.is_stuck) kill(child.process, SIGKILL);
  }
}

bool Children::wait(ChildEnd& end) {
  watch();
  std::vector<pollfd> pipes;
  std::vector<long> numbers;
  for (auto& [number, child] : children_) {
    pipes.push_back({child.pipe, POLLIN, 0});
    numbers.push_back(number);
  }
  constexpr int patience = 100;  // ms
  poll(pipes.data(), nfds_t(pipes.size()), patience);
  for (std::size_t k = 0; k < pipes.size(); ++k) {
    if (pipes[k].revents == 0) continue;
    char piece[65536];
    const ssize_t count = read(pipes[k].fd, piece, sizeof piece);
    Child& child = children_.at(numbers[k]);
    if (count > 0) {
      child.text.append(piece, std::size_t(count));
    } else if (count == 0 || errno != EINTR) {
      end = endOf(numbers[k], child);
      children_.erase(numbers[k]);
      return true;
    }
  }
  return false;
}

void runJobs(int count, const JobLimits& limits, const std::function<std::string(int)>& work,
             const std::function<void(int, const ChildEnd&)>& done) {
  Children children;
  std::map<long, ChildEnd> waiting;
  for (int next = 0, told = 0; told < count;) {
    for (; next < count && int(children.running()) < limits.at_once; ++next)
      children.start(next, limits.seconds, [&, next] { return work(next); }, limits.gigabytes);
    ChildEnd end;
    if (children.wait(end)) waiting.emplace(end.number, end);
    for (auto first = waiting.find(told); first != waiting.end(); first = waiting.find(++told)) {
      done(told, first->second);
      waiting.erase(first);
    }
  }
}

}  // namespace stroma
