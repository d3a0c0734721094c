// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <compare>
#include <deque>
#include <limits>
#include <string>
#include <utility>

#include "components/contact/contact_parts.h"
#include "components/contact/longest_step.h"

namespace stroma {
class Archive;
}

namespace stroma::contact {

/// A vertex and a triangle, or two edges, that are near enough to be looked at.
struct Candidate {
  PairKind kind;
  int first, second;     ///< vertex and triangle, or two edges
  std::array<int, 4> v;  ///< vertices
  double radius;         ///< both surfaces' [m]
  double distance = 0;   ///< where it was found, less the radius [m]
  int meeting = 0;       ///< of the parts that its sides belong to
  bool pushes = true;    ///< false: near at rest already, and only kept from crossing
  double factor = std::numeric_limits<double>::quiet_NaN();  ///< of two edges, see contact_terms.h; not known yet
  double tried = factor, found = factor;                     ///< the factor of the solve before, and the one that followed from it
  bool operator<(const Candidate& o) const {
    return kind != o.kind ? kind < o.kind : first != o.first ? first < o.first : second < o.second;
  }
};

/// A pair without what is known of it.
struct PairName {
  PairKind kind;
  int first, second;
  auto operator<=>(const PairName&) const = default;
};

/// A plane that pushes what is below it: bodies are where n.x > offset.
struct Plane {
  Vec3 normal;
  double offset;
};

/// The pairs of an interaction that are nearer than a reach; ways and crossings of all pairs. Each two parts of the surfaces have
/// a proof of what they do not need (contact_parts.h): while it holds, neither pairs nor crossings are looked for between them.
class Candidates {
 public:
  bool self_contact = true;
  double reach = 0;      ///< distance at which pairs begin to count [m]
  double thickness = 0;  ///< distance at which surfaces that push touch, in `reach` [m]
  double reach_at_rest = -1;  ///< places of one piece that are nearer at rest do not push [m]; below zero: `reach`

  void compile(const Surfaces& surfaces);
  /// Another step begins: margins follow what things move in one.
  void stepBegins() { ++step_; }
  /// All pairs that may come nearer than `reach` while no vertex moves farther than `margin` from x; nothing is
  /// known of them. False: none that pushes is new in patternPairs().
  bool find(const std::vector<Vec3>& x, double margin);
  /// The same with a margin of each two bodies, margin(a, b).
  template <class Margin>
  bool findWithin(const std::vector<Vec3>& x, Margin&& margin) {
    forget(), startFrom(x);
    for (std::size_t m = 0; m < meetings_.size(); ++m)
      search(int(m), x, margin(parts_[std::size_t(meetings_[m].a)].body, parts_[std::size_t(meetings_[m].b)].body));
    return takeFound();
  }
  /// Pairs of two bodies whose distance at x is above `from` and up to `to` [m], which find() there has left out.
  void addFarther(int body_a, int body_b, const std::vector<Vec3>& x, double from, double to, std::deque<Candidate>& out);
  /// The same where motion up to x has used up what was known, with margins that last for some steps. What was known of a pair
  /// stays with it. False: as above.
  bool findAgain(const std::vector<Vec3>& x, double least_margin, double most_margin);
  void forget();
  /// Grows when there are others.
  long revision() const { return revision_; }
  /// x stays what it is until this is called again: nothing is asked twice there.
  void placedAt(const std::vector<Vec3>& x) { placed_ = x.data(), is_placed_followed_ = false; }
  /// All pairs that are nearer than `reach` at x are known.
  bool covers(const std::vector<Vec3>& x) { return follow(x); }
  /// The last search has found no pairs, and nothing is nearer than `distance` now.
  bool areFarther(const std::vector<Vec3>& x, double distance);
  /// Nothing has been looked for yet.
  bool isNew() const { return found_at_.empty(); }
  /// What a matrix has places for: pairs that push, and others that have, so that it seldom needs another pattern.
  const std::vector<PairName>& patternPairs() const { return pattern_; }
  std::array<int, 4> verticesOf(const PairName& pair) const;
  std::vector<Candidate>& pairs() { return pairs_; }
  const std::vector<Candidate>& pairs() const { return pairs_; }
  // ---- at the x of the last covers() ----
  /// False: nothing that pushes is nearer than `reach`.
  bool mayPush() const { return may_push_; }
  bool mayPush(const Candidate& pair) const {
    return pair.pushes && !isFine(pair.meeting) && pair.distance - meetings_[std::size_t(pair.meeting)].motion < reach;
  }
  /// The largest s <= 1 up to which the vertices may move from x to x + s dx. `bend`: how far each may be off that line on
  /// its way [m]; empty: not at all.
  double longestStep(const std::vector<Vec3>& x, const std::vector<Vec3>& dx, const std::vector<double>& bend);
  /// An edge that has a point in common with a triangle; of the vertices of both.
  struct Crossing {
    int edge, face;
    double depth;  ///< how far the edge reaches through the plane of the triangle [m]
  };
  std::vector<Crossing> crossings(const std::vector<Vec3>& x);
  FourPoints pointsOf(const Candidate& pair, const std::vector<Vec3>& x) const {
    return {x[std::size_t(pair.v[0])], x[std::size_t(pair.v[1])], x[std::size_t(pair.v[2])], x[std::size_t(pair.v[3])]};
  }
  void serialize(Archive& archive);
  /// What has been done since the last forget(): what two parts need counts as one.
  struct Work {
    long searches = 0;  ///< of pairs, where two parts were or of the way they want to go
    long ways = 0;      ///< pairs whose way was looked at
    long tests = 0;     ///< of crossings
    long all() const { return searches + ways + tests; }
  };
  const Work& work() const { return work_; }

