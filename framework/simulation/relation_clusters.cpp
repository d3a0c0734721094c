// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/simulation/relation_clusters.h"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>

#include "framework/simulation/held_size.h"

namespace stroma {

namespace {

/// What a projector leaves of a coefficient that it takes away, relative to it.
constexpr double projector_round_off = 1e-12;
/// A relation of length one that adds less than this to others follows from them.
constexpr double least_independent = 1e-10;

void gather(ConstRows vector, const std::vector<Index>& rows, Eigen::Ref<Eigen::VectorXd> out) {
  for (std::size_t i = 0; i < rows.size(); ++i) out.segment<3>(3 * Eigen::Index(i)) = vector[rows[i]];
}

void subtract(const Eigen::Ref<const Eigen::VectorXd>& change, const std::vector<Index>& rows, Rows vector) {
  for (std::size_t i = 0; i < rows.size(); ++i) vector[rows[i]] -= change.segment<3>(3 * Eigen::Index(i));
}

/// vector -= along N vector, in the rows of a cluster; `of_rows` and `of_basis` are work space.
template <class Along>
void takeAway(const Eigen::MatrixXd& basis, const Along& along, const std::vector<Index>& rows, Eigen::Ref<Eigen::VectorXd> of_rows,
              Eigen::Ref<Eigen::VectorXd> of_basis, Rows vector) {
  gather(vector, rows, of_rows);
  of_basis.noalias() = basis * of_rows;
  of_rows.noalias() = along * of_basis;
  subtract(of_rows, rows, vector);
}

/// See held_size.h; beside the diagonal blocks of these rows.
template <class SlotOf>
double heldBeside(std::vector<double>& blocks, const std::vector<Index>& rows, const SlotOf& slotOf) {
  double sum = 0;
  for (const Index row : rows) sum += diagonalSize(blockAt(blocks, slotOf(row)));
  return heldSize(sum / double(rows.size()));
}

Vec3 displacement(const LinearRelations::Term& term, ConstRows x) { return x[term.row] - term.rest; }

}  // namespace

void RelationClusters::set(const LinearRelations& relations, const std::vector<NodeProjector>& projectors, const NodeGroups& groups,
                           const std::vector<double>& inverse_mass) {
  relations_ = relations;
  clusters_.clear();
  if (empty()) return;
  Index rows = 0;
  for (const LinearRelations::Term& term : relations_.terms) {
    const Index group = groups.of(term.row);
    rows = std::max({rows, term.row + 1, group < 0 ? 0 : *(groups.end(group) - 1) + 1});
  }
  std::vector<FreeTerm> terms = freeTerms(projectors, groups);
  std::vector<double> squares(std::size_t(relations_.count()), 0.0);
  for (const FreeTerm& term : terms) squares[std::size_t(term.relation)] += term.coefficients.squaredNorm();
  lengths_.clear();
  for (const double square : squares) lengths_.push_back(std::sqrt(square));
  for (FreeTerm& term : terms) term.coefficients /= lengths_[std::size_t(term.relation)];
  makeClusters(terms, rows);
  std::size_t most_rows = 0, most_relations = 0;
  for (Cluster& cluster : clusters_) {
    factorise(cluster, terms, inverse_mass);
    most_rows = std::max(most_rows, cluster.rows.size());
    most_relations = std::max(most_relations, cluster.relations.size());
  }
  gathered_.resize(3 * Eigen::Index(most_rows));
  for (Eigen::VectorXd* vector : {&reduced_, &off_}) vector->resize(Eigen::Index(most_relations));
}

// By relation, rows in the order of the terms.
std::vector<RelationClusters::FreeTerm> RelationClusters::freeTerms(const std::vector<NodeProjector>& projectors,
                                                                    const NodeGroups& groups) const {
  std::vector<FreeTerm> terms;
  const auto projectorOf = [&projectors](Index row) -> Mat3 {
    const auto at = std::lower_bound(projectors.begin(), projectors.end(), row,
                                     [](const NodeProjector& held, Index wanted) { return held.row < wanted; });
    return at != projectors.end() && at->row == row ? at->projector : Mat3::Identity();
  };
  for (Index relation = 0; relation < relations_.count(); ++relation)
    for (auto term = relations_.begin(relation); term != relations_.end(relation); ++term) {
      const Vec3 free = projectorOf(term->row) * term->coefficients;
      if (!(free.norm() > projector_round_off * term->coefficients.norm())) continue;
      const Index group = groups.of(term->row);
      if (group < 0) {
        terms.push_back({relation, term->row, free});
      } else {
        for (const Index* row = groups.begin(group); row != groups.end(group); ++row)
          terms.push_back({relation, *row, free / double(groups.size(group))});
      }
    }
  return terms;
}

void RelationClusters::makeClusters(const std::vector<FreeTerm>& terms, Index rows) {
  std::vector<Index> lowest(std::size_t(rows), 0);
  std::iota(lowest.begin(), lowest.end(), 0);
  const auto root = [&lowest](Index row) {
    while (lowest[std::size_t(row)] != row) row = lowest[std::size_t(row)];
    return row;
  };
  for (std::size_t i = 1; i < terms.size(); ++i) {
    if (terms[i].relation != terms[i - 1].relation) continue;
    const Index a = root(terms[i].row), b = root(terms[i - 1].row);
    lowest[std::size_t(std::max(a, b))] = std::min(a, b);
  }
  std::vector<Index> cluster_of_root(std::size_t(rows), -1);
  for (const FreeTerm& term : terms) {
    Index& number = cluster_of_root[std::size_t(root(term.row))];
    if (number < 0) number = Index(clusters_.size()), clusters_.emplace_back();
    Cluster& cluster = clusters_[std::size_t(number)];
    cluster.rows.push_back(term.row);
    if (cluster.relations.empty() || cluster.relations.back() != term.relation) cluster.relations.push_back(term.relation);
  }
  for (Cluster& cluster : clusters_) {
    std::sort(cluster.rows.begin(), cluster.rows.end());
    cluster.rows.erase(std::unique(cluster.rows.begin(), cluster.rows.end()), cluster.rows.end());
  }
}

// (C Q)^T Pi = N^T R by a rank-revealing QR. Relations beyond the rank follow from the others.
void RelationClusters::factorise(Cluster& cluster, const std::vector<FreeTerm>& terms, const std::vector<double>& inverse_mass) const {
  const Eigen::Index directions = 3 * Eigen::Index(cluster.rows.size()), count = Eigen::Index(cluster.relations.size());
  Eigen::MatrixXd transposed = Eigen::MatrixXd::Zero(directions, count);
  for (Eigen::Index column = 0; column < count; ++column) {
    const auto byRelation = [](const FreeTerm& a, const FreeTerm& b) { return a.relation < b.relation; };
    const FreeTerm wanted{cluster.relations[std::size_t(column)], 0, Vec3::Zero()};
    const auto [first, last] = std::equal_range(terms.begin(), terms.end(), wanted, byRelation);
    for (auto term = first; term != last; ++term) {
      const auto at = std::lower_bound(cluster.rows.begin(), cluster.rows.end(), term->row);
      transposed.block<3, 1>(3 * (at - cluster.rows.begin()), column) += term->coefficients;
    }
  }
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(transposed);
  Eigen::Index rank = 0;
  while (rank < std::min(directions, count) && std::abs(qr.matrixQR()(rank, rank)) > least_independent) ++rank;
  Eigen::MatrixXd columns = Eigen::MatrixXd::Identity(directions, rank);
  columns = qr.householderQ() * columns;
  cluster.basis = columns.transpose();

  Eigen::VectorXd weights = Eigen::VectorXd::Zero(directions);
  if (!inverse_mass.empty())
    for (Eigen::Index i = 0; i < directions; ++i) weights[i] = inverse_mass[std::size_t(cluster.rows[std::size_t(i / 3)])];
  if (!(weights.minCoeff() > 0)) weights.setOnes();
  const Eigen::MatrixXd weighted = weights.asDiagonal() * columns;
  cluster.along = weighted * (cluster.basis * weighted).llt().solve(Eigen::MatrixXd::Identity(rank, rank));

  // the first `rank` relations of the order of Pi give R^T (N u) = C u
  Eigen::MatrixXd chosen = Eigen::MatrixXd::Zero(rank, count);
  for (Eigen::Index i = 0; i < rank; ++i) {
    const Eigen::Index relation = qr.colsPermutation().indices()[i];
    chosen(i, relation) = 1 / lengths_[std::size_t(cluster.relations[std::size_t(relation)])];
  }
  qr.matrixQR().topLeftCorner(rank, rank).triangularView<Eigen::Upper>().transpose().solveInPlace(chosen);
  cluster.correction = cluster.along * chosen;
}

Index RelationClusters::heldDirections() const {
  return std::accumulate(clusters_.begin(), clusters_.end(), Index(0),
                         [](Index sum, const Cluster& cluster) { return sum + Index(cluster.basis.rows()); });
}

void RelationClusters::project(Rows vector) const {
  for (const Cluster& cluster : clusters_)
    takeAway(cluster.basis, cluster.basis.transpose(), cluster.rows, gathered_.head(cluster.basis.cols()),
             reduced_.head(cluster.basis.rows()), vector);
}

void RelationClusters::projectAcceleration(Rows a) const {
  for (const Cluster& cluster : clusters_)
    takeAway(cluster.basis, cluster.along, cluster.rows, gathered_.head(cluster.basis.cols()), reduced_.head(cluster.basis.rows()), a);
}

template <class Value>
void RelationClusters::correct(Rows vector, const Value& valueOf) const {
  for (const Cluster& cluster : clusters_) {
    auto off = off_.head(Eigen::Index(cluster.relations.size()));
    off.setZero();
    for (Eigen::Index i = 0; i < off.size(); ++i) {
      const Index relation = cluster.relations[std::size_t(i)];
      for (auto term = relations_.begin(relation); term != relations_.end(relation); ++term)
        off[i] += term->coefficients.dot(valueOf(*term));
    }
    auto of_rows = gathered_.head(cluster.basis.cols());
    of_rows.noalias() = cluster.correction * off;
    subtract(of_rows, cluster.rows, vector);
  }
}

void RelationClusters::correctVelocities(Rows v) const {
  correct(v, [v](const LinearRelations::Term& term) { return Vec3(v[term.row]); });
}

void RelationClusters::correctPositions(Rows x) const {
  correct(x, [x](const LinearRelations::Term& term) { return displacement(term, x); });
}

RelationClusters::Violation RelationClusters::worst(ConstRows x) const {
  Violation worst;
  for (Index relation = 0; relation < relations_.count(); ++relation) {
    double off = 0, square = 0;
    for (auto term = relations_.begin(relation); term != relations_.end(relation); ++term) {
      off += term->coefficients.dot(displacement(*term, x));
      square += term->coefficients.squaredNorm();
    }
    const double distance = std::abs(off) / std::sqrt(square);
    if (worst.relation < 0 || distance > worst.distance) worst = {relation, distance};
  }
  return worst;
}

void RelationClusters::addTies(std::vector<Tie>& ties) const {
  for (const Cluster& cluster : clusters_)
    for (std::size_t i = 1; i < cluster.rows.size(); ++i) ties.push_back({cluster.rows[i - 1], cluster.rows[i]});
}

// The rows of a cluster have blocks in the same columns, and the pattern is symmetric: addTies() saw to it.
void RelationClusters::eliminate(BlockMatrix& matrix) const {
  std::vector<double>& values = matrix.values();
  Eigen::MatrixXd stacked, reduced;
  for (const Cluster& cluster : clusters_) {
    const Eigen::Index count = Eigen::Index(cluster.rows.size());
    const double held = heldBeside(values, cluster.rows, [&matrix](Index row) { return matrix.diagonal()[std::size_t(row)]; });
    const auto startOf = [&](Eigen::Index i) { return matrix.rowStart()[std::size_t(cluster.rows[std::size_t(i)])]; };
    const Eigen::Index blocks = matrix.rowStart()[std::size_t(cluster.rows[0]) + 1] - startOf(0);
    stacked.resize(3 * count, 3);
    for (Eigen::Index k = 0; k < blocks; ++k) {  // from the left
      for (Eigen::Index i = 0; i < count; ++i) stacked.middleRows<3>(3 * i) = blockAt(values, startOf(i) + Index(k));
      reduced.noalias() = cluster.basis * stacked;
      stacked.noalias() -= cluster.basis.transpose() * reduced;
      for (Eigen::Index i = 0; i < count; ++i) blockAt(values, startOf(i) + Index(k)) = stacked.middleRows<3>(3 * i);
    }
    const std::vector<Index> neighbours(matrix.columns().begin() + startOf(0), matrix.columns().begin() + startOf(0) + blocks);
    for (const Index row : neighbours) {  // from the right, as the transpose from the left
      for (Eigen::Index i = 0; i < count; ++i)
        stacked.middleRows<3>(3 * i) = blockAt(values, matrix.slot(row, cluster.rows[std::size_t(i)])).transpose();
      reduced.noalias() = cluster.basis * stacked;
      stacked.noalias() -= cluster.basis.transpose() * reduced;
      for (Eigen::Index i = 0; i < count; ++i)
        blockAt(values, matrix.slot(row, cluster.rows[std::size_t(i)])) = stacked.middleRows<3>(3 * i).transpose();
    }
    for (Eigen::Index i = 0; i < count; ++i)
      for (Eigen::Index j = 0; j < count; ++j)
        matrix.add(cluster.rows[std::size_t(i)], cluster.rows[std::size_t(j)],
                   held * cluster.basis.middleCols<3>(3 * i).transpose() * cluster.basis.middleCols<3>(3 * j));
  }
}

// Of P A P for a block diagonal A only what a row has of its own: enough for a preconditioner.
void RelationClusters::eliminateDiagonal(std::vector<double>& blocks) const {
  for (const Cluster& cluster : clusters_) {
    const double held = heldBeside(blocks, cluster.rows, [](Index row) { return row; });
    for (std::size_t i = 0; i < cluster.rows.size(); ++i) {
      const Mat3 taken = cluster.basis.middleCols<3>(3 * Eigen::Index(i)).transpose() * cluster.basis.middleCols<3>(3 * Eigen::Index(i));
      const Mat3 free = Mat3::Identity() - taken;
      auto block = blockAt(blocks, cluster.rows[i]);
      block = (free * block * free + held * taken).eval();
    }
  }
}

}  // namespace stroma
