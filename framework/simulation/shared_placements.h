// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <vector>

#include "framework/mechanics/motion.h"
#include "framework/mechanics/projective_constraint.h"

namespace stroma {

/// Nodes positioned by several prescribed motions. Each motion i fixes the part H_i x of a position, H_i = I - P_i, so
/// together they require
///   (sum H_i) (x' - x) = sum H_i (x_i - x)
/// with the position x_i given by motion i alone. x' is the point nearest to x that satisfies all of them, found in one
/// solve; applying them in turns would only converge to it. Differences of orientations are increments. If there is no
/// such point, the equation gives a compromise, and meet() reports the conflict.
class SharedPlacements {
 public:
  /// Reserves room for nodes of `count` motions: nothing else allocates.
  void reserve(std::size_t count) { entries_.reserve(count); }
  void clear() { entries_.clear(); }
  /// The nodes of a motion; `constraint`: its number in the system.
  void add(int constraint, const NodeProjector* begin, const NodeProjector* end);
  /// Drops nodes of a single motion. Call it after the last add().
  void keepShared();
  bool empty() const { return entries_.empty(); }

  /// Call it when motion `constraint` has positioned its nodes in x [m] and v [m/s].
  void note(int constraint, ConstRows x, ConstRows v);
  /// A node with conflicting positions.
  struct Conflict {
    Index row = -1;       ///< -1: no conflict
    int a = 0, b = 0;     ///< two motions that conflict
    double distance = 0;  ///< [m], to the position given by a
  };
  /// Moves the nodes to the positions that satisfy all motions noted; returns the worst conflict.
  Conflict meet(const Motion& motion, Rows x, Rows v) const;

 private:
  struct Entry {
    Index row;
    int constraint;
    Mat3 held;          ///< H_i
    Eigen::Vector4d x;  ///< position of the node given by this motion alone
    Vec3 v;             ///< velocity of the node given by this motion alone
  };
  using Iterator = std::vector<Entry>::const_iterator;
  Iterator endOfRow(Iterator first) const;
  std::vector<Entry> entries_;  ///< by row, then by constraint
};

}  // namespace stroma
