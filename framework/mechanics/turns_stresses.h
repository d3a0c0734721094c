// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

namespace stroma {

/// A force field, or the kernels of one, whose stiffness leaves out how the stresses of its elements turn with them, and may
/// be asked to add that.
class TurnsStresses {
 public:
  virtual ~TurnsStresses() = default;
  /// From the next force on it is prepared. Returns false if there is no such term.
  virtual bool keepTurning(bool on) = 0;
  /// Products, diagonals and assemblies include it with this factor from now on; 0 leaves it out.
  virtual void addTurning(double part) = 0;
};

}  // namespace stroma
