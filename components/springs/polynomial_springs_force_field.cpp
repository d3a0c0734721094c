// SPDX-License-Identifier: LGPL-2.1-or-later
// Springs whose force is a polynomial of their strain.
//
//   P(e) = c_1 e + c_2 e^2 + ... + c_n e^n
//
// PolynomialSpringsForceField, between nodes of one body or of two: with d = x_b - x_a, l = |d|, n = d / l, L the length at
// rest and e = (l - L)/L
//
//   E = L sum_i c_i |e|^(i+1)/(i+1),   f_a = -f_b = P(e) n where e >= 0,   and where e < 0  0, or with compressible -P(|e|) n
//   df_a/dx_a = -(P'(|e|)/L n n^T + P/l (I - n n^T)), with the sign of P in f
//
// L is the distance at the start, or, with computeZeroLength="0", zeroLength.
//
// PolynomialRestShapeSpringsForceField, from nodes to where they rest or to nodes of another body, at the start of the step:
//
//   d = x - t,   l = |d|,   f = -P(l/L) d/m,   m = sqrt(l^2 + exp(smoothShift - smoothScale l^2)),   L = initialLength
//
// a force without a corner at l = 0. It is radial, and its energy is the integral of |f| over l (by Gauss's rule).
//
// polynomialDegree is the number of coefficients in polynomialStiffness for each spring, one after the other; if it does not
// have a number for each spring, all have the first polynomial. Without points every node has a spring.
//
// Source: names and attributes are SOFA's. There the tangent (rough) is -(P'(|e|)/L n n^T + P(|e|)/l (I - n n^T)) whether a spring
// resists or not, and of springs to rest positions -P/m I and, on the diagonal alone,
// -(P'/L - P/m) (1 - smoothScale exp(smoothShift - smoothScale l^2)) d_i^2/m^2.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="50" tolerance="1e-10"/>
//   <MechanicalObject name="dofs" position="0 0 0  1 0 0  2 0.5 0"/>
//   <UniformMass totalMass="0.3"/>
//   <FixedProjectiveConstraint indices="0"/>
//   <PolynomialSpringsForceField firstObjectPoints="0 1" secondObjectPoints="1 2" polynomialDegree="2 2"
//                                polynomialStiffness="200 500  100 300" computeZeroLength="0" zeroLength="1 1"/>
//   <PolynomialRestShapeSpringsForceField points="2" polynomialStiffness="100 50" polynomialDegree="2"/>
// </Node>
#include <fmt/format.h>

#include <cmath>
#include <numeric>

#include "framework/mechanics/drawn_segments.h"
#include "framework/mechanics/node_group_field.h"
#include "framework/mechanics/node_indices.h"
#include "framework/mechanics/node_pairs.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

/// The polynomials of springs: coefficients one after the other.
class Polynomials {
 public:
  void declare(DataTable& table) {
    table.add("polynomialStiffness", coefficients_)
        .recompiled()
        .help("coefficients of the polynomials, from the linear one on")
        .unit("N");
    table.add("polynomialDegree", degrees_).help("how many coefficients each polynomial has");
    table.addChoice("tangent", tangent_, {"exact", "rough"}).help("rough: SOFA's approximation of the derivative");
  }
  /// Throws ComponentError where the lists do not fit each other.
  void check(std::size_t springs) {
    if (degrees_.empty()) throw ComponentError("polynomialDegree is given and empty", "a number for each spring, or one for all");
    for (const int degree : degrees_)
      if (degree < 1) throw ComponentError(fmt::format("polynomialDegree has {}", degree), "numbers from 1 on");
    const std::size_t wanted = std::size_t(std::accumulate(degrees_.begin(), degrees_.end(), 0));
    if (wanted != coefficients_.size())
      throw ComponentError(
          fmt::format("polynomialStiffness has {} coefficients, and polynomialDegree asks for {}", coefficients_.size(), wanted),
          "as many of each");
    for (const double c : coefficients_)
      if (!std::isfinite(c)) throw ComponentError("a coefficient of polynomialStiffness is not finite", "finite numbers");
    starts_.assign(springs, 0), counts_.assign(springs, std::size_t(degrees_[0]));
    if (degrees_.size() != springs) return;
    for (std::size_t i = 1; i < springs; ++i) {
      starts_[i] = starts_[i - 1] + counts_[i - 1];
      counts_[i] = std::size_t(degrees_[i]);
    }
  }
  bool isOneForAll(std::size_t springs) const { return degrees_.size() != springs && degrees_.size() > 1; }

