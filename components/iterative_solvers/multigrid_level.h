// SPDX-License-Identifier: LGPL-2.1-or-later
// A level of a multigrid hierarchy: its matrix, its smoother, and what it hands over to the next level.
#pragma once
#include "components/iterative_solvers/multigrid_patches.h"

namespace stroma::amg {

/// One level: its matrix A, how it is smoothed, and how it hands over to the next one. The smoother is a polynomial in
/// M^-1 A, M the diagonal blocks of A, or its patches where there are some.
template <int D>
struct Level {
  Blocks<D, D> a;
  Floats inverse;           ///< of the diagonal blocks, shape (rows, D, D) and a few zeros
  Patches<D> patches;       ///< none: the diagonal blocks smooth
  double largest = 0;       ///< eigenvalue of M^-1 A, estimated from above
  Blocks<D, modes> p;       ///< prolongation; no rows on the last level
  Blocks<modes, D> r;       ///< p^T
  Array<float> b, x, y, d;  ///< work space, shape (rows, lanes): right side, solution twice, last change

  void allocateWork() {
    for (Array<float>* vector : {&b, &x, &y, &d}) vector->assign(std::size_t(a.rows()) * lanes<D>, 0.0f);
    patches.allocateWork();
  }
  /// use(row, z) for each row of z = M^-1 in.
  template <class Use>
  void precondition(const Array<float>& in, Use&& use) {
    if (patches.exist()) patches.solve(in.data());
    forRows(a.rows(), [&](Index row) {
      Column<D> z;
      if (patches.exist())
        patches.gather(row, z);
      else
        divideRow(row, in.data() + std::size_t(row) * lanes<D>, z);
      use(row, z);
    });
  }

  /// x = smoothed solution of A x = b from nothing; Chebyshev's polynomial of M^-1 A over the upper part of the spectrum.
  void smoothFromZero(int degree);
  /// The same from x.
  void smooth(int degree);
  /// y = b - A x
  void residual() {
    forRows(a.rows(), [this](Index row) {
      Column<D> sum, right;
      a.multiplyRow(row, x.data(), sum);
      right.load(b.data() + std::size_t(row) * lanes<D>);
      right.lane -= sum.lane;
      right.store(y.data() + std::size_t(row) * lanes<D>);
    });
  }
  /// What the next level has to solve: r y.
  void restrictTo(Array<float>& coarse) const {
    forRows(r.rows(), [&](Index row) {
      Column<modes> sum;
      r.multiplyRow(row, y.data(), sum);
      sum.store(coarse.data() + std::size_t(row) * lanes<modes>);
    });
  }
  /// x += p e
  void correctBy(const Array<float>& e) {
    forRows(p.rows(), [&](Index row) {
      Column<D> sum, now;
      p.multiplyRow(row, e.data(), sum);
      now.load(x.data() + std::size_t(row) * lanes<D>);
      now.lane += sum.lane;
      now.store(x.data() + std::size_t(row) * lanes<D>);
    });
  }

 private:
  struct Interval {
    double theta, delta;  ///< its middle and half its length
  };
  /// The upper end of the spectrum, from the largest eigenvalue down to a share of it. Patches reach further down.
  Interval smoothedPart() const {
    const double low = largest / (patches.exist() ? 16 : 12);
    return {(largest + low) / 2, (largest - low) / 2};
  }
  /// x += d, d = keep d + move M^-1 (b - A x)
  void step(float keep, float move);
  /// The rest of a polynomial whose first step has been made.
  void goOn(int degree, const Interval& part);
  /// out = D^-1 of this row times `in`.
  void divideRow(Index row, const float* in, Column<D>& out) const {
    const float* block = inverse.data() + std::size_t(row) * D * D;
    Column<D> column;
    out = {};
    for (int c = 0; c < D; ++c) {
      column.load(block + c * D);
      out.lane += column.lane * in[c];
    }
  }
  /// to = x + d, d = keep d + move z, in one row.
  void advance(Index row, float keep, float move, const Column<D>& z, Array<float>& to) {
    const std::size_t at = std::size_t(row) * lanes<D>;
    Column<D> now, change;
    change.load(d.data() + at);
    change.lane = keep * change.lane + move * z.lane;
    change.store(d.data() + at);
    now.load(x.data() + at);
    now.lane += change.lane;
    now.store(to.data() + at);
  }
};

template <int D>
void Level<D>::step(float keep, float move) {
  if (patches.exist()) {
    residual();
    precondition(y, [&](Index row, const Column<D>& z) { advance(row, keep, move, z, x); });
    return;
  }
  forRows(a.rows(), [&](Index row) {
    Column<D> sum, right;
    a.multiplyRow(row, x.data(), sum);
    right.load(b.data() + std::size_t(row) * lanes<D>);
    right.lane -= sum.lane;
    float rest[lanes<D>];
    right.store(rest);
    divideRow(row, rest, sum);
    advance(row, keep, move, sum, y);
  });
  x.swap(y);
}

// Saad 2003, algorithm 12.1, with the residual computed anew in each step.
template <int D>
void Level<D>::goOn(int degree, const Interval& part) {
  const double sigma = part.theta / part.delta;
  double rho = 1 / sigma;
  for (int k = 1; k < degree; ++k) {
    const double next = 1 / (2 * sigma - rho);
    step(float(next * rho), float(2 * next / part.delta));
    rho = next;
  }
}

template <int D>
void Level<D>::smooth(int degree) {
  const Interval part = smoothedPart();
  step(0, float(1 / part.theta));
  goOn(degree, part);
}

template <int D>
void Level<D>::smoothFromZero(int degree) {
  const Interval part = smoothedPart();
  const float first = float(1 / part.theta);
  precondition(b, [&](Index row, Column<D> z) {
    z.lane *= first;
    z.store(d.data() + std::size_t(row) * lanes<D>);
    z.store(x.data() + std::size_t(row) * lanes<D>);
  });
  goOn(degree, part);
}

}  // namespace stroma::amg
