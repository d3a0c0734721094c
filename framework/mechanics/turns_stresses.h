// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

namespace stroma {

/// A force field, or the kernels of one, whose stiffness leaves out how the stresses of its elements turn with them, and may
/// be asked to add that.
class TurnsStresses {
 public:
  virtual ~TurnsStresses() = default;
  /// Forces from the next one on prepare it. False: it has none.
  virtual bool keepTurning(bool on) = 0;
  /// Products, diagonals and assemblies have this much of it from now on; 0: none.
  virtual void addTurning(double part) = 0;
};

}  // namespace stroma
