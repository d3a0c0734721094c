// SPDX-License-Identifier: LGPL-2.1-or-later
// Where the time of a run goes: hears the spans of the engine, of all threads. Of short steps it hears some, so that listening
// takes less than a hundredth of their time: the first twenty, and then one at random of each so many in a row. Figures of what
// is in steps are then estimates from these. How many steps there are, and how long all of them take, is always exact.
#pragma once
#include <atomic>
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
  long steps = 0, heard = 0;         ///< of the run; those whose spans were heard
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
  /// From the beginning of a step to that of the next one.
  enum class Step : int { all_heard, chosen, passed_over };
  ThreadLog& log();
  void stepBegins(ThreadLog& first);
  void chooseSteps(const ThreadLog& first);
  void enter(Step step, ThreadLog& first);
  void addEstimates(std::vector<Sum>& sums, const std::vector<Sum>& chosen) const;
  std::uint32_t kindOf(ThreadLog& log, const char* what, const Component* whose);

  std::mutex access_;  ///< of the following two
  std::vector<std::unique_ptr<ThreadLog>> logs_;
  std::vector<Kind> kinds_;
  long generation_;
  std::uint64_t begin_ = 0;
  double begin_seconds_ = 0;

  // ---- which steps are heard; of the first thread, others read step_ alone ----
  std::atomic<Step> step_{Step::all_heard};
  const char* step_name_ = nullptr;  ///< the literal of a whole step, once it was met
  std::size_t depth_ = 0;            ///< open spans around a step
  std::uint32_t holder_ = 0;         ///< kind of the innermost of them
  long steps_ = 0, heard_ = 0;
  long every_ = 1, place_ = 0, chosen_place_ = 0;  ///< in each `every_` steps in a row
  std::uint32_t random_ = 1;
  long told_before_ = 0;                          ///< spans, before the first step
  std::vector<std::uint64_t> first_steps_;        ///< ticks that each took
  std::uint64_t entered_ = 0;                     ///< ticks: the last of the first steps, and then when step_ has changed
  long entered_allocations_ = 0;                  ///< then, of the first thread
  std::uint64_t chosen_ticks_ = 0, passed_ = 0;   ///< in steps of these two kinds
  std::uint64_t chosen_inside_ = 0;               ///< in spans right below the holder, in chosen steps
};

/// Whether the allocations of this process are counted: the library that counts them is loaded before all others.
bool countsAllocations();
/// Runs this program again as it was started, be it the command or Python with a scene, with that library, and does not
/// return. Returns where there is no such library, and where it is loaded already.
void runAgainCounting();

}  // namespace stroma::profile
