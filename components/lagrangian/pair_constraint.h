// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

#include "framework/mechanics/lagrangian_constraint.h"

namespace stroma::lagrangian {

using Kind = LagrangianRows::Kind;

/// Conditions between points of one or two states.
class PairConstraint : public Component, public LagrangianConstraint {
 public:
  std::string roleText() const override { return "Lagrangian constraint"; }
  void declare(DataTable& table) override;  ///< object1, object2, forces
  void init() override;                     ///< finds the states
  std::vector<State*> constrainedStates() const override {
    return first_ == second_ ? std::vector<State*>{first_} : std::vector<State*>{first_, second_};
  }
  void takeForces(std::span<const double> forces) override { forces_.assign(forces.begin(), forces.end()); }
  void reset() override { forces_.clear(); }

 protected:
  State& first() const { return *first_; }
  State& second() const { return *second_; }
  /// Throws ComponentError for a node that the state does not have.
  void checkNode(const State& state, Index node, const char* attribute) const;
  /// The system's row of a node.
  static Index rowOf(const State& state, Index node) { return state.firstRow() + node; }
  virtual bool takesValues() const { return false; }  ///< states of numbers instead of points

 private:
  Link<State> object1_{"mechanical state"}, object2_{"mechanical state"};
  State *first_ = nullptr, *second_ = nullptr;
  std::vector<double> forces_;
};

}  // namespace stroma::lagrangian
