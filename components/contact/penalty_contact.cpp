// SPDX-License-Identifier: LGPL-2.1-or-later
// PenaltyContact: surfaces that push each other with a pressure proportional to the violation of their contact distance.
//
// Surfaces of `mstate` and `other`, obstacles and paths are those of BarrierContact and ConstraintContact. At the start of a
// step, a vertex and a triangle or two edges that are nearer than alarmDistance become a contact, with their closest points p
// and q and the normal n from q to p. These are fixed during the step; contact_rims.h treats sharp rims. With the gap d = (p -
// q).n minus radii and `thickness`, A the share of the vertex in the surface (contact_terms.h) and kappa the stiffness, a
// contact pushes while d < contactDistance:
//
//   pressure = kappa (1 - d/contactDistance),   K = -k n n^T with k = kappa A/contactDistance
//
// so that forces hardly depend on the mesh: under kappa/10 surfaces rest at 0.9 contactDistance, under kappa they touch, and
// under more they intersect. Penetration is not excluded: nodes that are deeper than half of a body, or move farther than
// alarmDistance in a step, may come out on the other side. BarrierContact and ConstraintContact exclude that. Every dynamic
// integrator supports it, explicit ones with a step below 2/sqrt(k/m). `offset` moves obstacles during a run, by at most half
// of alarmDistance per step. StaticSolver rejects a body that is supported only by its contacts.
//
// Friction: with l the force of a contact at the start of the step and u its slip along the surfaces since then, mu l f
// against u, f = 2 y - y^2 with y = |u| / (slipVelocity dt) below 1, else 1. mu is staticFriction for contacts that stuck in
// the previous step. If round surfaces have slid out of reach as normals turned, l is the force along the previous normal.
// This applies to integrators that iterate. With one linear solve, and in explicit steps, springs that slip at mu l hold
// sticking contacts (contact_springs.cpp).
//
// CollisionResponse has the same penalty with SOFA's stiffness per contact, between collision models.
//
// Source: penalty of SOFA (PenalityContactForceField), friction of Li, Ferguson, Schneider and others 2020.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 -9.81">
//   <EulerImplicitSolver/>
//   <SparseLDLSolver/>
//   <MeshTopology position="0 0 0  1 0 0  0 1 0  0.3 0.3 0.8" tetrahedra="0 1 2 3"/>
//   <MechanicalObject/>
//   <UniformMass totalMass="2"/>
//   <TetrahedronFEMForceField youngModulus="1e5" poissonRatio="0.3"/>
//   <PenaltyContact contactDistance="0.162" planes="-0.19 0.29 0.94 -0.35"/>
// </Node>
#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "components/contact/contact_bodies.h"
#include "components/contact/contact_field.h"
#include "components/contact/contact_rims.h"
#include "components/contact/passages.h"
#include "framework/mechanics/step_limiter.h"
#include "framework/scene/archive.h"
#include "framework/scene/factory.h"
#include "framework/scene/node.h"
#include "framework/simulation/integrator.h"

namespace stroma {
namespace {

using namespace contact;

class PenaltyContact final : public ContactField, public StepListener {
 public:
  void declare(DataTable& table) override;
  ForceTraits traits() const override {
    ForceTraits traits;
    traits.symmetric = traits.exact_tangent = traits.lagged = true;
    traits.conservative = !friction_.acts();
    traits.time_dependent = is_explicit_;
    traits.undamped = friction_.acts() && solves() == Solves::often;  // what sticks, 2 mu l/(slipVelocity dt), is no stiffness
    return traits;
  }
  void init() override;
  void compile() override;
  void setTime(double t) override;
  void stepBegins(ConstRows x, double t, double t_end) override;
  double energy(ConstRows x) const override;
  void addForce(ConstRows x, ConstRows v, Rows f) override;
  void addPattern(BlockPattern& pattern) const override { contacts_.addPattern(pattern); }
  void reset() override;
  void serialize(Archive& archive) override;
  std::string doubt(ConstRows x) const override;

 private:
  Touch at(const Touch& start, const std::vector<Vec3>& x) const;
  Term termOf(const Touch& touch) const;

  /// How the integrator finds a step: by iterates, by one linear solve, or by forces where it starts.
  enum class Solves { often, once, never };
  Solves solves() const;
  void rubbed(const std::vector<Touch>& touches, bool again);
  void rub(ConstRows v);
  void checkAlarm() const;
  void startObstacles();
  void noteEnd(ConstRows x, double t);
  void lookAtWay(Passages& passages, double t) const;
  void serializeFound(Archive& archive);
  const std::vector<Touch>& pushing();

