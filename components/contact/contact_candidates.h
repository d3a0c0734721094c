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

/// A vertex and a triangle, or two edges, close enough to be checked.
struct Candidate {
  PairKind kind;
  int first, second;     ///< vertex and triangle, or two edges
  std::array<int, 4> v;  ///< vertices
  double radius;         ///< sum of both surfaces' radii [m]
  double distance = 0;   ///< when it was found, minus the radius [m]
  int meeting = 0;       ///< of the two parts that it belongs to
  bool pushes = true;    ///< false: already close at rest, and only prevented from crossing
  double factor = std::numeric_limits<double>::quiet_NaN();  ///< for two edges, see contact_terms.h; NaN: unknown
  double tried = factor, found = factor;                     ///< the factor in the previous solve, and the one that resulted from it
  bool is_rounded = false;  ///< one side is a rounded obstacle
  bool operator<(const Candidate& o) const {
    return kind != o.kind ? kind < o.kind : first != o.first ? first < o.first : second < o.second;
  }
};

/// The identity of a pair.
struct PairName {
  PairKind kind;
  int first, second;
  auto operator<=>(const PairName&) const = default;
};

/// A plane that pushes everything below it: bodies are where n.x > offset.
struct Plane {
  Vec3 normal;
  double offset;
};

/// The candidate pairs of a contact, and the step bounds and crossing tests of all pairs. Each two parts of the surfaces have
/// a proof of separation (contact_parts.h): while it holds, neither pairs nor crossings are searched between them.
class Candidates {
 public:
  bool self_contact = true;
  double reach = 0;      ///< distance below which pairs are active [m]
  double thickness = 0;  ///< distance at which pushing surfaces touch, included in `reach` [m]
  double reach_at_rest = -1;  ///< parts of one piece closer than this at rest do not push each other [m]; negative: `reach`

  void compile(const Surfaces& surfaces);
  /// Begins a step: margins adapt to the motion per step.
  void stepBegins() { ++step_; }
  /// Finds all pairs that may come nearer than `reach` while no vertex moves farther than `margin` from x, without cached
  /// data. Returns false if no pushing pair is new in patternPairs().
  bool find(const std::vector<Vec3>& x, double margin);
  /// The same with a margin per pair of bodies, margin(a, b).
  template <class Margin>
  bool findWithin(const std::vector<Vec3>& x, Margin&& margin) {
    forget(), startFrom(x);
    for (std::size_t m = 0; m < meetings_.size(); ++m)
      search(int(m), x, margin(parts_[std::size_t(meetings_[m].a)].body, parts_[std::size_t(meetings_[m].b)].body));
    return takeFound();
  }
  /// Appends pairs of two bodies with a distance above `from` and up to `to` at x [m], which find() has left out there.
  void addFarther(int body_a, int body_b, const std::vector<Vec3>& x, double from, double to, std::deque<Candidate>& out);
  /// The same if the motion up to x has exhausted the proofs, with margins for several steps. Cached data of a pair is
  /// kept. Returns false as above.
  bool findAgain(const std::vector<Vec3>& x, double least_margin, double most_margin);
  void forget();
  /// Increases when the pairs change.
  long revision() const { return revision_; }
  /// x is constant until the next call, so repeated queries there are answered from the cache.
  void placedAt(const std::vector<Vec3>& x) { placed_ = x.data(), is_placed_followed_ = false; }
  /// All pairs nearer than `reach` at x are known.
  bool covers(const std::vector<Vec3>& x) { return follow(x); }
  /// The last search found no pairs, and nothing is nearer than `distance` now.
  bool areFarther(const std::vector<Vec3>& x, double distance);
  /// No search has been made yet.
  bool isNew() const { return found_at_.empty(); }
  /// The pairs in the matrix pattern: pushing pairs, and earlier ones, so that the pattern seldom changes.
  const std::vector<PairName>& patternPairs() const { return pattern_; }
  std::array<int, 4> verticesOf(const PairName& pair) const;
  std::vector<Candidate>& pairs() { return pairs_; }
  const std::vector<Candidate>& pairs() const { return pairs_; }
  // ---- at the x of the last covers() ----
  /// False: no pushing pair is nearer than `reach`.
  bool mayPush() const { return may_push_; }
  bool mayPush(const Candidate& pair) const {
    return pair.pushes && !isFine(pair.meeting) && pair.distance - meetings_[std::size_t(pair.meeting)].motion < reach;
  }
  /// The largest s <= 1 for which the vertices may move from x to x + s dx. `bend`: the distance of each vertex's path from
  /// that line [m]; empty: straight paths.
  double longestStep(const std::vector<Vec3>& x, const std::vector<Vec3>& dx, const std::vector<double>& bend);
  /// An edge that intersects a triangle, by their vertices.
  struct Crossing {
    int edge, face;
    double depth;  ///< how far the edge extends through the plane of the triangle [m]
  };
  std::vector<Crossing> crossings(const std::vector<Vec3>& x);
  FourPoints pointsOf(const Candidate& pair, const std::vector<Vec3>& x) const {
    return {x[std::size_t(pair.v[0])], x[std::size_t(pair.v[1])], x[std::size_t(pair.v[2])], x[std::size_t(pair.v[3])]};
  }
  void serialize(Archive& archive);
  /// Work done since the last forget(), counted per pair of parts.
  struct Work {
    long searches = 0;  ///< searches for pairs, at the positions or along the intended path
    long ways = 0;      ///< pairs whose path was checked
    long tests = 0;     ///< crossing tests
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
  // Boxes enclose x, or the path from x to x + step dx.
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
  std::vector<unsigned> shared_;      ///< per triangle, see leastApart()
  std::vector<BoxTree> trees_;           ///< one per part
  std::vector<std::vector<Box>> boxes_;  ///< of its triangles
  std::vector<char> is_fit_;             ///< its boxes are up to date for the current query
  std::vector<Displacements> gone_, goes_;  ///< per part: up to x, and along the path
  std::vector<CommonMotion> turned_, turns_;  ///< the same as rigid motions; computed on demand
  std::vector<char> is_turned_, does_turn_;   ///< whether they are computed
  double radii_ = 0;                          ///< the largest sum of two radii [m]
  std::vector<Meeting> meetings_;
  std::vector<WholeBody> bodies_;
  std::vector<BodyMeeting> body_meetings_;
  bool are_bodies_counted_ = false;
  std::vector<PartGroup> part_groups_;
  std::vector<MeetingGroup> groups_;
  std::vector<int> group_of_;  ///< per meeting
  AllDisplacements gone_way_, goes_way_;    ///< of all vertices; work space
  bool has_gone_way_ = false;  ///< the first is up to date
  std::vector<double> ways_;  ///< per meeting: motion of the intended step
  std::vector<char> looks_, searched_;  ///< per meeting: its pairs are checked; they are searched again
  std::vector<std::vector<std::array<int, 2>>> face_pairs_;
  std::vector<Candidate> pairs_, old_pairs_, found_;
  std::vector<PairName> pattern_, pushing_, both_;  ///< sorted; the last two: work space
  std::vector<Vec3> found_at_;  ///< positions that motion is measured from
  std::vector<Vec3> followed_;  ///< positions of the last query of motion; empty: placed_
  const Vec3* placed_ = nullptr;     ///< see placedAt()
  bool is_placed_followed_ = false;  ///< the last query of motion was there
  bool is_followed_ = false, is_all_known_ = false;  ///< motion is up to date; it is within all budgets
  double size_ = 0;             ///< largest coordinate there [m]
  bool may_push_ = true;
  long revision_ = 0, step_ = 0;
  Work work_;
};

}  // namespace stroma::contact
