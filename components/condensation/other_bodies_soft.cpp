// SPDX-License-Identifier: LGPL-2.1-or-later
// Soft bodies beside condensed ones: their rows, with the linear solver of their integrator.
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstdint>

#include "components/condensation/other_bodies.h"
#include "framework/scene/archive.h"

namespace stroma {
namespace {

/// Of all bits, so that equal sums stand for equal values.
std::uint64_t checksum(const std::vector<double>& values) {
  std::uint64_t sum = 14695981039346656037u;
  for (const double value : values) {
    sum = (sum ^ std::bit_cast<std::uint64_t>(value)) * 1099511628211u;
    sum ^= sum >> 29;
  }
  return sum;
}

}  // namespace

/// The rows of one cluster.
class OtherBodies::Matrix final : public SystemMatrix {
 public:
  Matrix(const System& system, std::vector<Index> rows, BlockPattern&& pattern, bool is_symmetric)
      : system_(system), rows_(std::move(rows)), matrix_(std::move(pattern)), is_symmetric_(is_symmetric) {}
  MatrixKey key() const override { return {identity().get(), 0, values_}; }
  Index rows() const override { return Index(rows_.size()); }
  void multiply(ConstRows p, Rows out) const override { matrix_.multiply(p, out); }
  const BlockMatrix& assemble() override { return matrix_; }
  void diagonalBlocks(std::vector<double>& blocks) const override {
    blocks.resize(9 * rows_.size());
    for (std::size_t i = 0; i < rows_.size(); ++i)
      std::copy_n(matrix_.values().data() + 9 * std::size_t(matrix_.diagonal()[i]), 9, blocks.data() + 9 * i);
  }
  bool symmetric() const override { return is_symmetric_; }
  bool prefersAssembled(int) const override { return true; }
  bool hasTurns() const override {
    return std::ranges::any_of(rows_, [this](Index row) { return system_.motion().kindOf(row) == RowKind::turn; });
  }
  std::string describeRow(Index row) const override { return system_.actors().describeRow(rows_[std::size_t(row)]); }

  /// The values of these rows of a matrix of all. Their checksum is their revision: a counter would be wrong after a return to a
  /// checkpoint, because a solver may still have factors of a later revision.
  void take(const BlockMatrix& all) {
    auto own = matrix_.values().begin();
    for (const Index row : rows_) {
      const auto begin = all.values().begin() + 9 * std::ptrdiff_t(all.rowStart()[std::size_t(row)]);
      const auto end = all.values().begin() + 9 * std::ptrdiff_t(all.rowStart()[std::size_t(row) + 1]);
      own = std::copy(begin, end, own);
    }
    values_ = long(checksum(matrix_.values()));
  }

