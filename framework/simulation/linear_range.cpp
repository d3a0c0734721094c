// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/simulation/linear_range.h"

#include <fmt/format.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

#include "framework/mesh/topology.h"

namespace stroma {

void LinearRange::compile(const System& system, const CondensedBody& body, const std::vector<Index>& active_of_row) {
  triangles_.clear();
  system_ = &system;
  const auto add = [&](const State& state, Index a, Index b, Index c) {
    Patch patch;
    patch.rows = {state.firstRow() + a, state.firstRow() + b, state.firstRow() + c};
    bool moves = false;
    for (std::size_t i = 0; i < 3; ++i) {
      patch.node[i] = active_of_row[std::size_t(patch.rows[i])];
      moves = moves || patch.node[i] >= 0;
      if (patch.node[i] < 0 && body.nodeOf(patch.rows[i]) >= 0) return;  // inside: not known in a step
    }
    const auto& x = body.reference();
    const Vec3 e1 = x[patch.rows[1]] - x[patch.rows[0]], e2 = x[patch.rows[2]] - x[patch.rows[0]];
    const Vec3 n = e1.cross(e2);
    if (!moves || !(n.norm() > 1e-12 * e1.norm() * e2.norm())) return;
    patch.slope = {Vec3(e2.cross(n) / n.squaredNorm()), Vec3(n.cross(e1) / n.squaredNorm())};
    patch.normal = n.normalized();
    patch.along = e1.normalized();
    triangles_.push_back(patch);
  };
  for (const State* state : system.states()) {
    const Topology* topology = state->find<Topology>(true);
    if (!topology || topology->mesh().nodes() != state->size()) continue;
    for (const Triangle& face : topology->mesh().boundaryTriangles()) add(*state, face[0], face[1], face[2]);
    for (const Quad& face : topology->mesh().boundaryQuads()) {
      add(*state, face[0], face[1], face[2]);
      add(*state, face[0], face[2], face[3]);
    }
  }
}

void LinearRange::measure(const Patch& patch, const double* u, double t) {
  const auto at = [&](std::size_t i) -> Vec3 {
    return patch.node[i] < 0 ? Vec3::Zero() : Vec3(Eigen::Map<const Vec3>(u + 3 * patch.node[i]));
  };
  const Vec3 u0 = at(0), d1 = at(1) - u0, d2 = at(2) - u0, across = patch.normal.cross(patch.along);
  const Vec3 g1 = d1 * patch.slope[0].dot(patch.along) + d2 * patch.slope[1].dot(patch.along);
  const Vec3 g2 = d1 * patch.slope[0].dot(across) + d2 * patch.slope[1].dot(across);
  const double xx = g1.dot(patch.along), yy = g2.dot(across);
  const double yx = g1.dot(across), xy = g2.dot(patch.along);
  const double n1 = g1.dot(patch.normal), n2 = g2.dot(patch.normal);
  const double turn = std::sqrt((yx - xy) * (yx - xy) / 4 + n1 * n1 + n2 * n2);
  const double strain = std::abs(xx + yy) / 2 + std::sqrt((xx - yy) * (xx - yy) + (xy + yx) * (xy + yx)) / 2;
  if (turn > largest_turn_) largest_turn_ = turn, time_of_turn_ = t, turned_ = patch.rows;
  if (strain > largest_strain_) largest_strain_ = strain, time_of_strain_ = t, strained_ = patch.rows;
}

void LinearRange::look(const double* u, double t, bool all) {
  constexpr std::size_t turns = 64;
  const std::size_t count = all ? triangles_.size() : (triangles_.size() + turns - 1) / turns;
  for (std::size_t i = 0; i < count; ++i) {
    if (next_ >= triangles_.size()) next_ = 0;
    measure(triangles_[next_++], u, t);
  }
}

std::string LinearRange::sentence(double rotation_bound, double strain_bound) const {
  const auto at = [this](const std::array<Index, 3>& rows) { return system_->describeRow(rows[0]); };
  std::string text;
  if (largest_turn_ > rotation_bound)
    text = fmt::format("the surface at {} has turned by {:.2g} rad (bound {:g}) at t = {:.6g} s", at(turned_),
                       largest_turn_, rotation_bound, time_of_turn_);
  if (largest_strain_ > strain_bound)
    text += fmt::format("{}the surface at {} has a strain of {:.2g} (bound {:g}) at t = {:.6g} s",
                        text.empty() ? "" : " and ", at(strained_), largest_strain_, strain_bound, time_of_strain_);
  return text;
}

}  // namespace stroma
