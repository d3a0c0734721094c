// SPDX-License-Identifier: LGPL-2.1-or-later
// CollisionResponse: forces between the collision models of a scene: penalties, or contact with friction as a condition.
//
// Where a step starts, pairs of parts of two surfaces that are nearer than the alarm distance become contacts, with the
// points p and q of both that are closest, and the normal n from p to q. Both last for the step. With
//
//   d = contactDistance of the method + that of both models + radii,   k = k1 k2 / d,   k1, k2 the contactStiffness of the models
//   (k = k1 k2 where d is zero)
//
// a contact of the response PenalityContactForceField pushes while (q - p).n < d, without friction and damping:
//
//   force on q = k (d - (q - p).n) n,   on p its opposite,   K = -k n n^T
//
// FrictionContactConstraint is the contact of Signorini and Coulomb, with forces of constraint at the end of the step
// (components/integrators/multipliers.h). s is the way of q - p across n in the step, mu of responseParams="mu=0.6":
//
//   (q - p).n >= d,   l_n >= 0,   one of both zero;   s = 0, or |l_t| = mu l_n against s
//
// A sphere around the centre of a frame, whose radius is r, is a ball: what rubs is its surface, so that friction turns it. With w
// the rotation vector of its turn in the step, s has -r w x n besides, and its torque on both balls is -r n x (force on q). All
// others, spheres on points that follow a frame among them, rub where their nodes are, without a torque.
//
// A step that ends with conditions that do not hold is refused, unless they are off by toleratedError at most.
//
// Nothing hinders thin bodies that are fast from passing through each other: n then turns round. With response="BarrierContact" they
// cannot: a BarrierContact of whole surfaces is then made beside this component and described by the models, and this one does nothing
// (contact_of_surfaces.h). ConstraintContact and PenaltyContact are made in the same way.
//
// Bodies of several integrators that may meet move in one system, and penalties between them are implicit; SOFA evaluates them once
// where the step starts, but for those with models that are not `simulated`. With explicitBetween they are no part of the matrix here
// either.
//
// Pairs of models may have responses of their own: `rules` names them, and a model's contactResponse takes precedence. Where both models
// have one and the two differ, `response` is used, or with `rules` that of the model that comes first in the scene. So does SOFA.
//
// It needs a CollisionPipeline, which is a watch where a response is asked for that is none of the two.
//
// Source: the formulas are SOFA's (PenalityContactForceField, BarycentricPenalityContact, FrictionContact), as are the names.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <CollisionPipeline/>
//   <CollisionResponse name="response"/>
//   <MinProximityIntersection alarmDistance="0.3" contactDistance="0.1"/>
//   <Node name="ball">
//     <EulerImplicitSolver/>
//     <CGLinearSolver iterations="50" tolerance="1e-10"/>
//     <MechanicalObject position="0 0.19 0  0.5 0.3 0.2"/>
//     <UniformMass totalMass="1"/>
//     <SphereCollisionModel radius="0.1" contactStiffness="50"/>
//   </Node>
//   <Node name="floor">
//     <MeshTopology position="-9 0 -7  9 0 -9  9 0 9  -9 0 9" triangles="0 1 2  0 2 3"/>
//     <MechanicalObject/>
//     <TriangleCollisionModel simulated="false" moving="false"/>
//   </Node>
// </Node>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <map>

#include "components/collision/contact_finder.h"
#include "components/collision/contact_of_surfaces.h"
#include "components/collision/contact_report.h"
#include "components/collision/push.h"
#include "framework/mechanics/force_field.h"
#include "framework/mechanics/lagrangian_constraint.h"
#include "framework/mechanics/step_limiter.h"
#include "framework/scene/archive.h"
#include "framework/scene/factory.h"
#include "framework/scene/node.h"
#include "framework/simulation/integrator.h"
#include "framework/simulation/step_guard.h"

