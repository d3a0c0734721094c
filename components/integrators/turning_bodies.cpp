// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/integrators/turning_bodies.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <limits>

namespace stroma {

namespace {

/// u with P (J u - L) = 0 and (1 - P) u as it was.
Vec3 velocityOf(const Mat3& inertia, const Vec3& momentum, const Mat3* projector, const Vec3& u) {
  if (!projector) return inertia.ldlt().solve(momentum);
  const Mat3 held = Mat3::Identity() - *projector;
  const Mat3 matrix = *projector * inertia * *projector + held;
  return held * u + matrix.ldlt().solve(*projector * (momentum - inertia * (held * u)));
}

const Mat3* projectorOf(const ConstraintSet& constraints, Index row) {
  const Index slot = constraints.projectorOf(row);
  return slot < 0 ? nullptr : &constraints.projectors()[std::size_t(slot)].projector;
}

}  // namespace

Mat3 TurningBodies::Body::inertiaAt(const Quaternion& q) const {
  if (!turns) return inertia;
  const Mat3 r = q.toRotationMatrix();
  return r * inertia * r.transpose();
}

void TurningBodies::compile(const System& system) {
  bodies_.clear();
  for (const Mass* mass : system.masses()) {
    const Index first = mass->state().firstRow();
    if (first >= system.independentRows()) continue;  // System::computeForce() has w x J w of these
    for (const TurningInertia& turning : mass->turningInertias())
      bodies_.push_back({first + turning.row, turning.inertia, turning.turns});
  }
}

Mat3 TurningBodies::inertia(std::size_t body, ConstRows x) const {
  return bodies_[body].inertiaAt(orientationIn(x, row(body)));
}

void TurningBodies::momenta(ConstRows x, ConstRows v, std::vector<Vec3>& out) const {
  out.resize(count());
  for (std::size_t b = 0; b < count(); ++b) out[b] = inertia(b, x) * v[row(b)];
}

void TurningBodies::addGyroscopic(ConstRows x, ConstRows v, double factor, Rows out) const {
  for (std::size_t b = 0; b < count(); ++b) {
    const Vec3 w = v[row(b)];
    if (bodies_[b].turns) out[row(b)] += factor * w.cross(inertia(b, x) * w);
  }
}

void TurningBodies::divide(ConstRows x, ConstRows f, Rows a) const {
  for (std::size_t b = 0; b < count(); ++b) a[row(b)] = inertia(b, x).ldlt().solve(Vec3(f[row(b)]));
}

void TurningBodies::setVelocities(ConstRows x, const std::vector<Vec3>& momenta, const ConstraintSet& constraints,
                                  Rows v) const {
  for (std::size_t b = 0; b < count(); ++b)
    v[row(b)] = velocityOf(inertia(b, x), momenta[b], projectorOf(constraints, row(b)), v[row(b)]);
}

// Newton's method; the turn by u is taken as additive in its derivative, which costs iterations only. Whatever is left,
// the momentum is L at the orientation that the step ends with.
Vec3 TurningBodies::solve(std::size_t body, ConstRows x, const Vec3& turn, double displacement, const Vec3& w0,
                          const Vec3& momentum, const ConstraintSet& constraints, Vec3 u) const {
  const Quaternion q0 = orientationIn(x, row(body));
  const Mat3* projector = projectorOf(constraints, row(body));
  const Mat3 free = projector ? *projector : Mat3(Mat3::Identity()), held = Mat3::Identity() - free;
  const auto inertia_for = [&](const Vec3& w) {
    return bodies_[body].inertiaAt(turnedBy(turn + displacement * (w - w0)) * q0);
  };
  if (!bodies_[body].turns) return velocityOf(bodies_[body].inertia, momentum, projector, u);
  double before = std::numeric_limits<double>::infinity();
  for (int iteration = 0; iteration < 50; ++iteration) {
    const Mat3 inertia = inertia_for(u);
    const Vec3 spin = inertia * u, residual = free * (momentum - spin);
    const Mat3 slope = inertia + displacement * (inertia * crossMatrix(u) - crossMatrix(spin));
    const Vec3 change = (free * slope * free + held).partialPivLu().solve(residual);
    const double size = change.norm();
    if (!(size > 1e-15 * u.norm()) || (iteration > 8 && size >= before)) break;
    before = size;
    u += change;
  }
  return u;
}

}  // namespace stroma
