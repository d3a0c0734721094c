// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/contact/contact_friction.h"

#include <algorithm>
#include <utility>

namespace stroma::contact {

namespace {
/// u of a slide.
Vec3 wayOf(const Friction::Slide& slide, const std::vector<Vec3>& x, const std::vector<Vec3>& start, const Vec3& moved) {
  Vec3 u = slide.on_plane ? Vec3(-moved) : Vec3(Vec3::Zero());
  for (std::size_t i = 0; i < 4; ++i)
    if (const int v = slide.v[i]; v >= 0) u += slide.c[i] * (x[std::size_t(v)] - start[std::size_t(v)]);
  return u - slide.n.dot(u) * slide.n;
}
}  // namespace

void Friction::note(const BarrierLaw& law, const std::vector<Vec3>& x) {
  slides.clear();
  looks_ = true;
  if (mu == 0) return;
  for (const Touch& touch : law.touches(x))
    if (const double l = law.forceOf(touch).dot(touch.n); l != 0)
      slides.push_back({touch.v, touch.c, touch.n, mu * l, touch.v[1] < 0});
}

void Friction::remember(const std::vector<Vec3>& x, const std::vector<Vec3>& start, const Vec3& moved) {
  const auto slipOf = [&](const Slide& slide) {
    const Vec3 u = wayOf(slide, x, start, moved);
    return u.norm() > slip ? u : Vec3(Vec3::Zero());
  };
  Vec3 sum = Vec3::Zero();
  double whole = 0;
  for (const Slide& slide : slides) sum += std::abs(slide.force) * slipOf(slide), whole += std::abs(slide.force);
  // what has not touched yet does as the others
  std::fill(slid_.begin(), slid_.end(), whole > 0 ? Vec3(sum / whole) : sum);
  for (const Slide& slide : slides) slid_[std::size_t(slide.v[0])] = slipOf(slide);
}

void Friction::hold(const std::vector<Vec3>& x, const std::vector<Vec3>& start, const Vec3& moved) {
  if (!std::exchange(looks_, false)) return;
  for (Slide& slide : slides) {
    if (met_[std::size_t(slide.v[0])]) continue;
    const Vec3 u = wayOf(slide, x, start, moved);
    const double way = u.norm();
    // what slipped by half as much in the step before, in that direction, goes on
    slide.held = way > slip && way < farthest && u.dot(slid_[std::size_t(slide.v[0])]) < 0.5 * way * way;
  }
}

bool Friction::release() {
  bool held = false;
  for (Slide& slide : slides)
    if (std::exchange(slide.held, false)) held = met_[std::size_t(slide.v[0])] = true;
  return held;
}

void Friction::compute(const Surfaces& surfaces, const std::vector<Vec3>& x, const std::vector<Vec3>& start,
                       const Vec3& moved) {
  terms_.clear();
  for (const Slide& slide : slides) {
    Term term;
    for (std::size_t i = 0; i < 4; ++i)
      if (const int v = slide.v[i]; v >= 0) term.rows[i] = surfaces.rows[std::size_t(v)];
    const Vec3 u = wayOf(slide, x, start, moved);
    const double length = u.norm(), y = slide.held ? 0 : length / slip;
    const double over_length = y < 1 ? (2 - y) / slip : 1 / length, along = y < 1 ? 2 * (1 - y) / slip : 0;
    const Vec3 direction = length > 0 ? Vec3(u / length) : Vec3(Vec3::Zero());
    const Mat3 turned = direction * direction.transpose();
    term.c = slide.c;
    term.force = -slide.force * over_length * u;
    // without slip every tangent is alike
    const Mat3 tangents = Mat3::Identity() - slide.n * slide.n.transpose();
    term.m = std::max(0.0, slide.force) * (over_length * (tangents - turned) + along * turned);
    terms_.push_back(term);
  }
}

void Friction::forces(std::vector<Vec3>& out) const {
  std::fill(out.begin(), out.end(), Vec3::Zero());
  for (std::size_t k = 0; k < terms_.size(); ++k)
    for (std::size_t i = 0; i < 4; ++i)
      if (slides[k].v[i] >= 0) out[std::size_t(slides[k].v[i])] += terms_[k].c[i] * terms_[k].force;
}

}  // namespace stroma::contact
