// SPDX-License-Identifier: LGPL-2.1-or-later
// Gaps that forces of constraint keep, and the proof of a step. Which side of each other two places are on is settled by their
// straight way from where the step starts, not by a sign: what slides past a rim turns by more than a right angle and passes
// through nothing.
//   free way:  d and n are those of the closest points where the pair has come to;
//   else:      n and the weights c are those just before the pair would touch, and d = n . sum c_i x_i.
// Of two rigid bodies whose straight ways touch the proof is the way on which both keep their shapes (kept_turns.cpp).
// Only the first touch of a vertex or an edge is trusted: from then on it is on a side where it may not be, and other pairs of it are
// what they were when last looked at. The step is proved where at its end the way of every pair is free and nothing has moved
// farther than pairs were looked for.
//
// Two edges have a condition where both are ridges: over a flat surface their distance is that of the vertices around. Over a low
// bend it is nearly so, and their condition is made only where the others hold and leave a smaller gap than is tolerated.
// Nearly parallel edges have none, because their distance has no one direction; the ways of all of them are looked at.
// A condition is made when its pair first comes nearer than the gap that is kept, and lasts for the step. Pairs of rigid bodies that
// were not expected to come near take the place of spare ones, as conditions are as many all through a step. Of pairs with the same
// closest points one is active. Faces of rigid bodies that lie flat on each other have one direction (flush_faces.h).
//
// Directions of small gaps turn far by small ways, and where many bodies meet they may turn to and fro for ever. Then those that count
// stay for the rest of the step (kept_directions.cpp): its forces have the directions of a place nearby.
#pragma once
#include <compare>
#include <deque>

#include "components/contact/contact_terms.h"
#include "components/contact/flush_faces.h"

namespace stroma::contact {

/// The vertices that are beyond the other side where it has touched: of a triangle it is the vertex, of edges all.
inline int passing(const Candidate& pair) { return pair.radius > 0 ? 0 : pair.kind == PairKind::point_triangle ? 1 : 4; }
/// How far the sides of a pair move against each other at most.
double mostAgainst(PairKind kind, const FourPoints& ways);
/// What has moved by less than this part of its distance touches nothing.
constexpr double certainly_free = 0.7;
/// By how much the sides of a pair move against each other at most [m], and the part of their straight way that touches nothing.
struct FreeWay {
  double moved = 0, free = 1;
};
/// From `places` at distance `start`, to a fiftieth of the gap to keep.
FreeWay freeWay(const BarrierLaw& law, const Candidate& pair, double start, const FourPoints& places, const FourPoints& ways);

/// Two places that are kept apart: of a pair, or of a vertex and a plane.
struct KeptGap {
  const Candidate* pair = nullptr;  ///< null: a plane
  std::size_t plane = 0;
  std::array<int, 4> v{-1, -1, -1, -1};
  Vec3 across = Vec3::Zero();  ///< unit, along the surface where the step starts
  double start = 0;            ///< gap there, without contactDistance [m]
  std::size_t first_meeting = 0, end_of_meetings = 0;  ///< in the list of FlushFaces, of those it may be of
  bool is_parallel = false;                 ///< of edges that have a condition only at a corner of such faces
  bool is_parallel_at_start = false, is_aligned_at_start = false;
  bool is_aligned = false;  ///< so much that their closest points cost 113 bits: `start` is a lower bound, and n is near enough
  bool has_way_across = true;  ///< else `across` is still to be found
  bool is_rigid = false;       ///< of rigid bodies or obstacles
  bool is_spare = false;       ///< of no pair yet (KeptGaps::giveConditions())
  // where conditions were last looked at
  std::array<double, 4> c{};
  Vec3 n = Vec3::Zero(), tangent = Vec3::Zero();
  double gap = 0;        ///< less contactDistance [m]
  bool is_lower_bound = false;  ///< it is no less than `gap`, and c and n are those of where it was nearer
  double moved = 0;      ///< by how much its sides have moved against each other at most [m]
  double free = 1;       ///< the part of the straight way to there that touches nothing
  bool is_trusted = false;    ///< c, n and gap are those of the closest points, or of the first touch
  /// Of faces that lie flat on each other: at a corner of what they have in common; beside it, so that others tell.
  enum class Flush : unsigned char { no, corner, beside } flush = Flush::no, flush_at_start = Flush::no;
  double upright = 1;    ///< of such a corner: distance over length along n
  bool has_closed = false;     ///< the gap has been below zero in this step
  bool is_active = false;   ///< it has closed, and no other one stands for it

