// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <vector>

#include "components/iterative_solvers/multigrid_last_level.h"
#include "framework/algebra/block_matrix.h"
#include "framework/algebra/linear_solver.h"
#include "framework/scene/archive.h"

namespace stroma::amg {

class ProductLevel;

/// Levels of a smoothed aggregation (Vanek, Mandel, Brezina 1996), the first for the nodes of a system and the others for
/// groups of them, which move like rigid bodies.
struct Hierarchy {
  Level<3> fine;
  std::vector<Level<modes>> coarse;
  LastLevel last;
  double scale = 1;  ///< levels hold A times this
  MatrixKey made_of;  ///< and with these positions, none where they were not known
  Vector positions;
  std::vector<Index> held;  ///< rows with a direction that nothing couples to others, ascending

  /// z = B r, one V-cycle: symmetric. With `turns`, unit quaternions (x, y, z, w) of shape (rows), z = R B R^T r. With
  /// `products` these are the first level, of another matrix.
  void apply(ConstRows r, Rows z, const Vector* turns = nullptr, ProductLevel* products = nullptr);
  /// The numbers of the first level: apply() goes by products from now on.
  void dropFineBlocks() { fine.a.values = {}; }
  bool hasFineBlocks() const { return !fine.a.values.empty(); }
  int levels() const { return 1 + int(coarse.size()); }
  /// Patches smooth, not diagonal blocks: an iteration then takes twice as long.
  bool hasPatches() const { return fine.patches.exist(); }
  /// Bytes that it takes.
  std::size_t bytes() const;
  /// What apply() reads, not its work space.
  void serialize(Archive& archive);

 private:
  void applyWithProducts(ConstRows r, Rows z, const Vector* turns, ProductLevel& products, double size);
  template <int D>
  void cycle(Level<D>& level, std::size_t below);
};

/// Steps of the smoother before and after the coarse correction.
constexpr int smoother_steps = 2;

/// The hierarchy of a symmetric matrix. `positions` (of the rows; count 0: not known) give the six motions that no level
/// may resist. Null, and the report says why and where, when the matrix is not positive definite, as far as this shows,
/// or not finite, or it was stopped.
std::shared_ptr<Hierarchy> makeHierarchy(const BlockMatrix& matrix, ConstRows positions, SolveReport& report,
                                         StopToken stop);
/// Whether diagonal blocks hardly smooth it, so that its hierarchy would have patches.
bool hardlySmooths(const BlockMatrix& matrix);

}  // namespace stroma::amg
