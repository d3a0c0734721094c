// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/iterative_solvers/mixed_solve.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace stroma {
namespace {

/// K / mu at Poisson's ratio 0.3: that of A.
constexpr double kept_bulk = 2.6 / 1.2;
constexpr Index in_row = 3;

}  // namespace

PressureRows::PressureRows(const VolumeTerms& terms, Index nodes) {
  for (Index c = 0; c < terms.count(); ++c) {
    const double excess = terms.bulk[std::size_t(c)] - kept_bulk * terms.shear[std::size_t(c)];
    if (!(excess > kept_bulk * terms.shear[std::size_t(c)])) continue;
    double size = 0;
    const Index first = terms.start[std::size_t(c)], end = terms.start[std::size_t(c) + 1];
    for (Index e = first; e < end; ++e) size += terms.gradients[std::size_t(e)].squaredNorm();
    if (!(size > 0)) continue;  // all its nodes are held
    for (Index e = first; e < end; ++e)
      if (terms.gradients[std::size_t(e)] != Vec3::Zero()) {
        nodes_.push_back(terms.rows[std::size_t(e)]);
        gradients_.push_back(terms.gradients[std::size_t(e)]);
        volume_of_.push_back(count());
      }
    start_.push_back(Index(nodes_.size()));
    excess_.push_back(excess);
  }
  entry_start_.assign(std::size_t(nodes) + 1, 0);
  for (const Index node : nodes_) ++entry_start_[std::size_t(node) + 1];
  for (std::size_t i = 0; i < std::size_t(nodes); ++i) entry_start_[i + 1] += entry_start_[i];
  entries_.resize(nodes_.size());
  std::vector<Index> next(entry_start_.begin(), entry_start_.end());
  for (std::size_t e = 0; e < nodes_.size(); ++e) entries_[std::size_t(next[std::size_t(nodes_[e])]++)] = Index(e);
  group();
  weighLaplacian();
}

/// l_i: the least E^-1 around a node, over the most that n_i sum up to around a pressure.
void PressureRows::weighLaplacian() {
  laplacian_.assign(entry_start_.size() - 1, 0.0);
  std::vector<double> sums(excess_.size(), 0.0);
  for (std::size_t i = 0; i < laplacian_.size(); ++i) {
    double stiffest = 0;
    for (Index k = entry_start_[i]; k < entry_start_[i + 1]; ++k) {
      const std::size_t c = std::size_t(volume_of_[std::size_t(entries_[std::size_t(k)])]);
      stiffest = std::max(stiffest, excess_[c]);
      sums[c] += entry_start_[i + 1] - entry_start_[i];
    }
    if (stiffest > 0) laplacian_[i] = 1 / stiffest;
  }
  const double most = sums.empty() ? 1 : std::ranges::max(sums);
  for (double& weight : laplacian_) weight /= most;
}

void PressureRows::multiplyByLaplacian(ConstRows p, Rows sums, Rows out) const {
  amg::forRows(sums.count, [&](Index i) {
    double sum = 0;
    for (Index k = entry_start_[std::size_t(i)]; k < entry_start_[std::size_t(i) + 1]; ++k)
      sum += p.data[place_[std::size_t(volume_of_[std::size_t(entries_[std::size_t(k)])])]];
    sums.data[std::size_t(i) * row_doubles] = sum;
  });
  clear(out);
  amg::forRows(count(), [&](Index c) {
    const std::size_t at = place_[std::size_t(c)];
    double sum = 0;
    for (Index e = start_[std::size_t(c)]; e < start_[std::size_t(c) + 1]; ++e) {
      const std::size_t i = std::size_t(nodes_[std::size_t(e)]);
      sum += laplacian_[i] * ((entry_start_[i + 1] - entry_start_[i]) * p.data[at] - sums.data[i * row_doubles]);
    }
    out.data[at] = sum;
  });
}

