// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/mappings/weighted_mapping.h"

#include <fmt/format.h>

#include <algorithm>

#include "framework/mechanics/force_field.h"
#include "framework/mechanics/mass.h"

namespace stroma {

void WeightedMapping::declare(DataTable& table) {
  table.addLink("input", input_).help("state that is followed; the one of the parent node or above when not given");
  table.addLink("output", output_).help("state whose nodes follow; the one of this node when not given");
  table.add("mapForces", maps_forces_).help("false: forces on the nodes that follow are an error, not lost");
  table.add("mapMasses", maps_masses_).help("false: a mass of the nodes that follow is an error, not lost");
  table.add("mapConstraints", maps_constraints_)
      .help("SOFA's; without effect: constraints on nodes that follow are an error");
  table.add("mapMatrices", maps_matrices_).help("SOFA's; without effect: a matrix is mapped where a solver wants one");
}

void WeightedMapping::init() {
  parent_ = input_.get();
  if (!parent_ && node().parent()) parent_ = node().parent()->find<State>(this, true);
  child_ = output_.get() ? output_.get() : find<State>(false);
  if (!parent_)
    throw ComponentError("there is no state to follow", "a MechanicalObject in a node above, or input=\"@path\"");
  if (!child_)
    throw ComponentError("there is no state that follows", "a MechanicalObject in the same node, or output=\"@path\"");
  if (parent_ == child_) throw ComponentError(fmt::format("{} cannot follow itself", parent_->path()), "two states");
  parent_->ensureReady();
  child_->ensureReady();
  start_ = {0};
  weights_.clear();
}

void WeightedMapping::addNode(const std::vector<Weight>& weights) {
  weights_.insert(weights_.end(), weights.begin(), weights.end());
  start_.push_back(weights_.size());
}

void WeightedMapping::compile() {
  const auto refuse = [this](const Component& actor, const char* attribute) {
    throw ComponentError(fmt::format("{} acts on {}, and {} is false", actor.path(), child_->path(), attribute),
                         fmt::format("{}=\"true\", or nothing that acts there", attribute));
  };
  std::vector<ForceField*> fields;
  std::vector<Mass*> masses;
  node().root().collect(fields);
  node().root().collect(masses);
  for (const ForceField* field : fields) {
    const std::vector<State*> states = field->states();
    if (!maps_forces_ && std::find(states.begin(), states.end(), child_) != states.end()) refuse(*field, "mapForces");
  }
  for (const Mass* mass : masses)
    if (!maps_masses_ && &mass->state() == child_) refuse(*mass, "mapMasses");
}

void WeightedMapping::apply(Rows x) const {
  const Index first = child_->firstRow(), parent = parent_->firstRow();
  for (Index i = 0; i < child_->size(); ++i) {
    Vec3 sum = Vec3::Zero();
    for (std::size_t k = start_[i]; k < start_[i + 1]; ++k) sum += weights_[k].value * x[parent + weights_[k].parent];
    x[first + i] = sum;
  }
}

void WeightedMapping::applyJT(Rows f) const {
  const Index first = child_->firstRow(), parent = parent_->firstRow();
  for (Index i = 0; i < child_->size(); ++i)
    for (std::size_t k = start_[i]; k < start_[i + 1]; ++k)
      f[parent + weights_[k].parent] += weights_[k].value * f[first + i];
}

void WeightedMapping::addJacobian(std::vector<JacobianBlock>& out) const {
  const Index first = child_->firstRow(), parent = parent_->firstRow();
  for (Index i = 0; i < child_->size(); ++i)
    for (std::size_t k = start_[i]; k < start_[i + 1]; ++k)
      out.push_back({first + i, parent + weights_[k].parent, weights_[k].value * Mat3::Identity()});
}

}  // namespace stroma
