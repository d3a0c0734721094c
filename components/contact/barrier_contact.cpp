// SPDX-License-Identifier: LGPL-2.1-or-later
// BarrierContact: surfaces that push each other apart before they touch, and never pass through each other.
//
// A pressure that depends on the gap d acts between the surfaces of `mstate` and `other`, of each with itself (selfContact) and with
// obstacles. With r = d/contactDistance and stiffness kappa it is, for r < 1,
//
//   p = kappa (2 (r - 1) ln r + (r - 1)^2 / r)
//
// Its energy per area, -kappa contactDistance (r - 1)^2 ln r, has no bound as the gap closes. Under kappa/10 surfaces rest at 0.83
// contactDistance, under kappa/1000 at 0.98. Vertices carry their share of the surface (contact_terms.h), so that forces hardly depend on
// the mesh. The tangent is exact except for the change of shares, or its stable part. The gap is the distance minus `thickness`.
//
// Friction: with l the normal force of a contact and u the slip along the surfaces since the start of the step, the force is mu l f
// against u, f = 2 y - y^2 with y = |u| / (slipVelocity dt) below 1, else 1. Sticking contacts therefore creep, at less than
// slipVelocity. l and directions are those of the previous solve; solves are repeated until they no longer change, at most
// frictionIterations times. Contacts that a tool may drag along stick in the first of them. Sticking contacts have the mu of
// `staticFriction`, those faster than twice slipVelocity that of `friction`; mu is updated with the solves like l. Adhering surfaces
// attract each other by a tension. It has its maximum, `adhesion`, at the gap adhesionPeak, and ends at adhesionDistance:
//
//   adhesion d/adhesionPeak below adhesionPeak,   adhesion (adhesionDistance - d)/(adhesionDistance - adhesionPeak) beyond
//
// l is then the compressive part. adhesionFriction times the tension adds to the friction of sticking contacts, not of sliding ones.
//
// The shares of vertices are updated in the first six force evaluations of a solve and then fixed (line_shares.h); with friction, whose
// solves compare forces, they are fixed from its start. A solve is repeated if updated shares would change its forces by more than a
// hundredth. Every iterate is shortened before anything penetrates, with allowance for round-off. After each step an exact test of all
// edges against all triangles detects crossings; `crossings` counts such steps. Paths of threads and points are tested twice
// (path_proofs.h). Surfaces that intersect at the start are rejected, or pushed apart by resolveStart (contact_start.h). Implicit
// integrators use Newton's method. Explicit ones subdivide steps (integrators/explicit_parts.h), with contact_springs.cpp for friction.
//
// Surfaces are the boundary of the volume cells of a mesh, or its triangles and quads when it has none; quadratic triangles count as
// four. Points of one piece that are nearer than contactDistance at rest do not push each other, but cannot cross. A state may be mapped: a
// rigid tool is a frame that carries the nodes of a surface by a RigidMapping. With a SphereCollisionModel a state is balls around its
// nodes; one with a surface too is refused. States of `other` that no integrator moves are obstacles. Others are planes (nx ny nz o: bodies
// are where n.x > o), spheres (x y z r), capsules and cylinders (x y z  x y z  r) and boxes (two corners). They are fixed, or move together
// by `movements` at `keyTimes`, as far as their path is free, while bodies yield. A step is solved again until they have gone all the way.
// `offset` moves them by hand: after a dozen solves the rest is left for the next step.
//
// Source: Li, Ferguson, Schneider, Langlois, Zorin, Panozzo, Jiang and Kaufman 2020; Li et al. 2023 (physical barrier); Fang, Li, Cao,
// Li, Wolper, Yang and Jiang 2023 (adhesion).
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 -9.81">
//   <EulerImplicitSolver/>
//   <SparseLDLSolver/>
//   <MeshTopology position="0 0 0  1 0 0  0 1 0  0.3 0.3 0.8" tetrahedra="0 1 2 3"/>
//   <MechanicalObject/>
//   <UniformMass totalMass="2"/>
//   <TetrahedronFEMForceField youngModulus="1e5" poissonRatio="0.3"/>
//   <BarrierContact contactDistance="0.25" planes="-0.19 0.29 0.94 -0.35"/>
// </Node>
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "components/contact/contact_bodies.h"
#include "components/contact/contact_field.h"
#include "components/contact/contact_inside.h"
#include "components/contact/contact_start.h"
#include "components/contact/friction_rounds.h"
#include "components/contact/line_shares.h"
#include "components/contact/path_proofs.h"
#include "components/contact/step_energy.h"
#include "framework/mechanics/step_limiter.h"
#include "framework/scene/archive.h"
#include "framework/scene/factory.h"
#include "framework/scene/node.h"

