// SPDX-License-Identifier: LGPL-2.1-or-later
// The equations of the last step of each system, kept while somebody asks for them.
#pragma once
#include <map>
#include <memory>

#include "tools/python/python.h"
#include "framework/simulation/step_watch.h"

namespace stroma {
class System;
}

namespace stroma::python {

/// Keeps A, b and x of the last linear solve that a step made for its motion, and the gradients J of Lagrangian constraints where
/// the forces of that step got their directions. Solves that answer single forces of constraint are not among them.
class LastSolve final : public StepWatch {
 public:
  void solved(SystemMatrix& matrix, ConstRows b, ConstRows x) override;
  void constraintGradients(const System& system, const LagrangianRows& rows, double displacement) override;
  /// (A, held, b, x): blocks of A as matrix_of() has them; the projectors P of its rows, shape (rows, 3, 3), with A = P A P where P is
  /// not the identity; b and x of shape (rows, 3). Throws ComponentError where no step has been watched.
  py::tuple equations(System& system, bool has_changed_meshes) const;
  /// (row starts, columns, values, displacement): J as compressed rows of numbers, 3 columns for each row of the system. On mapped rows
  /// J is that of their own motion, on independent ones that of all; held directions are in it.
  py::tuple gradients(const System& system, bool has_changed_meshes) const;
  bool keeps_matrices = false;  ///< A, b and x, which cost an assembly in each step
  /// Steps of this thread are watched as long as it lives.
  class Watching {
   public:
    explicit Watching(StepWatch* watch) : before_(stepWatch()) { stepWatch() = watch; }
    ~Watching() { stepWatch() = before_; }
    Watching(const Watching&) = delete;

   private:
    StepWatch* before_;
  };

 private:
  struct Equations {
    std::shared_ptr<const int> identity;  ///< of the matrix: no other gets its address
    BlockMatrix matrix;
    std::vector<double> b, x;  ///< shape (rows, 3)
    std::vector<int> row_starts, columns;
    std::vector<double> gradients;
    double displacement = 0;
    bool has_gradients = false;
  };
  std::map<const int*, Equations> systems_;
};

}  // namespace stroma::python