  bool is_found_ = false, has_new_ = false;  ///< contacts are those of a step; of other rows than those of the last force
  std::vector<Touch> found_, touches_;       ///< where the step starts; at the x of the last force
  Terms contacts_;                           ///< of all that were found
  Vec3 led_ = Vec3::Zero(), led_next_ = Vec3::Zero();  ///< of the offset, what obstacles have come where the step starts, and ends
  Passages passages_;
  double began_ = 0;                                   ///< when it starts; not a number before the first one [s]
  // ---- for friction ----
  std::vector<double> pushed_;      ///< of each vertex, the least gap of its contacts where the step before ended [m]
  std::vector<Vec3> pushed_along_;  ///< the normal of that one
  std::vector<Touch> pushing_;      ///< those of the step, see pushing()
  const Integrator* integrator_ = nullptr;
  bool is_explicit_ = false, has_leant_ = false;
  double duration_ = 0;     ///< of the step [s]
  std::vector<Vec3> way_;   ///< work space
};

void PenaltyContact::declare(DataTable& table) {
  ContactField::declare(table);
  table.add("alarmDistance", law_.alarm)
      .help("gap below which contacts are found where a step starts; 0: twice contactDistance")
      .unit("m")
      .min(0);
  outputs_.declareForces(table);
}

/// The integrator is that of mstate, which need not be ready yet.
void PenaltyContact::init() {
  ContactField::init();
  checkAlarm();
  for (const Node* node = &state().node(); node && !integrator_; node = node->parent())
    for (const auto& component : node->components())
      if (!integrator_) integrator_ = dynamic_cast<const Integrator*>(component.get());
  const auto* heeds = dynamic_cast<const RespectsStepLimits*>(integrator_);
  friction_.is_damped = !integrator_ || integrator_->toleratesLaggedForces();
  is_explicit_ = heeds && heeds->howToRespectStepLimits().empty() && integrator_->movesInTime() && !integrator_->stateOwner();
}

/// What is not found until it is nearer than contactDistance is pushed too late, or never.
void PenaltyContact::checkAlarm() const {
  if (law_.alarm > 0 && law_.alarm < law_.range)
    throw ComponentError(fmt::format("alarmDistance of {} is {:g} m and contactDistance {:g} m", path(), law_.alarm, law_.range),
                         "an alarmDistance of contactDistance or more, and of what moves in a step besides");
}

void PenaltyContact::compile() {
  compileSurfaces();
  checkAlarm();
  if (law_.alarm == 0) law_.alarm = 2 * law_.range;
  law_.is_penalty = true;
  law_.compile();
  reset();
}

PenaltyContact::Solves PenaltyContact::solves() const {
  if (is_explicit_) return Solves::never;
  const auto* heeds = dynamic_cast<const RespectsStepLimits*>(integrator_);
  return heeds && !heeds->respectsStepLimits() ? Solves::once : Solves::often;
}

/// Of the step that has ended where this one starts, with the touches there.
void PenaltyContact::rubbed(const std::vector<Touch>& touches, bool again) {
  const Vec3 way = law_.moved - moved_at_start_;
  switch (solves()) {
    case Solves::often:
      friction_.note(law_, touches);
      friction_.remember(x_, start_, way);
      break;
    case Solves::once:
      if (!again) friction_.keepLeaning(law_, touches, x_, start_, way);
      break;
    case Solves::never:
      if (again) break;
      friction_.stretch(law_, touches, x_, start_, way);
      friction_.keepStretched(x_, start_, way);
      break;
  }
}

/// Friction at x_.
void PenaltyContact::rub(ConstRows v) {
  const Vec3 way = law_.moved - moved_at_start_;
  switch (solves()) {
    case Solves::often:
      friction_.compute(law_.surfaces, x_, start_, way);
      break;
    case Solves::once:
      if (!std::exchange(has_leant_, true)) friction_.leanAtSpeed(law_, pushing_, v, duration_, start_, way, way_);
      friction_.lean(law_, pushing_, x_, start_, way);
      break;
    case Solves::never:
      friction_.stretch(law_, touches_, x_, start_, way);
      break;
  }
}

/// Of the contacts of the step before, at its end x.
void PenaltyContact::noteEnd(ConstRows x, double t) {
  gather(x, law_.moved);
  lookAtWay(passages_, t);
  pushed_.clear(), pushed_along_.clear();
  if (!friction_.acts() || found_.empty()) return;
  pushed_.assign(start_.size(), law_.range), pushed_along_.assign(start_.size(), Vec3::Zero());
  for (const Touch& start : found_)
    if (const double gap = at(start, x_).gap; start.of_surface && gap < std::min(start.range, pushed_[std::size_t(start.v[0])]))
      pushed_[std::size_t(start.v[0])] = gap, pushed_along_[std::size_t(start.v[0])] = start.n;
}

/// Of the step that has ended at x_.
void PenaltyContact::lookAtWay(Passages& passages, double t) const {
  std::vector<Touch> ended;
  for (const Touch& start : found_)
    if (const Touch touch = at(start, x_); touch.gap < 0) ended.push_back(touch);
  passages.look(law_, ended, start_, x_, t);
}

std::string PenaltyContact::doubt(ConstRows x) const {
  gather(x, law_.moved);
  Passages passages = passages_;
  lookAtWay(passages, began_ + duration_);
  return passages.doubt(path(), [this](int vertex) { return nameOfVertex(law_.surfaces, bodies_, vertex); });
}

/// The contacts that have been found, with the force that they had in the step before and have lost as normals turned. That of a plane
/// never does: what is out of reach there has left. What has come into reach beside has a force that nothing has been in balance with.
const std::vector<Touch>& PenaltyContact::pushing() {
  constexpr double alike = 0.9, same = 1 - 1e-9;
  pushing_ = found_;
  for (Touch& touch : pushing_) {
    const auto vertex = std::size_t(touch.v[0]);
    if (!touch.of_surface || touch.v[1] < 0 || vertex >= pushed_.size()) continue;  // of two edges v[0] is an end of one
    const double turned = pushed_along_[vertex].dot(touch.n), before = pushed_[vertex];
    if (touch.gap < touch.range ? touch.gap < before : turned > alike && turned < same) touch.gap = before;
  }
  return pushing_;
}

/// Contacts at x, where the step begins.
void PenaltyContact::stepBegins(ConstRows x, double t, double t_end) {
  const bool again = t == began_;
  if (!again) led_ = led_next_, noteEnd(x, t);
  began_ = t, duration_ = t_end - t;
  led_next_ = obstacles_.ledFrom(led_, 0.5 * law_.alarm);
  law_.moved = obstacles_.pathAt(t) + led_;
  gather(x, law_.moved);
  law_.candidates.stepBegins();
  law_.candidates.findAgain(x_, 0.5 * law_.range, 0.25 * mean_edge_);
  law_.weigh(x_);
  found_ = law_.touches(x_);
  leaveRims(law_, x_, found_);
  friction_.slip = slip_velocity_ * duration_;
  friction_.begin(x_.size());
  const std::vector<Touch>& touches = friction_.acts() ? pushing() : found_;
  if (friction_.acts() && start_.size() == x_.size()) rubbed(touches, again);
  if (friction_.acts() && solves() == Solves::once) friction_.leanAgain(again), has_leant_ = false;
  friction_.note(law_, touches);
  start_ = x_, moved_at_start_ = law_.moved;
  law_.moved = obstacles_.pathAt(t_end) + led_next_;
  const auto rowsOf = [](const Term& term) { return term.rows; };
  Terms before = std::exchange(contacts_, {});
  for (const Touch& touch : found_) contacts_.push_back(termOf(touch));
  has_new_ = has_new_ || !std::equal(before.begin(), before.end(), contacts_.begin(), contacts_.end(),
                                     [&](const Term& a, const Term& b) { return rowsOf(a) == rowsOf(b); });
  is_found_ = true;
}

/// The contact with the gap that it has at x; obstacles have their vertices in x, but for planes.
Touch PenaltyContact::at(const Touch& start, const std::vector<Vec3>& x) const {
  Vec3 way = start.v[1] < 0 ? Vec3(moved_at_start_ - law_.moved) : Vec3(Vec3::Zero());
  for (std::size_t i = 0; i < 4; ++i)
    if (const int v = start.v[i]; v >= 0) way += start.c[i] * (x[std::size_t(v)] - start_[std::size_t(v)]);
  Touch touch = start;
  touch.gap += start.n.dot(way);
  return touch;
}

/// In explicit steps obstacles go along with the stages.
void PenaltyContact::setTime(double t) {
  if (!is_explicit_ || !is_found_) return;
  const double part = std::clamp((t - began_) / duration_, 0.0, 1.0);
  law_.moved = obstacles_.pathAt(t) + led_ + part * (led_next_ - led_);
}

/// Normals do not turn in a step.
Term PenaltyContact::termOf(const Touch& touch) const {
  Term term;
  for (std::size_t i = 0; i < 4; ++i) term.rows[i] = touch.v[i] >= 0 ? law_.surfaces.rows[std::size_t(touch.v[i])] : -1;
  const Slopes energy = law_.slopesOf(touch);
  term.c = touch.c;
  term.force = -energy.slope * touch.n;
  term.m = energy.curvature * touch.n * touch.n.transpose();
  return term;
}

double PenaltyContact::energy(ConstRows x) const {
  gather(x, law_.moved);
  double sum = 0;
  for (const Touch& touch : found_) sum += law_.slopesOf(at(touch, x_)).value;
  return sum;
}

void PenaltyContact::addForce(ConstRows x, ConstRows v, Rows f) {
  const Node& root = state().node().root();
  if (!is_found_) {  // asked for before the first step
    stepBegins(x, root.root_time, root.root_time + root.dt());
    law_.moved = moved_at_start_;
  }
  pattern_revision_ += std::exchange(has_new_, false);
  gather(x, law_.moved);
  terms_.clear(), touches_.clear();
  for (const Touch& start : found_) {
    const Touch touch = at(start, x_);
    if (!(touch.gap < touch.range)) continue;
    touches_.push_back(touch);
    terms_.push_back(termOf(touch));
  }
  terms_.addForce(f);
  if (friction_.acts()) rub(v), friction_.terms().addForce(f);
  outputs_.note(law_, touches_, friction_, x_, bodies_);
}

void PenaltyContact::startObstacles() {
  law_.moved = moved_at_start_ = obstacles_.startAt(state().node().root().root_time);
  led_ = led_next_ = obstacles_.startOffset();
  began_ = std::numeric_limits<double>::quiet_NaN();
}

void PenaltyContact::reset() {
  law_.candidates.forget();
  startObstacles();
  start_.clear(), found_.clear(), touches_.clear(), terms_.clear(), contacts_.clear(), friction_.clear();
  pushed_.clear(), pushed_along_.clear();
  is_found_ = false, outputs_.reset(), passages_.forget();
  ++pattern_revision_;
}

/// What the end of the step before will be asked for.
void PenaltyContact::serializeFound(Archive& archive) {
  std::vector<double> numbers;
  if (!archive.isReading())
    for (const Touch& touch : found_) {
      numbers.insert(numbers.end(), touch.v.begin(), touch.v.end());
      numbers.insert(numbers.end(), touch.c.begin(), touch.c.end());
      numbers.insert(numbers.end(), {touch.n.x(), touch.n.y(), touch.n.z(), touch.gap, touch.range});
    }
  archive.list("found", numbers);
  if (!archive.isReading()) return;
  constexpr std::size_t size = 13;
  found_.clear();
  for (std::size_t i = 0; i + size <= numbers.size(); i += size) {
    const double* const n = numbers.data() + i;
    Touch touch;
    for (int k = 0; k < 4; ++k) touch.v[std::size_t(k)] = int(n[k]), touch.c[std::size_t(k)] = n[4 + k];
    touch.n = Vec3(n[8], n[9], n[10]), touch.gap = n[11], touch.range = n[12];
    found_.push_back(touch);
  }
}

void PenaltyContact::serialize(Archive& archive) {
  archive.list("start", start_);
  if (friction_.acts()) serializeFound(archive);
  serializePlace(archive, "began", moved_at_start_);
  serializePlace(archive, "led", led_next_);
  serializePlace(archive, "moved", law_.moved);
  friction_.serialize(archive);
  passages_.serialize(archive);
  outputs_.serialize(archive);
  if (!archive.isReading()) return;
  is_found_ = false, led_ = led_next_, began_ = std::numeric_limits<double>::quiet_NaN();
  ++pattern_revision_;
}

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(penalty_contact) {
  factory.add<stroma::PenaltyContact>("PenaltyContact", "surfaces that push each other by a penalty");
}
