// SPDX-License-Identifier: LGPL-2.1-or-later
// Friction of explicit steps, which use the forces at the start of a substep without a solve, and of implicit ones with one
// solve.
//
// The law of slipVelocity would need steps of slipVelocity m/(mu l), far below those of the bodies. Sticking contacts are
// therefore held by a tangential spring that is as stiff as the contact is along its normal, k = d l/d gap (as Mindlin 1949
// found for spheres, up to a factor near one), but at least that under a tenth of kappa, k = kappa A/contactDistance, which is
// about the stiffness of a cell. It hardly reduces the stable step of the bodies, and does not creep:
//   u = previous stretch + slip since then,   |u| <= mu l/k,   force -k u
// A contact stretched farther slides, and its spring follows. Springs belong to vertices. mu is the static one unless the last
// substep was faster than slipVelocity, as in contact_friction.h.
//
// One linear solve uses the force and its derivative at the start of the step. There the law of slipVelocity is the unbounded
// line of sticking: it would glue. The state of a vertex is therefore decided between steps, and its force is linear within
// one:
//   it sticks: -k u, until |u| > mu l/k; then it slides
//   it slides: -mu l along its slip d in the previous step, mu l/|d| across; if it has reversed, it sticks
// A vertex whose speed exceeds the sticking limit within a step slides from its start, except after a reversal, when its
// spring stops it, unless the integrator would make that oscillate. The start and the end of sliding are detected one step
// late.
#include <algorithm>
#include <cmath>

#include "components/contact/contact_friction.h"

