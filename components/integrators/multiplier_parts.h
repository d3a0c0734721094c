// SPDX-License-Identifier: LGPL-2.1-or-later
// Parts of the search for forces of constraint (multipliers.h).
#pragma once
#include <Eigen/Dense>
#include <span>
#include <vector>

#include "framework/algebra/mixing.h"
#include "framework/algebra/vector.h"

namespace stroma {

/// How gradients turn with x, as a part of the matrix: A + B S B^T in the place of A, of a few columns of B.
class GradientBends {
 public:
  struct Bend {
    double size;  ///< S
    Vector b, y;  ///< columns of B and Y = A^-1 B, shape (independent rows)
  };
  void clear() { count_ = 0; }
  bool empty() const { return count_ == 0; }
  /// A column of B, to be filled.
  Vector& add(double size, Index rows);
  std::span<Bend> all() { return {bends_.data(), count_}; }
  /// S^-1 + B^T Y, when all Y are known.
  void factor();
  /// What A^-1 has answered becomes what A + B S B^T answers.
  void takeFrom(Rows response);

 private:
  std::vector<Bend> bends_;  ///< the first count_ of them
  std::size_t count_ = 0;
  Eigen::PartialPivLU<Eigen::MatrixXd> factors_;
  Eigen::VectorXd along_, shares_;  ///< work space, as is
  Eigen::MatrixXd matrix_;
};

/// Which directions of rows of W are not zero where a response is not: of free rigid bodies those of the bodies that it moves.
class DirectionOverlaps {
 public:
  /// Of the rows `live`, which stay where they are; `rows`: of each direction.
  void find(const std::vector<Vector>& directions, const std::vector<std::size_t>& live, Index rows);
  /// Numbers of live rows; valid until the next call.
  const std::vector<std::size_t>& of(ConstRows response);
  /// The direction of a live row with a response.
  double along(std::size_t number, ConstRows response) const;

 private:
  const std::vector<Vector>* directions_ = nullptr;
  const std::vector<std::size_t>* live_ = nullptr;
  std::vector<Index> reached_;             ///< rows in which directions are not zero
  std::vector<std::size_t> first_;         ///< of each live row, in reached_
  std::vector<std::vector<std::size_t>> reaches_;  ///< of each row of directions: live rows whose direction is not zero there
  std::vector<std::size_t> found_;                 ///< work space, as are
  std::vector<long> marks_;
  long mark_ = 0;
};

/// J^T p that Newton's method carries as a load [N s], from where a step starts.
class CarriedForces {
 public:
  void resize(Index rows);
  /// A step starts with the forces of the one before; `weight`: p = weight l [s].
  void begin(double weight) { copy(last_, now_), scale(weight, now_); }
  void end(double weight) { copy(now_, last_), scale(1 / weight, last_); }
  ConstRows now() const { return now_; }
  void set(ConstRows now) { copy(now, now_); }
  ConstRows last() const { return last_; }  ///< J^T l of the step before [N]
  Vector& last() { return last_; }
  void forget() { stroma::clear(last_); }
  /// To be made the sum of J^T p that is carried from now on; change() follows.
  Rows beginChange();
  /// out += by how much that is another.
  void change(Rows out);
  /// Only this share of what the last change() added.
  void changeShare(double share, Rows out);
  /// The iterate `to` that came of `from` is mixed with those before, and what is carried with it.
  void mix(Mixing& mixing, ConstRows from, Rows to, Rows out);

 private:
  Vector now_, last_;
  Vector added_;  ///< by the last change(), with share_ of it
  double share_ = 1;
};

}  // namespace stroma
