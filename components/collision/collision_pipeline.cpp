// SPDX-License-Identifier: LGPL-2.1-or-later
// CollisionPipeline watches the collision models of a scene. There are no contact forces: as long as no two models that may
// meet come nearer than their contact distance, a scene with contact and one without are the same. The first step that
// starts with two of them nearer is refused, with the models and their distance.
//
// The distance is the contactDistance of the method, plus that of both models, plus the radii of spheres. The method says
// what meets what:
//   MinProximityIntersection, LocalMinDistance: points, lines and triangles as pairs of point and triangle or line and
//     line (unless useLineLine is off), point and point, line and point where their switches are on; spheres with all;
//   NewProximityIntersection: the same, and triangles with triangles;
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

#include "components/collision/collision_model.h"
#include "framework/collision/distances.h"
#include "framework/scene/factory.h"
#include "framework/scene/node.h"
#include "framework/simulation/observer.h"
#include "framework/simulation/step_guard.h"

namespace stroma::collision {
namespace {

class Method : public Component {
 public:
  enum class Rule { proximity, proximity_and_triangles, discrete };
  std::string roleText() const override { return "intersection method"; }
  void declare(DataTable& table) override {
    table.add("contactDistance", contact_distance_).help("nearer than this is a contact").unit("m").min(0);
    table.add("alarmDistance", alarm_distance_).help("SOFA's; from where on it looks at pairs").unit("m").min(0);
    table.add("usePointPoint", point_point_).help("points meet points");
    table.add("useLinePoint", line_point_).help("lines meet points");
    table.add("useLineLine", line_line_).help("lines meet lines");
    table.add("useSphereTriangle", sphere_triangle_).help("spheres meet triangles");
    table.add("useSurfaceNormals", normals_).help("SOFA's; without effect on the watch");
    for (const char* name : {"angleCone", "coneFactor", "useLMDFilters", "maxIterations", "tolerance",
                             "continuousCollisionType"})
      table.addVisualOnly(name);
  }
  /// Whether parts of these kinds meet.
  bool meet(CollisionModel::Kind a, CollisionModel::Kind b) const {
    using Kind = CollisionModel::Kind;
    if (a > b) std::swap(a, b);
    if (rule == Rule::discrete)
      return (a == Kind::sphere && b == Kind::sphere) || (a == Kind::line && b == Kind::triangle);
    if (b == Kind::sphere) return a != Kind::triangle || sphere_triangle_;
    if (a == Kind::triangle) return rule == Rule::proximity_and_triangles;
    if (b == Kind::triangle) return a == Kind::point;
    if (a == Kind::line) return line_line_;
    return b == Kind::line ? line_point_ : point_point_;
  }
  double contactDistance() const { return rule == Rule::discrete ? 0 : contact_distance_; }

  Rule rule = Rule::proximity;  ///< set by the registration of a name

 private:
  double contact_distance_ = 0.5, alarm_distance_ = 1;
  bool point_point_ = true, line_point_ = true, line_line_ = true, sphere_triangle_ = true, normals_ = false;
};

struct Pair {
  const CollisionModel *a, *b;
};

class CollisionPipeline final : public Observer, public StepGuard {
 public:
  void declare(DataTable& table) override {
    table.add("depth", depth_).help("SOFA's; of its trees of boxes").min(0);
    table.addVisualOnly("draw");
  }
  void init() override {
    std::vector<Method*> methods;
    node().root().collect(methods);
    if (methods.size() > 1)
      throw ComponentError(fmt::format("the scene has {} intersection methods", methods.size()), "one");
    method_ = methods.empty() ? nullptr : methods.front();
    std::vector<CollisionModel*> models;
    node().root().collect(models);
    for (CollisionModel* model : models) model->ensureReady();
    static Method without;
    if (!method_) without.rule = Method::Rule::discrete, method_ = &without;
    for (std::size_t i = 0; i < models.size(); ++i)
      for (std::size_t j = 0; j < i; ++j)
        if (CollisionModel::mayMeet(*models[j], *models[i]) && method_->meet(models[j]->kind(), models[i]->kind()))
          pairs_.push_back({models[j], models[i]});
  }
  void afterStep(const Simulation&, const StepContext&) override {}
  std::string describe() const override { return fmt::format("watches {} pairs of surfaces for contact", pairs_.size()); }

  std::string refusal(const StepContext&) override {
    for (const Pair& pair : pairs_)
      if (std::string why = touch(pair); !why.empty()) return why;
    return {};
  }

 private:
  static Box boxOf(const CollisionModel& model, const Part& part) {
    std::array<Vec3, 3> places;
    Box box;
    for (const Vec3& corner : model.corners(part, places)) box.add(corner);
    return box.grownBy(part.radius);
  }
  std::string touch(const Pair& pair) const {
    const double limit = method_->contactDistance() + pair.a->contactDistance() + pair.b->contactDistance();
    std::vector<Box> boxes;
    for (const Part& part : pair.b->parts()) boxes.push_back(boxOf(*pair.b, part));
    BoxTree tree;
    tree.build(std::move(boxes));
    double nearest = std::numeric_limits<double>::infinity();
    for (const Part& part : pair.a->parts()) {
      std::array<Vec3, 3> places, others;
      const std::span<const Vec3> mine = pair.a->corners(part, places);
      tree.forEachMeeting(boxOf(*pair.a, part).grownBy(limit), [&](Index i) {
        const Part& other = pair.b->parts()[std::size_t(i)];
        const double distance = distanceOf(mine, pair.b->corners(other, others)) - part.radius - other.radius;
        nearest = std::min(nearest, distance);
      });
    }
    // what only crosses has no distance: the method that has none asks for less than zero, or for a crossing
    const bool touches = limit > 0 ? nearest < limit : nearest <= 0;
    if (!touches) return {};
    return fmt::format("{} and {} are {:.4g} m apart, nearer than their contact distance of {:.4g} m: there are no contact "
                       "forces, so the run ends here",
                       pair.a->path(), pair.b->path(), nearest, limit);
  }

  int depth_ = 6;
  Method* method_ = nullptr;
  std::vector<Pair> pairs_;
};

}  // namespace
}  // namespace stroma::collision

STROMA_COMPONENT(collision_pipeline) {
  using namespace stroma::collision;
  factory.add<CollisionPipeline>("CollisionPipeline", "ends a run where surfaces would touch");
  const auto add = [&factory](const char* type, Method::Rule rule) {
    factory.add<Method>(type, "what of two surfaces meets, and from which distance on", [rule](Method& m) { m.rule = rule; });
  };
  add("MinProximityIntersection", Method::Rule::proximity);
  add("LocalMinDistance", Method::Rule::proximity);
  add("NewProximityIntersection", Method::Rule::proximity_and_triangles);
  add("DiscreteIntersection", Method::Rule::discrete);
}
