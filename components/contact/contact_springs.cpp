// SPDX-License-Identifier: LGPL-2.1-or-later
// Friction of explicit steps, which take forces where a part of a step starts and solve nothing.
//
// The law of slipVelocity would need steps of slipVelocity m/(mu l), far below those of the bodies. What sticks is therefore held by
// a spring across the normal that is as stiff as the contact is along it, k = d l/d gap (as Mindlin 1949 has it of spheres, up to a
// factor near one), but no less than under a tenth of kappa, k = kappa A/contactDistance, which is about the stiffness of a cell. It asks
// for hardly shorter steps than the bodies do, and does not creep:
//   u = what was stretched + the way since then,   |u| <= mu l/k,   force -k u
// What is stretched farther slides, and its spring follows. Springs belong to vertices. mu is that of what sticks unless the last part
// of a step went faster than slipVelocity, as in contact_friction.h.
#include <algorithm>
#include <cmath>

#include "components/contact/contact_friction.h"

namespace stroma::contact {

void Friction::stretch(const BarrierLaw& law, const std::vector<Touch>& touches, const std::vector<Vec3>& x,
                       const std::vector<Vec3>& start, const Vec3& moved) {
  slides.clear(), terms_.clear();
  are_springs_ = true;
  for (const Touch& touch : touches) {
    const std::size_t vertex = std::size_t(touch.v[0]);
    add(law, touch, vertex < sticking_.size() ? sticking_[vertex] : 1);
    if (slides.size() == terms_.size()) continue;
    Slide& slide = slides.back();
    const Slopes push = law.pushingOf(touch);
    // below zero where what was counted twice is taken away; the force then is, too
    const double k = std::copysign(
        std::max(std::abs(push.curvature), law.stiffness * std::abs(touch.share) / touch.range), slide.force);
    const Mat3 across = Mat3::Identity() - touch.n * touch.n.transpose();
    slide.u =
        wayOf(slide, x, start, moved) + (vertex < slid_.size() ? Vec3(across * slid_[vertex]) : Vec3(Vec3::Zero()));
    const double most = k != 0 ? slide.force / k : 0, size = slide.u.norm();
    slide.held = size <= most;
    if (!slide.held) slide.u *= most / size;
    Term term;
    for (std::size_t i = 0; i < 4; ++i)
      if (const int v = slide.v[i]; v >= 0) term.rows[i] = law.surfaces.rows[std::size_t(v)];
    term.c = slide.c;
    term.force = -k * slide.u;
    term.m = std::max(0.0, k) * across;
    terms_.push_back(term);
  }
}

void Friction::keepStretched(const std::vector<Vec3>& x, const std::vector<Vec3>& start, const Vec3& moved) {
  slid_before_.assign(slid_.size(), Vec3::Zero());
  weights_.assign(slid_.size(), 0);
  if (letsGo()) sticking_.assign(slid_.size(), 1);
  for (const Slide& slide : slides) {
    const std::size_t vertex = std::size_t(slide.v[0]);
    const double weight = std::abs(slide.force);
    weights_[vertex] += weight, slid_before_[vertex] += weight * slide.u;
    if (letsGo() && !slide.held)
      sticking_[vertex] = std::min(sticking_[vertex], stickingAt(wayOf(slide, x, start, moved).norm()));
  }
  for (std::size_t v = 0; v < slid_.size(); ++v)
    slid_[v] = weights_[v] > 0 ? Vec3(slid_before_[v] / weights_[v]) : Vec3(Vec3::Zero());
}

}  // namespace stroma::contact
