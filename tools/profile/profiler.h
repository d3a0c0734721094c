// SPDX-License-Identifier: LGPL-2.1-or-later
// Where the time of a run goes: hears the spans of the engine, of all threads.
#pragma once
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "framework/scene/spans.h"

namespace stroma::profile {

/// One span, as long as there is room for it.
struct Event {
  std::uint32_t kind = 0;            ///< index in Profile::kinds
  std::uint64_t begin = 0, end = 0;  ///< ticks
  long count = 0, allocations = 0, bytes = 0;
};

/// All spans of one name and owner, of one thread.
struct Sum {
  long calls = 0, count = 0, allocations = 0;  ///< allocations without those of the spans within
  std::uint64_t total = 0, self = 0;           ///< ticks; self: without the spans within
};

struct Kind {
  std::string what, whose;  ///< "force", "/liver/fem"; whose is empty for what belongs to no component
};

/// What was heard, when nobody speaks any more.
struct Profile {
  struct Thread {
    std::vector<Event> events;
    std::vector<Sum> sums;  ///< shape (kinds)
  };
  std::vector<Kind> kinds;
  std::vector<Thread> threads;  ///< the first is the one that made the profiler
  double seconds_per_tick = 1e-9;
  std::uint64_t begin = 0, end = 0;  ///< ticks
  long left_out = 0;                 ///< spans that are in the sums alone
  bool has_allocations = false;

  double seconds(std::uint64_t ticks) const { return double(ticks) * seconds_per_tick; }
  double wall() const { return seconds(end - begin); }
};

/// Listens from its making to stop(). One at a time in a process.
class Profiler final : public SpanListener {
 public:
  Profiler();
  Profiler(const Profiler&) = delete;
  ~Profiler() override;
  void begin(const char* what, const Component* whose) override;
  void end(long count) override;
  /// No span may be open. The result; after it nothing is heard.
  Profile stop();

 private:
  struct ThreadLog;
  ThreadLog& log();
  std::uint32_t kindOf(ThreadLog& log, const char* what, const Component* whose);

  std::mutex access_;  ///< of the following two
  std::vector<std::unique_ptr<ThreadLog>> logs_;
  std::vector<Kind> kinds_;
  long generation_;
  std::uint64_t begin_ = 0;
  double begin_seconds_ = 0;
};

/// Whether the allocations of this process are counted: the library that counts them is loaded before all others.
bool countsAllocations();
/// Runs this program again with the same arguments and that library, and does not return. Returns where there is no such
/// library, and where it is loaded already.
void runAgainCounting(const std::vector<std::string>& words);

}  // namespace stroma::profile
