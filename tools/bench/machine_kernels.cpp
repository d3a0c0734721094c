// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/bench/machine_kernels.h"

namespace stroma::bench {
namespace {

#if defined(__AVX512F__)
constexpr int lanes = 8;
#elif defined(__AVX__)
constexpr int lanes = 4;
#else
constexpr int lanes = 2;
#endif
using Wide = double __attribute__((vector_size(lanes * sizeof(double))));
constexpr int chains = 16;  // enough to hide the latency of two multiply-add units (4 cycles each)

double total(const Wide (&parts)[chains]) {
  double result = 0;
  for (const Wide& part : parts)
    for (int l = 0; l < lanes; ++l) result += part[l];
  return result;
}

double sum(const double* a, std::size_t count) {
  Wide parts[chains] = {};
  constexpr int width = 8 * lanes;
  const std::size_t whole = count / width * width;
  for (std::size_t i = 0; i < whole; i += width)
    for (int c = 0; c < 8; ++c) parts[c] += *reinterpret_cast<const Wide*>(a + i + std::size_t(c * lanes));
  return total(parts);
}

void triad(double* __restrict a, const double* __restrict b, const double* __restrict c, double s, std::size_t count) {
  const Wide scale = s - Wide{};
  for (std::size_t i = 0; i < count; i += lanes)
    *reinterpret_cast<Wide*>(a + i) =
        *reinterpret_cast<const Wide*>(b + i) + scale * *reinterpret_cast<const Wide*>(c + i);
}

// The chains always stay below 2: x <- 0.5 x + 0.75 tends to 1.5, so no number becomes slow to handle.
double multiplyAdd(std::size_t rounds) {
  Wide parts[chains];
  for (int c = 0; c < chains; ++c) parts[c] = 0.01 * c - Wide{};
  const Wide factor = 0.5 - Wide{}, addend = 0.75 - Wide{};
  for (std::size_t r = 0; r < rounds; ++r)
    for (Wide& part : parts) part = part * factor + addend;
  return total(parts);
}

}  // namespace

#define STROMA_BENCH_JOIN_(a, b) a##b
#define STROMA_BENCH_JOIN(a, b) STROMA_BENCH_JOIN_(a, b)
extern const MachineKernels STROMA_BENCH_JOIN(machine_kernels_, STROMA_BENCH_LEVEL) = {sum, triad, multiplyAdd, lanes,
                                                                                       2 * chains* lanes};

}  // namespace stroma::bench
