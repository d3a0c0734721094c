// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <limits>
#include <string>

#include "components/contact/contact_surfaces.h"
#include "components/contact/longest_step.h"
#include "framework/collision/box_tree.h"

namespace stroma::contact {

/// A vertex and a triangle, or two edges, that are near enough to be looked at.
struct Candidate {
  PairKind kind;
  int first, second;     ///< vertex and triangle, or two edges
  std::array<int, 4> v;  ///< vertices
  double radius;         ///< both surfaces' [m]
  bool pushes = true;    ///< false: near at rest already, and only kept from crossing
  double factor = std::numeric_limits<double>::quiet_NaN();  ///< of two edges, see contact_terms.h; not known yet
  double tried = factor, found = factor;                     ///< the factor of the solve before, and the one that followed from it
  bool operator<(const Candidate& o) const {
    return kind != o.kind ? kind < o.kind : first != o.first ? first < o.first : second < o.second;
  }
};

/// A plane that pushes what is below it: bodies are where n.x > offset.
struct Plane {
  Vec3 normal;
  double offset;
};

/// The pairs of an interaction that are nearer than a reach, as long as no vertex has moved farther than a margin since
/// they were looked for; ways and crossings of all pairs.
class Candidates {
 public:
  bool self_contact = true;
  double reach = 0;  ///< distance at which pairs begin to count [m]

  void compile(const Surfaces& surfaces);
  /// All pairs that may come nearer than `reach` while no vertex moves farther than `margin` from x. What was known of a
  /// pair stays with it. False: those that push are the same as before.
  bool find(const std::vector<Vec3>& x, double margin);
  void forget() { found_at_.clear(), pairs_.clear(), ++revision_; }
  /// Grows with each find().
  long revision() const { return revision_; }
  bool covers(const std::vector<Vec3>& x) const;
  std::vector<Candidate>& pairs() { return pairs_; }
  const std::vector<Candidate>& pairs() const { return pairs_; }
  /// The largest s <= 1 up to which the vertices may move from x to x + s dx. `bend`: how far each may be off that line on
  /// its way [m]; empty: not at all.
  double longestStep(const std::vector<Vec3>& x, const std::vector<Vec3>& dx, const std::vector<double>& bend,
                     double thickness);
  /// An edge that has a point in common with a triangle; of the vertices of both.
  struct Crossing {
    int edge, face;
    double depth;  ///< how far the edge reaches through the plane of the triangle [m]
  };
  std::vector<Crossing> crossings(const std::vector<Vec3>& x);
  FourPoints pointsOf(const Candidate& pair, const std::vector<Vec3>& x) const {
    return {x[std::size_t(pair.v[0])], x[std::size_t(pair.v[1])], x[std::size_t(pair.v[2])], x[std::size_t(pair.v[3])]};
  }
  // what has to be known to find the same pairs again
  std::vector<Vec3>& foundAt() { return found_at_; }
  double& margin() { return margin_; }

 private:
  bool mayMeet(int body_a, int body_b) const;
  bool doOthersPush() const;
  bool isNearAtRest(const Candidate& pair) const;
  bool coversWay(const std::vector<Vec3>& x, const std::vector<Vec3>& dx, const std::vector<double>& bend) const;
  void fit(const std::vector<Vec3>& x, const std::vector<Vec3>* dx, const std::vector<double>& bend);
  template <class Visit>
  void forEachNearPair(double margin, Visit&& visit) const;
  template <class Visit>
  void pairsOf(int f, int g, Visit&& visit) const;
  Candidate vertexAndFace(int vertex, int face) const;
  Candidate twoEdges(int a, int b, double radius) const;

  const Surfaces* surfaces_ = nullptr;
  std::vector<BoxTree> trees_;  ///< one per body
  std::vector<std::vector<Box>> boxes_;
  std::vector<Candidate> pairs_, old_pairs_;
  std::vector<std::array<int, 2>> face_pairs_;
  std::vector<Vec3> found_at_;
  double margin_ = 0;
  long revision_ = 0;
};

}  // namespace stroma::contact
