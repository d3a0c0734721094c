// SPDX-License-Identifier: LGPL-2.1-or-later
// Work in processes of its own: what crashes, hangs or fills the memory costs a sentence.
#pragma once
#include <sys/types.h>

#include <chrono>
#include <functional>
#include <map>
#include <string>

namespace stroma {

struct ChildEnd {
  long number = 0;
  std::string text;     ///< what the work returned
  std::string failure;  ///< a sentence where it did not: "it crashes with SIGSEGV", or what was thrown
  bool is_late = false;
};

/// Those that run at present. They end with this process. Their time is that of the processor, with that of programs that they run:
/// it does not depend on what else the machine does. One that takes none of it for `patience` seconds stands still for ever.
class Children {
 public:
  explicit Children(double patience = 60) : patience_(patience) {}
  Children(const Children&) = delete;
  ~Children();
  /// Calls work() in a child, which has `seconds` of processor time and `gigabytes` of memory. Before any thread is made.
  /// Throws std::runtime_error.
  void start(long number, double seconds, const std::function<std::string()>& work, double gigabytes = 1e9);
  std::size_t running() const { return children_.size(); }
  /// Waits a while for one to end. False when none has.
  bool wait(ChildEnd& end);

 private:
  using Clock = std::chrono::steady_clock;
  struct Child {
    pid_t process = -1;
    int pipe = -1;
    double seconds = 0, used = 0;  ///< of processor time
    Clock::time_point last_work;   ///< when it was seen to have taken some
    std::string text;
    bool is_late = false, is_stuck = false;
  };
  void watch();
  ChildEnd endOf(long number, Child& child) const;

  double patience_;
  Clock::time_point last_watch_ = Clock::now();
  std::map<long, Child> children_;
};

struct JobLimits {
  int at_once = 1;
  double seconds = 600, gigabytes = 8;  ///< of one: of processor time, and of memory
};

/// Calls work(i) for i in [0, count) in children, and done(i, end) here in the order of i. Before any thread is made.
void runJobs(int count, const JobLimits& limits, const std::function<std::string(int)>& work,
             const std::function<void(int, const ChildEnd&)>& done);

}  // namespace stroma
