// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/contact/contact_friction.h"

#include <algorithm>
#include <utility>

#include "components/contact/step_energy.h"
#include "framework/scene/archive.h"

namespace stroma::contact {

/// u of a slide.
Vec3 Friction::wayOf(const Slide& slide, const std::vector<Vec3>& x, const std::vector<Vec3>& start, const Vec3& moved) {
  Vec3 u = slide.on_plane ? Vec3(-moved) : Vec3(Vec3::Zero());
  for (std::size_t i = 0; i < 4; ++i)
    if (const int v = slide.v[i]; v >= 0) u += slide.c[i] * (x[std::size_t(v)] - start[std::size_t(v)]);
  return u - slide.n.dot(u) * slide.n;
}

namespace {
/// Of a slide at a u: 1/rho, and the derivative of rho by |u|.
struct Law {
  double one_over, slope;
  Law(const Vec3& u, double e) {
    const double y = u.norm() / e;
    one_over = y < 1 ? (2 - y) / e : 1 / u.norm();
    slope = y < 1 ? 1 / ((2 - y) * (2 - y)) : 1;
  }
};

Vec3 directionOf(const Vec3& u) {
  const double length = u.norm();
  return length > 0 ? Vec3(u / length) : Vec3(Vec3::Zero());
}
}  // namespace

/// 1 for what sticks, 0 for what slides.
double Friction::stickingAt(double way) const {
  const double t = std::clamp(way / slip - 1, 0.0, 1.0);
  return (1 - t) * (1 - t) * (1 + 2 * t);
}

void Friction::add(const BarrierLaw& law, const Touch& touch, double sticking, double part) {
  const double whole = (mu + (mu_static - mu) * sticking) * law.pushOf(touch) + mu_adhesion * sticking * law.pullOf(touch);
  const double force = part * whole;
  if (force != 0) slides.push_back({.v = touch.v, .c = touch.c, .n = touch.n, .force = force, .on_plane = touch.v[1] < 0});
}

/// Those of the end of a step and, where its impulse is no mean, those of its start: they rub by the way of the step as well, which takes
/// energy, however large they are beside the mean.
template <class Add>
void Friction::addAll(const BarrierLaw& law, const std::vector<Touch>& touches, Add&& addOf) {
  for (const Touch& touch : touches) addOf(touch, balance ? balance->factorOf(law, touch.v) : 1);
  if (!balance) return;
  for (const Touch& touch : balance->startTouches())
    if (const double part = balance->rubbingPartOf(law, touch.v); part > 0) addOf(touch, part);
}

void Friction::note(const BarrierLaw& law, const std::vector<Touch>& touches) {
  slides.clear();
  looks_ = true, is_computed_ = is_on_line_ = false;
  if (!acts()) return;
  const auto addOf = [&](const Touch& touch, double part) {
    const std::size_t vertex = std::size_t(touch.v[0]);
    add(law, touch, stickingAt(vertex < slid_.size() ? slid_[vertex].norm() : 0), part);
  };
  addAll(law, touches, addOf);
}

void Friction::noteAgain(const BarrierLaw& law, const std::vector<Touch>& touches, const std::vector<Vec3>& x,
                         const std::vector<Vec3>& start, const Vec3& moved) {
  slides.clear();
  looks_ = true, is_computed_ = is_on_line_ = false;
  if (!acts()) return;
  addAll(law, touches, [&](const Touch& touch, double part) {
    const Vec3 u = wayOf({.v = touch.v, .c = touch.c, .n = touch.n, .on_plane = touch.v[1] < 0}, x, start, moved);
    const bool turned = u.dot(slid_[std::size_t(touch.v[0])]) < 0;
    add(law, touch, turned ? 1 : stickingAt(u.norm()), part);
  });
}

double Friction::renew(const BarrierLaw& law, const std::vector<Vec3>& x, const std::vector<Vec3>& start, const Vec3& moved, bool was_held,
                       std::vector<Vec3>& before, std::vector<Vec3>& after) {
  compute(law.surfaces, x, start, moved);
  forces(before);
  if (!was_held && knows_stuck_) noteStuck(x, start, moved);
  if (was_held)
    note(law, law.touches(x));
  else
    noteAgain(law, law.touches(x), x, start, moved);
  compute(law.surfaces, x, start, moved);
  forces(after);
  return relativeChange(before, after);
}

/// What has stuck by the present e is to stick in the next solve too, and might seem to slide there.
void Friction::noteStuck(const std::vector<Vec3>& x, const std::vector<Vec3>& start, const Vec3& moved) {
  stuck_.clear(), knows_stuck_ = true;
  for (const Slide& slide : slides)
    if (const double y = wayOf(slide, x, start, moved).norm() / slip; y <= 1) stuck_[placeOf(slide)] = y;
}

Friction::PlaceOf Friction::placeOf(const Slide& slide) {
  PlaceOf place{slide.v[0], slide.v[1], slide.v[2], slide.v[3], 0};
  for (std::size_t i = 0; i < 4; ++i) place[4] |= int(slide.c[i] != 0) << i;
  return place;
}

void Friction::sharpen(const BarrierLaw& law, const std::vector<Vec3>& x, const std::vector<Vec3>& start, const Vec3& moved) {
  constexpr double part = 0.1;
  noteStuck(x, start, moved);
  slip = std::max(wanted_slip_, part * slip);
  noteAgain(law, law.touches(x), x, start, moved);
}

void Friction::remember(const std::vector<Vec3>& x, const std::vector<Vec3>& start, const Vec3& moved) {
  const auto slipOf = [&](const Slide& slide) {
    const Vec3 u = wayOf(slide, x, start, moved);
    return u.norm() > slip ? u : Vec3(Vec3::Zero());
  };
  Vec3 sum = Vec3::Zero();
  double whole = 0;
  for (const Slide& slide : slides) sum += std::abs(slide.force) * slipOf(slide), whole += std::abs(slide.force);
  slid_before_ = slid_;
  // what has not touched yet does as the others
  std::fill(slid_.begin(), slid_.end(), whole > 0 ? Vec3(sum / whole) : sum);
  for (const Slide& slide : slides) {
    const std::size_t vertex = std::size_t(slide.v[0]);
    slid_[vertex] = slipOf(slide);
    if (letsGo() && slid_[vertex].dot(slid_before_[vertex]) < 0) slid_[vertex].setZero();
  }
}

void Friction::serialize(Archive& archive) {
  archive.list("slid", slid_), archive.list("sticking", sticking_), archive.list("goes", goes_);
  archive.value("slip", slip);  // of the step before, whose end is asked for when the next one begins
}

void Friction::hold(const std::vector<Vec3>& x, const std::vector<Vec3>& start, const Vec3& moved) {
  if (!std::exchange(looks_, false)) return;
  for (Slide& slide : slides) {
    if (slide.force <= 0) continue;  // a spring of negative stiffness has a potential without bound
    if (knows_stuck_) {
      const auto stuck = stuck_.find(placeOf(slide));
      if (stuck != stuck_.end()) slide.held = true, slide.hold = 2 - stuck->second;
      continue;
    }
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

void Friction::lineStarts() {
  ++lines_;
  if (!is_computed_) return;
  is_on_line_ = true;
  for (Slide& slide : slides) slide.start_u = slide.u, slide.start_t = slide.t;
}

void Friction::compute(const Surfaces& surfaces, const std::vector<Vec3>& x, const std::vector<Vec3>& start,
                       const Vec3& moved) {
  terms_.clear();
  is_computed_ = true;
  for (Slide& slide : slides) {
    Term term;
    for (std::size_t i = 0; i < 4; ++i)
      if (const int v = slide.v[i]; v >= 0) term.rows[i] = surfaces.rows[std::size_t(v)];
    slide.u = wayOf(slide, x, start, moved);
    Law law(slide.u, slip);
    if (slide.held) law.one_over = slide.hold / slip;
    slide.t = law.one_over * slide.u;
    term.c = slide.c;
    term.force = -slide.force * slide.t;
    // without slip every tangent is alike
    term.m = Mat3::Identity() - slide.n * slide.n.transpose();
    if (!slide.held) {
      if (is_on_line_) followLine(slide);
      const Mat3 turned = slide.t * directionOf(slide.u).transpose();
      term.m -= 0.5 * law.slope * (turned + turned.transpose());
    }
    term.m *= law.one_over * (definite ? std::max(0.0, slide.force) : slide.force);
    terms_.push_back(term);
  }
}

void Friction::computeAtSpeed(const Surfaces& surfaces, ConstRows v, double dt, const std::vector<Vec3>& start,
                              const Vec3& moved, std::vector<Vec3>& x) {
  x = start;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const Index row = surfaces.rows[i];
    x[i] += row >= 0 ? Vec3(dt * v[row]) : moved;
  }
  compute(surfaces, x, start, moved);
}

/// mu l f0, which is e (y^2 - y^3/3) for y < 1, else e (y - 1/3); of what is held e y^2 hold/2.
double Friction::energy(const std::vector<Vec3>& x, const std::vector<Vec3>& start, const Vec3& moved) const {
  double sum = 0;
  for (const Slide& slide : slides) {
    const double y = wayOf(slide, x, start, moved).norm() / slip;
    sum += slide.force * slip * (slide.held ? 0.5 * slide.hold * y * y : y < 1 ? y * y * (1 - y / 3) : y - 1.0 / 3);
  }
  return sum;
}

/// t at u, by the equation linearised where the line starts.
void Friction::followLine(Slide& slide) const {
  const Law law(slide.start_u, slip);
  const Vec3 way = slide.u - slide.start_u;
  slide.t = law.one_over * (slide.u - law.slope * directionOf(slide.start_u).dot(way) * slide.start_t);
  if (const double size = slide.t.norm(); size > 1) slide.t /= size;
}

void Friction::forces(std::vector<Vec3>& out) const {
  std::fill(out.begin(), out.end(), Vec3::Zero());
  for (std::size_t k = 0; k < terms_.size(); ++k)
    for (std::size_t i = 0; i < 4; ++i)
      if (slides[k].v[i] >= 0) out[std::size_t(slides[k].v[i])] += terms_[k].c[i] * terms_[k].force;
}

}  // namespace stroma::contact
