// SPDX-License-Identifier: LGPL-2.1-or-later
// Several runs at once. A timed run has its cores for itself; half of the machine, or what --jobs says, is for timed runs,
// because runs share memory and caches even where they share no core. What is not timed runs on the rest, and on
// everything when nothing timed is left.
#pragma once
#include <chrono>
#include <deque>
#include <functional>
#include <vector>

#include "tools/sweep/process.h"

namespace stroma::sweep {

struct Job {
  std::size_t number = 0;  ///< the caller's
  int repetition = 0;
  int cores = 1;
  bool timed = true;
  Program process{};
};

/// Under which circumstances a job ran.
struct Circumstances {
  std::vector<int> cores;
  int beside = 0;   ///< most other runs of this sweep at the same time
  double load = 0;  ///< of the machine at the start
  double seconds = 0;
  double others_seconds = 0;  ///< of these cores, what other programs had of them
};

class Scheduler {
 public:
  using Finished = std::function<void(const Job&, const ProcessEnd&, const Circumstances&)>;
  using Tick = std::function<void()>;

  Scheduler(std::vector<int> cores, int timed_cores);
  void add(Job job) { (job.timed ? timed_ : others_).push_back(std::move(job)); }
  /// Until no job is left; `finished` may add more. Returns the signal that stopped it, with all runs ended, or 0.
  int run(const Finished& finished, const Tick& tick);

  std::size_t running() const { return running_.size(); }
  int allCores() const { return int(all_.size()); }

 private:
  struct Running {
    Job job;
    pid_t process = 0;
    Circumstances circumstances;
    std::chrono::steady_clock::time_point start;
    double busy = 0;  ///< its cores until then [s]
  };
  void startWhatFits();
  bool fits(const Job& job) const;
  void begin(std::deque<Job>& queue);
  void collect(const Finished& finished);
  void endAll();
  int coresOf(const Job& job) const;

  std::vector<int> all_, free_;
  int timed_cores_;
  std::deque<Job> timed_, others_;
  std::vector<Running> running_;
};

}  // namespace stroma::sweep
