// SPDX-License-Identifier: LGPL-2.1-or-later
// CollisionPipeline finds contacts of the collision models of a scene, for a CollisionResponse. Without one that acts it is
// a watch: as long as no two models that may meet come nearer than their contact distance, a scene with contact and one
// without are the same. The first step that starts with two of them nearer is refused, with the models and their distance.
//
// The distance is the contactDistance of the method, plus that of both models, plus the radii of spheres. The method says
// what meets what:
//   MinProximityIntersection: points, lines and triangles as pairs of point and triangle or line and line (unless
//     useLineLine is off), point and point, line and point where their switches are on; spheres with all;
//   LocalMinDistance: the same, within the cones of normals of both surfaces (normal_cones.h), for which the sides of
//     triangles count: normals point outward;
//   NewProximityIntersection: the first, and triangles with triangles and lines, by corners; their edges with useLineLine;
//   CCDTightInclusionIntersection: points and triangles, lines and lines; with continuousCollisionType also those that come near on the
//     way of a step (path_contacts.h);
//   DiscreteIntersection: spheres that overlap, lines that cross triangles; no distance of its own.
// Without a method the watch is that of DiscreteIntersection.
//
// Source: what meets what, names and attributes are SOFA's.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <CollisionPipeline/>
//   <NewProximityIntersection alarmDistance="0.2" contactDistance="0.1"/>
//   <EulerExplicitSolver/>
//   <Node name="ball">
//     <MechanicalObject position="0 1 0"/>
//     <UniformMass totalMass="1"/>
//     <SphereCollisionModel radius="0.1"/>
//   </Node>
//   <Node name="floor">
//     <MeshTopology position="-9 0 -9  9 0 -9  9 0 9  -9 0 9" triangles="0 1 2  0 2 3"/>
//     <MechanicalObject/>
//     <UniformMass totalMass="1"/>
//     <FixedProjectiveConstraint fixAll="true"/>
//     <TriangleCollisionModel simulated="false" moving="false"/>
//   </Node>
// </Node>
#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "components/collision/collision_method.h"
#include "components/collision/distances.h"
#include "framework/scene/factory.h"
#include "framework/scene/node.h"
#include "framework/simulation/integrator.h"
#include "framework/simulation/observer.h"
#include "framework/simulation/step_guard.h"

namespace stroma::collision {
namespace {

class CollisionPipeline final : public Observer, public StepGuard, public ContactWatch {
 public:
  void declare(DataTable& table) override {
    table.add("depth", depth_).help("SOFA's; without effect: of its trees of boxes").min(0);
    table.addVisualOnly("draw");
  }
  void init() override {
    method_ = Method::of(node().root());
    const std::vector<ModelPair> found = modelPairs(node().root(), method_);
    for (const ModelPair& pair : found)
      if (pair.a != pair.b) {
        pairs_.push_back({pair, {}, {}});
        pair.b->boxParts(pairs_.back().boxes);
      }
    std::vector<ContactAnswer*> answers;
    node().root().collect(answers);
    answer_ = answers.empty() ? nullptr : answers.front();
    if (isIdle()) return pairs_.clear();
    found.empty() ? tellOfStrangers() : tellOfStrangersAmong(found);
    if (method_ && method_->hasCones()) tellOfHollows(found);
    for (Watched& each : pairs_) each.tree.build(each.boxes);
    if (!answer_ && !pairs_.empty())
      inform("there is no CollisionResponse: the run ends where two models come nearer than their contact distance. With "
             "response=\"BarrierContact\" bodies touch and never pass through each other");
  }
  void afterStep(const Simulation&, const StepContext&) override {}
  std::string describe() const override {
    if (isIdle()) return "does nothing: the response is a contact of whole surfaces, which finds its contacts itself";
    return answer_ && answer_->idle().empty() ? "finds contacts for the response"
                                              : fmt::format("watches {} pairs of surfaces for contact", pairs_.size());
  }

  std::string refusal(const StepContext&) override {
    const std::string why = answer_ ? answer_->idle() : "there are no contact forces";
    for (Watched& each : pairs_) {
      if (why.empty() && isAnswered(each.models)) continue;
      if (const std::string touching = touch(each); !touching.empty())
        return fmt::format("{}: {}, so the run ends here", touching,
                           why.empty() ? "lines that cross triangles have no response" : why);
    }
    return {};
  }

