// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/springs/spring_field.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace stroma {

void SpringField::setSprings(std::vector<Spring> springs, State* second) {
  springs_ = std::move(springs);
  second_ = second == &state() ? nullptr : second;
  damped_ = false, rests_ = true;
  for (std::size_t s = 0; s < springs_.size(); ++s) {
    const Spring& spring = springs_[s];
    if (!second_ && spring.a == spring.b)
      throw ComponentError(fmt::format("spring {} joins node {} to itself", s, spring.a), "two different nodes");
    for (const auto& [value, word] : {std::pair(spring.stiffness, "stiffness"), std::pair(spring.damping, "damping"),
                                      std::pair(spring.length, "rest length")})
      if (!(value >= 0) || !std::isfinite(value))
        throw ComponentError(
            fmt::format("spring {} (nodes {} {}) has a {} of {:g}", s, spring.a, spring.b, word, value),
            "a number that is not negative");
    damped_ = damped_ || spring.damping > 0;
    rests_ = rests_ && std::abs(spring.length - restDistance(spring)) <= 1e-12 * spring.length;
  }
}

double SpringField::restDistance(const Spring& spring) const {
  return (second().rest_position[spring.b] - state().rest_position[spring.a]).norm();
}

std::vector<State*> SpringField::states() const {
  return second_ ? std::vector<State*>{&state(), second_} : std::vector<State*>{&state()};
}

void SpringField::declareDamping(DataTable& table) {
  table.add("explicitDamping", explicit_damping_)
      .help("damping adds to the tension of a spring and to no df/dv, as in SOFA: it is not stable for large ones");
  table.addChoice("meetingEnds", meeting_ends_, {"stiff", "free"})
      .help("a spring whose ends meet has no direction; stiff: its stiffness acts in all directions; free: it has no effect there, "
            "as in SOFA");
}

ForceTraits SpringField::traits() const {
  ForceTraits traits;
  traits.symmetric = traits.conservative = true;
  traits.velocity_dependent = damped_ && !explicit_damping_;
  traits.exact_tangent = !damped_;
  traits.forces_balance = traits.torques_balance = rests_;
  return traits;
}

void SpringField::compile() {
  std::vector<Group> rows(springs_.size());
  for (std::size_t s = 0; s < springs_.size(); ++s)
    rows[s] = {state().firstRow() + springs_[s].a, second().firstRow() + springs_[s].b};
  setGroups(std::move(rows), damped_ && !explicit_damping_);
}

/// A spring without a length at rest is never shorter.
static bool resists(const Spring& spring, double stretch) {
  return !(stretch <= 0 && spring.length > 0 && spring.elongation_only) && !(stretch >= 0 && spring.compression_only);
}

double SpringField::energy(ConstRows x) const {
  double sum = 0;
  for (std::size_t s = 0; s < springs_.size(); ++s) {
    const double stretch = (x[rows_[s][1]] - x[rows_[s][0]]).norm() - springs_[s].length;
    if (resists(springs_[s], stretch)) sum += springs_[s].stiffness / 2 * stretch * stretch;
  }
  return sum;
}

void SpringField::addForce(ConstRows x, ConstRows v, Rows f) {
  for (std::size_t s = 0; s < springs_.size(); ++s) {
    const Spring& spring = springs_[s];
    const auto [a, b] = rows_[s];
    const Vec3 d = x[b] - x[a];
    const double length = d.norm(), stretch = length - spring.length;
    constexpr double met = 1e-9;  // SOFA's [m]
    if (!resists(spring, stretch) || (meeting_ends_ == MeetingEnds::free && length <= met)) {
      stiffness_[s].setZero();
      if (!damping_.empty()) damping_[s].setZero();
      continue;
    }
    if (length <= 1e-12 * spring.length || length == 0) {
      stiffness_[s].k = -spring.stiffness * Mat3::Identity();
      if (!damping_.empty()) damping_[s].setZero();
      continue;
    }
    const Vec3 n = d / length;
    const Mat3 along = n * n.transpose();
    const double transverse = stretch / length;  // 1 - L0/L
    stiffness_[s].k = -spring.stiffness * (transverse * Mat3::Identity() + (1 - transverse) * along);
    double tension = spring.stiffness * stretch;
    if (damped_) {
      tension += spring.damping * (v[b] - v[a]).dot(n);
      if (explicit_damping_)
        stiffness_[s].k = -(spring.stiffness - tension / length) * along - tension / length * Mat3::Identity();
      else
        damping_[s].k = -spring.damping * along;
    }
    f[a] += tension * n;
    f[b] -= tension * n;
  }
}

void SpringField::addSegments(std::vector<Segment>& segments) const {
  for (const Spring& spring : springs_) segments.push_back({&state(), spring.a, &second(), spring.b});
}

std::string SpringField::worstElement(ConstRows x) const {
  std::size_t worst = springs_.size();
  double largest = 0;
  for (std::size_t s = 0; s < springs_.size(); ++s) {
    const double stretch = std::abs((x[rows_[s][1]] - x[rows_[s][0]]).norm() - springs_[s].length);
    const double force = springs_[s].stiffness * stretch;
    if (force >= largest) largest = force, worst = s;
  }
  if (worst == springs_.size()) return {};
  const Spring& spring = springs_[worst];
  return fmt::format("spring {} (nodes {} {}): length {:.4g} m, at rest {:.4g} m", worst, spring.a, spring.b,
                     (x[rows_[worst][1]] - x[rows_[worst][0]]).norm(), spring.length);
}

}  // namespace stroma