  bool isRough() const { return tangent_ == Tangent::rough; }

  struct Value {
    double p = 0, slope = 0;  ///< P and P'
    double integral = 0;      ///< of P from 0
  };
  Value at(std::size_t spring, double e) const {
    Value value;
    double power = 1;
    for (std::size_t i = 0; i < counts_[spring]; ++i, power *= e) {
      const double c = coefficients_[starts_[spring] + i];
      value.slope += double(i + 1) * c * power;
      value.p += c * power * e;
      value.integral += c * power * e * e / double(i + 2);
    }
    return value;
  }

 private:
  std::vector<double> coefficients_{100};
  std::vector<int> degrees_{1};
  std::vector<std::size_t> starts_, counts_;  ///< shape (springs)
  enum class Tangent : int { exact, rough } tangent_ = Tangent::exact;
};

class PolynomialSpringsForceField final : public NodeGroupField<2, PairTangent>, public DrawnSegments {
 public:
  void declare(DataTable& table) override {
    ForceField::declare(table);
    table.addLink("object1", object1_).help("state of the first ends; the one of this node by default");
    table.addLink("object2", object2_).help("state of the second ends; the one of the first ends by default");
    table.add("firstObjectPoints", first_).help("first node of each spring; every node by default");
    table.add("secondObjectPoints", second_).help("second node of each spring; every node by default");
    polynomials_.declare(table);
    table.add("computeZeroLength", by_start_).help("the length at rest is the distance at the start").min(0).max(1);
    table.add("zeroLength", given_lengths_).help("length at rest, one per spring or one for all").unit("m").min(0, false);
    table.add("compressible", resists_).help("springs that are too short push, as much as they would pull");
    for (const char* name : {"recompute_indices", "drawMode", "showArrowSize", "springColor", "showIndicesScale"})
      table.addVisualOnly(name);
  }

  void init() override {
    setFirstState(object1_, mstate_);
    ForceField::init();
    other_ = object2_.get() ? object2_.get() : &state();
    const auto nodes = [this](const char* name, const std::vector<int>& given, const State& whose) {
      return data().find(name)->isSet() ? checkedNodesInOrder(given, whose, name) : allNodes(whose);
    };
    ends_.clear();
    const std::vector<Index> one = nodes("firstObjectPoints", first_, state()), two = nodes("secondObjectPoints", second_, *other_);
    if (one.size() != two.size())
      throw ComponentError(fmt::format("there are {} first and {} second points", one.size(), two.size()), "as many of each");
    for (std::size_t i = 0; i < one.size(); ++i) {
      if (other_ == &state() && one[i] == two[i])
        throw ComponentError(fmt::format("spring {} joins node {} to itself", i, one[i] / state().rows_per_node),
                             "two different nodes");
      ends_.push_back({one[i], two[i]});
    }
    polynomials_.check(ends_.size());
    if (polynomials_.isOneForAll(ends_.size()))
      inform(fmt::format("polynomialDegree has no number for each of the {} springs: all have the first polynomial", ends_.size()));
    findLengths();
  }

  std::vector<State*> states() const override {
    return other_ == &state() ? std::vector<State*>{&state()} : std::vector<State*>{&state(), other_};
  }
  ForceTraits traits() const override {
    ForceTraits traits;
    traits.symmetric = traits.conservative = true;
    traits.exact_tangent = !polynomials_.isRough();
    return traits;
  }
  void compile() override {
    std::vector<Group> rows;
    for (const Group& pair : ends_) rows.push_back({state().firstRow() + pair[0], other_->firstRow() + pair[1]});
    setGroups(std::move(rows), false);
  }

  double energy(ConstRows x) const override {
    double sum = 0;
    for (std::size_t s = 0; s < ends_.size(); ++s) {
      const double e = (x[rows_[s][1]] - x[rows_[s][0]]).norm() / lengths_[s] - 1;
      if (e >= 0 || resists_) sum += lengths_[s] * polynomials_.at(s, std::abs(e)).integral;
    }
    return sum;
  }
  void addForce(ConstRows x, ConstRows, Rows f) override {
    for (std::size_t s = 0; s < ends_.size(); ++s) {
      const auto [a, b] = rows_[s];
      const Vec3 d = x[b] - x[a];
      const double length = d.norm(), e = length / lengths_[s] - 1;
      stiffness_[s].setZero();
      const bool acts = e >= 0 || resists_;
      if (!(length > 1e-12 * lengths_[s]) || (!acts && !polynomials_.isRough())) continue;  // ends that meet have no direction
      const Polynomials::Value value = polynomials_.at(s, std::abs(e));
      const double tension = !acts ? 0 : e < 0 ? -value.p : value.p;
      const Vec3 n = d / length;
      f[a] += tension * n;
      f[b] -= tension * n;
      const Mat3 along = n * n.transpose();
      const double across = polynomials_.isRough() ? value.p : tension;
      stiffness_[s].k = -(value.slope / lengths_[s] * along + across / length * (Mat3::Identity() - along));
    }
  }

