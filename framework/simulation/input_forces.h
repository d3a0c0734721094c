// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <map>
#include <vector>

#include "framework/mechanics/force_field.h"
#include "framework/simulation/input.h"

namespace stroma {

/// The inputs on one system, as a force field with diagonal derivative blocks, which every matrix has: adding an input
/// changes values of a matrix, never its pattern. The system lists this field only while there is an input, so without
/// one it costs nothing.
///
/// For a ball, K = -k n n^T and C = -c n n^T on each node that is inside at the x of the last addForce(). The exact
/// derivative has one more term, k (r/d - 1) (I - n n^T), because n rotates when a node slides along the ball. It is
/// omitted: inside the ball it is positive and unbounded towards the centre, and would make the system matrix
/// indefinite. Newton's method finds the same equilibrium without it, in more iterations. The damping omits the
/// rotation of n as well.
class InputForces final : public ForceField {
 public:
  /// `state`: one of the system's.
  explicit InputForces(State& state);
  void declare(DataTable&) override {}

  /// Adds an input, or replaces the one with the same number. `state`: the state it names, with its rows.
  /// True if the stiffness or damping of some node has changed; false also if a ball has only moved.
  bool set(long number, const Input& input, const State& state);
  /// The same for an input that ends; false also if there is none with this number.
  bool remove(long number);
  bool empty() const { return inputs_.empty(); }
  bool isDamped() const;
  bool hasBall() const;

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
  /// A node that was inside a ball in the last evaluation of the forces.
  struct Touch {
    Index row;
    Vec3 normal;  ///< outward
  };
  struct Placed {
    Input input;
    const State* state;
    std::vector<Touch> touches{};  ///< ascending rows
  };

  /// visit(row, depth r - d [m], normal) for nodes inside the ball of `placed` at x
  template <class Visit>
  static void forInside(const Placed& placed, ConstRows x, Visit&& visit);
  /// visit(row, input, normal) for nodes that were inside balls in the last evaluation of the forces
  template <class Visit>
  void forTouches(Visit&& visit) const {
    for (const auto& [number, placed] : inputs_)
      for (const Touch& touch : placed.touches) visit(touch.row, placed.input, touch.normal);
  }

  bool takesAllRows() const override { return true; }
  /// Some input acts on orientations.
  bool turnsAny() const;

  std::map<long, Placed> inputs_;  ///< by number: sums are taken in this order
};

}  // namespace stroma
