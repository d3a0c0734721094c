// SPDX-License-Identifier: LGPL-2.1-or-later
// Where a solve begins, from the solutions of the solves before it: the combination of them that is nearest to the new
// solution in the energy of the new matrix A (Fischer 1998),
//
//   x = sum_k c_k x_k,   sum_k x_j.A x_k c_k = x_j.b,
//
// for one product each. The changes of velocity in steps of a body that swings follow few motions: four of them leave
// 2 to 5 % of the residual. What leaves more than half is not worth its products, and the next try then waits. Inline for
// the reason given in vector.h.
#pragma once
#include <Eigen/Eigenvalues>
#include <memory>
#include <string>
#include <vector>

#include "components/iterative_solvers/preconditioned_conjugate_gradients.h"
#include "framework/scene/archive.h"

namespace stroma::cg {

class FormerSolutions {
 public:
  static constexpr int most = 4;

  /// x and work.r = b - A x where that gains; its |r| / |b|. 1, and x as it was: a start from there is as good. `size` is |b|.
  template <class Product>
  double begin(Product&& product, ConstRows b, double size, Directions& work, Rows x);
  /// After each solve that found one.
  void solved(ConstRows x);
  void reset() { now_ = kept_ = {}, all_.clear(); }
  void keep() { kept_ = now_; }
  void takeBack() { now_ = kept_; }
  void serialize(Archive& archive);

 private:
  using Shared = std::shared_ptr<Vector>;
  using Matrix = Eigen::Matrix<double, most, most>;
  using Factors = Eigen::Matrix<double, most, 1>;
  /// What later solves depend on.
  struct Memory {
    std::vector<Shared> solutions;  ///< the oldest first
    int solves = 0;                 ///< as far as counted: the first ones may be all, and nothing is kept of them
    int wait = 0;                   ///< solves until the next try
    int pause = 0;                  ///< the last time that one was without a gain
  };
  /// c, or zeros where A shows itself not to be definite.
  static Factors bestFactors(const Matrix& a, const Factors& b);
  void combine(const Factors& c, Index first, Index size, Rows x) const;
  Shared unused(Index rows);

  Memory now_, kept_;
  std::vector<Shared> all_;  ///< no step allocates any once there are enough
};

inline FormerSolutions::Factors FormerSolutions::bestFactors(const Matrix& a, const Factors& b) {
  constexpr double least = 1e-12;  // of an energy beside the others: round-off
  const Factors size = a.diagonal().cwiseMax(0).cwiseSqrt();
  if (!a.allFinite() || !b.allFinite() || !(size.minCoeff() > 0)) return Factors::Zero();
  const Factors scale = size.cwiseInverse();
  const Matrix scaled = scale.asDiagonal() * a * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Matrix> motions((scaled + scaled.transpose()) / 2);
  Factors part = motions.eigenvectors().transpose() * (scale.asDiagonal() * b);
  for (int k = 0; k < most; ++k) part[k] = motions.eigenvalues()[k] > least ? part[k] / motions.eigenvalues()[k] : 0;
  return scale.asDiagonal() * (motions.eigenvectors() * part);
}

[[gnu::noinline]] inline void FormerSolutions::combine(const Factors& c, Index first, Index size, Rows x) const {
  static_assert(most == 4);
  const auto of = [&](std::size_t k) { return ConstRows(*now_.solutions[k]).segment(first, size).data; };
  const double* __restrict a0 = of(0);
  const double* __restrict a1 = of(1);
  const double* __restrict a2 = of(2);
  const double* __restrict a3 = of(3);
  double* __restrict out = x.segment(first, size).data;
  const std::size_t count = std::size_t(size) * row_doubles;
#pragma omp simd
  for (std::size_t i = 0; i < count; ++i) out[i] = (c[0] * a0[i] + c[1] * a1[i]) + (c[2] * a2[i] + c[3] * a3[i]);
}

template <class Product>
double FormerSolutions::begin(Product&& product, ConstRows b, double size, Directions& work, Rows x) {
  constexpr double most_left = 0.5;
  constexpr int longest_pause = 64;
  if (int(now_.solutions.size()) < most || now_.solutions[0]->count() != b.count || inner(x, x) != 0) return 1;
  if (now_.wait > 0) return --now_.wait, 1;
  Matrix energies;
  Factors works;
  for (int k = 0; k < most; ++k) {
    const Vector& solution = *now_.solutions[std::size_t(k)];
    product(solution, work.q.rows());
    for (int j = 0; j <= k; ++j) energies(j, k) = energies(k, j) = inner(*now_.solutions[std::size_t(j)], work.q);
    works[k] = inner(solution, b);
  }
  const Factors c = bestFactors(energies, works);
  forPieces(b.count, [&](int, Index first, Index count) {
    combine(c, first, count, x);
    copy(b.segment(first, count), work.r.rows().segment(first, count));
  });
  product(x, work.q.rows());
  const double left = std::sqrt(reduceResidual(1, work.q, work.r)) / size;
  if (left <= most_left) return now_.pause = 0, left;
  now_.wait = now_.pause = std::min(longest_pause, std::max(most, 2 * now_.pause));
  clear(x);
  return 1;
}

inline FormerSolutions::Shared FormerSolutions::unused(Index rows) {
  for (const Shared& each : all_)
    if (each.use_count() == 1 && each->count() == rows) return each;
  std::erase_if(all_, [](const Shared& each) { return each.use_count() == 1; });
  return all_.emplace_back(std::make_shared<Vector>(rows));
}

inline void FormerSolutions::solved(ConstRows x) {
  constexpr int passed_over = 2;
  if (now_.solves < passed_over) return void(++now_.solves);
  auto& solutions = now_.solutions;
  if (!solutions.empty() && solutions[0]->count() != x.count) solutions.clear();
  if (int(solutions.size()) == most) solutions.erase(solutions.begin());
  Shared place = unused(x.count);
  copyShared(x, *place);
  solutions.push_back(std::move(place));
}

inline void FormerSolutions::serialize(Archive& archive) {
  int count = int(now_.solutions.size());
  archive.value("former_solutions", count);
  archive.value("former_solves", now_.solves);
  archive.value("former_wait", now_.wait);
  archive.value("former_pause", now_.pause);
  if (archive.isReading()) {
    now_.solutions.resize(std::size_t(count));
    for (Shared& each : now_.solutions) each = all_.emplace_back(std::make_shared<Vector>());
  }
  for (int k = 0; k < count; ++k) archive.rows("former_" + std::to_string(k), *now_.solutions[std::size_t(k)]);
}

}  // namespace stroma::cg
