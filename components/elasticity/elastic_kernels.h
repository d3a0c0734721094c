// SPDX-License-Identifier: LGPL-2.1-or-later
// From what a scene chooses (a variant) to the kernels that do it.
#pragma once
#include <memory>

#include "components/elasticity/elastic_variant.h"
#include "components/elasticity/rotation_methods.h"
#include "framework/fem/model_kernels.h"

namespace stroma {

/// make.operator()<Rotation>() for the rotation of a variant: chosen once, outside all loops.
template <class Make>
std::unique_ptr<ElementKernels> makeRotated(const ElasticVariant& variant, Make&& make) {
  if (variant.method == ElasticMethod::large) return make.template operator()<rotation::Qr>();
  if (variant.method == ElasticMethod::polar) return make.template operator()<rotation::Polar>();
  return make.template operator()<rotation::Svd>();
}
/// The same with make.operator()<update>(): none or strain_displacement. Whether the volume follows too is a number of the rest
/// shapes.
template <class Make>
std::unique_ptr<ElementKernels> makeUpdated(const ElasticVariant& variant, Make&& make) {
  using elastic::Update;
  if (variant.update == Update::none) return make.template operator()<Update::none>();
  return make.template operator()<Update::strain_displacement>();
}

/// A method whose products go through its own assembled matrix, refreshed with every force unless K is constant.
/// Pays where a solve takes many products of one K: 76 bytes per block instead of an element's work.
class AssembledKernels final : public ElementKernels {
 public:
  AssembledKernels(std::unique_ptr<ElementKernels> method, bool constant)
      : method_(std::move(method)), constant_(constant) {}
  void addForce(ConstRows x, Rows f) override {
    method_->addForce(x, f);
    refresh(x.count);
  }
  void addForceAndProduct(ConstRows x, ConstRows dx, double factor, Rows f) override {
    addForce(x, f);
    addProduct(dx, factor, f);
  }
  bool refill() override {
    is_stale_ = true;
    return method_->refill();
  }
  double energy(ConstRows x) const override { return method_->energy(x); }
  void addProduct(ConstRows dx, double factor, Rows df) const override { matrix_.multiplyAdd(factor, dx, df); }
  void addPattern(BlockPattern& pattern) const override { method_->addPattern(pattern); }
  std::vector<Index> slots(const BlockMatrix& matrix) const override { return method_->slots(matrix); }
  void assemble(double factor, const std::vector<Index>& slots, std::vector<double>& values) const override {
    method_->assemble(factor, slots, values);
  }
  void assembleDiagonal(double factor, std::vector<double>& blocks) const override {
    method_->assembleDiagonal(factor, blocks);
  }

 private:
  /// Lays the matrix out at the first force and fills it; later only where K can have changed.
  void refresh(Index rows) {
    const bool first = matrix_.rows() != rows;
    if (first) {
      BlockPattern pattern(rows);
      method_->addPattern(pattern);
      matrix_ = BlockMatrix(std::move(pattern));
      slots_ = method_->slots(matrix_);
    }
    if (!first && constant_ && !is_stale_) return;
    is_stale_ = false;
    matrix_.clear();
    method_->assemble(1, slots_, matrix_.values());
  }
  /// The method whose K is kept; computes forces and energies.
  std::unique_ptr<ElementKernels> method_;
  bool constant_, is_stale_ = false;  ///< stale: the constants are others
  /// K at the x of the last force, over all rows of the system.
  BlockMatrix matrix_;
  std::vector<Index> slots_;
};

/// `method` itself, or wrapped where the scene asked for assembling; K is constant only for small strains.
inline std::unique_ptr<ElementKernels> withOwnMatrix(const ElasticVariant& variant,
                                                     std::unique_ptr<ElementKernels> method) {
  if (!variant.own_matrix) return method;
  return std::make_unique<AssembledKernels>(std::move(method), variant.method == ElasticMethod::small);
}

}  // namespace stroma
