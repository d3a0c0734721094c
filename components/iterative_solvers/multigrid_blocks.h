// SPDX-License-Identifier: LGPL-2.1-or-later
// Matrices of small blocks in single precision, as the levels of a multigrid hierarchy keep them, and products with a
// row of them. A block is stored column after column: a product is one multiply-add of registers for each column. Loads
// run past the end of a short column; what the lanes beyond the last row then hold is not used. Inline for the reason
// given in vector.h.
#pragma once
#include <algorithm>
#include <cstring>
#include <vector>

#include "framework/algebra/memory.h"
#include "framework/algebra/parallel.h"
#include "framework/scene/types.h"

namespace stroma::amg {

/// Unknowns of a node of a coarse level: a rigid body's motion.
constexpr int modes = 6;

/// Numbers that a row of D unknowns fills in a vector; those beyond D are zero.
template <int D>
constexpr int lanes = D <= 4 ? 4 : 8;

template <int Count>
struct Register;
template <>
struct Register<4> {
  typedef float Lanes __attribute__((vector_size(16)));
};
template <>
struct Register<8> {
  typedef float Lanes __attribute__((vector_size(32)));
};

/// Memory that is not cleared before it is filled.
template <class T>
struct Uncleared : ArrayAllocator<T> {
  template <class U>
  struct rebind {
    using other = Uncleared<U>;
  };
  Uncleared() = default;
  template <class U>
  Uncleared(const Uncleared<U>&) {}
  template <class U>
  void construct(U*) {}
  template <class U>
  void construct(U* place, const U& value) {
    *place = value;
  }
};
using Floats = std::vector<float, Uncleared<float>>;

/// A column of D floats in a register.
template <int D>
struct Column {
  using Lanes = typename Register<lanes<D>>::Lanes;
  Lanes lane{};
  void load(const float* from) { std::memcpy(&lane, from, sizeof(Lanes)); }
  /// With zeros beyond D.
  void store(float* to) const {
    Lanes cut = lane;
    for (int l = D; l < lanes<D>; ++l) cut[l] = 0;
    std::memcpy(to, &cut, sizeof(Lanes));
  }
};

/// `count` floats to be filled, and eight zeros.
inline void allocate(Floats& values, std::size_t count) {
  values = {};
  values.resize(count + 8);
  std::fill_n(values.end() - 8, 8, 0.0f);
}

/// Rows of blocks of R x C floats.
template <int R, int C>
struct Blocks {
  static constexpr std::size_t size = std::size_t(R) * C;
  std::vector<Index> start{0}, columns;  ///< shape (rows + 1), (blocks)
  Floats values;                         ///< shape (blocks, C, R), and a few zeros for loads past the end

  Index rows() const { return Index(start.size()) - 1; }
  Index blocks() const { return Index(columns.size()); }
  /// Makes room for the blocks that `columns` has; they are to be filled.
  void allocateValues() { allocate(values, columns.size() * size); }
  float* at(Index slot) { return values.data() + std::size_t(slot) * size; }
  const float* at(Index slot) const { return values.data() + std::size_t(slot) * size; }

  /// sum = row `row` of A x.
  void multiplyRow(Index row, const float* __restrict x, Column<R>& sum) const {
    Column<R> part[C], column;
    for (Index s = start[std::size_t(row)]; s < start[std::size_t(row) + 1]; ++s) {
      const float* __restrict block = at(s);
      const float* __restrict p = x + std::size_t(columns[std::size_t(s)]) * lanes<C>;
      for (int c = 0; c < C; ++c) {
        column.load(block + c * R);
        part[c].lane += column.lane * p[c];
      }
    }
    sum = part[0];
    for (int c = 1; c < C; ++c) sum.lane += part[c].lane;
  }
};

/// body(row) for all rows, in pieces that threads share. Rows do not see each other.
template <class Body>
void forRows(Index rows, Body&& body) {
  constexpr Index piece = 1024;
  parallelFor(int((rows + piece - 1) / piece), [&](int k) {
    const Index end = std::min(rows, (Index(k) + 1) * piece);
    for (Index row = Index(k) * piece; row < end; ++row) body(row);
  });
}

/// One level: its matrix A, how it is smoothed, and how it hands over to the next one.
template <int D>
struct Level {
  Blocks<D, D> a;
  Floats inverse;           ///< of the diagonal blocks, shape (rows, D, D) and a few zeros
  double largest = 0;       ///< eigenvalue of D^-1 A, estimated from above
  Blocks<D, modes> p;       ///< prolongation; no rows on the last level
  Blocks<modes, D> r;       ///< p^T
  Array<float> b, x, y, d;  ///< work space, shape (rows, lanes): right side, solution twice, last change

  void allocateWork() {
    for (Array<float>* vector : {&b, &x, &y, &d}) vector->assign(std::size_t(a.rows()) * lanes<D>, 0.0f);
  }
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

  /// x = smoothed solution of A x = b from nothing; Chebyshev's polynomial of D^-1 A over the upper part of the spectrum.
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
  /// y = x + d, d = keep d + move D^-1 (b - A x); then y is x.
  void step(float keep, float move);
};

/// The share of the spectrum's upper end that is smoothed: from largest / smoothed_range up.
constexpr double smoothed_range = 8;

template <int D>
void Level<D>::step(float keep, float move) {
  forRows(a.rows(), [&](Index row) {
    const std::size_t at = std::size_t(row) * lanes<D>;
    Column<D> sum, now, right, change;
    a.multiplyRow(row, x.data(), sum);
    right.load(b.data() + at);
    right.lane -= sum.lane;
    float rest[lanes<D>];
    right.store(rest);
    divideRow(row, rest, sum);
    change.load(d.data() + at);
    change.lane = keep * change.lane + move * sum.lane;
    change.store(d.data() + at);
    now.load(x.data() + at);
    now.lane += change.lane;
    now.store(y.data() + at);
  });
  x.swap(y);
}

// Saad 2003, algorithm 12.1, with the residual computed anew in each step.
template <int D>
void Level<D>::smooth(int degree) {
  const double low = largest / smoothed_range, theta = (largest + low) / 2, delta = (largest - low) / 2;
  const double sigma = theta / delta;
  double rho = 1 / sigma;
  step(0, float(1 / theta));
  for (int k = 1; k < degree; ++k) {
    const double next = 1 / (2 * sigma - rho);
    step(float(next * rho), float(2 * next / delta));
    rho = next;
  }
}

template <int D>
void Level<D>::smoothFromZero(int degree) {
  const double low = largest / smoothed_range, theta = (largest + low) / 2, delta = (largest - low) / 2;
  const double sigma = theta / delta;
  double rho = 1 / sigma;
  const float first = float(1 / theta);
  forRows(a.rows(), [&](Index row) {
    const std::size_t at = std::size_t(row) * lanes<D>;
    Column<D> change;
    divideRow(row, b.data() + at, change);
    change.lane *= first;
    change.store(d.data() + at);
    change.store(x.data() + at);
  });
  for (int k = 1; k < degree; ++k) {
    const double next = 1 / (2 * sigma - rho);
    step(float(next * rho), float(2 * next / delta));
    rho = next;
  }
}

}  // namespace stroma::amg
