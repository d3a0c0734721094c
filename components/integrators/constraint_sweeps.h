// SPDX-License-Identifier: LGPL-2.1-or-later
// Forces of constraint by sweeps that end at a tolerance; constraint_sweeps.cpp.
#pragma once
#include <Eigen/Dense>
#include <vector>

#include "framework/scene/component.h"

namespace stroma {

class ConstraintSweeps final : public Component {
 public:
  std::string roleText() const override { return "constraint solver"; }
  void declare(DataTable& table) override;
  bool startsFromZero() const { return method_ == Method::unbuilt; }
  /// Rows that are solved together.
  struct Block {
    int width = 1;
    bool turns = false;  ///< how two frames are turned to each other
  };
  /// l of g + W l = 0, from where l is. `impulse`: of a unit of l [s]. Gives how many sweeps.
  int solve(const Eigen::MatrixXd& w, const Eigen::VectorXd& g, const std::vector<Block>& blocks, double impulse, Eigen::VectorXd& l);
  /// Says of all in the scene of `asker` that they do not count, and why.
  static void tellIdle(const Component& asker, const std::string& why);

 private:
  struct Sweep {
    double error = 0;       ///< by how much conditions still moved, a sum
    bool verified = true;   ///< no row by more than the tolerance
  };
  Sweep sweep(const Eigen::VectorXd& g, const std::vector<Block>& blocks, double tolerance, Eigen::VectorXd& l);
  bool isOver(const Sweep& sweep, double tolerance) const { return all_verified_ ? sweep.verified : sweep.error < tolerance; }
  int searchByGradients(const Eigen::VectorXd& g, const std::vector<Block>& blocks, double tolerance, Eigen::VectorXd& l);

  enum class Method : int { built, unbuilt, gradients } method_ = Method::built;
  int most_ = 1000;
  double tolerance_ = 1e-3, turn_tolerance_ = 1e-4, relaxation_ = 1, softness_ = 0;
  bool scales_ = true, all_verified_ = false;
  Eigen::MatrixXd w_;  ///< with the softness
  Eigen::VectorXd old_, off_, change_, last_change_, way_;
};

}  // namespace stroma
