// SPDX-License-Identifier: LGPL-2.1-or-later
// Work on many scenes, each in a process of its own: one that crashes, hangs or fills the memory costs a sentence.
#pragma once
#include <functional>
#include <string>
#include <vector>

namespace stroma::command {

struct JobEnd {
  std::string text;    ///< what the work returned
  std::string failure; ///< a sentence where it did not: "crashed (signal 11)", "took longer than 60 s"
};

struct JobLimits {
  int at_once = 1;
  double seconds = 600;       ///< wall time of one
  double gigabytes = 8;       ///< of its memory
};

/// Calls work(i) for i in [0, count) in child processes, and done(i, end) here in the order of i. Before any thread is made.
void runJobs(int count, const JobLimits& limits, const std::function<std::string(int)>& work,
             const std::function<void(int, const JobEnd&)>& done);

}  // namespace stroma::command
