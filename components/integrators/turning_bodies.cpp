// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/integrators/turning_bodies.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <limits>

namespace stroma {

namespace {

/// u with P (J u - L) = 0 and (1 - P) u as it was.
Vec3 heldVelocity(const Mat3& inertia, const Vec3& momentum, const Mat3& projector, const Vec3& u) {
  const Mat3 held = Mat3::Identity() - projector;
  const Mat3 matrix = projector * inertia * projector + held;
  return held * u + matrix.ldlt().solve(projector * (momentum - inertia * (held * u)));
}

}  // namespace

Mat3 TurningBodies::Body::inertiaAt(const Quaternion& q) const {
  if (!turns) return inertia;
  const Mat3 r = q.toRotationMatrix();
  return r * inertia * r.transpose();
}

const Mat3* TurningBodies::projectorOf(Index row) const {
  const Index slot = constraints_->projectorOf(row);
  return slot < 0 ? nullptr : &constraints_->projectors()[std::size_t(slot)].projector;
}

namespace {

/// What all masses of a row have in common about all axes.
double meanInertia(const System& system, Index row) {
  double sum = 0;
  for (const Mass* mass : system.masses()) {
    const Index first = mass->state().firstRow();
    if (row >= first && row < first + mass->state().size()) sum += mass->lumped()[std::size_t(row - first)];
  }
  return sum;
}

}  // namespace

void TurningBodies::compile(const System& system) {
  constraints_ = &system.constraints();
  bodies_.clear();
  std::vector<Index> body_of_row(std::size_t(system.independentRows()), -1);
  for (const Mass* mass : system.masses()) {
    const Index first = mass->state().firstRow();
    if (first >= system.independentRows()) continue;  // System::computeForce() has w x J w of these
    for (const TurningInertia& turning : mass->turningInertias()) {
      const Index row = first + turning.row;
      Index& body = body_of_row[std::size_t(row)];
      if (body < 0) {
        body = Index(bodies_.size());
        bodies_.push_back({row, meanInertia(system, row) * Mat3::Identity(), turning.turns});
      }
      bodies_[std::size_t(body)].inertia += turning.inertia - turning.inertia.trace() / 3 * Mat3::Identity();
    }
  }
  const NodeGroups& groups = constraints_->groups();
  for (Index group = 0; group < groups.count(); ++group) join(system, group, body_of_row);
  std::erase_if(bodies_, [](const Body& body) { return body.row < 0; });
  for (Body& body : bodies_) {
    const Eigen::SelfAdjointEigenSolver<Mat3> principal(body.inertia);
    Mat3 axes = principal.eigenvectors();
    if (axes.determinant() < 0) axes.col(0) *= -1;
    body.moments = principal.eigenvalues(), body.inverse = body.moments.cwiseInverse();
    body.axes = Quaternion(axes).normalized();
  }
}

bool TurningBodies::anyTurns() const {
  return std::any_of(bodies_.begin(), bodies_.end(), [](const Body& body) { return body.turns; });
}

/// Tied bodies have one orientation: their inertias add up in their own axes. The first stays.
void TurningBodies::join(const System& system, Index group, const std::vector<Index>& body_of_row) {
  const NodeGroups& groups = constraints_->groups();
  const auto bodyOf = [&](Index row) { return body_of_row[std::size_t(row)]; };
  const Index* first = std::find_if(groups.begin(group), groups.end(group), [&](Index row) { return bodyOf(row) >= 0; });
  if (first == groups.end(group)) return;
  Body& whole = bodies_[std::size_t(bodyOf(*first))];
  whole.group = group;
  for (const Index* row = groups.begin(group); row != groups.end(group); ++row) {
    if (row == first) continue;
    if (bodyOf(*row) < 0) {
      whole.inertia += meanInertia(system, *row) * Mat3::Identity();
      continue;
    }
    Body& part = bodies_[std::size_t(bodyOf(*row))];
    if (whole.turns != part.turns)
      throw ComponentError(fmt::format("{} and {} are tied, and the inertia of only one of them turns with it",
                                       system.actors().describeRow(*first), system.actors().describeRow(*row)),
                           "turns=\"true\" of both, or turns=\"false\"");
    whole.inertia += part.inertia;
    part.row = -1;
  }
}

void TurningBodies::put(std::size_t body, const Vec3& value, Rows v) const {
  const Index group = bodies_[body].group;
  if (group < 0) return void(v[bodies_[body].row] = value);
  for (const Index* row = constraints_->groups().begin(group); row != constraints_->groups().end(group); ++row)
    v[*row] = value;
}

Vec3 TurningBodies::sum(std::size_t body, ConstRows f) const {
  const Index group = bodies_[body].group;
  if (group < 0) return f[bodies_[body].row];
  Vec3 sum = Vec3::Zero();
  for (const Index* row = constraints_->groups().begin(group); row != constraints_->groups().end(group); ++row)
    sum += f[*row];
  return sum;
}

Vec3 TurningBodies::Body::scaled(const Quaternion& q, const Vec3& factors, const Vec3& w) const {
  const Mat3 r = (turns ? q * axes : axes).toRotationMatrix();
  const double a = factors.x() * r.col(0).dot(w), b = factors.y() * r.col(1).dot(w), c = factors.z() * r.col(2).dot(w);
  return a * r.col(0) + b * r.col(1) + c * r.col(2);
}

Vec3 TurningBodies::times(std::size_t body, ConstRows x, const Vec3& w) const {
  return bodies_[body].scaled(orientationIn(x, row(body)), bodies_[body].moments, w);
}

Vec3 TurningBodies::inverse(std::size_t body, ConstRows x, const Vec3& momentum) const {
  const Body& of = bodies_[body];
  const Quaternion q = orientationIn(x, row(body));
  const Vec3 w = of.scaled(q, of.inverse, momentum);
  // what q is not of length one by would add up from step to step
  return w + of.scaled(q, of.inverse, momentum - of.scaled(q, of.moments, w));
}

void TurningBodies::momenta(ConstRows x, ConstRows v, std::vector<Vec3>& out) const {
  out.resize(count());
  for (std::size_t b = 0; b < count(); ++b) out[b] = times(b, x, v[row(b)]);
}

void TurningBodies::addGyroscopic(ConstRows x, ConstRows v, double factor, Rows out) const {
  for (std::size_t b = 0; b < count(); ++b) {
    const Vec3 w = v[row(b)];
    if (bodies_[b].turns) out[row(b)] += factor * w.cross(times(b, x, w));
  }
}

Vec3 TurningBodies::velocityOf(std::size_t body, ConstRows x, const Vec3& momentum, const Vec3& u) const {
  const Mat3* projector = projectorOf(row(body));
  if (!projector) return inverse(body, x, momentum);
  return heldVelocity(bodies_[body].inertiaAt(orientationIn(x, row(body))), momentum, *projector, u);
}

void TurningBodies::divide(ConstRows x, ConstRows f, Rows a) const {
  for (std::size_t b = 0; b < count(); ++b) put(b, velocityOf(b, x, sum(b, f), Vec3::Zero()), a);
}

void TurningBodies::setVelocities(ConstRows x, const std::vector<Vec3>& momenta, Rows v) const {
  for (std::size_t b = 0; b < count(); ++b) put(b, velocityOf(b, x, momenta[b], v[row(b)]), v);
}

Vec3 TurningBodies::corrected(std::size_t body, ConstRows x, const Vec3& turn, double displacement, const Vec3& w0,
                              const Vec3& u, const Vec3& change) const {
  if (!bodies_[body].turns) return u + change;
  const Mat3 inertia = bodies_[body].inertiaAt(turnedBy(turn + displacement * (u - w0)) * orientationIn(x, row(body)));
  return solve(body, x, turn, displacement, w0, inertia * (u + change), u + change);
}

// Newton's method; the turn by u is taken as additive in its derivative, which costs iterations only. Whatever is left,
// the momentum is L at the orientation that the step ends with.
Vec3 TurningBodies::solve(std::size_t body, ConstRows x, const Vec3& turn, double displacement, const Vec3& w0,
                          const Vec3& momentum, Vec3 u) const {
  const Quaternion q0 = orientationIn(x, row(body));
  const Mat3* projector = projectorOf(row(body));
  const Mat3 free = projector ? *projector : Mat3(Mat3::Identity()), held = Mat3::Identity() - free;
  const auto inertia_for = [&](const Vec3& w) {
    return bodies_[body].inertiaAt(turnedBy(turn + displacement * (w - w0)) * q0);
  };
  if (!bodies_[body].turns) return velocityOf(body, x, momentum, u);
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
