// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <vector>

#include "framework/mechanics/motion.h"
#include "framework/mechanics/projective_constraint.h"

namespace stroma {

/// Nodes that several prescribed motions place. Each motion i fixes the part H_i x of a position, H_i = I - P_i, so
/// that together they ask for
///   (sum H_i) (x' - x) = sum H_i (x_i - x)
/// with x_i where motion i alone puts the node: x' is the place nearest to x that all agree on, found at once. Going
/// there in turns would only approach it. Of orientations the differences are increments. Without such a place the
/// equation gives the one between, and meet() says so.
class SharedPlacements {
 public:
  /// Room for `count` calls' worth of nodes: nothing else allocates.
  void reserve(std::size_t count) { entries_.reserve(count); }
  void clear() { entries_.clear(); }
  /// The nodes that a motion places; `constraint`: its number in the system.
  void add(int constraint, const NodeProjector* begin, const NodeProjector* end);
  /// Forgets the nodes of one motion only. After the last add().
  void keepShared();
  bool empty() const { return entries_.empty(); }

  /// To be called when motion `constraint` has placed its nodes in x [m] and v [m/s].
  void note(int constraint, ConstRows x, ConstRows v);
  /// A node with conflicting prescribed positions.
  struct Conflict {
    Index row = -1;       ///< -1: there is none
    int a = 0, b = 0;     ///< two conflicting motions
    double distance = 0;  ///< [m], to where a puts it
  };
  /// Puts the nodes where all motions noted agree; returns the worst conflict.
  Conflict meet(const Motion& motion, Rows x, Rows v) const;

 private:
  struct Entry {
    Index row;
    int constraint;
    Mat3 held;          ///< H_i
    Eigen::Vector4d x;  ///< where the motion alone puts the node
    Vec3 v;             ///< and how fast
  };
  using Iterator = std::vector<Entry>::const_iterator;
  Iterator endOfRow(Iterator first) const;
  std::vector<Entry> entries_;  ///< by row, then by constraint
};

}  // namespace stroma
