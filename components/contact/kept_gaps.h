// SPDX-License-Identifier: LGPL-2.1-or-later
// Gaps that constraint forces keep, and the proof of a step. Which side of each other two points are on is decided by their
// straight path from the start of the step, not by a sign: the normal of a pair that slides past a rim rotates by more than a right
// angle although nothing penetrates.
//   free path:  d and n are those of the closest points at the end of the path;
//   otherwise:  n and the weights c are those just before the pair would touch, and d = n . sum c_i x_i.
// If the straight paths of two rigid bodies touch, the proof uses a path on which both keep their shapes (kept_turns.cpp).
// Only the first touch of a vertex or an edge is trusted: afterwards it is on an invalid side, and its other pairs keep
// their last values. The step is proved if at its end the path of every pair is free and nothing has moved
// farther than pairs were searched.
//
// Two edges have a condition if both are ridges: over a flat surface their distance is that of the vertices around. Over a low
// bend this is nearly so, and they get a condition only if the others hold and leave a gap smaller than tolerated.
// Nearly parallel edges have none, because the direction of their distance is not unique; all of their paths are checked.
// A condition is made when its pair first comes nearer than the gap to keep, and lasts for the step. Pairs of rigid bodies that
// come near unexpectedly use spare conditions, because the number of conditions is constant during a step. Of pairs with the same
// closest points one is active. Faces of rigid bodies that are flush share one direction (flush_faces.h).
//
// Small motions can rotate the directions of small gaps far, and with many contacts they may oscillate for ever. Then the active ones
// are kept for the rest of the step (kept_directions.cpp): its forces have the directions of a configuration nearby.
#pragma once
#include <compare>
#include <deque>

#include "components/contact/contact_terms.h"
#include "components/contact/flush_faces.h"

namespace stroma::contact {

/// The number of vertices on an invalid side after a touch: the vertex, or all of two edges; none with rounded obstacles.
inline int passing(const Candidate& pair) { return pair.is_rounded ? 0 : pair.kind == PairKind::point_triangle ? 1 : 4; }
/// An upper bound of the relative motion of the two sides of a pair.
double boundOfRelativeMotion(PairKind kind, const FourPoints& ways);
/// A pair whose relative motion is below this fraction of its distance does not touch.
constexpr double certainly_free = 0.7;
/// An upper bound of the relative motion of a pair [m], and the fraction of the straight path without a touch.
struct PathCheck {
  double moved = 0, free = 1;
};
/// Starts from `places` at distance `start`; a pair touches at a fiftieth of the gap to keep. `slack`: how far the true path may leave
/// the straight one [m], which must remain free too.
PathCheck checkPath(const BarrierLaw& law, const Candidate& pair, double start, const FourPoints& places, const FourPoints& ways,
                    double slack = 0);

/// Two points that are kept apart: of a pair, or of a vertex and a plane.
struct KeptGap {
  const Candidate* pair = nullptr;  ///< null: a plane
  std::size_t plane = 0;
  std::array<int, 4> v{-1, -1, -1, -1};
  Vec3 across = Vec3::Zero();  ///< unit vector along the surface at the start of the step
  double start = 0;            ///< gap there, without contactDistance [m]
  std::size_t first_meeting = 0, end_of_meetings = 0;  ///< range in the list of FlushFaces of those it may belong to
  bool is_parallel = false;                 ///< edges that have a condition only at a corner of flush faces
  bool is_parallel_at_start = false, is_aligned_at_start = false;
  bool is_aligned = false;  ///< so parallel that closest points would need 113 bits: `start` is a lower bound, and n is approximate
  bool has_across = true;  ///< otherwise `across` is not computed yet
  bool is_rigid = false;       ///< of rigid bodies or obstacles
  bool is_spare = false;       ///< of no pair yet (KeptGaps::makeConditions())
  // ---- at the last evaluation of the conditions ----
  std::array<double, 4> c{};
  Vec3 n = Vec3::Zero(), tangent = Vec3::Zero();
  double gap = 0;        ///< distance minus contactDistance [m]
  bool is_lower_bound = false;  ///< `gap` is a lower bound, and c and n are older, from where the pair was nearer
  double moved = 0;      ///< upper bound of the relative motion of its sides [m]
  double free = 1;       ///< the fraction of the straight path without a touch
  bool is_trusted = false;    ///< c, n and gap are those of the closest points, or of the first touch
  /// For flush faces: at a corner of their overlap, or beside it, where other gaps are used.
  enum class Flush : unsigned char { no, corner, beside } flush = Flush::no, flush_at_start = Flush::no;
  double upright = 1;    ///< of such a corner: distance over length along n
  bool has_closed = false;     ///< the gap has been below zero in this step
  bool is_active = false;   ///< it has closed, and no other gap replaces it

