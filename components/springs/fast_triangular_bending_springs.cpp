// SPDX-License-Identifier: LGPL-2.1-or-later
// FastTriangularBendingSprings: linear bending resistance of a triangle surface that is flat at rest.
//
// Across the edge (c, d) that two triangles share, a and b their other nodes, h_a and h_b their heights over the edge, the vector
//
//   R = sum alpha_i x_i,   alpha_a = h_b / (h_a + h_b),   alpha_b = h_a / (h_a + h_b),   alpha_c = -(1 - s),   alpha_d = -s
//
// with s where the line from a to b crosses the edge, all at rest, is zero when the four nodes lie in a plane. A fold by the
// small angle t has |R| = t h_a h_b / (h_a + h_b). With n the normals of a triangle's edges in its plane, its curvature is
//
//   k = sum over its inner edges of 2 R / (h_a h_b) n n^T,   E = sum over triangles of A mu/2 k:k,   f = -dE/dx
//
// in each direction of space. mu [N m] is the bending stiffness of a plate without lateral contraction; of a sheet of thickness
// t it is E t^3 / 12. In a grid whose cells are all cut alike, whatever their shape, inner triangles have the exact curvature of
// every surface of second order, and deflections converge to the plate's with the size of the cells. A sheet whose triangles
// differ keeps an error: where the diagonals of a grid alternate, a twist meets twice the stiffness, cylindrical bending the right
// one; with the nodes of a grid moved at random by a quarter of a cell, strips are 5 % too stiff and square plates 15 %.
//
// method = springs: SOFA's formula, of folds alone, with N_a, N_b twice the area vectors of the triangles, N_c, N_d those of
// (c, a, b) and (d, a, b), and l the length of the edge:
//
//   E = lambda/2 |R|^2,   lambda = 2/3 (|N_a| + |N_b|) / (|N_a| |N_b|)^2 l^3 mu,   alpha_c = -|N_d| / (|N_c| + |N_d|), ...
//
// Its mu is not a stiffness of the surface: with cells half the size the same sheet is twice as stiff.
//
// The stiffness is constant and positive semidefinite. A surface that is curved at rest is flattened. If more than two
// triangles share an edge, each pair of them bends independently.
//
// Source: Volino and Magnenat-Thalmann 2006, "Simple linear bending stiffness in particle systems", for R and for springs; the
// curvature of a triangle from those of its edges as in Onate and Zarate 2000, "Rotation-free triangular plate and shell
// elements". The name and the attribute are SOFA's.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 -9.81">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="100" tolerance="1e-10"/>
//   <MechanicalObject position="0 0 0  1 0 0  0.5 1 0  0.5 -1 0"/>
//   <MeshTopology position="0 0 0  1 0 0  0.5 1 0  0.5 -1 0" triangles="0 1 2  1 0 3"/>
//   <UniformMass totalMass="0.1"/>
//   <FixedProjectiveConstraint indices="0 1"/>
//   <MeshSpringForceField linesStiffness="500"/>
//   <FastTriangularBendingSprings bendingStiffness="10"/>
// </Node>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <numbers>

#include "framework/mechanics/node_group_field.h"
#include "framework/mechanics/state_topology.h"
#include "framework/mesh/cell_kind.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

constexpr int most_nodes = 6;  // of a triangle and those beyond its edges

/// The same number for the three directions of space at each pair of nodes: -stiffness_of(i, j).
struct BendingTangent {
  Eigen::Matrix<double, most_nodes, most_nodes> numbers;
  int corners = most_nodes;
  void setZero() { numbers.setZero(); }
  Mat3 block(int i, int j) const { return numbers(i, j) * Mat3::Identity(); }
  void addProduct(const std::array<Index, most_nodes>& rows, ConstRows dx, double factor, Rows df) const {
    for (int i = 0; i < corners; ++i) {
      Vec3 sum = Vec3::Zero();
      for (int j = 0; j < corners; ++j) sum += numbers(i, j) * dx[rows[std::size_t(j)]];
      df[rows[std::size_t(i)]] += factor * sum;
    }
  }
};

class FastTriangularBendingSprings final : public NodeGroupField<most_nodes, BendingTangent> {
 public:
  void declare(DataTable& table) override;
  void init() override;

  ForceTraits traits() const override {
    ForceTraits traits;
    traits.linear = traits.constant_stiffness = traits.symmetric = traits.conservative = traits.exact_tangent = true;
    traits.forces_balance = traits.torques_balance = curved_ == 0;
    return traits;
  }

