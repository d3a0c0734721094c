// SPDX-License-Identifier: LGPL-2.1-or-later
// What is proved by how far things have moved. Surfaces are cut into parts. Where no pair of two parts was nearer than d, and no
// displacement of one has since differed by more than m from any of the other, no pair is nearer than d - m now: each distance
// changes by no more than its two sides move against each other. What moves along together has used up nothing.
// Where parts turn and stretch, p -> p + t + G (p - c) with R = 1 + G - S a rotation, is taken off the displacements of both first.
// Under that alone no length l becomes shorter than (1 - |S|) l; what is left over counts as above:
//   d' >= (1 - |S|) d - m
// The bound holds on a whole way to there: R_s from 1 to R, then s S and s times what is left over. So an exact test that has
// found nothing at one place holds at all that such a bound above zero is known of.
#pragma once
#include "components/contact/contact_surfaces.h"
#include "framework/collision/box_tree.h"
#include "framework/collision/pair_distances.h"

namespace stroma::contact {

/// Triangles of one body that lie side by side.
struct SurfacePart {
  int body = 0;
  std::vector<int> faces, vertices;
};
/// All bodies in parts of about as many triangles as there are parts, and of no fewer than 16.
std::vector<SurfacePart> partsOf(const Surfaces& surfaces);

/// Of the vertices of a part.
struct Displacements {
  Box box;
  double longest = 0;  ///< [m]; infinite where one is no number
};
/// Displacements of all vertices, in a shape that is read fast.
struct AllDisplacements {
  std::vector<Vec3> u;          ///< one more than there are vertices [m]
  std::vector<double> squares;  ///< of their lengths [m^2]
  /// From `from` to x; without `from`, x are displacements.
  void set(const std::vector<Vec3>& x, const std::vector<Vec3>* from);
};
/// Each is up to its `bend` [m] off besides, if there is any.
Displacements displacementsOf(const SurfacePart& part, const AllDisplacements& way, const std::vector<double>& bend);
/// The same where few parts are asked for.
inline Displacements displacementsOf(const SurfacePart& part, const std::vector<Vec3>& x, const std::vector<Vec3>* from,
                                     const std::vector<double>& bend) {
  AllDisplacements way;
  way.set(x, from);
  return displacementsOf(part, way, bend);
}
/// Around the displacements of `count` vertices that lie side by side, from `from` to x; without `from`, x are displacements.
/// False: one is no number.
bool boxAround(const Vec3* x, const Vec3* from, std::size_t count, Box& box);
/// No displacement in one box differs by more from one in the other [m].
inline double mostApart(const Box& a, const Box& b) { return (a.high - b.low).cwiseMax(b.high - a.low).norm(); }
/// None in it is longer [m].
inline double longestIn(const Box& box) { return box.low.cwiseAbs().cwiseMax(box.high.cwiseAbs()).norm(); }
/// No displacement of a differs by more from one of b [m].
double mostApart(const Displacements& a, const Displacements& b);
/// `to` becomes `from`, as a copy of bytes.
void copyPlaces(const std::vector<Vec3>& from, std::vector<Vec3>& to);
/// The same bits: what followed from one follows from the other.
bool areSame(const std::vector<Vec3>& a, const std::vector<Vec3>& b);

/// The motion of a part as a whole, t + G (p - c), and what it leaves of its displacements. Any t and G will do; these are fitted.
struct CommonMotion {
  Vec3 middle = Vec3::Zero(), half = Vec3::Zero();  ///< c and half the size of the box of its points p [m]
  Vec3 shift = Vec3::Zero();                        ///< t [m]
  Mat3 gradient = Mat3::Zero();                     ///< G
  double shrink = 0;                                ///< |S|
  Box left;                                         ///< of the displacements [m]
};
/// From p to x.
CommonMotion commonMotionTo(const SurfacePart& part, const std::vector<Vec3>& p, const std::vector<Vec3>& x);
/// Along a straight way, p + s dx: here G - S is skew, and the bound is (1 - s |S|) l. `bend` as above.
CommonMotion commonMotionAlong(const SurfacePart& part, const std::vector<Vec3>& p, const std::vector<Vec3>& dx,
                               const std::vector<double>& bend);
/// Makes `left` what a motion leaves of the displacements of other vertices; `dx`: see commonMotionAlong(), else null.
void leaveOf(CommonMotion& motion, const SurfacePart& part, const std::vector<Vec3>& p, const std::vector<Vec3>& x,
             const std::vector<Vec3>* dx, const std::vector<double>& bend);
/// What the motion of a leaves of a displacement of its part differs by no more from what it leaves of one of b's part [m].
double mostApart(const CommonMotion& a, const CommonMotion& b);

/// Boxes around both sides of a pair on their way are farther apart than `distance`: a bound that costs little.
bool areFar(PairKind kind, const FourPoints& x, const FourPoints* dx, double distance);
/// A lower bound of the distance of nearly parallel edges, which regular grids have many of and closestPoints() takes long for;
/// -1 for others.
double leastOfParallel(const FourPoints& edges);
/// closestPoints().distance(), or that bound.
double leastDistance(PairKind kind, const FourPoints& x);
/// The smallest distance of a corner or an edge of one triangle from what the other does not share with it, of those that belong to a
/// triangle of another part; no more than `least` [m]. `f_strangers`, `g_strangers`: bits of corners that do, then of edges from each
/// corner to the next. An edge comes to cross a triangle only through a distance of 0.
double leastApart(const Surfaces& surfaces, int f, unsigned f_strangers, int g, unsigned g_strangers, const std::vector<Vec3>& x,
                  double least);
/// Of all triangles: bits of what belongs to a triangle of another part, or to none.
std::vector<unsigned> strangersOf(const Surfaces& surfaces, const std::vector<SurfacePart>& parts);

/// Two parts that may meet, and what a search at some positions has found out. Distances are less radii of obstacles.
struct Meeting {
  int a = 0, b = 0;
  double near = -1;     ///< what is not listed was no nearer [m]; negative: never looked for
  double clear = 0;     ///< nor was anything nearer than this to where it may not be [m]
  double pushing = 0;   ///< nor was what pushes [m]
  double used = 0;      ///< motion up to the positions that motion is measured from [m]
  double motion = 0;    ///< at the positions asked last [m]
  long step = 0;        ///< in which was looked
  bool is_free = false;    ///< nothing crosses as long as the motion is less than `clear`
  bool has_faces = false;  ///< near pairs of triangles are listed
};

/// Parts of one body that follow each other, so that most of what is known of their meetings is proved at once.
struct PartGroup {
  int first = 0, end = 0;  ///< parts
  Displacements gone{}, goes{};
  void join(const std::vector<Displacements>& of_parts, Displacements& out) const;
};
struct MeetingGroup {
  int a = 0, b = 0;  ///< groups of parts
  std::vector<int> meetings{};
  bool is_counted = false;  ///< the following two are those of its meetings
  double room = 0;          ///< motion that none of them has to be looked at for [m]
  double clear = 0;         ///< motion until something may touch [m]
  double motion = 0;        ///< at the positions asked last, of each of them [m]
  bool is_fine = false;     ///< that is less than `room`: `motion` of its meetings is not known
  bool is_free = false;     ///< so are all of its meetings
  bool rests = false;       ///< nor has any of them to be looked at for the way of a step
  void count(const std::vector<Meeting>& all, double reach);
};
/// Two bodies, or a body and itself: the same of all of their groups.
struct BodyMeeting {
  int a = 0, b = 0;  ///< bodies
  std::vector<int> groups{};
  double room = 0, clear = 0;  ///< the least of them [m]
  double near = 0;             ///< the largest of their meetings [m]
  double away = 0;             ///< what was not listed was no nearer, less the motion used up [m]
  double motion = 0;           ///< [m]
  bool is_fine = false;        ///< it is less than `room`: that of groups is not known
};
/// What is known of a body as a whole.
struct WholeBody {
  int first_part = 0, end_part = 0, first_group = 0, end_group = 0;  ///< groups of parts
  SurfacePart all{}, some{};     ///< its vertices; enough of them to see how it turns
  Box gone{}, goes{};            ///< around all displacements [m]
  bool has_gone = false, can_go = false;  ///< these are numbers
  bool is_measured = false, is_way_measured = false;  ///< so it is of its parts
  std::vector<Vec3> turned_at{};  ///< of its vertices, where it was last found to turn as one; none: nowhere
  double turned = 0;              ///< what was left of its motion there [m]
};

}  // namespace stroma::contact
