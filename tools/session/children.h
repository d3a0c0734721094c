// SPDX-License-Identifier: LGPL-2.1-or-later
// Runs work in child processes, so that a crash, a hang or excessive memory becomes an ordinary error.
#pragma once
#include <sys/types.h>

#include <chrono>
#include <functional>
#include <map>
#include <string>

namespace stroma {

struct ChildEnd {
  long number = 0;
  std::string text;     ///< the result of the work
  std::string failure;  ///< the reason for a failure: "it crashes with SIGSEGV", or the message of an exception
  bool is_late = false;
};

/// The running children. They end with this process. Limits apply to processor time, including that of programs they start, so
/// they do not depend on the load of the machine. A child that uses none for `patience` seconds is considered hung.
class Children {
 public:
  explicit Children(double patience = 60) : patience_(patience) {}
  Children(const Children&) = delete;
  ~Children();
  /// Calls work() in a child limited to `seconds` of processor time and `gigabytes` of memory. Call it before creating threads.
  /// Throws std::runtime_error.
  void start(long number, double seconds, const std::function<std::string()>& work, double gigabytes = 1e9);
  std::size_t running() const { return children_.size(); }
  /// Waits briefly for a child to end. Returns false if none has.
  bool wait(ChildEnd& end);

 private:
  using Clock = std::chrono::steady_clock;
  struct Child {
    pid_t process = -1;
    int pipe = -1;
    double seconds = 0, used = 0;  ///< processor time
    Clock::time_point last_work;   ///< when its processor time last increased
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
  double seconds = 600, gigabytes = 8;  ///< limits of processor time and memory per child
};

/// Calls work(i) for i in [0, count) in children, and done(i, end) here in the order of i. Call it before creating threads.
void runJobs(int count, const JobLimits& limits, const std::function<std::string(int)>& work,
             const std::function<void(int, const ChildEnd&)>& done);

}  // namespace stroma
