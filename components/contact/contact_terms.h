// SPDX-License-Identifier: LGPL-2.1-or-later
// The barrier between surfaces (Li, Ferguson, Schneider, Langlois, Zorin, Panozzo, Jiang and Kaufman 2020; the physical
// barrier and the sums over features Li et al. 2023). With the gap d, r = d/dh, for r < 1:
//   b = -dh (r - 1)^2 ln r
//   b' = -(2 (r - 1) ln r + (r - 1)^2 / r),   b'' = -(2 ln r + 4 (r - 1)/r - (r - 1)^2/r^2) / dh
// The energy is kappa times the integral of b over the surfaces, each vertex standing for its share A of the surface:
//   E = kappa sum_vertices A/2 [sum_triangles b - sum_edges (t_e - 1) b + sum_vertices (1 - t_v + sum_e (t_e - 1)) b]
//     + kappa sum_edge-pairs A_e m b
// with t_e and t_v the triangles of an edge and of a vertex: 2 and 1 in the interior of a surface, 1 and 0 at its rim. The
// terms of edges and vertices remove what neighbouring triangles with the same closest point would count twice. Against
// obstacles, whose vertices are not in this sum, A/2 becomes A. A is the part of the surface around a vertex that faces the
// other surface, A = sum a max(0, -n.u), with u towards the vertex, and a third of a triangle's area, or the integral of a
// quad's bilinear function, for a (Surfaces::corner_area). Between two surfaces it is a mean (contact_shares.cpp). Two
// edges are active if both are ridges
// towards each other, so flat surfaces are pressed by their vertices only. A, ridges and the factor m of parallel
// edges are lagged from the last force. Every pair also has a second barrier with a tenth of its share and a tenth of dh, which
// only pairs without another share reach. In explicit steps it has the full share and half of dh, because nothing else stops fast bodies.
//
// Adhesion (Fang, Li and others 2023) is a traction of vertices over surfaces with the maximum Y at the gap dp:
//   Y d/dp for d < dp,   Y (da - d)/(da - dp) for dp <= d < da, else 0
// with the energy per area -Y (da - d)^2 / (2 (da - dp)) beyond dp, and -Y/2 (da - d^2/dp) below.
#pragma once
#include <algorithm>
#include <cstdint>

#include "components/contact/contact_candidates.h"
#include "framework/algebra/block_matrix.h"