  void compile() override {
    std::vector<Group> rows;
    for (const Part& part : parts_) {
      rows.push_back(part.nodes);
      for (Index& row : rows.back()) row += state().firstRow();
    }
    setGroups(std::move(rows), false);
    for (std::size_t p = 0; p < parts_.size(); ++p) {
      stiffness_[p].corners = parts_[p].count;
      stiffness_[p].numbers = -parts_[p].stiffness * parts_[p].slopes.transpose() * parts_[p].slopes;
    }
  }

  double energy(ConstRows x) const override {
    double sum = 0;
    for (std::size_t p = 0; p < parts_.size(); ++p) sum += parts_[p].stiffness / 2 * bend(p, x).squaredNorm();
    return sum;
  }
  void addForce(ConstRows x, ConstRows, Rows f) override {
    for (std::size_t p = 0; p < parts_.size(); ++p) {
      const Mat3 pull = parts_[p].stiffness * bend(p, x);
      for (int i = 0; i < parts_[p].count; ++i) f[rows_[p][std::size_t(i)]] -= pull * parts_[p].slopes.col(i);
    }
  }

 private:
  enum class Method : int { plate, springs };
  using Slopes = Eigen::Matrix<double, 3, most_nodes>;
  /// What bends as one: a triangle, or one fold.
  struct Part {
    Group nodes{};  ///< `count` of them, then the first again
    int count = 0;
    Slopes slopes = Slopes::Zero();  ///< of xx, yy and sqrt(2) xy of the curvature [1/m^2], or of R [-]
    double stiffness = 0;            ///< [N m^3], or [N/m]
  };
  /// Two triangles with an edge in common.
  struct Fold {
    std::array<Index, 4> nodes;         ///< a, b, c, d
    std::array<double, 4> alpha;        ///< [-]
    double height_a, height_b, length;  ///< [m]
  };

  /// Columns: the components of the curvature, or R; rows: directions of space.
  Mat3 bend(std::size_t p, ConstRows x) const {
    Mat3 sum = Mat3::Zero();
    for (int i = 0; i < parts_[p].count; ++i)
      sum += x[rows_[p][std::size_t(i)]] * parts_[p].slopes.col(i).transpose();
    return sum;
  }

  const Vec3& place(Index node) const { return state().rest_position[std::size_t(node)]; }
  bool isFold(Index a, Index b, Index c, Index d, Fold& fold);
  void addSpring(const Fold& fold);
  void addTriangle(const Triangle& triangle, const std::vector<Fold>& folds);

  TopologyLink topology_;
  double bending_ = 1000, smallest_ = 0;
  Method method_ = Method::plate;
  std::vector<Part> parts_;
  int curved_ = 0, folds_ = 0;
};

void FastTriangularBendingSprings::declare(DataTable& table) {
  ForceField::declare(table);
  topology_.declare(table, "surface");
  table.add("bendingStiffness", bending_).help("bending stiffness of the surface, E t^3 / 12 of a sheet").unit("N m").min(0).physical();
  table.add("minDistValidity", smallest_)
      .help("triangles with a smaller height have no bending stiffness")
      .unit("m")
      .min(0);
  table.addChoice("method", method_, {"plate", "springs"})
      .help("plate: curvatures of triangles; springs: SOFA's folds, whose stiffness depends on the size of the cells");
}

void FastTriangularBendingSprings::init() {
  ForceField::init();
  const Mesh& mesh = topology_.meshWith(cell_kinds::triangle, *this, state());
  std::map<Edge, std::vector<Index>> opposite;
  const auto edgeOf = [](Index c, Index d) { return Edge{std::min(c, d), std::max(c, d)}; };
  for (const Triangle& t : mesh.triangles)
    for (std::size_t i = 0; i < 3; ++i) opposite[edgeOf(t[i], t[(i + 1) % 3])].push_back(t[(i + 2) % 3]);
  parts_.clear();
  curved_ = folds_ = 0;
  Fold fold;
  for (const auto& [edge, nodes] : opposite)
    for (std::size_t i = 0; i < nodes.size(); ++i)
      for (std::size_t j = 0; j < i; ++j) {
        if (!isFold(nodes[j], nodes[i], edge[0], edge[1], fold)) continue;
        ++folds_;
        Vec3 bent = Vec3::Zero();
        for (std::size_t k = 0; k < 4; ++k) bent += fold.alpha[k] * place(fold.nodes[k]);
        curved_ += bent.norm() > 1e-9 * fold.length;
        if (method_ == Method::springs || nodes.size() > 2) addSpring(fold);
      }
  if (folds_ == 0) throw ComponentError("no two triangles of the surface share an edge", "a connected surface");
  if (method_ == Method::plate)
    for (const Triangle& t : mesh.triangles) {
      std::vector<Fold> folds;
      for (std::size_t i = 0; i < 3; ++i) {
        const Index c = t[i], d = t[(i + 1) % 3], a = t[(i + 2) % 3];
        const std::vector<Index>& nodes = opposite[edgeOf(c, d)];
        if (nodes.size() == 2 && isFold(a, nodes[0] == a ? nodes[1] : nodes[0], c, d, fold)) folds.push_back(fold);
      }
      if (!folds.empty()) addTriangle(t, folds);
    }
  if (curved_ > 0)
    warn(fmt::format("the surface is curved at rest at {} of its {} inner edges: it will be flattened", curved_, folds_),
         "TriangularBendingSprings keep a curved shape");
}

