// SPDX-License-Identifier: LGPL-2.1-or-later
// Parts of the search for constraint forces (multipliers.h).
#pragma once
#include <Eigen/Dense>
#include <span>
#include <vector>

#include "framework/algebra/mixing.h"
#include "framework/algebra/vector.h"

namespace stroma {

/// The change of gradients with x as a part of the matrix: A + B S B^T instead of A, with few columns of B.
class GradientBends {
 public:
  struct Bend {
    double size;  ///< S
    Vector b, y;  ///< columns of B and Y = A^-1 B, shape (independent rows)
  };
  void clear() { count_ = 0; }
  bool empty() const { return count_ == 0; }
  /// Adds a column of B, which the caller fills.
  Vector& add(double size, Index rows);
  std::span<Bend> all() { return {bends_.data(), count_}; }
  /// Factors S^-1 + B^T Y; call it when all Y are known.
  void factor();
  /// Changes a response of A^-1 to the one of (A + B S B^T)^-1.
  void takeFrom(Rows response);

 private:
  std::vector<Bend> bends_;  ///< the first count_ of them
  std::size_t count_ = 0;
  Eigen::PartialPivLU<Eigen::MatrixXd> factors_;
  Eigen::VectorXd along_, shares_;  ///< work space, like the next
  Eigen::MatrixXd matrix_;
};

/// Finds the rows of W whose direction overlaps a response, that is, both are nonzero in some row: for free rigid bodies those of the
/// bodies that it moves.
class DirectionOverlaps {
 public:
  /// For the rows `live` of `directions`, both of which must stay in place; each direction has `rows` rows.
  void find(const std::vector<Vector>& directions, const std::vector<std::size_t>& live, Index rows);
  /// The numbers of live rows that overlap `response`; valid until the next call.
  const std::vector<std::size_t>& of(ConstRows response);
  /// The product of the direction of a live row with a response.
  double along(std::size_t number, ConstRows response) const;

 private:
  const std::vector<Vector>* directions_ = nullptr;
  const std::vector<std::size_t>* live_ = nullptr;
  std::vector<Index> reached_;             ///< rows in which directions are nonzero
  std::vector<std::size_t> first_;         ///< per live row: its start in reached_
  std::vector<std::vector<std::size_t>> reaches_;  ///< per row of directions: live rows whose direction is nonzero there
  std::vector<std::size_t> found_;                 ///< work space, like the next
  std::vector<long> marks_;
  long mark_ = 0;
};

/// The load J^T p [N s] that Newton's method carries through a step.
class CarriedForces {
 public:
  void resize(Index rows);
  /// Starts a step with the forces of the previous one; `weight`: p = weight l [s].
  void begin(double weight) { copy(last_, now_), scale(weight, now_); }
  void end(double weight) { copy(now_, last_), scale(1 / weight, last_); }
  ConstRows now() const { return now_; }
  void set(ConstRows now) { copy(now, now_); }
  ConstRows last() const { return last_; }  ///< J^T l of the previous step [N]
  Vector& last() { return last_; }
  void forget() { stroma::clear(last_); }
  /// The caller writes the new sum of J^T p here and then calls change().
  Rows beginChange();
  /// out += the change of the load.
  void change(Rows out);
  /// Keeps only this fraction of the last change(); out += the difference.
  void changeShare(double share, Rows out);
  /// Mixes the iterate `to`, computed from `from`, and its load with earlier ones.
  void mix(Mixing& mixing, ConstRows from, Rows to, Rows out);

 private:
  Vector now_, last_;
  Vector added_;  ///< by the last change(), of which share_ is kept
  double share_ = 1;
};

}  // namespace stroma
