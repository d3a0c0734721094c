// SPDX-License-Identifier: LGPL-2.1-or-later
// The last level of a multigrid hierarchy, solved exactly: A = L L^T in double precision. Of each row of L the numbers from
// its first one on are kept (the envelope; George and Liu 1981, chapter 4), nodes in the order of Cuthill and McKee 1969,
// reversed: a slender body has a narrow band. Inline for the reason given in vector.h.
#pragma once
#include <Eigen/Cholesky>
#include <algorithm>
#include <vector>

#include "components/iterative_solvers/multigrid_build.h"

namespace stroma::amg {

/// Nodes so that neighbours lie near each other.
template <int D>
std::vector<Index> bandOrder(const BlockView<D>& a) {
  std::vector<Index> order, reached;
  std::vector<char> placed(std::size_t(a.rows), 0);
  const auto before = [&a](Index i, Index j) {
    const Index of_i = a.start[i + 1] - a.start[i], of_j = a.start[j + 1] - a.start[j];
    return of_i != of_j ? of_i < of_j : i < j;
  };
  // appends what hangs together with `root`, in circles around it
  const auto spread = [&](Index root, std::vector<Index>& list) {
    std::size_t at = list.size();
    list.push_back(root);
    placed[std::size_t(root)] = 1;
    for (; at < list.size(); ++at) {
      const std::size_t behind = list.size();
      for (Index s = a.start[list[at]]; s < a.start[list[at] + 1]; ++s) {
        const Index j = a.columns[s];
        if (placed[std::size_t(j)]) continue;
        placed[std::size_t(j)] = 1;
        list.push_back(j);
      }
      std::sort(list.begin() + std::ptrdiff_t(behind), list.end(), before);
    }
  };
  for (Index i = 0; i < a.rows; ++i) {
    if (placed[std::size_t(i)]) continue;
    Index root = i;
    for (int again = 0; again < 2; ++again) {  // to an end of the body
      reached.clear();
      spread(root, reached);
      root = reached.back();
      for (const Index j : reached) placed[std::size_t(j)] = 0;
    }
    spread(root, order);
  }
  std::reverse(order.begin(), order.end());
  return order;
}

/// The factor, if there is one.
struct LastLevel {
  int unknowns = 0;                 ///< of a node, 3 or 6; 0: there is none, the smoother stands for it
  std::vector<Index> order, first;  ///< the node at each place; the first place that its row reaches; shape (nodes)
  std::vector<Index> start;         ///< of each row in `values`, in blocks, shape (nodes + 1)
  Array<double> values;             ///< of each place D rows of numbers, D for each place from `first` to itself
  Array<double> work;               ///< shape (nodes, D); aligned, or bits depended on where it lies

  bool exists() const { return unknowns > 0; }
  /// Lays out a factor; returns the operations that it takes.
  template <int D>
  double layOut(const BlockView<D>& a);
  /// Fills what has been laid out for A times `scale`. False when that is not positive definite, also with what round-off
  /// may have taken.
  template <int D>
  bool factor(const BlockView<D>& a, double scale) {
    double largest = 0;
    for (Index i = 0; i < a.rows; ++i) largest = std::max(largest, scale * a.block(a.diagonal[i]).diagonal().maxCoeff());
    return factorShifted(a, scale, 0) || factorShifted(a, scale, 1e-9 * largest);
  }
  /// x = A^-1 b, both with lanes<D> numbers for a node.
  template <int D>
  void solve(const float* b, float* x);

