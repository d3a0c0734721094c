// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/profile/profiler.h"

#include <dlfcn.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#if defined(__x86_64__)
#include <cpuid.h>
#include <x86intrin.h>
#endif

#include "framework/scene/component.h"
#include "framework/scene/services.h"

namespace stroma::profile {
namespace {

constexpr std::size_t most_events = 400'000;  ///< of a thread; about 50 MB of text
constexpr long all_heard_steps = 20;              ///< at least
constexpr double span_seconds = 750e-9;           ///< that hearing and writing a span takes
constexpr double most_share = 0.01;               ///< of the time of steps that this may be
constexpr const char* preload = "LD_PRELOAD";
constexpr const char* mark = "STROMA_COUNTS_ALLOCATIONS";  ///< what was preloaded before, with a letter in front

double steadySeconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Reading the clock of the system takes longer than many spans: the counter of the processor, where it runs evenly.
bool hasEvenCounter() {
#if defined(__x86_64__)
  unsigned a = 0, b = 0, c = 0, d = 0;
  return __get_cpuid(0x80000007, &a, &b, &c, &d) && (d & (1u << 8)) != 0;
#else
  return false;
#endif
}
bool even_counter = false;  ///< asked by the first profiler: the question takes a microsecond in a virtual machine

std::uint64_t ticks() {
#if defined(__x86_64__)
  if (even_counter) return __rdtsc();
#endif
  return std::uint64_t(std::chrono::steady_clock::now().time_since_epoch().count());
}

/// What a thread has taken from the heap.
struct Taken {
  long count = 0, bytes = 0;
};
Taken operator-(const Taken& a, const Taken& b) { return {a.count - b.count, a.bytes - b.bytes}; }

using CountOfThread = const volatile Taken* (*)();
/// Null where nobody counts.
CountOfThread countOfThread() {
  static const auto found = reinterpret_cast<CountOfThread>(dlsym(RTLD_DEFAULT, "stroma_allocations_of_thread"));
  return found;
}

std::atomic<long> generations{0};
thread_local long passed_over_spans = 0;  ///< open ones of this thread: what most spans of short steps meet, so it is quick

}  // namespace

struct Profiler::ThreadLog {
  struct Open {
    std::uint32_t kind;
    std::uint64_t begin, inside;  ///< ticks; of the spans within
    Taken taken;
    long inner = 0;  ///< allocations of the spans within
  };
  struct Slot {
    const char* what = nullptr;
    const Component* whose = nullptr;
    std::uint32_t kind = 0;
  };
  std::vector<Open> open;
  std::vector<Event> events;
  std::vector<Sum> sums, chosen_sums;  ///< of steps that were chosen, the second
  std::vector<Slot> slots{1024};  ///< open addressing, at most half full
  std::size_t used = 0;
  long left_out = 0;
  bool is_first = false;
  std::uint64_t last = 0;  ///< ticks
  const volatile Taken* counted = nullptr;  ///< null: nobody counts
  Taken ours;                               ///< of it, what listening takes: nobody's spans have that

