// SPDX-License-Identifier: LGPL-2.1-or-later
// Which patches a level gets, if any, and their inverses. Inline for the reason given in vector.h.
#pragma once
#include "components/iterative_solvers/multigrid_build.h"

namespace stroma::amg {

/// The smallest eigenvalue of D^-1 A in a patch, D the diagonal blocks: how much the diagonal blocks see of a motion that
/// ends inside. 0.3 to 0.5 in an ordinary body; with mean dilatation 0.08 at Poisson's ratio 0.49, 0.009 at 0.499, 0.0009 at
/// 0.4999; with that of each point 0.05 at 0.499 and little less beyond.
template <int D>
double leastSeen(const Eigen::MatrixXd& a) {
  const Eigen::Index nodes = a.rows() / D;
  Eigen::MatrixXd scaled = a;
  for (Eigen::Index i = 0; i < nodes; ++i) {
    const Eigen::LLT<Eigen::Matrix<double, D, D>> root(a.block<D, D>(i * D, i * D));
    if (root.info() != Eigen::Success) return 1;
    scaled.middleRows<D>(i * D) = root.matrixL().solve(scaled.middleRows<D>(i * D)).eval();
    scaled.middleCols<D>(i * D) = root.matrixL().solve(scaled.middleCols<D>(i * D).transpose()).transpose().eval();
  }
  const Eigen::LLT<Eigen::MatrixXd> factor(scaled);
  if (factor.info() != Eigen::Success) return 1;
  Eigen::VectorXd v(a.rows());
  for (Eigen::Index i = 0; i < v.size(); ++i) v[i] = 1 + double((i * 7) % 5) - 2;
  double largest = 1;  // of the inverse
  for (int step = 0; step < 12; ++step) {
    v = factor.solve(v / v.norm()).eval();
    largest = v.norm();
  }
  return 1 / largest;
}

/// Makes the patches of a level: around nodes of which no two are neighbours, each with all its neighbours. They reach
/// beyond each other, and each node is in one at least.
template <int D>
class PatchMaker {
 public:
  PatchMaker(const BlockView<D>& a, double scale, Patches<D>& made) : a_(a), scale_(scale), made_(made) {
    made_ = {};
    std::vector<char> covered(std::size_t(a.rows), 0);
    for (Index i = 0; i < a.rows; ++i) {
      if (covered[std::size_t(i)]) continue;
      for (Index s = a.start[i]; s < a.start[i + 1]; ++s) {
        if (a.columns[s] != i && !(a.block(s).array() != 0).any()) continue;
        covered[std::size_t(a.columns[s])] = 1;
        made_.members.push_back(a.columns[s]);
      }
      std::sort(made_.members.begin() + made_.start.back(), made_.members.end());
      made_.start.push_back(Index(made_.members.size()));
    }
    layOut();
  }
  /// The median of leastSeen() of a few that are not small: a held node is a patch of its own.
  double leastSeenUsually() const {
    constexpr std::size_t samples = 9;
    std::vector<Index> large;
    for (Index k = 0; k < made_.count(); ++k)
      if (std::size_t(made_.nodesOf(k)) * std::size_t(made_.count()) >= made_.members.size()) large.push_back(k);
    std::vector<double> seen;
    const std::size_t count = std::min(samples, large.size());
    for (std::size_t k = 0; k < count; ++k) seen.push_back(leastSeen<D>(matrixOf(large[large.size() * k / count])));
    std::nth_element(seen.begin(), seen.begin() + std::ptrdiff_t(count / 2), seen.end());
    return seen[count / 2];
  }
  /// Numbers of the inverses.
  std::size_t numbers() const { return made_.first.back(); }
  /// False: one of them is not definite.
  bool invert() {
    allocate(made_.inverses, numbers());
    std::vector<char> bad(std::size_t(made_.count()), 0);
    parallelFor(int(made_.count()), [&](int k) {
      const Eigen::MatrixXd a = matrixOf(Index(k));
      const Eigen::LLT<Eigen::MatrixXd> factor(a);
      bad[std::size_t(k)] = factor.info() != Eigen::Success;
      if (bad[std::size_t(k)]) return;
      const Eigen::MatrixXd inverse = factor.solve(Eigen::MatrixXd::Identity(a.rows(), a.cols()));
      float* to = made_.inverses.data() + made_.first[std::size_t(k)];
      const int height = Patches<D>::padded(made_.nodesOf(Index(k)));
      for (int column = 0; column < int(a.cols()); ++column)
        for (int row = Patches<D>::firstRow(Index(column) / D); row < height; ++row)
          *to++ = row < column || row >= int(a.rows()) ? 0.0f : float((row == column ? 0.5 : 1) * inverse(row, column));
    });
    return std::find(bad.begin(), bad.end(), 1) == bad.end();
  }

