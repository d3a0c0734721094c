// SPDX-License-Identifier: LGPL-2.1-or-later
// Constraint forces by Gauss-Seidel sweeps that end at a tolerance; constraint_sweeps.cpp.
#pragma once
#include <Eigen/Dense>
#include <array>
#include <string>
#include <vector>

#include "framework/algebra/stop.h"
#include "framework/scene/component.h"

namespace stroma {

class ConstraintSweeps final : public Component {
 public:
  std::string roleText() const override { return "constraint solver"; }
  void declare(DataTable& table) override;
  /// Contacts that go on begin with the force of the step before.
  bool goesOnWithContacts() const { return goes_on_; }
  bool startsFromZero() const { return method_ == Method::unbuilt; }
  /// Rows that are solved together.
  struct Block {
    enum class Kind : unsigned char { equal, push, rub } kind = Kind::equal;  ///< rub: a push and the two rows of its friction
    int width = 1;
    bool turns = false;  ///< the relative orientation of two frames
    int first = 0;       ///< row
    double mu = 0;       ///< coefficient of friction
    bool goes_on = true;  ///< its forces start from those of the step before
    std::array<int, 2> name{};  ///< of a contact, the same from step to step
  };
  /// Solves g + W l = 0, starting from l. `impulse`: per unit of l [s]. Returns the number of sweeps. A stop ends it early.
  int solve(const Eigen::MatrixXd& w, const Eigen::VectorXd& g, const std::vector<Block>& blocks, double impulse, StopToken stop,
            Eigen::VectorXd& l);
  /// A warning if the last solve() has not reached its tolerance; otherwise empty.
  const std::string& unsettled() const { return unsettled_; }
  bool keepsUnsettled() const { return keeps_unsettled_; }
  /// Warns that all of them in the scene of `asker` have no effect, and why: once per reason.
  static void tellIdle(const Component& asker, const std::string& why);

 private:
  using Numbers = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, 3, 1>;  ///< of the rows of a block
  using Square = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, 3, 3>;
  struct Sweep {
    double error = 0;       ///< sum of the changes of conditions
    bool verified = true;   ///< no row changes by more than the tolerance
  };
  void pushBlock(const Block& block, Eigen::VectorXd& l);
  Sweep sweep(const Eigen::VectorXd& g, const std::vector<Block>& blocks, double tolerance, Eigen::VectorXd& l);
  bool isOver(const Sweep& sweep, double tolerance);
  int search(const Eigen::VectorXd& g, const std::vector<Block>& blocks, double tolerance, StopToken stop, Eigen::VectorXd& l);
  int searchByGradients(const Eigen::VectorXd& g, const std::vector<Block>& blocks, double tolerance, StopToken stop, Eigen::VectorXd& l);

  enum class Method : int { built, unbuilt, gradients, complementarity } method_ = Method::built;
  int most_ = 1000;
  double tolerance_ = 1e-3, turn_tolerance_ = 1e-4, relaxation_ = 1, softness_ = 0;
  bool scales_ = true, all_verified_ = false, keeps_unsettled_ = false, goes_on_ = false;
  bool is_over_ = false;  ///< ended by the tolerance
  double last_error_ = 0;  ///< of the last sweep
  std::string unsettled_, idle_;  ///< the last reason why it has no effect
  Eigen::MatrixXd w_;  ///< with the softness
  Numbers off_;        ///< g + W l of a block
  Eigen::VectorXd old_, change_, last_change_, way_;
};

}  // namespace stroma
