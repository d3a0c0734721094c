// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "framework/mesh/topology.h"

namespace stroma {

/// Base of the topologies that are given their cells: the attributes, and the checks once all lists are there.
class MeshContainer : public Topology {
 public:
  /// Declares positions and all kinds of cells.
  void declare(DataTable& table) override;

 protected:
  /// Completes missing positions from the state of the node, then checks. Throws ComponentError; complains of cells
  /// that were written in the scene.
  void finish();

  /// Raises a warning with the mesh report for cells that no loader has checked.
  void complainOfCells() const;

  int point_count_ = 0;  ///< attribute nbPoints; 0: from the positions

 private:
  void takePositionsFromState();
  std::vector<std::array<Index, 6>> prisms_;
  std::vector<std::array<Index, 5>> pyramids_;
};

}  // namespace stroma
