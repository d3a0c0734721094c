// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "framework/algebra/vector.h"
#include "framework/mechanics/state.h"

namespace stroma {

/// Positions of a child state as a function of a parent state: x_c = phi(x_p), v_c = J v_p, f_p += J^T f_c. Vectors are
/// the whole system's: rows of the parent are read (or added to), rows of the child written (or read).
class Mapping : public Component {
 public:
  std::string roleText() const override { return "mapping"; }
  virtual State& input() const = 0;
  virtual State& output() const = 0;
  virtual void compile() {}
  virtual void apply(Rows x) const = 0;     ///< writes x of the child from x of the parent
  virtual void applyJ(Rows v) const = 0;    ///< the same for a velocity or a displacement
  virtual void applyJT(Rows f) const = 0;   ///< adds the child's force to the parent
  /// df_parent += factor * (dJ^T/dx f_child) dx_parent; only for a mapping that is not linear.
  virtual void addGeometricProduct(ConstRows f, ConstRows dx, double factor, Rows df) const = 0;
  virtual bool isLinear() const = 0;
};

}  // namespace stroma
