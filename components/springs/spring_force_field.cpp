// SPDX-License-Identifier: LGPL-2.1-or-later
// SpringForceField: springs between listed nodes, of one body or of two.
//
// With d = x_b - x_a, L = |d|, n = d / L, u = (v_b - v_a).n, stiffness k, damping c and rest length L0 a spring has
//
//   E = k/2 (L - L0)^2,   f_a = -f_b = (k (L - L0) + c u) n
//
// The tangent is the exact derivative, except for the rotation of n in the damping force. A spring whose ends meet has no
// direction: with L0 = 0 its force is -k d, which needs none; with L0 > 0 it has no force until the ends separate.
// elongationOnly springs have no force while L < L0, and compressionOnly ones while L > L0. A compressed spring's tangent is
// indefinite, as its equilibrium is.
//
// The springs are given by `springsIndices1`, `springsIndices2` and `lengths`, or all in one by `spring`, five numbers
// each: i j k c L0. Node i belongs to `object1`, node j to `object2`; without them both are of the state of this node.
// `stiffness`, `damping`, `lengths`, `elongationOnly`, `compressionOnly` and `enabled` have a value for each spring or one for all.
//
// With `explicitForce` the springs are not in the matrix of a step. A step with one linear solve then has the forces at its
// start, equal and opposite on both bodies: momentum is conserved, and stiff springs need small steps. SOFA does so where it
// solves for each body separately.
//
// Source: the attributes are SOFA's (StiffSpringForceField is an older name).
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="50" tolerance="1e-10"/>
//   <MechanicalObject position="0 0 0  1 0 0  2 0.5 0"/>
//   <UniformMass totalMass="0.3"/>
//   <FixedProjectiveConstraint indices="0"/>
//   <SpringForceField springsIndices1="0 1" springsIndices2="1 2" lengths="1 0.8" stiffness="200" damping="0"/>
// </Node>
#include <fmt/format.h>

#include <cmath>

