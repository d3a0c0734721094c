// SPDX-License-Identifier: LGPL-2.1-or-later
// Smoothed aggregation: the prolongation of a level and the matrix of the next one. Inline for the reason given in
// vector.h.
#pragma once
#include "components/iterative_solvers/multigrid_build.h"

namespace stroma::amg {

/// The motions of each group as an orthonormal basis: `basis` of its nodes, and in it those motions again, shape (groups,
/// 6, 6). A motion that the nodes of a group cannot tell from others gets a column of zeros.
template <int D>
void orthonormalise(const Aggregates& groups, const Motions<D>& motions, Motions<D>& basis, Motions<modes>& coarse) {
  basis.resize(groups.of.size());
  coarse.resize(std::size_t(groups.count()));
  forPieces(groups.count(), piecesOf(groups.count()), [&](int, Index first, Index last) {
    Eigen::Matrix<double, Eigen::Dynamic, modes> all, q;
    for (Index k = first; k < last; ++k) {
      const Index start = groups.start[std::size_t(k)], count = groups.start[std::size_t(k) + 1] - start;
      all.resize(count * D, modes);
      for (Index m = 0; m < count; ++m)
        all.template middleRows<D>(m * D) = motions.at(groups.members[std::size_t(start + m)]);
      q = all;
      for (int c = 0; c < modes; ++c) {
        const double before = q.col(c).norm();
        for (int again = 0; again < 2; ++again)
          for (int e = 0; e < c; ++e) q.col(c) -= q.col(e).dot(q.col(c)) * q.col(e);
        const double after = q.col(c).norm();
        if (after > 1e-9 * before && before > 0)
          q.col(c) /= after;
        else
          q.col(c).setZero();
      }
      coarse.at(k).noalias() = q.transpose() * all;
      for (Index m = 0; m < count; ++m)
        basis.at(groups.members[std::size_t(start + m)]) = q.template middleRows<D>(m * D);
    }
  });
}

/// The groups that a row of A touches, each once.
template <int D>
void groupsOfRow(const BlockView<D>& a, const Aggregates& groups, Index row, std::vector<Index>& found) {
  found.clear();
  for (Index s = a.start[row]; s < a.start[row + 1]; ++s) {
    const Index group = groups.of[std::size_t(a.columns[s])];
    if (group < 0 || std::find(found.begin(), found.end(), group) != found.end()) continue;
    if (a.columns[s] == row || (a.block(s).array() != 0).any()) found.push_back(group);
  }
}

/// level.p = (I - w D^-1 A) basis, w = 4/3 over `largest`, the largest eigenvalue of D^-1 A.
template <int D>
void smoothBasis(const BlockView<D>& a, const Aggregates& groups, const Motions<D>& basis, double scale, double largest,
                 Level<D>& level) {
  auto& p = level.p;
  p.start.assign(std::size_t(a.rows) + 1, 0);
  const int pieces = piecesOf(a.rows);
  forPieces(a.rows, pieces, [&](int, Index first, Index last) {
    std::vector<Index> found;
    for (Index i = first; i < last; ++i) {
      groupsOfRow(a, groups, i, found);
      p.start[std::size_t(i) + 1] = Index(found.size());
    }
  });
  for (std::size_t i = 0; i < std::size_t(a.rows); ++i) p.start[i + 1] += p.start[i];
  p.columns.resize(std::size_t(p.start.back()));
  p.allocateValues();
  const double weight = largest > 0 ? 4 / (3 * largest) : 0;
  using Square = Eigen::Matrix<double, D, D>;
  using Tall = Eigen::Matrix<double, D, modes>;
  forPieces(a.rows, pieces, [&](int, Index first, Index last) {
    std::vector<Index> found;
    std::vector<Tall> sums;
    for (Index i = first; i < last; ++i) {
      groupsOfRow(a, groups, i, found);
      sums.assign(found.size(), Tall::Zero());
      for (Index s = a.start[i]; s < a.start[i + 1]; ++s) {
        const Index j = a.columns[s], group = groups.of[std::size_t(j)];
        if (group < 0) continue;
        const auto at = std::find(found.begin(), found.end(), group);
        if (at != found.end()) sums[std::size_t(at - found.begin())].noalias() += a.block(s) * basis.at(j);
      }
      const Square divide =
          (weight * scale) * Eigen::Map<const Eigen::Matrix<float, D, D>>(level.inverse.data() + std::size_t(i) * D * D)
                                 .template cast<double>();
      for (std::size_t k = 0; k < found.size(); ++k) {
        const Index slot = p.start[std::size_t(i)] + Index(k);
        p.columns[std::size_t(slot)] = found[k];
        Tall value = -divide * sums[k];
        if (found[k] == groups.of[std::size_t(i)]) value += basis.at(i);
        Eigen::Map<Eigen::Matrix<float, D, modes>>(p.at(slot)) = value.template cast<float>();
      }
    }
  });
}

/// level.r = level.p^T
template <int D>
void transposeProlongation(Level<D>& level, Index groups) {
  const auto& p = level.p;
  auto& r = level.r;
  r.start.assign(std::size_t(groups) + 1, 0);
  for (const Index column : p.columns) ++r.start[std::size_t(column) + 1];
  for (std::size_t k = 0; k < std::size_t(groups); ++k) r.start[k + 1] += r.start[k];
  r.columns.resize(p.columns.size());
  std::vector<Index> next(r.start.begin(), r.start.end()), source(p.columns.size());
  for (Index i = 0; i < p.rows(); ++i)
    for (Index s = p.start[std::size_t(i)]; s < p.start[std::size_t(i) + 1]; ++s) {
      const Index slot = next[std::size_t(p.columns[std::size_t(s)])]++;
      r.columns[std::size_t(slot)] = i;
      source[std::size_t(slot)] = s;
    }
  r.allocateValues();
  forRows(r.blocks(), [&](Index slot) {
    Eigen::Map<Eigen::Matrix<float, modes, D>>(r.at(slot)) =
        Eigen::Map<const Eigen::Matrix<float, D, modes>>(p.at(source[std::size_t(slot)])).transpose();
  });
}

/// Rows of P^T A P from the diagonal on, one after the other: P as it was rounded, sums in double precision. With the work
/// space of one thread.
template <int D>
class GalerkinRows {
 public:
  GalerkinRows(const BlockView<D>& a, const Level<D>& level)
      : a_(a), level_(level), place_(std::size_t(a.rows), -1), group_place_(std::size_t(level.r.rows()), -1) {}

