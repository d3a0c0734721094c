// SPDX-License-Identifier: LGPL-2.1-or-later
// Orientations that turn with the cells of a body. With g_a the gradients of the shape functions at rest and x_a the nodes,
//
//   F = sum_a x_a g_a^T = R S,   q = R q_0;   R is the rotation next to F, q_0 the orientation where F is the identity
//   w = J v = R G^-1 sum_a g_a x (R^T v_a),   G = tr(S) I - S;   force on a node: R (p x g_a),   p = G^-1 R^T torque
//
// and in the axes of R, u_a = R^T v_a, w_R = R^T w, S' = sum_a u_a g_a^T - [w_R] S, G' = tr(S') I - S':
//
//   dJ/dt v = R G^-1 (sum_a g_a x (u_a x w_R) - G' w_R)
//
// The geometric stiffness has the derivative of the forces with 1/2 [torque] w taken from the torque, as all turns here: it is
// symmetric.
#pragma once
#include <array>
#include <vector>

#include "components/mappings/linked_mapping.h"
#include "framework/mechanics/frames.h"
#include "framework/mesh/cell_tables.h"

namespace stroma {

class CellTurns {
 public:
  void clear() { turns_.clear(); }
  bool empty() const { return turns_.empty(); }
  /// An orientation in row `row` of the child, in the cell of these nodes of the parent.
  void add(Index row, const std::vector<Index>& nodes, const std::vector<Vec3>& slopes, const Quaternion& start);
  // ---- as those of Mapping: `parent` and `child` are the first rows of the states ----
  void apply(Rows x, Index parent, Index child) const;
  /// Before apply(), if x is overwritten: of q and -q it writes the one nearer to what x holds now.
  void noteSigns(ConstRows x, Index child) const;
  void applyJ(Rows v, Index parent, Index child) const;
  void applyJT(Rows f, Index parent, Index child) const;
  void addJacobian(std::vector<JacobianBlock>& out, Index parent, Index child) const;
  void addCurvature(ConstRows v, Rows a, Index parent, Index child) const;
  /// visit(row, column, block) for each block of the geometric stiffness, always the same ones in the same order; with f empty
  /// the blocks are zero.
  template <class Visit>
  void forGeometricBlocks(ConstRows f, Index parent, Index child, Visit&& visit) const {
    Column column;
    for (const Turn& turn : turns_)
      for (std::size_t b = 0; b < turn.nodes.size(); ++b) {
        geometricColumn(turn, b, f.count > 0 ? Vec3(f[child + turn.row]) : Vec3(Vec3::Zero()), column);
        for (std::size_t a = 0; a < turn.nodes.size(); ++a) visit(parent + turn.nodes[a], parent + turn.nodes[b], column[a]);
      }
  }

 private:
  struct Turn {
    Index row = 0;
    std::vector<Index> nodes;
    std::vector<Vec3> slopes;
    Quaternion start, before;  ///< q_0; what the row held
    // at the last apply()
    Mat3 rotation = Mat3::Identity(), stretch = Mat3::Identity(), inverse = Mat3::Identity() / 2;  ///< R, S, G^-1
  };
  using Column = std::array<Mat3, most_cell_nodes>;
  /// Of node b: the change of the forces on all nodes.
  static void geometricColumn(const Turn& turn, std::size_t b, const Vec3& torque, Column& column);

  mutable std::vector<Turn> turns_;
};

}  // namespace stroma