 private:
  const System& system_;
  std::vector<Index> rows_;  ///< of the system, ascending
  BlockMatrix matrix_;
  bool is_symmetric_;
  long values_ = 0;
};

/// Clusters of soft bodies, and others too large for an inverse of their own.
void OtherBodies::makeLarge(const System& system, Cluster& cluster) const {
  constexpr std::size_t most_small = 16;
  if (cluster.rows.size() <= most_small) return;
  for (const auto& [state, solver] : solvers_) {  // the first soft body of it decides
    const auto isOf = [&](Index k) {
      const Index local = rows_[std::size_t(k)] - state->firstRow();
      return local >= 0 && local < state->size();
    };
    if (!cluster.solver && std::ranges::any_of(cluster.rows, isOf)) cluster.solver = solver;
  }
  if (!cluster.solver) return;  // frames alone
  const BlockMatrix& all = assembled_->pattern();
  BlockPattern pattern(Index(cluster.rows.size()));
  std::vector<Index> rows;
  for (const Index k : cluster.rows) {
    const Index row = rows_[std::size_t(k)];
    rows.push_back(row);
    for (Index s = all.rowStart()[std::size_t(row)]; s < all.rowStart()[std::size_t(row) + 1]; ++s)
      pattern.addBlock(place_in_[std::size_t(k)], place_in_[std::size_t(number_[std::size_t(all.columns()[std::size_t(s)])])]);
  }
  cluster.matrix = std::make_shared<Matrix>(system, std::move(rows), std::move(pattern), isSymmetric());
}

bool OtherBodies::isSymmetric() const {
  return std::ranges::all_of(fields_, [](const ForceField* field) {
    const ForceTraits traits = field->traits();
    return traits.symmetric || !(traits.has_stiffness || traits.velocity_dependent);
  });
}

void OtherBodies::checkSolvers() const {
  for (const auto& [state, solver] : solvers_) {
    if (!solver)
      throw ComponentError(fmt::format("{} is a soft body beside condensed ones, and its integrator has no linear solver", state->path()),
                           "a linear solver beside the integrator of this body",
                           "<EulerImplicitSolver/> and <SparseLDLSolver/> in its node");
    if (solver->needsSymmetric() && !isSymmetric())
      throw ComponentError(
          fmt::format("{} solves symmetric systems only, and the matrix of {} is not symmetric", solver->path(), state->path()),
          "a solver for unsymmetric matrices");
  }
}

void OtherBodies::reset() {
  is_inverted_ = false;
  for (Cluster& cluster : clusters_) cluster.columns.clear();
}

void OtherBodies::serialize(Archive& archive) {
  for (std::size_t i = 0; i < clusters_.size(); ++i) {
    Cluster& cluster = clusters_[i];
    if (!cluster.matrix) continue;
    archive.enter(fmt::format("{}:cluster {}", cluster.solver->path(), i));
    cluster.solver->serializeFor(*cluster.matrix, archive);
    if (archive.isReading()) cluster.columns.clear();
  }
}

void OtherBodies::takeValues(Cluster& cluster, const BlockMatrix& matrix) const {
  cluster.matrix->take(matrix);
  cluster.columns.clear();  // kept ones would have bits that a run from a checkpoint does not have, as of factors in single precision
}

bool OtherBodies::solve(Cluster& cluster, const std::vector<ConstRows>& right, const std::vector<Rows>& solutions) {
  for (const Rows& each : solutions) clear(each);
  const SolveReport report = cluster.solver->solveAll(*cluster.matrix, right, solutions, {.stop = stop_});
  solved_.add(report);
  if (report.usable() && report.stop != SolveStop::breakdown) return true;
  fault_ = fmt::format("the linear solver {} {}", cluster.solver->path(), stroma::describe(report.stop));
  return false;
}

void OtherBodies::addTo(StepReport& report) const {
  if (solved_.stop == SolveStop::zero_right_side) return;
  report.linear_iterations += solved_.iterations;
  report.linear_residual = solved_.relative_residual;
  report.linear_stop = solved_.stop;
  report.linear_at_limit = solved_.stop == SolveStop::iteration_limit || solved_.stop == SolveStop::stagnated;
  report.linear_converged = solved_.stop == SolveStop::converged;
}

bool OtherBodies::findFreeChange(Cluster& cluster) {
  const Index rows = Index(cluster.rows.size());
  Vector right(rows), change(rows);
  for (Index i = 0; i < rows; ++i) {
    const auto k = std::size_t(cluster.rows[std::size_t(i)]);
    right[i] = h_ * (projectors_[k] * force_[rows_[k]]);
  }
  if (!solve(cluster, {ConstRows(right)}, {Rows(change)})) return false;
  for (Index i = 0; i < rows; ++i) {
    const auto k = std::size_t(cluster.rows[std::size_t(i)]);
    free_change_[k] = projectors_[k] * change[i];
  }
  return true;
}

void OtherBodies::load(Index k) {
  if (loads_.empty() || loads_[std::size_t(k)] || !clusters_[cluster_of_[std::size_t(k)]].matrix) return;
  loads_[std::size_t(k)] = 1, new_loads_.push_back(k);
}

bool OtherBodies::solveColumns() {
  last_loads_.swap(new_loads_), new_loads_.clear();
  for (Cluster& cluster : clusters_) {
    if (last_loads_.empty() || !cluster.matrix) continue;
    const Index rows = Index(cluster.rows.size());
    std::vector<Vector> loads;
    std::vector<Rows> solutions;
    for (const Index k : last_loads_) {
      if (&clusters_[cluster_of_[std::size_t(k)]] != &cluster) continue;
      std::array<Vector, 3>& columns = cluster.columns[k];
      for (std::size_t c = 0; c < 3; ++c) {
        columns[c].resize(rows), loads.emplace_back(rows);
        clear(loads.back());
        loads.back()[place_in_[std::size_t(k)]] = projectors_[std::size_t(k)].col(Eigen::Index(c));
        solutions.push_back(columns[c]);
      }
    }
    const std::vector<ConstRows> right(loads.begin(), loads.end());
    if (!right.empty() && !solve(cluster, right, solutions)) return false;
  }
  return true;
}

}  // namespace stroma
