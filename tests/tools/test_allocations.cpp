// SPDX-License-Identifier: LGPL-2.1-or-later
// After the first step, a step takes no memory from the heap. Counts every operator new, aligned_alloc and malloc of
// the process while the steps run. One exception that is not ours: a factorisation by CHOLMOD takes its work space (two
// blocks) and gives it back.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>

#include "framework/simulation/simulation.h"

namespace {

std::atomic<bool> counting{false};
std::atomic<long> allocations{0};

void note() {
  if (counting.load(std::memory_order_relaxed)) ++allocations;
}

}  // namespace

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool can_count = false;  // a sanitizer has its own malloc
#else
constexpr bool can_count = true;

// operator new calls malloc, so counting in these two sees everything
extern "C" void* __libc_malloc(std::size_t);
extern "C" void* __libc_memalign(std::size_t, std::size_t);
extern "C" void* malloc(std::size_t size) {
  note();
  return __libc_malloc(size);
}
extern "C" void* aligned_alloc(std::size_t alignment, std::size_t size) {
  note();
  return __libc_memalign(alignment, size);
}
#endif

namespace stroma {
namespace {

TEST(Allocations, TheCounterCounts) {
  if (!can_count) GTEST_SKIP() << "a sanitizer has its own malloc";
  allocations = 0;
  counting = true;
  ::operator delete(::operator new(8));
  const Vector vector(10);
  counting = false;
  EXPECT_EQ(allocations, 2);
}

class AllocationsOfScene : public testing::TestWithParam<const char*> {};

TEST_P(AllocationsOfScene, NoneAfterTheFirstStep) {
  if (!can_count) GTEST_SKIP() << "a sanitizer has its own malloc";
  Factory factory;
  Modules modules(factory);
  const std::string file = std::string(STROMA_SOURCE_DIR "/scenes/examples/") + GetParam();
  Simulation simulation(loadScene(file, {}, factory, modules));
  simulation.dropObservers();
  ASSERT_FALSE(simulation.step().diverged);
  allocations = 0;
  long factorisations = 0;
  bool diverged = false;
  counting = true;
  for (int i = 0; i < 5; ++i) {
    const StepReport report = simulation.step();
    factorisations += report.factorisations;
    diverged = diverged || report.diverged;
  }
  counting = false;
  EXPECT_FALSE(diverged);
  EXPECT_LE(allocations, 2 * factorisations);
}

INSTANTIATE_TEST_SUITE_P(Examples, AllocationsOfScene,
                         testing::Values("organ.xml", "cantilever.xml", "explicit.xml", "ten_tetrahedra.xml",
                                         "mesh_matrix_mass.xml", "partial_fixed.xml", "breathing.xml",
                                         "organ_condensed.xml"));

}  // namespace
}  // namespace stroma
