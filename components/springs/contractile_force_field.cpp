// SPDX-License-Identifier: LGPL-2.1-or-later
// ContractileForceField: fibres whose rest length is prescribed over time (a muscle).
//
//   E = k/2 (L - s(t) L0)^2,   L0 the length of a fibre in the rest shape, s(t) the factor at the end of the step
//
// Fibres are the edges given, or those of the topology (its edges, the sides of its triangles and quads, those of its volume
// cells). A fibre pushes as well as pulls unless elongationOnly is set. The change of s(t) does work: the total energy of a
// scene with muscles is not constant.
//
// Source: contractile objects of the breathing model that Nesme et al. 2005, section 4, builds on.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 0 0">
//   <EulerImplicitSolver/>
//   <CGLinearSolver iterations="50" tolerance="1e-8"/>
//   <MechanicalObject position="0 0 0  1 0 0  2 0 0"/>
//   <UniformMass totalMass="3"/>
//   <ContractileForceField edges="0 1  1 2" stiffness="100" times="0 0.5 1" factors="1 0.8 1" period="1"/>
// </Node>
#include <fmt/format.h>

#include "components/springs/spring_field.h"
#include "framework/mechanics/factor_over_time.h"
#include "framework/mechanics/node_indices.h"
#include "framework/mechanics/state_topology.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class ContractileForceField final : public SpringField {
 public:
  void declare(DataTable& table) override {
    SpringField::declare(table);
    topology_.declare(table, "mesh whose edges are fibres when no edges are given");
    table.add("edges", edges_).help("fibres, two nodes each");
    table.add("stiffness", stiffness_).unit("N/m").min(0).physical().help("spring constant of a fibre");
    table.add("damping", damping_).unit("N s/m").min(0).help("force along a fibre over its speed of elongation");
    table.add("elongationOnly", elongation_only_).help("a fibre that is shorter than its rest length has no force");
    factor_.declare(table, "the rest length", FactorOverTime::Sign::positive);
  }

  void init() override {
    SpringField::init();
    factor_.check();
    if (!data().find("edges")->isSet()) takeEdges();
    std::vector<Spring> springs;
    rest_length_.clear();
    for (std::size_t e = 0; e < edges_.size(); ++e) {
      for (const Index node : edges_[e]) checkNode(node, e, state(), "edges");
      springs.push_back({edges_[e][0], edges_[e][1], stiffness_, damping_, 0, elongation_only_});
      rest_length_.push_back(restDistance(springs.back()));
      springs.back().length = rest_length_.back();
    }
    setSprings(std::move(springs));
  }

  ForceTraits traits() const override {
    ForceTraits traits = SpringField::traits();
    traits.time_dependent = factor_.varies();
    // they balance at any time, but not by vanishing at the rest shape
    traits.has_rest_shape = true;
    if (factor_.varies() || factor_.at(0) != 1) traits.forces_balance = traits.torques_balance = false;
    return traits;
  }
  void setTime(double t) override {
    const double factor = factor_.at(t);
    for (std::size_t s = 0; s < rest_length_.size(); ++s) setLength(s, factor * rest_length_[s]);
  }
  void compile() override {
    SpringField::compile();
    setTime(0);
  }

 private:
  void takeEdges() {
    const Topology* topology = topology_.find(*this, state(), MeshNodes::first);
    if (!topology) throw ComponentError("there are no fibres", "edges=\"0 1  1 2\", or a topology with edges");
    edges_ = topology->mesh().allEdges();
    if (edges_.empty()) throw ComponentError(fmt::format("{} has no edges", topology->path()), "edges or cells");
  }

  TopologyLink topology_;
  std::vector<Edge> edges_;
  double stiffness_ = 100, damping_ = 0;
  bool elongation_only_ = false;
  FactorOverTime factor_;
  std::vector<double> rest_length_;  ///< [m], shape (edges)
};

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(contractile_force_field) {
  factory.add<stroma::ContractileForceField>("ContractileForceField", "Fibres with a rest length prescribed over time");
}
