// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

#include "framework/mechanics/lagrangian_constraint.h"

namespace stroma::lagrangian {

using Kind = LagrangianRows::Kind;

/// Conditions between nodes of one or two states.
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
  void serialize(Archive& archive) override;

 protected:
  /// What states may hold.
  enum class Nodes { points, points_or_frames, points_or_values, values };
  virtual Nodes nodes() const { return Nodes::points; }
  void declareOneState(DataTable& table);  ///< instead of declare(): mstate, forces
  State& first() const { return *first_; }
  State& second() const { return *second_; }
  /// Throws ComponentError for a node that the state does not have.
  void checkNode(const State& state, Index node, const char* attribute) const;
  /// Of the last row, whose gradient has the unit vector n of the way between two rows: it turns across n with both, and becomes at
  /// `to` what it was less size (1 - n n^T) (dx_to - dx_from). `from` -1: a place that stays.
  static void addTurning(const Vec3& n, Index from, Index to, double size, LagrangianRows& rows);
  /// The system's row of a node; of a frame that of its centre, its orientation is in the next.
  static Index rowOf(const State& state, Index node) { return state.firstRow() + node * state.rows_per_node; }

 private:
  void checkState(const State& state) const;

  Link<State> object1_{"mechanical state"}, object2_{"mechanical state"};
  State *first_ = nullptr, *second_ = nullptr;
  std::vector<double> forces_;
};

}  // namespace stroma::lagrangian
