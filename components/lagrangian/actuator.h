// SPDX-License-Identifier: LGPL-2.1-or-later
// What pulls or pumps: a way s(x) from where the scene starts, and a force f along ds/dx with the work f ds. A cable has its
// shortening and its tension, a cavity the growth of its volume and its pressure. Either is imposed, the other follows within
// its bounds:
//
//   the way:    s = value,  f_least <= f <= f_most;   at f_least s >= value, at f_most s <= value
//   the force:  f = value,  s_least <= s <= s_most;   at s_least f >= value, at s_most f <= value
//
// The imposed value is first kept within its own bounds, and within a largest change from what was there a step ago. In SOFA's
// plug-in SoftRobots a given force is an impulse, f dt: with `impulses` it is divided by dt, and outputs are f dt.
#pragma once
#include <limits>

#include "components/lagrangian/pair_constraint.h"
#include "framework/mechanics/key_times.h"

namespace stroma::lagrangian {

class Actuator : public PairConstraint {
 public:
  void init() override;
  void constrainedStepBegins(ConstRows x, double t_end) override;
  void addConditions(ConstRows x, ConstRows x_start, LagrangianRows& rows) const override;
  void takeForces(std::span<const double> forces) override;
  void reset() override;
  void serialize(Archive& archive) override;

 protected:
  static constexpr double infinity = std::numeric_limits<double>::infinity();
  /// Bounds of a way or of a force, and by how much it may change in a step as an imposed one.
  struct Bounds {
    double least = -infinity, most = infinity, change = infinity;
    double within(double value, double before) const;
    Bounds times(double factor) const { return {factor * least, factor * most, factor * change}; }
  };
  virtual double measure(ConstRows x) const = 0;  ///< s and a constant
  virtual double measureAtStart(ConstRows x) const { return measure(x); }
  /// Adds sign * ds/dx to the last row.
  virtual void addGradient(ConstRows x, double sign, LagrangianRows& rows) const = 0;
  /// value, valueIndex, valueType: `way` or `force`, the words of a scene. The first of them is that of a scene that gives none.
  void declareValue(DataTable& table, const char* way, const char* force, bool way_first, const std::string& help);
  /// What a scene has written in an attribute, else what stands for nothing.
  double written(const char* attribute, double value, double otherwise) const;
  /// In init(): throws ComponentError where least is above most.
  void bound(const Bounds& way, const Bounds& force);
  bool imposesForce() const { return imposed_ == force_is_; }
  double value() const;         ///< at the end of the step under way
  double largestValue() const;  ///< of all its key times
  // ---- of one that has several ways, with the one value and the bounds of all ----
  /// The conditions on a way s - start; `add` adds sign * ds/dx to the last row.
  template <class Add>
  void addPlanned(double way, LagrangianRows& rows, const Add& add) const {
    for (const Plan& row : plan_) {
      rows.begin(row.kind, row.sign * (way - row.at), row.factor);
      add(row.sign);
    }
  }
  std::size_t planned() const { return plan_.size(); }  ///< conditions on a way
  double plannedForce(std::span<const double> forces) const;  ///< f, of those on them
  void tell(double force, double way, std::span<const double> forces);  ///< after a step
  void startAt(double measured) { start_ = measured, is_measured_ = true; }

  double way_ = 0, force_ = 0, start_ = 0;  ///< s and f after the last step; measure() where the scene starts
  double told_force_ = 0;                   ///< f, or with impulses f dt

 private:
  /// One condition sign * (s - at).
  struct Plan {
    Kind kind;
    double sign, at, factor;
  };
  enum class Imposed : int { first, second };  ///< of the words of valueType
  void plan();
  void takeKeyTimes();
  /// A single number that a run has set is the value at all times.
  bool isKeyed() const { return !key_times_.empty() && key_times_.size() == values_.size(); }

  std::vector<double> values_{0};
  int index_ = 0;
  std::vector<double> key_times_;
  KeyTimes<double> keys_;
  bool was_keyed_ = false;  ///< as the scene was written
  double time_ = 0;  ///< end of the step under way
  bool impulses_ = false;
  Imposed imposed_ = Imposed::first, force_is_ = Imposed::second;
  std::string way_word_, force_word_;
  Bounds way_bounds_, force_bounds_;
  bool is_measured_ = false;
  std::vector<Plan> plan_;  ///< of the step under way
  mutable double now_ = 0;  ///< measure() at the x of the last conditions
};

}  // namespace stroma::lagrangian
