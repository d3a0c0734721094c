// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "framework/mechanics/mapping.h"

namespace stroma {

/// What mappings share whose child nodes are weighted sums of parent nodes, x_c = sum w x_p with weights that do not
/// change: J has a block w I for each weight.
class WeightedMapping : public Mapping {
 public:
  void declare(DataTable& table) override;  ///< input, output and SOFA's switches
  void init() override;                     ///< finds both states
  void compile() override;
  State& input() const override { return *parent_; }
  State& output() const override { return *child_; }
  bool isLinear() const override { return true; }
  void apply(Rows x) const override;
  void applyJ(Rows v) const override { apply(v); }
  void applyJT(Rows f) const override;
  void addJacobian(std::vector<JacobianBlock>& out) const override;
  void addGeometricProduct(ConstRows, ConstRows, double, Rows) const override {}
  void addGeometricPattern(BlockPattern&) const override {}
  void addGeometricStiffness(ConstRows, double, BlockMatrix&) const override {}

 protected:
  struct Weight {
    Index parent = 0;  ///< node of input()
    double value = 0;
  };
  /// The weights of the next node of output(). Called once for each node, in init().
  void addNode(const std::vector<Weight>& weights);

 private:
  State *parent_ = nullptr, *child_ = nullptr;
  std::vector<std::size_t> start_{0};  ///< of each child node's weights
  std::vector<Weight> weights_;
  Link<State> input_{"mechanical state"}, output_{"mechanical state"};
  bool maps_forces_ = true, maps_constraints_ = true, maps_masses_ = true, maps_matrices_ = false;
};

}  // namespace stroma