  /// Sets the values at the start of a step.
  void place(const BarrierLaw& law, const std::vector<Vec3>& x);
  /// It has not come near since the step began: a bound is enough.
  bool isFar(const BarrierLaw& law) const;
  /// If the relative motion of its sides is at most `most` [m], it is too far for a condition and its path is free.
  bool staysFar(const BarrierLaw& law, double most) const;
  /// Evaluates the gap at x on the path from `from`. Without `refresh` along the last direction.
  void look(const BarrierLaw& law, const std::vector<Vec3>& from, const std::vector<Vec3>& x, bool refresh);
  /// Rotates the tangent with n.
  void turnTangent();
  /// How n rotates with the points: by -apart() b (b . dx) along them, b = sum of[i] n, with the coefficients of at most two b.
  struct Turns {
    int count = 0;
    std::array<std::array<double, 4>, 2> of{};
  };
  Turns turns(const BarrierLaw& law, const std::vector<Vec3>& x) const;
  double apart(const BarrierLaw& law) const { return gap + law.range + law.thickness + (pair ? pair->radius : 0); }
  int passing() const { return pair ? contact::passing(*pair) : 0; }
};

/// The motion expected in a step, of all vertices.
struct ExpectedMotion {
  std::vector<Vec3> last, straight;  ///< that of the previous step, and that with the velocities at its end [m]
  double other = 0;                  ///< possible deviation from both [m]
};

class KeptGaps {
 public:
  /// Call it when `surfaces` of the law are finished. `tolerated`: tolerance of gaps [m]. `rigid`: per body.
  void compile(const BarrierLaw& law, double tolerated, const std::vector<char>& rigid);
  /// Starts a step at x. Pairs are searched up to twice `way`, those of two rigid bodies up to the sum of their `ways`.
  /// True: there are some, and addPairs() must follow.
  bool begin(const BarrierLaw& law, const std::vector<Vec3>& x, double way, const std::vector<double>& ways);
  /// Adds conditions for pairs that may come near.
  void addPairs(const BarrierLaw& law, const ExpectedMotion& ways);
  /// Evaluates all gaps at x, with obstacles at their positions at the end of the step.
  void look(const BarrierLaw& law, const std::vector<Vec3>& x);
  /// Keeps the directions of the gaps active at the last x for the rest of the step.
  void keepDirections();
  void releaseDirections() { keeps_directions_ = false; }
  bool keepsDirections() const { return keeps_directions_; }
  /// The length of motion to the last x that is not proved [m]; 0: the step is proved.
  double unproved() const { return unproved_; }
  /// The first pair to touch; null: none.
  const Candidate* notFree() const { return not_free_; }
  const std::vector<KeptGap>& all() const { return all_; }
  /// Vertices of pairs without a condition whose paths are also checked, except pairs of two rigid bodies.
  const std::vector<int>& watchedVertices() const { return watched_vertices_; }
  const std::vector<Vec3>& start() const { return start_; }
  /// The smallest gap at the last x, minus contactDistance [m]; infinity without any.
  double smallest(const BarrierLaw& law, const std::vector<Vec3>& x);
  Vec3 slide(const KeptGap& gap, const BarrierLaw& law, const std::vector<Vec3>& x) const;
  void clear() {
    all_.clear(), watched_.clear(), watched_vertices_.clear(), start_.clear(), not_free_ = nullptr;
    touches_.clear(), unexpected_.clear(), next_spare_ = 0, has_spares_ = false;
  }