 private:
  void layOut() {
    std::size_t place = 0;
    made_.entry_start.assign(std::size_t(a_.rows) + 1, 0);
    for (const Index node : made_.members) ++made_.entry_start[std::size_t(node) + 1];
    for (std::size_t i = 0; i < std::size_t(a_.rows); ++i) made_.entry_start[i + 1] += made_.entry_start[i];
    made_.entries.resize(made_.members.size());
    std::vector<Index> next(made_.entry_start.begin(), made_.entry_start.end());
    for (Index k = 0; k < made_.count(); ++k) {
      const Index nodes = made_.nodesOf(k);
      const int height = Patches<D>::padded(nodes);
      std::size_t numbers = 0;
      for (Index m = 0; m < nodes; ++m) {
        numbers += std::size_t(D * (height - Patches<D>::firstRow(m)));
        const Index node = made_.members[std::size_t(made_.start[std::size_t(k)] + m)];
        made_.entries[std::size_t(next[std::size_t(node)]++)] = Index(place) + m * D;
      }
      made_.place.push_back(place);
      made_.first.push_back(made_.first.back() + numbers);
      place += 2 * std::size_t(height);
    }
  }
  /// A in a patch, scaled.
  Eigen::MatrixXd matrixOf(Index k) const {
    const Index* begin = made_.members.data() + made_.start[std::size_t(k)];
    const Index* end = made_.members.data() + made_.start[std::size_t(k) + 1];
    Eigen::MatrixXd full = Eigen::MatrixXd::Zero((end - begin) * D, (end - begin) * D);
    for (const Index* i = begin; i != end; ++i)
      for (Index s = a_.start[*i]; s < a_.start[*i + 1]; ++s) {
        const Index* j = std::lower_bound(begin, end, a_.columns[s]);
        if (j != end && *j == a_.columns[s]) full.block<D, D>((i - begin) * D, (j - begin) * D) = scale_ * a_.block(s);
      }
    return full;
  }

  const BlockView<D>& a_;
  double scale_;
  Patches<D>& made_;
};

/// Where the diagonal blocks see less, half of the iterations are left with patches, or fewer.
constexpr double hardly_seen = 0.03;

/// Gives a level patches where its diagonal blocks hardly smooth, or where `wanted`. Returns whether it has some.
template <int D>
bool addPatches(const BlockView<D>& a, double scale, bool wanted, Level<D>& level) {
  constexpr std::size_t most = 16;  // times the numbers of the matrix
  PatchMaker<D> maker(a, scale, level.patches);
  const bool worth = wanted || maker.leastSeenUsually() < hardly_seen;
  if (!worth || maker.numbers() > most * level.a.values.size() || !maker.invert()) level.patches = {};
  level.patches.allocateWork();
  return level.patches.exist();
}

// In multigrid_factors.cpp.
extern template bool addPatches(const BlockView<3>&, double, bool, Level<3>&);
extern template bool addPatches(const BlockView<modes>&, double, bool, Level<modes>&);

}  // namespace stroma::amg