 private:
  bool mayMeet(int body_a, int body_b) const;
  bool needsPattern();
  bool isNearAtRest(const Candidate& pair) const;
  void group();
  bool isFine(int meeting) const { return groups_[std::size_t(group_of_[std::size_t(meeting)])].is_fine; }
  bool follow(const std::vector<Vec3>& x);
  bool isFollowed(const std::vector<Vec3>& x) const {
    return is_followed_ && (x.data() == placed_ ? is_placed_followed_ : areSame(x, followed_));
  }
  void follow(MeetingGroup& group, const std::vector<Vec3>& x);
  void followParts(const BodyMeeting& each, const std::vector<Vec3>& x);
  void measureParts(WholeBody& body, const std::vector<Vec3>& x);
  void restGroups(const std::vector<Vec3>& x);
  // ---- contact_wholes.cpp ----
  void joinBodies();
  void countBodies();
  bool followBodies(const std::vector<Vec3>& x);
  bool turnsAsOne(BodyMeeting& body, const std::vector<Vec3>& x);
  bool restBodies(const std::vector<Vec3>& x, const std::vector<Vec3>& dx, const std::vector<double>& bend);
  bool goesAsOne(const BodyMeeting& body, const std::vector<Vec3>& x, const std::vector<Vec3>& dx, const std::vector<double>& bend,
                 double most) const;
  bool areAllFree() const;
  double roundOff(double motion) const { return 4e-12 * (size_ + motion); }
  double goneOf(const Meeting& meeting) const {
    return gone_[std::size_t(meeting.a)].longest + gone_[std::size_t(meeting.b)].longest;
  }
  double roundOffOf(const Meeting& meeting) const { return goneOf(meeting) > 0 ? roundOff(goneOf(meeting)) : 0; }
  void takeOffShift(Meeting& meeting);
  void takeOffTurns(Meeting& meeting, const std::vector<Vec3>& x);
  double takeOffTurns(const Meeting& meeting, const std::vector<Vec3>& x, const std::vector<Vec3>& dx,
                      const std::vector<double>& bend, double way);
  double budgetOf(const Meeting& meeting) const { return meeting.near - reach; }
  void startFrom(const std::vector<Vec3>& x);
  void search(int meeting, const std::vector<Vec3>& x, double margin);
  bool takeFound();
  // Boxes are around x, or around the way from there to x + step dx.
  void fit(int part, const std::vector<Vec3>& x, const std::vector<Vec3>* dx, const std::vector<double>& bend, double step = 1);
  void fitBoth(const Meeting& meeting, const std::vector<Vec3>& x, const std::vector<Vec3>* dx, const std::vector<double>& bend,
               double step = 1);
  void fitNone() { std::fill(is_fit_.begin(), is_fit_.end(), false); }
  template <class Visit>
  void forEachNearPair(const Meeting& meeting, double margin, Visit&& visit) const;
  template <class Visit>
  void pairsOf(int f, int g, Visit&& visit) const;
  Candidate vertexAndFace(int vertex, int face) const;
  Candidate twoEdges(int a, int b, double radius) const;
  bool findWays(const std::vector<Vec3>& x, const std::vector<Vec3>& dx, const std::vector<double>& bend, bool knows_any);
  bool hasRoom(std::size_t meeting, double room, double step) const;
  double roundingOf(std::size_t meeting, double step) const;
  void shorten(const Candidate& pair, const std::vector<Vec3>& x, const std::vector<Vec3>& dx, const std::vector<double>& bend,
               double& step);
  void testFaces(int from, int to, const std::vector<Vec3>& x, std::vector<Crossing>& found) const;
  void readPairs(const std::vector<int>& numbers, const std::vector<double>& distances);
  void readPattern(const std::vector<int>& numbers);