  void addSegments(std::vector<Segment>& segments) const override {
    for (const Group& pair : ends_) segments.push_back({&state(), pair[0], other_, pair[1]});
  }

 protected:
  bool takesAllRows() const override { return true; }  // a spring ends at the centre of a frame

 private:
  void findLengths() {
    if (by_start_ == 0) {
      if (given_lengths_.empty()) throw ComponentError("there is no length at rest", "zeroLength, or computeZeroLength=\"1\"");
      lengths_ = given_lengths_;
      return spread(lengths_, ends_.size(), "zeroLength", "springs");
    }
    lengths_.clear();
    for (std::size_t s = 0; s < ends_.size(); ++s) {
      lengths_.push_back((other_->position[std::size_t(ends_[s][1])] - state().position[std::size_t(ends_[s][0])]).norm());
      if (!(lengths_[s] > 0))
        throw ComponentError(fmt::format("the ends of spring {} are one place: it has no length at rest", s),
                             "ends apart, or zeroLength with computeZeroLength=\"0\"");
    }
  }

  Link<State> object1_{"mechanical state"}, object2_{"mechanical state"};
  std::vector<int> first_, second_;
  Polynomials polynomials_;
  int by_start_ = 1;
  bool resists_ = false;
  std::vector<double> given_lengths_, lengths_;  ///< [m]
  State* other_ = nullptr;
  std::vector<Group> ends_;  ///< first rows of the nodes in their states
};

class PolynomialRestShapeSprings final : public NodeGroupField<1>, public DrawnSegments {
 public:
  void declare(DataTable& table) override {
    ForceField::declare(table);
    table.add("points", points_).help("nodes with a spring; every node by default");
    table.addLink("external_rest_shape", external_).help("state whose nodes are the targets");
    table.add("external_points", external_points_).help("its nodes, one for each point");
    polynomials_.declare(table);
    table.add("initialLength", lengths_)
        .recompiled()
        .help("length over which the strain is taken, one per point or one for all")
        .unit("m")
        .min(0, false);
    table.add("smoothShift", shift_)
        .recompiled()
        .help("logarithm of the square of the length that rounds the corner at the target");
    table.add("smoothScale", scale_).recompiled().help("how fast the rounding ends with the square of the length").min(0);
    for (const char* name : {"recompute_indices", "drawSpring", "springColor", "showIndicesScale"}) table.addVisualOnly(name);
  }

  void init() override {
    ForceField::init();
    nodes_ = data().find("points")->isSet() ? checkedNodesInOrder(points_, state(), "points") : allNodes(state());
    polynomials_.check(nodes_.size());
    if (polynomials_.isOneForAll(nodes_.size()))
      inform(fmt::format("polynomialDegree has no number for each of the {} points: all have the first polynomial", nodes_.size()));
    if (lengths_.empty()) throw ComponentError("initialLength is given and empty", "a length for each point, or one for all");
    length_of_ = lengths_;
    spread(length_of_, nodes_.size(), "initialLength", "points");
    findTargets();
  }

  ForceTraits traits() const override {
    ForceTraits traits;
    traits.symmetric = traits.conservative = true;
    traits.exact_tangent = !polynomials_.isRough();
    traits.time_dependent = external_.target() != nullptr;
    return traits;
  }
  void compile() override { setNodes(nodes_, false); }
  void setTime(double) override {
    const State& other = *external_.get();
    for (std::size_t i = 0; i < nodes_.size(); ++i)
      targets_[i] = other.isBound() ? Vec3(other.x()[external_nodes_[i]]) : other.position[std::size_t(external_nodes_[i])];
  }

