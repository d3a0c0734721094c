// SPDX-License-Identifier: LGPL-2.1-or-later
// ConstraintContact: surfaces that keep a distance from each other and from obstacles, with friction, by constraint forces at
// the end of each step.
//
// Surfaces of `mstate` and `other`, obstacles and paths are those of BarrierContact: soft, rigid, mapped and condensed bodies.
// With the distance d of a vertex and a triangle or of two edges, minus radii and `thickness`, the force l_n between them, the slip s
// along the surfaces in the step and the friction mu:
//
//   d >= contactDistance,   l_n >= 0,   one of them with equality;   s = 0, or |l_t| = mu l_n opposite to s
//
// Sticking contacts do not creep. The integrator finds the forces from the compliance of the bodies (Signorini and Coulomb): condensed
// bodies read it from their inverse; EulerImplicitSolver, TrapezoidalRuleSolver, BDFOdeSolver and StaticSolver solve for each
// condition. Distances and normals are those at the end of the step. Violations of gaps and of sticking up to `toleratedError`, by default
// a thousandth of contactDistance, are accepted; mostly they are round-off. Up to ten times that is reported at the end
// of a run. Edges whose bend is at most `toleratedError` high are flat (kept_gaps.h). Forces of a pair are equal and opposite.
//
// Pairs are found at the start of a step: those that may come near if bodies move at most twice as far as in the last step or at their
// speed, plus an eighth of the mean edge. Each step is also proved (kept_gaps.h): every pair can move on a straight path
// from the start to the end of the step without touching (Li, Kaufman and Jiang 2021), and nothing has moved farther than pairs
// were searched. A step that cannot be proved ends the run; BarrierContact is for such motions.
//
// Bodies that intersect at the start are rejected, or pushed apart by resolveStart (contact_start.h).
//
// A change of `offset` during a run moves obstacles by at most an eighth of the mean edge per step.
//
// A body has contact with itself with `selfContact`, except points that are nearer than contactDistance at rest.
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

#include "components/contact/body_list.h"
#include "components/contact/contact_bodies.h"
#include "components/contact/contact_inside.h"
#include "components/contact/contact_obstacles.h"
#include "components/contact/contact_outputs.h"
#include "components/contact/contact_start.h"
#include "components/contact/kept_forces.h"
#include "components/contact/kept_rows.h"
#include "components/contact/motion_bounds.h"
#include "framework/mechanics/lagrangian_constraint.h"
#include "framework/mechanics/mapping.h"
#include "framework/mechanics/open_choices.h"
#include "framework/mechanics/condition_roles.h"
#include "framework/mechanics/state_topology.h"
#include "framework/mechanics/step_limiter.h"
#include "framework/scene/archive.h"
#include "framework/scene/factory.h"
#include "framework/scene/node.h"
#include "framework/scene/usual_component.h"

