// SPDX-License-Identifier: LGPL-2.1-or-later
// A nearly incompressible body: displacements u and pressures p are solved for together, so that nothing grows with the
// bulk modulus. The matrix is K = A + B^T E B with the B and E of pressure_rows.h; A is the matrix of a body with Poisson's ratio
// 0.3. With p = E B u,
//
//   | A    B^T  | | u |   | f |
//   | B  -E^-1  | | p | = | 0 |.
//
// Flexible GMRES (Saad 1993) solves it, preconditioned from the right by a block triangle (Murphy, Golub, Wathen 2000)
//
//   p = -T r_p,   u = V (r_u - B^T p).
//
// V ~ A^-1 is a V-cycle of multigrid.h, in single precision. T ~ (B A^-1 B^T + E^-1)^-1 is the BFBt preconditioner, or least-squares
// commutator (Elman 1999), with D, the 3x3 diagonal blocks of A, for a scale (Elman, Howle, Shadid, Shuttleworth, Tuminaro 2006;
// for jumps of stiffness May, Moresi 2008):
//
//   T = X^-1 (B D^-1 A D^-1 B^T + L E L) X^-1,   X = B D^-1 B^T + L.
//
// L, E^-1 times a Laplacian (pressure_rows.h), is what those authors do not have. It brings E^-1 into T where pressures are rough. For a
// pressure with B D^-1 B^T = x and D^-1 A = a, T is then a / (x + a E^-1), the inverse of x / a + E^-1. Without L, iterations at
// Poisson's ratio 0.499 double from 10^3 to 30^3 cells.
//
// Hexahedra with one pressure each have pressures, near a chessboard pattern, that hardly act on a displacement. T knows them: the
// eigenvalues of T B A^-1 B^T are 1 to 1.64 with 10^3 cells and 1 to 1.8 with 14^3. With a mass matrix for T they are 0.007 to
// 1.6 with 10^3 cells, and iterations grow with the mesh. X is factored. It has a number for each pressure: with as many pressures
// as nodes its factors take 1/27 of the operations of those of K, and 1/9 of the memory.
//
// Any B and E give the solution of K u = f, as A is what they leave of K. Where they are not those of the body, A may be indefinite
// or V and T poor, and the solve fails.
//
// Iterations end when |f - K u|, computed, is small enough, or where it does not fall any more. Minimising that norm itself would not
// do: K times what single precision rounds in V is as large as the residual. No u of numbers of eps = 1e-16 leaves less than about
// eps |D u|. In a slender body that is more than 1e-8 |f|: u of a beam is large for its weight.
#pragma once
#include <functional>
#include <memory>
#include <optional>

#include "components/iterative_solvers/former_matrix.h"
#include "components/iterative_solvers/light_rows.h"
#include "components/iterative_solvers/multigrid.h"
#include "components/iterative_solvers/pressure_rows.h"
#include "framework/algebra/direct_solver.h"

namespace stroma {

/// One for each matrix. V, and X with its factors, serve the later matrices of a step for as long as they pay, see Multigrid; pressures do
/// not turn with a body.
class MixedSolve {
 public:
  using Product = std::function<void(ConstRows p, Rows out)>;
  struct Equations {
    SystemMatrix& matrix;
    ConstRows b;
    Product product;                            ///< out = K p
    std::function<VolumeTerms()> terms;         ///< called where the matrix has changed; none: they are not in it
    std::function<void(double residual)> note;  ///< after each iteration
    DirectSolver& factors;                      ///< of X
    LightRows& light;
  };
  /// Of a solve. Cubes take 30, and what takes more than 150 seldom converges.
  static constexpr int most_iterations = 150;

  MixedSolve();
  ~MixedSolve();
  /// Solves K x = b from the x given to |b - K x| <= tolerance |b|, and goes on while light rows are left.
  SolveReport solve(const Equations& of, int iterations, double tolerance, StopToken stop, Rows x);
  /// Forgets all matrices. Of one that changes, before each step: a resumed run then continues with the same bits.
  void reset();
  /// Of a matrix that does not change: the places that V is made for.
  void serialize(Archive& archive);

 private:
  class Compressible;  ///< A as the matrix of multigrid

  bool follow(const Equations& of, SolveReport& report, StopToken stop);
  bool takeDiagonal(std::vector<double>& blocks, SolveReport& report);
  bool factor(const std::vector<double>& diagonal, DirectSolver& factors, SolveReport& report, StopToken stop);
  void allocate();
  /// The next follow() makes all anew. False: it is of this very matrix.
  bool giveUp();
  SolveReport iterate(const Equations& of, const cg::Limits& limits, Rows x);
  Vector& vectorOf(std::vector<Vector>& vectors, std::size_t i) {
    while (vectors.size() <= i) vectors.emplace_back().resize(both_.count());
    return vectors[i];
  }
  void multiply(const Product& product, ConstRows in, Rows out);
  void precondition(const Product& product, ConstRows r, Rows z);
  void applyInverseSchur(const Product& product, ConstRows r, Rows p);
  std::optional<SolveStop> descend(const Equations& of, const cg::Limits& limits, SolveReport& report);
  double residualOf(const Equations& of, ConstRows x);

  MatrixKey key_;
  Index nodes_ = 0;
  double weight_ = 1;  ///< of the lower part of the residual [N/m^3]
  std::unique_ptr<PressureRows> volumes_;
  std::unique_ptr<Compressible> compressible_;
  Multigrid inverse_;
  cg::BlockJacobi diagonal_;  ///< D^-1
  BlockMatrix x_;
  FormerMatrix shown_x_;
  Factorisation* factors_ = nullptr;   ///< of X
  Vector positions_;                   ///< that V was made for
  bool has_positions_ = false;         ///< they are to serve again
  std::vector<Vector> basis_, steps_;  ///< each of displacements, then pressures
  Vector both_, trial_, forces_, moved_, pressures_, sums_;
};

}  // namespace stroma
