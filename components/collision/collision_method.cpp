// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/collision/collision_method.h"

#include <fmt/format.h>

#include <utility>

#include "framework/scene/node.h"

namespace stroma::collision {

void Method::declare(DataTable& table) {
  table.add("contactDistance", contact_distance_).help("nearer than this is a contact").unit("m").min(0);
  table.add("alarmDistance", alarm_distance_).help("pairs that are nearer where a step starts are looked at").unit("m").min(0);
  table.add("usePointPoint", point_point_).help("points meet points");
  table.add("useLinePoint", line_point_).help("lines meet points");
  const bool has_edges = rule == Rule::proximity_and_triangles;
  line_line_ = !has_edges;
  table.add("useLineLine", line_line_)
      .help(has_edges ? "edges of triangles meet lines and each other; lines meet lines always" : "lines meet lines");
  table.add("useSphereTriangle", sphere_triangle_).help("spheres meet triangles");
  table.add("useSurfaceNormals", normals_).help("SOFA's; without effect");
  if (rule == Rule::local_minimum) {
    table.add("filterIntersection", filters_).help("contacts lie within the cones of normals of both surfaces");
    table.add("angleCone", angle_cone_).help("added to the sine of the angle by which a cone is wider than its normals").unit("-");
    table.add("coneFactor", cone_factor_).help("how much of the angle between neighbouring faces a cone takes").unit("-");
    table.add("useLMDFilters", filtered_elsewhere_).help("true: as filterIntersection false; SOFA's filters beside the models");
  } else {
    for (const char* name : {"angleCone", "coneFactor", "useLMDFilters", "filterIntersection"}) table.addVisualOnly(name);
  }
  for (const char* name : {"maxIterations", "tolerance"}) table.addVisualOnly(name);
  if (rule != Rule::continuous) return table.addVisualOnly("continuousCollisionType");
  table.addChoice("continuousCollisionType", path_, {"None", "Inertia", "FreeMotion"})
      .help("Inertia: contacts are also found on the straight paths of a step, at the velocities of its start; FreeMotion: the same, and "
            "as far beside the paths as gravity moves in a step; None: only where a step starts");
}

double Method::pathDeviation() const {
  const double dt = node().root().dt();
  return path_ == Path::free_motion ? dt * dt * node().gravity().norm() : 0;
}

bool Method::meet(CollisionModel::Kind a, CollisionModel::Kind b) const {
  using Kind = CollisionModel::Kind;
  if (a > b) std::swap(a, b);
  if (rule == Rule::discrete)
    return (a == Kind::sphere && b == Kind::sphere) || (a == Kind::line && b == Kind::triangle);
  if (rule == Rule::continuous) return (a == Kind::line && b == Kind::line) || (a == Kind::point && b == Kind::triangle);
  if (b == Kind::sphere) return a != Kind::triangle || sphere_triangle_;
  if (a == Kind::triangle) return rule == Rule::proximity_and_triangles;
  if (b == Kind::triangle) return a == Kind::point || rule == Rule::proximity_and_triangles;
  if (a == Kind::line) return line_line_ || rule == Rule::proximity_and_triangles;
  return b == Kind::line ? line_point_ : point_point_;
}

const Method* Method::of(const Node& root) {
  std::vector<Method*> methods;
  root.collect(methods);
  if (methods.size() > 1)
    throw ComponentError(fmt::format("the scene has {} intersection methods", methods.size()), "one");
  return methods.empty() ? nullptr : methods.front();
}

std::vector<ModelPair> modelPairs(const Node& root, const Method* method) {
  Method without;
  without.rule = Method::Rule::discrete;
  const Method& rule = method ? *method : without;
  std::vector<CollisionModel*> models;
  root.collect(models);
  for (CollisionModel* model : models) model->ensureReady();
  std::vector<ModelPair> pairs;
  for (std::size_t i = 0; i < models.size(); ++i)
    for (std::size_t j = 0; j <= i; ++j)
      if (CollisionModel::mayMeet(*models[j], *models[i]) && rule.meet(models[j]->kind(), models[i]->kind()))
        pairs.push_back({models[j], models[i]});
  return pairs;
}

}  // namespace stroma::collision