namespace stroma {
namespace {

using namespace contact;

class BarrierContact final : public ContactField, public StepLimiter, public CorrectsStart {
 public:
  void declare(DataTable& table) override;
  ForceTraits traits() const override {
    ForceTraits traits;
    traits.symmetric = true;
    traits.conservative = !friction_.acts();
    traits.undamped = true;  // it changes by decades within a step
    return traits;
  }
  void compile() override;
  double energy(ConstRows x) const override;
  void addForce(ConstRows x, ConstRows v, Rows f) override;
  void addPattern(BlockPattern& pattern) const override {
    law_.addPattern(pattern), friction_.terms().addPattern(pattern), terms_.addPattern(pattern);
  }
  void stepBegins(ConstRows x, double t, double t_end) override;
  void placeStart(Rows x, Index independent, const std::function<void(Rows)>& project) override;
  void checkStart(ConstRows x) override;
  double longestStep(ConstRows x, const StepPath& way) override;
  bool updatesLagged(ConstRows x) override;
  bool isIntermediate() const override { return !is_explicit_ && ((gets_on_ && obstaclesGoOn()) || friction_rounds_.goOn(friction_)); }
  bool hasRemainingMotion() const override { return waits_; }
  void addPush(Rows f) const override { terms_.addPush(goal_ - law_.moved, f), friction_.terms().addPush(goal_ - law_.moved, f); }
  void advanceRemainingMotion(double s) override;
  void wantStartForces(bool wanted, double of_end) override { holds_nothing_ = wanted, of_end_ = of_end; }
  void setTime(double t) override { law_.moved = is_explicit_ && is_in_step_ ? placeAt(t) : law_.moved; }
  std::string overlap(ConstRows x) override;
  std::string doubt(ConstRows) const override { return step_energy_.doubt(paths_.doubt(path(), outputs_.doubt())); }
  std::string worstElement(ConstRows x) const override { return gather(x, law_.moved), describeWorst(lawAt(x_), x_, names()); }
  bool useDefiniteTangent(bool on) override { return friction_.definite = on, tangent_ = on ? Tangent::definite : Tangent::whole, true; }
  void reset() override { law_.candidates.forget(), startObstacles(), outputs_.reset(), step_energy_.forget(), paths_.reset(); }
  void serialize(Archive& archive) override;

