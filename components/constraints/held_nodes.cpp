// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/constraints/held_nodes.h"

#include "framework/mechanics/node_indices.h"
#include "framework/scene/archive.h"

namespace stroma {

void HeldNodes::declare(DataTable& table) {
  ProjectiveConstraint::declare(table);
  table.add("indices", indices_).recompiled().help("nodes to hold");
  table.add("fixAll", fix_all_).help("hold every node");
  table.addVisualOnly("topology");
}

void HeldNodes::init() {
  ProjectiveConstraint::init();
  if (fix_all_) {
    nodes_ = allNodes(state());
    return;
  }
  if (!data().find("indices")->isSet())
    throw ComponentError("no indices: which nodes are held?",
                         "indices=\"0 3 7\", indices=\"@roi.indices\" or fixAll=\"true\"");
  nodes_ = checkedNodes(indices_, state(), "indices");
}

void HeldNodes::serializeStart(Archive& archive, std::vector<Vec3>& start) const {
  archive.list("start", start);
  std::vector<Index> whose = nodes_;
  archive.list("nodes", whose);
  if (whose != nodes_) start.clear();
}

void HeldNodes::addProjectors(double, std::vector<NodeProjector>& out) const {
  for (Index node : nodes_) out.push_back({state().firstRow() + node, projector_});
}

}  // namespace stroma
