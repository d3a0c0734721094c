// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/iterative_solvers/pressure_rows.h"

#include <algorithm>

#include "components/iterative_solvers/multigrid_blocks.h"

namespace stroma {
namespace {

/// K / mu at Poisson's ratio 0.3.
constexpr double kept_bulk = 2.6 / 1.2;
constexpr std::size_t in_row = 3;

}  // namespace

PressureRows::PressureRows(const VolumeTerms& terms, Index nodes) {
  for (Index c = 0; c < terms.count(); ++c) {
    const double kept = kept_bulk * terms.shear[c], excess = terms.bulk[c] - kept;
    if (!(excess > kept)) continue;
    for (Index e = terms.start[c]; e < terms.start[c + 1]; ++e) {
      if (terms.gradients[e] == Vec3::Zero()) continue;
      nodes_.push_back(terms.rows[e]);
      gradients_.push_back(terms.gradients[e]);
      volume_of_.push_back(count());
    }
    if (Index(nodes_.size()) == start_.back()) continue;  // all its nodes are held
    start_.push_back(Index(nodes_.size()));
    excess_.push_back(excess);
  }
  findEntries(nodes);
  group();
  weighLaplacian();
}

void PressureRows::findEntries(Index nodes) {
  entry_start_.assign(std::size_t(nodes) + 1, 0);
  for (const Index node : nodes_) ++entry_start_[node + 1];
  for (Index i = 0; i < nodes; ++i) entry_start_[i + 1] += entry_start_[i];
  entries_.resize(nodes_.size());
  std::vector<Index> next(entry_start_.begin(), entry_start_.end());
  for (Index e = 0; e < Index(nodes_.size()); ++e) entries_[next[nodes_[e]]++] = e;
}

/// A row is the first volume that has none yet, and the two that share most nodes with it.
void PressureRows::group() {
  place_.assign(excess_.size(), 0);
  std::vector<char> placed(excess_.size(), 0);
  std::vector<Index> shared(excess_.size(), 0), row;
  for (Index c = 0; c < count(); ++c) {
    if (placed[c]) continue;
    row.clear();
    for (Index e = start_[c]; e < start_[c + 1]; ++e)
      for (Index k = entry_start_[nodes_[e]]; k < entry_start_[nodes_[e] + 1]; ++k) {
        const Index other = volume_of_[entries_[k]];
        if (other != c && !placed[other] && shared[other]++ == 0) row.push_back(other);
      }
    std::ranges::sort(row, [&](Index a, Index b) { return shared[a] != shared[b] ? shared[a] > shared[b] : a < b; });
    for (const Index other : row) shared[other] = 0;
    row.insert(row.begin(), c);
    row.resize(std::min(in_row, row.size()));
    for (std::size_t k = 0; k < row.size(); ++k) {
      placed[row[k]] = 1;
      place_[row[k]] = std::size_t(rows_) * row_doubles + k;
    }
    ++rows_;
  }
}

void PressureRows::weighLaplacian() {
  laplacian_.assign(entry_start_.size() - 1, 0.0);
  std::vector<double> neighbours(excess_.size(), 0.0);
  for (Index i = 0; i < Index(laplacian_.size()); ++i) {
    double stiffest = 0;
    for (Index k = entry_start_[i]; k < entry_start_[i + 1]; ++k) {
      const Index c = volume_of_[entries_[k]];
      stiffest = std::max(stiffest, excess_[c]);
      neighbours[c] += pressuresAt(i);
    }
    if (stiffest > 0) laplacian_[i] = 1 / stiffest;
  }
  const double most = neighbours.empty() ? 1 : std::ranges::max(neighbours);
  for (double& weight : laplacian_) weight /= most;
}

void PressureRows::volumes(ConstRows u, Rows out) const {
  clear(out);
  amg::forRows(count(), [&](Index c) {
    double sum = 0;
    for (Index e = start_[c]; e < start_[c + 1]; ++e) sum += gradients_[e].dot(u[nodes_[e]]);
    out.data[place_[c]] = sum;
  });
}

void PressureRows::addForces(double factor, ConstRows p, Rows out) const {
  amg::forRows(out.count, [&](Index i) {
    Vec3 sum = Vec3::Zero();
    for (Index k = entry_start_[i]; k < entry_start_[i + 1]; ++k) {
      const Index e = entries_[k];
      sum += p.data[place_[volume_of_[e]]] * gradients_[e];
    }
    out[i] += factor * sum;
  });
}

void PressureRows::multiplyByExcess(Rows p) const {
  for (Index c = 0; c < count(); ++c) p.data[place_[c]] *= excess_[c];
}
void PressureRows::divideByExcess(Rows p) const {
  for (Index c = 0; c < count(); ++c) p.data[place_[c]] /= excess_[c];
}

void PressureRows::multiplyByLaplacian(ConstRows p, Rows sums, Rows out) const {
  amg::forRows(sums.count, [&](Index i) {
    double sum = 0;
    for (Index k = entry_start_[i]; k < entry_start_[i + 1]; ++k) sum += p.data[place_[volume_of_[entries_[k]]]];
    sums.data[std::size_t(i) * row_doubles] = sum;
  });
  clear(out);
  amg::forRows(count(), [&](Index c) {
    double sum = 0;
    for (Index e = start_[c]; e < start_[c + 1]; ++e) {
      const Index i = nodes_[e];
      sum += laplacian_[i] * (pressuresAt(i) * p.data[place_[c]] - sums.data[std::size_t(i) * row_doubles]);
    }
    out.data[place_[c]] = sum;
  });
}

void PressureRows::subtractFrom(BlockMatrix& k) const {
  amg::forRows(k.rows(), [&](Index row) {
    const auto begin = k.columns().begin(), first = begin + k.rowStart()[row], end = begin + k.rowStart()[row + 1];
    for (Index at = entry_start_[row]; at < entry_start_[row + 1]; ++at) {
      const Index own = entries_[at], c = volume_of_[own];
      const Vec3 force = -excess_[c] * gradients_[own];
      for (Index e = start_[c]; e < start_[c + 1]; ++e) {
        const auto found = std::lower_bound(first, end, nodes_[e]);
        if (found != end && *found == nodes_[e]) k.add(Index(found - begin), force * gradients_[e].transpose());
      }
    }
  });
}

void PressureRows::subtractFrom(std::vector<double>& diagonal) const {
  for (Index e = 0; e < Index(nodes_.size()); ++e) {
    Eigen::Map<Mat3> block(diagonal.data() + 9 * std::size_t(nodes_[e]));  // symmetric
    block -= excess_[volume_of_[e]] * gradients_[e] * gradients_[e].transpose();
  }
}

BlockMatrix PressureRows::products(const std::vector<Mat3>& inverse) const {
  const Index nodes = Index(inverse.size());
  BlockPattern pattern(rows_);
  std::vector<Index> around;
  for (Index i = 0; i < nodes; ++i) {
    around.clear();
    for (Index k = entry_start_[i]; k < entry_start_[i + 1]; ++k) around.push_back(Index(place_[volume_of_[entries_[k]]] / row_doubles));
    std::ranges::sort(around);
    around.erase(std::unique(around.begin(), around.end()), around.end());
    pattern.addClique(around.data(), int(around.size()));
  }
  BlockMatrix x(std::move(pattern));
  const auto entry = [&](std::size_t at, std::size_t to) -> double& {
    const Index slot = x.slot(Index(at / row_doubles), Index(to / row_doubles));
    return x.values()[9 * std::size_t(slot) + 3 * (at % row_doubles) + to % row_doubles];
  };
  for (Index i = 0; i < nodes; ++i)
    for (Index k = entry_start_[i]; k < entry_start_[i + 1]; ++k) {
      const Vec3 moved = inverse[i] * gradients_[entries_[k]];
      for (Index m = entry_start_[i]; m < entry_start_[i + 1]; ++m) {
        const double rough = (k == m ? pressuresAt(i) - 1 : -1) * laplacian_[i];
        entry(place_[volume_of_[entries_[k]]], place_[volume_of_[entries_[m]]]) += moved.dot(gradients_[entries_[m]]) + rough;
      }
    }
  double trace = 0;
  for (const Index slot : x.diagonal()) trace += x.values()[9 * std::size_t(slot)];
  for (const Index slot : x.diagonal())
    for (const std::size_t k : {0, 4, 8})
      if (double& value = x.values()[9 * std::size_t(slot) + k]; value == 0) value = trace / rows_;
  return x;
}

double PressureRows::meanGradient() const {
  double sum = 0;
  for (const Vec3& gradient : gradients_) sum += gradient.norm();
  return sum / double(gradients_.size());
}

}  // namespace stroma
