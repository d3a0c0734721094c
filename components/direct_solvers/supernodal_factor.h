// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <vector>

#include "components/direct_solvers/cholesky_factor.h"
#include "components/direct_solvers/side_solves.h"
#include "components/direct_solvers/supernodal_analysis.h"
#include "components/direct_solvers/supernodal_numbers.h"
#include "framework/algebra/memory.h"

namespace stroma {

/// A supernodal factor of a symmetric block matrix, kept over many matrices of one pattern.
class SupernodalFactor final : public CholeskyFactor {
 public:
  ~SupernodalFactor() override { release(); }
  bool analyse(const BlockMatrix& matrix, StopToken stop) override;
  /// The same with an analysis of the matrix that there is.
  void take(std::shared_ptr<SupernodalAnalysis> analysis);
  void load(const BlockMatrix& matrix) override;  ///< the upper triangle
  /// `row` is the one at which a pivot was not positive.
  SolveStop factor(Index& row, StopToken stop) override;
  void apply(ConstRows b, Rows x) override;
  void applyAll(std::span<const ConstRows> b, std::span<const Rows> x) override;
  /// In single precision, which reads half as much.
  void applyRoughly(ConstRows b, Rows x) override;
  const std::string& ordering() const override { return analysis_->ordering; }
  double flops() const override { return analysis_->flops; }
  double entries() const override { return analysis_->entries; }
  void releaseNumbers();  ///< until the next factor()
  /// Fitted to 1,331 to 15,625 nodes of hexahedra on a core of 65 Gflop/s; an application in single precision to slender bodies.
  Cost cost() const override { return Cost::of(entries(), flops(), false); }

 private:
  void release();
  std::size_t place(std::size_t k) const {
    return std::size_t(analysis_->unknown[k] / 3 * row_doubles + analysis_->unknown[k] % 3);
  }

  std::shared_ptr<SupernodalAnalysis> analysis_;
  SupernodalNumbers numbers_;
  std::vector<int> parent_;      ///< of each supernode, for many right sides
  WorkPool<SideWork<double>> side_works_;
  std::vector<double> right_, gathered_right_;
  Array<float> rough_values_;  ///< the factor in single precision; empty: none yet
  std::vector<float> rough_, gathered_;
};

}  // namespace stroma
