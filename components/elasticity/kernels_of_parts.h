// SPDX-License-Identifier: LGPL-2.1-or-later
// Cells of one mesh in two parts with kernels of their own: each part has the fastest that its shapes allow.
#pragma once
#include <memory>

#include "framework/fem/element_kernels.h"

namespace stroma {

class KernelsOfParts final : public ElementKernels {
 public:
  KernelsOfParts(std::unique_ptr<ElementKernels> a, std::unique_ptr<ElementKernels> b) : a_(std::move(a)), b_(std::move(b)) {}
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
  void addPattern(BlockPattern& pattern) const override { a_->addPattern(pattern), b_->addPattern(pattern); }
  /// How many the first part has, those, and those of the second.
  std::vector<Index> slots(const BlockMatrix& matrix) const override {
    std::vector<Index> first = a_->slots(matrix);
    const std::vector<Index> second = b_->slots(matrix);
    first.insert(first.begin(), Index(first.size()));
    first.insert(first.end(), second.begin(), second.end());
    return first;
  }
  void assemble(double factor, const std::vector<Index>& slots, std::vector<double>& values) const override {
    const auto middle = slots.begin() + 1 + slots.front();
    a_->assemble(factor, {slots.begin() + 1, middle}, values), b_->assemble(factor, {middle, slots.end()}, values);
  }
  void assembleDiagonal(double factor, std::vector<double>& blocks) const override {
    a_->assembleDiagonal(factor, blocks), b_->assembleDiagonal(factor, blocks);
  }

 private:
  std::unique_ptr<ElementKernels> a_, b_;
};

}  // namespace stroma
