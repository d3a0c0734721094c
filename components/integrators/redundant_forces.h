// SPDX-License-Identifier: LGPL-2.1-or-later
// Forces of many conditions on few ways to move, as of rigid bodies whose faces meet in many points: W (condition_forces.h) is
// L L^T with less than half as many columns as rows. Such rows say the same, or contradict each other by a little, and no force is
// the only one. With r + shift (q - where) instead of r there is one: proximal points (Rockafellar 1976) draw it from where forces
// were, with Newton's method; where that finds none it begins from an interior-point method for where = 0.
//
// With x = (mu l_n, l_t) and z = (r_n / mu + |r_t|, r_t) of each group, both are in the cone x_0 >= |x_t| and x . z = 0 (De Saxce
// and Feng 1998). A round goes towards x o z = share nu e, nu the mean of x . z; |r_t| is (|r_t|^2 + smooth nu^2 / (x_0^2 + nu))^.5:
//   (W + F) dx = share nu x^-1 - z - T ((T x)^-1 o c) - (z(x) - z),   F x = z,   F = T T = e (2 w w^T - J),   J = diag(1, -1, -1)
// with |x|^2 = x_0^2 - |x_t|^2, e = |z| / |x|, w the middle of z / |z| and J x / |x|, |w| = 1 (Nesterov and Todd 1998), and
// c = T dx o T^-1 dz of a first way without share (Mehrotra 1992). Of rows that are equal z = 0 and x is free. W then has the
// derivative D r of |r_t|, but after a short way; F is (1 - D) F.
//
// Newton's method is that of condition_forces.h. Both solve, with blocks A and B of groups,
//   (A W + B) d = b,   C = A shift + B:   d = y - C^-1 A L (1 + L^T C^-1 A L)^-1 L^T y,   y = C^-1 b
#pragma once
#include <Eigen/Dense>
#include <utility>
#include <vector>

#include "framework/algebra/stop.h"
#include "framework/mechanics/lagrangian_constraint.h"

namespace stroma {

class RedundantForces {
 public:
  using Kind = LagrangianRows::Kind;
  using Row = LagrangianRows::Row;

  /// `live`: the rows of w; g, sizes and l are of all rows. False: these are not such conditions, and l is left as it is.
  bool find(const std::vector<Row>& rows, const std::vector<std::size_t>& live, const Eigen::MatrixXd& w, const Eigen::VectorXd& g,
            const std::vector<double>& sizes, Eigen::VectorXd& l, StopToken stop);
  /// What is off with the forces found, where rows contradict each other; else 0. As ConditionForces::contradiction.
  double contradiction() const { return contradiction_; }

 private:
  /// Rows [first, first + size): one that is equal, or a push and what rubs there.
  struct Group {
    bool pushes = false;
    Eigen::Index first = 0, size = 1;
    double mu = 0, rate = 0;  ///< rate: of the tangents' block of W
    Eigen::Index tangents() const { return size - 1; }
  };
  struct Blocks;
  struct Inside;

  bool scaleRows(const std::vector<Row>& rows, const std::vector<std::size_t>& live, const Eigen::MatrixXd& w, const Eigen::VectorXd& g,
                 const std::vector<double>& sizes, const Eigen::VectorXd& l);
  bool findGroups(const std::vector<Row>& rows, const std::vector<std::size_t>& live);
  bool findRoot();
  double offOf(const Eigen::VectorXd& q, const Eigen::VectorXd& r) const;
  Eigen::VectorXd stepFrom(Eigen::VectorXd& q, Eigen::VectorXd& r, double shift) const;
  double newton(double shift, const Eigen::VectorXd& where, Eigen::VectorXd& q) const;
  bool draw(double shift, Eigen::VectorXd where, Eigen::VectorXd q);
  Eigen::VectorXd searchInside(double shift) const;
  void note(const Eigen::VectorXd& q);

  std::vector<Group> groups_;                              ///< of rows that something moves
  std::vector<std::pair<Eigen::Index, Eigen::Index>> all_;  ///< first row and rows of all groups and other rows
  Eigen::Index widest_ = 1;
  Eigen::VectorXd scale_, offset_, start_, best_, last_;  ///< in units in which W has a diagonal of one; start_, best_, last_: forces
  Eigen::MatrixXd w_, root_;                              ///< W and L
  double size_ = 0, off_ = 0, contradiction_ = 0;         ///< off_: of best_, of size_
  StopToken stop_;
};

}  // namespace stroma
