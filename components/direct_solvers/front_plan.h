// SPDX-License-Identifier: LGPL-2.1-or-later
// The multifrontal form of a factorisation (Duff and Reid 1983): what each supernode leaves for those above it is one dense
// triangle, its update, that is added to the front of its parent and so on upwards.
#pragma once
#include <cstddef>
#include <vector>

#include "components/direct_solvers/front_kernels.h"
#include "components/direct_solvers/supernodal_plan.h"

namespace stroma {

/// Where everything of a multifrontal factorisation lies, from the pattern alone. A supernode with n columns and m rows below has
/// the triangle L11 of n x n and L21 of m x n behind it; columns are padded to front_rows.
struct FrontPlan {
  std::vector<int> parent;                     ///< -1 of roots, shape (supernodes)
  std::vector<int> child_start, children;      ///< ascending
  std::vector<int> run_start;                  ///< shape (supernodes + 1)
  std::vector<FrontRun> runs;                  ///< none goes across the parent's columns
  std::vector<std::size_t> values;             ///< of L11, shape (supernodes + 1)
  std::vector<std::size_t> vector;             ///< of a front's vector: its columns and what is below, each padded
  std::vector<std::size_t> update;             ///< in the memory of its part, or of all parts, shape (supernodes)
  std::vector<char> shared;                    ///< the update lies in the memory of all parts
  std::size_t shared_size = 0, part_size = 0;  ///< numbers of the updates at once
  std::vector<int> entry;                      ///< place of each value of the lower triangle behind `values` of its supernode
  TreeParts tree;
  double flops = 0;

  static int padded(int rows);
};

/// `lower_start`, `lower_rows`: the lower triangle by columns.
FrontPlan frontPlanOf(const SupernodalPattern& pattern, const int* lower_start, const int* lower_rows);

}  // namespace stroma
