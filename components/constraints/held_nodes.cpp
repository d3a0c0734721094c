// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/constraints/held_nodes.h"

#include <fmt/format.h>

#include "framework/mechanics/node_indices.h"
#include "framework/scene/archive.h"

namespace stroma {

void HeldNodes::declare(DataTable& table) {
  ProjectiveConstraint::declare(table);
  table.add("indices", indices_).recompiled().help("nodes to fix");
  table.add("fixAll", fix_all_).help("fix every node");
  table.add("ignoreMissing", ignore_missing_).help("nodes that the state does not have, or none at all, are no error");
  table.addVisualOnly("topology");
}

void HeldNodes::declareMatrix(DataTable& table) {
  table.add("inMatrix", in_matrix_)
      .help("false: the nodes are free in the matrix of an implicit step of one linear solve, whose right side is projected, and "
            "which are placed after it: SOFA's way with assembled matrices");
}

void HeldNodes::init() {
  ProjectiveConstraint::init();
  if (fix_all_) {
    nodes_ = allNodes(state());
    return;
  }
  if (!data().find("indices")->isSet())
    throw ComponentError("no indices: which nodes should be fixed?",
                         "indices=\"0 3 7\", indices=\"@roi.indices\" or fixAll=\"true\"");
  if (ignore_missing_) {
    std::vector<int> there = indices_;
    const auto missing = std::erase_if(there, [this](int node) { return node < 0 || node >= state().nodes(); });
    if (missing > 0 || there.empty())
      warn(there.empty() ? "no node is held" : fmt::format("{} of {} indices are no nodes of {}", missing, indices_.size(),
                                                           state().path()));
    nodes_.clear();
    if (!there.empty()) nodes_ = checkedNodes(there, state(), "indices");
    return;
  }
  nodes_ = checkedNodes(indices_, state(), "indices");
}

void HeldNodes::serializeStart(Archive& archive, std::vector<Vec3>& start) const {
  archive.list("start", start);
  std::vector<Index> whose = nodes_;
  archive.list("nodes", whose);
  if (whose != nodes_) start.clear();
}

void HeldNodes::addProjectors(double, std::vector<NodeProjector>& out) const {
  for (const Index node : nodes_)
    for (Index k = 0; k < heldRows(); ++k)
      out.push_back({state().firstRow() + node + k, in_matrix_ ? projector(k) : Mat3(Mat3::Identity())});
}

void HeldNodes::projectRightSide(Rows b) const {
  for (std::size_t i = 0; i < nodes_.size(); ++i)
    for (Index k = 0; k < heldRows(); ++k) b[row(i) + k] = (projector(k) * b[row(i) + k]).eval();
}

}  // namespace stroma
