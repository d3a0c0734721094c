// SPDX-License-Identifier: LGPL-2.1-or-later
// Ways of rigid bodies that turn (kept_gaps.h). A corner that turns goes along an arc, and its straight way may cut what the arc goes
// around. So where the straight way of a pair of two rigid bodies touches, the way of both that keeps their shape is looked at,
//   p(s) = c_0 + s (c_1 - c_0) + R(s) (p_0 - c_0),   R(s) about one axis by the part s of the angle,   s from 0 to 1
// as straight pieces so short that they leave the arc by at most a fiftieth of the gap to keep. The proof is of all pairs of the two
// bodies on this one way: where all are free there, the bodies have not met.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "components/contact/kept_gaps.h"

namespace stroma::contact {

namespace {

constexpr int most_pieces = 64;

/// A rotation and a shift from places of a body to others; `size`: the largest distance of a vertex from its centre [m].
struct RigidMotion {
  Vec3 from = Vec3::Zero(), to = Vec3::Zero();
  Eigen::AngleAxisd turn{0, Vec3::UnitX()};
  double size = 0;
  bool is_rigid = true;

  RigidMotion(const Vec3* start, const Vec3* end, std::size_t count) {
    using Points = Eigen::Map<const Eigen::Matrix3Xd>;
    const Points p(start->data(), 3, Eigen::Index(count)), q(end->data(), 3, Eigen::Index(count));
    from = p.rowwise().mean(), to = q.rowwise().mean();
    const Eigen::Matrix3Xd before = p.colwise() - from, after = q.colwise() - to;
    size = std::sqrt(before.colwise().squaredNorm().maxCoeff());
    if (count == 1) return;
    const Eigen::JacobiSVD<Mat3> svd(after * before.transpose(), Eigen::ComputeFullU | Eigen::ComputeFullV);
    Mat3 mirror = Mat3::Identity();
    mirror(2, 2) = svd.matrixU().determinant() * svd.matrixV().determinant();
    const Mat3 rotation = svd.matrixU() * mirror * svd.matrixV().transpose();
    turn = Eigen::AngleAxisd(rotation);
    constexpr double rounding = 1e-9;
    is_rigid = (rotation * before - after).cwiseAbs().maxCoeff() <= rounding * size;
  }
  Vec3 at(double s, const Vec3& place) const {
    return from + s * (to - from) + Eigen::AngleAxisd(s * turn.angle(), turn.axis()) * (place - from);
  }
};

}  // namespace

/// All pairs of a and b are free on the way on which both keep their shapes.
bool KeptGaps::areFreeTurning(const BarrierLaw& law, int a, int b, const std::vector<Vec3>& x) const {
  constexpr double part = 0.02;  // of the gap to keep
  const Surfaces& s = law.surfaces;
  const auto motionOf = [&](int body) {
    const Surfaces::Body& each = s.bodies()[std::size_t(body)];
    return RigidMotion(&start_[std::size_t(each.first_vertex)], &x[std::size_t(each.first_vertex)], std::size_t(each.vertices));
  };
  const RigidMotion of_a = motionOf(a), of_b = motionOf(b);
  if (!of_a.is_rigid || !of_b.is_rigid) return false;
  const auto piecesOf = [&](const RigidMotion& m) { return std::ceil(m.turn.angle() * std::sqrt(m.size / (8 * part * law.range))); };
  const double wanted = std::max(piecesOf(of_a), piecesOf(of_b));
  if (!(wanted > 1 && wanted <= most_pieces)) return false;
  const int pieces = int(wanted);
  // no vertex of the two moves farther against one of the other than both centres do and both turn
  const double way = ((of_a.to - of_a.from) - (of_b.to - of_b.from)).norm() + of_a.size * of_a.turn.angle() + of_b.size * of_b.turn.angle();
  if (!(way <= lookedFor(a, b))) return false;
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
      if (freeWay(law, pair, apart, places, ways).free < 1) return false;
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
