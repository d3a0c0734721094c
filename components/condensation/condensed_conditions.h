// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <Eigen/Dense>
#include <array>
#include <span>
#include <vector>

#include "framework/algebra/mixing.h"
#include "framework/mechanics/condition_forces.h"

namespace stroma {

/// What a condensed body knows of the conditions of Lagrangian constraints on it (condensed_conditions.cpp). Nodes are
/// active; those of the conditions have numbers of their own, slots. Rows of other bodies follow as further nodes.
struct CondensedConditions {
  struct Entry {
    Index slot;
    Vec3 gradient;
  };
  static std::span<const Entry> of(Eigen::Index row, const std::vector<Entry>& entries, const std::vector<std::size_t>& first) {
    return std::span(entries).subspan(first[std::size_t(row)], first[std::size_t(row) + 1] - first[std::size_t(row)]);
  }
  std::vector<LagrangianConstraint*> constraints;
  LagrangianRows rows, rows_before;
  std::vector<std::size_t> ends;  ///< of the rows of each constraint
  std::vector<Entry> entries;     ///< of all rows on nodes that can move
  std::vector<std::size_t> first_entry;
  std::vector<Entry> pushing;  ///< the same of D, along which forces act
  std::vector<std::size_t> first_pushing;
  ConditionForces solve;
  std::vector<Eigen::Index> live;  ///< rows of its W
  std::vector<double> allowed;  ///< by how much each row may be off [m]; work space
  std::vector<double> taken;  ///< the forces of the last step [N]
  Vector start;               ///< x where the step starts, shape (allRows())
  double extent = 0;          ///< of the body [m]

  std::vector<Index> nodes;  ///< of slots
  std::vector<Index> slot;   ///< of an active node, or -1
  Eigen::MatrixXd stored;    ///< C of all slots, shape (3 slots, 3 slots)
  std::vector<Index> old_nodes, old_slot;  ///< of the step before, with its part of C
  Eigen::MatrixXd old_stored;
  void beginSlots();
  Eigen::MatrixXd c;         ///< the same without the share of touched nodes, shape (3 slots, 3 slots)
  Eigen::MatrixXd response;  ///< C D^T, shape (3 slots, rows)
  Eigen::VectorXd free, u;   ///< displacements without and with forces, shape (3 slots)
  Eigen::VectorXd force;     ///< D^T l, shape (3 slots)
  std::vector<Vec3> others;  ///< of it that on rows of other bodies; work space
  Eigen::MatrixXd touched;   ///< what touched nodes take of C, shape (touches, 3 slots)
  Eigen::VectorXd reaction;  ///< of touched nodes, shape (touches)
  std::vector<Index> loaded;
  std::vector<std::array<double, 3>> loads;
  Eigen::VectorXd next, before;
  bool swings = false;  ///< in the last step directions of forces have not come to rest
  bool is_changing = false;  ///< in the last step conditions have not come to an end
  int swinging = 0;     ///< steps

  /// The next place after rounds from `before` to u.
  void mix();
  Mixing mixing;
  Vector from, to;  ///< `before` and u as whole rows
};

}  // namespace stroma