  /// Where a step starts.
  void place(const BarrierLaw& law, const std::vector<Vec3>& x);
  /// It has not come near since the step began: a bound is enough.
  bool isFar(const BarrierLaw& law) const;
  /// It is too far for a condition, and its way is free, if its sides move by no more than `most` against each other [m].
  bool staysFar(const BarrierLaw& law, double most) const;
  /// Where it has come to at x from where it was. Without `refresh` along the last direction.
  void look(const BarrierLaw& law, const std::vector<Vec3>& from, const std::vector<Vec3>& x, bool refresh);
  /// As n has turned.
  void turnTangent();
  /// How n turns with the places: by -apart() b (b . dx) along them, b = sum of[i] n, with the coefficients of at most two b.
  struct Turns {
    int count = 0;
    std::array<std::array<double, 4>, 2> of{};
  };
  Turns turns(const BarrierLaw& law, const std::vector<Vec3>& x) const;
  double apart(const BarrierLaw& law) const { return gap + law.range + law.thickness + (pair ? pair->radius : 0); }
  int passing() const { return pair ? contact::passing(*pair) : 0; }
};

/// The motion that a step is expected to make, of all vertices.
struct ExpectedWays {
  std::vector<Vec3> last, straight;  ///< that of the step before, and with the velocities of its end [m]
  double other = 0;                  ///< what it may be besides [m]
};

class KeptGaps {
 public:
  /// After `surfaces` of the law have been finished. Gaps may be off by `tolerated` [m]. `rigid`: of each body.
  void compile(const BarrierLaw& law, double tolerated, const std::vector<char>& rigid);
  /// A step starts at x. Pairs are looked for up to twice `way`; of two rigid bodies up to the sum of `ways`, of each body.
  /// True: there are some, and addPairs() is to follow.
  bool begin(const BarrierLaw& law, const std::vector<Vec3>& x, double way, const std::vector<double>& ways);
  /// Those that may come near have conditions.
  void addPairs(const BarrierLaw& law, const ExpectedWays& ways);
  /// All of them at x, while obstacles are where they will be at the end of the step.
  void look(const BarrierLaw& law, const std::vector<Vec3>& x);
  /// Of those that count at the last x, from now on in the step.
  void keepDirections();
  void releaseDirections() { keeps_directions_ = false; }
  bool keepsDirections() const { return keeps_directions_; }
  /// How far the step to the last x is from being proved [m]; 0: it is.
  double unproved() const { return unproved_; }
  /// Only rigid bodies touch on their ways, and at the last x nothing of them intersects, by an exact test: by how much they may have
  /// been in one another at most [m]. Else infinity.
  double mostGrazed(const BarrierLaw& law, const std::vector<Vec3>& x) const;
  /// Of the pairs whose way is not free the first that touches; null: none.
  const Candidate* notFree() const { return not_free_; }
  const std::vector<KeptGap>& all() const { return all_; }
  /// Of pairs without a condition whose ways are looked at as well, but where both bodies are rigid.
  const std::vector<int>& watchedVertices() const { return watched_vertices_; }
  const std::vector<Vec3>& start() const { return start_; }
  /// The smallest gap at the last x, less contactDistance [m]; infinity without any.
  double smallest(const BarrierLaw& law, const std::vector<Vec3>& x);
  Vec3 slide(const KeptGap& gap, const BarrierLaw& law, const std::vector<Vec3>& x) const;
  void clear() { all_.clear(), watched_.clear(), watched_vertices_.clear(), start_.clear(), not_free_ = nullptr; }

