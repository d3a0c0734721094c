// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <vector>

#include "framework/algebra/linear_solver.h"
#include "framework/simulation/system.h"

namespace stroma {

/// Bodies whose balance the |R| of all does not see, beside others that are decades heavier: a tissue of a gram in a frame of steel.
/// Newton's method ends by |R|, and so after one linear solve for them. A state is a body here, R_b its rows. It is out of balance where
///
///   |R_b| > max(1e-2, 1000 tolerance) S_b   and   max |D^-1 R_b| > 1e-9 max |x_b|
///
/// with S_b the largest of |R_b| and |f_b| where the solve starts and of the loads on it, D the diagonal blocks of the tangent: what is
/// less is round-off. Then it is solved on by itself: the residual is that of its rows alone, and the line search goes by the work,
/// because the energy of all has no digits for it.
///
/// With forces of constraint all are solved at once, and what is left falls by factors and not by squares: there the first bound is
/// max(1e-5, 1000 tolerance) S_b. A body that was once out of balance counts by itself from then on: |R_b| / S_b beside the |R| of all.
class LightBodies {
 public:
  void compile(System& system);
  /// A solve starts with R, which has the unit of `weight` times forces, and with the forces of System::f.
  void begin(ConstRows residual, double weight);
  /// The residual is that of one body from now on, the one most out of balance that has not been looked at since begin(). False: there
  /// is none.
  bool focus(ConstRows residual, double tolerance, double weight, SystemMatrix& tangent, double displacement);
  void end() { in_focus_ = nullptr; }
  /// One that is out of balance, the most; null: none. `carried`: forces in R that are found with it, as of constraints, which count
  /// in S_b.
  const State* outOfBalance(ConstRows residual, ConstRows carried, double tolerance, double weight, SystemMatrix& tangent,
                            double displacement);
  /// The root of the sum of (|R_b| / S_b)^2 over those that were out of balance since begin(); 0: there are none.
  double left(ConstRows residual) const;
  /// How many were out of balance since begin().
  std::size_t found() const;
  /// None of them is out of balance by the first bound.
  bool areLittle(ConstRows residual, double tolerance) const;
  /// The rows of all others become zero, in focus.
  void narrow(Rows residual) const;
  double scale() const { return in_focus_->size(); }              ///< S_b
  const State& body() const { return *in_focus_->state; }

 private:
  struct Body {
    const State* state;
    Index first, count;
    double scale = 0;
    double carried = 0;  ///< of forces of constraint at the last outOfBalance(), which may be far less than on the way there
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