namespace stroma::collision {
namespace {

class CollisionResponse final : public ForceField,
                                public StepListener,
                                public ContactAnswer,
                                public LagrangianConstraint {
 public:
  void declare(DataTable& table) override {
    ForceField::declare(table);
    rules_.declare(table);
    table.add("explicitBetween", explicit_between_)
        .help("penalties between bodies of different integrators are no part of the matrix, as in SOFA");
    table.add("toleratedError", tolerated_error_)
        .help("with friction: a step whose conditions are violated by no more than this is kept, and reported as not converged")
        .unit("m")
        .min(0);
    finder_.declare(table);
    table.add("sweepNames", sweep_names_)
        .help("with sofaLists, for each contact with friction: the place of its node in the scene, its pair of models since these touch, "
              "and its number in the pair")
        .output();
    table.add("contacts", acting_).help("contacts that push").output();
    report_.declare(table);
  }
  void init() override;
  std::vector<State*> states() const override { return states_; }
  std::string missingPartner() const override { return rules_.isOfSurfaces() ? rules_.response() : std::string(); }
  bool leavesAllToAnother() const override { return rules_.isOfSurfaces(); }
  std::string idle() const override {
    return rules_.act() || rules_.isOfSurfaces() ? std::string() : fmt::format("there is no response {} here", rules_.response());
  }
  ForceTraits traits() const override {
    ForceTraits traits;
    traits.symmetric = traits.lagged = true;
    traits.conservative = traits.exact_tangent = !explicit_between_;
    traits.has_stiffness = rules_.mayPush();
    return traits;
  }
  std::vector<State*> constrainedStates() const override { return rules_.anyRubs() ? states_ : std::vector<State*>(); }
  void addConditions(ConstRows x, ConstRows x_start, LagrangianRows& rows) const override;
  void takeForces(std::span<const double> forces) override;
  Tolerance tolerance() const override { return {.kept = tolerated_error_}; }
  void compile() override {
    if (method_) finder_.compile(node().root(), pairs_, *method_, rules_);
    report_.compile(pairs_);
    pushes_.clear(), pattern_.clear();
    found_ = false;
    ++revision_;
  }
  void stepBegins(ConstRows, double t, double t_end) override {
    find();
    if (t_end <= t) finder_.reset();  // the check of where a run starts is not the first search of a step
  }
  double energy(ConstRows x) const override;
  bool acts() const override { return pushing_ > 0; }
  void addForce(ConstRows x, ConstRows v, Rows f) override;
  void addStiffnessProduct(ConstRows dx, double factor, Rows df) const override;
  void addPattern(BlockPattern& pattern) const override;
  long patternRevision() const override { return revision_; }
  void addStiffness(double factor, BlockMatrix& matrix) const override;
  void addStiffnessDiagonal(double factor, std::vector<double>& blocks) const override;
  void reset() override {
    found_ = false, acting_ = pushing_ = rubbing_ = 0;
    report_.clear(), finder_.reset();
  }
  void serialize(Archive& archive) override {
    archive.value("contacts", acting_);
    report_.serialize(archive), finder_.serialize(archive);
  }

 protected:
  bool takesAllRows() const override { return true; }

 private:
  /// Something has to look for contacts.
  bool hasPipeline() const {
    std::vector<ContactWatch*> pipelines;
    node().root().collect(pipelines);
    return !pipelines.empty();
  }
  void find();
  void describePartner();
  bool joins(const CollisionModel& a, const CollisionModel& b) const;
  std::array<Vec3, 2> tangents(const Vec3& n) const;

  ContactRules rules_;
  int acting_ = 0, pushing_ = 0, rubbing_ = 0;  ///< contacts with a force: all, and of each kind
  bool explicit_between_ = false;
  double tolerated_error_ = 0;
  std::map<const CollisionModel*, const Integrator*> movers_;

  const Method* method_ = nullptr;
  std::vector<ModelPair> pairs_;
  std::vector<State*> states_;
  ContactFinder finder_;
  std::vector<int> sweep_names_;  ///< three for each contact that rubs: what ConstraintSweeps sorts and recognises them by
  std::vector<Contact> contacts_;
  std::vector<Push> pushes_;  ///< of contacts_
  ContactReport report_;      ///< the same
  std::vector<std::array<Index, 6>> pattern_;  ///< their rows
  bool found_ = false, has_new_ = false;  ///< new: rows are others than those of the last force
  long revision_ = 0;
};

/// The integrator in the model's node or above; null: nothing moves it.
static const Integrator* moverOf(const CollisionModel& model) {
  for (const Node* node = &model.node(); node; node = node->parent())
    for (const auto& component : node->components())
      if (const auto* integrator = dynamic_cast<const Integrator*>(component.get())) return integrator;
  return nullptr;
}

void CollisionResponse::init() {
  std::vector<State*> all;
  node().root().collect(all);
  method_ = Method::of(node().root());
  pairs_ = rules_.act() && method_ && hasPipeline() ? modelPairs(node().root(), method_) : std::vector<ModelPair>();
  rules_.read(pairs_);
  std::vector<CollisionResponse*> responses;
  node().root().collect(responses);
  if (responses.size() > 1) throw ComponentError(fmt::format("the scene has {} of these", responses.size()), "one");
  states_.clear();
  for (const ModelPair& pair : pairs_)
    for (const CollisionModel* model : {pair.a, pair.b})
      if (model->isMoved() && std::find(states_.begin(), states_.end(), &model->state()) == states_.end())
        states_.push_back(&model->state());
  if (states_.empty()) pairs_.clear();
  if (rules_.isOfSurfaces()) describePartner();
  if (!pairs_.empty() && !data().find("response")->isSet() && !data().find("rules")->isSet())
    inform("contacts have penalties, which do not exclude penetration by fast or thin bodies. response=\"BarrierContact\" excludes it; "
           "response=\"PenalityContactForceField\" says that penalties are meant");
  movers_.clear();
  for (const ModelPair& pair : pairs_) movers_[pair.a] = moverOf(*pair.a), movers_[pair.b] = moverOf(*pair.b);
  if (!mstate_.target() && !all.empty()) mstate_.set(states_.empty() ? all.front() : states_.front());
  ForceField::init();
}

void CollisionResponse::describePartner() {
  for (const auto& component : node().components()) {
    if (component->type() != rules_.response() || !component->isMadeForAnother()) continue;
    try {
      return describeContact(*component, *this, method_, rules_.parameters());
    } catch (...) {
      component->markFailed();  // one message is enough
      throw;
    }
  }
}

bool CollisionResponse::joins(const CollisionModel& a, const CollisionModel& b) const {
  return !explicit_between_ || !a.isSimulated() || !b.isSimulated() || movers_.at(&a) == movers_.at(&b);
}

void CollisionResponse::find() {
  finder_.find(contacts_);
  pushes_.resize(contacts_.size());
  sweep_names_.clear();
  has_new_ = has_new_ || pattern_.size() != pushes_.size();
  pattern_.resize(pushes_.size());
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    const Contact& contact = contacts_[i];
    Push& push = pushes_[i] = {};
    push.n = contact.normal, push.d = contact.contact;
    push.k = contact.model_a->contactStiffness() * contact.model_b->contactStiffness() / (push.d > 0 ? push.d : 1);
    addSide(*contact.model_a, contact.a, -1, push);
    addSide(*contact.model_b, contact.b, 1, push);
    const Answer& answer = rules_.of(*contact.model_a, *contact.model_b);
    push.rubs = answer.rubs, push.mu = answer.mu;
    if (push.rubs && finder_.lists()) finder_.addName(i, sweep_names_);
    push.joined = !push.rubs && joins(*contact.model_a, *contact.model_b);
    has_new_ = has_new_ || pattern_[i] != push.rows;
    pattern_[i] = push.rows;
  }
  report_.note(contacts_);
  found_ = true;
}

std::array<Vec3, 2> CollisionResponse::tangents(const Vec3& n) const {
  Vec3 across = n.unitOrthogonal();
  const Vec3 turned = n.cross(Vec3(n[2], n[0], n[1]));  // SOFA has no tangents along the diagonal of space
  if (finder_.lists() && turned.norm() > 1e-9) across = turned.normalized().cross(n);
  return {across, n.cross(across)};
}

void CollisionResponse::addConditions(ConstRows x, ConstRows x_start, LagrangianRows& rows) const {
  if (report_.isRestored()) return;  // asked for between steps: contacts are those of another one
  const auto add = [&](const Push& push, const Vec3& along) {
    for (std::size_t i = 0; i < 6; ++i)
      if (push.rows[i] >= 0 && push.c[i] != 0) rows.add(push.rows[i], push.c[i] * along);
  };
  for (const Push& push : pushes_) {
    if (!push.rubs) continue;
    rows.begin(LagrangianRows::Kind::push, -depth(push, x));
    add(push, push.n);
    if (push.mu == 0) continue;
    const Vec3 way = (finder_.lists() ? shareInTouch(push, x, x_start) : 1) * slid(push, x, x_start);
    for (const Vec3& tangent : tangents(push.n)) {
      rows.begin(LagrangianRows::Kind::rub, tangent.dot(way), push.mu);
      add(push, tangent);
      for (std::size_t side = 0; side < 2; ++side)
        if (push.turns[side] >= 0) rows.add(push.turns[side], -push.radii[side] * push.n.cross(tangent));
    }
  }
}

void CollisionResponse::takeForces(std::span<const double> forces) {
  rubbing_ = 0;
  report_.setMultipliers(forces);
  const double* l = forces.data();
  for (std::size_t i = 0; i < pushes_.size(); ++i) {
    const Push& push = pushes_[i];
    if (!push.rubs) continue;
    rubbing_ += l[0] > 0;
    Vec3 force = l[0] * push.n;
    if (push.mu != 0)
      for (int k = 0; k < 2; ++k) force += l[1 + k] * tangents(push.n)[std::size_t(k)];
    report_.setForce(i, force);
    l += push.mu != 0 ? 3 : 1;
  }
  acting_ = pushing_ + rubbing_;
  report_.sumForces();
}

double CollisionResponse::energy(ConstRows x) const {
  double sum = 0;
  for (const Push& push : pushes_)
    if (const double pen = depth(push, x); !push.rubs && pen > 0) sum += 0.5 * push.k * pen * pen;
  return sum;
}

void CollisionResponse::addForce(ConstRows x, ConstRows, Rows f) {
  if (!rules_.anyPushes()) return;
  if (!found_) find();
  revision_ += has_new_, has_new_ = false;
  pushing_ = 0;
  for (std::size_t at = 0; at < pushes_.size(); ++at) {
    Push& push = pushes_[at];
    if (push.rubs) continue;
    const double pen = depth(push, x);
    push.acts = pen > 0;
    report_.setForce(at, push.acts ? Vec3(push.k * pen * push.n) : Vec3::Zero());
    if (!push.acts) continue;
    ++pushing_;
    for (std::size_t i = 0; i < 6; ++i)
      if (push.rows[i] >= 0) f[push.rows[i]] += push.c[i] * push.k * pen * push.n;
  }
  acting_ = pushing_ + rubbing_;
  report_.sumForces();
}

void CollisionResponse::addStiffnessProduct(ConstRows dx, double factor, Rows df) const {
  for (const Push& push : pushes_) {
    if (!push.acts || !push.joined) continue;
    double along = 0;
    for (std::size_t i = 0; i < 6; ++i)
      if (push.rows[i] >= 0) along += push.c[i] * push.n.dot(dx[push.rows[i]]);
    for (std::size_t i = 0; i < 6; ++i)
      if (push.rows[i] >= 0) df[push.rows[i]] -= factor * push.k * along * push.c[i] * push.n;
  }
}

void CollisionResponse::addPattern(BlockPattern& pattern) const {
  for (const Push& push : pushes_) {
    if (!push.joined) continue;
    std::array<Index, 6> rows;
    int count = 0;
    for (const Index row : push.rows)
      if (row >= 0) rows[std::size_t(count++)] = row;
    pattern.addClique(rows.data(), count);
  }
}

void CollisionResponse::addStiffness(double factor, BlockMatrix& matrix) const {
  for (const Push& push : pushes_)
    for (std::size_t i = 0; push.acts && push.joined && i < 6; ++i)
      for (std::size_t j = 0; j < 6; ++j)
        if (push.rows[i] >= 0 && push.rows[j] >= 0 && push.c[i] * push.c[j] != 0)
          matrix.add(push.rows[i], push.rows[j],
                     -factor * push.k * push.c[i] * push.c[j] * push.n * push.n.transpose());
}

void CollisionResponse::addStiffnessDiagonal(double factor, std::vector<double>& blocks) const {
  for (const Push& push : pushes_)
    for (std::size_t i = 0; push.acts && push.joined && i < 6; ++i) {
      if (push.rows[i] < 0) continue;
      double* block = blocks.data() + std::size_t(push.rows[i]) * 9;
      for (int k = 0; k < 9; ++k) block[k] -= factor * push.k * push.c[i] * push.c[i] * push.n[k / 3] * push.n[k % 3];
    }
}

}  // namespace
}  // namespace stroma::collision

STROMA_COMPONENT(collision_response) {
  factory.add<stroma::collision::CollisionResponse>("CollisionResponse", "penalty forces between surfaces that meet");
}