 private:
  template <int D, class Values>
  auto row(Values& numbers, Index k) const {
    using Wide = Eigen::Matrix<double, D, Eigen::Dynamic, Eigen::RowMajor>;
    using Seen = std::conditional_t<std::is_const_v<Values>, const Wide, Wide>;
    const Index begin = start[std::size_t(k)], blocks = start[std::size_t(k) + 1] - begin;
    return Eigen::Map<Seen>(numbers.data() + std::size_t(begin) * D * D, D, Eigen::Index(blocks) * D);
  }
  template <int D>
  bool factorShifted(const BlockView<D>& a, double scale, double shift);
  template <int D>
  bool factorRow(Index k, double shift);
};

template <int D>
double LastLevel::layOut(const BlockView<D>& a) {
  *this = {};
  order = bandOrder(a);
  std::vector<Index> place(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) place[std::size_t(order[k])] = Index(k);
  start.assign(1, 0);
  double operations = 0, blocks = 0;
  for (std::size_t k = 0; k < order.size(); ++k) {
    Index least = Index(k);
    for (Index s = a.start[order[k]]; s < a.start[order[k] + 1]; ++s)
      least = std::min(least, place[std::size_t(a.columns[s])]);
    first.push_back(least);
    const double wide = double(Index(k) - least + 1);
    operations += wide * wide * D * D * D;
    blocks += wide;
    start.push_back(blocks < double(std::numeric_limits<Index>::max()) ? Index(blocks) : 0);
  }
  return blocks < double(std::numeric_limits<Index>::max()) ? operations : std::numeric_limits<double>::infinity();
}

template <int D>
bool LastLevel::factorShifted(const BlockView<D>& a, double scale, double shift) {
  unknowns = 0;
  values.assign(std::size_t(start.back()) * D * D, 0.0);
  std::vector<Index> place(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) place[std::size_t(order[k])] = Index(k);
  for (Index k = 0; k < Index(order.size()); ++k) {
    auto own = row<D>(values, k);
    const Index node = order[std::size_t(k)], from = first[std::size_t(k)];
    for (Index s = a.start[node]; s < a.start[node + 1]; ++s)
      if (const Index j = place[std::size_t(a.columns[s])]; j <= k)
        own.template middleCols<D>((j - from) * D) = scale * a.block(s);
    if (!factorRow<D>(k, shift)) return false;
  }
  unknowns = D;
  work.assign(order.size() * D, 0.0);
  return true;
}

/// L_kj = (A_kj - sum_i L_ki L_ji^T) L_jj^-T, and the root of what is left of A_kk.
template <int D>
bool LastLevel::factorRow(Index k, double shift) {
  using Square = Eigen::Matrix<double, D, D>;
  auto own = row<D>(values, k);
  const Index from = first[std::size_t(k)];
  for (Index j = from; j <= k; ++j) {
    const auto other = row<D>(values, j);
    const Index other_from = first[std::size_t(j)], begin = std::max(from, other_from), count = (j - begin) * D;
    Square block = own.template middleCols<D>((j - from) * D);
    if (count > 0)
      block.noalias() -=
          own.middleCols((begin - from) * D, count) * other.middleCols((begin - other_from) * D, count).transpose();
    if (j < k) {
      const Square diagonal = other.template rightCols<D>();
      diagonal.template triangularView<Eigen::Lower>().transpose().template solveInPlace<Eigen::OnTheRight>(block);
    } else {
      block.diagonal().array() += shift;
      const Eigen::LLT<Square> root(block);
      if (root.info() != Eigen::Success || !block.allFinite()) return false;
      block = root.matrixL();
    }
    own.template middleCols<D>((j - from) * D) = block;
  }
  return true;
}

template <int D>
void LastLevel::solve(const float* b, float* x) {
  using Few = Eigen::Matrix<double, D, 1>;
  using Given = Eigen::Matrix<float, D, 1>;
  const auto& numbers = values;
  Eigen::Map<Eigen::VectorXd> y(work.data(), Eigen::Index(work.size()));
  const Index count = Index(order.size());
  for (Index k = 0; k < count; ++k) {
    const auto own = row<D>(numbers, k);
    const Index from = first[std::size_t(k)] * D, before = k * D - from;
    Few right = Eigen::Map<const Given>(b + std::size_t(order[std::size_t(k)]) * lanes<D>).template cast<double>();
    right.noalias() -= own.leftCols(before) * y.segment(from, before);
    own.template rightCols<D>().template triangularView<Eigen::Lower>().solveInPlace(right);
    y.template segment<D>(k * D) = right;
  }
  for (Index k = count - 1; k >= 0; --k) {
    const auto own = row<D>(numbers, k);
    const Index from = first[std::size_t(k)] * D, before = k * D - from;
    Few now = y.template segment<D>(k * D);
    own.template rightCols<D>().template triangularView<Eigen::Lower>().transpose().solveInPlace(now);
    y.segment(from, before).noalias() -= own.leftCols(before).transpose() * now;
    float* const to = x + std::size_t(order[std::size_t(k)]) * lanes<D>;
    std::fill_n(to, lanes<D>, 0.0f);
    Eigen::Map<Given>(to, D) = now.template cast<float>();
  }
}

// In multigrid_factors.cpp.
extern template double LastLevel::layOut(const BlockView<3>&);
extern template double LastLevel::layOut(const BlockView<modes>&);
extern template bool LastLevel::factorShifted(const BlockView<3>&, double, double);
extern template bool LastLevel::factorShifted(const BlockView<modes>&, double, double);
extern template void LastLevel::solve<3>(const float*, float*);
extern template void LastLevel::solve<modes>(const float*, float*);

}  // namespace stroma::amg
