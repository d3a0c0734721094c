// SPDX-License-Identifier: LGPL-2.1-or-later
// How a level of a multigrid hierarchy is made from its matrix, in double precision: Galerkin's product subtracts large
// numbers for motions that cost little energy, and only its result may be rounded. Inline for the reason given in
// vector.h.
#pragma once
#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>

#include "components/iterative_solvers/multigrid_aggregates.h"
#include "components/iterative_solvers/multigrid_level.h"

namespace stroma::amg {

/// A square matrix of D x D blocks of doubles, row-major in a block; not owned.
template <int D>
struct BlockView {
  Index rows = 0;
  const Index *start = nullptr, *columns = nullptr, *diagonal = nullptr;
  const double* values = nullptr;
  using Block = Eigen::Matrix<double, D, D, Eigen::RowMajor>;
  Eigen::Map<const Block> block(Index slot) const {
    return Eigen::Map<const Block>(values + std::size_t(slot) * D * D);
  }
};

/// The matrix of a coarse level while the next one is made.
struct CoarseMatrix {
  std::vector<Index> start{0}, columns, diagonal;
  std::vector<double, Passing<double>> values;
  BlockView<modes> view() const {
    return {Index(diagonal.size()), start.data(), columns.data(), diagonal.data(), values.data()};
  }
};

/// Rows of D x 6 blocks of doubles, row-major: motions of nodes.
template <int D>
struct Motions {
  static constexpr std::size_t size = std::size_t(D) * modes;
  std::vector<double> values;
  using Block = Eigen::Matrix<double, D, modes, Eigen::RowMajor>;
  void resize(std::size_t blocks) { values.assign(blocks * size + 8, 0.0); }
  Eigen::Map<Block> at(Index k) { return Eigen::Map<Block>(values.data() + std::size_t(k) * size); }
  Eigen::Map<const Block> at(Index k) const { return Eigen::Map<const Block>(values.data() + std::size_t(k) * size); }
};

/// Six doubles in registers.
struct Six {
  using Four = double __attribute__((vector_size(32)));
  using Two = double __attribute__((vector_size(16)));
  Four low{};
  Two high{};
  void load(const double* from) {
    std::memcpy(&low, from, sizeof low);
    std::memcpy(&high, from + 4, sizeof high);
  }
  void load(const float* from) {
    for (int k = 0; k < 4; ++k) low[k] = from[k];
    for (int k = 0; k < 2; ++k) high[k] = from[4 + k];
  }
  void store(double* to) const {
    std::memcpy(to, &low, sizeof low);
    std::memcpy(to + 4, &high, sizeof high);
  }
  void add(double factor, const Six& other) {
    low += factor * other.low;
    high += factor * other.high;
  }
};

/// body(piece, first row, last row) for pieces that share nothing; their number does not depend on that of the threads.
template <class Body>
void forPieces(Index rows, int pieces, Body&& body) {
  parallelFor(pieces, [&](int k) {
    body(k, Index(std::int64_t(rows) * k / pieces), Index(std::int64_t(rows) * (k + 1) / pieces));
  });
}
inline int piecesOf(Index rows) { return std::clamp(int(rows / 64), 1, 32); }

/// Links whose block is not small beside the diagonal blocks of its ends: |A_ij|^2 > weak^2 |A_ii| |A_jj|. A node with many neighbours
/// may have none that is: each spring of a net in hexahedra is a 26th of its diagonal. Then those are strong that are half as
/// strong as the strongest one, unless that is below an eighth of `weak`: what holds such a node is not its neighbours.
template <int D>
StrongGraph strongLinks(const BlockView<D>& a, double weak) {
  constexpr double half_as_strong = 0.25, least = 1.0 / 64;  // of squares
  std::vector<double> size(std::size_t(a.rows));
  forRows(a.rows, [&](Index i) { size[std::size_t(i)] = a.block(a.diagonal[i]).norm(); });
  const auto strength = [&](Index i, Index s) {
    return i == a.columns[s] ? 0 : a.block(s).squaredNorm() / (size[std::size_t(i)] * size[std::size_t(a.columns[s])]);
  };
  std::vector<char> strong(std::size_t(a.start[a.rows]));
  StrongGraph graph;
  graph.start.assign(std::size_t(a.rows) + 1, 0);
  forRows(a.rows, [&](Index i) {
    const double weakest = weak * weak;
    const auto mark = [&](double limit) {
      Index count = 0;
      for (Index s = a.start[i]; s < a.start[i + 1]; ++s) count += strong[std::size_t(s)] = strength(i, s) > limit;
      return count;
    };
    Index count = mark(weakest);
    if (count == 0) {
      double most = 0;
      for (Index s = a.start[i]; s < a.start[i + 1]; ++s) most = std::max(most, strength(i, s));
      if (most > least * weakest) count = mark(half_as_strong * most);
    }
    graph.start[std::size_t(i) + 1] = count;
  });
  for (std::size_t i = 0; i < std::size_t(a.rows); ++i) graph.start[i + 1] += graph.start[i];
  graph.neighbours.resize(std::size_t(graph.start.back()));
  forRows(a.rows, [&](Index i) {
    Index at = graph.start[std::size_t(i)];
    for (Index s = a.start[i]; s < a.start[i + 1]; ++s)
      if (strong[std::size_t(s)]) graph.neighbours[std::size_t(at++)] = a.columns[s];
  });
  return graph;
}

/// The matrix in single precision, times `scale`, with the inverses of its diagonal blocks. Returns the first row whose
/// block is not positive definite, or -1.
template <int D>
Index fillLevel(const BlockView<D>& a, double scale, Level<D>& level) {
  level.a.start.assign(a.start, a.start + a.rows + 1);
  level.a.columns.assign(a.columns, a.columns + a.start[a.rows]);
  level.a.allocateValues();
  allocate(level.inverse, std::size_t(a.rows) * D * D);
  std::vector<char> bad(std::size_t(a.rows), 0);
  using Turned = Eigen::Matrix<float, D, D>;
  forRows(a.rows, [&](Index i) {
    for (Index s = a.start[i]; s < a.start[i + 1]; ++s)
      Eigen::Map<Turned>(level.a.at(s)) = (scale * a.block(s)).template cast<float>();
    const Eigen::Matrix<double, D, D> block = scale * a.block(a.diagonal[i]);
    const Eigen::LLT<Eigen::Matrix<double, D, D>> factor(block);
    if (factor.info() != Eigen::Success || !(block.trace() < std::numeric_limits<double>::infinity()))
      bad[std::size_t(i)] = 1;
    else
      Eigen::Map<Turned>(level.inverse.data() + std::size_t(i) * D * D) =
          factor.solve(Eigen::Matrix<double, D, D>::Identity()).template cast<float>();
  });
  level.allocateWork();
  const auto first = std::find(bad.begin(), bad.end(), 1);
  return first == bad.end() ? -1 : Index(first - bad.begin());
}

/// The largest eigenvalue of the smoother's M^-1 A from above: what Lanczos' method finds in 15 steps, and a twentieth. The
/// smoother bears 1.13 times what was found. A single eigenvalue so far above the others grows by 12,000 in those steps: it is
/// found beside 100 million others.
template <int D>
double largestEigenvalue(Level<D>& level) {
  constexpr int steps = 15;
  const std::size_t numbers = level.x.size();
  Array<float> p(numbers), q(numbers);
  std::uint32_t bits = 12345;
  for (Index i = 0; i < level.a.rows(); ++i)
    for (int l = 0; l < D; ++l) {
      bits = bits * 1664525u + 1013904223u;
      level.b[std::size_t(i) * lanes<D> + std::size_t(l)] = float(bits >> 8) / 16777216.0f - 0.5f;
    }
  const auto divide = [&](const Array<float>& in, Array<float>& out) {
    level.precondition(in, [&](Index row, const Column<D>& z) { z.store(out.data() + std::size_t(row) * lanes<D>); });
  };
  const auto product = [numbers](const Array<float>& u, const Array<float>& v) {
    double sum = 0;
    for (std::size_t i = 0; i < numbers; ++i) sum += double(u[i]) * double(v[i]);
    return sum;
  };
  // conjugate gradients, whose coefficients are those of Lanczos' matrix
  Eigen::VectorXd diagonal(steps), side(steps);
  Array<float>&r = level.b, &z = level.y;
  divide(r, z);
  p = z;
  double rho = product(r, z), beta = 0, before = 1;
  int done = 0;
  for (; done < steps && rho > 0; ++done) {
    forRows(level.a.rows(), [&](Index row) {
      Column<D> sum;
      level.a.multiplyRow(row, p.data(), sum);
      sum.store(q.data() + std::size_t(row) * lanes<D>);
    });
    const double energy = product(p, q);
    if (!(energy > 0)) break;
    const double alpha = rho / energy;
    diagonal[done] = 1 / alpha + (done > 0 ? beta / before : 0);
    for (std::size_t i = 0; i < numbers; ++i) r[i] -= float(alpha) * q[i];
    divide(r, z);
    const double next = product(r, z);
    beta = next / rho, before = alpha, rho = next;
    side[done] = std::sqrt(std::max(beta, 0.0)) / alpha;
    for (std::size_t i = 0; i < numbers; ++i) p[i] = z[i] + float(beta) * p[i];
  }
  if (done == 0) return 0;
  Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> values;
  values.computeFromTridiagonal(diagonal.head(done), side.head(std::max(done - 1, 0)), Eigen::EigenvaluesOnly);
  return 1.05 * values.eigenvalues().maxCoeff();
}

}  // namespace stroma::amg
