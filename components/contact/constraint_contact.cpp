// SPDX-License-Identifier: LGPL-2.1-or-later
// ConstraintContact: a surface that keeps a distance from obstacles, with friction, by forces of constraint at the end of each
// step.
//
// Surfaces, planes, spheres and capsules are those of BarrierContact. With d the distance of a vertex and a plane, a sphere and a
// triangle, or an axis and an edge, less radii and `thickness`, l_n the force between them, s the way along the surfaces in the
// step and mu the friction:
//
//   d >= contactDistance,   l_n >= 0,   one of both with equality;   s = 0, or |l_t| = mu l_n against s
//
// What sticks does not move at all. The integrator finds the forces by the compliance of the bodies (Signorini and Coulomb):
// condensed bodies read it from their inverse, EulerImplicitSolver, TrapezoidalRuleSolver and BDFOdeSolver solve for each
// condition. Distances and normals are those of the end of the step, so that the distance is kept to round-off.
//
// Pairs are found where a step starts: those that may come near if nothing moves farther than obstacles do and twice as far as
// in the last step, as its speed would take it, or as an eighth of the mean edge. Which side of each other they are on is that of
// the start. Each step is proved besides: nothing has passed through a sphere or an axis where each pair may go straight from
// where the step starts to where it ends (Li, Kaufman and Jiang 2021) and no vertex has moved farther than pairs were looked for.
// A condition that is off by the rest refuses a step in which it is not, and BarrierContact is for such. contactDistance is above
// zero for the sake of the side.
//
// Of pairs whose closest points are the same one counts, and of nearly parallel edges the ends alone. Bodies do not meet each
// other, nor themselves: BarrierContact has that, and boxes and cylinders.
//
// Source: Signorini 1933; Duriez, Dubois, Kheddar and Andriot 2006 (forces by compliance).
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 -9.81">
//   <EulerImplicitSolver/>
//   <SparseLDLSolver/>
//   <MeshTopology position="0 0 0  1 0 0  0 1 0  0.3 0.3 0.8" tetrahedra="0 1 2 3"/>
//   <MechanicalObject/>
//   <UniformMass totalMass="2"/>
//   <TetrahedronFEMForceField youngModulus="1e5" poissonRatio="0.3"/>
//   <ConstraintContact contactDistance="0.159" friction="0.1" planes="-0.19 0.29 0.94 -0.35"/>
// </Node>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "components/contact/contact_bodies.h"
#include "components/contact/contact_inside.h"
#include "components/contact/contact_obstacles.h"
#include "components/contact/kept_gaps.h"
#include "framework/mechanics/lagrangian_constraint.h"
#include "framework/mechanics/mapping.h"
#include "framework/mechanics/state_topology.h"
#include "framework/scene/archive.h"
#include "framework/scene/factory.h"
#include "framework/scene/node.h"
#include "framework/scene/usual_component.h"

namespace stroma {
namespace {

using namespace contact;

class ConstraintContact final : public Component, public LagrangianConstraint {
 public:
  std::string roleText() const override { return "contact"; }
  void declare(DataTable& table) override;
  void init() override;
  std::vector<State*> constrainedStates() const override { return bodies_; }
  void constrainedStepBegins(ConstRows x, double t_end) override;
  void addConditions(ConstRows x, ConstRows x_start, LagrangianRows& rows) const override;
  void takeForces(std::span<const double> forces) override;
  void reset() override;
  void serialize(Archive& archive) override;

 private:
  void build();
  void buildForRun(ConstRows x);
  void checkStart();
  void refuseOverlaps() const;
  void refuseNear() const;
  void checkMoves() const;
  void measureTravel();
  double proof() const;
  double fastest() const;
  void addContact(const KeptGap& contact, double reach);
  Vec3 slide(const KeptGap& contact) const;

  Link<State> mstate_{"mechanical state"};
  TopologyLink topology_;
  Obstacles obstacles_;
  BarrierLaw law_;  ///< surfaces, obstacles and candidates; no barrier acts
  double friction_ = 0;
  int contacts_ = 0;
  double smallest_gap_ = 0;
  std::vector<double> forces_;
  std::vector<Vec3> contact_forces_, wrenches_;

