// SPDX-License-Identifier: LGPL-2.1-or-later
// The elements of a mesh with one method, behind one interface: chosen once, called once per mesh. model_kernels.h builds
// it from an element's mathematics.
#pragma once
#include <vector>

#include "framework/algebra/block_matrix.h"

namespace stroma {

/// Forces and stiffness of all elements. Rows are the system's; K is taken at the x of the last addForce.
class ElementKernels {
 public:
  virtual ~ElementKernels() = default;
  /// f += forces [N] at x [m]; makes the tangent ready for the calls below.
  virtual void addForce(ConstRows x, Rows f) = 0;
  /// f += force + factor * K dx
  virtual void addForceAndProduct(ConstRows x, ConstRows dx, double factor, Rows f) = 0;
  /// Stored energy [J] at x; the tangent stays that of the last force.
  virtual double energy(ConstRows x) const = 0;
  /// df += factor * K dx
  virtual void addProduct(ConstRows dx, double factor, Rows df) const = 0;
  /// Recomputes the constants of the elements, and leaves everything else. False: the kernels have to be rebuilt.
  virtual bool refill() { return false; }
  /// Marks the blocks that assemble() adds to.
  virtual void addPattern(BlockPattern& pattern) const = 0;
  /// The slots that assemble() needs for a matrix with this pattern.
  virtual std::vector<Index> slots(const BlockMatrix& matrix) const = 0;
  /// values (shape (blocks, 9) of the matrix that `slots` were made for) += factor * K.
  virtual void assemble(double factor, const std::vector<Index>& slots, std::vector<double>& values) const = 0;
  /// blocks[row] += factor * K[row][row], shape (rows, 9).
  virtual void assembleDiagonal(double factor, std::vector<double>& blocks) const = 0;
};

}  // namespace stroma
