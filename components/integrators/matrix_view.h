// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "framework/algebra/linear_solver.h"

namespace stroma {

/// A view of another matrix, which must outlive it. Functions that are not overridden forward to it; a shifted diagonal is part of key().
class MatrixView : public SystemMatrix {
 public:
  explicit MatrixView(SystemMatrix& base) : SystemMatrix(base.identity()), base_(base) {}
  Index rows() const override { return base_.rows(); }
  void multiply(ConstRows p, Rows out) const override { base_.multiply(p, out); }
  const BlockMatrix& pattern() override { return base_.pattern(); }
  const BlockMatrix& assemble() override { return base_.assemble(); }
  void diagonalBlocks(std::vector<double>& blocks) const override { base_.diagonalBlocks(blocks); }
  MatrixKey key() const override { return base_.key(); }
  bool symmetric() const override { return base_.symmetric(); }
  bool prefersAssembled(int expected_products) const override { return base_.prefersAssembled(expected_products); }
  double productCost() const override { return base_.productCost(); }
  double assemblyCost() const override { return base_.assemblyCost(); }
  ConstRows positions() const override { return base_.positions(); }
  bool isOfLooseNodes() const override { return base_.isOfLooseNodes(); }
  bool hasTurns() const override { return base_.hasTurns(); }
  std::string describeRow(Index row) const override { return base_.describeRow(row); }

 protected:
  SystemMatrix& base_;
};

}  // namespace stroma
