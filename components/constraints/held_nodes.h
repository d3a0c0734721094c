// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <vector>

#include "framework/mechanics/projective_constraint.h"
#include "framework/mechanics/right_side.h"

namespace stroma {

/// Base of constraints on listed nodes that all have the same projectors.
class HeldNodes : public ProjectiveConstraint, public ProjectsRightSide {
 public:
  void declare(DataTable& table) override;  ///< also indices and fixAll
  void init() override;                     ///< finds the nodes; throws ComponentError when none are named
  void addProjectors(double, std::vector<NodeProjector>& out) const override;
  bool leavesMatrix() const override { return !in_matrix_; }
  void projectRightSide(Rows b) const override;

 protected:
  /// After init(): the rows of a node, from the first on, have these projectors: of frames also the orientations.
  void setProjectors(std::vector<Mat3> projectors) { projectors_ = std::move(projectors); }
  /// inMatrix, of constraints that can do without the matrix.
  void declareMatrix(DataTable& table);
  /// All rows of a node are held in all directions.
  void holdAllRows() { projectors_.assign(std::size_t(state().rows_per_node), Mat3::Zero()); }
  /// Onto the free directions of row k of a node.
  const Mat3& projector(Index k = 0) const { return projectors_[std::size_t(k)]; }
  Index heldRows() const { return Index(projectors_.size()); }  ///< of a node
  const std::vector<Index>& nodes() const { return nodes_; }  ///< ascending, each once
  Index row(std::size_t i) const { return state().firstRow() + nodes_[i]; }
  /// The start of a movement of the nodes, rows of the nodes or empty. Read for other nodes it is empty: their movement
  /// restarts.
  void serializeStart(Archive& archive, std::vector<Vec3>& start) const;
  bool ignoresMissing() const { return ignore_missing_; }
  /// Replaces the nodes that init() found.
  void setNodes(std::vector<Index> nodes) { nodes_ = std::move(nodes); }

 private:
  std::vector<int> indices_;
  bool fix_all_ = false, ignore_missing_ = false, in_matrix_ = true;
  std::vector<Index> nodes_;
  std::vector<Mat3> projectors_{Mat3::Zero()};  ///< of the rows of a node
};

}  // namespace stroma