  double energy(ConstRows x) const override {
    double sum = 0;
    for (std::size_t i = 0; i < nodes_.size(); ++i) sum += workTo((x[rows_[i][0]] - targets_[i]).norm(), i);
    return sum;
  }
  void addForce(ConstRows x, ConstRows, Rows f) override {
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      const Vec3 d = x[rows_[i][0]] - targets_[i];
      const double l = d.norm();
      const auto [pull, slope, over_length] = pullAt(l, i);
      f[rows_[i][0]] -= over_length * d;
      if (polynomials_.isRough()) {
        stiffness_[i].blocks[0] = -roughSlopes(d, i);
        continue;
      }
      const Mat3 along = l > 0 ? Mat3(d * d.transpose() / (l * l)) : Mat3(Mat3::Zero());
      stiffness_[i].blocks[0] = -(over_length * Mat3::Identity() + (l > 0 ? slope - over_length : 0) * along);
    }
  }

  /// To the nodes of another body; a place at rest is no node.
  void addSegments(std::vector<Segment>& segments) const override {
    if (const State* other = external_.get())
      for (std::size_t i = 0; i < nodes_.size(); ++i) segments.push_back({&state(), nodes_[i], other, external_nodes_[i]});
  }

 protected:
  bool takesAllRows() const override { return true; }  // of frames the centres

 private:
  struct Pull {
    double force, slope, over_length;  ///< |f| [N], d|f|/dl and |f|/l [N/m]
  };
  Pull pullAt(double l, std::size_t i) const {
    const double rounding = std::exp(shift_ - scale_ * l * l), m = std::sqrt(l * l + rounding);
    const Polynomials::Value value = polynomials_.at(i, l / length_of_[i]);
    if (!(m > 0)) return {0, 0, 0};
    const double share = l / m, m_slope = share * (1 - scale_ * rounding);
    return {value.p * share, value.slope / length_of_[i] * share + value.p * (1 - share * m_slope) / m, value.p / m};
  }
  Mat3 roughSlopes(const Vec3& d, std::size_t i) const {
    const double l = d.norm(), rounding = std::exp(shift_ - scale_ * l * l), m = std::sqrt(l * l + rounding);
    const Polynomials::Value value = polynomials_.at(i, l / length_of_[i]);
    if (!(m > 0)) return Mat3::Zero();
    const double share = (value.slope / length_of_[i] - value.p / m) * (1 - scale_ * rounding);
    return (share * d.cwiseProduct(d) / (m * m) + Vec3::Constant(value.p / m)).asDiagonal();
  }
  /// The integral of the pull from 0 to l: Gauss's rule of 8 points on pieces shorter than the rounding.
  double workTo(double l, std::size_t i) const {
    static constexpr double points[] = {0.1834346424956498, 0.5255324099163290, 0.7966664774136267, 0.9602898564975363};
    static constexpr double weights[] = {0.3626837833783620, 0.3137066458778873, 0.2223810344533745, 0.1012285362903763};
    const int pieces = int(std::min(64., 1 + std::floor(2 * l * (std::sqrt(scale_) + std::exp(-shift_ / 2)))));
    const double half = l / (2 * pieces);
    double sum = 0;
    for (int piece = 0; piece < pieces; ++piece)
      for (int k = 0; k < 4; ++k)
        for (const double side : {-1., 1.}) sum += half * weights[k] * pullAt(half * (2 * piece + 1 + side * points[k]), i).force;
    return sum;
  }

  void findTargets() {
    const State* other = external_.get();
    const bool listed = data().find("external_points")->isSet();
    if (!other && listed)
      throw ComponentError("external_points names nodes of another state, and external_rest_shape is not given",
                           "external_rest_shape=\"@path/of/a/MechanicalObject\"");
    targets_.clear(), external_nodes_.clear();
    if (!other) {
      for (const Index node : nodes_) targets_.push_back(state().rest_position[std::size_t(node)]);
      return;
    }
    external_nodes_ = listed ? checkedNodesInOrder(external_points_, *other, "external_points") : allNodes(*other);
    if (external_nodes_.size() != nodes_.size())
      throw ComponentError(fmt::format("there are {} targets for {} points", external_nodes_.size(), nodes_.size()),
                           "as many of each");
    for (const Index node : external_nodes_) targets_.push_back(other->position[std::size_t(node)]);
  }

  std::vector<int> points_, external_points_;
  Link<State> external_{"mechanical state"};
  Polynomials polynomials_;
  std::vector<double> lengths_{1}, length_of_;
  double shift_ = 0, scale_ = 1;
  std::vector<Index> nodes_, external_nodes_;  ///< shape (points)
  std::vector<Vec3> targets_;                  ///< [m], shape (points)
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(polynomial_springs_force_field) {
  factory.add<stroma::PolynomialSpringsForceField>("PolynomialSpringsForceField",
                                                   "springs whose force is a polynomial of their strain");
  factory.add<stroma::PolynomialRestShapeSprings>("PolynomialRestShapeSpringsForceField",
                                                  "springs to rest positions whose force is a polynomial");
}
