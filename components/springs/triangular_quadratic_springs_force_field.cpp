// SPDX-License-Identifier: LGPL-2.1-or-later
// Springs along the sides of triangles and between them, which together behave as a membrane with Hooke's law.
//
//   E = sum over triangles of 1/2 s^T H s,   s_i the elongation of the side opposite corner i
//   H_ii = w_i^2 (c_i^2 (lambda + 2 mu) + mu) / (4 A),   H_ij = w_i w_j (c_i c_j (lambda + 2 mu) - mu) / (4 A)
//   lambda = E h nu / (1 - nu^2),   mu = E h / (2 (1 + nu))
//
// c_i is the cotangent of the angle at corner i, A the area, L_i the length of its side, all at rest; h the thickness.
//
// TriangularQuadraticSpringsForceField:   s_i = l_i - L_i,           w_i = L_i
// TriangularBiquadraticSpringsForceField: s_i = (l_i^2 - L_i^2)/2,   w_i = 1
//
// Both have the energy of a membrane in plane stress to second order in the strain; the second is the membrane of St. Venant
// and Kirchhoff. `compressible` adds to that one 3/4 (lambda + 2 mu) A (J - 1)^4 for each triangle whose area J A is smaller
// than at rest, so that it does not collapse. Without useAngularSprings only the H_ii act: plain springs. The tension t = H s
// becomes H (s + dampingRatio ds/dt). The tangent is the exact derivative, except for the rotation of sides in the damping.
// There is no bending stiffness.
//
// Source: Delingette 2008, "Triangular springs for modeling nonlinear membranes"; names and attributes are SOFA's, but for
// thickness (1 there). SOFA takes the damping of the start of a step into the tension: explicitDamping. Its tangent of the
// first kind (rough) has lengths at rest where those of the moment belong, + H_ii s_i/l_i n n^T for each side with n along it;
// without angular springs it leaves out how the tension of the damping stretches. That of the second is made milder where
// triangles lose area, which is not here.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 -9.81">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="100" tolerance="1e-10"/>
//   <Node name="one">
//     <MeshTopology position="0 0 0  1 0 0  0.5 1 0  0.5 -1 0.2" triangles="0 1 2  1 0 3"/>
//     <MechanicalObject/>
//     <UniformMass totalMass="0.1"/>
//     <FixedProjectiveConstraint indices="0 1"/>
//     <TriangularQuadraticSpringsForceField youngModulus="1e4" poissonRatio="0.3" thickness="0.01" dampingRatio="0.01"/>
//   </Node>
//   <Node name="other">
//     <MeshTopology position="3 0 0  4 0 0  3.5 1 0  3.5 -1 0.2" triangles="0 1 2  1 0 3"/>
//     <MechanicalObject/>
//     <UniformMass totalMass="0.1"/>
//     <FixedProjectiveConstraint indices="0 1"/>
//     <TriangularBiquadraticSpringsForceField youngModulus="1e4" poissonRatio="0.3" thickness="0.01"/>
//   </Node>
// </Node>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>

#include "framework/mechanics/frames.h"
#include "framework/mechanics/node_group_field.h"
#include "framework/mechanics/state_topology.h"
#include "framework/mesh/cell_kind.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

/// The elongation of a side as a function of its vector d.
struct Side {
  double s = 0;
  Vec3 gradient = Vec3::Zero();
  Mat3 hessian = Mat3::Zero();
};

/// s_i = l_i - L_i. A side whose ends meet has no direction.
struct QuadraticSides {
  static constexpr bool holds_area = false;
  static Vec3 weights(const Vec3& length) { return length; }
  static Side sideOf(const Vec3& d, double rest) {
    const double length = d.norm();
    if (!(length > 1e-12 * rest)) return {length - rest, Vec3::Zero(), Mat3::Zero()};
    const Vec3 n = d / length;
    return {length - rest, n, (Mat3::Identity() - n * n.transpose()) / length};
  }
};

/// s_i = (l_i^2 - L_i^2)/2
struct BiquadraticSides {
  static constexpr bool holds_area = true;
  static Vec3 weights(const Vec3&) { return Vec3::Ones(); }
  static Side sideOf(const Vec3& d, double rest) { return {(d.squaredNorm() - rest * rest) / 2, d, Mat3::Identity()}; }
};

template <class Sides>
class TriangularSprings final : public NodeGroupField<3> {
 public:
  void declare(DataTable& table) override {
    ForceField::declare(table);
    topology_.declare(table, "surface");
    table.add("youngModulus", young_).recompiled().help("Young's modulus").unit("Pa").min(0).physical();
    table.add("poissonRatio", poisson_).recompiled().help("Poisson's ratio").unit("-").min(-1, false).max(0.5).physical();
    table.add("thickness", thickness_).recompiled().help("thickness of the membrane").unit("m").min(0, false).physical();
    table.add("dampingRatio", damping_ratio_).recompiled().help("damping over stiffness").unit("s").min(0);
    table.add("useAngularSprings", angular_).help("false: the sides resist independently");
    if constexpr (!Sides::holds_area)
      table.addChoice("tangent", tangent_, {"exact", "rough"}).help("rough: SOFA's approximation of the derivative");
    table.add("explicitDamping", explicit_).help("damping adds to the tension and to no df/dv, as in SOFA");
    if constexpr (Sides::holds_area)
      table.add("compressible", resists_).help("a triangle that loses area becomes stiffer");
  }

