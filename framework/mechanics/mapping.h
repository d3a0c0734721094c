// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "framework/algebra/block_matrix.h"
#include "framework/mechanics/state.h"

namespace stroma {

/// The 3x3 block of a Jacobian between a row of the child and a row of the parent.
struct JacobianBlock {
  Index child = 0, parent = 0;  ///< rows of the system
  Mat3 block = Mat3::Zero();
};

/// Positions of a child state as a function of a parent state: x_c = phi(x_p), v_c = J v_p, f_p += J^T f_c. Vectors cover
/// the whole system: rows of the parent are read (or added to), rows of the child are written (or read).
class Mapping : public Component {
 public:
  std::string roleText() const override { return "mapping"; }
  virtual State& input() const = 0;  ///< the first one if there are several
  virtual std::vector<State*> inputs() const { return {&input()}; }
  virtual State& output() const = 0;
  virtual void compile() {}
  virtual void apply(Rows x) const = 0;    ///< writes x of the child from x of the parent
  virtual void applyJ(Rows v) const = 0;   ///< the same for a velocity or a displacement
  virtual void applyJT(Rows f) const = 0;  ///< adds the child's force to the parent
  /// Appends the blocks of J at the x of the last apply(), always with the same row pairs in the same order.
  virtual void addJacobian(std::vector<JacobianBlock>& out) const = 0;
  virtual bool isLinear() const = 0;
  /// Completes the acceleration of the child, J a of the parents on entry: += dJ/dt v, at the x of the last apply() and
  /// the v of parents and child. Called only if the mapping is nonlinear.
  virtual void addCurvature(ConstRows v, Rows a) const = 0;
  // ---- the geometric stiffness G = dJ^T/dx f_child, called only if the mapping is nonlinear ----
  /// df_parent += factor * G dx_parent
  virtual void addGeometricProduct(ConstRows f, ConstRows dx, double factor, Rows df) const = 0;
  virtual void addGeometricPattern(BlockPattern& pattern) const = 0;
  /// matrix += factor * G, over all rows of the system
  virtual void addGeometricStiffness(ConstRows f, double factor, BlockMatrix& matrix) const = 0;
};

}  // namespace stroma