/// Three volumes to a row: the first one that is left, and those that share most nodes with it.
void PressureRows::group() {
  place_.assign(excess_.size(), 0);
  std::vector<char> placed(excess_.size(), 0);
  std::vector<Index> shared(excess_.size(), 0), near;
  for (Index c = 0; c < count(); ++c) {
    if (placed[std::size_t(c)]) continue;
    near.clear();
    for (Index e = start_[std::size_t(c)]; e < start_[std::size_t(c) + 1]; ++e) {
      const std::size_t node = std::size_t(nodes_[std::size_t(e)]);
      for (Index k = entry_start_[node]; k < entry_start_[node + 1]; ++k) {
        const Index other = volume_of_[std::size_t(entries_[std::size_t(k)])];
        if (other == c || placed[std::size_t(other)]) continue;
        if (shared[std::size_t(other)]++ == 0) near.push_back(other);
      }
    }
    std::ranges::sort(near, [&](Index a, Index b) {
      return shared[std::size_t(a)] != shared[std::size_t(b)] ? shared[std::size_t(a)] > shared[std::size_t(b)] : a < b;
    });
    for (const Index other : near) shared[std::size_t(other)] = 0;
    near.insert(near.begin(), c);
    for (Index k = 0; k < std::min(in_row, Index(near.size())); ++k) {
      placed[std::size_t(near[std::size_t(k)])] = 1;
      place_[std::size_t(near[std::size_t(k)])] = std::size_t(rows_) * row_doubles + std::size_t(k);
    }
    ++rows_;
  }
}

void PressureRows::subtractFrom(BlockMatrix& k) const {
  amg::forRows(k.rows(), [&](Index row) {
    const auto first = k.columns().begin() + k.rowStart()[row], end = k.columns().begin() + k.rowStart()[row + 1];
    for (Index at = entry_start_[std::size_t(row)]; at < entry_start_[std::size_t(row) + 1]; ++at) {
      const std::size_t own = std::size_t(entries_[std::size_t(at)]), c = std::size_t(volume_of_[own]);
      const Vec3 force = -excess_[c] * gradients_[own];
      for (Index e = start_[c]; e < start_[c + 1]; ++e) {
        const auto found = std::lower_bound(first, end, nodes_[std::size_t(e)]);
        if (found != end && *found == nodes_[std::size_t(e)])
          k.add(Index(found - k.columns().begin()), force * gradients_[std::size_t(e)].transpose());
      }
    }
  });
}

BlockMatrix PressureRows::products(const std::vector<Mat3>& inverse) const {
  const Index nodes = Index(inverse.size());
  BlockPattern pattern(rows_);
  std::vector<Index> around;
  for (std::size_t i = 0; i < std::size_t(nodes); ++i) {
    around.clear();
    for (Index k = entry_start_[i]; k < entry_start_[i + 1]; ++k)
      around.push_back(Index(place_[std::size_t(volume_of_[std::size_t(entries_[std::size_t(k)])])] / row_doubles));
    std::ranges::sort(around);
    around.erase(std::unique(around.begin(), around.end()), around.end());
    pattern.addClique(around.data(), int(around.size()));
  }
  BlockMatrix x(std::move(pattern));
  for (Index i = 0; i < nodes; ++i) {
    const Index first = entry_start_[std::size_t(i)], end = entry_start_[std::size_t(i) + 1];
    const double weight = laplacian_[std::size_t(i)];
    for (Index k = first; k < end; ++k) {
      const std::size_t own = std::size_t(entries_[std::size_t(k)]), at = place_[std::size_t(volume_of_[own])];
      const Vec3 moved = inverse[std::size_t(i)] * gradients_[own];
      for (Index m = first; m < end; ++m) {
        const std::size_t other = std::size_t(entries_[std::size_t(m)]), to = place_[std::size_t(volume_of_[other])];
        const Index slot = x.slot(Index(at / row_doubles), Index(to / row_doubles));
        x.values()[9 * std::size_t(slot) + 3 * (at % row_doubles) + to % row_doubles] +=
            moved.dot(gradients_[other]) + (k == m ? end - first - 1 : -1) * weight;
      }
    }
  }
  double sum = 0;
  for (const Index slot : x.diagonal()) sum += x.values()[9 * std::size_t(slot)];
  for (const Index slot : x.diagonal())  // places without a volume
    for (const std::size_t k : {0, 4, 8})
      if (double& value = x.values()[9 * std::size_t(slot) + k]; value == 0) value = sum / rows_;
  return x;
}

void PressureRows::volumes(ConstRows u, Rows out) const {
  clear(out);
  amg::forRows(count(), [&](Index c) {
    double sum = 0;
    for (Index e = start_[std::size_t(c)]; e < start_[std::size_t(c) + 1]; ++e)
      sum += gradients_[std::size_t(e)].dot(u[nodes_[std::size_t(e)]]);
    out.data[place_[std::size_t(c)]] = sum;
  });
}

