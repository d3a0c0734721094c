// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <fmt/format.h>

#include <vector>

#include "framework/mechanics/state.h"
#include "framework/mesh/topology.h"

namespace stroma {

/// The cells of one kind (`list` of a mesh, called `what`) of the linked mesh, else of the first of this node or the nearest
/// above that has any. Throws ComponentError when there are none, or when they name a node beyond `nodes`.
template <class Cell>
const std::vector<Cell>& cellsOfMesh(const Component& asker, const Link<Topology>& link, std::vector<Cell> Mesh::*list,
                                     const char* what, Index nodes) {
  const Topology* mesh = link.get();
  for (const Node* at = &asker.node(); at && !mesh; at = at->parent())
    for (const auto& component : at->components())
      if (auto* one = dynamic_cast<Topology*>(component.get()); one && !mesh) {
        one->ensureReady();
        if (!(one->mesh().*list).empty()) mesh = one;
      }
  if (!mesh || (mesh->mesh().*list).empty())
    throw ComponentError(fmt::format("there are no {}", what),
                         fmt::format("a topology with {} in this node, or topology=\"@path\"", what));
  for (const Cell& cell : mesh->mesh().*list)
    for (const Index node : cell)
      if (node < 0 || node >= nodes)
        throw ComponentError(fmt::format("one of the {} of {} names point {} of {}", what, mesh->path(), node, nodes),
                             fmt::format("0 to {}", nodes - 1));
  return mesh->mesh().*list;
}

/// A state that follows gets a number for each of `count` things; at rest they are what the scene gives it, else zero. Throws
/// ComponentError where it cannot hold numbers, or where the scene gives it another count.
inline void makeNumbers(State& child, std::size_t count, const char* of_what) {
  if (child.rows_per_node != 1 || child.kindOf(0) != RowKind::value)
    throw ComponentError(fmt::format("{} cannot hold numbers", child.path()), "a state of numbers (template=\"Vec1\")");
  const bool is_given = child.data().find("position")->isSet() || child.data().find("rest_position")->isSet();
  if (child.nodes() != Index(count) && is_given)
    throw ComponentError(fmt::format("{} has {} numbers for {} {}", child.path(), child.nodes(), count, of_what),
                         "as many, or no position");
  child.row_kinds.assign(count, RowKind::value);
  for (std::vector<Vec3>* rows : {&child.position, &child.velocity}) rows->assign(count, Vec3::Zero());
  if (!is_given) child.rest_position.assign(count, Vec3::Zero());
}

}  // namespace stroma
