// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <vector>

#include "components/hyperelasticity/porous_cells.h"
#include "framework/algebra/vector.h"

namespace stroma {

/// Backward Euler of Darcy's law on cells at rest, (s M + h kappa L) P = b: M the lumped volumes of the
/// nodes [m^3], L the products of gradients [m], s the storage [1/Pa], kappa the permeability [m^4/(N s)]. P = 0 at
/// drained nodes, no flow through the rest of the boundary. Factored when h changes.
class DarcyFlow {
 public:
  DarcyFlow();
  ~DarcyFlow();
  void build(const porous::PorousCells& cells, const std::vector<Index>& drained);
  /// h > 0 [s]; s > 0.
  void setStep(double h, double storage, double permeability);
  /// In the x of each row, rows being the nodes: b [m^3] becomes P [Pa].
  void solve(Rows values) const;
  /// Columns B, shape (columns, nodes), become a B' with B'^T B' = B^T A^-1 B, A the matrix of solve().
  void multiplyRoot(double* columns, std::size_t count) const;
  /// How often the matrix has been factored: another number, another matrix.
  long factorisations() const { return factorisations_; }
  /// Nanoseconds of solve(), from the numbers in the factor; 0 before there is one.
  double solveCost() const;
  double volume(Index node) const { return volume_[node]; }  ///< of M [m^3]
  bool isDrained(Index node) const { return drained_[node] != 0; }

 private:
  struct Matrices;
  /// The matrix of L, with a place for each node's M.
  void buildGradients(const porous::PorousCells& cells);
  std::vector<double> volume_;
  std::vector<char> drained_;
  std::unique_ptr<Matrices> matrices_;
  double step_ = -1;
  long factorisations_ = 0;
};

}  // namespace stroma
