// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

namespace stroma {

/// Kernels whose stiffness may have what the turning of stresses adds; see TurnsStresses.
class TurningKernels {
 public:
  virtual ~TurningKernels() = default;
  virtual bool keepTurning(bool on) = 0;
  virtual void addTurning(double part) = 0;
};

}  // namespace stroma
