// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "framework/mesh/topology.h"

namespace stroma {

/// Base of the topologies that are given their cells: the attributes, and the checks once all lists are there.
class MeshContainer : public Topology {
 public:
  /// Declares positions and all kinds of cells.
  void declare(DataTable& table) override;
  /// Not while it asks the state beside it for positions: the state must not ask back.
  bool answersLookup() const override { return !asks_state_; }

 protected:
  /// Takes the mesh of the topological mapping that names this container as its output, or lies beside it. Throws
  /// ComponentError for two of them, and for cells that the scene writes here as well.
  void takeFromMapping();
  /// Completes missing positions from the state of the node, then checks. Throws ComponentError; complains of cells
  /// that were written in the scene.
  void finish();

  /// Adds the edges and faces that createEdgeArray, createTriangleArray and createQuadArray ask for.
  void addParts();

  /// Raises a warning with the mesh report for cells that no loader has checked.
  void complainOfCells() const;

  int point_count_ = 0;      ///< attribute nbPoints; 0: from the positions
  bool allow_empty_ = false;  ///< attribute allowEmpty

 private:
  void takePositionsFromState();
  void makeReady(Component& state);
  void takeNodesOf(Component& state, bool is_given);
  bool asks_state_ = false, create_triangles_ = false, create_quads_ = false, create_edges_ = false;
};

}  // namespace stroma
