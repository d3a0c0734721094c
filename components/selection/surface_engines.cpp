// SPDX-License-Identifier: LGPL-2.1-or-later
// Shapes made of others, before the first step.
//
// Spiral: position, a strip rolled up to a spiral r = curvature t of the angle t. A point (x, y, z) of rest_position goes to
//   where the spiral has the length |x| from its centre, y across it, and keeps z. Points with x < 0 go to the other arm,
//   turned by half a turn. Length and angle: l = curvature/2 (t sqrt(1 + t^2) + asinh t). Where t < pi/2 the way across leans
//   so that it is at most 0.8 along y.
// ExtrudeSurface: extrusionVertices and extrusionTriangles, a closed shell of a part of a surface: the triangles of `triangles`
//   that surfaceTriangles numbers, turned round; the same moved by heightFactor along the normals of their nodes; and a wall of
//   two triangles at each side of the border. A node's normal is the mean direction of those of its triangles. Nodes stand in
//   pairs, the moved one after its own.
//
// Source: names and attributes are SOFA's. There a third of the walls is turned inward.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 0">
//   <EulerExplicitSolver/>
//   <Node name="rolled">
//     <Spiral name="spiral" rest_position="0 0 0  1 0 0  2 0 0  3 0.1 0" curvature="0.2"/>
//     <MechanicalObject position="@spiral.position"/>
//     <UniformMass totalMass="1"/>
//   </Node>
//   <Node name="shell">
//     <MeshTopology name="net" position="0 0 0  1 0 0  1 1 0  0 1 0" triangles="0 1 2  0 2 3"/>
//     <ExtrudeSurface name="thick" surfaceVertices="@net.position" triangles="@net.triangles" surfaceTriangles="0 1"
//                     heightFactor="0.2"/>
//     <TriangleSetTopologyContainer name="hull" position="@thick.extrusionVertices" triangles="@thick.extrusionTriangles"/>
//     <MechanicalObject src="@hull"/>
//     <UniformMass totalMass="1"/>
//   </Node>
// </Node>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <numbers>

#include "components/selection/engine.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class Spiral final : public Engine {
 public:
  void declare(DataTable& table) override {
    table.add("rest_position", flat_).help("points of a strip along x").unit("m").required();
    table.add("position", rolled_).help("where they are when it is rolled up").unit("m").output();
    table.add("curvature", curvature_).help("radius over angle").unit("m").min(0, false);
  }
  void init() override {
    rolled_.clear();
    for (const Vec3& p : flat_) {
      const double t = angleAt(std::abs(p.x())), side = p.x() > 0 ? 1 : -1;
      Vec3 across = Vec3(-std::sin(t) - t * std::cos(t), std::cos(t) - t * std::sin(t), 0).normalized();
      if (t < std::numbers::pi / 2 && across.y() > 0.8) across = Vec3(-0.6, 0.8, 0);
      rolled_.push_back(side * curvature_ * t * Vec3(std::cos(t), std::sin(t), 0) + Vec3(0, 0, p.z()) + p.y() * across);
    }
  }

 private:
  /// Newton's method: the length is convex and grows with the angle.
  double angleAt(double length) const {
    double t = std::sqrt(length);
    for (int i = 0; i < 50; ++i) {
      const double root = std::sqrt(1 + t * t), step = (curvature_ / 2 * (t * root + std::asinh(t)) - length) / (curvature_ * root);
      t -= step;
      if (std::abs(step) <= 1e-15 * (1 + std::abs(t))) break;
    }
    return t;
  }
  std::vector<Vec3> flat_, rolled_;
  double curvature_ = 0.2;
};

class ExtrudeSurface final : public Engine {
 public:
  std::string roleText() const override { return "mesh engine"; }
  void declare(DataTable& table) override {
    table.add("surfaceVertices", nodes_).help("nodes of the surface").unit("m").required();
    table.add("triangles", triangles_).help("its triangles").required();
    table.add("surfaceTriangles", chosen_).help("numbers of the triangles that are extruded").required();
    table.add("heightFactor", height_).help("how far along the normals").unit("m");
    table.add("extrusionVertices", shell_nodes_).help("nodes of the shell").unit("m").output();
    table.add("extrusionTriangles", shell_).help("its triangles").output();
    table.addVisualOnly("isVisible");
  }
  void init() override {
    shell_.clear(), shell_nodes_.clear();
    if (chosen_.empty()) warn("surfaceTriangles names no triangle", "check the selection that is linked here");
    const std::map<Index, Vec3> normals = normalsOfNodes();
    std::map<Index, Index> place;
    std::map<Edge, bool> is_border;
    for (const int number : chosen_) {
      Triangle inner;
      for (std::size_t i = 0; i < 3; ++i) inner[i] = placeOf(triangles_[std::size_t(number)][i], normals, place);
      for (const auto& [a, b] : {std::pair(0, 1), std::pair(1, 2), std::pair(2, 0)}) {
        const Edge side{inner[std::size_t(a)], inner[std::size_t(b)]}, back{side[1], side[0]};
        const bool turned = !is_border.count(side) && is_border.count(back);
        const bool seen = turned || is_border.count(side);
        is_border[turned ? back : side] = !seen;
      }
      shell_.push_back({inner[0], inner[2], inner[1]});
      shell_.push_back({inner[0] + 1, inner[1] + 1, inner[2] + 1});
    }
    for (const auto& [side, borders] : is_border) {
      if (!borders) continue;
      shell_.push_back({side[0], side[1], side[0] + 1});
      shell_.push_back({side[1] + 1, side[0] + 1, side[1]});
    }
  }

 private:
  std::map<Index, Vec3> normalsOfNodes() const {
    std::map<Index, Vec3> normals;
    for (const int number : chosen_) {
      if (number < 0 || std::size_t(number) >= triangles_.size())
        throw ComponentError(fmt::format("surfaceTriangles names {}, and there are {} triangles", number, triangles_.size()));
      const Triangle& triangle = triangles_[std::size_t(number)];
      for (const Index node : triangle)
        if (node < 0 || std::size_t(node) >= nodes_.size())
          throw ComponentError(fmt::format("triangles names node {} of {}", node, nodes_.size()));
      const auto at = [&](std::size_t i) -> const Vec3& { return nodes_[std::size_t(triangle[i])]; };
      const Vec3 normal = (at(1) - at(0)).cross(at(2) - at(0)).normalized();
      for (const Index node : triangle) normals.emplace(node, Vec3::Zero()).first->second += normal;
    }
    for (auto& [node, normal] : normals) normal.normalize();
    return normals;
  }
  /// The number of a node in the shell; where it is new it comes there, and the moved one after it.
  Index placeOf(Index node, const std::map<Index, Vec3>& normals, std::map<Index, Index>& place) {
    const auto [found, is_new] = place.emplace(node, Index(shell_nodes_.size()));
    if (is_new) {
      shell_nodes_.push_back(nodes_[std::size_t(node)]);
      shell_nodes_.push_back(nodes_[std::size_t(node)] + height_ * normals.at(node));
    }
    return found->second;
  }

  std::vector<Vec3> nodes_, shell_nodes_;
  std::vector<Triangle> triangles_, shell_;
  std::vector<int> chosen_;
  double height_ = 1;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(surface_engines) {
  factory.add<stroma::Spiral>("Spiral", "a strip rolled up to a spiral");
  factory.add<stroma::ExtrudeSurface>("ExtrudeSurface", "a shell of a part of a surface");
}
