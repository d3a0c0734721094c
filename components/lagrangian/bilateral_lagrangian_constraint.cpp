// SPDX-License-Identifier: LGPL-2.1-or-later
// BilateralLagrangianConstraint: pairs of points, of two bodies or of one, that stay together at the end of each step; or pairs
// of rigid frames, whose orientations stay together too.
//
//   x_second - x_first - rest_vector = 0,   three rows for each pair
//   log(q_second (q_first r)^-1) = 0,       three more for frames: r = 1, or what q_second is more than q_first at the start
//                                           with keepOrientationDifference; a rest_vector of six numbers is taken off too
//
// With keepCentreDifference the difference of the centres of frames at the start stays too, in fixed axes, whatever rest_vector is.
//
// DistanceLagrangianConstraint: pairs that keep their distance d, the initial one unless `distances` gives it.
//
//   |x_second - x_first| - d = 0,   one row for each pair
//
// Forces are found with the matrix of the step (components/integrators/multipliers.h), in rounds until the conditions hold to
// round-off, and are equal and opposite: momentum is conserved. `forces` has them row by row.
//
// Source: the names and attributes of the first are SOFA's.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <SparseLDLSolver/>
//   <MechanicalObject name="dofs" position="0 0 0  1 0 0  1 0 0  2 0 0"/>
//   <UniformMass totalMass="4"/>
//   <FixedProjectiveConstraint indices="0"/>
//   <DistanceLagrangianConstraint first_point="0 2" second_point="1 3"/>
//   <BilateralLagrangianConstraint first_point="1" second_point="2"/>
// </Node>
#include <fmt/format.h>

#include "components/lagrangian/pair_constraint.h"
#include "framework/mechanics/frames.h"
#include "framework/scene/archive.h"
#include "framework/scene/factory.h"

namespace stroma::lagrangian {
namespace {

class Pairs : public PairConstraint {
 public:
  void declare(DataTable& table) override {
    PairConstraint::declare(table);
    table.add("first_point", first_points_).alias("firstPoint").help("points of object1");
    table.add("second_point", second_points_).alias("secondPoint").help("points of object2, one for each first_point");
    table.add("activate", active_).atOnce().help("false: it is not active");
  }
  void init() override {
    PairConstraint::init();
    if (first_points_.size() != second_points_.size())
      throw ComponentError(
          fmt::format("first_point has {} points and second_point {}", first_points_.size(), second_points_.size()),
          "as many of each");
    for (std::size_t i = 0; i < first_points_.size(); ++i) {
      checkNode(first(), first_points_[i], "first_point"), checkNode(second(), second_points_[i], "second_point");
      if (&first() == &second() && first_points_[i] == second_points_[i])
        throw ComponentError(fmt::format("pair {} is node {} twice", i, first_points_[i]), "two points");
    }
  }

 protected:
  std::size_t count() const { return active_ ? first_points_.size() : 0; }
  Index a(std::size_t pair) const { return rowOf(first(), first_points_[pair]); }
  Index b(std::size_t pair) const { return rowOf(second(), second_points_[pair]); }
  bool startsAtOnePlace(std::size_t pair) const {
    return first().position[std::size_t(first_points_[pair])] == second().position[std::size_t(second_points_[pair])];
  }
  std::size_t pairs() const { return first_points_.size(); }

 private:
  std::vector<Index> first_points_{0}, second_points_{0};
  bool active_ = true;
};

class Bilateral final : public Pairs {
 public:
  void declare(DataTable& table) override {
    Pairs::declare(table);
    table.add("rest_vector", rest_)
        .help("offset of the second point from the first; one for each pair, for frames also two, position and rotation; none: zero")
        .unit("m");
    table.add("keepOrientationDifference", keeps_turn_)
        .help("of frames: they keep the orientation that they start with to each other");
    table.add("keepCentreDifference", keeps_place_)
        .help("of frames: they keep the difference of places that they start with, as SOFA's");
  }
  void init() override {
    Pairs::init();
    const bool has_turns = first().hasFrames() && rest_.size() == 2 * pairs();
    if (!rest_.empty() && rest_.size() != pairs() && !has_turns)
      throw ComponentError(fmt::format("rest_vector has {} vectors for {} pairs", rest_.size(), pairs()), "one for each pair");
    width_ = has_turns ? 2 : 1;
    if (keepsPlaces() && !rest_.empty())
      warn("rest_vector has no effect: with keepCentreDifference pairs stay as they are at the start", "one of the two");
    if (keeps_turn_ && !first().hasFrames()) warn("keepOrientationDifference has no effect: points do not turn", "states of frames");
    turns_.clear(), places_.clear();
  }
  void constrainedStepBegins(ConstRows x, double) override {
    for (std::size_t i = places_.size(); keepsPlaces() && i < pairs(); ++i) places_.push_back(Vec3(x[b(i)]) - Vec3(x[a(i)]));
    if (!turns_.empty() || !first().hasFrames()) return;
    for (std::size_t i = 0; i < pairs(); ++i)
      turns_.push_back(keeps_turn_ ? orientationIn(x, a(i) + 1).conjugate() * orientationIn(x, b(i) + 1)
                                   : Quaternion::Identity());
  }
  void addConditions(ConstRows x, ConstRows, LagrangianRows& rows) const override {
    for (std::size_t i = 0; i < count(); ++i) {
      add(i, 0, Vec3(x[b(i)]) - Vec3(x[a(i)]) - restOf(i, 0), rows);
      if (!first().hasFrames()) continue;
      const Quaternion wanted = orientationIn(x, a(i) + 1) * turns_[i];
      add(i, 1, rotationVector(orientationIn(x, b(i) + 1) * wanted.conjugate()) - restOf(i, 1), rows);
    }
  }
  void reset() override {
    Pairs::reset();
    turns_.clear(), places_.clear();
  }
  void serialize(Archive& archive) override {
    Pairs::serialize(archive);
    archive.list("turns", turns_);
    if (keepsPlaces()) archive.list("places", places_);
  }