  void init() override {
    ForceField::init();
    const Mesh& mesh = topology_.meshWith(cell_kinds::triangle, *this, state());
    sheets_.clear();
    for (std::size_t e = 0; e < mesh.triangles.size(); ++e) addSheet(e, mesh.triangles[e]);
  }

  ForceTraits traits() const override {
    ForceTraits traits;
    traits.symmetric = traits.forces_balance = traits.torques_balance = true;
    traits.conservative = damping_ratio_ == 0 || !explicit_;  // damping that no C says is in no energy
    traits.velocity_dependent = damping_ratio_ > 0 && !explicit_;
    traits.exact_tangent = damping_ratio_ == 0 && tangent_ == Tangent::exact;
    return traits;
  }

  void compile() override {
    std::vector<Group> rows;
    for (const Sheet& sheet : sheets_) {
      rows.push_back(sheet.nodes);
      for (Index& row : rows.back()) row += state().firstRow();
    }
    setGroups(std::move(rows), damping_ratio_ > 0 && !explicit_);
  }

  double energy(ConstRows x) const override {
    double sum = 0;
    for (std::size_t e = 0; e < sheets_.size(); ++e) {
      Vec3 s;
      for (int i = 0; i < 3; ++i) s[i] = Sides::sideOf(vectorOf(e, i, x), sheets_[e].length[i]).s;
      sum += s.dot(sheets_[e].h * s) / 2;
      if constexpr (Sides::holds_area) sum += energyOfArea(e, x);
    }
    return sum;
  }

  void addForce(ConstRows x, ConstRows v, Rows f) override {
    for (std::size_t e = 0; e < sheets_.size(); ++e) {
      const Mat3& h = sheets_[e].h;
      std::array<Side, 3> sides;
      Vec3 s, rate;
      for (int i = 0; i < 3; ++i) {
        sides[std::size_t(i)] = Sides::sideOf(vectorOf(e, i, x), sheets_[e].length[i]);
        s[i] = sides[std::size_t(i)].s;
        rate[i] = damping_ratio_ > 0 ? damping_ratio_ * sides[std::size_t(i)].gradient.dot(vectorOf(e, i, v)) : 0;
      }
      const Vec3 tension = h * (s + rate), held_s = explicit_ ? Vec3(s + rate) : s, held = h * held_s;
      stiffness_[e].setZero();
      if (!damping_.empty()) damping_[e].setZero();
      for (int i = 0; i < 3; ++i) {
        const Side& side = sides[std::size_t(i)];
        f[rows_[e][far(i)]] -= tension[i] * side.gradient;
        f[rows_[e][near(i)]] += tension[i] * side.gradient;
        addBlocks(stiffness_[e], i, i, -held[i] * side.hessian);
        if (const double l = vectorOf(e, i, x).norm(); tangent_ == Tangent::rough && l > 1e-12 * sheets_[e].length[i]) {
          const double left_out = angular_ ? s[i] : s[i] - held_s[i];
          addBlocks(stiffness_[e], i, i, h(i, i) * (left_out / l) * side.gradient * side.gradient.transpose());
        }
        for (int j = 0; j < 3; ++j) {
          const Mat3 block = -h(i, j) * side.gradient * sides[std::size_t(j)].gradient.transpose();
          addBlocks(stiffness_[e], i, j, block);
          if (!damping_.empty()) addBlocks(damping_[e], i, j, damping_ratio_ * block);
        }
      }
      if constexpr (Sides::holds_area) addForceOfArea(e, x, f);
    }
  }

  std::string worstElement(ConstRows x) const override {
    std::size_t worst = sheets_.size();
    double largest = 0;
    for (std::size_t e = 0; e < sheets_.size(); ++e)
      for (int i = 0; i < 3; ++i)
        if (const double stretch = vectorOf(e, i, x).norm() / sheets_[e].length[i]; stretch >= largest)
          largest = stretch, worst = e;
    if (worst == sheets_.size()) return {};
    const auto& nodes = sheets_[worst].nodes;
    return fmt::format("triangle {} (nodes {} {} {}): a side has {:.4g} times its length at rest", worst, nodes[0], nodes[1],
                       nodes[2], largest);
  }

 private:
  struct Sheet {
    std::array<Index, 3> nodes;
    Vec3 length;  ///< of the side opposite each corner [m]
    Mat3 h;       ///< [N/m], or [N/m^3] over squares of lengths
    double area;  ///< [m^2]
  };
  static std::size_t near(int i) { return std::size_t((i + 1) % 3); }
  static std::size_t far(int i) { return std::size_t((i + 2) % 3); }
  /// Of the side opposite corner i: positions of its ends, or their velocities.
  Vec3 vectorOf(std::size_t e, int i, ConstRows x) const { return x[rows_[e][far(i)]] - x[rows_[e][near(i)]]; }

