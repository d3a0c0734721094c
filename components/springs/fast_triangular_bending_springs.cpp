// SPDX-License-Identifier: LGPL-2.1-or-later
// FastTriangularBendingSprings: linear bending resistance of a triangle surface that is flat at rest.
//
// Across the edge (c, d) that two triangles share, a and b their other nodes, the vector
//
//   R = sum alpha_i x_i,   alpha_a = |N_b| / (|N_a| + |N_b|),   alpha_b = |N_a| / (|N_a| + |N_b|),
//                          alpha_c = -|N_d| / (|N_c| + |N_d|),  alpha_d = -|N_c| / (|N_c| + |N_d|)
//
// is zero when the four nodes lie in a plane and else the bent edge's normal times its curvature, up to a factor. With
// N_a, N_b twice the area vectors of the triangles, N_c, N_d those of the triangles (c, a, b) and (d, a, b), l the
// length of the edge, all at rest, and mu the bending stiffness:
//
//   E = lambda/2 |R|^2,   lambda = 2/3 (|N_a| + |N_b|) / (|N_a| |N_b|)^2 l^3 mu,   f_i = -lambda alpha_i R
//
// The stiffness is constant and positive semidefinite. Where the surface is curved at rest it is flattened.
//
// Source: Volino and Magnenat-Thalmann 2006, "Simple linear bending stiffness in particle systems"; the name and the
// attribute are SOFA's.
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
#include <map>

#include "framework/mechanics/node_group_field.h"
#include "framework/mechanics/state_topology.h"
#include "framework/mesh/cell_kind.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class FastTriangularBendingSprings final : public NodeGroupField<4> {
 public:
  void declare(DataTable& table) override {
    ForceField::declare(table);
    topology_.declare(table, "surface");
    table.add("bendingStiffness", bending_).help("bending stiffness of the surface").unit("N m").min(0);
    table.add("minDistValidity", smallest_)
        .help("triangles with a smaller height have no bending stiffness")
        .unit("m")
        .min(0);
  }

  void init() override {
    ForceField::init();
    const Mesh& mesh = topology_.meshWith(cell_kinds::triangle, *this, state());
    std::map<Edge, std::vector<Index>> opposite;
    for (const Triangle& t : mesh.triangles)
      for (std::size_t i = 0; i < 3; ++i) {
        const Index c = t[i], d = t[(i + 1) % 3];
        opposite[{std::min(c, d), std::max(c, d)}].push_back(t[(i + 2) % 3]);
      }
    hinges_.clear();
    curved_ = 0;
    for (const auto& [edge, nodes] : opposite)
      for (std::size_t i = 0; i < nodes.size(); ++i)
        for (std::size_t j = 0; j < i; ++j) addHinge({nodes[j], nodes[i], edge[0], edge[1]});
    if (hinges_.empty()) throw ComponentError("no two triangles of the surface share an edge", "a connected surface");
    if (curved_ > 0)
      warn(fmt::format("the surface is curved at rest at {} of its {} inner edges: it will be flattened", curved_,
                       hinges_.size()),
           "TriangularBendingSprings keep a curved shape");
  }

  ForceTraits traits() const override {
    ForceTraits traits;
    traits.linear = traits.constant_stiffness = traits.symmetric = traits.conservative = traits.exact_tangent = true;
    traits.forces_balance = traits.torques_balance = curved_ == 0;
    return traits;
  }

  void compile() override {
    std::vector<Group> rows;
    for (const Hinge& hinge : hinges_) {
      rows.push_back(hinge.nodes);
      for (Index& row : rows.back()) row += state().firstRow();
    }
    setGroups(std::move(rows), false);
    for (std::size_t h = 0; h < hinges_.size(); ++h)
      for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j)
          stiffness_[h].block(i, j) = -hinges_[h].lambda * hinges_[h].alpha[i] * hinges_[h].alpha[j] * Mat3::Identity();
  }

  double energy(ConstRows x) const override {
    double sum = 0;
    for (std::size_t h = 0; h < hinges_.size(); ++h) sum += hinges_[h].lambda / 2 * bend(h, x).squaredNorm();
    return sum;
  }
  void addForce(ConstRows x, ConstRows, Rows f) override {
    for (std::size_t h = 0; h < hinges_.size(); ++h) {
      const Vec3 pull = hinges_[h].lambda * bend(h, x);
      for (std::size_t i = 0; i < 4; ++i) f[rows_[h][i]] -= hinges_[h].alpha[i] * pull;
    }
  }

 private:
  struct Hinge {
    Group nodes;      ///< a, b, c, d
    double alpha[4];  ///< [-]
    double lambda;    ///< [N/m]
  };

  Vec3 bend(std::size_t h, ConstRows x) const {
    Vec3 r = Vec3::Zero();
    for (std::size_t i = 0; i < 4; ++i) r += hinges_[h].alpha[i] * x[rows_[h][i]];
    return r;
  }

  void addHinge(const Group& nodes) {
    if (nodes[0] == nodes[1]) return;
    const auto p = [&](std::size_t i) -> const Vec3& { return state().rest_position[nodes[i]]; };
    const auto area = [&](std::size_t i, std::size_t j, std::size_t k) {
      return (p(j) - p(i)).cross(p(k) - p(i)).norm();
    };
    const double a = area(0, 2, 3), b = area(1, 2, 3), c = area(2, 0, 1), d = area(3, 0, 1);
    const double length = (p(3) - p(2)).norm();
    if (!(std::min(a, b) > smallest_ * length) || !(c + d > 0)) return;
    Hinge hinge{nodes, {b / (a + b), a / (a + b), -d / (c + d), -c / (c + d)}, 0};
    hinge.lambda = 2. / 3 * (a + b) / (a * b * a * b) * length * length * length * bending_;
    Vec3 bent = Vec3::Zero();
    for (std::size_t i = 0; i < 4; ++i) bent += hinge.alpha[i] * p(i);
    curved_ += bent.norm() > 1e-9 * length;
    hinges_.push_back(hinge);
  }

  TopologyLink topology_;
  double bending_ = 1000, smallest_ = 0;
  std::vector<Hinge> hinges_;
  int curved_ = 0;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(fast_triangular_bending_springs) {
  factory.add<stroma::FastTriangularBendingSprings>("FastTriangularBendingSprings",
                                                    "linear bending resistance of a flat triangle surface");
}
