// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <functional>
#include <string>

#include "framework/algebra/vector.h"

namespace stroma {

/// Positions go from x to x + s dx, s from 0 to 1. Where mappings turn they do so on a curve, and a row is besides at most
/// `bend` [m] away from that line.
struct Way {
  ConstRows dx;
  const double* bend = nullptr;  ///< shape (rows); null: straight
  bool is_carried = false;       ///< that of what is moved, at whose end a solve begins; else the line of a search
  double along = 0;              ///< obstacles go this part of the way that they have left
};

/// A force field that takes something from where a step starts, which then lasts for it: contacts that have been found.
class HearsSteps {
 public:
  virtual ~HearsSteps() = default;
  /// A step from t to t_end [s] starts at x.
  virtual void stepBegins(ConstRows x, double t, double t_end) = 0;
};

/// A force field whose forces have a potential in each solve, with what is held fixed meanwhile: energy() and lentEnergy() together.
class LendsEnergy {
 public:
  virtual ~LendsEnergy() = default;
  virtual bool lendsEnergy() const = 0;
  /// The part [J] that is no energy of the field's, as of the last force.
  virtual double lentEnergy(ConstRows x) const = 0;
};

/// A force field besides which positions may not move anyhow: bodies that touch must not pass through each other.
/// Integrators ask how long a step may be (simulation/step_limits.h). Vectors have all rows of the system.
class StepLimiter : public HearsSteps {
 public:
  /// Where a run starts. Throws ComponentError when things lie in one another there.
  virtual void checkStart(ConstRows x) = 0;
  /// The largest s <= 1 up to which the way from x on is known to be free.
  virtual double longestStep(ConstRows x, const Way& way) = 0;
  /// The step's equations are solved at x with what is held fixed meanwhile: the directions of friction, obstacles that
  /// have not been let all the way. True: that has moved on or waits to, and they are to be solved again.
  virtual bool movesOn(ConstRows x) = 0;
  /// Obstacles have a way left that goAlong() is to let them go before the next solve.
  virtual bool hasWay() const { return false; }
  /// f += what that way would add to the forces of the last addForce(), if nothing gave way, by their derivative.
  virtual void addPush(Rows /*f*/) const {}
  /// Obstacles go the part s of it.
  virtual void goAlong(double /*s*/) {}
  /// True: movesOn() will say so after the present solve too, as with obstacles half way. Its equilibrium is only a place to go on
  /// from.
  virtual bool isOnTheWay() const { return false; }
  /// While `wanted`, forces are asked for that stay in the equations of a step, nothing held; `of_end`: the part of those of its solves.
  virtual void wantStartForces(bool /*wanted*/, double /*of_end*/) {}
  /// After a step to x: what lies in one another, as a sentence, or empty. Exact.
  virtual std::string overlap(ConstRows x) = 0;
};

/// A force field that moves nodes before the first step, because a run cannot start where they are.
class PlacesStart {
 public:
  virtual ~PlacesStart() = default;
  /// x: positions of all rows, of which the first `independent` may be moved; `project` takes out of displacements of these what
  /// is held. Throws ComponentError where there is no such place.
  virtual void placeStart(Rows x, Index independent, const std::function<void(Rows)>& project) = 0;
};

/// The role of an integrator that asks.
class HeedsStepLimits {
 public:
  virtual ~HeedsStepLimits() = default;
  virtual bool heedsStepLimits() const = 0;
  /// An attribute with which it would: "newtonIterations=\"30\"", or empty.
  virtual std::string howToHeedStepLimits() const { return {}; }
};

}  // namespace stroma
