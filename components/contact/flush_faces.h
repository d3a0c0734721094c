// SPDX-License-Identifier: LGPL-2.1-or-later
// Faces of rigid bodies that lie flat on each other. Where the rim of one is above the rim of the other, closest points are on
// both rims, and their direction turns by the slide over the gap: a slide of a micrometre below a gap of a millimetre is a
// thousandth of a radian. Conditions then have directions of their own and contradict each other. So a vertex over the other face
// has that face's direction m, outward, and rims of both have one direction,
//   n = (m_b - m_a) / |m_b - m_a|,   x_a - x_b = d n / (n . m)
// where m is the direction of their distance d, across both rims. There are conditions at the corners of what they have in common,
// seen along n: vertices of one over the other, and rims that cross. These carry every force and moment that a pressure between
// the two faces can have. What is beside has no condition as long as there is one of these; beyond that, closest points tell, as
// on a rim that is rounded by the gap.
//
// A face is what triangles in one plane make of the surface of a body that a rigid frame carries, or of an obstacle. Two are flat
// on each other where a step starts with planes whose distance changes by less than contactDistance over what they have in common,
// and where the closest points of the nearest pair that is on both are on the outer side of each. Along m a tilted box is not
// pushed aside, and vertices of a ball of triangles are pushed along the face that they are on, whichever triangles they are of.
//
// A direction that is off by an angle pushes aside by that part of the force. Of two faces with L in common it is at most
// contactDistance / L, and n is off by half of it from each. Other limits are of cases that this leaves out: 0.1 rad for faces
// that are smaller than ten times the gap, 0.1 rad between rims whose common normal is not to be trusted, 0.01 contactDistance for
// corners that are one. With a third and three times of these, boxes that land tipped, slide over each other, and are aside by as
// much as such corners, an arch and a ball of small triangles have the same heights and tilts to 1e-11. How far friction turns
// a box about the normal depends on which of such places carry: by up to 15 % of the turn and 1 % of the slide where corners are one
// or not, and by a fifth of the 2e-3 rad of a landing where rims at 0.3 rad are taken for nearly parallel ones.
#pragma once
#include <limits>
#include <span>
#include <vector>

#include "components/contact/contact_terms.h"

namespace stroma::contact {

struct KeptGap;

class FlushFaces {
 public:
  /// After `surfaces` have been finished. `rigid`: of each body of them.
  void compile(const Surfaces& surfaces, const std::vector<char>& rigid);
  /// A step starts, with other pairs.
  void begin() { meetings_.clear(), numbers_.clear(), known_count_ = 0, ++step_; }
  /// Where a step starts: whether the sides of a pair may lie in two such faces.
  bool add(KeptGap& gap, const BarrierLaw& law, const std::vector<Vec3>& x);
  /// Gives directions, places and gaps to those at corners (KeptGap::flush). Corners nearer to each other than `together` [m] are one.
  void look(std::vector<KeptGap>& gaps, const std::vector<Vec3>& x, double together);

 private:
  /// Two faces, the first with the smaller number.
  struct Meeting {
    int a, b;
    Vec3 n = Vec3::Zero();  ///< from a to b
    Vec3 of_a = Vec3::Zero(), of_b = Vec3::Zero();  ///< outward
    double tilt = 0;        ///< where the step starts [rad]
    double nearest = std::numeric_limits<double>::infinity();  ///< distance of the nearest pair on both there [m]
    bool is_outside = false;                                   ///< of that pair: each is on the outer side of the other
    bool overlaps = false;
  };
  /// Of a gap at a corner.
  struct Corner {
    std::array<double, 4> c;
    Vec3 n;
    double upright;
  };
  /// Where the step starts: outward; and the number of a meeting of two faces, -1: none.
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

  std::vector<std::array<int, 3>> faces_;       ///< vertices of the largest triangle of each
  std::vector<std::vector<int>> vertices_;      ///< all of each face
  std::vector<int> face_of_;                    ///< of each triangle; -1: none
  std::vector<std::array<int, 2>> edge_faces_;  ///< of each edge
  std::vector<std::vector<int>> around_;        ///< of each vertex
  std::vector<std::vector<int>> at_edges_, at_triangles_;  ///< those around any of their vertices
  std::vector<Outward> outward_;  ///< of each face
  std::vector<Known> known_;      ///< a table with open addresses, of a power of two
  std::size_t known_count_ = 0;   ///< of those of this step
  long step_ = 0;
  std::vector<Meeting> meetings_;
  std::vector<int> numbers_;  ///< of meetings, of one gap after another
  std::vector<Place> places_;  ///< work space
};

}  // namespace stroma::contact
