// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "components/mappings/linked_mapping.h"

namespace stroma {

/// What mappings share whose child rows are weighted sums of parent rows, x_c = sum w x_p with weights that do not
/// change: J has a block w I for each weight. An orientation can have one parent only, of weight 1.
class WeightedMapping : public LinkedMapping {
 public:
  void init() override;
  bool isLinear() const override { return true; }
  void apply(Rows x) const override;
  void applyJ(Rows v) const override { apply(v); }
  void applyJT(Rows f) const override;
  void addJacobian(std::vector<JacobianBlock>& out) const override;
  void addCurvature(ConstRows, Rows) const override {}
  void addGeometricProduct(ConstRows, ConstRows, double, Rows) const override {}
  void addGeometricPattern(BlockPattern&) const override {}
  void addGeometricStiffness(ConstRows, double, BlockMatrix&) const override {}

 protected:
  struct Weight {
    Index parent = 0;  ///< row of input(), or of the state below
    double value = 0;
    int state = 0;  ///< of inputs()
  };
  /// The weights of the next row of output(). Called once for each row, in init().
  void addNode(const std::vector<Weight>& weights);
  /// The next rows of output() are those of a node, given by the first of its rows. Throws ComponentError where the two
  /// are not alike.
  void addCopy(Index first_row, int state = 0);

 private:
  Index row(const Weight& weight) const { return inputs_[std::size_t(weight.state)]->firstRow() + weight.parent; }
  std::vector<State*> inputs_;
  std::vector<std::size_t> start_{0};  ///< of each child node's weights
  std::vector<Weight> weights_;
};

}  // namespace stroma
