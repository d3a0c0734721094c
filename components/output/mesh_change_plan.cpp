// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/output/mesh_change_plan.h"

#include <fmt/format.h>

#include "framework/mesh/cell_lists.h"
#include "framework/scene/node.h"

namespace stroma {
namespace {

bool hasCells(const Topology& topology) { return highestDimension(topology.mesh()) > 0; }

const Topology* lastOf(const Node& node, bool with_cells) {
  const Topology* last = nullptr;
  for (const auto& component : node.components()) {
    auto* topology = dynamic_cast<Topology*>(component.get());
    if (!topology || !topology->answersLookup()) continue;
    topology->ensureReady();
    if (!with_cells || hasCells(*topology)) last = topology;
  }
  return last;
}

}  // namespace

void MeshChangePlan::declare(DataTable& table) {
  table.addLink("topology", link_)
      .help("the mesh; without it the last with cells of this node, or of the nearest node above");
  table.add("keepsPoints", keeps_points_)
      .help("points that lose their last cell stay, fixed in place; otherwise they are removed");
}

void MeshChangePlan::init() {
  topology_ = link_.get();
  for (const bool with_cells : {true, false})
    for (const Node* at = &node(); at && !topology_; at = at->parent()) topology_ = lastOf(*at, with_cells);
  if (!topology_) throw ComponentError("there is no mesh in this node or above", "a container, or topology=\"@path\"");
}

const CellKind& MeshChangePlan::mainKind() const {
  const CellKind* kind = &cell_kinds::point;
  forEachCellList(
      [&](const CellKind& each, const auto& cells) {
        const bool is_called = topology_->type() == std::string(each.word) + "SetTopologyContainer";
        if (is_called || (!cells.empty() && each.dimension >= kind->dimension)) kind = &each;
      },
      topology_->mesh());
  return *kind;
}

std::string MeshChangePlan::refusal(const StepContext& context) {
  try {
    if (changesAt(context.t, context.dt).empty()) return {};
  } catch (const ComponentError& error) {
    return error.what();
  }
  return fmt::format("changes a mesh at t = {:g} s, which this program does not follow, as stroma run does",
                     plannedAt(context.t));
}

}  // namespace stroma