namespace stroma {
namespace {

using namespace contact;

class ConstraintContact final : public Component, public LagrangianConstraint, public GuessesForces, public ChangesConditions,
                                public StepListener, public CorrectsStart, public DrawnObstacles, public OpenChoices {
 public:
  std::string roleText() const override { return "contact"; }
  void declare(DataTable& table) override;
  void init() override;
  std::vector<State*> constrainedStates() const override { return bodies_; }
  /// Before the first step, when mapped surfaces are where they belong: bad starts are refused.
  void stepBegins(ConstRows x, double, double) override {
    if (!is_built_) buildForRun(x);
  }
  void placeStart(Rows x, Index independent, const std::function<void(Rows)>& project) override;
  void constrainedStepBegins(ConstRows x, double t_end) override;
  void addConditions(ConstRows x, ConstRows x_start, LagrangianRows& rows) const override;
  void takeForces(std::span<const double> forces) override;
  void guessForces(std::span<double> forces, std::span<double> yields) const override {
    kept_forces_.expect(gaps_, law_.surfaces, x_, rowsOfEach(), forces, yields);
  }
  /// Where conditions between rigid bodies do not come to hold their directions stay; where they do not then either, they are let go.
  bool changeConditions(ConstRows, std::span<const double> forces, std::span<const double>) override {
    const bool keeps = gaps_.keepsDirections();
    if (!keeps && !kept_forces_.isViolated(gaps_, law_, x_, rowsOfEach(), forces, friction_, toleratedError())) return false;
    keeps ? gaps_.releaseDirections() : gaps_.keepDirections();
    return true;
  }
  std::string choice() const override {
    return fmt::format("{}, which keep a gap of {:.4g} m{}", namesOf(law_, bodies_, self_), law_.range,
                       friction_ > 0 ? fmt::format(", friction {:g}", friction_) : "");
  }
  void addShapes(std::vector<Shape>& shapes) const override { contact::addShapes(law_, shapes); }
  Vec3 shapesMovedBy() const override { return moved_at_start_; }
  Tolerance tolerance() const override { return {toleratedError(), reportedError()}; }
  void reset() override;
  void serialize(Archive& archive) override;

 private:
  void build();
  void buildForRun(ConstRows x);
  void checkStart();
  void checkFirstStep(ConstRows x);
  void refuseOverlaps() const;
  void warnOfNear();
  void checkMoves() const;
  void startObstacles();
  std::size_t rowsOfEach() const { return friction_ > 0 ? 3 : 1; }
  double toleratedError() const { return tolerated_error_ > 0 ? tolerated_error_ : 1e-3 * law_.range; }
  double reportedError() const { return 10 * toleratedError(); }
  std::string nameOf(int vertex) const { return nameOfVertex(law_.surfaces, bodies_, vertex); }

  Link<State> mstate_{"mechanical state"};
  BodyList listed_;
  TopologyLink topology_;
  Obstacles obstacles_;
  BarrierLaw law_;  ///< surfaces, obstacles and candidates; no barrier acts
  double friction_ = 0, tolerated_error_ = 0;
  bool self_ = false, resolve_start_ = false;
  int contacts_ = 0;
  std::vector<double> forces_;
  Outputs outputs_;

  std::vector<State*> bodies_;
  bool is_built_ = false;  ///< with rows of a system
  std::vector<Vec3> start_, end_;  ///< of all vertices, where the step starts, and where the last one ended
  mutable std::vector<Vec3> x_;    ///< where conditions were last looked at
  mutable KeptGaps gaps_;
  KeptForces kept_forces_;
  MotionBounds ways_;
  Vec3 moved_at_start_ = Vec3::Zero();
  Vec3 led_ = Vec3::Zero(), led_next_ = Vec3::Zero();  ///< of the offset, what obstacles have come; at the end of the step
  std::string last_warning_;   ///< of the start
};

void ConstraintContact::declare(DataTable& table) {
  table.addLink("mstate", mstate_).help("state of the body; of this node or the nearest above when not given");
  listed_.declare(table, "states of other bodies, obstacles if nothing moves them; without any, mstate meets obstacles, and itself with "
                         "selfContact");
  topology_.declare(table, "mesh whose surface mstate has");
  table.add("contactDistance", law_.range).help("gap that is kept; 0: a hundredth of the mean edge").unit("m").min(0);
  table.add("thickness", law_.thickness).help("distance of two surfaces at which their gap is zero").unit("m").min(0);
  table.add("friction", friction_).help("Coulomb's coefficient mu").unit("-").min(0);
  table.add("toleratedError", tolerated_error_)
      .help("gaps and slides may be off by this; up to ten times it the run goes on with a warning, beyond that it ends; 0: "
            "contactDistance/1000")
      .unit("m")
      .min(0);
  table.add("selfContact", self_).help("a body meets itself; several bodies of one state meet by this too");
  obstacles_.declare(table);
  table.add("resolveStart", resolve_start_).help("bodies that start in one another, or nearer than contactDistance, are pushed apart");
  table.add("movedStart", outputs_.moved_start).help("the longest way of a node by resolveStart").unit("m").output();
  table.add("contacts", contacts_).help("pairs that push after the last step").unit("-").output();
  table.add("forces", forces_).help("forces of constraint of the last step").unit("N").output();
  outputs_.declareForces(table);
  table.add("moved", moved_at_start_).help("how far obstacles have come from where they are written").unit("m").output();
}

void ConstraintContact::init() {
  State* first = mstate_.get() ? mstate_.get() : find<State>(true);
  if (!first)
    throw ComponentError("no mechanical state has a surface for this contact",
                         "a " + usualComponent(Part::state) + " in the same node or above, or mstate=\"@path\"");
  bodies_ = listed_.init(*first);
  obstacles_.init(self_ || listed_.areSeveral(), "other, planes, spheres, capsules, cylinders, boxes, meshes or selfContact");
  build();
  is_built_ = false;
  checkStart();
}

void ConstraintContact::build() {
  law_.surfaces.clear(), gaps_.clear();
  listed_.addTo(law_.surfaces, topology_, *this);
  obstacles_.addTo(law_);
  law_.surfaces.finish();
  constexpr double small = 0.01;
  if (law_.range == 0) law_.range = partOfMeanEdge(law_.surfaces, small);
  law_.candidates.self_contact = self_;
  law_.compile();
  const std::vector<char> rigid = areRigid(law_.surfaces, bodies_);
  gaps_.compile(law_, toleratedError(), rigid), kept_forces_.compile(law_.surfaces, rigid);
  outputs_.compile(law_, bodies_);
}

/// With the rows of the system; refuses a start in which surfaces are in one another.
void ConstraintContact::buildForRun(ConstRows x) {
  build();
  is_built_ = true;
  if (start_.size() == law_.surfaces.rows.size()) return;  // goes on
  law_.moved = moved_at_start_;
  law_.surfaces.gather(x, law_.moved, x_);
  refuseOverlaps();
  warnOfNear();
}

void ConstraintContact::refuseOverlaps() const {
  refuseOverlap(path(), law_, x_, [this](int vertex) { return nameOf(vertex); });
  refuseInside(path(), law_.surfaces, x_, [this](int vertex) { return nameOf(vertex); });
}

/// Nearer than the gap that is kept is no error: forces of constraint part them, as they do in the end of any step.
void ConstraintContact::warnOfNear() {
  const std::string near = describeNear(law_, x_, [this](int vertex) { return nameOf(vertex); });
  if (!near.empty() && near != last_warning_) warn(near, "gaps that are not smaller than contactDistance");
  last_warning_ = near;
}

/// As it is written; where mapped nodes are is known when a system has been compiled (stepBegins()).
void ConstraintContact::checkStart() {
  std::vector<Mapping*> mappings;
  node().root().collect(mappings);
  for (Mapping* mapping : mappings) mapping->ensureReady();  // then it knows what it places
  if (std::any_of(bodies_.begin(), bodies_.end(), [](const State* body) { return body->isBound(); })) return;
  startObstacles();
  for (const State* body : bodies_)
    if (std::any_of(mappings.begin(), mappings.end(), [&](Mapping* m) { return &m->output() == body; })) return;
  const Surfaces& s = law_.surfaces;
  x_.resize(s.rows.size());
  for (std::size_t v = 0; v < x_.size(); ++v) {
    const bool moves = s.moves(int(v));
    const State* body = moves ? bodies_[std::size_t(s.bodyOf(int(v)))] : nullptr;
    x_[v] = moves ? body->position[std::size_t(s.rows[v] - body->firstRow())] : Vec3(s.rest[v] + law_.moved);
  }
  if (resolve_start_) return;  // placeStart() follows
  refuseOverlaps();
  warnOfNear();
}

void ConstraintContact::placeStart(Rows x, Index independent, const std::function<void(Rows)>& project) {
  if (!resolve_start_) return;
  constexpr double beyond = 1.02;  // of the gap that is kept: pushApart() ends within a hundredth of the gap that it is given
  build();
  law_.moved = moved_at_start_;
  outputs_.moved_start = pushApart(law_, listed_.startBodies(topology_, *this), beyond * law_.range, independent, project, x);
  law_.surfaces.gather(x, law_.moved, x_);
  refuseOverlaps();
}

/// Somebody else has moved what is near: it may be anywhere.
void ConstraintContact::checkMoves() const {
  bool is_elsewhere = ways_.wasExceeded();
  constexpr double rounding = 1e-6;
  for (std::size_t i = 0; i < gaps_.all().size() && end_.size() == x_.size(); ++i)
    for (const int v : gaps_.all()[i].v)
      if (v >= 0 && law_.surfaces.moves(v) && (x_[std::size_t(v)] - end_[std::size_t(v)]).norm() > rounding * law_.range)
        is_elsewhere = true;
  if (is_elsewhere) refuseOverlaps();
}

/// What somebody has put elsewhere since the start was found to be free.
void ConstraintContact::checkFirstStep(ConstRows x) {
  const std::vector<Vec3> found_free = x_;
  law_.moved = moved_at_start_;
  law_.surfaces.gather(x, law_.moved, x_);
  if (found_free.size() == x_.size() && law_.surfaces.areBodiesAt(x_, found_free)) return;
  refuseOverlaps();
  warnOfNear();
}

void ConstraintContact::constrainedStepBegins(ConstRows x, double t_end) {
  try {
    stepBegins(x, t_end, t_end);
    if (start_.size() != x_.size()) checkFirstStep(x);
  } catch (const ComponentError& error) {  // out of a step: nobody adds the place in the file
    throw ComponentError(where().text() + ": " + error.what(), error.expected, error.suggestion);
  }
  led_next_ = obstacles_.ledFrom(led_, MotionBounds::of_edge * MotionBounds::lengthOf(law_));
  const Vec3 goal = obstacles_.pathAt(t_end) + led_next_, way = goal - moved_at_start_;
  law_.moved = moved_at_start_;
  law_.surfaces.gather(x, law_.moved, x_);
  const double dt = node().root().dt();
  ways_.measure(law_.surfaces, start_, x_);
  checkMoves();
  ways_.find(law_, bodies_, dt, way);
  const bool has_pairs = gaps_.begin(law_, x_, ways_.longest() + way.norm(), ways_.ofBodies());
  if (has_pairs) ways_.expect(law_, bodies_, dt, way, start_, x_), gaps_.addPairs(law_, ways_.expected());
  copyPlaces(x_, start_);
  law_.moved = goal;
}

void ConstraintContact::startObstacles() {
  moved_at_start_ = law_.moved = obstacles_.startAt(node().root().root_time);
  led_ = led_next_ = obstacles_.startOffset();
}

void ConstraintContact::addConditions(ConstRows x, ConstRows, LagrangianRows& rows) const {
  law_.surfaces.gather(x, law_.moved, x_);
  gaps_.look(law_, x_);
  addRows(gaps_, law_, x_, friction_, reportedError(), rows);
}

void ConstraintContact::takeForces(std::span<const double> forces) {
  moved_at_start_ = law_.moved, led_ = led_next_;
  forces_.assign(forces.begin(), forces.end());
  gaps_.all().empty() ? end_.clear() : copyPlaces(x_, end_);
  const std::size_t each = rowsOfEach();
  kept_forces_.take(gaps_, law_.surfaces, forces, each);
  contacts_ = outputs_.note(law_, gaps_, forces, each, friction_, toleratedError(), x_, bodies_);
}

void ConstraintContact::reset() {
  startObstacles();
  start_.clear(), end_.clear(), gaps_.clear(), kept_forces_.clear();
  forces_.clear(), outputs_.clear();
  ways_.reset(), contacts_ = 0;
}

void ConstraintContact::serialize(Archive& archive) {
  serializePlace(archive, "moved", moved_at_start_);
  serializePlace(archive, "led", led_);
  archive.list("start", start_);
  ways_.serialize(archive);
  archive.value("contacts", contacts_);
  archive.list("forces", forces_);
  outputs_.serialize(archive), kept_forces_.serialize(archive);
  if (archive.isReading()) end_.clear();
}

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(constraint_contact) {
  factory.add<stroma::ConstraintContact>("ConstraintContact",
                                         "surfaces that keep a distance, with friction, by forces of constraint");
}
