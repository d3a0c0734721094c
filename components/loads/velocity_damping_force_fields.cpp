// SPDX-License-Identifier: LGPL-2.1-or-later
// Damping of the nodes' velocity against the ground.
//
//   UniformVelocityDampingForceField:   f_i = -c v_i,              C = -c I
//   DiagonalVelocityDampingForceField:  f_i = -diag(c_i) v_i,      C = -diag(c_i)
//
// dampingCoefficient is c, or three coefficients (x, y, z) for each node or for all; of frames six, the last three of the torque
// about the fixed axes over the angular velocity [N m s]; of numbers as many as a node has. Without `indices` every node is
// damped. There is no energy and no stiffness; implicit integrators take C into their matrix, so any c is stable there,
// and an explicit step is stable while dt c is below twice the mass of a node.
//
// With explicitDamping the uniform one has no C: the force is that of the velocity at the start of a step. It also damps
// numbers and frames: of frames the velocity by -c v and the rotation by the torque -c w, c in N m s.
//
// Source: the names and attributes are SOFA's; its `implicit` has no effect, since C is used unless explicitDamping is written.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="50" tolerance="1e-10"/>
//   <MechanicalObject position="0 0 0  1 0 0  2 0 0"/>
//   <UniformMass totalMass="0.3"/>
//   <UniformVelocityDampingForceField dampingCoefficient="0.5"/>
//   <DiagonalVelocityDampingForceField dampingCoefficient="1 0 2"/>
// </Node>
#include <fmt/format.h>

#include "framework/mechanics/node_group_field.h"
#include "framework/mechanics/node_indices.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class VelocityDamping : public NodeGroupField<1> {
 public:
  void declare(DataTable& table) override {
    ForceField::declare(table);
    table.add("indices", indices_).help("damped nodes; every node by default");
  }
  void init() override {
    ForceField::init();
    nodes_ = data().find("indices")->isSet() ? checkedNodesInOrder(indices_, state(), "indices") : allNodes(state());
  }
  ForceTraits traits() const override {
    ForceTraits traits;
    traits.linear = traits.symmetric = traits.exact_tangent = true;
    traits.has_stiffness = false;
    traits.velocity_dependent = traits.conservative = !isExplicit();  // damping that no C says is in no energy
    return traits;
  }
  void compile() override {
    setNodes(rowsOf(nodes_, state()), true);
    for (std::size_t i = 0; i < damping_.size(); ++i)
      damping_[i].blocks[0] = -coefficientsOf(i).asDiagonal().toDenseMatrix();
  }
  double energy(ConstRows) const override { return 0; }
  void addForce(ConstRows, ConstRows v, Rows f) override { addDampingProduct(v, 1, f); }

 protected:
  virtual Vec3 coefficientsOf(std::size_t row) const = 0;  ///< [N s/m], of the row at that place in the list of nodes
  virtual bool isExplicit() const { return false; }
  std::size_t rowCount() const { return nodes_.size() * std::size_t(state().rows_per_node); }

 private:
  std::vector<int> indices_;
  std::vector<Index> nodes_;
};

class UniformVelocityDampingForceField final : public VelocityDamping {
 public:
  void declare(DataTable& table) override {
    VelocityDamping::declare(table);
    table.add("dampingCoefficient", coefficient_).recompiled().help("force over velocity").unit("N s/m").min(0).physical();
    table.add("explicitDamping", explicit_).help("damping has no part in derivatives, as in SOFA without implicit");
    table.addVisualOnly("implicit");
  }

 protected:
  Vec3 coefficientsOf(std::size_t) const override { return Vec3::Constant(coefficient_); }
  bool takesAllRows() const override { return true; }  // velocities of frames turn, too
  bool isExplicit() const override { return explicit_; }

 private:
  double coefficient_ = 0.1;
  bool explicit_ = false;
};

class DiagonalVelocityDampingForceField final : public VelocityDamping {
 public:
  void declare(DataTable& table) override {
    VelocityDamping::declare(table);
    table.add("dampingCoefficient", given_)
        .recompiled()
        .help("force over velocity along x, y and z, for each node or for all; of a frame three more, of the torque; or of each number")
        .unit("N s/m")
        .min(0)
        .required();
    table.add("lastForOthers", last_for_others_).help("nodes beyond the list take the last of dampingCoefficient, as in SOFA");
  }
  void init() override {
    VelocityDamping::init();
    const std::size_t each = state().kindOf(0) == RowKind::value ? 1 : 3, width = each * std::size_t(state().rows_per_node);
    const std::size_t nodes = rowCount() / std::size_t(state().rows_per_node);
    std::vector<double> all = given_;
    if (last_for_others_ && all.size() >= width && all.size() % width == 0) {
      if (all.size() > width * nodes)
        warn(fmt::format("dampingCoefficient has {} numbers for {} nodes: those beyond are left out", all.size(), nodes),
             fmt::format("{} of each", width));
      while (all.size() < width * nodes) all.push_back(all[all.size() - width]);
      all.resize(width * nodes);
    }
    if (all.size() != width && all.size() != width * nodes)
      throw ComponentError(fmt::format("dampingCoefficient has {} numbers for {} nodes", given_.size(), nodes),
                           fmt::format("{} for all, or {} of each", width, width));
    coefficients_.assign(rowCount(), Vec3::Zero());
    for (std::size_t row = 0; row < rowCount(); ++row)
      for (std::size_t i = 0; i < each; ++i) coefficients_[row][Index(i)] = all[(row * each + i) % all.size()];
  }

 protected:
  Vec3 coefficientsOf(std::size_t row) const override { return coefficients_[row]; }
  bool takesAllRows() const override { return true; }  // of frames the turning, too

 private:
  std::vector<double> given_;
  bool last_for_others_ = false;
  std::vector<Vec3> coefficients_;  ///< of each row
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(velocity_damping_force_fields) {
  factory.add<stroma::UniformVelocityDampingForceField>("UniformVelocityDampingForceField",
                                                        "damping of the nodes' velocity");
  factory.add<stroma::DiagonalVelocityDampingForceField>("DiagonalVelocityDampingForceField",
                                                         "damping of the nodes' velocity, along each axis");
}
