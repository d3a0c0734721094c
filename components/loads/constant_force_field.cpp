// SPDX-License-Identifier: LGPL-2.1-or-later
// ConstantForceField: forces on nodes that are independent of shape and time.
//
//   f_i = forces[i] for each index, or totalForce / (number of indices);  energy = -sum f_i . x_i;  K = 0
//
// One value in `forces` (or `force`) goes to every node; totalForce is shared equally by the nodes, not by area. A node
// listed twice is loaded twice. Without `indices` every node is loaded. With indexFromEnd the index 0 is the last node.
//
// A force on a rigid frame has six numbers, the force on its centre and the torque in fixed axes; on nodes of other types as
// many as they have. A torque of fixed direction has no energy: it does not derive from a potential.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 0">
//   <EulerExplicitSolver/>
//   <MechanicalObject position="0 0 0  1 0 0  2 0 0"/>
//   <UniformMass totalMass="3"/>
//   <ConstantForceField indices="1 2" totalForce="0 -2 0"/>
// </Node>
#include <fmt/format.h>

#include <cmath>
#include <numeric>
#include <utility>

#include "components/loads/dead_load.h"
#include "framework/mechanics/node_indices.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class ConstantForceField final : public DeadLoad {
 public:
  void declare(DataTable& table) override {
    ForceField::declare(table);
    table.add("indices", indices_).recompiled().help("loaded nodes; every node by default");
    table.add("emptyMeansAll", empty_is_all_).help("an empty list of indices means all nodes, as in SOFA");
    table.add("forces", forces_).recompiled().help("force on each listed node, or one for all of them").unit("N");
    table.add("noneIfMismatched", none_if_mismatched_)
        .help("forces of another number than one or that of the nodes are left out with a warning, as in SOFA, and are no error");
    table.add("force", force_).recompiled().help("the same force on each listed node").unit("N").shorthand();
    table.add("totalForce", total_force_).recompiled().help("force shared equally by the listed nodes").unit("N");
    table.add("indexFromEnd", from_end_).help("count indices from the last node: 0 is the last");
    for (const char* without_effect : {"showArrowSize", "showColor", "topology"}) table.addVisualOnly(without_effect);
  }

  void init() override {
    ForceField::init();
    const bool is_given = data().find("indices")->isSet();
    const bool takes_all = indices_.empty() && empty_is_all_;
    if (is_given && takes_all)
      warn(fmt::format("indices is empty: the load acts on all {} nodes of {}", state().nodes(), state().path()));
    if (is_given && !takes_all) {
      if (indices_.empty()) checkedNodes(indices_, state(), "indices");
      for (std::size_t i = 0; i < indices_.size(); ++i) checkNode(indices_[i], i, state(), "indices");
      nodes_.assign(indices_.begin(), indices_.end());
    } else {
      if (!is_given) inform(fmt::format("no indices: all {} nodes of {} are loaded", state().nodes(), state().path()));
      nodes_.resize(state().nodes());
      std::iota(nodes_.begin(), nodes_.end(), 0);
    }
    if (from_end_)
      for (Index& node : nodes_) node = state().nodes() - 1 - node;
    distribute();
  }

  ForceTraits traits() const override {
    ForceTraits traits = DeadLoad::traits();
    for (const auto& [row, force] : loads_)
      if (state().kindOf(row) == RowKind::turn && !force.isZero(0)) traits.conservative = false;
    return traits;
  }

  double energy(ConstRows x) const override {
    double sum = 0;
    for (const auto& [row, force] : loads_)
      if (state().kindOf(row) != RowKind::turn) sum -= force.dot(x[state().firstRow() + row]);
    return sum;
  }
  void addForce(ConstRows, ConstRows, Rows f) override {
    for (const auto& [row, force] : loads_) f[state().firstRow() + row] += force;
  }

 protected:
  bool takesAllRows() const override { return true; }

 private:
  void distribute() {
    int given = 0;
    for (const char* name : {"forces", "force", "totalForce"}) given += data().find(name)->isSet();
    if (given != 1)
      throw ComponentError(given == 0 ? "there is no force" : "more than one of forces, force and totalForce is given",
                           "forces (one per node or one for all) or totalForce");
    const std::size_t rows = std::size_t(state().rows_per_node);
    const bool numbers = state().kindOf(0) == RowKind::value;
    const std::size_t width = numbers ? rows : 3 * rows;
    const auto check = [width](const std::vector<double>& values, const char* name) {
      if (values.empty() || values.size() % width != 0)
        throw ComponentError(fmt::format("{} has {} numbers", name, values.size()),
                             fmt::format("{} for each node", width));
    };
    if (data().find("totalForce")->isSet()) {
      check(total_force_, "totalForce");
      forces_ = total_force_;
      for (double& number : forces_) number /= double(nodes_.size());
    }
    if (data().find("force")->isSet()) check(force_, "force"), forces_ = force_;
    check(forces_, "forces");
    std::vector<double> all = forces_;  // the attribute stays as it is written: other indices may be as many others
    if (none_if_mismatched_ && all.size() != width && all.size() != width * nodes_.size()) {
      warn(fmt::format("forces has {} values for {} nodes: the load is left out, as in SOFA", all.size() / width, nodes_.size()),
           fmt::format("1 value or {}", nodes_.size()));
      total_force_.assign(width, 0);
      return loads_.clear();
    }
    if (all.size() == width)
      while (all.size() < width * nodes_.size()) all.push_back(all[all.size() - width]);
    if (all.size() != width * nodes_.size())
      throw ComponentError(fmt::format("forces has {} values for {} nodes", all.size() / width, nodes_.size()),
                           fmt::format("1 value or {}", nodes_.size()));
    for (const double number : all)
      if (!std::isfinite(number)) throw ComponentError("a force is not finite", "finite numbers");
    total_force_.assign(width, 0);
    for (std::size_t i = 0; i < all.size(); ++i) total_force_[i % width] += all[i];
    loads_.clear();
    const double* at = all.data();
    for (const Index node : nodes_)
      for (Index k = 0; k < Index(rows); ++k, at += numbers ? 1 : 3)
        loads_.emplace_back(node * Index(rows) + k, numbers ? Vec3(at[0], 0, 0) : Vec3(at[0], at[1], at[2]));
  }

  std::vector<int> indices_;
  std::vector<double> forces_, force_{0, 0, 0}, total_force_{0, 0, 0};  ///< flat
  bool from_end_ = false, empty_is_all_ = false, none_if_mismatched_ = false;
  std::vector<Index> nodes_;
  std::vector<std::pair<Index, Vec3>> loads_;  ///< row of the state and what acts on it
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(constant_force_field) {
  factory.add<stroma::ConstantForceField>("ConstantForceField", "Given forces on nodes");
}
