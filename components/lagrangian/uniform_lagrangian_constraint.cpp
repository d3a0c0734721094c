// SPDX-License-Identifier: LGPL-2.1-or-later
// UniformLagrangianConstraint: all values of a state stay zero, by forces that can be read.
//
//   x = 0,   with one row for each number of the state, three for each point; with constrainToRestPos x = its rest position
//
// For a mapped state it constrains the quantity that the mapping computes: distances from a DistanceMapping keep their rest
// values, so that its edges are rods. The force of a row is then the tension of a rod.
//
// Source: the name is SOFA's.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <SparseLDLSolver/>
//   <MechanicalObject position="0 0 0  1 0 0  2 0 0"/>
//   <UniformMass totalMass="3"/>
//   <FixedProjectiveConstraint indices="0"/>
//   <Node name="rods">
//     <MeshTopology position="0 0 0  1 0 0  2 0 0" edges="0 1  1 2"/>
//     <MechanicalObject template="Vec1"/>
//     <DistanceMapping/>
//     <UniformLagrangianConstraint/>
//   </Node>
// </Node>
#include <fmt/format.h>

#include "components/lagrangian/pair_constraint.h"
#include "framework/scene/factory.h"

namespace stroma::lagrangian {
namespace {

class Uniform final : public PairConstraint {
 public:
  void declare(DataTable& table) override {
    declareOneState(table);
    table.add("constrainToRestPos", to_rest_).help("scalars and points stay at their rest value, not at zero");
    table.addVisualOnly("iterative");
  }
  void addConditions(ConstRows x, ConstRows, LagrangianRows& rows) const override {
    const Index start = first().firstRow();
    for (Index i = 0; i < first().size(); ++i)
      for (int k = 0; k < (first().kindOf(i) == RowKind::place ? 3 : 1); ++k) {
        rows.begin(Kind::equal, x[start + i][k] - (to_rest_ ? first().rest_position[std::size_t(i)][k] : 0));
        rows.add(start + i, Vec3::Unit(k));
      }
  }

 protected:
  Nodes nodes() const override { return Nodes::points_or_values; }

 private:
  bool to_rest_ = false;
};

}  // namespace
}  // namespace stroma::lagrangian

STROMA_COMPONENT(uniform_lagrangian_constraint) {
  factory.add<stroma::lagrangian::Uniform>("UniformLagrangianConstraint", "scalars and points that stay zero, such as mapped distances");
}
