// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <vector>

#include "framework/algebra/linear_solver.h"
#include "framework/simulation/system.h"

namespace stroma {

/// Bodies too light to affect |R| beside bodies that are orders of magnitude heavier, like a gram of tissue in a steel frame. Newton's
/// method ends by |R|, and therefore after one linear solve for them. Each state is a body with the rows R_b. It is out of balance if
///
///   |R_b| > max(1e-2, 1000 tolerance) S_b   and   max |D^-1 R_b| > 1e-9 max |x_b|
///
/// with S_b the largest of |R_b| and |f_b| at the start of the solve and of the loads on it, and D the diagonal blocks of the tangent;
/// anything less is round-off. It is then solved separately: the residual is that of its rows only, and the line search uses the work,
/// because the total energy has no digits for it.
///
/// With constraint forces all bodies are solved together, and convergence is linear rather than quadratic: the first bound is then
/// max(1e-5, 1000 tolerance) S_b. A body that was once out of balance is tracked from then on, by |R_b| / S_b beside the total |R|.
class LightBodies {
 public:
  void compile(System& system);
  /// Starts a solve with R, in the unit of `weight` times forces, and with the forces of System::f.
  void begin(ConstRows residual, double weight);
  /// Focuses the residual on one body, the one most out of balance that has not been handled since begin(). Returns false if there
  /// is none.
  bool focus(ConstRows residual, double tolerance, double weight, SystemMatrix& tangent, double displacement);
  void end() { in_focus_ = nullptr; }
  /// The body most out of balance; null: none. `carried`: forces in R that are unknowns too, such as constraint forces; they
  /// enter S_b.
  const State* outOfBalance(ConstRows residual, ConstRows carried, double tolerance, double weight, SystemMatrix& tangent,
                            double displacement);
  /// The root of the sum of (|R_b| / S_b)^2 over bodies found out of balance since begin(); 0: there are none.
  double left(ConstRows residual) const;
  /// The number of bodies found out of balance since begin().
  std::size_t found() const;
  /// None of them violates the first bound.
  bool areLittle(ConstRows residual, double tolerance) const;
  /// Sets the rows of all other bodies to zero, in focus.
  void narrow(Rows residual) const;
  double scale() const { return in_focus_->size(); }              ///< S_b
  const State& body() const { return *in_focus_->state; }

 private:
  struct Body {
    const State* state;
    Index first, count;
    double scale = 0;
    double carried = 0;  ///< constraint forces at the last outOfBalance(), which may be far smaller than in earlier iterations
    double size() const { return scale > carried ? scale : carried; }  ///< S_b
    bool is_done = false;
    bool is_found = false;  ///< out of balance since begin()
  };
  void find(ConstRows residual, double share, double weight, SystemMatrix& tangent, double displacement);

  System* system_ = nullptr;
  std::vector<Body> bodies_;  ///< empty where there is one
  Body* in_focus_ = nullptr;
  Vector loads_;
};

/// A linear step by products ends by the |b - A x| of all, which says nothing of a body whose b is decades smaller. Such a body is solved
/// on by itself, A c = r_b with the rows of all others zero, x += c, where |r_b| / |b_b| is more than ten times the |r| / |b| of all.
/// `report`: of the solve of all.
void solveLightBodies(const System& system, LinearSolver& solver, SystemMatrix& matrix, ConstRows b, Rows x, const SolveTerms& terms,
                      StepReport& report);

}  // namespace stroma
