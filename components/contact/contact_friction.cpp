// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/contact/contact_friction.h"

#include <algorithm>

namespace stroma::contact {

void Friction::compute(const Surfaces& surfaces, const std::vector<Vec3>& x, const std::vector<Vec3>& start,
                       const Vec3& moved) {
  terms_.clear();
  for (const Slide& slide : slides) {
    Term term;
    Vec3 u = slide.on_plane ? Vec3(-moved) : Vec3(Vec3::Zero());
    for (std::size_t i = 0; i < 4; ++i)
      if (const int v = slide.v[i]; v >= 0) {
        u += slide.c[i] * (x[std::size_t(v)] - start[std::size_t(v)]);
        term.rows[i] = surfaces.rows[std::size_t(v)];
      }
    u -= slide.n.dot(u) * slide.n;
    const double length = u.norm(), y = length / slip;
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
