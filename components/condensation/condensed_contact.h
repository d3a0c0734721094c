// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <Eigen/Dense>
#include <vector>

#include "framework/algebra/block_matrix.h"
#include "framework/algebra/memory.h"
#include "framework/simulation/step_limits.h"

namespace stroma {

/// What a condensed body knows of barriers that push its kept nodes (condensed_contact.cpp); slots are CondensedConditions'.
struct CondensedContact {
  std::vector<ForceField*> fields;
  StepLimits limits;

  bool is_at_start = false;
  double part = 0;                  ///< s: of the way to where the body would go without barriers
  Array<double> now, goal, way;     ///< u, u_0, and the correction d of an iteration, shape (padded)
  Array<double> from;               ///< u before the correction, shape (padded)
  Array<double> still;              ///< u where the step starts, shape (padded)
  Eigen::VectorXd push, next_push;  ///< p and q, shape (3 slots)
  Vector force;                     ///< f at u, shape (allRows())
  Vector rows;                      ///< d on all rows, shape (independentRows())

  BlockMatrix stiffness;        ///< -df/du on all rows
  std::vector<long> revisions;  ///< patterns of the fields that it has
  std::vector<Index> touched;   ///< rows that are pushed, or would be where they moved
  std::vector<Index> place;     ///< of a row in `touched`, or -1
  Eigen::MatrixXd matrix;       ///< I + H C on `touched`
  Eigen::MatrixXd compliance;   ///< C on `touched`
  Eigen::VectorXd right;
  Eigen::PartialPivLU<Eigen::MatrixXd> factor;
  double residual = 0;  ///< |f - p| of the last iteration, relative
};

}  // namespace stroma
