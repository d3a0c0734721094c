// SPDX-License-Identifier: LGPL-2.1-or-later
// PartialCholesky by CHOLMOD's orders and supernodes: elimination_order.cpp finds the order and lays the factor out,
// partial_cholesky.cpp computes its numbers.
#pragma once
#include <cholmod.h>
#include <omp.h>

#include "components/condensation/partial_cholesky.h"

// of OpenBLAS; absent from other libraries
extern "C" __attribute__((weak)) void openblas_set_num_threads(int);
extern "C" __attribute__((weak)) int openblas_get_num_threads();

namespace stroma {

/// CHOLMOD 5 opens OpenMP regions in loops that are too short for them.
class NoRegions {
 public:
  NoRegions() : before_(omp_get_max_active_levels()) {
    omp_set_max_active_levels(0);
    // on two threads OpenBLAS sums in another order, and no result may depend on their number
    if (openblas_set_num_threads && openblas_get_num_threads() != 1) openblas_set_num_threads(1);
  }
  ~NoRegions() { omp_set_max_active_levels(before_); }

 private:
  int before_;
};

class CholmodPartialCholesky final : public PartialCholesky {
 public:
  CholmodPartialCholesky();
  ~CholmodPartialCholesky() override;
  std::vector<Index> analyse(const BlockMatrix& matrix, Index eliminated, bool as_they_are) override;
  double peakBytes() const override;
  double flops() const override { return flops_; }
  Index factor(const std::function<void(double)>& progress) override;
  SupernodalColumns eliminated() const override;
  Array<double>& kept() override { return kept_; }
  bool shift(const std::vector<double>& diagonal) override;
  void invert(const Sink& sink, const std::function<void(double)>& progress) override;

 private:
  void check(bool good, const char* what) const;
  cholmod_sparse* graph(const BlockMatrix& matrix, Index nodes);
  void tryOrder(cholmod_sparse* graph, std::vector<int> order, Index eliminated);
  void buildLower(const BlockMatrix& matrix);
  void layOut(const cholmod_factor& symbolic);
  Index eliminate(const std::function<void(double)>& progress);
  void takeColumns(Index first, Index count, double* block, Index height, const std::vector<Index>& place) const;
  void updateBy(Index s, Index done, Index columns, double* block, Index height, Index origin,
                const std::vector<Index>& place);
  void updateKept(Index s);
  Index factorKept(const std::function<void(double)>& progress);
  Index lostPivot() const;
  Index width(Index s) const { return first_[s + 1] - first_[s]; }
  double operationsOf(Index s) const;
  Index below(Index s) const { return Index(row_start_[s + 1] - row_start_[s]); }
  Index keptUnknowns() const { return Index(3 * (order_.size() - std::size_t(eliminated_))); }

  cholmod_common common_;
  cholmod_sparse* lower_ = nullptr;
  std::vector<Index> order_;
  std::vector<double> diagonal_;  ///< of the matrix, in the new order
  Index eliminated_ = 0;
  double flops_ = 0;
  std::vector<std::int32_t> first_, rows_;
  std::vector<std::int64_t> row_start_, start_;
  Array<double> values_, kept_;
  std::vector<Index> kept_place_;  ///< row in kept_ of an unknown
  Array<double> update_;           ///< what one supernode takes from some columns of another
};

}  // namespace stroma
