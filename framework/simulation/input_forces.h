// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <map>
#include <memory>
#include <vector>

#include "framework/mechanics/force_field.h"
#include "framework/simulation/input.h"

namespace stroma {

/// The force of a ball on the points of a state, see Input. Some component computes it (Part::ball).
class BallForce : public ForceField {
 public:
  /// Acts on `state` as the ball of `input`. Called again when the input changes.
  virtual void actAs(const Input& input, State& state) = 0;
};

/// The inputs on one system, as a force field with diagonal derivative blocks, which every matrix has: adding an input
/// changes values of a matrix, never its pattern. The system lists this field only while there is an input, so without
/// one it costs nothing.
class InputForces final : public ForceField {
 public:
  /// `state`: one of the system's.
  explicit InputForces(State& state);
  void declare(DataTable&) override {}

  /// Adds an input, or replaces the one with the same number. `state`: the state it names, with its rows.
  /// True if the stiffness or damping of some node has changed; false also if a ball has only moved.
  bool set(long number, const Input& input, State& state);
  /// The same for an input that ends; false also if there is none with this number.
  bool remove(long number);
  bool empty() const { return inputs_.empty(); }
  bool isDamped() const;

  ForceTraits traits() const override;
  Cost cost() const override;
  double energy(ConstRows x) const override;
  void addForce(ConstRows x, ConstRows v, Rows f) override;
  void addStiffnessProduct(ConstRows dx, double factor, Rows df) const override;
  void addPattern(BlockPattern&) const override {}  // the diagonal is always there
  void addStiffness(double factor, BlockMatrix& matrix) const override;
  void addStiffnessDiagonal(double factor, std::vector<double>& blocks) const override;
  void addDampingProduct(ConstRows dv, double factor, Rows df) const override;
  void addDamping(double factor, BlockMatrix& matrix) const override;
  void addDampingDiagonal(double factor, std::vector<double>& blocks) const override;

  /// visit(row, input, position in its list of nodes), in the order of input numbers. A ball lists no nodes.
  template <class Visit>
  void forNodes(Visit&& visit) const {
    for (const auto& [number, placed] : inputs_)
      for (std::size_t i = 0; i < placed.input.nodes.size(); ++i)
        visit(placed.state->firstRow() + placed.input.nodes[i], placed.input, i);
  }

 private:
  struct Placed {
    Input input;
    State* state;
    std::unique_ptr<BallForce> ball{};  ///< null: the input lists nodes
  };

  /// visit(force of a ball), in the order of input numbers
  template <class Visit>
  void forBalls(Visit&& visit) const {
    for (const auto& [number, placed] : inputs_)
      if (placed.ball) visit(*placed.ball);
  }
  bool takesAllRows() const override { return true; }
  /// Some input acts on orientations.
  bool turnsAny() const;

  std::map<long, Placed> inputs_;  ///< by number: sums are taken in this order
};

}  // namespace stroma