 protected:
  Nodes nodes() const override { return Nodes::points_or_frames; }

 private:
  bool keepsPlaces() const { return keeps_place_ && first().hasFrames(); }
  Vec3 restOf(std::size_t pair, std::size_t row) const {
    if (keepsPlaces()) return row == 0 ? places_[pair] : Vec3(Vec3::Zero());
    return rest_.empty() || row >= width_ ? Vec3(Vec3::Zero()) : rest_[pair * width_ + row];
  }
  void add(std::size_t pair, Index row, const Vec3& off, LagrangianRows& rows) const {
    for (int k = 0; k < 3; ++k) {
      rows.begin(Kind::equal, off[k]);
      rows.add(a(pair) + row, -Vec3::Unit(k)), rows.add(b(pair) + row, Vec3::Unit(k));
    }
  }

  std::vector<Vec3> rest_;
  std::size_t width_ = 1;  ///< of rest_, of each pair
  bool keeps_turn_ = false, keeps_place_ = false;
  std::vector<Quaternion> turns_;  ///< r of each pair
  std::vector<Vec3> places_;       ///< differences of the start [m], shape (pairs)
};

class Distance final : public Pairs {
 public:
  void declare(DataTable& table) override {
    Pairs::declare(table);
    table.add("distances", distances_).help("distances; those of the start by default").unit("m").min(0, false);
  }
  void init() override {
    Pairs::init();
    if (!distances_.empty() && distances_.size() != pairs())
      throw ComponentError(fmt::format("distances has {} numbers for {} pairs", distances_.size(), pairs()),
                           "one for each pair");
    kept_ = distances_;
    // where mapped points are is known when the first step begins
    for (std::size_t i = 0; distances_.empty() && &first() == &second() && i < pairs(); ++i)
      if (startsAtOnePlace(i))
        throw ComponentError(fmt::format("the points of pair {} start at one place", i), "a distance above zero");
  }
  void constrainedStepBegins(ConstRows x, double) override {
    for (std::size_t i = kept_.size(); i < pairs(); ++i) kept_.push_back((Vec3(x[b(i)]) - Vec3(x[a(i)])).norm());
  }
  void addConditions(ConstRows x, ConstRows, LagrangianRows& rows) const override {
    for (std::size_t i = 0; i < count(); ++i) {
      const Vec3 way = Vec3(x[b(i)]) - Vec3(x[a(i)]);
      const double length = way.norm();
      const Vec3 n = length > 0 ? Vec3(way / length) : Vec3(Vec3::UnitX());
      rows.begin(Kind::equal, length - kept_[i]);
      rows.add(a(i), -n), rows.add(b(i), n);
      if (length > 0) addTurning(n, a(i), b(i), -1 / length, rows);
    }
  }
  void reset() override {
    Pairs::reset();
    kept_ = distances_;
  }
  void serialize(Archive& archive) override {
    Pairs::serialize(archive);
    archive.list("kept", kept_);
  }

 private:
  std::vector<double> distances_, kept_;
};

}  // namespace
}  // namespace stroma::lagrangian

STROMA_COMPONENT(bilateral_lagrangian_constraint) {
  using namespace stroma::lagrangian;
  factory.add<Bilateral>("BilateralLagrangianConstraint", "points of two bodies that stay together");
  factory.add<Distance>("DistanceLagrangianConstraint", "points that keep their distance");
}