  long told() const { return long(events.size()) + left_out; }
  Taken all() const { return counted ? Taken{counted->count, counted->bytes} : Taken{}; }
  Taken taken() const { return all() - ours; }
  /// Where the counters of two processors differ, a thread that changes between them does not go back in time.
  std::uint64_t notBeforeLast(std::uint64_t now) { return last = std::max(last, now); }
  /// What was taken since then is ours.
  void hideSince(const Taken& before) {
    const Taken more = all() - before;
    ours.count += more.count, ours.bytes += more.bytes;
  }
};

Profiler::Profiler() : generation_(++generations) {
  if (span_listener) throw std::logic_error("there is a profiler already");
  even_counter = hasEvenCounter();
  first_steps_.reserve(all_heard_steps);
  begin_ = ticks(), begin_seconds_ = steadySeconds();
  log().is_first = true;  // this thread
  span_listener = this;
}

Profiler::~Profiler() {
  if (span_listener == this) span_listener = nullptr;
}

Profiler::ThreadLog& Profiler::log() {
  thread_local long known_generation = 0;
  thread_local ThreadLog* known = nullptr;
  if (known_generation != generation_) [[unlikely]] {
    const std::lock_guard lock(access_);
    known = logs_.emplace_back(std::make_unique<ThreadLog>()).get();
    known->open.reserve(64);
    known->counted = countOfThread() ? countOfThread()() : nullptr;
    known->ours = known->all();
    known->last = begin_;
    known_generation = generation_;
  }
  return *known;
}

std::uint32_t Profiler::kindOf(ThreadLog& log, const char* what, const Component* whose) {
  const auto hash = [&](std::size_t size) {
    const auto mixed =
        (reinterpret_cast<std::uintptr_t>(what) * 31 + reinterpret_cast<std::uintptr_t>(whose)) * 0x9E3779B97F4A7C15ull;
    return std::size_t(mixed >> 32) & (size - 1);
  };
  std::size_t at = hash(log.slots.size());
  for (; log.slots[at].what; at = (at + 1) & (log.slots.size() - 1))
    if (log.slots[at].what == what && log.slots[at].whose == whose) return log.slots[at].kind;
  const std::lock_guard lock(access_);
  Kind kind{what, whose ? whose->path() : std::string()};
  std::uint32_t number = 0;
  // equal literals of two libraries are two addresses, and other threads have met it
  while (number < kinds_.size() && !(kinds_[number].what == kind.what && kinds_[number].whose == kind.whose)) ++number;
  if (number == kinds_.size()) kinds_.push_back(std::move(kind));
  if (log.sums.size() <= number) {
    log.sums.resize(number + 1);
    log.chosen_sums.resize(number + 1);
  }
  if (2 * ++log.used > log.slots.size()) {
    std::vector<ThreadLog::Slot> old(4 * log.slots.size());
    old.swap(log.slots);
    for (const ThreadLog::Slot& slot : old) {
      if (!slot.what) continue;
      const auto mixed =
          (reinterpret_cast<std::uintptr_t>(slot.what) * 31 + reinterpret_cast<std::uintptr_t>(slot.whose)) *
          0x9E3779B97F4A7C15ull;
      std::size_t to = std::size_t(mixed >> 32) & (log.slots.size() - 1);
      while (log.slots[to].what) to = (to + 1) & (log.slots.size() - 1);
      log.slots[to] = slot;
    }
    at = hash(log.slots.size());
    while (log.slots[at].what) at = (at + 1) & (log.slots.size() - 1);
  }
  log.slots[at] = {what, whose, number};
  return number;
}

// ---- which steps are heard ----

void Profiler::enter(Step step, ThreadLog& first) {
  const std::uint64_t now = first.notBeforeLast(ticks());
  const Step before = step_.load(std::memory_order_relaxed);
  if (before == Step::chosen) chosen_ticks_ += now - entered_;
  const long allocations = first.taken().count;
  if (before == Step::passed_over) {
    passed_ += now - entered_;
    first.open.back().inside += now - entered_, first.open.back().inner += allocations - entered_allocations_;
  }
  entered_ = now, entered_allocations_ = allocations;
  step_.store(step, std::memory_order_release);
}

/// By what the first steps took.
void Profiler::chooseSteps(const ThreadLog& first) {
  const double seconds_per_tick = (steadySeconds() - begin_seconds_) / double(std::max<std::uint64_t>(1, ticks() - begin_));
  // the usual step: one that had to wait for a processor is none
  std::nth_element(first_steps_.begin(), first_steps_.begin() + std::ptrdiff_t(first_steps_.size() / 2), first_steps_.end());
  const double took = double(first_steps_[first_steps_.size() / 2]) * seconds_per_tick * double(first_steps_.size());
  const double heard = double(first.told() - told_before_) * span_seconds;
  while (heard > most_share * took * double(every_) && every_ < 1024) every_ *= 2;
}

void Profiler::stepBegins(ThreadLog& first) {
  if (steps_ == 0) told_before_ = first.told();
  if (steps_ > 0 && steps_ <= all_heard_steps) first_steps_.push_back(first.last - entered_);
  if (steps_ <= all_heard_steps) entered_ = first.last;
  depth_ = first.open.size(), holder_ = first.open.empty() ? 0 : first.open.back().kind;
  if (steps_++ == all_heard_steps) chooseSteps(first);
  if (every_ == 1 || depth_ == 0) {
    ++heard_;
    return;
  }
  if (place_ == every_) {
    random_ = random_ * 1664525u + 1013904223u;
    place_ = 0, chosen_place_ = long(random_ >> 8) % every_;
  }
  const Step next = place_++ == chosen_place_ ? Step::chosen : Step::passed_over;
  heard_ += next == Step::chosen;
  if (next != Step::passed_over || step_.load(std::memory_order_relaxed) != Step::passed_over) enter(next, first);
}

void Profiler::begin(const char* what, const Component* whose) {
  if (step_.load(std::memory_order_acquire) == Step::passed_over && what != step_name_) {
    ++passed_over_spans;
    return;
  }
  ThreadLog& here = log();
  if (here.is_first && passed_over_spans == 0) {
    if (!step_name_ && std::strcmp(what, "whole step") == 0) step_name_ = what;
    if (what == step_name_) stepBegins(here);
  }
  if (step_.load(std::memory_order_relaxed) == Step::passed_over) {
    ++passed_over_spans;
    return;
  }
  const Taken before = here.all();
  const std::uint32_t kind = kindOf(here, what, whose);
  if (here.open.size() == here.open.capacity()) here.open.reserve(2 * here.open.size());
  here.hideSince(before);
  here.open.push_back({kind, here.notBeforeLast(ticks()), 0, here.taken(), 0});
}

void Profiler::end(long iterations) {
  if (passed_over_spans > 0) {
    --passed_over_spans;
    return;
  }
  const std::uint64_t read = ticks();
  ThreadLog& here = log();
  if (here.open.empty()) return;  // it began before we listened
  const bool is_sampling = step_.load(std::memory_order_relaxed) != Step::all_heard;
  if (is_sampling && here.is_first && here.open.size() <= depth_) enter(Step::all_heard, here);  // no more steps
  const ThreadLog::Open span = here.open.back();
  here.open.pop_back();
  const std::uint64_t now = here.notBeforeLast(read);
  const Taken before = here.all(), taken = here.taken() - span.taken;
  const std::uint64_t took = now - span.begin;
  const bool is_chosen = step_.load(std::memory_order_relaxed) == Step::chosen;
  if (is_chosen && here.is_first && here.open.size() == depth_) chosen_inside_ += took;
  Sum& sum = (is_chosen ? here.chosen_sums : here.sums)[span.kind];
  ++sum.calls;
  sum.count += iterations;
  sum.allocations += taken.count - span.inner;
  sum.total += took, sum.self += took - span.inside;
  if (!here.open.empty()) {
    here.open.back().inside += took;
    here.open.back().inner += taken.count;
  }
  // where there is no room for all, those that hold others go on being told
  if (here.events.size() < most_events || (here.open.size() < 3 && here.events.size() < 2 * most_events))
    here.events.push_back({span.kind, span.begin, now, iterations, taken.count, taken.bytes});
  else
    ++here.left_out;
  here.hideSince(before);
}

/// Times by the time of the steps that were passed over, numbers by how many they were.
void Profiler::addEstimates(std::vector<Sum>& sums, const std::vector<Sum>& chosen) const {
  const auto chosen_steps = double(std::max(1L, heard_ - std::min(heard_, all_heard_steps)));
  const double by_number = (chosen_steps + double(steps_ - heard_)) / chosen_steps;
  const double by_time = 1 + double(passed_) / double(std::max<std::uint64_t>(1, chosen_ticks_));
  const auto number = [&](long count) { return std::lround(by_number * double(count)); };
  const auto time = [&](std::uint64_t ticks) { return std::uint64_t(by_time * double(ticks)); };
  for (std::size_t k = 0; k < chosen.size(); ++k) {
    const Sum& more = chosen[k];
    sums[k].calls += number(more.calls);
    sums[k].count += number(more.count);
    sums[k].allocations += number(more.allocations);
    sums[k].total += time(more.total), sums[k].self += time(more.self);
  }
  if (passed_ > 0 && !sums.empty() && &sums == &logs_.front()->sums) {
    // the holder of steps has what lies between them
    const std::uint64_t own = chosen_ticks_ - std::min(chosen_ticks_, chosen_inside_);
    sums[holder_].self += time(own) - own;
  }
}

Profile Profiler::stop() {
  span_listener = nullptr;
  Profile profile;
  const std::lock_guard lock(access_);
  profile.begin = begin_, profile.end = std::max(begin_ + 1, ticks());
  for (const auto& log : logs_) profile.end = std::max(profile.end, log->last);
  profile.seconds_per_tick = (steadySeconds() - begin_seconds_) / double(profile.end - profile.begin);
  profile.has_allocations = countsAllocations();
  profile.kinds = kinds_;
  profile.steps = steps_, profile.heard = heard_;
  for (const auto& log : logs_) {
    log->sums.resize(kinds_.size()), log->chosen_sums.resize(kinds_.size());
    if (heard_ < steps_) addEstimates(log->sums, log->chosen_sums);
    profile.left_out += log->left_out;
    profile.threads.push_back({std::move(log->events), std::move(log->sums)});
  }
  return profile;
}

bool countsAllocations() { return countOfThread() != nullptr; }

namespace {

std::vector<std::string> wordsOfThisProcess() {
  std::ifstream file("/proc/self/cmdline", std::ios::binary);
  std::vector<std::string> words;
  for (std::string word; std::getline(file, word, '\0');) words.push_back(word);
  return words;
}

}  // namespace

void runAgainCounting() {
  if (const char* before = std::getenv(mark)) {  // we are the second one: what we start is as it would be
    *(before + 1) ? setenv(preload, before + 1, 1) : unsetenv(preload);
    unsetenv(mark);
    return;
  }
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  return;  // a sanitizer has its own malloc
#endif
  const std::filesystem::path library =
      std::filesystem::path(moduleFolder()).parent_path() / "libstroma_allocations.so";
  if (!std::filesystem::exists(library)) return;
  const char* before = std::getenv(preload);
  const std::string others = before ? before : "";
  setenv(mark, ("=" + others).c_str(), 1);
  setenv(preload, (library.string() + (others.empty() ? "" : ":" + others)).c_str(), 1);
  std::vector<std::string> words = wordsOfThisProcess();
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  std::fflush(nullptr);
  execv("/proc/self/exe", arguments.data());
  others.empty() ? unsetenv(preload) : setenv(preload, others.c_str(), 1);
  unsetenv(mark);
}

}  // namespace stroma::profile
