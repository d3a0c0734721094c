// SPDX-License-Identifier: LGPL-2.1-or-later
// Blocks under their own weight, as the tests of multigrid and of the automatic choices solve them.
#pragma once
#include "tests/support/elastic_block.h"
#include "tests/support/solver_fixture.h"

namespace stroma::test {

inline ElasticBlock box(Index nx, Index ny, Index nz) {
  ElasticBlock block;
  block.cells = {nx, ny, nz};
  return block;
}

/// With its nodes where they are, unless `hides_nodes`.
inline StoredMatrix matrixOf(const ElasticBlock& block, bool hides_nodes = false) {
  StoredMatrix matrix = block.matrix();
  matrix.nodes.resize(hides_nodes ? 0 : std::size_t(matrix.rows()));
  for (Index k = 0; k < block.nodes(2) && !hides_nodes; ++k)
    for (Index j = 0; j < block.nodes(1); ++j)
      for (Index i = 0; i < block.nodes(0); ++i) matrix.nodes[std::size_t(block.node(i, j, k))] = Vec3(i, j, k);
  return matrix;
}

/// The block's own weight; nothing on the held floor.
inline Vector weight(const ElasticBlock& block) {
  Vector b(block.count());
  for (Index i = block.hold_floor ? block.node(0, 0, 1) : 0; i < b.count(); ++i) b[i] = Vec3(0.1, 0, -1);
  return b;
}

/// What a run that is taken up again with the solver `to` has of the one before.
inline void handOver(SolverInScene& from, SolverInScene& to, StoredMatrix& matrix) {
  Archive written;
  written.enter("solver"), from.solver->serializeFor(matrix, written);
  Archive reading = written.readable();
  reading.enter("solver"), to.solver->serializeFor(matrix, reading);
}

}  // namespace stroma::test
