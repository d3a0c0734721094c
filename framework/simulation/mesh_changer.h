// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <utility>
#include <vector>

#include "framework/mesh/cell_kind.h"
#include "framework/mesh/topology.h"

namespace stroma {

/// What is removed from a mesh, or added to it, between two steps. The last item of a list takes the number of a removed one, as
/// in SOFA, the largest number first. Faces and edges that belong to no other cell are removed with their cell.
struct MeshChange {
  const Topology* topology = nullptr;
  const CellKind* kind = &cell_kinds::point;  ///< of all below
  std::vector<Index> removed{};
  std::vector<std::vector<Index>> added{};  ///< node numbers of each new cell
  /// Of each new point: numbers of points, and their shares in its place, rest place and velocity.
  std::vector<std::vector<std::pair<Index, double>>> points{};
  bool keeps_points = false;  ///< those that lose their last cell stay, held where they are
  bool by_first_numbers = false;  ///< `removed` has the numbers before all changes; what is already gone is no error
};

/// An observer that plans changes of meshes. The driver of the run makes them (tools/session/mesh_changes.h): it rebuilds the scene
/// with the new mesh, and the run goes on.
class MeshChanger {
 public:
  virtual ~MeshChanger() = default;
  /// Before the step that starts at t, in order: each has the numbers that those before it have left. Throws ComponentError.
  virtual std::vector<MeshChange> changesAt(double t, double dt) = 0;
  /// Called when the changes have been made.
  virtual void changesMade(double t, double dt) = 0;
};

}  // namespace stroma