  std::vector<State*> bodies_;
  bool is_built_ = false;
  std::vector<Vec3> start_, end_;   ///< of all vertices, where the step starts, and where the last one ended
  mutable std::vector<Vec3> x_;     ///< where conditions were last looked at
  mutable std::vector<KeptGap> found_;
  mutable std::vector<GapKey> keys_;  ///< of ignoreDoubles()
  std::vector<KeptGap> watched_;      ///< that no condition is of: nearly parallel edges
  Vec3 moved_at_start_ = Vec3::Zero();
  double travel_ = 0;  ///< the longest way of a vertex in the last step [m]
  double way_ = 0;     ///< up to which pairs were looked for in it [m]
};

void ConstraintContact::declare(DataTable& table) {
  table.addLink("mstate", mstate_).help("state of the body; of this node or the nearest above when not given");
  topology_.declare(table, "mesh whose surface mstate has");
  table.add("contactDistance", law_.range).help("gap that is kept; 0: a hundredth of the mean edge").unit("m").min(0);
  table.add("thickness", law_.thickness).help("distance of two surfaces at which their gap is zero").unit("m").min(0);
  table.add("friction", friction_).help("Coulomb's coefficient mu").unit("-").min(0);
  obstacles_.declare(table);
  table.add("contacts", contacts_).help("pairs that push after the last step").unit("-").output();
  table.add("smallestGap", smallest_gap_)
      .help("of the pairs that were looked at in the last step; 0 without any")
      .unit("m")
      .output();
  table.add("forces", forces_).help("forces of constraint of the last step").unit("N").output();
  table.add("contactForces", contact_forces_)
      .help("contact force, with friction, on each node of mstate in the last step")
      .unit("N")
      .output();
  table.add("wrenches", wrenches_)
      .help("the sum of the contact forces with friction on the body [N], and their moment about the origin [N m]")
      .output();
}

void ConstraintContact::init() {
  State* first = mstate_.get() ? mstate_.get() : find<State>(true);
  if (!first)
    throw ComponentError("no mechanical state has a surface for this contact",
                         "a " + usualComponent(Part::state) + " in the same node or above, or mstate=\"@path\"");
  bodies_ = {first};
  if (!first->row_kinds.empty())
    throw ComponentError(fmt::format("{} has rows that are no points", first->path()), "a state of points",
                         first->hasFrames() ? "points below it that a RigidMapping carries" : "");
  obstacles_.init(false, "planes, spheres or capsules");
  build();
  is_built_ = false;
  checkStart();
}

void ConstraintContact::build() {
  law_.surfaces.clear();
  const State& body = *bodies_.front();
  const Topology* topology = topology_.find(*this, body);
  if (!topology && !(topology = topologyOf(body)))
    throw ComponentError(fmt::format("{} has no mesh, so no surface", body.path()), "a topology beside it");
  law_.surfaces.addState(body, topology->mesh());
  if (law_.surfaces.faces.empty())
    throw ComponentError(fmt::format("the mesh of {} has no triangle, quad or volume cell", body.path()), "a surface");
  obstacles_.addTo(law_);
  law_.surfaces.finish();
  for (std::size_t f = 0; f < law_.surfaces.faces.size(); ++f)
    if (!law_.surfaces.moves(law_.surfaces.faces[f][0]) && law_.surfaces.radius[f] == 0)
      throw ComponentError("boxes and cylinders are not among what it keeps a distance from", "planes, spheres and capsules",
                           "BarrierContact");
  constexpr double small = 0.01;
  if (law_.range == 0) law_.range = small * law_.surfaces.meanEdge();
  law_.candidates.self_contact = false;
  law_.compile();
}

/// With the rows of the system; refuses a start in which surfaces are in one another.
void ConstraintContact::buildForRun(ConstRows x) {
  build();
  is_built_ = true;
  if (start_.size() == law_.surfaces.rows.size()) return;  // goes on
  law_.moved = moved_at_start_;
  law_.surfaces.gather(x, law_.moved, x_);
  refuseOverlaps();
  refuseNear();
}

void ConstraintContact::refuseOverlaps() const {
  refuseInside(path(), law_.surfaces, x_);
  refuseOverlap(path(), law_, x_, [this](int vertex) { return nameOfVertex(law_.surfaces, bodies_, vertex); });
}

/// What starts nearer than the gap that is kept would be thrown out to it.
void ConstraintContact::refuseNear() const {
  constexpr double rounding = 1e-6;
  double nearest = (1 - rounding) * law_.range;
  int at = -1;
  const auto look = [&](double gap, int vertex) {
    if (gap < nearest) nearest = gap, at = vertex;
  };
  for (const Candidate& pair : law_.candidates.pairs()) {
    const double apart = closestPoints(pair.kind, law_.candidates.pointsOf(pair, x_)).distance();
    look(apart - pair.radius - law_.thickness, law_.surfaces.moves(pair.v[0]) ? pair.v[0] : pair.v[3]);
  }
  for (std::size_t p = 0; p < law_.planes.size(); ++p)
    for (int v = 0; v < int(x_.size()); ++v)
      if (law_.surfaces.moves(v)) look(law_.gapToPlane(p, x_[std::size_t(v)]), v);
  if (at >= 0)
    throw ComponentError(fmt::format("{} starts with a gap of {:.4g} m, and contactDistance is {:.4g} m",
                                     nameOfVertex(law_.surfaces, bodies_, at), nearest, law_.range),
                         "gaps that are not smaller than contactDistance");
}

/// Before a run; where mapped nodes are is known when it begins.
void ConstraintContact::checkStart() {
  const State& body = *bodies_.front();
  std::vector<Mapping*> mappings;
  node().root().collect(mappings);
  if (body.isBound() || std::any_of(mappings.begin(), mappings.end(), [&](Mapping* m) { return &m->output() == &body; })) return;
  moved_at_start_ = law_.moved = obstacles_.displacement(node().root().root_time);
  Vector x(body.size());
  for (Index i = 0; i < body.size(); ++i) x[i] = body.position[std::size_t(i)];
  law_.surfaces.gather(x, law_.moved, x_);
  refuseOverlaps();
  refuseNear();
}

/// Somebody else has moved what is near: it may be anywhere.
void ConstraintContact::checkMoves() const {
  bool is_elsewhere = travel_ > 2 * way_;
  constexpr double rounding = 1e-6;
  for (std::size_t i = 0; i < found_.size() && end_.size() == x_.size(); ++i)
    for (const int v : found_[i].v)
      if (v >= 0 && law_.surfaces.moves(v) && (x_[std::size_t(v)] - end_[std::size_t(v)]).norm() > rounding * law_.range)
        is_elsewhere = true;
  if (is_elsewhere) refuseOverlaps();
}

void ConstraintContact::constrainedStepBegins(ConstRows x, double t_end) {
  if (!is_built_) buildForRun(x);
  const Vec3 goal = obstacles_.displacement(t_end);
  law_.moved = moved_at_start_;
  law_.surfaces.gather(x, law_.moved, x_);
  measureTravel();
  checkMoves();
  start_ = x_;
  constexpr double of_edge = 0.125;
  way_ = std::max({2 * travel_, 2 * fastest() * node().root().dt(), of_edge * law_.surfaces.meanEdge()}) +
         (goal - moved_at_start_).norm();
  law_.candidates.find(x_, way_);
  found_.clear(), watched_.clear();
  const double reach = law_.range + 2 * way_;
  for (const Candidate& pair : law_.candidates.pairs())
    if (pair.pushes) addContact({.pair = &pair, .v = pair.v}, reach);
  for (std::size_t p = 0; p < law_.planes.size(); ++p)
    for (int v = 0; v < int(x_.size()); ++v)
      if (law_.surfaces.moves(v)) addContact({.plane = p, .v = {v, -1, -1, -1}}, reach);
  law_.moved = goal;
}

/// How far the step before has moved a vertex.
void ConstraintContact::measureTravel() {
  if (start_.size() != x_.size() || law_.surfaces.areBodiesAt(x_, start_)) return;
  travel_ = 0;
  for (std::size_t v = 0; v < x_.size(); ++v)
    if (law_.surfaces.moves(int(v))) travel_ = std::max(travel_, (x_[v] - start_[v]).norm());
}

double ConstraintContact::fastest() const {
  double square = 0;
  const Rows v = bodies_.front()->v();
  for (Index i = 0; i < v.count; ++i) square = std::max(square, Vec3(v[i]).squaredNorm());
  return std::sqrt(square);
}

/// What is left of the proof that nothing has passed through anything since the step has started [m]; below zero: it is none.
double ConstraintContact::proof() const {
  const Surfaces& s = law_.surfaces;
  const Vec3 way = law_.moved - moved_at_start_;
  const auto gone = [&](int v) { return (x_[std::size_t(v)] - start_[std::size_t(v)] - way).norm(); };
  double left = 2 * way_;  // what is farther away is in no pair
  if (start_.size() != x_.size()) return left;
  for (int v = 0; v < int(x_.size()); ++v)
    if (s.moves(v)) left = std::min(left, 2 * way_ - gone(v));
  const auto look = [&](const KeptGap& contact) {
    if (!contact.pair) return;  // a plane has no other side to pass to unseen
    double nearest = contact.distance;
    FourPoints start, ways;
    for (std::size_t k = 0; k < 4; ++k) {
      const std::size_t v = std::size_t(contact.v[k]);
      start[k] = start_[v], ways[k] = x_[v] - start_[v];
      if (s.moves(contact.v[k])) nearest = std::min(nearest, contact.distance - gone(contact.v[k]));
    }
    if (nearest < 0 && longestStep(contact.pair->kind, start, ways) < 1) left = std::min(left, nearest);
  };
  for (const KeptGap& contact : found_) look(contact);
  for (const KeptGap& contact : watched_) look(contact);
  return left;
}

void ConstraintContact::addContact(const KeptGap& contact, double reach) {
  KeptGap added = contact;
  added.look(law_, x_);
  if (added.gap + law_.range > reach) return;
  added.side = added.n, added.side_c = added.c;
  if (contact.pair) added.distance = added.gap + law_.range + law_.thickness + contact.pair->radius;
  added.across = added.n.unitOrthogonal();
  (added.isOfParallelEdges(law_, x_) ? watched_ : found_).push_back(added);
}

/// The way of the two places past each other in the step.
Vec3 ConstraintContact::slide(const KeptGap& contact) const {
  if (!contact.pair) {
    const std::size_t v = std::size_t(contact.v[0]);
    return (x_[v] - law_.moved) - (start_[v] - moved_at_start_);
  }
  Vec3 way = Vec3::Zero();
  for (std::size_t k = 0; k < 4; ++k) {
    const std::size_t v = std::size_t(contact.v[k]);
    way += contact.c[k] * (x_[v] - start_[v]);
  }
  return way;
}

// Nodes with a weight of zero have a gradient too: the conditions read where they are.
void ConstraintContact::addConditions(ConstRows x, ConstRows, LagrangianRows& rows) const {
  law_.surfaces.gather(x, law_.moved, x_);
  for (KeptGap& contact : found_) contact.counts = true, contact.look(law_, x_);
  ignoreDoubles(found_, keys_);
  const auto add = [&](const KeptGap& contact, const Vec3& along) {
    for (std::size_t k = 0; k < 4; ++k)
      if (contact.v[k] >= 0 && law_.surfaces.moves(contact.v[k]))
        rows.add(law_.surfaces.rows[std::size_t(contact.v[k])], contact.c[k] * along);
  };
  for (const KeptGap& contact : found_) {
    const auto kindOf = [&contact](LagrangianRows::Kind kind) { return contact.counts ? kind : LagrangianRows::Kind::given; };
    rows.begin(kindOf(LagrangianRows::Kind::push), contact.gap);
    add(contact, contact.n);
    if (friction_ == 0) continue;
    const Vec3 slid = slide(contact);
    for (const Vec3& tangent : {contact.tangent, Vec3(contact.n.cross(contact.tangent))}) {
      rows.begin(kindOf(LagrangianRows::Kind::rub), tangent.dot(slid), contact.counts ? friction_ : 0);
      add(contact, tangent);
    }
  }
  rows.begin(LagrangianRows::Kind::push, std::min(proof(), 0.0));  // no force helps where it is below zero
}

void ConstraintContact::takeForces(std::span<const double> forces) {
  moved_at_start_ = law_.moved;
  forces_.assign(forces.begin(), forces.end());
  end_ = x_;
  contacts_ = 0;
  smallest_gap_ = std::numeric_limits<double>::infinity();
  contact_forces_.assign(std::size_t(bodies_.front()->size()), Vec3::Zero());
  wrenches_.assign(2, Vec3::Zero());
  const std::size_t each = friction_ > 0 ? 3 : 1;
  for (std::size_t i = 0; i < found_.size(); ++i) {
    const KeptGap& contact = found_[i];
    smallest_gap_ = std::min(smallest_gap_, contact.gap + law_.range);
    const double* l = forces.data() + each * i;
    if (!(l[0] > 0)) continue;
    ++contacts_;
    Vec3 whole = l[0] * contact.n;
    if (each == 3) whole += l[1] * contact.tangent + l[2] * contact.n.cross(contact.tangent);
    for (std::size_t k = 0; k < 4; ++k) {
      if (contact.v[k] < 0 || !law_.surfaces.moves(contact.v[k])) continue;
      const std::size_t v = std::size_t(contact.v[k]);
      const Vec3 force = contact.c[k] * whole;
      contact_forces_[std::size_t(law_.surfaces.rows[v] - bodies_.front()->firstRow())] += force;
      wrenches_[0] += force;
      wrenches_[1] += x_[v].cross(force);
    }
  }
  if (found_.empty()) smallest_gap_ = 0;
}

void ConstraintContact::reset() {
  moved_at_start_ = law_.moved = obstacles_.displacement(node().root().root_time);
  start_.clear(), end_.clear(), found_.clear(), watched_.clear();
  forces_.clear(), contact_forces_.clear(), wrenches_.clear();
  travel_ = way_ = smallest_gap_ = 0;
  contacts_ = 0;
}

void ConstraintContact::serialize(Archive& archive) {
  for (int k = 0; k < 3; ++k) archive.value(std::string("moved_") + char('x' + k), moved_at_start_[k]);
  archive.list("start", start_);
  archive.value("travel", travel_);
  archive.value("way", way_);
  archive.value("contacts", contacts_);
  archive.value("smallest_gap", smallest_gap_);
  archive.list("forces", forces_);
  archive.list("contact_forces", contact_forces_);
  archive.list("wrenches", wrenches_);
  if (archive.isReading()) end_.clear();
}

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(constraint_contact) {
  factory.add<stroma::ConstraintContact>("ConstraintContact",
                                         "surfaces that keep a distance, with friction, by forces of constraint");
}