/// False for the same triangle twice and for those that are too flat.
bool FastTriangularBendingSprings::isFold(Index a, Index b, Index c, Index d, Fold& fold) {
  if (a == b) return false;
  const Vec3 edge = place(d) - place(c);
  fold.nodes = {a, b, c, d};
  fold.length = edge.norm();
  fold.height_a = edge.cross(place(a) - place(c)).norm() / fold.length;
  fold.height_b = edge.cross(place(b) - place(c)).norm() / fold.length;
  const double both = fold.height_a + fold.height_b;
  if (!(std::min(fold.height_a, fold.height_b) > smallest_)) return false;
  const auto along = [&](Index node) { return edge.dot(place(node) - place(c)) / edge.squaredNorm(); };
  const double s = (fold.height_b * along(a) + fold.height_a * along(b)) / both;
  fold.alpha = {fold.height_b / both, fold.height_a / both, s - 1, -s};
  return true;
}

/// A fold by itself: the energy of its two triangles, or SOFA's.
void FastTriangularBendingSprings::addSpring(const Fold& fold) {
  const auto area = [&](std::size_t i, std::size_t j, std::size_t k) {
    const Vec3& p = place(fold.nodes[i]);
    return (place(fold.nodes[j]) - p).cross(place(fold.nodes[k]) - p).norm();
  };
  const double a = area(0, 2, 3), b = area(1, 2, 3), l = fold.length;
  Part part;
  part.count = 4;
  part.stiffness = (a + b) / (a * b * a * b) * l * l * l * bending_;
  std::array<double, 4> alpha = fold.alpha;
  if (method_ == Method::springs) {
    const double c = area(2, 0, 1), d = area(3, 0, 1);
    if (!(c + d > 0)) return;
    part.stiffness *= 2. / 3;
    alpha = {b / (a + b), a / (a + b), -d / (c + d), -c / (c + d)};
  } else {
    part.stiffness *= 2 * l;
  }
  for (int i = 0; i < most_nodes; ++i) part.nodes[std::size_t(i)] = fold.nodes[i < 4 ? std::size_t(i) : 0];
  for (int i = 0; i < 4; ++i) part.slopes(0, i) = alpha[std::size_t(i)];
  parts_.push_back(part);
}

/// The folds have the node of `triangle` opposite to their edge first, then the one beyond.
void FastTriangularBendingSprings::addTriangle(const Triangle& triangle, const std::vector<Fold>& folds) {
  const Vec3 first = (place(triangle[1]) - place(triangle[0])).normalized();
  const Vec3 normal = first.cross(place(triangle[2]) - place(triangle[0]));
  const Vec3 second = normal.normalized().cross(first);
  Part part;
  part.count = 3 + int(folds.size());
  part.nodes.fill(triangle[0]);
  for (std::size_t i = 0; i < 3; ++i) part.nodes[i] = triangle[i];
  part.stiffness = bending_ * (place(triangle[1]) - place(triangle[0])).norm() * normal.norm() / 2;
  for (std::size_t f = 0; f < folds.size(); ++f) {
    const Fold& fold = folds[f];
    part.nodes[3 + f] = fold.nodes[1];
    const Vec3 edge = (place(fold.nodes[3]) - place(fold.nodes[2])).normalized();
    const double u = edge.dot(second), v = -edge.dot(first);  // the edge's normal
    const Vec3 curvature = 2 / (fold.height_a * fold.height_b) * Vec3(u * u, v * v, std::numbers::sqrt2 * u * v);
    for (std::size_t k = 0; k < 4; ++k) {
      const auto end = k == 1 ? part.nodes.begin() + 3 + std::ptrdiff_t(f)
                              : std::find(part.nodes.begin(), part.nodes.begin() + 3, fold.nodes[k]);
      part.slopes.col(end - part.nodes.begin()) += fold.alpha[k] * curvature;
    }
  }
  parts_.push_back(part);
}

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(fast_triangular_bending_springs) {
  factory.add<stroma::FastTriangularBendingSprings>("FastTriangularBendingSprings",
                                                    "linear bending resistance of a flat triangle surface");
}
