// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <Eigen/Dense>
#include <cstdint>

#include "framework/scene/types.h"

namespace stroma {

/// The columns of a Cholesky factor L of the unknowns that are eliminated first, by supernodes: groups of neighbouring
/// columns that share the rows below them. Unknowns are numbered in the order of their elimination; those that are kept
/// come last. With I the eliminated and S the kept ones,
///   forward:  y_I = L_II^-1 f_I,  f*_S = f_S - L_SI y_I  (= f_S - K_SI K_II^-1 f_I)
///   backward: u_I = L_II^-T (y_I - L_SI^T u_S)           (= K_II^-1 (f_I - K_IS u_S))
/// A view: it owns nothing, so that a factor can be a mapped file.
struct SupernodalColumns {
  Index supernodes = 0;
  const std::int32_t* first = nullptr;      ///< first column of each, shape (supernodes + 1)
  const std::int64_t* row_start = nullptr;  ///< where its rows start, shape (supernodes + 1)
  const std::int64_t* start = nullptr;      ///< where its values start, shape (supernodes + 1)
  const std::int32_t* rows = nullptr;       ///< those below its own columns
  const double* values = nullptr;           ///< by columns, own rows first

  /// In place on a vector of all unknowns; `work` has room for the longest list of rows below.
  void forward(double* y, double* work) const {
    for (Index s = 0; s < supernodes; ++s) {
      Own own(y + first[s], width(s));
      diagonal(s).triangularView<Eigen::Lower>().solveInPlace(own);
      const Index count = below(s);
      if (count == 0) continue;
      Own sums(work, count);
      sums.noalias() = lower(s) * own;
      const std::int32_t* to = rows + row_start[s];
      for (Index i = 0; i < count; ++i) y[to[i]] -= work[i];
    }
  }
  void backward(double* y, double* work) const {
    for (Index s = supernodes - 1; s >= 0; --s) {
      Own own(y + first[s], width(s));
      if (const Index count = below(s); count > 0) {
        const std::int32_t* from = rows + row_start[s];
        for (Index i = 0; i < count; ++i) work[i] = y[from[i]];
        own.noalias() -= lower(s).transpose() * Own(work, count);
      }
      diagonal(s).transpose().triangularView<Eigen::Upper>().solveInPlace(own);
    }
  }
  Index longest() const {
    Index most = 1;
    for (Index s = 0; s < supernodes; ++s) most = std::max(most, below(s));
    return most;
  }
  std::size_t entries() const { return supernodes > 0 ? std::size_t(start[supernodes]) : 0; }

 private:
  using Own = Eigen::Map<Eigen::VectorXd>;
  using Block = Eigen::Map<const Eigen::MatrixXd, 0, Eigen::OuterStride<>>;
  Index width(Index s) const { return first[s + 1] - first[s]; }
  Index below(Index s) const { return Index(row_start[s + 1] - row_start[s]); }
  Block diagonal(Index s) const {
    return {values + start[s], width(s), width(s), Eigen::OuterStride<>(width(s) + below(s))};
  }
  Block lower(Index s) const {
    return {values + start[s] + width(s), below(s), width(s), Eigen::OuterStride<>(width(s) + below(s))};
  }
};

}  // namespace stroma
