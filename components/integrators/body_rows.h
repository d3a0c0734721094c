// SPDX-License-Identifier: LGPL-2.1-or-later
// Conditions on free rigid bodies, each on at most two: J and A^-1 J^T of a row are twelve numbers each, for any number of bodies.
// A then consists of one 6 x 6 block K per body, and rows are coupled only through common bodies:
//   W_ij = weight displacement sum over common bodies b of J_ib K_b^-1 J_jb^T
// so that W is not needed: with the motion m = sum over j of K^-1 J_j^T l_j of all bodies, (W l)_i = weight displacement J_i . m, and a
// change of l_i changes m in two bodies. Physics engines sweep in this way (Catto 2005; Todorov 2014). A sweep reads 24 numbers per row,
// while W has 9 for every row that shares a body with it.
//
// K^-1 comes from the solver of the scene with six unit loads, on all bodies at once. A seventh load checks it: if the answer differs,
// something couples the bodies, and this class is not used.
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
  static constexpr int width = 2 * row_doubles;  ///< numbers per body: two rows, each padded by a zero
  static constexpr int loads = 7;
  using Numbers = Eigen::Matrix<double, width, 1>;
  using Block = Eigen::Matrix<double, width, width>;
  /// J and K^-1 J^T of a condition on bodies whose first rows are `at`; with one body the second block is zero, at the same row.
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
  /// Finds the bodies from the pattern of the matrix. False: there are none.
  bool findBodies(SystemMatrix& matrix);
  /// Unit load `number` on all bodies; shape (independent rows).
  void load(int number, Rows out) const;
  /// Sets K^-1 from the solutions for all loads. False: bodies are coupled.
  bool takeAnswers(std::span<const Vector> loads_of_all, std::span<const Vector> answers);
  /// Takes J of the rows `live`. False: one acts on something else, or on three bodies.
  bool take(const LagrangianRows& rows, const std::vector<std::size_t>& live);
  /// Sets K^-1 J^T of the rows taken, after takeAnswers().
  void respond();
  const std::vector<Row>& rows() const { return rows_; }
  int touched() const { return touched_; }  ///< number of bodies with rows
  /// Returns factor J_i . K^-1 J_j^T.
  static double couple(const Row& i, const Row& j, double factor);
  /// Computes W.
  void couple(double factor, Eigen::MatrixXd& w) const;

 private:
  bool add(Index at, const Vec3& gradient, Row& row) const;
  void readMappings();

  System* system_ = nullptr;
  MatrixKey key_;                  ///< of the matrix that body_of_ is from
  std::vector<Index> first_;       ///< first row of each body
  std::vector<int> body_of_;       ///< per independent row; -1: not of a body
  std::vector<Block> inverse_;     ///< K^-1 of each body
  std::vector<JacobianBlock> blocks_;  ///< of all mappings
  std::vector<std::size_t> order_, begin_;  ///< blocks_ sorted by child row; for each row the start of its range in order_
  std::vector<Row> rows_;
  std::vector<std::vector<int>> rows_of_;  ///< per body
  int touched_ = 0;
};

}  // namespace stroma
