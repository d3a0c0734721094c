// SPDX-License-Identifier: LGPL-2.1-or-later
// FixedLagrangianConstraint: points or rigid frames that stay at their initial position, by forces that can be read.
// FixedProjectiveConstraint fixes nodes at less cost; this one also fixes mapped nodes, such as those of an embedded surface
// or on a rigid frame.
//
//   x - x_0 = 0,           three rows for each point; with atRest x_0 is its rest position
//   log(q q_0^-1) = 0,     three more for a frame
//
// Source: the names and attributes are SOFA's.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <SparseLDLSolver/>
//   <MechanicalObject position="0 0 0  1 0 0"/>
//   <UniformMass totalMass="2"/>
//   <SpringForceField springsIndices1="0" springsIndices2="1" lengths="1" stiffness="200"/>
//   <FixedLagrangianConstraint indices="0"/>
// </Node>
#include "components/lagrangian/pair_constraint.h"
#include "framework/mechanics/frames.h"
#include "framework/scene/archive.h"
#include "framework/scene/factory.h"

namespace stroma::lagrangian {
namespace {

class Fixed final : public PairConstraint {
 public:
  void declare(DataTable& table) override {
    declareOneState(table);
    table.add("indices", nodes_).help("points");
    table.add("fixAll", all_).help("all points");
    table.add("atRest", at_rest_).help("they go to where they rest, as in SOFA, and do not stay where they start");
  }
  void init() override {
    PairConstraint::init();
    held_ = nodes_;
    if (all_) {
      held_.clear();
      for (Index i = 0; i < first().nodes(); ++i) held_.push_back(i);
    }
    for (const Index node : held_) checkNode(first(), node, "indices");
    places_.clear(), turns_.clear();
  }
  void constrainedStepBegins(ConstRows x, double) override {
    if (!places_.empty()) return;
    for (const Index node : held_) {
      const Index row = rowOf(first(), node);
      const Vec3* rest = first().rest_position.data() + (row - first().firstRow());
      places_.push_back(at_rest_ ? *rest : Vec3(x[row]));
      if (first().hasFrames()) turns_.push_back(at_rest_ ? turnedBy(rest[1]) : orientationIn(x, row + 1));
    }
  }
  void addConditions(ConstRows x, ConstRows, LagrangianRows& rows) const override {
    for (std::size_t i = 0; i < places_.size(); ++i) {
      const Index row = rowOf(first(), held_[i]);
      add(row, Vec3(x[row]) - places_[i], rows);
      if (first().hasFrames()) add(row + 1, rotationVector(orientationIn(x, row + 1) * turns_[i].conjugate()), rows);
    }
  }
  void reset() override {
    PairConstraint::reset();
    places_.clear(), turns_.clear();
  }
  void serialize(Archive& archive) override {
    PairConstraint::serialize(archive);
    archive.list("places", places_);
    archive.list("turns", turns_);
  }

 protected:
  Nodes nodes() const override { return Nodes::points_or_frames; }

 private:
  static void add(Index row, const Vec3& off, LagrangianRows& rows) {
    for (int k = 0; k < 3; ++k) {
      rows.begin(Kind::equal, off[k]);
      rows.add(row, Vec3::Unit(k));
    }
  }

  std::vector<Index> nodes_{0}, held_;
  bool all_ = false, at_rest_ = false;
  std::vector<Vec3> places_;       ///< where they started [m]
  std::vector<Quaternion> turns_;  ///< and how, of frames
};

}  // namespace
}  // namespace stroma::lagrangian

STROMA_COMPONENT(fixed_lagrangian_constraint) {
  factory.add<stroma::lagrangian::Fixed>("FixedLagrangianConstraint", "points that stay where they start, mapped ones too");
}
