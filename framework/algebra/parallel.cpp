// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/algebra/parallel.h"

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <memory>
#include <mutex>

#include "framework/scene/spans.h"

#ifdef __SANITIZE_THREAD__
#include <sanitizer/tsan_interface.h>
#endif

namespace stroma {
namespace {

// The arena fixes how many threads share a loop (also beyond the cores of the machine, so that a test on a small
// machine can show that results do not depend on it); the control lets the library make that many.
struct Pool {
  explicit Pool(int count) : control(tbb::global_control::max_allowed_parallelism, std::size_t(count)), arena(count) {}
  tbb::global_control control;
  tbb::task_arena arena;
};

std::atomic<int> thread_count{1};

/// The pool of the process. A loop holds it while it runs, so that another thread may exchange it meanwhile.
class SharedPool {
 public:
  std::shared_ptr<Pool> get() {
    const std::lock_guard lock(access_);
    return pool_;
  }
  void exchange(std::shared_ptr<Pool> pool) {
    const std::lock_guard lock(access_);
    pool_.swap(pool);
  }

 private:
  std::mutex access_;
  std::shared_ptr<Pool> pool_;  ///< null with one thread
};
SharedPool& sharedPool() {
  static SharedPool instance;
  return instance;
}

#ifdef __SANITIZE_THREAD__
// The library of the pool is not instrumented: this tells the thread sanitizer what it orders. Every piece comes after the
// start of the loop and before its end; two places, so that the pieces remain unordered among each other.
struct LoopOrder {
  void begin() { __tsan_release(&started); }
  void beginPiece() { __tsan_acquire(&started); }
  void endPiece() { __tsan_release(&ended); }
  void end() { __tsan_acquire(&ended); }
  char started = 0, ended = 0;
};
// for the function that the pool copies into its tasks and reads before beginPiece()
#define STROMA_UNSEEN __attribute__((no_sanitize_thread))
#else
#define STROMA_UNSEEN
struct LoopOrder {
  void begin() {}
  void beginPiece() {}
  void endPiece() {}
  void end() {}
};
#endif

}  // namespace

int threads() { return thread_count.load(std::memory_order_relaxed); }

void setThreads(int count) {
  count = std::max(count, 1);
  if (count == threads()) return;
  sharedPool().exchange(count > 1 ? std::make_shared<Pool>(count) : nullptr);
  thread_count = count;
}

namespace detail {

void runParallel(int count, void (*body)(void*, int), void* data) {
  const std::shared_ptr<Pool> pool = sharedPool().get();
  if (!pool) {
    for (int i = 0; i < count; ++i) body(data, i);
    return;
  }
  LoopOrder order;
  order.begin();
  pool->arena.execute([=, &order] {
    tbb::parallel_for(
        0, count,
        [=, &order](int i) STROMA_UNSEEN {
          order.beginPiece();
          const Span span("share");
          body(data, i);
          order.endPiece();
        },
        tbb::simple_partitioner());
  });
  order.end();
}

}  // namespace detail
}  // namespace stroma
