// SPDX-License-Identifier: LGPL-2.1-or-later
// CableConstraint: a cable through points of a body, which is pulled at pullPoint. It slides through the points without
// friction, so that one tension T acts along all of it.
//
//   L(x) = |x_1 - pullPoint| + sum |x_i+1 - x_i|,   L_0 = L(rest positions) unless cableInitialLength is given;
//   of mapped nodes where they start
//   valueType displacement: L = L_0 - value, and T is what that takes, between minForce and maxForce where they are given
//   valueType force:        T = value, while -maxNegativeDisp <= L_0 - L <= maxPositiveDisp where they are given
//
// At minForce L may be less than L_0 - value (with 0 the cable is slack and does not push), at maxForce more. At
// maxPositiveDisp T is less than value, at -maxNegativeDisp more. maxDispVariation bounds the change of the imposed
// displacement from one step to the next.
//
// T and the displacement L_0 - L are `force` and `displacement`. Neither depends on the time step: T is a force, and the
// condition holds at the end of every step. Without pullPoint (hasPullPoint off) the cable ends at its first point.
//
// Source: the names and attributes are those of SOFA's plugin SoftRobots, where forces are T times the time step.
//
// Example:
// <Node name="root" dt="0.01">
//   <EulerImplicitSolver/>
//   <SparseLDLSolver/>
//   <MechanicalObject position="0 0 0  1 0 0  2 0 0"/>
//   <UniformMass totalMass="3"/>
//   <RestShapeSpringsForceField stiffness="100"/>
//   <CableConstraint indices="1 2" pullPoint="-1 0 0" valueType="displacement" value="0.1" minForce="0"/>
// </Node>
#include <fmt/format.h>

#include <algorithm>

#include "components/lagrangian/actuator.h"
#include "framework/mechanics/mapping.h"
#include "framework/scene/archive.h"
#include "framework/scene/factory.h"
#include "framework/scene/node.h"

namespace stroma::lagrangian {
namespace {

class Cable final : public Actuator {
 public:
  void declare(DataTable& table) override {
    declareOneState(table);
    table.add("indices", nodes_).required().help("points that the cable runs through, from its pulled end on");
    table.add("pullPoint", pull_).atOnce().help("where it is pulled; L_0 is unchanged if that moves during a run").unit("m");
    table.add("hasPullPoint", has_pull_).help("false: it ends at the first of indices");
    table.add("method", method_).help("point: forces act on the points themselves");
    declareValue(table, "displacement", "force", true, "displacement [m] or force [N]");
    table.add("minForce", least_force_).recompiled().help("least tension; 0: it does not push. Without it, none").unit("N");
    table.add("maxForce", most_force_).recompiled().help("largest tension; without it, none").unit("N");
    table.add("maxPositiveDisp", most_way_).recompiled().help("largest displacement; without it, none").unit("m");
    table.add("maxNegativeDisp", least_way_).recompiled().help("largest displacement the other way; without it, none").unit("m");
    table.add("maxDispVariation", change_)
        .recompiled()
        .help("largest change of the imposed displacement in a step; without it, none")
        .unit("m")
        .min(0);
    table.add("force", told_force_).help("tension of the last step").unit("N").output();
    table.add("displacement", way_).help("pulled length after the last step").unit("m").output();
    table.add("cableInitialLength", start_length_).help("L_0; that of the rest positions by default").unit("m").min(0);
    table.add("cableLength", length_).help("length after the last step").unit("m").output();
    for (const char* name : {"drawPullPoint", "drawPoints", "drawPulledAreas", "color"}) table.addVisualOnly(name);
  }
  void init() override {
    Actuator::init();
    for (const Index node : nodes_) checkNode(first(), node, "indices");
    if (nodes_.empty() || (nodes_.size() == 1 && !has_pull_))
      throw ComponentError("the cable has no length", "two points, or one and a pullPoint");
    for (std::size_t i = 1; i < nodes_.size(); ++i)
      if (nodes_[i] == nodes_[i - 1])
        throw ComponentError(fmt::format("indices has point {} twice in a row", nodes_[i]), "the points one after the other");
    if (method_ != "point")
      throw ComponentError(fmt::format("method is {}: the cable acts on points only", method_), "point",
                           "points that follow the surface by a BarycentricMapping");
    bound({-written("maxNegativeDisp", least_way_, infinity), written("maxPositiveDisp", most_way_, infinity),
           written("maxDispVariation", change_, infinity)},
          {written("minForce", least_force_, -infinity), written("maxForce", most_force_, infinity)});
    if (hasLength()) startAt(-start_length_);
  }
  void constrainedStepBegins(ConstRows x, double t_end) override {
    Actuator::constrainedStepBegins(x, t_end);
    start_length_ = 0 - start_;  // no -0 where nothing has been measured yet
  }
  void takeForces(std::span<const double> forces) override {
    Actuator::takeForces(forces);
    length_ = start_length_ - way_;
  }
  void reset() override {
    Actuator::reset();
    if (hasLength()) startAt(-start_length_);
  }
  void serialize(Archive& archive) override {
    Actuator::serialize(archive);
    archive.value("length", length_);
    start_length_ = 0 - start_;
  }

 protected:
  double measure(ConstRows x) const override {
    return -lengthOf([&](Index node) { return Vec3(x[rowOf(first(), node)]); });
  }
  /// Mapped nodes are measured where they start: what is written for them may be in the axes of a frame.
  double measureAtStart(ConstRows x) const override {
    std::vector<Mapping*> mappings;
    node().root().collect(mappings);
    if (std::any_of(mappings.begin(), mappings.end(), [this](Mapping* m) { return &m->output() == &first(); })) return measure(x);
    return -lengthOf([this](Index node) { return first().rest_position[std::size_t(node * first().rows_per_node)]; });
  }
  void addGradient(ConstRows x, double sign, LagrangianRows& rows) const override {
    Vec3 before = has_pull_ ? pull_ : Vec3(x[rowOf(first(), nodes_.front())]);
    Index row_before = has_pull_ ? -1 : rowOf(first(), nodes_.front());
    for (std::size_t i = has_pull_ ? 0 : 1; i < nodes_.size(); ++i) {
      const Index row = rowOf(first(), nodes_[i]);
      const Vec3 way = Vec3(x[row]) - before;
      const double length = way.norm();
      const Vec3 n = length > 0 ? Vec3(sign / length * way) : Vec3(Vec3::Zero());
      rows.add(row, -n);
      if (row_before >= 0) rows.add(row_before, n);
      if (length > 0) addTurning(n, row_before, row, sign / length, rows);
      before = x[row], row_before = row;
    }
  }

 private:
  bool hasLength() const { return data().find("cableInitialLength")->isSet(); }
  template <class Place>
  double lengthOf(const Place& place) const {
    double sum = has_pull_ ? (place(nodes_.front()) - pull_).norm() : 0;
    for (std::size_t i = 1; i < nodes_.size(); ++i) sum += (place(nodes_[i]) - place(nodes_[i - 1])).norm();
    return sum;
  }

  std::vector<Index> nodes_;
  Vec3 pull_ = Vec3::Zero();
  bool has_pull_ = true;
  std::string method_ = "point";
  double least_force_ = 0, most_force_ = 0, least_way_ = 0, most_way_ = 0, change_ = 0;
  double start_length_ = 0, length_ = 0;
};

}  // namespace
}  // namespace stroma::lagrangian

STROMA_COMPONENT(cable_constraint) {
  factory.add<stroma::lagrangian::Cable>("CableConstraint", "a cable that is pulled, by a length or a force");
}
