// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/algebra/per_matrix.h"

#include <gtest/gtest.h>

#include <new>

#include "tests/support/stored_matrix.h"

namespace stroma::test {
namespace {

BlockMatrix diagonal() { return BlockMatrix(BlockPattern(2)); }

TEST(PerMatrix, KeepsOneForEachMatrix) {
  PerMatrix<int> kept;
  StoredMatrix a(diagonal()), b(diagonal());
  kept.of(a) = 1;
  kept.of(b) = 2;
  int* const first = &kept.of(a);
  EXPECT_EQ(*first, 1);
  EXPECT_EQ(kept.of(b), 2);
  ++a.revision_number;
  EXPECT_EQ(&kept.of(a), first) << "other values are no other matrix";
  const StoredMatrix moved(std::move(a));
  EXPECT_EQ(&kept.of(moved), first);
  EXPECT_EQ(kept.size(), 2u);
}

TEST(PerMatrix, AMatrixAtTheSamePlaceIsAnother) {
  PerMatrix<int> kept;
  alignas(StoredMatrix) std::byte place[sizeof(StoredMatrix)];
  for (int life = 0; life < 3; ++life) {
    auto* matrix = new (place) StoredMatrix(diagonal());
    EXPECT_EQ(kept.of(*matrix), 0) << "what was kept for the one that has died";
    kept.of(*matrix) = 7;
    matrix->~StoredMatrix();
  }
  EXPECT_EQ(kept.size(), 1u) << "the dead are forgotten when another one comes";
}

TEST(MatrixKey, TellsIdentityPatternValuesAndShiftApart) {
  StoredMatrix a(diagonal()), b(diagonal());
  const MatrixKey key = a.key();
  EXPECT_TRUE(key == a.key());
  EXPECT_FALSE(key == b.key());
  ++a.revision_number;
  EXPECT_FALSE(key == a.key());
  --a.revision_number, ++a.pattern_number;
  EXPECT_FALSE(key == a.key());
  --a.pattern_number;
  MatrixKey shifted = a.key();
  shifted.shift = 1e-3;
  EXPECT_FALSE(key == shifted);
}

}  // namespace
}  // namespace stroma::test
