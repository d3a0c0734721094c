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
// root, as the filter of steps does (longest_step.h): the two share no code.
//
// Straight paths are those that the vertices have gone, from one iterate to the next. Of points on frames, which go on arcs, it is what
// the filter has allowed: a straight line, and a deviation by which the products must be above zero.
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
  /// There are threads, points or balls that move, or threads or points without a thickness that do not.
  bool areNeeded() const { return !thin_.empty(); }
  /// Paths start at x. What was found on those of an attempt that has been taken back does not count.
  void startAt(const std::vector<Vec3>& x);
  /// The vertices of bodies are at x, where they have not moved to, and obstacles stay where they are.
  void placeBodies(const std::vector<Vec3>& x);
  /// Everything has moved to x, and what does not bend by the last call of allow() straight.
  void moveTo(const std::vector<Vec3>& x);
  /// The filter allows the motion from x to x + step way. `bend`: how far a vertex may deviate from its line; empty: none does.
  void allow(const std::vector<Vec3>& x, const std::vector<Vec3>& way, const std::vector<double>& bend, double step);
  /// A step has ended; `name` describes a vertex.
  void noteStep(const std::function<std::string(int)>& name);
  /// `doubt`, and a sentence on the steps with paths that have not been proved free.
  std::string doubt(const std::string& path, std::string doubt) const;
  void reset() { forget(), steps_ = 0; }
  void serialize(Archive& archive);

 private:
  void goOnFrom(const std::vector<Vec3>& x) { last_ = x, bend_.clear(); }
  void forget() { last_.clear(), bend_.clear(), one_ = other_ = -1; }
  /// Checks the paths from last_ to x of pairs that bend, or of the others.
  void checkPaths(const std::vector<Vec3>& x, bool bent);
  void checkFaces(int f, int g, const std::vector<Vec3>& x, bool bent);
  void check(PairKind kind, const std::array<int, 4>& v, const std::vector<Vec3>& x, bool bent);
  bool mayMeet(int f, int g) const;
  bool isThin(int f) const {
    const auto& face = surfaces_->faces[std::size_t(f)];
    return face[0] == face[1] && (surfaces_->moves(face[0]) || surfaces_->radius[std::size_t(f)] == 0);
  }
  void fit(const std::vector<int>& faces, const std::vector<Vec3>& x, std::vector<Box>& boxes) const;

  const Surfaces* surfaces_ = nullptr;
  bool self_contact_ = true;
  std::vector<int> thin_, all_;  ///< faces: edges and points; all
  BoxTree thin_tree_, all_tree_;
  std::vector<Box> thin_boxes_, all_boxes_;
  std::vector<Vec3> last_;       ///< empty: no path has begun
  std::vector<double> bend_;     ///< of the last call of allow()
  int one_ = -1, other_ = -1;    ///< vertices of a pair of this step whose path is not proved; -1: none
  int steps_ = 0;                ///< with such pairs
  std::string names_;            ///< of the last of them
};

}  // namespace stroma::contact
