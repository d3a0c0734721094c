// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <map>
#include <vector>

#include "framework/mechanics/force_field.h"
#include "framework/simulation/input.h"

namespace stroma {

/// The inputs on one system, as a force field whose derivatives are diagonal blocks, which every matrix has: adding one
/// changes values of a matrix, never its pattern. The system has it in its lists while there is an input, so that it
/// costs nothing when there is none.
class InputForces final : public ForceField {
 public:
  /// `state`: one of the system's.
  explicit InputForces(State& state);
  void declare(DataTable&) override {}

  /// Puts an input in the place of the one with the same number, if any. `first_row`: of its state. True when the
  /// stiffness or damping of some node is another than before.
  bool set(long number, const Input& input, Index first_row);
  /// The same for an input that ends; false also when there is none with this number.
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

  /// visit(row, input, place in the list of nodes); in the order of their numbers
  template <class Visit>
  void forNodes(Visit&& visit) const {
    for (const auto& [number, placed] : inputs_)
      for (std::size_t i = 0; i < placed.input.nodes.size(); ++i)
        visit(placed.first_row + placed.input.nodes[i], placed.input, i);
  }

 private:
  struct Placed {
    Input input;
    Index first_row;
  };

  std::map<long, Placed> inputs_;  ///< by number: sums are taken in this order
};

}  // namespace stroma
