// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/mappings/linked_mapping.h"

#include <fmt/format.h>

#include <algorithm>

#include "framework/mechanics/force_field.h"
#include "framework/mechanics/mass.h"

namespace stroma {

void LinkedMapping::declare(DataTable& table) {
  table.addLink("input", input_)
      .help(takesManyInputs() ? "parent states; by default the one of the parent node or above"
                              : "parent state; by default the one of the parent node or above");
  table.addLink("output", output_).help("child state; by default the one of this node");
  table.add("mapForces", maps_forces_).help("false: forces on the nodes that follow are an error, not lost");
  table.add("mapMasses", maps_masses_).help("false: a mass of the nodes that follow is an error, not lost");
  table.add("mapConstraints", maps_constraints_)
      .help("SOFA's; without effect: constraints on nodes that follow are an error");
  table.add("mapMatrices", maps_matrices_).help("SOFA's; without effect: a matrix is mapped where a solver wants one");
}

void LinkedMapping::init() {
  parents_ = input_.all();
  if (parents_.empty() && node().parent())
    if (State* above = node().parent()->find<State>(this, true)) parents_.push_back(above);
  child_ = output_.get() ? output_.get() : find<State>(false);
  if (parents_.empty())
    throw ComponentError("there is no state to follow", "a MechanicalObject in a node above, or input=\"@path\"");
  if (!child_)
    throw ComponentError("there is no state that follows", "a MechanicalObject in the same node, or output=\"@path\"");
  if (parents_.size() > 1 && !takesManyInputs())
    throw ComponentError(fmt::format("input names {} states", parents_.size()), "one state");
  child_->ensureReady();
  for (State* parent : parents_) {
    if (parent == child_) throw ComponentError(fmt::format("{} cannot follow itself", child_->path()), "two states");
    parent->ensureReady();
  }
}

void LinkedMapping::compile() {
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

void declareGeometricStiffness(DataTable& table, GeometricStiffness& choice, bool with_stabilized) {
  std::vector<std::string> words{"None", "Exact"};
  if (with_stabilized) words.push_back("Stabilized");
  table.addChoice("geometricStiffness", choice, words)
      .help(
          with_stabilized
              ? "the derivative of the mapped force with respect to the direction: left out, whole, or where it resists"
              : "the derivative of the mapped force with respect to the orientation: left out, or whole");
}

void declareConvection(DataTable& table, bool& convects) {
  table.add("convectiveInertia", convects)
      .help("masses of the child have the inertial forces M dJ/dt v of its rotation; false: these are left out, as in SOFA");
}

void CurvedMapping::declare(DataTable& table) {
  LinkedMapping::declare(table);
  declareConvection(table, convects_);
}

void CurvedMapping::addGeometricProduct(ConstRows f, ConstRows dx, double factor, Rows df) const {
  blocks_.clear();
  geometricBlocks(f, blocks_);
  for (const Block& block : blocks_) df[block.row] += factor * (block.value * dx[block.column]);
}

void CurvedMapping::addGeometricPattern(BlockPattern& pattern) const {
  blocks_.clear();
  geometricBlocks({}, blocks_);
  for (const Block& block : blocks_) pattern.addBlock(block.row, block.column);
}

void CurvedMapping::addGeometricStiffness(ConstRows f, double factor, BlockMatrix& matrix) const {
  blocks_.clear();
  geometricBlocks(f, blocks_);
  for (const Block& block : blocks_) matrix.add(block.row, block.column, factor * block.value);
}

}  // namespace stroma
