// SPDX-License-Identifier: LGPL-2.1-or-later
// Ways of rigid bodies that turn (kept_gaps.h). A corner that turns goes along an arc, and its straight way may cut what the arc goes
// around. So where the straight way of a pair of two rigid bodies touches, ways are looked at that keep the shapes of both,
//   p(s) = c + s d + R(s) (p_0 - c),   R(s) about one axis by the part s of the angle,   s from 0 to 1
// with the middle of the body as c, which then goes straight, or with c on the axis of the screw from start to end. They are followed in
// straight pieces so short that they leave the arc by at most a fiftieth of the gap to keep, and by so much the pieces of a pair stay
// apart. The proof is of all pairs of the two bodies on one such way: where all are free there, the bodies have not met.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "components/contact/kept_gaps.h"

namespace stroma::contact {

namespace {

constexpr int most_pieces = 64;

/// From places of a body to others.
struct RigidMotion {
  Vec3 c = Vec3::Zero(), d = Vec3::Zero();
  Eigen::AngleAxisd turn{0, Vec3::UnitX()};
  double size = 0;  ///< the largest distance of a vertex from c [m]
  bool is_rigid = true;

  RigidMotion(const Vec3* start, const Vec3* end, std::size_t count, bool screws) {
    using Points = Eigen::Map<const Eigen::Matrix3Xd>;
    const Points p(start->data(), 3, Eigen::Index(count)), q(end->data(), 3, Eigen::Index(count));
    c = p.rowwise().mean(), d = q.rowwise().mean() - c;
    const Eigen::Matrix3Xd before = p.colwise() - c, after = q.colwise() - (c + d);
    size = std::sqrt(before.colwise().squaredNorm().maxCoeff());
    if (count == 1) return;
    const Eigen::JacobiSVD<Mat3> svd(after * before.transpose(), Eigen::ComputeFullU | Eigen::ComputeFullV);
    Mat3 mirror = Mat3::Identity();
    mirror(2, 2) = svd.matrixU().determinant() * svd.matrixV().determinant();
    const Mat3 rotation = svd.matrixU() * mirror * svd.matrixV().transpose();
    turn = Eigen::AngleAxisd(rotation);
    constexpr double rounding = 1e-9, least = 1e-3;  // rad: beyond that a screw is a shift
    is_rigid = (rotation * before - after).cwiseAbs().maxCoeff() <= rounding * size;
    if (!screws || turn.angle() < least) return;
    const Vec3 along = turn.axis() * turn.axis().dot(d), across = d - along;
    c += 0.5 * (across + turn.axis().cross(across) / std::tan(0.5 * turn.angle())), d = along;
    size = std::sqrt((p.colwise() - c).colwise().squaredNorm().maxCoeff());
  }
  Vec3 at(double s, const Vec3& place) const {
    return c + s * d + Eigen::AngleAxisd(s * turn.angle(), turn.axis()) * (place - c);
  }
};

}  // namespace

/// All pairs of a and b are free on a way on which both keep their shapes.
bool KeptGaps::areFreeWhileRotating(const BarrierLaw& law, int a, int b, const std::vector<Vec3>& x, bool screws) const {
  constexpr double part = 0.02;  // of the gap to keep
  const Surfaces& s = law.surfaces;
  const auto motionOf = [&](int body) {
    const Surfaces::Body& each = s.bodies()[std::size_t(body)];
    return RigidMotion(&start_[std::size_t(each.first_vertex)], &x[std::size_t(each.first_vertex)], std::size_t(each.vertices), screws);
  };
  const RigidMotion of_a = motionOf(a), of_b = motionOf(b);
  if (!of_a.is_rigid || !of_b.is_rigid) return false;
  const auto piecesOf = [&](const RigidMotion& m) { return std::ceil(m.turn.angle() * std::sqrt(m.size / (8 * part * law.range))); };
  const double wanted = std::max(piecesOf(of_a), piecesOf(of_b));
  if (!(wanted > 1 && wanted <= most_pieces)) return false;
  const int pieces = int(wanted);
  // how far a straight piece leaves its arc: the sagitta size angle^2 / 8
  const auto leaves = [&](const RigidMotion& m) { return m.size * std::pow(m.turn.angle() / pieces, 2) / 8; };
  const double slack = leaves(of_a) + leaves(of_b);
  // no vertex of the two moves farther against one of the other than by d and what both turn
  const double way = (of_a.d - of_b.d).norm() + of_a.size * of_a.turn.angle() + of_b.size * of_b.turn.angle();
  if (!(way <= searchedDistance(a, b))) return false;
  const auto isFree = [&](const Candidate& pair, double start) {
    if (start > 0 && way < certainly_free * start) return true;
    const auto placesAt = [&](int piece) {
      FourPoints places = law.candidates.pointsOf(pair, start_);
      for (std::size_t k = 0; k < 4; ++k)
        places[k] = (s.bodyOf(pair.v[k]) == a ? of_a : of_b).at(double(piece) / pieces, places[k]);
      return places;
    };
    FourPoints places = placesAt(0);
    for (int piece = 0; piece < pieces; ++piece) {
      const FourPoints next = placesAt(piece + 1);
      FourPoints ways = next;
      for (std::size_t k = 0; k < 4; ++k) ways[k] -= places[k];
      const double apart = piece == 0 ? start : leastDistance(pair.kind, places) - pair.radius - (pair.pushes ? law.thickness : 0);
      if (checkPath(law, pair, apart, places, ways, slack).free < 1) return false;
      places = next;
    }
    return true;
  };
  const auto isOfBoth = [&](const Candidate& pair) {
    const int first = s.bodyOf(pair.v[0]), second = s.bodyOf(pair.v[3]);
    return (first == a && second == b) || (first == b && second == a);
  };
  return std::ranges::all_of(all_, [&](const KeptGap& gap) { return !gap.pair || !isOfBoth(*gap.pair) || isFree(*gap.pair, gap.start); }) &&
         std::ranges::all_of(watched_, [&](const Watched& each) { return !isOfBoth(*each.pair) || isFree(*each.pair, each.start); });
}

}  // namespace stroma::contact
