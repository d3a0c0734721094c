// SPDX-License-Identifier: LGPL-2.1-or-later
// A ball that pushes the points inside it outwards, such as one that a hand leads. With the centre c, radius r, stiffness k,
// damping c_d, d = |x - c| and n = (x - c)/d:
//
//   E = k/2 (r - d)^2,   f = (k (r - d) - c_d v.n) n   where d < r
//   df/dx = -k n n^T,   df/dv = -c_d n n^T
//
// A point at the centre is pushed along x, so that it leaves. Of frames the centres are pushed.
//
// df/dx leaves out k (r/d - 1) (I - n n^T), how n turns as a point slides along the ball. This term is positive, without bound
// towards the centre, and would make the matrix of an implicit step indefinite. So a ball may move deep into a body in one step.
// Newton's method finds the same equilibrium in more iterations. df/dv leaves out the turning of n too. SphereForceField has the
// exact derivative, damps sliding as well, and also keeps nodes inside.
//
// Both derivatives have diagonal blocks alone, which every matrix has: which points are inside never changes a pattern.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="50" tolerance="1e-10"/>
//   <MechanicalObject position="0 0 0  0.1 0 0.05  1.3 0 -2.7"/>
//   <UniformMass totalMass="0.3"/>
//   <BallForceField center="0 -1.4 0" radius="1.41" stiffness="1000" damping="2"/>
// </Node>
#include <fmt/format.h>

#include "framework/scene/factory.h"
#include "framework/simulation/input_forces.h"

namespace stroma {
namespace {

/// Nearer to the centre the square of a distance underflows, and a point has no direction.
constexpr double no_distance = 1e-150;

Mat3 along(const Vec3& normal, double factor) { return factor * normal * normal.transpose(); }

class BallForceField final : public BallForce {
 public:
  void declare(DataTable& table) override {
    ForceField::declare(table);
    table.add("center", ball_.centre).recompiled().help("centre").unit("m");
    table.add("radius", ball_.radius).recompiled().help("radius").unit("m").min(0, false).required();
    table.add("stiffness", stiffness_).recompiled().help("force over depth").unit("N/m").min(0).physical();
    table.add("damping", damping_).recompiled().help("force over the velocity along the radius").unit("N s/m").min(0);
  }
  void init() override {
    ForceField::init();
    const State& bodies = state();
    for (Index i = 0; i < bodies.size(); ++i)
      if (bodies.kindOf(i) == RowKind::place) return;
    throw ComponentError(fmt::format("a ball pushes points, and {} has none", bodies.path()), "a state of points or frames");
  }
  void actAs(const Input& input, State& state) override {
    standBeside(state, "ball");
    mstate_.set(&state);
    ball_ = *input.ball, stiffness_ = input.stiffness, damping_ = input.damping;
    init();
  }

  ForceTraits traits() const override {
    ForceTraits traits;
    traits.symmetric = traits.conservative = true;
    traits.velocity_dependent = damping_ > 0;
    return traits;
  }
  Cost cost() const override { return {2.5, 2.5}; }  // few points are inside, and they come and go
  double energy(ConstRows x) const override {
    double sum = 0;
    forInside(x, [&](Index, double depth, const Vec3&) { sum += stiffness_ / 2 * depth * depth; });
    return sum;
  }
  void addForce(ConstRows x, ConstRows v, Rows f) override {
    touches_.clear();
    forInside(x, [&](Index row, double depth, const Vec3& normal) {
      f[row] += (stiffness_ * depth - damping_ * normal.dot(v[row])) * normal;
      touches_.push_back({row, normal});
    });
  }
  void addPattern(BlockPattern&) const override {}  // the diagonal is always there
  void addStiffnessProduct(ConstRows dx, double factor, Rows df) const override { addProduct(-factor * stiffness_, dx, df); }
  void addStiffness(double factor, BlockMatrix& matrix) const override { addTo(-factor * stiffness_, matrix); }
  void addStiffnessDiagonal(double factor, std::vector<double>& blocks) const override { addTo(-factor * stiffness_, blocks); }
  void addDampingProduct(ConstRows dv, double factor, Rows df) const override { addProduct(-factor * damping_, dv, df); }
  void addDamping(double factor, BlockMatrix& matrix) const override { addTo(-factor * damping_, matrix); }
  void addDampingDiagonal(double factor, std::vector<double>& blocks) const override { addTo(-factor * damping_, blocks); }

 private:
  /// A point that was inside in the last evaluation of the force.
  struct Touch {
    Index row;
    Vec3 normal;  ///< outward
  };

  /// visit(row, depth r - d [m], normal) for points inside the ball at x
  template <class Visit>
  void forInside(ConstRows x, Visit&& visit) const {
    const State& of = state();
    for (Index i = 0; i < of.size(); ++i) {
      if (of.kindOf(i) != RowKind::place) continue;
      const Index row = of.firstRow() + i;
      const Vec3 from = x[row] - ball_.centre;
      const double distance = from.norm();
      if (!(distance < ball_.radius)) continue;
      visit(row, ball_.radius - distance, distance < no_distance ? Vec3(1, 0, 0) : Vec3(from / distance));
    }
  }
  void addProduct(double factor, ConstRows p, Rows out) const {
    for (const auto& [row, normal] : touches_) out[row] += factor * normal.dot(p[row]) * normal;
  }
  void addTo(double factor, BlockMatrix& matrix) const {
    for (const auto& [row, normal] : touches_) matrix.add(matrix.diagonal()[row], along(normal, factor));
  }
  void addTo(double factor, std::vector<double>& blocks) const {
    for (const auto& [row, normal] : touches_) {
      const Mat3 block = along(normal, factor);
      for (Eigen::Index k = 0; k < 9; ++k) blocks[9 * std::size_t(row) + std::size_t(k)] += block(k / 3, k % 3);
    }
  }
  bool takesAllRows() const override { return true; }

  Ball ball_{Vec3::Zero(), 1};
  double stiffness_ = 500;  ///< k [N/m]
  double damping_ = 0;      ///< c_d [N s/m]
  std::vector<Touch> touches_;  ///< ascending rows
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(ball_force_field) {
  factory.add<stroma::BallForceField>("BallForceField", "a ball that pushes points out of it, however deep they are");
}