 private:
  void addPlanes(const BarrierLaw& law, const std::vector<Vec3>& x);
  void add(const Candidate& pair, const BarrierLaw& law, const ExpectedWays& ways);
  void makeGap(const Candidate& pair, bool is_rigid, const BarrierLaw& law, KeptGap& gap) const;
  bool isRigidAt(const BarrierLaw& law, int vertex) const { return rigid_[std::size_t(law.surfaces.bodyOf(vertex))]; }
  bool isOfRigid(int a, int b) const { return a != b && rigid_[std::size_t(a)] && rigid_[std::size_t(b)]; }
  void lookAtParallel(KeptGap& gap, const BarrierLaw& law, const std::vector<Vec3>& x);
  void findWayAcross(KeptGap& gap, const BarrierLaw& law);
  void lookAtFlush(const BarrierLaw& law, const std::vector<Vec3>& x);
  void ignoreDoubles();
  void restoreDirections(const BarrierLaw& law, const std::vector<Vec3>& x);
  // ---- kept_proof.cpp ----
  void findPairs(const BarrierLaw& law, const std::vector<Vec3>& x, const std::vector<double>& ways);
  double lookedFor(int a, int b) const;
  void watchFarther(const BarrierLaw& law, int a, int b, double way);
  void watch(const Candidate& pair, const BarrierLaw& law);
  double mostAgainst(int a, int b);
  FreeWay freeWayOf(const BarrierLaw& law, const Candidate& pair, double start, const std::vector<Vec3>& x) const;
  void forgiveTurning(const BarrierLaw& law, const std::vector<Vec3>& x);
  bool areFreeTurning(const BarrierLaw& law, int a, int b, const std::vector<Vec3>& x, bool screws) const;  ///< kept_turns.cpp
  double widthOf(int body, const Surfaces& surfaces, const std::vector<Vec3>& x) const;
  void addSpares();
  void giveConditions(const BarrierLaw& law);
  bool boxDisplacements(const BarrierLaw& law, const std::vector<Vec3>& x);
  bool isWithin(const BarrierLaw& law, const std::vector<Vec3>& x);
  double beyond(const BarrierLaw& law, const std::vector<Vec3>& x);
  bool isAbovePlanes(const BarrierLaw& law, int body, const std::vector<Vec3>& x) const;
  template <class Visit>
  void forEachMeeting(const BarrierLaw& law, Visit&& visit) const;
  void findFirstTouches(const BarrierLaw& law, const std::vector<Vec3>& x);
  bool isTrusted(const KeptGap& gap, const BarrierLaw& law, const std::vector<Vec3>& x) const;

  /// The vertices of the closest points of a gap.
  struct Key {
    std::array<int, 4> vertices;
    bool is_new;  ///< beside those whose directions are kept
    std::size_t gap;
    auto operator<=>(const Key&) const = default;
  };
  /// A pair without a condition, of bodies a and b.
  struct Watched {
    const Candidate* pair;
    double start;  ///< as KeptGap::start
    int a, b;
  };
  /// Two rigid bodies whose pairs are watched for a motion beyond ways_.
  struct Farther {
    int a, b;
    double way;  ///< [m]
  };
  /// A pair whose straight way touches.
  struct Touch {
    const Candidate* pair;
    double free;
    KeptGap* gap;  ///< null: a watched one
    bool is_rigid;
    int a, b;      ///< bodies, the smaller number first
  };
  std::vector<Touch> touches_;  ///< at the last x
  std::vector<const Candidate*> uninvited_;  ///< watched pairs of rigid bodies that touch or are nearer than the gap there
  std::size_t next_spare_ = 0;  ///< in all_
  static constexpr double untouched = 2;  ///< in first_
  std::vector<KeptGap> all_;  ///< with a condition
  std::vector<Watched> watched_;
  std::vector<double> ways_;  ///< of each body, in this step [m]
  std::vector<Farther> farther_;
  std::deque<Candidate> farther_pairs_;
  std::array<int, 2> of_pair_{-1, -1};  ///< the bodies of most_of_pair_, which mostAgainst() was asked for last
  double most_of_pair_ = 0;
  bool are_boxes_known_ = false;        ///< around_ are those of now
  std::vector<int> watched_vertices_;
  std::vector<SurfacePart> bodies_;     ///< all vertices of each
  AllDisplacements all_moved_;          ///< work space, as are
  std::vector<Displacements> moved_;    ///< of bodies_
  std::vector<Box> around_;             ///< their displacements
  std::vector<Vec3> start_;  ///< of all vertices
  Vec3 moved_at_start_ = Vec3::Zero();
  std::vector<double> first_;  ///< of each vertex, the part of its way to its first touch; or `untouched`
  std::vector<Key> keys_;
  /// Of each gap, with keepDirections(); `is_any`: it has counted.
  struct Directions {
    bool is_any = false, is_of_place = false;  ///< is_of_place: so is the gap
    int times = 0;  ///< they have been taken again
    std::array<double, 4> c{};
    Vec3 n = Vec3::Zero();
    double upright = 1, more = 0;  ///< more: than the gap along them [m]
    KeptGap::Flush flush = KeptGap::Flush::no;
    void take(const KeptGap& gap);
  };
  std::vector<Directions> kept_;
  bool keeps_directions_ = false;
  int looks_ = 0;  ///< since then
  FlushFaces flush_;
  std::vector<char> rigid_;  ///< of each body
  double way_ = 0, unproved_ = 0, tolerated_ = 0;
  bool is_beyond_ = false;  ///< something has moved farther than pairs were looked for
  const Candidate* not_free_ = nullptr;
};

}  // namespace stroma::contact