  double waveModulus() const { return young_ * thickness_ / (1 - poisson_ * poisson_); }  ///< lambda + 2 mu [N/m]

  void addSheet(std::size_t e, const Triangle& triangle) {
    Sheet sheet{{triangle[0], triangle[1], triangle[2]}, {}, {}, 0};
    std::array<Vec3, 3> d;
    for (int i = 0; i < 3; ++i) {
      d[std::size_t(i)] = state().rest_position[triangle[far(i)]] - state().rest_position[triangle[near(i)]];
      sheet.length[i] = d[std::size_t(i)].norm();
    }
    sheet.area = d[0].cross(d[1]).norm() / 2;
    if (!(sheet.area > 1e-12 * sheet.length.squaredNorm()))
      throw ComponentError(
          fmt::format("triangle {} (nodes {} {} {}) has no area at rest", e, triangle[0], triangle[1], triangle[2]),
          "triangles with three corners apart");
    const double whole = waveModulus(), mu = young_ * thickness_ / (2 * (1 + poisson_));
    const Vec3 w = Sides::weights(sheet.length);
    Vec3 cotangent;
    for (int i = 0; i < 3; ++i) cotangent[i] = -d[near(i)].dot(d[far(i)]) / (2 * sheet.area);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        sheet.h(i, j) =
            i != j && !angular_ ? 0 : w[i] * w[j] * (cotangent[i] * cotangent[j] * whole + (i == j ? mu : -mu)) / (4 * sheet.area);
    sheets_.push_back(sheet);
  }

  /// A derivative of the tension of side i with respect to the vector of side j, on the corners.
  static void addBlocks(DenseTangent<3>& tangent, int i, int j, const Mat3& block) {
    for (const auto& [row, row_sign] : {std::pair(far(i), 1.), std::pair(near(i), -1.)})
      for (const auto& [column, sign] : {std::pair(far(j), 1.), std::pair(near(j), -1.)})
        tangent.block(int(row), int(column)) += row_sign * sign * block;
  }

  double energyOfArea(std::size_t e, ConstRows x) const {
    const double lost = lossOf(e, normalOf(e, x));
    return 3. / 4 * waveModulus() * sheets_[e].area * lost * lost * lost * lost;
  }
  /// With N = 2 A J n: da/dx_i = n x d_i / 2, and the second derivatives of the area a.
  void addForceOfArea(std::size_t e, ConstRows x, Rows f) {
    const Vec3 normal = normalOf(e, x);
    const double lost = lossOf(e, normal), twice = normal.norm();
    if (lost == 0 || !(twice > 1e-12 * sheets_[e].area)) return;
    const Vec3 n = normal / twice;
    const double slope = 3 * waveModulus() * lost * lost * lost, curve = 9 * waveModulus() * lost * lost / sheets_[e].area;
    const Mat3 across = (Mat3::Identity() - n * n.transpose()) / twice;
    for (int i = 0; i < 3; ++i) {
      const Vec3 gradient = n.cross(vectorOf(e, i, x)) / 2;
      f[rows_[e][std::size_t(i)]] -= slope * gradient;
      for (int j = 0; j < 3; ++j) {
        Mat3 second = -crossMatrix(vectorOf(e, i, x)) * across * crossMatrix(vectorOf(e, j, x)) / 2;
        if (i != j) second += (std::size_t(j) == far(i) ? 0.5 : -0.5) * crossMatrix(n);
        stiffness_[e].block(i, j) -= curve * gradient * (n.cross(vectorOf(e, j, x)) / 2).transpose() + slope * second;
      }
    }
  }
  Vec3 normalOf(std::size_t e, ConstRows x) const { return vectorOf(e, 2, x).cross(-vectorOf(e, 1, x)); }
  /// J - 1 where it is negative.
  double lossOf(std::size_t e, const Vec3& normal) const {
    return resists_ ? std::min(0., normal.norm() / (2 * sheets_[e].area) - 1) : 0;
  }

  TopologyLink topology_;
  double young_ = 1000, poisson_ = 0.3, thickness_ = 1, damping_ratio_ = 0;
  bool angular_ = true, explicit_ = false, resists_ = true;
  enum class Tangent : int { exact, rough } tangent_ = Tangent::exact;
  std::vector<Sheet> sheets_;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(triangular_quadratic_springs_force_field) {
  using namespace stroma;
  factory.add<TriangularSprings<QuadraticSides>>("TriangularQuadraticSpringsForceField",
                                                   "springs along the sides of triangles that make a membrane");
  factory.add<TriangularSprings<BiquadraticSides>>("TriangularBiquadraticSpringsForceField",
                                                    "a membrane of springs over the squares of lengths");
}
