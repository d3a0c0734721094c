// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/sweep/scheduler.h"

#include <algorithm>
#include <csignal>

#include "tools/sweep/cores.h"

namespace stroma::sweep {

Scheduler::Scheduler(std::vector<int> cores, int timed_cores)
    : all_(std::move(cores)), free_(all_), timed_cores_(timed_cores > 0 ? timed_cores : std::max(1, allCores() / 2)) {
  timed_cores_ = std::min(timed_cores_, allCores());
}

/// A run with more threads than the machine has cores gets all of them.
int Scheduler::coresOf(const Job& job) const { return std::min(job.cores, allCores()); }

bool Scheduler::fits(const Job& job) const {
  int timed = 0;
  for (const Running& run : running_)
    if (run.job.timed) timed += int(run.circumstances.cores.size());
  const int wanted = coresOf(job), available = int(free_.size());
  if (wanted > available) return false;
  if (job.timed) return timed == 0 || timed + wanted <= timed_cores_;
  const int kept = timed_.empty() ? 0 : std::max(0, std::max(timed_cores_, coresOf(timed_.front())) - timed);
  return available - wanted >= kept;
}

void Scheduler::begin(std::deque<Job>& queue) {
  Running run;
  run.job = std::move(queue.front());
  queue.pop_front();
  const auto count = std::size_t(coresOf(run.job));
  // timed runs from the front of the list, others from its end: runs of one kind stay on their cores
  const auto from = run.job.timed ? free_.begin() : free_.end() - std::ptrdiff_t(count);
  run.circumstances.cores.assign(from, from + std::ptrdiff_t(count));
  free_.erase(from, from + std::ptrdiff_t(count));
  run.circumstances.beside = int(running_.size());
  run.circumstances.load = loadOfMachine();
  run.job.process.cores = run.circumstances.cores;
  run.busy = busySeconds(run.circumstances.cores);
  run.start = std::chrono::steady_clock::now();
  run.process = start(run.job.process);
  running_.push_back(std::move(run));
  for (Running& other : running_)
    other.circumstances.beside = std::max(other.circumstances.beside, int(running_.size()) - 1);
}

void Scheduler::startWhatFits() {
  for (std::deque<Job>* queue : {&timed_, &others_})
    while (!queue->empty() && fits(queue->front())) begin(*queue);
}

void Scheduler::collect(const Finished& finished) {
  for (std::size_t i = 0; i < running_.size();) {
    ProcessEnd end;
    if (!hasEnded(running_[i].process, end)) {
      ++i;
      continue;
    }
    Running run = std::move(running_[i]);
    running_.erase(running_.begin() + std::ptrdiff_t(i));
    free_.insert(free_.end(), run.circumstances.cores.begin(), run.circumstances.cores.end());
    std::ranges::sort(free_);
    run.circumstances.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - run.start).count();
    run.circumstances.others_seconds = std::max(0., busySeconds(run.circumstances.cores) - run.busy - end.cpu_seconds);
    finished(run.job, end, run.circumstances);
  }
}

void Scheduler::endAll() {
  for (const Running& run : running_) kill(run.process, SIGKILL);
  for (const Running& run : running_) {
    ProcessEnd end;
    while (!hasEnded(run.process, end)) SignalGuard().wait(0.05);
  }
  running_.clear();
  free_ = all_;
}

int Scheduler::run(const Finished& finished, const Tick& tick) {
  const SignalGuard signals;
  constexpr double most_wait = 0.5;
  try {
    for (;;) {
      startWhatFits();
      if (running_.empty()) return 0;
      if (const int signal = signals.wait(most_wait)) {
        endAll();
        return signal;
      }
      collect(finished);
      tick();
    }
  } catch (...) {
    endAll();
    throw;
  }
}

}  // namespace stroma::sweep
