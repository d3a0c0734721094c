// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/profile/profiler.h"

#include <dlfcn.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <filesystem>
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
  std::vector<Sum> sums;
  std::vector<Slot> slots{1024};  ///< open addressing, at most half full
  std::size_t used = 0;
  long left_out = 0;
  std::uint64_t last = 0;  ///< ticks
  const volatile Taken* counted = nullptr;  ///< null: nobody counts
  Taken ours;                               ///< of it, what listening takes: nobody's spans have that

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
  begin_ = ticks(), begin_seconds_ = steadySeconds();
  log();  // the first thread is this one
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
  if (log.sums.size() <= number) log.sums.resize(number + 1);
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

void Profiler::begin(const char* what, const Component* whose) {
  ThreadLog& here = log();
  const Taken before = here.all();
  const std::uint32_t kind = kindOf(here, what, whose);
  if (here.open.size() == here.open.capacity()) here.open.reserve(2 * here.open.size());
  here.hideSince(before);
  here.open.push_back({kind, here.notBeforeLast(ticks()), 0, here.taken(), 0});
}

void Profiler::end(long iterations) {
  const std::uint64_t read = ticks();
  ThreadLog& here = log();
  if (here.open.empty()) return;  // it began before we listened
  const ThreadLog::Open span = here.open.back();
  here.open.pop_back();
  const std::uint64_t now = here.notBeforeLast(read);
  const Taken before = here.all(), taken = here.taken() - span.taken;
  const std::uint64_t took = now - span.begin;
  Sum& sum = here.sums[span.kind];
  ++sum.calls, sum.count += iterations, sum.allocations += taken.count - span.inner;
  sum.total += took, sum.self += took - span.inside;
  if (!here.open.empty()) here.open.back().inside += took, here.open.back().inner += taken.count;
  // where there is no room for all, those that hold others go on being told
  if (here.events.size() < most_events || (here.open.size() < 3 && here.events.size() < 2 * most_events))
    here.events.push_back({span.kind, span.begin, now, iterations, taken.count, taken.bytes});
  else
    ++here.left_out;
  here.hideSince(before);
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
  for (const auto& log : logs_) {
    log->sums.resize(kinds_.size());
    profile.left_out += log->left_out;
    profile.threads.push_back({std::move(log->events), std::move(log->sums)});
  }
  return profile;
}

bool countsAllocations() { return countOfThread() != nullptr; }

void runAgainCounting(const std::vector<std::string>& words) {
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
  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  execv("/proc/self/exe", arguments.data());
  others.empty() ? unsetenv(preload) : setenv(preload, others.c_str(), 1);
  unsetenv(mark);
}

}  // namespace stroma::profile
