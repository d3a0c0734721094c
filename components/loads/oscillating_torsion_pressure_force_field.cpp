// SPDX-License-Identifier: LGPL-2.1-or-later
// OscillatingTorsionPressureForceField: a part of a surface twisted back and forth about an axis by a moment, as by a plate
// glued to it.
//
//   M(t) = moment cos(2 pi frequency t + phase)
//   f_i = penalty (R(alpha) X_i - x_i) + m w_i t_i/d_i,   alpha = sum d_i angle_i / sum d_i
//
// X_i and x_i are the rest and current positions of a node of the part, d_i its current distance from the axis through
// `center`, angle_i its rotation about it, and t_i the direction of this rotation. The first term keeps the shape of the part,
// rotated by alpha as a whole. m makes up the difference of that term from M(t), so that all forces together have the moment
// M(t) about the axis. The weights w_i sum to 1 and grow with the third power of the distance and with the area around a node.
//
// The part: the triangles of triangleList; or those whose corners have all dmin < X.axis < dmax; or all.
//
// The forces have no derivative here, as in SOFA: a step is stable while dt^2 penalty is less than the mass of a node.
//
// Source: name, attributes and weights are SOFA's, but for phase.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="100" tolerance="1e-10"/>
//   <MeshTopology position="1 0 0  0 1 0  -1 0 0  0 -1 0" triangles="0 1 2  0 2 3"/>
//   <MechanicalObject/>
//   <UniformMass totalMass="4"/>
//   <TriangularFEMForceField youngModulus="1e3" poissonRatio="0.3" thickness="0.1"/>
//   <OscillatingTorsionPressureForceField moment="0.5" axis="0 0 1" frequency="2" penalty="100"/>
// </Node>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>

