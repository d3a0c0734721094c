// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <vector>

#include "components/hyperelasticity/darcy_flow.h"
#include "framework/algebra/block_matrix.h"

namespace stroma::porous {

/// What a fluid that flows adds to the stiffness of its tissue, as a matrix. With U = d theta/dx, by the weights w_e =
/// d ln J/dJ half on the volumes and half on the pressures (as they are where all elements have one J),
///   K_fluid = -U^T A^-1 U,   U_ai = sum_e V_ea/V_e alpha w_e^1/2 dv_e/dx_i,   A = M/M_Biot + h kappa L
/// couples all nodes, because pressure spreads through the body within a step: for bodies of few nodes only.
class DenseCoupling {
 public:
  /// `first_row`: of node 0. All are kept by reference.
  DenseCoupling(const PorousCells& cells, const Sponge& sponge, Index first_row);
  ~DenseCoupling();
  void addPattern(BlockPattern& pattern) const;
  std::vector<Index> slots(const BlockMatrix& matrix) const;
  /// Takes K_fluid at x, rows of the system, with the A of `flow`, which is kept by reference. The matrix is multiplied out when it is
  /// assembled; its diagonal costs what the neighbours of each node cost.
  void update(ConstRows x, const DarcyFlow& flow);
  /// values (shape (blocks, 9)) += factor K_fluid; `slots`: those of slots().
  void assemble(double factor, const Index* slots, std::vector<double>& values);
  /// blocks[row] += factor K_fluid[row][row], shape (rows, 9).
  void assembleDiagonal(double factor, std::vector<double>& blocks) const;

 private:
  struct Matrices;
  std::size_t nodes() const { return cells_.rest().size(); }
  const PorousCells& cells_;
  const Sponge& sponge_;
  Index first_row_;
  const DarcyFlow* flow_ = nullptr;
  std::unique_ptr<Matrices> matrices_;
};

}  // namespace stroma::porous
