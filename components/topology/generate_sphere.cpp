// SPDX-License-Identifier: LGPL-2.1-or-later
// GenerateSphere: a ball of tetrahedra, made from a platonic solid. Each face of the solid forms a tetrahedron with the centre, which is
// cut into tessellationDegree^3 smaller ones in layers around the centre. Layer l of n has radius l R / n. Its nodes lie on the rays
// through the nodes of an even cut of the faces. The surface is that of the last layer: output_TrianglesPosition lists its triangles.
//
// Source: names and attributes are SOFA's; the order of nodes and cells is not.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 0">
//   <EulerExplicitSolver/>
//   <GenerateSphere name="ball" radius="0.5" tessellationDegree="3"/>
//   <TetrahedronSetTopologyContainer position="@ball.output_TetrahedraPosition" tetrahedra="@ball.tetrahedra"/>
//   <MechanicalObject/>
//   <DiagonalMass massDensity="1000"/>
// </Node>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "framework/mesh/cell_attributes.h"
#include "framework/mesh/mesh.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class GenerateSphere final : public Component {
 public:
  std::string roleText() const override { return "mesh engine"; }
  void declare(DataTable& table) override {
    table.add("radius", radius_).help("of the ball").unit("m").min(0, false);
    table.add("origin", centre_).alias("center").help("its centre").unit("m");
    table.add("tessellationDegree", degree_).help("layers, and parts of each edge of the solid").min(1).max(60);
    table.addChoice("platonicSolid", solid_, {"icosahedron", "octahedron", "tetrahedron"}).help("the solid that is cut");
    table.add("output_TetrahedraPosition", mesh_.position).alias("position").help("nodes").unit("m").output();
    addCellList(table, cell_kinds::tetrahedron, mesh_.tetrahedra).help("the cells").output();
    table.add("output_TrianglesPosition", shell_).help("nodes of the surface").unit("m").output();
    addCellList(table, cell_kinds::triangle, triangles_).help("the surface, of its own nodes, outward").output();
    for (const char* name : {"bezierTetrahedronDegree", "bezierTriangleDegree"}) table.addVisualOnly(name);
  }

  void init() override {
    mesh_ = Mesh();
    shell_.clear();
    triangles_.clear();
    nodes_.clear();
    on_shell_.clear();
    const std::vector<Vec3> corners = cornersOfSolid();
    double edge = (corners[0] - corners[1]).norm();
    for (const Vec3& p : corners)
      if (&p != &corners[0]) edge = std::min(edge, (corners[0] - p).norm());
    const int count = int(corners.size());
    const auto beside = [&](int a, int b) { return (corners[std::size_t(a)] - corners[std::size_t(b)]).norm() < 1.01 * edge; };
    for (int a = 0; a < count; ++a)
      for (int b = a + 1; b < count; ++b)
        for (int c = b + 1; c < count; ++c)
          if (beside(a, b) && beside(b, c) && beside(c, a)) cut(corners, {a, b, c});
  }

 private:
  enum class Solid : int { icosahedron, octahedron, tetrahedron };
  /// On the unit sphere.
  std::vector<Vec3> cornersOfSolid() const {
    std::vector<Vec3> corners;
    if (solid_ == Solid::tetrahedron) {
      corners = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
    } else {
      const double golden = (1 + std::sqrt(5.)) / 2;
      for (int axis = 0; axis < 3; ++axis)
        for (const double end : {1., -1.}) {
          if (solid_ == Solid::octahedron) corners.emplace_back(end * Vec3::Unit(axis));
          for (const double side : {golden, -golden})
            if (solid_ == Solid::icosahedron) corners.emplace_back(end * Vec3::Unit(axis) + side * Vec3::Unit((axis + 1) % 3));
        }
    }
    for (Vec3& p : corners) p.normalize();
    return corners;
  }

  /// A place in the tetrahedron of the centre and a face: degree >= layer >= second >= third >= 0.
  using Place = std::array<int, 3>;

  /// The node at a place; one for all faces that share it.
  Index nodeAt(const Place& place, const std::vector<Vec3>& corners, const std::array<int, 3>& face) {
    const std::array<int, 3> shares = {place[0] - place[1], place[1] - place[2], place[2]};
    std::vector<int> key;
    Vec3 ray = Vec3::Zero();
    for (std::size_t c = 0; c < 3; ++c) {
      if (shares[c] == 0) continue;
      key.insert(key.end(), {face[c], shares[c]});
      ray += shares[c] * corners[std::size_t(face[c])];
    }
    const auto [found, is_new] = nodes_.emplace(key, Index(mesh_.position.size()));
    if (is_new) {
      if (place[0] > 0) ray *= radius_ * place[0] / degree_ / ray.norm();
      mesh_.position.push_back(centre_ + ray);
    }
    return found->second;
  }

  /// Cubes of places cut along their diagonals (Freudenthal): those of the tetrahedron, degree^3 cells.
  void cut(const std::vector<Vec3>& corners, const std::array<int, 3>& face) {
    constexpr int orders[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
    for (int i = 0; i < degree_; ++i)
      for (int j = 0; j <= i; ++j)
        for (int k = 0; k <= j; ++k)
          for (const auto& order : orders) {
            std::array<Place, 4> places;
            places[0] = {i, j, k};
            for (std::size_t s = 0; s < 3; ++s) {
              places[s + 1] = places[s];
              ++places[s + 1][std::size_t(order[s])];
            }
            const auto lies_in = [](const Place& p) { return p[0] >= p[1] && p[1] >= p[2]; };
            if (std::all_of(places.begin(), places.end(), lies_in)) addCell(places, corners, face);
          }
  }

  void addCell(const std::array<Place, 4>& places, const std::vector<Vec3>& corners, const std::array<int, 3>& face) {
    Tetrahedron cell;
    for (std::size_t c = 0; c < 4; ++c) cell[c] = nodeAt(places[c], corners, face);
    const auto at = [&](std::size_t c) -> const Vec3& { return mesh_.position[std::size_t(cell[c])]; };
    if ((at(1) - at(0)).dot((at(2) - at(0)).cross(at(3) - at(0))) < 0) std::swap(cell[2], cell[3]);
    mesh_.tetrahedra.push_back(cell);
    std::vector<Index> outer;
    for (std::size_t c = 0; c < 4; ++c)
      if (places[c][0] == degree_) outer.push_back(nodeAt(places[c], corners, face));
    if (outer.size() != 3) return;
    Triangle triangle;
    std::array<Vec3, 3> p;
    for (std::size_t c = 0; c < 3; ++c) {
      p[c] = mesh_.position[std::size_t(outer[c])];
      const auto [found, is_new] = on_shell_.emplace(outer[c], Index(shell_.size()));
      if (is_new) shell_.push_back(p[c]);
      triangle[c] = found->second;
    }
    if ((p[1] - p[0]).cross(p[2] - p[0]).dot(p[0] - centre_) < 0) std::swap(triangle[1], triangle[2]);
    triangles_.push_back(triangle);
  }

  double radius_ = 1;
  Vec3 centre_ = Vec3::Zero();
  int degree_ = 1;
  Solid solid_ = Solid::icosahedron;
  Mesh mesh_;
  std::vector<Vec3> shell_;
  std::vector<Triangle> triangles_;
  std::map<std::vector<int>, Index> nodes_;  ///< by corners of the solid and their shares
  std::map<Index, Index> on_shell_;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(generate_sphere) {
  factory.add<stroma::GenerateSphere>("GenerateSphere", "a ball of tetrahedra");
}
