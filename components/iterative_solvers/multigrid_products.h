// SPDX-License-Identifier: LGPL-2.1-or-later
// The finest level of a multigrid hierarchy by products of the force fields, where these cost less than reading the blocks of
// the matrix. It is of the matrix as it is now, while the levels below may be those of a former one. Inline for the reason given
// in vector.h.
#pragma once
#include <array>
#include <cmath>
#include <limits>

#include "components/iterative_solvers/conjugate_gradients.h"
#include "components/iterative_solvers/multigrid_hierarchy.h"

namespace stroma::amg {

/// Chebyshev's polynomial in D^-1 A, D the diagonal blocks of A, and what goes to the next level and comes back, in double
/// precision.
class ProductLevel {
 public:
  /// One more than by blocks, as a step costs less beside the rest of a V-cycle.
  static constexpr int steps = 3;

  /// Whether its products cost so much less. 1 ns by the estimates of force fields is 2 in a step, and a block takes 1.5 ns in
  /// cache and 4 to 5 outside.
  static bool isWorth(const SystemMatrix& matrix, const Hierarchy& hierarchy) {
    constexpr double most = 1;  // ns, for each block
    const double cost = matrix.productCost();
    return cost > 0 && cost < most * hierarchy.fine.a.blocks() && matrix.symmetric() && !hierarchy.coarse.empty() &&
           !hierarchy.hasPatches();
  }
  /// Takes the matrix as it is, and its diagonal blocks where `key` is new; `of_this`: the hierarchy was made of this very
  /// matrix, and has their inverses. `stiffest` is stiffest() when the hierarchy was made; 0: now. False: not positive definite,
  /// in `row` where that is known.
  bool follow(const SystemMatrix& matrix, const Hierarchy& hierarchy, bool of_this, double& stiffest, Index& row);

  void smoothFromZero(ConstRows b, Rows x);
  void smooth(ConstRows b, Rows x);
  /// y = R^T (b - A x) / size, R the `turns` of the nodes
  void residual(ConstRows b, ConstRows x, const Vector* turns, double size, Array<float>& y);
  /// x += size R P e, e from levels of a matrix that was so much softer.
  void correct(const Blocks<3, modes>& p, const Array<float>& e, const Vector* turns, double size, Rows x) const;

 private:
  typedef double Four __attribute__((vector_size(32), aligned(8), may_alias));
  typedef float FourFloats __attribute__((vector_size(16), aligned(4), may_alias));
  static Four& four(double* from) { return *reinterpret_cast<Four*>(from); }
  static const Four& four(const double* from) { return *reinterpret_cast<const Four*>(from); }
  static std::size_t at(Index row) { return std::size_t(row) * row_doubles; }
  static Vec3 turned(const Vector& turns, Index row, double sign, const Vec3& v) {
    const double* const q = turns.rows().data + at(row);
    const Vec3 axis(sign * q[0], sign * q[1], sign * q[2]), twice = 2 * axis.cross(v);
    return v + q[3] * twice + axis.cross(twice);
  }
  /// D^-1 of this row times `in`, over scale_.
  Four divided(Index row, Four in) const {
    const float* const block = inverse_.data() + std::size_t(row) * 12;
    const auto column = [block](int c) {
      return __builtin_convertvector(*reinterpret_cast<const FourFloats*>(block + 4 * c), Four);
    };
    return column(0) * in[0] + column(1) * in[1] + column(2) * in[2];
  }
  bool invert(const SystemMatrix& matrix, const Hierarchy& hierarchy, bool of_this, Index& row);
  /// Of rows: the first whose block is not positive definite, and the sum of the logarithms of how much stiffer they are than
  /// in the hierarchy.
  struct Piece {
    Index bad = std::numeric_limits<Index>::max();
    double stiffer = 0;
  };
  Piece invertPiece(const Hierarchy& hierarchy, Index first, Index end);
  /// u.D^-1 A u / u.u of a vector that has much of the stiffest motions: it changes as the largest eigenvalue of D^-1 A does, and
  /// a few rows far stiffer than the others do not hide these.
  double stiffest();
  /// out = D^-1 in
  void divide(ConstRows in, Rows out) const {
    forRows(in.count, [=, this](Index i) { four(out.data + at(i)) = scale_ * divided(i, four(in.data + at(i))); });
  }
  /// x += d, d = keep d + move D^-1 (b - A x)
  void step(ConstRows b, Rows x, double keep, double move);
  /// The rest of a polynomial whose first step has been made.
  void goOn(ConstRows b, Rows x);
  double theta() const { return largest_ * (1 + 1 / reach) / 2; }  ///< the middle of the part of the spectrum that is smoothed
  double delta() const { return largest_ * (1 - 1 / reach) / 2; }  ///< and half its length
  static constexpr double reach = 12;

