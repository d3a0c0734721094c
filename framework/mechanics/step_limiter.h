// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <functional>
#include <string>

#include "framework/algebra/vector.h"

namespace stroma {

/// Positions go from x to x + s dx, s from 0 to 1. Where mappings turn they go on a curve, and a row is at most
/// `bend` [m] away from that line.
struct StepPath {
  ConstRows dx;
  const double* bend = nullptr;  ///< shape (rows); null: straight
  bool is_carried = false;       ///< a prescribed motion, at whose end a solve starts; else the line of a line search
  double along = 0;              ///< obstacles go this fraction of their remaining way
};

/// A force field that looks up something at the start of a step and keeps it for the step, such as contacts.
class StepListener {
 public:
  virtual ~StepListener() = default;
  /// A step from t to t_end [s] starts at x.
  virtual void stepBegins(ConstRows x, double t, double t_end) = 0;
};

/// A force field whose forces have a potential in each solve, with the lagged quantities fixed: energy() plus solvePotential().
class HasSolvePotential {
 public:
  virtual ~HasSolvePotential() = default;
  virtual bool hasSolvePotential() const = 0;
  /// The part [J] of that potential that is not stored energy, as of the last force.
  virtual double solvePotential(ConstRows x) const = 0;
};

/// A force field that limits how far positions may move in a step: bodies in contact must not pass through each other.
/// Integrators ask how long a step may be (simulation/step_limits.h). Vectors have all rows of the system.
class StepLimiter : public StepListener {
 public:
  /// Called at the start of a run. Throws ComponentError if bodies intersect there.
  virtual void checkStart(ConstRows x) = 0;
  /// The largest s <= 1 up to which the way from x on is known to be free.
  virtual double longestStep(ConstRows x, const StepPath& way) = 0;
  /// The step's equations are solved at x with the lagged quantities fixed: directions of friction, obstacles that have
  /// not gone all the way. True: those were updated or are waiting to be, and the equations have to be solved again.
  virtual bool updatesLagged(ConstRows x) = 0;
  /// Obstacles have a remaining way, which advanceRemainingMotion() advances before the next solve.
  virtual bool hasRemainingMotion() const { return false; }
  /// f += what that way would add to the forces of the last addForce() with all nodes fixed, by their derivative.
  virtual void addPush(Rows /*f*/) const {}
  /// Obstacles go the fraction s of it.
  virtual void advanceRemainingMotion(double /*s*/) {}
  /// True: updatesLagged() will return true after the present solve too, as with obstacles half way. Its equilibrium is only an
  /// intermediate one.
  virtual bool isIntermediate() const { return false; }
  /// While `wanted`, forces are asked for that stay in the equations of a step, nothing held; `of_end`: the part of those of its solves.
  virtual void wantStartForces(bool /*wanted*/, double /*of_end*/) {}
  /// After a step to x: a sentence on what intersects, or empty. Exact.
  virtual std::string overlap(ConstRows x) = 0;
};

/// A force field that moves nodes before the first step, because a run cannot start from their positions.
class CorrectsStart {
 public:
  virtual ~CorrectsStart() = default;
  /// x: positions of all rows, of which the first `independent` may be moved; `project` removes the constrained part of their
  /// displacements. Throws ComponentError if there is no valid start.
  virtual void placeStart(Rows x, Index independent, const std::function<void(Rows)>& project) = 0;
};

/// The role of an integrator that asks.
class RespectsStepLimits {
 public:
  virtual ~RespectsStepLimits() = default;
  virtual bool respectsStepLimits() const = 0;
  /// The attribute that makes it ask: "newtonIterations=\"30\"", or empty.
  virtual std::string howToRespectStepLimits() const { return {}; }
};

}  // namespace stroma