  void makeRow(Index row) {
    multiplyFromLeft(row);
    multiplyFromRight(row);
    for (const Index j : nodes_) place_[std::size_t(j)] = -1;
    for (const Index group : groups_) group_place_[std::size_t(group)] = -1;
  }
  const std::vector<Index>& groups() const { return groups_; }
  /// Of the row, shape (groups, 6, 6), column-major.
  const std::vector<double>& blocks() const { return products_; }

 private:
  static Index placeIn(std::vector<Index>& list, Index what, Index& place, std::vector<double>& sums,
                       std::size_t size) {
    if (place >= 0) return place;
    place = Index(list.size());
    list.push_back(what);
    sums.resize(sums.size() + size, 0.0);
    return place;
  }
  /// left_ = row of P^T A, as columns of six for each node in nodes_.
  void multiplyFromLeft(Index row) {
    nodes_.clear(), left_.clear();
    const auto& r = level_.r;
    for (Index q = r.start[std::size_t(row)]; q < r.start[std::size_t(row) + 1]; ++q) {
      const Index i = r.columns[std::size_t(q)];
      Six rows[D];
      for (int k = 0; k < D; ++k) rows[k].load(r.at(q) + k * modes);
      for (Index s = a_.start[i]; s < a_.start[i + 1]; ++s) {
        const Index j = a_.columns[s];
        const Index at = placeIn(nodes_, j, place_[std::size_t(j)], left_, D * modes);
        double* sum = left_.data() + std::size_t(at) * D * modes;
        const double* block = a_.values + std::size_t(s) * D * D;
        for (int c = 0; c < D; ++c) {
          Six column;
          column.load(sum + c * modes);
          for (int k = 0; k < D; ++k) column.add(block[k * D + c], rows[k]);
          column.store(sum + c * modes);
        }
      }
    }
  }
  /// products_ = left_ P
  void multiplyFromRight(Index row) {
    groups_.clear(), products_.clear();
    const auto& p = level_.p;
    for (std::size_t n = 0; n < nodes_.size(); ++n) {
      const std::size_t j = std::size_t(nodes_[n]);
      Six columns[D];
      for (int c = 0; c < D; ++c) columns[c].load(left_.data() + (n * D + std::size_t(c)) * modes);
      for (Index s = p.start[j]; s < p.start[j + 1]; ++s) {
        const Index group = p.columns[std::size_t(s)];
        if (group < row) continue;
        const Index at = placeIn(groups_, group, group_place_[std::size_t(group)], products_, modes * modes);
        double* sum = products_.data() + std::size_t(at) * modes * modes;
        const float* right = p.at(s);
        for (int b = 0; b < modes; ++b) {
          Six column;
          column.load(sum + b * modes);
          for (int c = 0; c < D; ++c) column.add(double(right[b * D + c]), columns[c]);
          column.store(sum + b * modes);
        }
      }
    }
  }

