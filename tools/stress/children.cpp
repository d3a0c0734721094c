// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/stress/children.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <new>
#include <stdexcept>
#include <vector>

namespace stroma::stress {
namespace {

constexpr char whole = '\x01';  ///< the last byte: the text before it is all

void writeAll(int pipe, const std::string& text) {
  for (std::size_t at = 0; at < text.size();) {
    const ssize_t count = write(pipe, text.data() + at, text.size() - at);
    if (count <= 0) return;
    at += std::size_t(count);
  }
}

/// What it prints goes nowhere.
[[noreturn]] void work(int pipe, const std::function<std::string()>& call) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  rlimit none{};
  setrlimit(RLIMIT_CORE, &none);
  if (const int nowhere = open("/dev/null", O_WRONLY); nowhere >= 0) dup2(nowhere, 1), dup2(nowhere, 2);
  const char end = whole;
  try {
    writeAll(pipe, call());
    if (write(pipe, &end, 1) != 1) _exit(1);
  } catch (...) {  // not a word of it: the parent says that it ended
  }
  _exit(0);
}

}  // namespace

Children::~Children() {
  for (auto& [number, child] : children_) {
    kill(child.process, SIGKILL);
    close(child.pipe);
    waitpid(child.process, nullptr, 0);
  }
}

void Children::start(long number, double seconds, const std::function<std::string()>& call) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0)
    throw std::runtime_error(fmt::format("no pipe can be made: {}", std::strerror(errno)));
  std::fflush(nullptr);
  Child child;
  child.process = fork();
  if (child.process < 0) throw std::runtime_error(fmt::format("no process can be made: {}", std::strerror(errno)));
  if (child.process == 0) {
    close(ends[0]);
    work(ends[1], call);
  }
  close(ends[1]);
  child.pipe = ends[0], child.seconds = seconds;
  child.latest = Clock::now() + std::chrono::milliseconds(long(seconds * 1000));
  children_.emplace(number, std::move(child));
}

ChildEnd Children::endOf(long number, Child& child) {
  close(child.pipe);
  int status = 0;
  waitpid(child.process, &status, 0);
  ChildEnd end{number, {}, {}, child.is_late};
  if (!child.text.empty() && child.text.back() == whole) {
    child.text.pop_back();
    end.text = std::move(child.text);
    end.is_late = false;
  } else if (child.is_late) {
    end.failure = fmt::format("given up after {:.3g} s", child.seconds);
  } else if (WIFSIGNALED(status)) {
    end.failure = fmt::format("it crashes with SIG{}", sigabbrev_np(WTERMSIG(status)));
  } else {
    end.failure = fmt::format("its process ends with code {} and without a word", WEXITSTATUS(status));
  }
  return end;
}

bool Children::wait(ChildEnd& end) {
  std::vector<pollfd> pipes;
  std::vector<long> numbers;
  for (auto& [number, child] : children_) {
    if (!child.is_late && Clock::now() > child.latest) {
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
    Child& child = children_.at(numbers[k]);
    if (count > 0) {
      child.text.append(piece, std::size_t(count));
    } else {
      end = endOf(numbers[k], child);
      children_.erase(numbers[k]);
      return true;
    }
  }
  return false;
}

}  // namespace stroma::stress