namespace stroma::contact {

/// An active pair of closest points.
struct Touch {
  std::array<int, 4> v;     ///< vertices; for a plane the first one, then -1 minus its number
  std::array<double, 4> c;  ///< the difference of the closest points is sum c_i x_i
  Vec3 n;                   ///< unit, its direction
  double gap = 0;           ///< [m]
  double share = 0;         ///< [m^2]; negative: compensates a share counted twice
  double range = 0;         ///< dh [m]
  bool of_surface = false;  ///< the share is a part of a surface, not of crossing ridges or of the second barrier
};

/// An energy as a function of the gap: its value, b' and b''.
struct Slopes {
  double value = 0, slope = 0, curvature = 0;
};
struct Barrier : Slopes {
  Barrier(double gap, double range);
};
/// b = dh/2 (r - 1)^2 for r < 1: a pressure that increases linearly as the gap decreases, also below zero.
struct Penalty : Slopes {
  Penalty(double gap, double range);
};

struct Adhesion {
  double strength = 0;  ///< Y [Pa]
  double peak = 0;      ///< dp [m]
  double range = 0;     ///< da [m]
  Slopes at(double gap) const;  ///< [J/m^2], [Pa], [Pa/m]
};

/// A force f c_i on each of up to four rows. Its derivative, for an energy e(d) of the distance d, is
///   K_ij = -c_i c_j m + e' (d (w_i.w_j) n n^T + c_j n w_i^T + c_i w_j n^T),   m = e'' n n^T + e'/d Q
/// If the closest points can slide along directions D_a, with derivatives c_i,a of the weights, then w_i = sum_a c_i,a u_a with
/// u_a . D_b = 1 for a = b, else 0, and Q projects onto the complement of n and all D_a. This is the second derivative of a distance
/// minimised over the weights. With displacements p, a = sum c_i p_i and b = sum w_i (n.p_i), a pushing term (e' < 0) has -p.K p =
///   e'' (n.a)^2 - |e'|/d a.Q a + |e'| (d |b|^2 + 2 a.b),   2 a.b = 1/2 |s a + b/s|^2 - 1/2 |s a - b/s|^2,   s^2 = |w|/|c|
/// A positive definite approximation keeps e'' (n.a)^2 if that is positive, and |e'|/2 |s a + b/s|^2, for slides that rotate two sides
/// into each other. Without the latter a correction slides so far that the gap closes quadratically in the slide, and the force is then
/// orders of magnitude too large. If d exceeds 1/s^2, as from the centre of a large sphere, it is q |e'| d |b + a/d|^2 instead, where q
/// increases with d s^2 / 2 from a half to 1.
struct Term {
  std::array<Index, 4> rows{-1, -1, -1, -1};  ///< -1: of an obstacle
  std::array<double, 4> c{};
  Vec3 force;
  Mat3 m;
  double slope = 0, distance = 0;  ///< e' [N], d [m]; a slope of 0: only the first term
  Vec3 n = Vec3::Zero();
  std::array<Vec3, 4> w{Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};  ///< [1/m]
  Mat3 derivative(std::size_t i, std::size_t j) const;  ///< K_ij
};
class Terms : public std::vector<Term> {
 public:
  void addForce(Rows f) const;
  void addProduct(ConstRows dx, double factor, Rows df) const;  ///< of the derivative
  /// df += that of obstacles which move by `way`, by the derivative.
  void addPush(const Vec3& way, Rows df) const;
  void addPattern(BlockPattern& pattern) const;
  void addTo(double factor, BlockMatrix& matrix) const;
  void addDiagonal(double factor, std::vector<double>& blocks) const;
};

/// What a term has of the derivative: all of it, a part without unstable directions, or e'' n n^T alone where that is positive.
enum class Tangent { whole, definite, normal };

class BarrierLaw {
 public:
  double range = 0, thickness = 0;  ///< dh [m]; distance of surfaces at which the gap is zero [m]
  double stiffness = 0;             ///< kappa [Pa]
  double small_range = 0.1, small_share = 0.1;  ///< of the second barrier, as fractions of dh and of the share
  bool is_penalty = false;          ///< uses Penalty instead of Barrier
  Adhesion adhesion;
  double alarm = 0;  ///< gap up to which inactive pairs are listed [m]
  std::vector<Plane> planes;
  Vec3 moved = Vec3::Zero();  ///< displacement of all obstacles [m]
  Surfaces surfaces;
  mutable Candidates candidates;