 private:
  bool isIdle() const { return answer_ && answer_->leavesAllToAnother(); }
  /// Bodies whose models could meet, of kinds that do not.
  void tellOfStrangers() const {
    std::vector<CollisionModel*> models;
    node().root().collect(models);
    for (std::size_t i = 0; i < models.size(); ++i)
      for (std::size_t j = 0; j < i; ++j)
        if (CollisionModel::mayMeet(*models[j], *models[i]))
          return warn(fmt::format("{} and {} do not meet by {}, nor do any others: bodies pass through each other",
                                  models[j]->path(), models[i]->path(),
                                  method_ ? method_->path() : "DiscreteIntersection, which there is without another"),
                      "MinProximityIntersection, and points, lines and triangles on both");
  }
  /// The node of the integrator that moves the model, or the one below the root.
  static const Node* bodyOf(const CollisionModel& model) {
    const Node* at = &model.node();
    for (; at->parent() && at->parent()->parent(); at = at->parent())
      for (const auto& component : at->components())
        if (dynamic_cast<const Integrator*>(component.get())) return at;
    return at;
  }
  /// The same of two bodies where others meet.
  void tellOfStrangersAmong(const std::vector<ModelPair>& found) const {
    std::vector<CollisionModel*> models;
    node().root().collect(models);
    std::vector<const Node*> bodies;
    for (const CollisionModel* model : models) bodies.push_back(bodyOf(*model));
    std::set<std::pair<const Node*, const Node*>> meet;
    for (const ModelPair& pair : found) meet.insert(std::minmax(bodyOf(*pair.a), bodyOf(*pair.b)));
    for (std::size_t i = 0; i < models.size(); ++i)
      for (std::size_t j = 0; j < i; ++j) {
        const Node *a = bodies[j], *b = bodies[i];
        if (a != b && CollisionModel::mayMeet(*models[j], *models[i]) && !meet.contains(std::minmax(a, b)))
          return warn(fmt::format("{} and {} do not meet by {}, nor do others of {} and {}: these bodies pass through each other",
                                  models[j]->path(), models[i]->path(), method_ ? method_->path() : "DiscreteIntersection",
                                  a->path(), b->path()),
                      "MinProximityIntersection, and points, lines and triangles on both");
      }
  }
  /// Bodies that meet by lines and points of their surfaces alone, within cones of normals: what bends inwards has no contacts but those
  /// of triangles (normal_cones.h), and a floor that is pressed does.
  void tellOfHollows(const std::vector<ModelPair>& found) const {
    using Kind = CollisionModel::Kind;
    std::set<std::pair<const Node*, const Node*>> with_triangles;
    for (const auto& [a, b] : found)
      if (a->kind() == Kind::triangle || b->kind() == Kind::triangle) with_triangles.insert(std::minmax(bodyOf(*a), bodyOf(*b)));
    for (const auto& [a, b] : found)
      for (const CollisionModel* model : {a, b})
        if (model->kind() == Kind::line && !with_triangles.contains(std::minmax(bodyOf(*a), bodyOf(*b))) && !model->faces().empty())
          return warn(fmt::format("{} and {} meet by {} without triangles: where {} is hollow or bends inwards it has no contacts, and "
                                  "bodies pass through it",
                                  a->path(), b->path(), method_->path(), model->path()),
                      "a TriangleCollisionModel beside it, or MinProximityIntersection");
  }
  struct Watched {
    ModelPair models;
    std::vector<Box> boxes;  ///< of the second
    BoxTree tree;
  };
  bool isAnswered(const ModelPair& pair) const {
    return method_ && (method_->rule != Method::Rule::discrete ||
                       (pair.a->kind() == CollisionModel::Kind::sphere && pair.b->kind() == CollisionModel::Kind::sphere));
  }
  std::string touch(Watched& watched) const {
    const CollisionModel &a = *watched.models.a, &b = *watched.models.b;
    const double limit = (method_ ? method_->contactDistance() : 0) + a.contactDistance() + b.contactDistance();
    b.boxParts(watched.boxes);
    watched.tree.refit(watched.boxes);
    double nearest = std::numeric_limits<double>::infinity();
    for (const Part& part : a.parts()) {
      std::array<Vec3, 3> places, others;
      const std::span<const Vec3> mine = a.corners(part, places);
      watched.tree.forEachMeeting(a.boxOf(part, limit), [&](Index i) {
        const Part& other = b.parts()[std::size_t(i)];
        const double distance = distanceOf(mine, b.corners(other, others)) - part.radius - other.radius;
        nearest = std::min(nearest, distance);
      });
    }
    // what only crosses has no distance: the method that has none asks for less than zero, or for a crossing
    const bool touches = limit > 0 ? nearest < limit : nearest <= 0;
    if (!touches) return {};
    return fmt::format("{} and {} are {:.4g} m apart, nearer than their contact distance of {:.4g} m", a.path(), b.path(),
                       nearest, limit);
  }

  int depth_ = 6;
  const Method* method_ = nullptr;
  const ContactAnswer* answer_ = nullptr;
  std::vector<Watched> pairs_;
};

}  // namespace
}  // namespace stroma::collision

STROMA_COMPONENT(collision_pipeline) {
  using namespace stroma::collision;
  factory.add<CollisionPipeline>("CollisionPipeline", "finds contacts for a response, or ends a run where surfaces would touch");
  const auto add = [&factory](const char* type, Method::Rule rule) {
    factory.add<Method>(type, "which elements of two surfaces are in contact, and from which distance",
                        [rule](Method& m) { m.rule = rule; });
  };
  add("MinProximityIntersection", Method::Rule::proximity);
  add("LocalMinDistance", Method::Rule::local_minimum);
  add("NewProximityIntersection", Method::Rule::proximity_and_triangles);
  add("CCDTightInclusionIntersection", Method::Rule::continuous);
  add("DiscreteIntersection", Method::Rule::discrete);
}