 private:
  void startObstacles();
  void follow(ConstRows x);
  void beginRounds();
  void beginPart(double t, double t_end);
  /// Of obstacles in explicit steps; a hand leads them by an eighth of the mean edge per step, and not faster than barriers stop.
  Vec3 ledTo() const { return obstacles_.ledFrom(arrived_, std::min(0.125 * mean_edge_, fastest_ * (to_ - from_))); }
  Vec3 placeAt(double t) const { return obstacles_.pathAt(t) + arrived_ + (t - from_) / (to_ - from_) * (ledTo() - arrived_); }
  void startStep(ConstRows v);
  bool hasArrived() const { return (goal_ - law_.moved).norm() <= 1e-9 * law_.range; }  // parts of a way add up to it but for round-off
  bool isLed() const { return is_behind_ || arrived_ != obstacles_.offset(); }
  bool obstaclesGoOn() const { return !hasArrived() && obstacle_rounds_ < (isLed() ? 12 : 1000); }
  double leastMargin() const { return 0.5 * law_.range; }
  /// Where surfaces push from as far as edges are long, many pairs are near, and a longer margin would cost more than it saves.
  double mostMargin() const { return 0.35 * mean_edge_ - law_.range; }
  /// A copy that knows the pairs at x: who only asks leaves no trace.
  BarrierLaw lawAt(const std::vector<Vec3>& x) const {
    BarrierLaw law = law_;
    return law.candidates.findAgain(x, leastMargin(), mostMargin()), law;
  }
  void lookAgain(const std::vector<Vec3>& x) const {
    if (law_.candidates.findAgain(x, leastMargin(), mostMargin())) has_new_pairs_ = true;
  }
  void slideTo(const std::vector<Vec3>& x) {
    const Vec3 way = law_.moved - moved_at_start_;
    is_explicit_ ? friction_.stretch(law_, law_.touches(x), x, start_, way) : friction_.compute(law_.surfaces, x, start_, way);
  }
  bool frictionChanges(bool was_held);
  /// At x_. `again`: if that is where the step began, what has been found on the way does not count.
  void startPaths(bool again) {
    again && law_.moved == moved_at_start_ && law_.surfaces.areBodiesAt(x_, start_) ? paths_.startAgain(x_) : paths_.startAt(x_);
  }
  /// Shares that stayed in the solve, against those of where it has ended.
  bool sharesChange() { return share_rounds_.goOn(law_.isOutOfReach(x_) ? 0 : law_.changeByWeighing(x_, forces_before_, forces_)); }
  std::function<std::string(int)> names() const { return [this](int vertex) { return nameOfVertex(law_.surfaces, states(), vertex); }; }

  static constexpr double ease = 1e-3;  ///< of contactDistance, may creep what sticks where a step is solved again, or creep is to be tiny
  // ---- attributes ----
  FrictionRounds friction_rounds_;
  bool resolve_start_ = false;

