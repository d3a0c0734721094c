// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <utility>
#include <vector>

#include "framework/mesh/cell_kind.h"
#include "framework/mesh/topology.h"

namespace stroma {

/// What goes from a mesh, or comes to it, between two steps. A number that goes is taken over by the last one of its list, as
/// in SOFA, the largest first. A face or edge of a cell that goes, and of no other, goes with it.
struct MeshChange {
  const Topology* topology = nullptr;
  const CellKind* kind = &cell_kinds::point;  ///< of all below
  std::vector<Index> removed{};
  std::vector<std::vector<Index>> added{};  ///< node numbers of each new cell
  /// Of each new point: numbers of points, and their shares in its place, rest place and velocity.
  std::vector<std::vector<std::pair<Index, double>>> points{};
  bool keeps_points = false;  ///< those that lose their last cell stay, held where they are
  bool by_first_numbers = false;  ///< `removed` numbers what was there before all changes; what has gone since is no error
};

/// An observer that plans changes of meshes. Who makes the steps makes the changes (tools/session/mesh_changes.h): the scene is made
/// anew with the other mesh, and its run goes on.
class MeshChanger {
 public:
  virtual ~MeshChanger() = default;
  /// Before the step that starts at t, in order: each has the numbers that those before it have left. Throws ComponentError.
  virtual std::vector<MeshChange> changesAt(double t, double dt) = 0;
  /// They have been made.
  virtual void changesMade(double t, double dt) = 0;
};

}  // namespace stroma