  void compile();
  /// Computes shares at x. touches() then uses them until the next call.
  void weigh(const std::vector<Vec3>& x) const;
  /// The same at the end x of a solve, starting from the present shares, for the next solve.
  void weighAgain(const std::vector<Vec3>& x) const;
  /// Recomputes shares. Returns the change of the force on each vertex, see relativeChange(); `before` and `after` have that many.
  double changeByWeighing(const std::vector<Vec3>& x, std::vector<Vec3>& before, std::vector<Vec3>& after) const;
  /// The shares computed by weigh(), of vertices at surfaces and planes and of edge pairs.
  struct Shares {
    std::vector<double> vertices, planes, edges;
    bool is_weighed = false;
    long revision = -1;  ///< revision of the pairs
  };
  void copyShares(Shares& out) const;
  /// Restores earlier shares. Returns false, and changes nothing, if the pairs have changed since.
  bool putBack(const Shares& shares) const;
  /// No surfaces are nearer than dh at x, and there are no planes.
  bool isOutOfReach(const std::vector<Vec3>& x) const;
  /// The active pairs at x, nearer than dh. Pairs that have come into reach since weigh() get their share here.
  const std::vector<Touch>& touches(const std::vector<Vec3>& x) const;
  Vec3 forceOf(const Touch& touch) const { return -slopesOf(touch).slope * touch.n; }  ///< on the first side [N]
  /// The energy of a touch and its derivatives [J], [N], [N/m].
  Slopes slopesOf(const Touch& touch) const;
  Slopes pushingOf(const Touch& touch) const;  ///< the same without adhesion
  /// The two parts of the force along n, pressure and adhesion [N]; both have the sign of the share.
  double pushOf(const Touch& touch) const;
  double pullOf(const Touch& touch) const;
  /// The largest gap of an active pair [m].
  double far() const { return std::max({range, adhesion.strength > 0 ? adhesion.range : 0, alarm}); }
  /// At the x of touches().
  Term termOf(const Touch& touch, const std::vector<Vec3>& x, Tangent tangent) const;
  double energy(const std::vector<Vec3>& x) const;  ///< [J], as touches()
  /// The area around a vertex that can be pushed along the unit vector `towards` [m^2].
  double shareOf(int vertex, const Vec3& towards, const std::vector<Vec3>& x) const;
  /// The force on each vertex, with the pairs of touches(); `out` has that many.
  void sumForces(const std::vector<Vec3>& x, std::vector<Vec3>& out) const;
  /// All pairs that may come into reach before the next search.
  void addPattern(BlockPattern& pattern) const;
  /// The largest s <= 1 for which vertices may move by s dx while planes move by s way. `bend`: see Candidates.
  double longestStep(const std::vector<Vec3>& x, const std::vector<Vec3>& dx, const std::vector<double>& bend,
                     const Vec3& way) const;
  /// Of a vertex at x.
  double gapToPlane(std::size_t plane, std::size_t vertex, const Vec3& x) const {
    return planes[plane].normal.dot(x - moved) - planes[plane].offset - thickness - surfaces.vertex_radius[vertex];
  }

 private:
  static constexpr double not_weighed = std::numeric_limits<double>::quiet_NaN();
  struct Feature {
    std::int64_t key;
    int count;
    const Candidate* pair;
    std::array<double, 4> c;
    Vec3 difference;
  };
  void look(const std::vector<Vec3>& x) const;
  static void keepPositive(Term& term);
  void addTurning(const Touch& touch, const std::vector<Vec3>& x, double slope, Term& term) const;
  enum class Which { all, all_again, missing };  ///< the pairs in reach whose shares are computed
  void weigh(const std::vector<Vec3>& x, Which which) const;
  void weighPlanes(const std::vector<Vec3>& x) const;
  double meanShare(std::size_t first, std::size_t end, const std::vector<Vec3>& x) const;
  double pressureAt(double gap) const;
  double factorOf(const Candidate& pair, const ClosestPoints& closest, const std::vector<Vec3>& x) const;
  double ridge(int edge, const Vec3& towards, const std::vector<Vec3>& x) const;
  void addFeature(Feature feature) const;
  void addFeaturesOf(const Candidate& pair, const ClosestPoints& closest, const std::vector<Vec3>& x) const;
  void addVertexTouches(int vertex) const;
  void addEdgeTouches(const Candidate& pair, const ClosestPoints& closest, double factor) const;
  void addPlaneTouches(const std::vector<Vec3>& x) const;
  void addTouch(const Candidate& pair, const std::array<double, 4>& c, const Vec3& difference, double share, double small,
                bool of_surface) const;

  mutable std::vector<ClosestPoints> closest_;  ///< of each candidate in reach, at looked_at_
  mutable std::vector<char> in_reach_;          ///< of each candidate; empty: none
  mutable bool is_weighed_ = false;             ///< something has a share
  mutable std::vector<Vec3> looked_at_;
  mutable long looked_revision_ = -1;
  mutable std::vector<double> vertex_share_, plane_share_;  ///< not a number: not weighed yet
  mutable std::vector<Feature> features_;
  mutable std::vector<Touch> touches_;
};

/// |b - a| / |b|, at most 1; 0 where nothing has changed.
double relativeChange(const std::vector<Vec3>& a, const std::vector<Vec3>& b);

}  // namespace stroma::contact
