// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>

#include "framework/fem/element_kernels.h"
#include "framework/mechanics/force_field.h"

namespace stroma {

/// A force field that hands everything a step asks for to an ElementKernels. Derived classes set method_ in compile().
class ElementKernelsField : public ForceField {
 public:
  double energy(ConstRows x) const override { return method_->energy(x); }
  void addForce(ConstRows x, ConstRows, Rows f) override { method_->addForce(x, f); }
  void addForceAndProduct(ConstRows x, ConstRows, ConstRows dx, double factor, Rows f) override {
    method_->addForceAndProduct(x, dx, factor, f);
  }
  void addStiffnessProduct(ConstRows dx, double factor, Rows df) const override { method_->addProduct(dx, factor, df); }
  void addPattern(BlockPattern& pattern) const override { method_->addPattern(pattern); }
  void prepareAssembly(const BlockMatrix& matrix) override { slots_ = method_->slots(matrix); }
  void addStiffness(double factor, BlockMatrix& matrix) const override {
    method_->assemble(factor, slots_, matrix.values());
  }
  void addStiffnessDiagonal(double factor, std::vector<double>& blocks) const override {
    method_->assembleDiagonal(factor, blocks);
  }

 protected:
  /// Owned; null until compile(). Everything above depends on it.
  std::unique_ptr<ElementKernels> method_;

 private:
  /// The slots that method_->assemble() needs for the system's matrix; kept here because a method may serve several matrices.
  std::vector<Index> slots_;
};

}  // namespace stroma
