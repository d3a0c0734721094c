// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/command/child_jobs.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <map>
#include <stdexcept>

namespace stroma::command {
namespace {

using Clock = std::chrono::steady_clock;

struct Child {
  pid_t process = -1;
  int pipe = -1;
  Clock::time_point end;
  std::string text;
  bool is_late = false;
};

void writeAll(int pipe, const std::string& text) {
  for (std::size_t at = 0; at < text.size();) {
    const ssize_t count = write(pipe, text.data() + at, text.size() - at);
    if (count <= 0) return;
    at += std::size_t(count);
  }
}

/// In the child; what it prints goes nowhere. The last byte says that the text is whole.
[[noreturn]] void work(int pipe, int i, const JobLimits& limits, const std::function<std::string(int)>& call) {
  rlimit memory{};
  memory.rlim_cur = memory.rlim_max = rlim_t(limits.gigabytes * double(1 << 30));
  setrlimit(RLIMIT_AS, &memory);
  rlimit none{};
  setrlimit(RLIMIT_CORE, &none);
  if (const int nowhere = open("/dev/null", O_WRONLY); nowhere >= 0) dup2(nowhere, 1), dup2(nowhere, 2);
  try {
    writeAll(pipe, call(i) + '\x01');
  } catch (const std::exception& error) {
    writeAll(pipe, std::string(error.what()) + '\x02');
  }
  _exit(0);
}

Child start(int i, const JobLimits& limits, const std::function<std::string(int)>& call) {
  int ends[2];
  if (pipe(ends) != 0) throw std::runtime_error(std::string("no pipe can be made: ") + std::strerror(errno));
  std::fflush(nullptr);
  Child child;
  child.process = fork();
  if (child.process < 0) throw std::runtime_error(std::string("no process can be made: ") + std::strerror(errno));
  if (child.process == 0) {
    close(ends[0]);
    work(ends[1], i, limits, call);
  }
  close(ends[1]);
  child.pipe = ends[0];
  child.end = Clock::now() + std::chrono::milliseconds(long(limits.seconds * 1000));
  return child;
}

JobEnd finish(Child& child, const JobLimits& limits) {
  close(child.pipe);
  int status = 0;
  waitpid(child.process, &status, 0);
  const char last = child.text.empty() ? '\0' : child.text.back();
  JobEnd end;
  if (last == '\x01' || last == '\x02') {
    child.text.pop_back();
    (last == '\x01' ? end.text : end.failure) = child.text;
  } else if (child.is_late) {
    end.failure = fmt::format("took longer than {:g} s", limits.seconds);
  } else if (WIFSIGNALED(status)) {
    end.failure = fmt::format("crashed (signal {})", WTERMSIG(status));
  } else {
    end.failure = "ended without a word";
  }
  return end;
}

/// Takes what the children write; returns one that has ended, or -1 after a while.
int waitForOne(std::map<int, Child>& running) {
  std::vector<pollfd> pipes;
  std::vector<int> numbers;
  for (auto& [number, child] : running) {
    if (!child.is_late && Clock::now() > child.end) {
      child.is_late = true;
      kill(child.process, SIGKILL);
    }
    pipes.push_back({child.pipe, POLLIN, 0});
    numbers.push_back(number);
  }
  constexpr int patience = 100;  // ms
  poll(pipes.data(), nfds_t(pipes.size()), patience);
  for (std::size_t k = 0; k < pipes.size(); ++k) {
    if (pipes[k].revents == 0) continue;
    char piece[65536];
    const ssize_t count = read(pipes[k].fd, piece, sizeof piece);
    if (count > 0)
      running.at(numbers[k]).text.append(piece, std::size_t(count));
    else
      return numbers[k];
  }
  return -1;
}

}  // namespace

void runJobs(int count, const JobLimits& limits, const std::function<std::string(int)>& work,
             const std::function<void(int, const JobEnd&)>& done) {
  std::map<int, Child> running;
  std::map<int, JobEnd> waiting;
  int next = 0, told = 0;
  while (told < count) {
    while (next < count && int(running.size()) < limits.at_once) {
      running.emplace(next, start(next, limits, work));
      ++next;
    }
    if (const int ended = waitForOne(running); ended >= 0) {
      waiting.emplace(ended, finish(running.at(ended), limits));
      running.erase(ended);
    }
    for (auto first = waiting.find(told); first != waiting.end(); first = waiting.find(++told)) {
      done(told, first->second);
      waiting.erase(first);
    }
  }
}

}  // namespace stroma::command
