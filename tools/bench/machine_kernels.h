// SPDX-License-Identifier: LGPL-2.1-or-later
// The loops that find the limits of one core, once for each instruction set. Plain C types only: code compiled for wide
// registers must share no inline function with the rest of the program.
#pragma once
#include <cstddef>

namespace stroma::bench {

struct MachineKernels {
  /// Sum of `count` doubles (a multiple of 64, 64-byte aligned).
  double (*sum)(const double* a, std::size_t count);
  /// a = b + s c, `count` as above.
  void (*triad)(double* a, const double* b, const double* c, double s, std::size_t count);
  /// `rounds` times 16 independent multiply-adds on whole registers; returns something that depends on all of them.
  double (*multiplyAdd)(std::size_t rounds);
  int lanes;        ///< doubles in a register
  int round_flops;  ///< floating-point operations of one round of multiplyAdd
};

extern const MachineKernels machine_kernels_v2, machine_kernels_v3, machine_kernels_v4;

}  // namespace stroma::bench