  mutable bool has_new_pairs_ = false;  ///< others push since the pattern was last said to be another
  std::vector<Vec3> way_, forces_, forces_before_;
  std::vector<double> bend_;
  Vec3 goal_ = Vec3::Zero(), moved_first_ = Vec3::Zero();  ///< where obstacles are to come; had come with bodies at the start
  double fastest_ = 0;           ///< a hand leads obstacles in explicit steps [m/s]
  Vec3 arrived_ = Vec3::Zero();  ///< the offset that obstacles have come to last
  bool is_in_step_ = false, is_explicit_ = false;  ///< steps solve nothing: forces are those where parts of them start
  double from_ = 0, to_ = 0, duration_ = 0, of_end_ = 1;  ///< times of the step; its length, or that of an explicit part [s]
  bool is_carried_ = false;  ///< what is moved has gone on since the last force
  bool left_start_ = false, holds_nothing_ = false, has_solved_ = false, waits_ = false;  ///< see hasRemainingMotion()
  int obstacle_rounds_ = 0;
  bool gets_on_ = false;  ///< obstacles have gone far beside contactDistance; little says that a contact has not opened again
  bool is_behind_ = false;  ///< obstacles begin the step elsewhere than where path and hand had them then
  LineShares shares_;
  ShareRounds share_rounds_;
  BarrierLaw::Shares solved_shares_;  ///< of the solve that has ended, where there is one in the step; its slides
  std::vector<Friction::Slide> solved_slides_;
  Tangent tangent_ = Tangent::whole;
  StepEnergy step_energy_;
  PathProofs paths_;
};

void BarrierContact::declare(DataTable& table) {
  ContactField::declare(table);
  table.add("frictionIterations", friction_rounds_.most).help("most solves of a step for directions of friction").unit("-").min(1);
  declareAdhesion(table, law_.adhesion, friction_);
  table.add("resolveStart", resolve_start_).help("bodies that start in one another are pushed apart");
  outputs_.declare(table), paths_.declare(table);
}

void BarrierContact::compile() {
  compileSurfaces();
  finishAdhesion(law_.adhesion, friction_, law_.range);
  friction_.farthest = std::max(law_.range, 0.25 * mean_edge_);
  paths_.compile(law_.surfaces, self_);
  law_.compile(), fastest_ = fastestLead(law_, bodies_), friction_.balance = &step_energy_, step_energy_.compile(law_, bodies_);
  startObstacles();
  way_.resize(law_.surfaces.rows.size()), forces_.resize(way_.size()), forces_before_.resize(way_.size());
}

void BarrierContact::placeStart(Rows x, Index independent, const std::function<void(Rows)>& project) {
  if (!resolve_start_) return;
  constexpr double part = 0.98;  // of the gap at which surfaces begin to push
  outputs_.moved_start = pushApart(law_, listed_.startBodies(topology_, *this), part * law_.range, independent, project, x);
}

void BarrierContact::checkStart(ConstRows x) {
  gather(x, law_.moved);
  refuseOverlap(path(), law_, x_, names(), leastMargin());
  refuseInside(path(), law_.surfaces, x_);
  has_new_pairs_ = true;
}

// ---- forces ----

double BarrierContact::energy(ConstRows x) const {
  gather(x, law_.moved);
  if (!is_in_step_ && !law_.candidates.covers(x_)) return lawAt(x_).energy(x_);
  lookAgain(x_);
  return step_energy_.hasStart() ? step_energy_.energy(law_, x_) : law_.energy(x_);
}

void BarrierContact::addForce(ConstRows x, ConstRows v, Rows f) {
  follow(x);
  lookAgain(x_);
  pattern_revision_ += std::exchange(has_new_pairs_, false);
  const bool begins = std::exchange(is_carried_, false), are_free = !is_explicit_ && !friction_.acts();  // shares
  if (const auto* place = are_free ? shares_.placeFor(x_) : is_explicit_ || begins ? &x_ : nullptr) law_.weigh(*place);
  terms_.clear();
  const std::vector<Touch>& touches = law_.touches(x_);
  for (const Touch& touch : touches) terms_.push_back(law_.termOf(touch, x_, is_explicit_ ? Tangent::normal : tangent_));
  if (is_in_step_ && !is_explicit_ && holds_nothing_ && !left_start_) return startStep(v);
  step_energy_.complete(terms_, law_, touches, f), terms_.addForce(f);
  if (!friction_.acts() || start_.size() != x_.size()) return;
  if (!is_explicit_ && !holds_nothing_ && friction_rounds_.mayHold()) friction_.hold(x_, start_, law_.moved - moved_at_start_);
  slideTo(x_), friction_.terms().addForce(f);
}

/// Forces of the start are in those of the solves, which find how much of them counts.
void BarrierContact::startStep(ConstRows v) {
  step_energy_.stepBegins(), friction_.note(law_, law_.touches(x_));
  if (friction_.acts()) friction_.computeAtSpeed(law_.surfaces, v, duration_, start_, goal_ - moved_at_start_, way_);
  step_energy_.startsAt(law_, x_, of_end_, friction_), friction_.note(law_, law_.touches(x_));
}

// ---- steps ----

/// Of an explicit step. What is moved goes along with the bodies, and is where it was at t until they have gone.
void BarrierContact::beginPart(double t, double t_end) {
  if (friction_.acts() && start_.size() == x_.size() && !law_.surfaces.areBodiesAt(x_, start_)) {
    law_.weigh(x_);
    slideTo(x_);
    friction_.keepStretched(x_, start_, law_.moved - moved_at_start_);
  }
  law_.moved = moved_at_start_ = placeAt(t), goal_ = placeAt(t_end);
}

void BarrierContact::stepBegins(ConstRows x, double t, double t_end) {
  is_explicit_ = holds_nothing_, waits_ = false;  // what waited was of a solve that was stopped
  if (!is_in_step_ || t_end > to_) from_ = t, to_ = t_end;
  follow(x);
  if (law_.candidates.isNew()) has_new_pairs_ = true, law_.candidates.find(x_, leastMargin()), law_.candidates.crossings(x_);
  lookAgain(x_);  // whether or not somebody has asked between steps
  law_.candidates.stepBegins();
  const bool again = is_in_step_ && !has_solved_;
  is_in_step_ = true, has_solved_ = false, step_energy_.stepBegins();
  law_.small_range = is_explicit_ ? 0.5 : 0.1, law_.small_share = is_explicit_ ? 1 : 0.1;
  if (is_explicit_) beginPart(t, t_end), gather(x, law_.moved);
  duration_ = t_end - t;
  friction_.setSlip(slip_velocity_ * duration_);
  friction_.begin(x_.size());
  is_explicit_ && again ? paths_.moveTo(x_) : startPaths(again);
  if (is_explicit_) return copyPlaces(x_, start_);
  if (friction_.acts() && start_.size() == x_.size()) {
    lookAgain(x_), law_.weigh(x_);
    friction_.note(law_, law_.touches(x_));
    friction_.remember(x_, start_, law_.moved - moved_at_start_);
  }
  copyPlaces(x_, start_);
  moved_at_start_ = moved_first_ = law_.moved;
  is_behind_ = (law_.moved - obstacles_.displacement(t)).norm() > 1e-9 * law_.range;
  outputs_.friction_change = 0;
  goal_ = obstacles_.displacement(t_end);
  friction_.ease(ease * law_.range, again);
  beginRounds();
}

void BarrierContact::beginRounds() {
  obstacle_rounds_ = 0, share_rounds_.stepBegins(), shares_.solveBegins();
  left_start_ = is_carried_ = gets_on_ = false;
  friction_.beginAgain(), lookAgain(x_), law_.weigh(x_);
  friction_.note(law_, law_.touches(x_));
  friction_rounds_.begin(friction_);
  waits_ = !hasArrived() && law_.moved == moved_at_start_;
}

/// x_ become positions at x. Where an integrator takes bodies back to the start of a step, obstacles begin theirs again. A line search
/// that finds nothing comes back too: what waits then goes on, and what has not moved has its rounds behind it.
void BarrierContact::follow(ConstRows x) {
  gather(x, law_.moved);
  if (is_explicit_) return;
  const bool is_back = law_.surfaces.areBodiesAt(x_, start_);
  if (is_back && left_start_ && !waits_) {
    if (holds_nothing_) moved_first_ = moved_at_start_;
    const int rounds = law_.moved == moved_first_ ? obstacle_rounds_ : 0;
    law_.moved = moved_first_;
    gather(x, law_.moved), startPaths(true);
    friction_.ease(ease * law_.range, true);
    beginRounds(), obstacle_rounds_ = rounds;
  } else if (is_back && left_start_) {
    paths_.placeBodies(x_);
  }
  left_start_ = !is_back;
  if (is_back) moved_first_ = law_.moved;
}

double BarrierContact::longestStep(ConstRows x, const StepPath& way) {
  way.is_carried ? void(is_carried_ = true) : friction_.lineStarts();
  shares_.lineBegins(way.is_carried), has_solved_ = false;
  const Vec3 from = is_explicit_ ? moved_at_start_ : law_.moved;
  const Vec3 along = waits_ ? Vec3(way.along * (goal_ - from)) : Vec3(law_.moved - from);
  gather(x, from), paths_.moveTo(x_);
  law_.surfaces.gatherWay(way.dx, along, way_);
  law_.surfaces.gatherBends(way.bend, bend_);
  const double step = law_.longestStep(x_, way_, bend_, along);
  return paths_.allow(x_, way_, bend_, step), step;
}

bool BarrierContact::updatesLagged(ConstRows x) {
  if (is_explicit_) return law_.moved = goal_, false;
  gather(x, law_.moved);
  if (obstaclesGoOn()) {
    law_.weigh(x_), shares_.solveBegins(), friction_.note(law_, law_.touches(x_));
    return ++obstacle_rounds_, waits_ = true;
  }
  law_.copyShares(solved_shares_);
  step_energy_.look(law_, x_, start_, law_.moved - moved_at_start_, x);
  const bool others = sharesChange(), goes_on = friction_rounds_.goOn(friction_), held = friction_.release();
  solved_slides_ = friction_.slides;
  const bool rubs = (friction_.acts() && frictionChanges(held)) || goes_on;
  const bool again = (held || rubs) && friction_rounds_.takeAnother();
  const bool sharpens = !again && !others && friction_.isRelaxed();
  if (sharpens) friction_rounds_.sharpen(friction_, law_, x_, start_, law_.moved - moved_at_start_);
  const bool settles = !again && !others && !sharpens;
  has_solved_ = settles && !step_energy_.goesOn();
  if (has_solved_) return friction_.settle(), false;
  if (settles) friction_.noteAgain(law_, law_.touches(x_), x_, start_, law_.moved - moved_at_start_);
  shares_.solveBegins(true);
  return true;
}

void BarrierContact::advanceRemainingMotion(double s) {
  if (!std::exchange(waits_, false)) return;
  const Vec3 way = s * (goal_ - law_.moved);
  gets_on_ = way.norm() > 0.02 * law_.range;
  law_.moved = s < 1 ? Vec3(law_.moved + way) : goal_, friction_.looksAgain();
}

/// Friction with the forces and shares that have been found now, against that of the solve before.
bool BarrierContact::frictionChanges(bool was_held) {
  outputs_.friction_change = friction_.renew(law_, x_, start_, law_.moved - moved_at_start_, was_held, forces_before_, forces_);
  return friction_rounds_.changes(outputs_.friction_change, was_held);
}

std::string BarrierContact::overlap(ConstRows x) {
  follow(x), paths_.moveTo(x_), paths_.noteStep(names());
  const auto crossings = law_.candidates.crossings(x_);
  const bool has_balance = std::exchange(has_solved_, false) && law_.putBack(solved_shares_);
  lookAgain(x_);
  if (has_balance) friction_.slides = solved_slides_;
  if (!has_balance) law_.weigh(x_);
  friction_.release();
  step_energy_.stepTaken(law_, x_, start_, law_.moved - moved_at_start_, x);
  slideTo(x_);
  outputs_.note(law_, law_.touches(x_), friction_, x_, bodies_);
  is_in_step_ = false;
  const std::string found = outputs_.overlap(path(), crossings, law_.surfaces, names());
  if (hasArrived()) arrived_ = is_explicit_ ? ledTo() : obstacles_.offset();
  if (found.empty() && !hasArrived() && !isLed())
    return fmt::format("the obstacles of {} have not gone all the way: {:.3g} m are left", path(), (goal_ - law_.moved).norm());
  outputs_.crossings += !found.empty(), outputs_.noteSettling(has_balance ? share_rounds_.left() : 0);
  return found;
}

void BarrierContact::startObstacles() {
  goal_ = law_.moved = moved_at_start_ = obstacles_.startAt(state().node().root().root_time);
  arrived_ = obstacles_.startOffset();
  start_.clear(), terms_.clear(), friction_.clear();
  is_in_step_ = left_start_ = is_carried_ = waits_ = false, ++pattern_revision_;
}

void BarrierContact::serialize(Archive& archive) {
  law_.candidates.serialize(archive);
  archive.list("start", start_), archive.value("new_pairs", has_new_pairs_);
  serializePlace(archive, "moved", law_.moved);
  serializePlace(archive, "began", moved_at_start_);
  serializePlace(archive, "arrived", arrived_);
  friction_.serialize(archive);
  step_energy_.serialize(archive), paths_.serialize(archive);
  outputs_.serialize(archive);
  if (!archive.isReading()) return;
  goal_ = law_.moved, left_start_ = is_in_step_ = false, ++pattern_revision_;
}

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(barrier_contact) {
  factory.add<stroma::BarrierContact>("BarrierContact",
                                      "surfaces that push each other apart and never pass through each other");
}
