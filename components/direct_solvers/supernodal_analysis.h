// SPDX-License-Identifier: LGPL-2.1-or-later
// The analysis of a symmetric pattern for CHOLMOD: an order of its unknowns, and where the numbers of its factor lie.
#pragma once
#include <cholmod.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "components/direct_solvers/supernodal_plan.h"
#include "framework/algebra/block_matrix.h"
#include "framework/algebra/stop.h"

namespace stroma {

/// Keeps CHOLMOD's short loops on one thread: CHOLMOD 5 opens OpenMP regions of four threads in loops that are too short
/// for them (28 ms against 7 for 3,993 unknowns).
class NoRegions {
 public:
  NoRegions();
  ~NoRegions();
  NoRegions(const NoRegions&) = delete;

 private:
  int before_;
};

class SupernodalAnalysis {
 public:
  SupernodalAnalysis();
  ~SupernodalAnalysis();
  SupernodalAnalysis(const SupernodalAnalysis&) = delete;

  /// That of the pattern of `matrix`. Null when it was stopped: METIS alone takes seconds for a large body, and is left to
  /// end by itself. The order is that of `former`, where it has the same pattern.
  static std::shared_ptr<SupernodalAnalysis> of(const BlockMatrix& matrix, StopToken stop,
                                                const SupernodalAnalysis* former = nullptr);

  /// Whether it serves this matrix: of the same pattern, to the last entry.
  bool isOf(const BlockMatrix& matrix) const {
    return graph_ && graph_->row_start == matrix.rowStart() && graph_->columns == matrix.columns();
  }
  SupernodalPattern supernodes() const;
  /// Throws std::runtime_error that names what CHOLMOD could not do, where it could not.
  void check(bool good, const char* what) const;

  cholmod_common common;
  cholmod_sparse* lower = nullptr;   ///< the lower triangle in the order found; its values are the caller's
  cholmod_factor* factor = nullptr;  ///< without numbers
  std::vector<int> source;           ///< shape (entries of lower): where each value lies in the block matrix
  std::vector<int> unknown;          ///< shape (3 rows): the unknown at each place of the order
  std::string ordering;              ///< METIS or AMD
  std::uint64_t pattern = 0;         ///< the pattern, mixed to one number
  double flops = 0, entries = 0;     ///< of a factorisation, and in the factor

 private:
  /// The pattern of a block matrix, which may go while it is analysed.
  struct Graph {
    std::vector<Index> row_start, columns, diagonal;
    Index rows() const { return Index(diagonal.size()); }
    Index slot(Index row, Index column) const;
  };
  void run(const Graph& graph);
  cholmod_sparse* upper(const Graph& graph);
  static bool isDissectionWorth(const Graph& graph, double block_flops);
  std::vector<int> orderUnknowns(const Graph& graph);
  void buildLower(const Graph& graph);

  std::shared_ptr<const Graph> graph_;  ///< what was analysed; null until then
};

}  // namespace stroma
