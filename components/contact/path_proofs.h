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
#include <array>
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
  /// There are threads, points or balls, of bodies or as obstacles.
  bool areNeeded() const { return !thin_.empty(); }
  /// Paths start at x. What has not been proved before in this step stays so.
  void startAt(const std::vector<Vec3>& x);
  /// Paths start again at the x of the last startAt(): what has moved since was taken back, and does not count.
  void startAgain(const std::vector<Vec3>& x);
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
  using Pair = std::array<int, 2>;  ///< vertices; -1: none
  static constexpr Pair none{-1, -1};
  void forget() { last_.clear(), bend_.clear(), kept_ = found_ = none; }
  void place(const std::vector<Vec3>& x);
  /// Checks the paths from last_ to x of pairs that bend, or of the others.
  void checkPaths(const std::vector<Vec3>& x, bool bent);
  void checkFaces(int f, int g, const std::vector<Vec3>& x, bool bent);
  void check(PairKind kind, const std::array<int, 4>& v, const std::vector<Vec3>& x, bool bent);
  bool mayMeet(int f, int g) const;
  bool isThin(int f) const {
    const auto& face = surfaces_->faces[std::size_t(f)];
    return face[0] == face[1];
  }
  Box boxOf(int f, const std::vector<Vec3>& x) const;
  void fitThin(const std::vector<Vec3>& x);
  bool mayMeetThin(const Surfaces::Body& body, const std::vector<Vec3>& x) const;

  const Surfaces* surfaces_ = nullptr;
  bool self_contact_ = true;
  std::vector<int> thin_;  ///< faces: edges and points
  BoxTree thin_tree_;      ///< of their paths
  std::vector<Box> thin_boxes_;
  std::vector<Vec3> last_, end_;  ///< empty: no path has begun; of paths that bend
  std::vector<double> bend_;      ///< of the last call of allow()
  Pair kept_ = none, found_ = none;  ///< not proved in this step: before the last startAt(), and since
  int steps_ = 0;                 ///< with such pairs
  std::string names_;             ///< of the last of them
};

}  // namespace stroma::contact