#include "framework/mechanics/node_group_field.h"
#include "framework/mechanics/state_topology.h"
#include "framework/mesh/cell_kind.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class OscillatingTorsion final : public NodeGroupField<1> {
 public:
  void declare(DataTable& table) override {
    ForceField::declare(table);
    topology_.declare(table, "surface");
    table.add("moment", moment_).atOnce().help("largest moment about the axis").unit("N m").required();
    table.add("frequency", frequency_).atOnce().help("oscillations per second").unit("1/s").min(0);
    table.add("phase", phase_).atOnce().help("of the moment at t = 0").unit("rad");
    table.add("penalty", penalty_).atOnce().help("force over the distance from the turned shape").unit("N/m").physical().min(0);
    table.add("axis", axis_).help("axis of the turn").unit("-");
    table.add("center", centre_).help("a point of the axis").unit("m");
    table.add("triangleList", listed_).help("triangles of the part");
    table.add("dmin", least_).help("the part lies beyond this place along the axis").unit("m");
    table.add("dmax", most_).help("and before this one").unit("m");
    table.addVisualOnly("showForces");
  }

  void init() override {
    ForceField::init();
    if (!(axis_.norm() > 0)) throw ComponentError("axis has no direction", "a vector that is not zero");
    direction_ = axis_.normalized();
    const Mesh& mesh = topology_.meshWith(cell_kinds::triangle, *this, state());
    weights_.clear();
    for (const int number : chosen(mesh)) addTriangle(mesh.triangles[std::size_t(number)]);
    const double sum =
        std::accumulate(weights_.begin(), weights_.end(), 0., [](double all, const auto& each) { return all + each.second; });
    if (!(sum > 0)) throw ComponentError("all nodes of the part lie on the axis", "a part around the axis");
    for (auto& [node, weight] : weights_) weight /= sum;
  }

  ForceTraits traits() const override {
    ForceTraits traits;
    traits.symmetric = traits.time_dependent = true;
    traits.has_stiffness = false;
    return traits;
  }
  void compile() override {
    std::vector<Index> nodes;
    rest_.clear(), shares_.clear();
    on_axis_ = 0;
    for (const auto& [node, weight] : weights_) {
      nodes.push_back(node), shares_.push_back(weight);
      rest_.push_back(state().rest_position[std::size_t(node)]);
      on_axis_ = std::max(on_axis_, 1e-20 * fromAxis(rest_.back()).squaredNorm());
    }
    setNodes(nodes, false);
  }
  void setTime(double t) override { now_ = moment_ * std::cos(2 * std::numbers::pi * frequency_ * t + phase_); }

  /// Of the term that keeps the shape.
  double energy(ConstRows x) const override {
    const Mat3 turn = Eigen::AngleAxisd(meanAngle(x), direction_).toRotationMatrix();
    double sum = 0;
    for (std::size_t i = 0; i < rows_.size(); ++i) sum += penalty_ / 2 * (placeOf(i, turn) - Vec3(x[rows_[i][0]])).squaredNorm();
    return sum;
  }
  void addForce(ConstRows x, ConstRows, Rows f) override {
    const Mat3 turn = Eigen::AngleAxisd(meanAngle(x), direction_).toRotationMatrix();
    double lacking = now_;
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      const Vec3 place = x[rows_[i][0]], force = penalty_ * (placeOf(i, turn) - place);
      f[rows_[i][0]] += force;
      lacking -= direction_.cross(fromAxis(place)).dot(force);
    }
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      const Vec3 arm = fromAxis(x[rows_[i][0]]);
      if (const double square = arm.squaredNorm(); square > on_axis_)
        f[rows_[i][0]] += lacking * shares_[i] / square * direction_.cross(arm);
    }
  }

 private:
  Vec3 fromAxis(const Vec3& p) const { return p - centre_ - direction_.dot(p - centre_) * direction_; }
  Vec3 placeOf(std::size_t i, const Mat3& turn) const { return rest_[i] + (turn - Mat3::Identity()) * fromAxis(rest_[i]); }
  double meanAngle(ConstRows x) const {
    double sum = 0, distances = 0;
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      const Vec3 arm = fromAxis(x[rows_[i][0]]), rest = fromAxis(rest_[i]);
      if (arm.squaredNorm() <= on_axis_ || rest.squaredNorm() <= on_axis_) continue;
      sum += arm.norm() * std::atan2(direction_.dot(rest.cross(arm)), rest.dot(arm));
      distances += arm.norm();
    }
    return distances > 0 ? sum / distances : 0;
  }

  std::vector<int> chosen(const Mesh& mesh) const {
    const bool listed = data().find("triangleList")->isSet();
    std::vector<int> numbers = listed ? listed_ : std::vector<int>();
    for (const int number : numbers)
      if (number < 0 || std::size_t(number) >= mesh.triangles.size())
        throw ComponentError(fmt::format("triangleList names {}, and there are {} triangles", number, mesh.triangles.size()));
    const auto lies_between = [this](Index node) {
      const double way = direction_.dot(state().rest_position[std::size_t(node)]);
      return least_ == most_ || (way > least_ && way < most_);
    };
    for (std::size_t e = 0; e < mesh.triangles.size() && !listed; ++e)
      if (std::all_of(mesh.triangles[e].begin(), mesh.triangles[e].end(), lies_between)) numbers.push_back(int(e));
    if (numbers.empty()) throw ComponentError("the part has no triangle", "triangleList, or dmin and dmax around some triangles");
    return numbers;
  }
  /// Distances at the corner, at the middles of its sides and between them, and at the centre of the triangle.
  void addTriangle(const Triangle& triangle) {
    std::array<double, 3> d;
    std::array<Vec3, 3> p;
    for (std::size_t i = 0; i < 3; ++i) {
      p[i] = state().rest_position[std::size_t(triangle[i])];
      d[i] = fromAxis(p[i]).norm();
    }
    const double area = (p[1] - p[0]).cross(p[2] - p[0]).norm() / 2, middle = (d[0] + d[1] + d[2]) / 3;
    for (std::size_t i = 0; i < 3; ++i) {
      const double one = (d[i] + d[(i + 1) % 3]) / 2, other = (d[i] + d[(i + 2) % 3]) / 2, between = (d[i] + one + other) / 3;
      weights_[triangle[i]] += (d[i] * d[i] + one * one + other * other + between * between + middle * middle) * d[i] * area / 3;
    }
  }

  TopologyLink topology_;
  double moment_ = 0, frequency_ = 1, phase_ = 0, penalty_ = 1000, least_ = 0, most_ = 0;
  Vec3 axis_ = Vec3::UnitZ(), centre_ = Vec3::Zero(), direction_ = Vec3::UnitZ();
  std::vector<int> listed_;
  std::map<Index, double> weights_;  ///< of each node of the part
  std::vector<Vec3> rest_;           ///< [m], shape (nodes of the part)
  std::vector<double> shares_;       ///< of the moment, shape (nodes of the part)
  double now_ = 0;                   ///< M(t) [N m]
  double on_axis_ = 0;               ///< [m^2], the square of an arm that is none
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(oscillating_torsion_pressure_force_field) {
  factory.add<stroma::OscillatingTorsion>("OscillatingTorsionPressureForceField",
                                          "a part of a surface twisted back and forth about an axis");
}