namespace stroma::contact {

/// Adds a slide. Returns the stiffness of its spring, or 0 where nothing is added. Below zero where what was counted twice is taken
/// away; the force then is, too.
double Friction::addSpring(const BarrierLaw& law, const Touch& touch) {
  const std::size_t vertex = std::size_t(touch.v[0]), before = slides.size();
  add(law, touch, vertex < sticking_.size() ? sticking_[vertex] : 1);
  if (slides.size() == before) return 0;
  const double least = law.stiffness * std::abs(touch.share) / touch.range;
  return std::copysign(std::max(std::abs(law.pushingOf(touch).curvature), least), slides.back().force);
}

void Friction::addTerm(const Surfaces& surfaces, const Slide& slide, const Vec3& force, const Mat3& m) {
  Term term;
  for (std::size_t i = 0; i < 4; ++i)
    if (const int v = slide.v[i]; v >= 0) term.rows[i] = surfaces.rows[std::size_t(v)];
  term.c = slide.c;
  term.force = force;
  term.m = m;
  terms_.push_back(term);
}

namespace {
Mat3 across(const Vec3& n) { return Mat3::Identity() - n * n.transpose(); }
}  // namespace

void Friction::stretch(const BarrierLaw& law, const std::vector<Touch>& touches, const std::vector<Vec3>& x,
                       const std::vector<Vec3>& start, const Vec3& moved) {
  slides.clear(), terms_.clear();
  are_springs_ = true;
  for (const Touch& touch : touches) {
    const double k = addSpring(law, touch);
    if (slides.size() == terms_.size()) continue;
    Slide& slide = slides.back();
    const std::size_t vertex = std::size_t(touch.v[0]);
    slide.u = wayOf(slide, x, start, moved) +
              (vertex < slid_.size() ? Vec3(across(touch.n) * slid_[vertex]) : Vec3(Vec3::Zero()));
    const double most = k != 0 ? slide.force / k : 0, size = slide.u.norm();
    slide.held = size <= most;
    if (!slide.held) slide.u *= most / size;
    addTerm(law.surfaces, slide, -k * slide.u, std::max(0.0, k) * across(touch.n));
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

// ---- steps of one solve ----

void Friction::lean(const BarrierLaw& law, const std::vector<Touch>& touches, const std::vector<Vec3>& x,
                    const std::vector<Vec3>& start, const Vec3& moved) {
  slides.clear(), terms_.clear();
  are_springs_ = true;
  goes_.resize(x.size(), 0);
  for (const Touch& touch : touches) {
    const double k = addSpring(law, touch);
    if (slides.size() == terms_.size()) continue;
    Slide& slide = slides.back();
    const auto vertex = std::size_t(touch.v[0]);
    const Vec3 before = across(touch.n) * slid_[vertex];
    const double length = before.norm();
    slide.held = goes_[vertex] != slides_on || !(length > 0);
    if (slide.held) {
      slide.u = wayOf(slide, x, start, moved) + before;
      addTerm(law.surfaces, slide, -k * slide.u, k * across(touch.n));
    } else {
      slide.u = before;
      const Vec3 d = before / length;
      const Mat3 beside = slide.force / length * (across(touch.n) - d * d.transpose());
      addTerm(law.surfaces, slide, -slide.force * d - beside * wayOf(slide, x, start, moved), beside);
    }
  }
}

/// Of each vertex in reach: its way, and how far its springs may be stretched, weighted by forces.
void Friction::weighWays(const BarrierLaw& law, const std::vector<Touch>& touches, const std::vector<Vec3>& x,
                         const std::vector<Vec3>& start, const Vec3& moved) {
  slid_before_.assign(slid_.size(), Vec3::Zero());
  weights_.assign(slid_.size(), 0), reach_.assign(slid_.size(), 0), goes_.resize(slid_.size(), 0);
  slides.clear();
  for (const Touch& touch : touches) {
    const double k = addSpring(law, touch);
    if (k == 0) continue;
    const Slide& slide = slides.back();
    const std::size_t vertex = std::size_t(touch.v[0]);
    const double weight = std::abs(slide.force);
    weights_[vertex] += weight, reach_[vertex] += weight * slide.force / k;
    slid_before_[vertex] += weight * wayOf(slide, x, start, moved);
  }
  for (std::size_t v = 0; v < slid_.size(); ++v)
    if (weights_[v] > 0) slid_before_[v] /= weights_[v], reach_[v] /= weights_[v];
}

void Friction::keepLeaning(const BarrierLaw& law, const std::vector<Touch>& touches, const std::vector<Vec3>& x,
                           const std::vector<Vec3>& start, const Vec3& moved) {
  weighWays(law, touches, x, start, moved);
  if (letsGo()) sticking_.assign(slid_.size(), 1);
  for (std::size_t v = 0; v < slid_.size(); ++v) {
    double& goes = goes_[v];
    const Vec3& way = slid_before_[v];
    if (weights_[v] == 0) goes = 0;
    if (letsGo() && goes == slides_on) sticking_[v] = stickingAt(way.norm());
    if (goes == 0) {
      slid_[v].setZero();
    } else if (goes != slides_on) {
      slid_[v] += way;
      goes = slid_[v].norm() > reach_[v] ? slides_on : sticks;
    } else if (way.dot(slid_[v]) > 0) {
      slid_[v] = way;
    } else {
      slid_[v] *= std::min(1.0, reach_[v] / slid_[v].norm());
      goes = is_damped ? came_back : sticks;
    }
  }
}

void Friction::leanAtSpeed(const BarrierLaw& law, const std::vector<Touch>& touches, ConstRows v, double dt,
                           const std::vector<Vec3>& start, const Vec3& moved, std::vector<Vec3>& x) {
  x = start;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const Index row = law.surfaces.rows[i];
    x[i] += row >= 0 ? Vec3(dt * v[row]) : moved;
  }
  weighWays(law, touches, x, start, moved);
  for (std::size_t i = 0; i < slid_.size(); ++i) {
    if (weights_[i] == 0 || (goes_[i] != 0 && goes_[i] != sticks)) continue;
    const bool slips = (slid_[i] + slid_before_[i]).norm() > reach_[i] && !slid_before_[i].isZero(0);
    if (slips) slid_[i] = slid_before_[i];
    goes_[i] = slips ? slides_on : sticks;
  }
}

void Friction::leanAgain(bool again) {
  (again ? goes_ : goes_at_start_) = again ? goes_at_start_ : goes_;
  (again ? slid_ : slid_at_start_) = again ? slid_at_start_ : slid_;
}

}  // namespace stroma::contact
