// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <vector>

#include "framework/mechanics/projective_constraint.h"

namespace stroma {

/// Base of constraints on listed nodes that all have the same projector.
class HeldNodes : public ProjectiveConstraint {
 public:
  void declare(DataTable& table) override;  ///< also indices and fixAll
  void init() override;                     ///< finds the nodes; throws ComponentError when none are named
  void addProjectors(double, std::vector<NodeProjector>& out) const override;

 protected:
  /// After init(): also the orientations of frames and all numbers of a node, with projectors of their own.
  void holdAllRows(const std::vector<Mat3>& projectors);
  const std::vector<Index>& nodes() const { return nodes_; }  ///< ascending, each once
  Index row(std::size_t i) const { return state().firstRow() + nodes_[i]; }
  /// Where a movement of the nodes started, shape (nodes) or empty. Read for other nodes it is empty: theirs begins anew.
  void serializeStart(Archive& archive, std::vector<Vec3>& start) const;
  /// Replaces the nodes that init() found.
  void setNodes(std::vector<Index> nodes) { nodes_ = std::move(nodes); }

  Mat3 projector_ = Mat3::Zero();  ///< onto the free directions

 private:
  std::vector<int> indices_;
  bool fix_all_ = false, ignore_missing_ = false;
  std::vector<Index> nodes_;
  std::vector<Mat3> of_rows_;  ///< projectors of the rows of a node; empty: projector_ of its first one
};

}  // namespace stroma