  const Surfaces* surfaces_ = nullptr;
  std::vector<SurfacePart> parts_;
  std::vector<unsigned> strangers_;      ///< of each triangle, see leastApart()
  std::vector<BoxTree> trees_;           ///< one per part
  std::vector<std::vector<Box>> boxes_;  ///< of its triangles
  std::vector<char> is_fit_;             ///< these boxes are of what is looked for now
  std::vector<Displacements> gone_, goes_;  ///< of each part, to x and on its way
  std::vector<CommonMotion> turned_, turns_;  ///< the same as a whole; made where asked for
  std::vector<char> is_turned_, does_turn_;   ///< they are made
  double radii_ = 0;                          ///< the largest of two triangles [m]
  std::vector<Meeting> meetings_;
  std::vector<WholeBody> bodies_;
  std::vector<BodyMeeting> body_meetings_;
  bool are_bodies_counted_ = false;
  std::vector<PartGroup> part_groups_;
  std::vector<MeetingGroup> groups_;
  std::vector<int> group_of_;  ///< of each meeting
  AllDisplacements gone_way_, goes_way_;    ///< of all vertices; work space
  bool has_gone_way_ = false;  ///< the first is of now
  std::vector<double> ways_;  ///< of each meeting: motion that a step wants
  std::vector<char> looks_, searched_;  ///< of each meeting: at its pairs; they are found anew
  std::vector<std::vector<std::array<int, 2>>> face_pairs_;
  std::vector<Candidate> pairs_, old_pairs_, found_;
  std::vector<PairName> pattern_, pushing_, both_;  ///< in order; the last two: work space
  std::vector<Vec3> found_at_;  ///< motion is measured from there
  std::vector<Vec3> followed_;  ///< where motion was asked for last; nothing: at placed_
  const Vec3* placed_ = nullptr;     ///< see placedAt()
  bool is_placed_followed_ = false;  ///< motion was asked for there last
  bool is_followed_ = false, is_all_known_ = false;  ///< it is of now; it is within all budgets
  double size_ = 0;             ///< largest coordinate there [m]
  bool may_push_ = true;
  long revision_ = 0, step_ = 0;
  Work work_;
};

}  // namespace stroma::contact
