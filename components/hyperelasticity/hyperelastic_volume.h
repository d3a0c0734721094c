// SPDX-License-Identifier: LGPL-2.1-or-later
// Mean dilatation of hyperelastic hexahedra and quadratic tetrahedra. A law W = W_0(F) + k U(J) has
//   E = sum_q w_q W_0(F_q) + k V U(v/V)
// V and v the element's volume at rest and now: of J only its mean over the element, v/V = sum_q w_q J_q / sum_q w_q,
// meets the stiffness k, so that a nearly incompressible element does not lock (Nagtegaal, Parks and Rice 1974; Simo,
// Taylor and Pister 1985). W_0 keeps J at its points: with J^-2/3 I1 it is the energy of a change of shape alone, and
// its J by the mean's would leave it nothing against a dilatation that varies over the element. W_0 is the law with
// k = 0; the rest is the same for all laws with the same U.
#pragma once
#include "components/hyperelasticity/hyperelastic_law.h"

namespace stroma::hyperelastic {

struct MeanVolumeKernels {
  /// -k V dU of the hexahedra of `cells`, arranged as the elements of a law: the slots of one serve the other. k is the
  /// volume parameter of `law`. `definite`: with a tangent that has no unstable direction, without the part of the
  /// pressure, and with U'' where it is positive.
  std::unique_ptr<ElementKernels> (*hexahedra)(const Cells& cells, const HyperelasticLaw& law, bool definite) = nullptr;
  /// The same of quadratic tetrahedra.
  std::unique_ptr<ElementKernels> (*quadratic_tetrahedra)(const Cells& cells, const HyperelasticLaw& law, bool definite) = nullptr;
};
/// Empty until a module has offered them.
MeanVolumeKernels& meanVolumeKernels();

/// The sum of two methods on the same cells, arranged in the same way.
class SumOfKernels final : public ElementKernels {
 public:
  SumOfKernels(std::unique_ptr<ElementKernels> a, std::unique_ptr<ElementKernels> b)
      : a_(std::move(a)), b_(std::move(b)) {}
  void addForce(ConstRows x, Rows f) override { a_->addForce(x, f), b_->addForce(x, f); }
  void addForceAndProduct(ConstRows x, ConstRows dx, double factor, Rows f) override {
    a_->addForceAndProduct(x, dx, factor, f), b_->addForceAndProduct(x, dx, factor, f);
  }
  double energy(ConstRows x) const override { return a_->energy(x) + b_->energy(x); }
  void addProduct(ConstRows dx, double factor, Rows df) const override {
    a_->addProduct(dx, factor, df), b_->addProduct(dx, factor, df);
  }
  bool refill() override {
    const bool a = a_->refill(), b = b_->refill();
    return a && b;
  }
  void addPattern(BlockPattern& pattern) const override { a_->addPattern(pattern); }
  std::vector<Index> slots(const BlockMatrix& matrix) const override { return a_->slots(matrix); }
  void assemble(double factor, const std::vector<Index>& slots, std::vector<double>& values) const override {
    a_->assemble(factor, slots, values), b_->assemble(factor, slots, values);
  }
  void assembleDiagonal(double factor, std::vector<double>& blocks) const override {
    a_->assembleDiagonal(factor, blocks), b_->assembleDiagonal(factor, blocks);
  }

 private:
  std::unique_ptr<ElementKernels> a_, b_;
};

}  // namespace stroma::hyperelastic
