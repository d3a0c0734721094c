// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <utility>
#include <vector>

#include "framework/mesh/cell_kind.h"
#include "framework/mesh/topology.h"

namespace stroma {

/// What is removed from a mesh, or added to it, between two steps. The last item of a list takes the number of a removed one,
/// largest numbers first, as in SOFA. Faces and edges that belong to removed cells only are removed too.
struct MeshChange {
  const Topology* topology = nullptr;
  const CellKind* kind = &cell_kinds::point;  ///< of all below
  std::vector<Index> removed{};
  std::vector<std::vector<Index>> added{};  ///< node numbers of each new cell
  /// Per new point: existing points, and their weights in its position, rest position and velocity.
  std::vector<std::vector<std::pair<Index, double>>> points{};
  bool keeps_points = false;  ///< points that lose their last cell stay, fixed at their positions
  bool by_first_numbers = false;  ///< `removed` has the numbers before all changes; items removed since then are no error
};

/// An observer that plans changes of meshes. The caller of the steps applies them (tools/session/mesh_changes.h): it rebuilds the
/// scene with the new mesh and continues the run.
class MeshChanger {
 public:
  virtual ~MeshChanger() = default;
  /// The changes before the step that starts at t, in order. Each uses the numbering left by the previous one. Throws ComponentError.
  virtual std::vector<MeshChange> changesAt(double t, double dt) = 0;
  /// They have been applied.
  virtual void changesMade(double t, double dt) = 0;
};

}  // namespace stroma
