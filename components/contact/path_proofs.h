// SPDX-License-Identifier: LGPL-2.1-or-later
// A second opinion on the paths of threads and points, which an exact test of edges and triangles at the end of a step cannot see: two
// threads that pass through each other cross before and after, seen from any side, and a point leaves no trace.
//
// What can pass through what: an edge of a thread through any edge, and a vertex of a thread, a point or the centre of a ball through a
// triangle. A point cannot pass through a thread: it goes around. Along a straight path from x to x + dx, with t from 0 to 1 and places
// u, v on both sides, the difference of the two sides
//   D(t, u, v) = (1 - u) a0(t) + u a1(t) - (1 - v) b0(t) - v b1(t)   or   p(t) - a(t) - u (b(t) - a(t)) - v (c(t) - a(t))
// is linear in each of t, u and v, so that its values in a box of these lie within the hull of those at the eight corners. If one
// direction has a positive product with all eight, nothing meets in the box; otherwise the box is halved. No distance is computed and no
// root, as the filter of steps does (longest_step.h): the two share no code. Paths that deviate from straight ones by `slack`
// need products above that.
//
// Source: Snyder 1992 (inclusion by subdivision), Wang and others 2021 (the boxes of eight corners).
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "components/contact/contact_surfaces.h"
#include "framework/collision/box_tree.h"
#include "framework/collision/pair_distances.h"
#include "framework/scene/data.h"

namespace stroma {
class Archive;
}

namespace stroma::contact {

/// True: the two sides of a pair have no point in common on the whole path. False: they have, or 4,000 boxes did not decide it.
bool isPathFree(PairKind kind, const FourPoints& x, const FourPoints& dx, double slack = 0);

class PathProofs {
 public:
  void declare(DataTable& table);
  /// `self_contact`: also within a body.
  void compile(const Surfaces& surfaces, bool self_contact);
  /// There are threads, points or balls.
  bool areNeeded() const { return !thin_.empty(); }
  /// Paths start at x.
  void startAt(const std::vector<Vec3>& x);
  /// The vertices of bodies are at x, where they have not moved to, and obstacles stay where they are.
  void placeBodies(const std::vector<Vec3>& x);
  /// Everything has moved straight to x, but for the bends of the last call of bendBy().
  void moveTo(const std::vector<Vec3>& x);
  /// How far the next motion may deviate from a straight one, per vertex; empty: not at all.
  void bendBy(const std::vector<double>& bend) { bend_ = bend; }
  /// A step has ended; `name` describes a vertex.
  void noteStep(const std::function<std::string(int)>& name);
  /// `doubt`, and a sentence on the steps with paths that have not been proved free.
  std::string doubt(const std::string& path, std::string doubt) const;
  void reset() { forget(), steps_ = 0; }
  void serialize(Archive& archive);

 private:
  void forget() { last_.clear(), bend_.clear(), one_ = other_ = -1; }
  void checkFaces(int f, int g, const std::vector<Vec3>& x);
  void check(PairKind kind, const std::array<int, 4>& v, const std::vector<Vec3>& x);
  bool mayMeet(int f, int g) const;
  void fit(const std::vector<int>& faces, const std::vector<Vec3>& x, std::vector<Box>& boxes) const;

  const Surfaces* surfaces_ = nullptr;
  bool self_contact_ = true;
  std::vector<int> thin_, all_;  ///< faces: edges and points; all
  BoxTree thin_tree_, all_tree_;
  std::vector<Box> thin_boxes_, all_boxes_;
  std::vector<Vec3> last_;       ///< empty: no path has begun
  std::vector<double> bend_;
  int one_ = -1, other_ = -1;    ///< vertices of a pair of this step whose path is not proved; -1: none
  int steps_ = 0;                ///< with such pairs
  std::string names_;            ///< of the last of them
};

}  // namespace stroma::contact
