// SPDX-License-Identifier: LGPL-2.1-or-later
// LennardJonesForceField: all nodes of a state attract each other at large and repel at small distances.
//
//   t(d) = a alpha d^(-alpha-1) - b beta d^(-beta-1),   a = p0 d0^alpha / (1 - alpha/beta),   b = p0 d0^beta / (beta/alpha - 1)
//   f_i = (t(d) n + c (v_j - v_i)) for each j with d < dmax,   d = |x_j - x_i|,   n = (x_j - x_i)/d
//   df_i/dx_i = -(t' n n^T + t/d (I - n n^T))
//
// d0 is the distance of zero force, and p0 the depth of the potential -a d^-alpha + b d^-beta there. fmax bounds attraction,
// not repulsion. With p0 below 0 near nodes attract and far ones repel each other. At dmax the force jumps to zero, which the
// energy does not include. c is `damping`. With aInit: masses that attract each other, t = aInit alpha/d^2, with beta = 0. The
// work grows with the square of the number of nodes, and the matrix is full.
//
// Source: J. E. Jones, On the determination of molecular fields (1924); names, attributes and defaults are SOFA's. There the tangent
// (rough) lacks t/d (I - n n^T), and damping is no part of the matrix (explicitDamping).
//
// Example:
// <Node name="root" dt="0.005" gravity="0 0 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="50" tolerance="1e-10"/>
//   <MechanicalObject position="0 0 0  1.1 0 0  0.5 0.9 0  0.6 0.4 1"/>
//   <UniformMass totalMass="4"/>
//   <LennardJonesForceField d0="1" p0="1" dmax="3" fmax="2" damping="0.1"/>
// </Node>
#include <cmath>
#include <limits>

