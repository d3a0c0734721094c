// SPDX-License-Identifier: LGPL-2.1-or-later
// The processor stops after each instruction of the stepping thread (its trap flag), whatever instruction set it has.
#include "tests/budgets/instruction_counter.h"

#include <dlfcn.h>
#include <signal.h>
#include <ucontext.h>
#include <x86intrin.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <thread>

#include "framework/scene/spans.h"

namespace {

constexpr int counted_step = 3;  ///< memory that is kept is taken by then, and functions of libraries are looked up
constexpr int bits = 18;
constexpr std::uint64_t trap_flag = 0x100;

struct Place {
  std::uint64_t address, count;
};
Place table[1u << bits];  ///< open addressing; a step has a tenth as many places

void countOne(int, siginfo_t*, void* context) {
  const auto address = std::uint64_t(static_cast<const ucontext_t*>(context)->uc_mcontext.gregs[REG_RIP]);
  std::size_t at = (address * 0x9E3779B97F4A7C15ull) >> (64 - bits);
  while (table[at].count && table[at].address != address) at = (at + 1) % (1u << bits);
  table[at].address = address;
  ++table[at].count;
}

class InstructionCounter final : public stroma::SpanListener {
 public:
  explicit InstructionCounter(const char* path) : path_(path) {
    struct sigaction action {};
    action.sa_sigaction = countOne;
    action.sa_flags = SA_SIGINFO;
    sigaction(SIGTRAP, &action, nullptr);
  }
  void begin(const char* what, const stroma::Component*) override {
    if (std::this_thread::get_id() != thread_) return;
    if (depth_ > 0) {
      ++depth_;
    } else if (std::strcmp(what, "whole step") == 0 && ++steps_ == counted_step) {
      depth_ = 1;
      __writeeflags(__readeflags() | trap_flag);
    }
  }
  void end(long) override {
    if (std::this_thread::get_id() != thread_ || depth_ == 0 || --depth_ > 0) return;
    __writeeflags(__readeflags() & ~trap_flag);
    write();
  }

 private:
  void write() const {
    std::FILE* file = std::fopen(path_, "w");
    if (!file) return;
    for (const Place& place : table) {
      if (place.count == 0) continue;
      Dl_info library{};
      if (!dladdr(reinterpret_cast<const void*>(place.address), &library)) library.dli_fname = "nowhere";
      std::fprintf(file, "%llu %llu %s\n", static_cast<unsigned long long>(place.count),
                   static_cast<unsigned long long>(place.address - reinterpret_cast<std::uint64_t>(library.dli_fbase)),
                   library.dli_fname);
    }
    std::fclose(file);
  }

  const char* path_;
  const std::thread::id thread_ = std::this_thread::get_id();
  int steps_ = 0, depth_ = 0;  ///< depth: of the spans that are open in the counted step
};

}  // namespace

void countInstructionsOfAStep() {
  const char* path = std::getenv("STROMA_COUNT");
  if (!path || stroma::span_listener) return;
  static InstructionCounter counter(path);
  stroma::span_listener = &counter;
}
