// SPDX-License-Identifier: LGPL-2.1-or-later
// VectorSpringForceField: springs with a rest vector between their ends, not a rest length: they also resist rotation.
//
//   f_a = -f_b = k (x_b - x_a - r) + c (v_b - v_a),   E = k/2 |x_b - x_a - r|^2,   K of (a, a): -k I
//
// With useTopology there is one on each edge of the mesh, and r is the vector of the rest shape. Otherwise node i of object1
// is pulled to node i of object2, r = 0. The force is linear.
//
// Source: names, attributes and defaults are SOFA's. There the viscosity is no part of the matrix: explicitDamping.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="50" tolerance="1e-10"/>
//   <MechanicalObject position="0 0 0  1 0 0  2 0.5 0"/>
//   <MeshTopology position="0 0 0  1 0 0  2 0.5 0" edges="0 1  1 2"/>
//   <UniformMass totalMass="0.3"/>
//   <FixedProjectiveConstraint indices="0"/>
//   <VectorSpringForceField useTopology="true" stiffness="200" viscosity="0.1"/>
// </Node>
#include <fmt/format.h>

#include "framework/mechanics/drawn_segments.h"
#include "framework/mechanics/node_group_field.h"
#include "framework/mechanics/node_pairs.h"
#include "framework/mechanics/state_topology.h"
#include "framework/mesh/cell_kind.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class VectorSpringForceField final : public NodeGroupField<2, PairTangent>, public DrawnSegments {
 public:
  void declare(DataTable& table) override {
    ForceField::declare(table);
    table.addLink("object1", object1_).help("state of the first ends; the one of this node by default");
    table.addLink("object2", object2_).help("state of the second ends; the one of the first ends by default");
    topology_.declare(table, "mesh whose edges are the springs");
    table.add("useTopology", on_edges_).help("a spring on each edge of the mesh; else on each pair of nodes of equal number");
    table.add("stiffness", stiffness_constant_).recompiled().help("force over the change of the vector").unit("N/m").min(0).physical();
    table.add("viscosity", viscosity_).recompiled().help("force over the relative velocity").unit("N s/m").min(0).physical();
    table.add("explicitForce", explicit_force_)
        .help("the springs are no part of the matrix, as in SOFA between bodies of different solvers: not stable for stiff ones");
    table.add("explicitDamping", explicit_damping_).help("viscosity is no part of the matrix, as in SOFA");
  }

  void init() override {
    setFirstState(object1_, mstate_);
    ForceField::init();
    second_ = object2_.get() ? object2_.get() : &state();
    springs_.clear();
    if (on_edges_) {
      for (const auto& [a, b] : topology_.meshWith(cell_kinds::edge, *this, state()).edges) {
        if (b >= second_->nodes()) throw ComponentError(fmt::format("an edge names a node that {} has not", second_->path()));
        const auto restOf = [&](Index node) { return state().rest_position[std::size_t(node * state().rows_per_node)]; };
        springs_.push_back({a * state().rows_per_node, b * second_->rows_per_node, restOf(b) - restOf(a)});
      }
    } else {
      if (second_ == &state()) throw ComponentError("it joins each node to itself", "object1 and object2, or useTopology");
      if (state().nodes() != second_->nodes())
        throw ComponentError(fmt::format("{} has {} nodes and {} has {}", state().path(), state().nodes(), second_->path(),
                                         second_->nodes()),
                             "as many in both");
      for (Index i = 0; i < state().nodes(); ++i)
        springs_.push_back({i * state().rows_per_node, i * second_->rows_per_node, Vec3::Zero()});
    }
    if (springs_.empty()) throw ComponentError("there is no spring", "a mesh with edges");
  }

  std::vector<State*> states() const override {
    return second_ == &state() ? std::vector<State*>{second_} : std::vector<State*>{&state(), second_};
  }

  ForceTraits traits() const override {
    ForceTraits traits;
    traits.linear = traits.constant_stiffness = traits.symmetric = true;
    traits.velocity_dependent = viscosity_ > 0 && !explicit_damping_;
    traits.conservative = traits.exact_tangent = viscosity_ == 0 || !explicit_damping_;
    traits.forces_balance = on_edges_ && second_ == &state();
    if (!explicit_force_) return traits;
    traits.conservative = viscosity_ == 0;
    traits.has_stiffness = traits.velocity_dependent = traits.exact_tangent = false;
    return traits;
  }

  void compile() override {
    std::vector<Group> rows;
    for (const PairOfNodes& spring : springs_) rows.push_back({state().firstRow() + spring.a, second_->firstRow() + spring.b});
    setGroups(std::move(rows), viscosity_ > 0 && !explicit_damping_);
    for (PairTangent& tangent : stiffness_) tangent.k = -stiffness_constant_ * Mat3::Identity();
    for (PairTangent& tangent : damping_) tangent.k = -viscosity_ * Mat3::Identity();
  }

  double energy(ConstRows x) const override {
    double sum = 0;
    for (std::size_t s = 0; s < springs_.size(); ++s) sum += stiffness_constant_ / 2 * stretch(s, x).squaredNorm();
    return sum;
  }

  void addForce(ConstRows x, ConstRows v, Rows f) override {
    for (std::size_t s = 0; s < springs_.size(); ++s) {
      const auto [a, b] = rows_[s];
      Vec3 force = stiffness_constant_ * stretch(s, x);
      if (viscosity_ > 0) force += viscosity_ * (v[b] - v[a]);
      f[a] += force;
      f[b] -= force;
    }
  }

  void addSegments(std::vector<Segment>& segments) const override {
    for (const PairOfNodes& spring : springs_) segments.push_back({&state(), spring.a, second_, spring.b});
  }

 protected:
  bool takesAllRows() const override { return true; }  // a spring ends at the centre of a frame

 private:
  struct PairOfNodes {
    Index a, b;  ///< rows, of state() and of second_
    Vec3 rest;   ///< [m]
  };
  Vec3 stretch(std::size_t s, ConstRows x) const { return x[rows_[s][1]] - x[rows_[s][0]] - springs_[s].rest; }

  Link<State> object1_{"mechanical state"}, object2_{"mechanical state"};
  TopologyLink topology_;
  double stiffness_constant_ = 1, viscosity_ = 1;
  bool on_edges_ = false, explicit_damping_ = false, explicit_force_ = false;
  State* second_ = nullptr;
  std::vector<PairOfNodes> springs_;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(vector_spring_force_field) {
  factory.add<stroma::VectorSpringForceField>("VectorSpringForceField", "springs that remember a vector, not a length");
}