  const BlockView<D>& a_;
  const Level<D>& level_;
  std::vector<Index> place_, group_place_;  ///< of a node in nodes_, of a group in groups_; -1: not there
  std::vector<Index> nodes_, groups_;
  std::vector<double> left_, products_;
};

/// What no node of a group moves with has no stiffness: it gets the mean of the others.
inline void completeDiagonal(double* block) {
  double sum = 0;
  int count = 0;
  for (int k = 0; k < modes; ++k)
    if (block[7 * k] != 0) sum += block[7 * k], ++count;
  for (int k = 0; k < modes; ++k)
    if (block[7 * k] == 0) block[7 * k] = count > 0 ? sum / count : 1;
}

/// Rows of a symmetric matrix from the diagonal on, made in pieces.
struct UpperRows {
  Index first = 0;
  std::vector<Index> counts, columns;
  std::vector<double> values;        ///< shape (blocks, 6, 6), column-major
  std::vector<Index> own, mirrored;  ///< slots of the blocks in the whole matrix, see giveSlots()
};

/// The pattern of the whole matrix: in a row those of the rows above first, then its own in their order.
inline void giveSlots(std::vector<UpperRows>& pieces, CoarseMatrix& coarse) {
  const auto forEach = [&pieces](auto&& visit) {
    for (UpperRows& piece : pieces) {
      std::size_t at = 0;
      for (std::size_t k = 0; k < piece.counts.size(); ++k)
        for (Index m = 0; m < piece.counts[k]; ++m, ++at) visit(piece, at, piece.first + Index(k), piece.columns[at]);
    }
  };
  forEach([&](UpperRows&, std::size_t, Index i, Index j) {
    ++coarse.start[std::size_t(i) + 1];
    if (i != j) ++coarse.start[std::size_t(j) + 1];
  });
  for (std::size_t i = 0; i < coarse.diagonal.size(); ++i) coarse.start[i + 1] += coarse.start[i];
  coarse.columns.resize(std::size_t(coarse.start.back()));
  for (UpperRows& piece : pieces) piece.own.resize(piece.columns.size()), piece.mirrored.resize(piece.columns.size());
  std::vector<Index> next(coarse.start.begin(), coarse.start.end());
  forEach([&](UpperRows& piece, std::size_t at, Index i, Index j) {
    const Index own = piece.own[at] = next[std::size_t(i)]++;
    coarse.columns[std::size_t(own)] = j;
    if (i == j) coarse.diagonal[std::size_t(i)] = own;
    const Index mirrored = piece.mirrored[at] = i == j ? own : next[std::size_t(j)]++;
    coarse.columns[std::size_t(mirrored)] = i;
  });
}

inline CoarseMatrix completed(std::vector<UpperRows>& pieces, Index rows) {
  CoarseMatrix coarse;
  coarse.start.assign(std::size_t(rows) + 1, 0);
  coarse.diagonal.resize(std::size_t(rows));
  giveSlots(pieces, coarse);
  coarse.values.resize(coarse.columns.size() * modes * modes);
  const auto block = [&coarse](Index slot) {
    return BlockView<modes>::Block::Map(coarse.values.data() + std::size_t(slot) * modes * modes);
  };
  using Turned = Eigen::Matrix<double, modes, modes>;
  parallelFor(int(pieces.size()), [&](int k) {
    UpperRows& piece = pieces[std::size_t(k)];
    for (std::size_t at = 0; at < piece.columns.size(); ++at) {
      const Eigen::Map<const Turned> from(piece.values.data() + at * modes * modes);
      block(piece.own[at]) = from;
      if (piece.mirrored[at] != piece.own[at]) block(piece.mirrored[at]) = from.transpose();
    }
    piece = {};
  });
  for (const Index slot : coarse.diagonal) completeDiagonal(coarse.values.data() + std::size_t(slot) * modes * modes);
  return coarse;
}

/// P^T A P
template <int D>
CoarseMatrix galerkin(const BlockView<D>& a, const Level<D>& level) {
  const Index rows = level.r.rows();
  const int count = piecesOf(rows);
  std::vector<UpperRows> pieces(std::size_t(count), UpperRows{});
  forPieces(rows, count, [&](int k, Index first, Index last) {
    GalerkinRows<D> maker(a, level);
    UpperRows& piece = pieces[std::size_t(k)];
    piece.first = first;
    for (Index row = first; row < last; ++row) {
      maker.makeRow(row);
      piece.counts.push_back(Index(maker.groups().size()));
      piece.columns.insert(piece.columns.end(), maker.groups().begin(), maker.groups().end());
      piece.values.insert(piece.values.end(), maker.blocks().begin(), maker.blocks().end());
    }
  });
  return completed(pieces, rows);
}

}  // namespace stroma::amg
