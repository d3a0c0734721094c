// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/condensation/linear_range.h"

#include <fmt/format.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

#include "framework/mechanics/state_topology.h"

namespace stroma {

void LinearRange::compile(const System& system, const CondensedBody& body, const std::vector<Index>& active_of_row) {
  triangles_.clear();
  std::vector<Patch> unknown;
  system_ = &system;
  const auto add = [&](const State& state, Index a, Index b, Index c) {
    Patch patch;
    patch.rows = {state.firstRow() + a, state.firstRow() + b, state.firstRow() + c};
    bool moves = false, known = true;
    for (const Index row : patch.rows) {
      moves = moves || body.nodeOf(row) >= 0;
      known = known && (active_of_row[row] >= 0 || body.nodeOf(row) < 0);
    }
    const auto& x = body.rest();
    const Vec3 e1 = x[patch.rows[1]] - x[patch.rows[0]], e2 = x[patch.rows[2]] - x[patch.rows[0]];
    const Vec3 n = e1.cross(e2);
    patch.edge = {e1, e2};
    if (!moves || !(n.norm() > 1e-12 * e1.norm() * e2.norm())) return;
    patch.slope = {Vec3(e2.cross(n) / n.squaredNorm()), Vec3(n.cross(e1) / n.squaredNorm())};
    patch.normal = n.normalized();
    patch.along = e1.normalized();
    (known ? triangles_ : unknown).push_back(patch);
  };
  for (const State* state : system.states()) {
    if (state->firstRow() >= system.independentRows()) continue;  // it only follows
    if (!state->hasPointsOnly()) continue;                        // frames are not condensed
    const Topology* topology = topologyOf(*state);
    if (!topology) continue;
    for (const Triangle& face : topology->mesh().boundaryTriangles()) add(*state, face[0], face[1], face[2]);
    for (const Quad& face : topology->mesh().boundaryQuads()) {
      add(*state, face[0], face[1], face[2]);
      add(*state, face[0], face[2], face[3]);
    }
  }
  known_ = triangles_.size();
  triangles_.insert(triangles_.end(), unknown.begin(), unknown.end());
  reset();
}

void LinearRange::reset() {
  peaks_ = {};
  next_ = 0;
  largest_square_ = -1;
}

void LinearRange::serialize(Archive& archive) {
  archive.value("next_triangle", next_);
  archive.value("largest_square", largest_square_);
  archive.value("last_time", last_time_);
  archive.value("turn", peaks_.turn);
  archive.value("strain", peaks_.strain);
  archive.value("time_of_turn", peaks_.time_of_turn);
  archive.value("time_of_strain", peaks_.time_of_strain);
  for (std::size_t i = 0; i < 3; ++i) {
    archive.value("turned " + std::to_string(i), peaks_.turned[i]);
    archive.value("strained " + std::to_string(i), peaks_.strained[i]);
  }
}

void LinearRange::measure(const Patch& patch, double t, Peaks& peaks) const {
  const auto& x = system_->x;
  const Vec3 d1 = x[patch.rows[1]] - x[patch.rows[0]] - patch.edge[0];
  const Vec3 d2 = x[patch.rows[2]] - x[patch.rows[0]] - patch.edge[1];
  const Vec3 across = patch.normal.cross(patch.along);
  const Vec3 g1 = d1 * patch.slope[0].dot(patch.along) + d2 * patch.slope[1].dot(patch.along);
  const Vec3 g2 = d1 * patch.slope[0].dot(across) + d2 * patch.slope[1].dot(across);
  const double xx = g1.dot(patch.along), yy = g2.dot(across);
  const double yx = g1.dot(across), xy = g2.dot(patch.along);
  const double n1 = g1.dot(patch.normal), n2 = g2.dot(patch.normal);
  const double turn = std::sqrt((yx - xy) * (yx - xy) / 4 + n1 * n1 + n2 * n2);
  const double strain = std::abs(xx + yy) / 2 + std::sqrt((xx - yy) * (xx - yy) + (xy + yx) * (xy + yx)) / 2;
  if (turn > peaks.turn) {
    peaks.turn = turn;
    peaks.time_of_turn = t;
    peaks.turned = patch.rows;
  }
  if (strain > peaks.strain) {
    peaks.strain = strain;
    peaks.time_of_strain = t;
    peaks.strained = patch.rows;
  }
}

// While a load rises all are looked at each time that the displacements have grown by a twentieth, seldom in a long
// run.
void LinearRange::look(double square, double t) {
  constexpr std::size_t turns = 64;
  constexpr double growth = 1.05 * 1.05;
  last_time_ = t;
  std::size_t count = (known_ + turns - 1) / turns;
  if (square > growth * largest_square_) largest_square_ = square, count = known_;
  for (std::size_t i = 0; i < count; ++i) {
    if (next_ >= known_) next_ = 0;
    measure(triangles_[next_++], t, peaks_);
  }
}

std::string LinearRange::sentence(double rotation_bound, double strain_bound) const {
  const auto at = [this](const std::array<Index, 3>& rows) { return system_->actors().describeRow(rows[0]); };
  Peaks peaks = peaks_;
  for (const Patch& patch : triangles_) measure(patch, last_time_, peaks);
  std::string text;
  if (peaks.turn > rotation_bound)
    text = fmt::format("the surface at {} has turned by {:.2g} rad (bound {:g}) at t = {:.6g} s", at(peaks.turned),
                       peaks.turn, rotation_bound, peaks.time_of_turn);
  if (peaks.strain > strain_bound)
    text +=
        fmt::format("{}the surface at {} has a strain of {:.2g} (bound {:g}) at t = {:.6g} s",
                    text.empty() ? "" : " and ", at(peaks.strained), peaks.strain, strain_bound, peaks.time_of_strain);
  return text;
}

}  // namespace stroma
