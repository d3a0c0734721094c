// SPDX-License-Identifier: LGPL-2.1-or-later
// Faces of rigid bodies that lie flat on each other. If the rim of one is above the rim of the other, the closest points are on
// both rims, and their direction rotates by the slide divided by the gap: a slide of a micrometre with a gap of a millimetre is a
// thousandth of a radian. Conditions then have different directions and contradict each other. Therefore a vertex over the other face
// uses the outward normal m of that face, and the rims of both share one direction,
//   n = (m_b - m_a) / |m_b - m_a|,   x_a - x_b = d n / (n . m)
// where m is the direction of their distance d, perpendicular to both rims. Conditions are placed at the corners of the overlap of the
// two faces, seen along n: vertices of one over the other, and crossing rims. These can carry every force and moment that a pressure
// between the two faces can have. Points beside the overlap have no condition as long as there is one of these; otherwise closest
// points are used, as for a rim rounded by the gap.
//
// A face is a set of coplanar triangles of a body on a rigid frame, or of an obstacle. Two faces are flush if at the start of a step
// the distance of their planes varies by less than contactDistance over their overlap, and if the closest points of the nearest pair
// on both are on the outer side of each. Along m a tilted box is not pushed sideways, and vertices of a triangulated ball are pushed
// along the face that they touch, independently of their triangles.
//
// An error of the direction by some angle adds that fraction of the force sideways. For two faces with an overlap of length L it is
// at most contactDistance / L, and n deviates from each normal by half of it. Further thresholds cover the remaining cases: 0.1 rad
// for faces smaller than ten times the gap, 0.1 rad between rims whose common normal is unreliable, and 0.01 contactDistance for
// merging corners. With a third and three times these values, tests with boxes that land tilted, slide over each other, or are offset
// by such a distance, an arch, and a ball of small triangles have the same heights and tilts to 1e-11. Rotation of a box about the
// normal by friction depends on which of these points carry load: by up to 15 % of the rotation and 1 % of the slide if corners merge
// or not, and by a fifth of the 2e-3 rad of a landing if rims at 0.3 rad are treated as nearly parallel.
#pragma once
#include <limits>
#include <span>
#include <vector>

#include "components/contact/contact_terms.h"

namespace stroma::contact {

struct KeptGap;

class FlushFaces {
 public:
  /// Call it when `surfaces` are finished. `rigid`: per body.
  void compile(const Surfaces& surfaces, const std::vector<char>& rigid);
  /// Starts a step with new pairs.
  void begin() { meetings_.clear(), numbers_.clear(), known_count_ = 0, ++step_; }
  /// At the start of a step: whether the two sides of a pair may lie in flush faces.
  bool add(KeptGap& gap, const BarrierLaw& law, const std::vector<Vec3>& x);
  /// Sets directions, points and gaps at corners (KeptGap::flush). Corners closer than `together` [m] are merged.
  void look(std::vector<KeptGap>& gaps, const std::vector<Vec3>& x, double together);

 private:
  /// Two faces, the first with the smaller number.
  struct Meeting {
    int a, b;
    Vec3 n = Vec3::Zero();  ///< from a to b
    Vec3 of_a = Vec3::Zero(), of_b = Vec3::Zero();  ///< outward normals
    double tilt = 0;        ///< at the start of the step [rad]
    double nearest = std::numeric_limits<double>::infinity();  ///< distance of the nearest pair on both there [m]
    bool is_outside = false;                                   ///< each side of that pair is on the outer side of the other
    bool overlaps = false;
  };
  /// For a gap at a corner.
  struct Corner {
    std::array<double, 4> c;
    Vec3 n;
    double upright;
  };
  /// At the start of the step: outward normals; and the number of a meeting of two faces, -1: none.
  struct Outward {
    Vec3 n;
    long step = -1;
  };
  struct Known {
    int a, b, number;
    long step = -1;
  };
  struct Place {
    int meeting;
    bool crosses;
    Vec3 x;
    double apart;
    std::size_t gap;
  };
  void facesAt(const auto& cells, std::vector<std::vector<int>>& all) const;
  std::span<const int> numbersOf(const KeptGap& gap) const;
  Vec3 outward(int face, const std::vector<Vec3>& x) const;
  const Vec3& outwardAtStart(int face, const std::vector<Vec3>& x);
  Known& knownOf(int a, int b);
  bool isOn(int face, int vertex) const;
  bool isRim(int edge, int face) const;
  int meetingOf(int a, int b, double range, const std::vector<Vec3>& x);
  double openingOf(int a, int b, const Vec3& way, const std::vector<Vec3>& x) const;
  bool isOnBoth(const KeptGap& gap, const Meeting& meeting) const;
  bool place(const KeptGap& gap, const Meeting& meeting, const std::vector<Vec3>& x, double together, Corner& corner) const;
  void joinNear(std::vector<KeptGap>& gaps, double together);

  std::vector<std::array<int, 3>> faces_;       ///< per face: vertices of its largest triangle
  std::vector<std::vector<int>> vertices_;      ///< per face: all vertices
  std::vector<int> face_of_;                    ///< per triangle; -1: none
  std::vector<std::array<int, 2>> edge_faces_;  ///< per edge
  std::vector<std::vector<int>> around_;        ///< per vertex
  std::vector<std::vector<int>> at_edges_, at_triangles_;  ///< faces around any of their vertices
  std::vector<Outward> outward_;  ///< per face
  std::vector<Known> known_;      ///< a hash table with open addressing; its size is a power of two
  std::size_t known_count_ = 0;   ///< entries of this step
  long step_ = 0;
  std::vector<Meeting> meetings_;
  std::vector<int> numbers_;  ///< of meetings, gap after gap
  std::vector<Place> places_;  ///< work space
};

}  // namespace stroma::contact
