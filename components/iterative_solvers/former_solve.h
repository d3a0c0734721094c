// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>

#include "framework/algebra/linear_solver.h"
#include "framework/scene/archive.h"

namespace stroma {

/// How far a matrix has drifted from a former one A_0, as conjugate gradients with its turned factors R A_0^-1 R^T would see it:
/// found without factors. A solve of A_0 is kept, A_0 x = b. R A_0^-1 R^T b' = R x where b' = R b, so that what the factors leave
/// of this b' is r = A R x - R b: one product with the matrix as it is. In the norms of energy, with D the diagonal blocks of A
/// for A itself, that is
///
///   d = sqrt(r . D^-1 r / x . b).
///
/// R is that of WarpedFactor. Kept solves are shared and never changed.
class FormerSolve {
 public:
  /// A solve of the matrix with this number, in the order in which matrices come.
  void keep(const SystemMatrix& matrix, int number, ConstRows b, ConstRows x);
  bool isEmpty() const { return !kept_; }
  void clear() { kept_.reset(); }
  /// Matrices since.
  int age(int number) const { return number - number_; }
  /// Takes the pattern of the matrix. Below 0: not known.
  double drift(SystemMatrix& matrix) const;
  void serialize(Archive& archive);

 private:
  struct Kept {
    Vector x, b, positions;
  };
  std::shared_ptr<Kept> kept_;  ///< never changed once made
  int number_ = 0;
};

/// Iterations for a decade of the residual that factors take after such a drift, fitted to d from 0.001 to 1 in 14 bodies: the
/// residual falls by 2 d / (1 + 12 d) in each, in most of them by half to twice that. Beyond, eigenvalues are taken to lie between
/// 1 and 1 + d, and the bound of conjugate gradients for these.
double ratePerDecade(double drift);

/// What is known of drifts: the largest of one matrix on, and of `age` matrices.
struct Drifts {
  double first = -1;  ///< below 0: not known
  double last = -1;
  int age = 0;
  bool isKnown() const { return first >= 0; }
  void note(int age, double drift);
  /// After so many matrices: on a line.
  double after(int matrices) const;
  void serialize(Archive& archive);
};

}  // namespace stroma
