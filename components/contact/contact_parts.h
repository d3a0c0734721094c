// SPDX-License-Identifier: LGPL-2.1-or-later
// Separation proofs from motion bounds. Surfaces are divided into parts. If no pair between two parts was nearer than d, and no
// displacement of one part has since differed by more than m from any displacement of the other, no pair is nearer than d - m:
// a distance changes by at most the relative motion of its two sides. Common motion uses up nothing.
// If parts rotate and stretch, a common motion p -> p + t + G (p - c), with a rotation R = 1 + G - S, is subtracted from the
// displacements of both. It shortens no length l below (1 - |S|) l, and the rest is bounded as above:
//   d' >= (1 - |S|) d - m
// The bound holds along a whole path: R_s from 1 to R, then s S and s times the rest. An exact test that finds no
// intersection at one configuration is therefore valid at all configurations with a positive bound.
#pragma once
#include "components/contact/contact_surfaces.h"
#include "framework/collision/box_tree.h"
#include "framework/collision/pair_distances.h"

namespace stroma::contact {

/// Adjacent triangles of one body.
struct SurfacePart {
  int body = 0;
  std::vector<int> faces, vertices;
};
/// Divides all bodies into parts, with about as many triangles per part as there are parts, and at least 16.
std::vector<SurfacePart> partsOf(const Surfaces& surfaces);

/// The displacements of the vertices of a part.
struct Displacements {
  Box box;
  double longest = 0;  ///< [m]; infinite if one is not finite
};
/// Displacements of all vertices, in a layout for fast reading.
struct AllDisplacements {
  std::vector<Vec3> u;          ///< one more than there are vertices [m]
  std::vector<double> squares;  ///< squared lengths [m^2]
  /// From `from` to x; without `from`, x holds displacements.
  void set(const std::vector<Vec3>& x, const std::vector<Vec3>* from);
};
/// Paths may deviate from straight lines by `bend` [m] per vertex, if given.
Displacements displacementsOf(const SurfacePart& part, const AllDisplacements& way, const std::vector<double>& bend);
/// The same, for queries of few parts.
inline Displacements displacementsOf(const SurfacePart& part, const std::vector<Vec3>& x, const std::vector<Vec3>* from,
                                     const std::vector<double>& bend) {
  AllDisplacements way;
  way.set(x, from);
  return displacementsOf(part, way, bend);
}
/// The box of the displacements of `count` consecutive vertices from `from` to x; without `from`, x holds displacements. Returns
/// false if one is not finite.
bool boxAround(const Vec3* x, const Vec3* from, std::size_t count, Box& box);
/// An upper bound of the difference between displacements in two boxes [m].
inline double boundOfDifference(const Box& a, const Box& b) { return (a.high - b.low).cwiseMax(b.high - a.low).norm(); }
/// An upper bound of the length of displacements in a box [m].
inline double longestIn(const Box& box) { return box.low.cwiseAbs().cwiseMax(box.high.cwiseAbs()).norm(); }
/// An upper bound of the difference between displacements of a and b [m].
double boundOfDifference(const Displacements& a, const Displacements& b);
/// Copies `from` to `to` bytewise.
void copyPlaces(const std::vector<Vec3>& from, std::vector<Vec3>& to);
/// Whether the bits are equal, so that results for one are valid for the other.
bool areSame(const std::vector<Vec3>& a, const std::vector<Vec3>& b);

/// The common motion t + G (p - c) of a part, and its remaining displacements. Any t and G are valid; these are fitted.
struct CommonMotion {
  Vec3 middle = Vec3::Zero(), half = Vec3::Zero();  ///< c, and half the size of the bounding box of its points p [m]
  Vec3 shift = Vec3::Zero();                        ///< t [m]
  Mat3 gradient = Mat3::Zero();                     ///< G
  double shrink = 0;                                ///< |S|
  Box left;                                         ///< box of the remaining displacements [m]
};
/// From p to x.
CommonMotion commonMotionTo(const SurfacePart& part, const std::vector<Vec3>& p, const std::vector<Vec3>& x);
/// Along a straight path p + s dx: here G - S is skew, and the bound is (1 - s |S|) l. `bend` as above.
CommonMotion commonMotionAlong(const SurfacePart& part, const std::vector<Vec3>& p, const std::vector<Vec3>& dx,
                               const std::vector<double>& bend);
/// Sets `left` to the remaining displacements of other vertices under a motion; `dx`: see commonMotionAlong(), otherwise null.
void leaveOf(CommonMotion& motion, const SurfacePart& part, const std::vector<Vec3>& p, const std::vector<Vec3>& x,
             const std::vector<Vec3>* dx, const std::vector<double>& bend);
/// An upper bound of the difference between the remaining displacements of a's and b's parts under the motion of a [m].
double boundOfDifference(const CommonMotion& a, const CommonMotion& b);

/// Whether boxes around the paths of both sides of a pair are farther apart than `distance`: a cheap bound.
bool areFar(PairKind kind, const FourPoints& x, const FourPoints* dx, double distance);
/// A lower bound of the distance of nearly parallel edges, which are frequent in regular grids and slow in closestPoints();
/// -1 for others.
double leastOfParallel(const FourPoints& edges);
/// closestPoints().distance(), or that bound.
double leastDistance(PairKind kind, const FourPoints& x);
/// The smallest distance from a corner or edge of one triangle to the part of the other that it does not share, for corners and edges
/// that also belong to another part; at most `least` [m]. `f_shared`, `g_shared`: bits of such corners, then of the edges from
/// each corner to the next. An edge can only begin to cross a triangle through a distance of 0.
double leastApart(const Surfaces& surfaces, int f, unsigned f_shared, int g, unsigned g_shared, const std::vector<Vec3>& x,
                  double least);
/// Per triangle: bits of the corners and edges that belong to a triangle of another part, or to none.
std::vector<unsigned> sharedFeatures(const Surfaces& surfaces, const std::vector<SurfacePart>& parts);

/// Two parts that may meet, and the results of a search at some configuration. Distances exclude the radii of obstacles.
struct Meeting {
  int a = 0, b = 0;
  double near = -1;     ///< lower bound of the distance of unlisted pairs [m]; negative: never searched
  double clear = 0;     ///< lower bound of the distance to an invalid configuration [m]
  double pushing = 0;   ///< lower bound of the distance of pushing pairs [m]
  double used = 0;      ///< motion up to the reference positions [m]
  double motion = 0;    ///< at the positions of the last query [m]
  long step = 0;        ///< of the last search
  bool is_free = false;    ///< nothing crosses while the motion is less than `clear`
  bool has_faces = false;  ///< near pairs of triangles are listed
};

/// Consecutive parts of one body, so that most of their meetings can be proved at once.
struct PartGroup {
  int first = 0, end = 0;  ///< parts
  Displacements gone{}, goes{};
  void join(const std::vector<Displacements>& of_parts, Displacements& out) const;
};
struct MeetingGroup {
  int a = 0, b = 0;  ///< groups of parts
  std::vector<int> meetings{};
  bool is_counted = false;  ///< the next two values are up to date
  double room = 0;          ///< motion below which none of its meetings has to be checked [m]
  double clear = 0;         ///< motion below which nothing can touch [m]
  double motion = 0;        ///< bound for all of them at the positions of the last query [m]
  bool is_fine = false;     ///< motion is less than `room`, and `motion` of its meetings is not computed
  bool is_free = false;     ///< all of its meetings are free
  bool rests = false;       ///< none of them has to be checked for the path of a step
  void count(const std::vector<Meeting>& all, double reach);
};
/// Two bodies, or a body and itself: the same for all of their groups.
struct BodyMeeting {
  int a = 0, b = 0;  ///< bodies
  std::vector<int> groups{};
  double room = 0, clear = 0;  ///< the smallest of them [m]
  double near = 0;             ///< the largest of their meetings [m]
  double away = 0;             ///< lower bound of the distance of unlisted pairs, less the motion used up [m]
  double motion = 0;           ///< [m]
  bool is_fine = false;        ///< it is less than `room`, and that of groups is not computed
};
/// A body as a whole.
struct WholeBody {
  int first_part = 0, end_part = 0, first_group = 0, end_group = 0;  ///< groups of parts
  SurfacePart all{}, some{};     ///< all vertices; a sample to estimate its rotation
  Box gone{}, goes{};            ///< boxes of all displacements [m]
  bool has_gone = false, can_go = false;  ///< these are finite
  bool is_measured = false, is_way_measured = false;  ///< the displacements of its parts are up to date
  std::vector<Vec3> turned_at{};  ///< positions of its vertices when it was last found to move rigidly; empty: never
  double turned = 0;              ///< remaining motion there [m]
};

}  // namespace stroma::contact