 private:
  void addPlanes(const BarrierLaw& law, const std::vector<Vec3>& x);
  void add(const Candidate& pair, const BarrierLaw& law, const ExpectedMotion& ways);
  void makeGap(const Candidate& pair, bool is_rigid, const BarrierLaw& law, KeptGap& gap) const;
  bool isRigidAt(const BarrierLaw& law, int vertex) const { return rigid_[std::size_t(law.surfaces.bodyOf(vertex))]; }
  bool isOfRigid(int a, int b) const { return a != b && rigid_[std::size_t(a)] && rigid_[std::size_t(b)]; }
  void evaluateParallel(KeptGap& gap, const BarrierLaw& law, const std::vector<Vec3>& x);
  void findAcross(KeptGap& gap, const BarrierLaw& law);
  void evaluateFlush(const BarrierLaw& law, const std::vector<Vec3>& x);
  void ignoreDuplicates();
  void restoreDirections(const BarrierLaw& law, const std::vector<Vec3>& x);
  // ---- kept_proof.cpp ----
  void findPairs(const BarrierLaw& law, const std::vector<Vec3>& x, const std::vector<double>& ways);
  double searchedDistance(int a, int b) const;
  void extendWatch(const BarrierLaw& law, int a, int b, double way);
  void watch(const Candidate& pair, const BarrierLaw& law);
  double boundOfRelativeMotion(int a, int b);
  PathCheck checkPathOf(const BarrierLaw& law, const Candidate& pair, double start, const std::vector<Vec3>& x) const;
  void removeTouchesOfRotations(const BarrierLaw& law, const std::vector<Vec3>& x);
  bool areFreeWhileRotating(const BarrierLaw& law, int a, int b, const std::vector<Vec3>& x, bool screws) const;  ///< kept_turns.cpp
  void addSpareConditions();
  void makeConditions(const BarrierLaw& law, const std::vector<Vec3>& x);
  /// Otherwise a motion of rigid bodies beyond searchedDistance() is not proved.
  bool canExtendWatch() const { return is_searched_ && has_spares_; }
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
    bool is_new;  ///< its direction is not among those kept
    std::size_t gap;
    auto operator<=>(const Key&) const = default;
  };
  /// A pair without a condition, of bodies a and b.
  struct Watched {
    const Candidate* pair;
    double start;  ///< as KeptGap::start
    int a, b;
  };
  /// Two rigid bodies whose pairs are watched because one has moved beyond ways_.
  struct ExtendedWatch {
    int a, b;
    double way;  ///< [m]
  };
  /// A pair that touches on its straight path.
  struct Touch {
    const Candidate* pair;
    double free;
    KeptGap* gap;  ///< null: a watched one
    bool is_rigid;
    int a, b;      ///< bodies, the smaller number first
  };
  std::vector<Touch> touches_;  ///< at the last x
  std::vector<const Candidate*> unexpected_;  ///< watched pairs of rigid bodies that touch or are nearer than the gap to keep
  std::size_t next_spare_ = 0;  ///< in all_
  bool is_searched_ = false, has_spares_ = false;  ///< in this step
  static constexpr double untouched = 2;  ///< in first_
  std::vector<KeptGap> all_;  ///< with a condition
  std::vector<Watched> watched_;
  std::vector<double> ways_;  ///< per body: expected motion in this step [m]
  std::vector<ExtendedWatch> extended_;
  std::deque<Candidate> extended_pairs_;
  std::array<int, 2> of_pair_{-1, -1};  ///< the bodies of most_of_pair_, which boundOfRelativeMotion() was asked for last
  double most_of_pair_ = 0;
  bool are_boxes_known_ = false;        ///< around_ are up to date
  std::vector<int> watched_vertices_;
  std::vector<SurfacePart> bodies_;     ///< all vertices of each
  AllDisplacements all_moved_;          ///< work space, as are
  std::vector<Displacements> moved_;    ///< of bodies_
  std::vector<Box> around_;             ///< their displacements
  std::vector<Vec3> start_;  ///< of all vertices
  Vec3 moved_at_start_ = Vec3::Zero();
  std::vector<double> first_;  ///< per vertex: the fraction of its path up to its first touch, or `untouched`
  std::vector<Key> keys_;
  /// Per gap, with keepDirections(); `is_any`: it has been active.
  struct Directions {
    bool is_any = false, is_of_place = false;  ///< is_of_place: so is the gap
    int times = 0;  ///< number of updates
    std::array<double, 4> c{};
    Vec3 n = Vec3::Zero();
    double upright = 1, more = 0;  ///< more: the gap minus the one along them [m]
    KeptGap::Flush flush = KeptGap::Flush::no;
    void take(const KeptGap& gap);
  };
  std::vector<Directions> kept_;
  bool keeps_directions_ = false;
  int looks_ = 0;  ///< evaluations since then
  FlushFaces flush_;
  std::vector<char> rigid_;  ///< per body
  double way_ = 0, unproved_ = 0, tolerated_ = 0;
  const Candidate* not_free_ = nullptr;
};

}  // namespace stroma::contact