#include "framework/mechanics/node_group_field.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class LennardJones final : public NodeGroupField<2, PairTangent> {
 public:
  void declare(DataTable& table) override {
    ForceField::declare(table);
    table.add("alpha", alpha_).help("exponent of the attraction").unit("-").min(0, false);
    table.add("beta", beta_).help("exponent of the repulsion, more than alpha; 0 with aInit").unit("-").min(0);
    table.add("d0", distance_).help("distance of no force").unit("m").min(0, false);
    table.add("p0", depth_).help("depth of the potential").unit("J");
    table.add("dmax", reach_).help("distance from which on nodes do not feel each other").unit("m").min(0, false);
    table.add("fmax", most_).help("the largest attraction").unit("N").min(0);
    table.add("damping", damping_per_speed_).help("damping of each pair").unit("N s/m").min(0);
    table.add("aInit", gravity_).help("gravitational attraction G m_1 m_2, instead of the other terms").unit("N m^2");
    table.add("explicitDamping", is_explicit_).help("damping is no part of the matrix, as in SOFA");
    table.addChoice("tangent", tangent_, {"exact", "rough"}).help("rough: SOFA's approximation of the derivative");
  }

  void init() override {
    ForceField::init();
    if (!state().hasPointsOnly()) throw ComponentError(state().path() + " has other nodes than points", "points");
    a_ = gravity_, b_ = 0;
    first_ = last_ = std::numeric_limits<double>::infinity();
    if (gravity_ != 0) {
      if (beta_ != 0 || alpha_ != 1) throw ComponentError("with aInit the force is that of masses", "alpha=\"1\" beta=\"0\"");
      if (gravity_ > 0) first_ = 0, last_ = std::sqrt(gravity_ / most_);
      return;
    }
    if (!(beta_ > alpha_)) throw ComponentError("beta is not above alpha: nothing would repel nodes", "beta=\"12\" with alpha=\"6\"");
    a_ = depth_ * std::pow(distance_, alpha_) / (1 - alpha_ / beta_), b_ = depth_ * std::pow(distance_, beta_) / (beta_ / alpha_ - 1);
    const double steepest = distance_ * std::pow((beta_ + 1) / (alpha_ + 1), 1 / (beta_ - alpha_));
    if (depth_ < 0) last_ = whereEnough(distance_), first_ = 0;
    if (depth_ > 0 && attraction(steepest) > most_) {
      first_ = whereMost(distance_, steepest);
      last_ = whereMost(steepest, 0);
    }
  }
  ForceTraits traits() const override {
    ForceTraits traits;
    traits.symmetric = true;
    traits.conservative = damping_per_speed_ == 0;
    traits.exact_tangent = tangent_ == Tangent::exact;
    traits.velocity_dependent = damping_per_speed_ != 0 && !is_explicit_;
    return traits;
  }
  void compile() override {
    std::vector<Group> pairs;
    const Index first = state().firstRow();
    for (Index j = 1; j < state().size(); ++j)
      for (Index i = 0; i < j; ++i) pairs.push_back({first + i, first + j});
    setGroups(std::move(pairs), damping_per_speed_ != 0 && !is_explicit_);
  }

  double energy(ConstRows x) const override {
    double sum = 0;
    for (const Group& pair : rows_)
      if (const double d = (x[pair[1]] - x[pair[0]]).norm(); d < reach_ && d > 0) sum += work(d) - work(reach_);
    return sum;
  }
  void addForce(ConstRows x, ConstRows v, Rows f) override {
    for (std::size_t p = 0; p < rows_.size(); ++p) {
      const auto [i, j] = rows_[p];
      stiffness_[p].setZero();
      if (!damping_.empty()) damping_[p].setZero();
      const Vec3 way = x[j] - x[i];
      const double d = way.norm();
      if (!(d < reach_) || !(d > 0)) continue;  // nodes that meet have no direction
      const bool is_cut = d > first_ && d < last_;
      const double t = is_cut ? most_ : attraction(d), slope = is_cut ? 0 : -((alpha_ + 1) * pull(d) - (beta_ + 1) * push(d)) / d;
      const Vec3 n = way / d;
      const Vec3 force = t * n + damping_per_speed_ * (v[j] - v[i]);
      f[i] += force, f[j] -= force;
      const Mat3 along = n * n.transpose();
      stiffness_[p].k = -slope * along;
      if (tangent_ == Tangent::exact) stiffness_[p].k -= t / d * (Mat3::Identity() - along);
      if (!damping_.empty()) damping_[p].k = -damping_per_speed_ * Mat3::Identity();
    }
  }

 private:
  double pull(double d) const { return gravity_ != 0 ? a_ * alpha_ / (d * d) : a_ * alpha_ * std::pow(d, -alpha_ - 1); }
  double push(double d) const { return b_ == 0 ? 0 : b_ * beta_ * std::pow(d, -beta_ - 1); }
  double attraction(double d) const { return pull(d) - push(d); }
  double potential(double d) const { return -a_ * std::pow(d, -alpha_) + (b_ == 0 ? 0 : b_ * std::pow(d, -beta_)); }
  /// The potential with the largest attraction between first_ and last_.
  double work(double d) const {
    if (d <= first_) return potential(d);
    const double from = first_ > 0 ? potential(first_) : 0;
    if (d < last_) return from + most_ * (d - first_);
    return from + most_ * (last_ - first_) + potential(d) - potential(last_);
  }
  /// Where the attraction, which falls from d = 0 to none at `high`, is fmax.
  double whereEnough(double high) const {
    double low = 0;
    for (int i = 0; i < 100; ++i) {
      const double middle = (low + high) / 2;
      (attraction(middle) > most_ ? low : high) = middle;
    }
    return high;
  }
  /// Where the attraction is fmax: from `low` on it rises until `high`, or (0) falls for ever.
  double whereMost(double low, double high) const {
    const bool rises = high > 0;
    if (!rises)
      for (high = 2 * low; attraction(high) > most_ && high < reach_;) high *= 2;
    for (int i = 0; i < 100; ++i) {
      const double middle = (low + high) / 2;
      ((attraction(middle) < most_) == rises ? low : high) = middle;
    }
    return low;
  }

  double alpha_ = 6, beta_ = 12, distance_ = 1, depth_ = 1, reach_ = 2, most_ = 1, damping_per_speed_ = 0, gravity_ = 0;
  bool is_explicit_ = false;
  enum class Tangent : int { exact, rough } tangent_ = Tangent::exact;
  double a_ = 0, b_ = 0;
  double first_ = 0, last_ = 0;  ///< distances between which the attraction is cut [m]
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(lennard_jones_force_field) {
  factory.add<stroma::LennardJones>("LennardJonesForceField", "nodes that all attract each other, and keep apart");
}