  const SystemMatrix* matrix_ = nullptr;  ///< of the solve that runs
  MatrixKey key_;
  double scale_ = 1;
  double largest_ = 0;       ///< eigenvalue of D^-1 A, from above
  double stiffer_ = 1;       ///< than the matrix that the hierarchy was made of: the mean of the diagonal blocks, geometric
  Floats inverse_;           ///< of the diagonal blocks times scale_, shape (rows, 3, 4)
  Vector change_, product_;  ///< work space
  std::vector<double> blocks_;
};

inline bool ProductLevel::follow(const SystemMatrix& matrix, const Hierarchy& hierarchy, bool of_this, double& before,
                                 Index& row) {
  matrix_ = &matrix;
  if (key_ == matrix.key() && largest_ > 0 && before > 0) return true;
  key_ = {};
  if (!invert(matrix, hierarchy, of_this, row)) return false;
  const double now = stiffest();
  if (before == 0) before = now;
  const double ratio = now / before;
  largest_ = hierarchy.fine.largest * (std::isfinite(ratio) ? std::max(1.0, ratio) : 1.0);
  key_ = matrix.key();
  return true;
}

inline bool ProductLevel::invert(const SystemMatrix& matrix, const Hierarchy& hierarchy, bool of_this, Index& row) {
  scale_ = hierarchy.scale;
  const Index rows = matrix.rows();
  if (change_.count() != rows) {
    change_.resize(rows), product_.resize(rows);
    allocate(inverse_, std::size_t(rows) * 12);
  }
  row = -1, stiffer_ = 1;
  if (of_this) {
    forRows(rows, [&](Index i) {
      Eigen::Map<Eigen::Matrix<float, 4, 3>> out(inverse_.data() + std::size_t(i) * 12);
      out.row(3).setZero();
      out.topRows<3>() = Eigen::Map<const Eigen::Matrix3f>(hierarchy.fine.inverse.data() + std::size_t(i) * 9);
    });
    return true;
  }
  matrix.diagonalBlocks(blocks_);
  std::array<Piece, 32> parts;
  forPieces(rows, piecesOf(rows), [&](int k, Index first, Index end) {
    parts[std::size_t(k)] = invertPiece(hierarchy, first, end);
  });
  Piece all;
  for (const Piece& part : parts) all.bad = std::min(all.bad, part.bad), all.stiffer += part.stiffer;
  stiffer_ = std::exp(all.stiffer / rows);
  if (all.bad == Piece().bad) return true;
  row = all.bad;
  return false;
}

[[gnu::noinline]] inline ProductLevel::Piece ProductLevel::invertPiece(const Hierarchy& hierarchy, Index first, Index end) {
  Piece piece;
  for (Index i = first; i < end; ++i) {
    Eigen::Map<Eigen::Matrix<float, 4, 3>> out(inverse_.data() + std::size_t(i) * 12);
    out.row(3).setZero();
    const Mat3 a = scale_ * Eigen::Map<const Mat3>(blocks_.data() + std::size_t(i) * 9);
    const double minor = a(0, 0) * a(1, 1) - a(0, 1) * a(1, 0), determinant = a.determinant();
    if (!(a(0, 0) > 0 && minor > 0 && determinant > 0)) piece.bad = std::min(piece.bad, i);
    const Mat3 inverse = a.inverse();
    const float* const former = hierarchy.fine.inverse.data() + std::size_t(i) * 9;
    piece.stiffer += std::log((double(former[0]) + double(former[4]) + double(former[8])) / inverse.trace());
    out.topRows<3>() = inverse.cast<float>();
  }
  return piece;
}

inline double ProductLevel::stiffest() {
  forRows(change_.count(), [this](Index i) {
    std::uint32_t bits = std::uint32_t(i) * 2654435761u + 12345u;
    Vec3 any;
    for (int l = 0; l < 3; ++l) {
      bits = (bits ^ (bits >> 15)) * 2246822519u + 1013904223u;
      any[l] = double(bits >> 8) / 16777216.0 - 0.5;
    }
    change_[i] = any;
  });
  matrix_->multiply(change_, product_.rows());
  divide(product_, change_.rows());
  matrix_->multiply(change_, product_.rows());
  divide(product_, product_.rows());
  return cg::inner(change_, product_) / cg::inner(change_, change_);
}

inline void ProductLevel::step(ConstRows b, Rows x, double keep, double move) {
  matrix_->multiply(x, product_.rows());
  const double* const q = product_.rows().data;
  double* const d = change_.rows().data;
  const double scaled = move * scale_;
  forRows(x.count, [=, this](Index row) {
    const std::size_t i = at(row);
    const Four change = keep * four(d + i) + scaled * divided(row, four(b.data + i) - four(q + i));
    four(d + i) = change;
    four(x.data + i) = four(x.data + i) + change;
  });
}

// Saad 2003, algorithm 12.1, with the residual computed anew in each step.
inline void ProductLevel::goOn(ConstRows b, Rows x) {
  const double sigma = theta() / delta();
  double rho = 1 / sigma;
  for (int k = 1; k < steps; ++k) {
    const double next = 1 / (2 * sigma - rho);
    step(b, x, next * rho, 2 * next / delta());
    rho = next;
  }
}

inline void ProductLevel::smoothFromZero(ConstRows b, Rows x) {
  const double first = scale_ / theta();
  double* const d = change_.rows().data;
  forRows(x.count, [=, this](Index row) {
    const Four change = first * divided(row, four(b.data + at(row)));
    four(d + at(row)) = change;
    four(x.data + at(row)) = change;
  });
  goOn(b, x);
}

inline void ProductLevel::smooth(ConstRows b, Rows x) {
  step(b, x, 0, 1 / theta());
  goOn(b, x);
}

inline void ProductLevel::residual(ConstRows b, ConstRows x, const Vector* turns, double size, Array<float>& y) {
  matrix_->multiply(x, product_.rows());
  const double out = 1 / size;
  forRows(x.count, [&](Index i) {
    const Vec3 rest = out * (Vec3(b[i]) - Vec3(product_[i]));
    const Vec3 seen = turns ? turned(*turns, i, -1, rest) : rest;
    float* const to = y.data() + std::size_t(i) * lanes<3>;
    for (int l = 0; l < 3; ++l) to[l] = float(seen[l]);
    to[3] = 0;
  });
}

inline void ProductLevel::correct(const Blocks<3, modes>& p, const Array<float>& e, const Vector* turns, double size,
                                  Rows x) const {
  size /= stiffer_;
  forRows(p.rows(), [&](Index i) {
    Column<3> sum;
    p.multiplyRow(i, e.data(), sum);
    const Vec3 found(size * double(sum.lane[0]), size * double(sum.lane[1]), size * double(sum.lane[2]));
    x[i] += turns ? turned(*turns, i, 1, found) : found;
  });
}

}  // namespace stroma::amg
