// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/mechanics/mass.h"

#include <algorithm>

#include "framework/algebra/parallel.h"
#include "framework/scene/node.h"

namespace stroma {

namespace {

constexpr Index piece_rows = 16384;  ///< rows that one thread takes at a time

}  // namespace

void Mass::addProduct(ConstRows p, double factor, Rows out) const {
  const double* __restrict mass = lumped().data();
  const std::size_t first = std::size_t(state().firstRow()) * row_doubles;
  const double* __restrict source = p.data + first;
  double* __restrict target = out.data + first;
  const Index size = state().size();
  parallelFor(int((size + piece_rows - 1) / piece_rows), [=](int piece) {
    const Index begin = piece * piece_rows, end = std::min(size, begin + piece_rows);
    for (Index i = begin; i < end; ++i) {
      const double m = factor * mass[i];
      for (int c = 0; c < row_doubles; ++c) target[row_doubles * i + c] += m * source[row_doubles * i + c];
    }
  });
}

void Mass::addTo(double factor, BlockMatrix& matrix) const {
  const std::vector<double>& mass = lumped();
  const Index first = state().firstRow();
  for (Index i = 0; i < state().size(); ++i) {
    double* block = matrix.values().data() + std::size_t(matrix.diagonal()[first + i]) * 9;
    for (int c : {0, 4, 8}) block[c] += factor * mass[i];
  }
}

void Mass::addDiagonal(double factor, std::vector<double>& blocks) const {
  const std::vector<double>& mass = lumped();
  const Index first = state().firstRow();
  for (Index i = 0; i < state().size(); ++i)
    for (int c : {0, 4, 8}) blocks[std::size_t(first + i) * 9 + std::size_t(c)] += factor * mass[i];
}

// M g = (row sums) g for any mass, because g is the same at all nodes.
void Mass::addGravity(Rows f) const {
  const std::vector<double>& mass = lumped();
  const Vec3 gravity = node().gravity();
  for (Index i = 0; i < state().size(); ++i) f[state().firstRow() + i] += mass[i] * gravity;
}

double Mass::kineticEnergy(ConstRows v) const {
  double sum = 0;
  const Index first = state().firstRow();
  if (isDiagonal()) {
    const std::vector<double>& mass = lumped();
    for (Index i = 0; i < state().size(); ++i) sum += mass[i] * v[first + i].squaredNorm();
    return 0.5 * sum;
  }
  if (work_.count() != v.count) work_.resize(v.count);
  clear(work_);
  addProduct(v, 1, work_);
  for (Index i = 0; i < state().size(); ++i) sum += work_[first + i].dot(v[first + i]);
  return 0.5 * sum;
}

double Mass::gravityEnergy(ConstRows x) const {
  const std::vector<double>& mass = lumped();
  const Vec3 gravity = node().gravity();
  double sum = 0;
  for (Index i = 0; i < state().size(); ++i) sum -= mass[i] * gravity.dot(x[state().firstRow() + i]);
  return sum;
}

double Mass::totalMass() const {
  double sum = 0;
  for (double m : lumped()) sum += m;
  return sum;
}

}  // namespace stroma