void PressureRows::addForces(double factor, ConstRows p, Rows out) const {
  amg::forRows(out.count, [&](Index i) {
    Vec3 sum = Vec3::Zero();
    for (Index k = entry_start_[std::size_t(i)]; k < entry_start_[std::size_t(i) + 1]; ++k) {
      const std::size_t e = std::size_t(entries_[std::size_t(k)]);
      sum += p.data[place_[std::size_t(volume_of_[e])]] * gradients_[e];
    }
    out[i] += factor * sum;
  });
}

void PressureRows::multiplyByExcess(Rows p) const {
  for (std::size_t c = 0; c < excess_.size(); ++c) p.data[place_[c]] *= excess_[c];
}
void PressureRows::divideByExcess(Rows p) const {
  for (std::size_t c = 0; c < excess_.size(); ++c) p.data[place_[c]] /= excess_[c];
}

struct MixedSolve::Pressures final : SystemMatrix {
  BlockMatrix values;
  long revision = 0;

  MatrixKey key() const override { return {identity().get(), revision, revision}; }
  Index rows() const override { return values.rows(); }
  void multiply(ConstRows p, Rows out) const override { values.multiply(p, out); }
  const BlockMatrix& assemble() override { return values; }
  void diagonalBlocks(std::vector<double>& blocks) const override {
    blocks.resize(std::size_t(rows()) * 9);
    for (Index row = 0; row < rows(); ++row)
      std::copy_n(values.values().data() + 9 * std::size_t(values.diagonal()[row]), 9, blocks.data() + 9 * std::size_t(row));
  }
  bool symmetric() const override { return true; }
  bool prefersAssembled(int) const override { return true; }
  std::string describeRow(Index row) const override { return "pressures " + std::to_string(3 * row); }
};

MixedSolve::MixedSolve() = default;
MixedSolve::~MixedSolve() = default;

void MixedSolve::reset() {
  key_ = {}, volumes_.reset(), hierarchy_.reset();
  factors_ = nullptr;
}

bool MixedSolve::follow(SystemMatrix& matrix, const VolumeTerms& terms, DirectSolver& factors, SolveReport& report, StopToken stop) {
  reset();
  nodes_ = matrix.rows();
  volumes_ = std::make_unique<PressureRows>(terms, nodes_);
  BlockMatrix a = matrix.assemble();
  volumes_->subtractFrom(a);
  if (volumes_->empty()) {
    report.stop = SolveStop::breakdown;
    return false;
  }
  hierarchy_ = amg::makeHierarchy(a, matrix.positions(), report, stop);
  if (!hierarchy_) return false;
  std::vector<double> blocks(std::size_t(nodes_) * 9);
  for (Index row = 0; row < nodes_; ++row)
    std::copy_n(a.values().data() + 9 * std::size_t(a.diagonal()[row]), 9, blocks.data() + 9 * std::size_t(row));
  if ((report.row = diagonal_.factor(blocks)) >= 0) {
    report.stop = SolveStop::not_definite;
    return false;
  }
  std::vector<Mat3> inverse;
  for (std::size_t row = 0; row < std::size_t(nodes_); ++row) inverse.push_back(Eigen::Map<const Mat3>(blocks.data() + 9 * row).inverse());
  if (!matrix_) matrix_ = std::make_unique<Pressures>();
  matrix_->values = volumes_->products(inverse);
  ++matrix_->revision;
  factors_ = factors.factor(*matrix_, report, stop);
  if (!factors_) return false;
  double stiffness = 0, area = 0;
  for (const double number : blocks) stiffness += std::abs(number) / double(blocks.size());
  for (const Vec3& gradient : terms.gradients) area += gradient.norm() / double(terms.gradients.size());
  weight_ = stiffness / area;
  const Index all = nodes_ + volumes_->rows();
  if (both_.count() != all) {
    basis_.clear(), steps_.clear();
    for (Vector* each : {&both_, &trial_}) each->resize(all);
  }
  for (Vector* each : {&forces_, &moved_}) each->resize(nodes_);
  for (Vector* each : {&pressures_, &sums_}) each->resize(volumes_->rows());
  key_ = matrix.key();
  return true;
}

}  // namespace stroma
