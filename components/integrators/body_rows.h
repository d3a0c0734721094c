// SPDX-License-Identifier: LGPL-2.1-or-later
// Conditions on free rigid bodies, of two at most each: J and A^-1 J^T of a row are twelve numbers each, however many bodies there are.
// A then consists of a block K of 6 x 6 for each body, and rows share what moves in bodies alone:
//   W_ij = weight displacement sum over common bodies b of J_ib K_b^-1 J_jb^T
// so that W need not be made: with the motion m = sum over j of K^-1 J_j^T l_j of all bodies, (W l)_i = weight displacement J_i . m, and a
// change of l_i changes m in two bodies. Physics engines sweep in this way (Catto 2005; Todorov 2014). For each row 24 numbers are read
// in a sweep, and W has 9 for each row of the two bodies that it shares one with.
//
// K^-1 is what the solver of the scene answers to six unit loads, on all bodies at once, and a seventh load is answered as these say: else
// something couples bodies, and rows are not taken as of bodies.
#pragma once
#include <array>
#include <span>
#include <vector>

#include <Eigen/Dense>

#include "framework/mechanics/lagrangian_constraint.h"
#include "framework/mechanics/mapping.h"
#include "framework/simulation/system.h"

namespace stroma {

class BodyRows {
 public:
  static constexpr int width = 2 * row_doubles;  ///< numbers of a body: two rows, each with a zero after three
  static constexpr int loads = 7;
  using Numbers = Eigen::Matrix<double, width, 1>;
  using Block = Eigen::Matrix<double, width, width>;
  /// J and K^-1 J^T of a condition on bodies whose first rows are `at`; with one body the second has zeros, at the first one's place.
  struct Row {
    alignas(64) std::array<Numbers, 2> j, y;
    std::array<Index, 2> at{0, 0};
    int bodies = 0;
    double along(const double* motion) const {
      return j[0].dot(Eigen::Map<const Numbers>(motion + row_doubles * at[0])) +
             j[1].dot(Eigen::Map<const Numbers>(motion + row_doubles * at[1]));
    }
    /// motion += by K^-1 J^T
    void move(double by, double* motion) const {
      Eigen::Map<Numbers>(motion + row_doubles * at[0]) += by * y[0];
      Eigen::Map<Numbers>(motion + row_doubles * at[1]) += by * y[1];
    }
  };

  void compile(System& system);
  /// Finds the bodies in what the matrix couples. False: there are none.
  bool findBodies(SystemMatrix& matrix);
  /// The load on all of them of this number; shape (independent rows).
  void load(int number, Rows out) const;
  /// K^-1, of what the matrix answers to each load. False: bodies are coupled.
  bool takeAnswers(std::span<const Vector> loads_of_all, std::span<const Vector> answers);
  /// The rows `live` of all. False: one is of something else, or of three bodies.
  bool take(const LagrangianRows& rows, const std::vector<std::size_t>& live);
  const std::vector<Row>& rows() const { return rows_; }
  int touched() const { return touched_; }  ///< bodies that rows are of
  /// factor J_i . K^-1 J_j^T
  static double couple(const Row& i, const Row& j, double factor);
  /// W
  void couple(double factor, Eigen::MatrixXd& w) const;

 private:
  bool add(Index at, const Vec3& gradient, Row& row) const;
  void readMappings();

  System* system_ = nullptr;
  MatrixKey key_;                  ///< of the matrix of body_of_
  std::vector<Index> first_;       ///< of each body, its first row
  std::vector<int> body_of_;       ///< of each independent row; -1: of something else
  std::vector<Block> inverse_;     ///< K^-1 of each body
  std::vector<JacobianBlock> blocks_;  ///< of all mappings
  std::vector<std::size_t> order_, begin_;  ///< of blocks_ by children; where those of each row of all begin in order_
  std::vector<Row> rows_;
  std::vector<std::vector<int>> rows_of_;  ///< of each body
  int touched_ = 0;
};

}  // namespace stroma