#include "components/springs/spring_field.h"
#include "framework/mechanics/node_indices.h"
#include "framework/mechanics/node_pairs.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class SpringForceField final : public SpringField {
 public:
  void declare(DataTable& table) override {
    ForceField::declare(table);
    declareDamping(table);
    table.addLink("object1", object1_).help("state of the first ends; the one of this node by default");
    table.addLink("object2", object2_).help("state of the second ends; the one of the first ends by default");
    table.add("spring", all_in_one_).recompiled().help("five numbers per spring: node, node, stiffness, damping, rest length");
    table.add("springsIndices1", indices1_).recompiled().alias("indices1").help("first node of each spring");
    table.add("springsIndices2", indices2_).recompiled().alias("indices2").help("second node of each spring");
    table.add("lengths", lengths_).recompiled().alias("length").help("length at rest").unit("m").min(0);
    table.add("stiffness", stiffness_).recompiled().help("spring constant").unit("N/m").min(0);
    table.add("damping", damping_)
        .recompiled()
        .help("force along the spring over its speed of elongation")
        .unit("N s/m")
        .min(0);
    table.add("elongationOnly", elongation_only_).help("no force while the spring is shorter than at rest");
    table.add("compressionOnly", compression_only_).help("no force while the spring is longer than at rest");
    table.add("enabled", enabled_).recompiled().help("false: the spring is left out");
    table.add("explicitForce", explicit_force_).help("the springs are no part of the matrix: not stable for stiff ones");
  }

  void init() override {
    setFirstState(object1_, mstate_);
    if (object2_.target() && !object1_.target())
      inform("no object1: the first ends of the springs are nodes of the state of this node");
    ForceField::init();
    if (!data().find("spring")->isSet() && !data().find("stiffness")->isSet())
      warn("stiffness is not given: the default 100 N/m is used");
    State* second = object2_.get() ? object2_.get() : &state();
    setSprings(data().find("spring")->isSet() ? fromOneList(*second) : fromLists(*second), second);
  }

  ForceTraits traits() const override {
    ForceTraits traits = SpringField::traits();
    if (!explicit_force_) return traits;
    traits.conservative = !traits.velocity_dependent;  // damping that no C says is in no energy
    traits.has_stiffness = traits.velocity_dependent = traits.exact_tangent = false;
    return traits;
  }

 protected:
  bool takesAllRows() const override { return true; }  // a spring ends at the centre of a frame

 private:
  std::vector<Spring> fromOneList(const State& second) const {
    for (const char* other : {"springsIndices1", "springsIndices2", "lengths", "stiffness", "damping"})
      if (data().find(other)->isSet())
        throw ComponentError(fmt::format("spring and {} are both given", other), "one way to list the springs");
    if (all_in_one_.empty() || all_in_one_.size() % 5 != 0)
      throw ComponentError(fmt::format("spring has {} numbers", all_in_one_.size()),
                           "five per spring: node, node, stiffness, damping, rest length");
    std::vector<Spring> springs;
    for (std::size_t s = 0; s < all_in_one_.size(); s += 5) {
      const double* v = all_in_one_.data() + s;
      for (int end = 0; end < 2; ++end) {
        const State& owner = end == 0 ? state() : second;
        if (v[end] != std::floor(v[end]) || !(std::abs(v[end]) < 1e9) || !isNode(int(v[end]), owner))
          throw ComponentError(fmt::format("spring[{}] is {:g}, and {} has {} nodes", s + std::size_t(end), v[end],
                                           owner.path(), owner.nodes()),
                               fmt::format("an index in 0 ... {}", owner.nodes() - 1));
      }
      springs.push_back({Index(v[0]) * state().rows_per_node, Index(v[1]) * second.rows_per_node, v[2], v[3], v[4]});
    }
    return withSwitches(std::move(springs));
  }

  std::vector<Spring> fromLists(const State& second) {
    if (!data().find("springsIndices1")->isSet() || !data().find("springsIndices2")->isSet())
      throw ComponentError("there is no spring", "springsIndices1 and springsIndices2, or spring");
    const auto [first_nodes, second_nodes] =
        checkedPairs({"springsIndices1", indices1_, state()}, {"springsIndices2", indices2_, second});
    if (!data().find("lengths")->isSet())
      warn("no lengths: the springs have a length of 0 at rest and pull their ends together", "lengths=\"...\"");
    const std::size_t count = first_nodes.size();
    spread(lengths_, count, "lengths", "springs");
    spread(stiffness_, count, "stiffness", "springs");
    spread(damping_, count, "damping", "springs");
    std::vector<Spring> springs(count);
    for (std::size_t s = 0; s < count; ++s)
      springs[s] = {first_nodes[s], second_nodes[s], stiffness_[s], damping_[s], lengths_[s]};
    return withSwitches(std::move(springs));
  }

  std::vector<Spring> withSwitches(std::vector<Spring> springs) const {
    std::vector<bool> elongation_only = elongation_only_, compression_only = compression_only_, enabled = enabled_;
    spread(elongation_only, springs.size(), "elongationOnly", "springs");
    spread(compression_only, springs.size(), "compressionOnly", "springs");
    spread(enabled, springs.size(), "enabled", "springs");
    std::vector<Spring> kept;
    for (std::size_t s = 0; s < springs.size(); ++s) {
      springs[s].elongation_only = elongation_only[s], springs[s].compression_only = compression_only[s];
      if (enabled[s]) kept.push_back(springs[s]);
    }
    if (kept.empty()) warn("no spring is enabled: the component has no effect");
    return kept;
  }

  Link<State> object1_{"mechanical state"}, object2_{"mechanical state"};
  std::vector<double> all_in_one_, lengths_{0}, stiffness_{100}, damping_{0};
  std::vector<int> indices1_, indices2_;
  std::vector<bool> elongation_only_{false}, compression_only_{false}, enabled_{true};
  bool explicit_force_ = false;
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(spring_force_field) {
  factory.add<stroma::SpringForceField>("SpringForceField", "springs between listed nodes of one body or two");
}
