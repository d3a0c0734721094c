// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <functional>
#include <memory>
#include <vector>

#include "components/condensation/supernodal_columns.h"
#include "framework/algebra/block_matrix.h"
#include "framework/algebra/memory.h"

namespace stroma {

/// A = L L^T of a sparse symmetric positive definite matrix whose last block rows are kept: what is eliminated before
/// them goes through the sparse factor, and L_SS is the dense factor of the Schur complement
///   K*_SS = K_SS - K_SI K_II^-1 K_IS = L_SS L_SS^T,  so that (A^-1)_SS = L_SS^-T L_SS^-1.
/// Implemented in the module of the condensed solvers.
class PartialCholesky {
 public:
  virtual ~PartialCholesky() = default;
  /// Orders the first `eliminated` block rows of the matrix for little fill and lays the factor out; the others keep
  /// their order. `as_they_are`: no other order is looked for. Returns the order: old block rows, shape (rows).
  virtual std::vector<Index> analyse(const BlockMatrix& matrix, Index eliminated, bool as_they_are = false) = 0;
  /// After analyse(): bytes that factor() takes at its peak, and operations.
  virtual double peakBytes() const = 0;
  virtual double flops() const = 0;
  /// Factors the analysed matrix. Returns -1, or the (old) block row where the matrix is not positive definite to
  /// round-off. `progress` receives the fraction that is done.
  virtual Index factor(const std::function<void(double)>& progress) = 0;
  /// After factor(); unknowns are numbered in the order that analyse() returned.
  virtual SupernodalColumns eliminated() const = 0;
  /// L_SS by columns, lower triangle, zero above; shape (n, n), n = 3 kept rows.
  virtual Array<double>& kept() = 0;

  /// L_SS becomes the factor of L_SS L_SS^T + diag(shift). False when that is not positive definite.
  virtual bool shift(const std::vector<double>& diagonal) = 0;
  /// Calls sink(j, count, x, height) with columns j ... j + count - 1 of (L_SS L_SS^T)^-1, rows j ... n - 1, by columns
  /// of `height` numbers; at once from several threads. The results do not depend on their number.
  using Sink = std::function<void(Index j, Index count, const double* x, Index height)>;
  /// `progress` receives the fraction that is done.
  virtual void invert(const Sink& sink, const std::function<void(double)>& progress) = 0;
};

/// Defined in the module of the condensed solvers, because of what it links.
std::unique_ptr<PartialCholesky> makePartialCholesky();

}  // namespace stroma
