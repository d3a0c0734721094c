// SPDX-License-Identifier: LGPL-2.1-or-later
// MeshROI: selects the nodes and cells of a mesh that lie inside of a closed surface of triangles.
//
// A point p is inside where the surface fills at least half of what is seen from there: the solid angles of its triangles (a, b, c),
//
//   tan(w/2) = a.(b x c) / (|a||b||c| + a.b |c| + b.c |a| + c.a |b|),   a, b, c from p to the corners,
//
// add up to 2 pi or more. Nodes on the surface are inside. A cell is inside when all its nodes are, and unless strict="true" also
// when its centre is. What is tested and what comes out is as of a BoxROI; `box` has the corners of the box around the surface.
//
// Source: van Oosterom and Strackee 1983; the attributes are SOFA's, which counts how often a ray meets the surface.
//
// Example:
// <Node name="root">
//   <RegularGridTopology name="grid" n="5 3 3" min="0 0 0" max="4 2 2"/>
//   <MeshROI name="corner" ROIposition="-1 -1 -1  3 -1 -1  -1 3 -1  -1 -1 3" ROItriangles="0 2 1  0 1 3  1 2 3  2 0 3"/>
// </Node>
#include <fmt/format.h>

#include <cmath>

#include "components/selection/region_of_interest.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class MeshROI final : public RegionOfInterest {
 public:
  MeshROI() { strict_ = false, whole_counts_ = true; }
  void declare(DataTable& table) override {
    table.add("ROIposition", surface_).unit("m").help("nodes of the surface");
    table.add("ROItriangles", triangles_).help("its triangles");
    table.add("computeMeshROI", inside_only_).alias("computeTemplateTriangles").help("false: everything is selected, as in SOFA");
    for (const char* name : {"ROIedges", "drawOut", "drawBox"}) table.addVisualOnly(name);
    RegionOfInterest::declare(table);
    table.find("strict")->help("a cell is inside when all its nodes are; false: also when its centre is");
    table.add("box", box_).unit("m").help("x y z of the least and of the largest corner of the surface").output();
  }

 protected:
  void prepare() override {
    if (triangles_.empty()) throw ComponentError("the surface has no triangles", "ROIposition and ROItriangles");
    for (const Triangle& t : triangles_)
      for (const Index node : t)
        if (node < 0 || std::size_t(node) >= surface_.size())
          throw ComponentError(fmt::format("ROItriangles names node {} of {}", node, surface_.size()));
    Eigen::AlignedBox3d around;
    for (const Vec3& p : surface_) around.extend(p);
    const Vec3 low = around.min(), high = around.max();
    box_ = {low.x(), low.y(), low.z(), high.x(), high.y(), high.z()};
    if (!inside_only_) warn("everything is selected", "computeMeshROI=\"true\" selects what lies in the surface");
  }
  /// Half of the full solid angle or more (van Oosterom and Strackee 1983).
  bool contains(const Vec3& p) const override {
    if (!inside_only_) return true;
    double angle = 0;
    for (const Triangle& t : triangles_) {
      const Vec3 a = surface_[t[0]] - p, b = surface_[t[1]] - p, c = surface_[t[2]] - p;
      const double l = a.norm(), m = b.norm(), n = c.norm();
      angle += 2 * std::atan2(a.dot(b.cross(c)), l * m * n + a.dot(b) * n + b.dot(c) * l + c.dot(a) * m);
    }
    constexpr double half = 6.283185307179586;
    return std::abs(angle) >= half * (1 - widening);
  }
  std::string describeRegion() const override { return "the surface"; }

 private:
  std::vector<Vec3> surface_;
  std::vector<Triangle> triangles_;
  std::vector<double> box_;
  bool inside_only_ = true;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(mesh_region) {
  factory.add<stroma::MeshROI>("MeshROI", "selects the nodes and cells inside of a surface");
}
