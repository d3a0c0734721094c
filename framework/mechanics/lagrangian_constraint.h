// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <span>
#include <vector>

#include "framework/mechanics/state.h"

namespace stroma {

/// Scalar conditions g(x): each has its value at x and its gradient over all rows of the system.
class LagrangianRows {
 public:
  enum class Kind : unsigned char {
    equal,  ///< g = 0
    push,   ///< g >= 0, force >= 0 and g * force = 0; if the force is bounded, g < 0 is allowed once it reaches the bound
    given,  ///< the force is prescribed
    rub     ///< Coulomb friction of the preceding `push`: either the slip g since the start of the step is zero, or the
            ///< combined force of its `rub` rows is mu times that of the `push` and opposes the slip
  };
  struct Entry {
    Index row;
    Vec3 gradient;
    bool operator==(const Entry&) const = default;
  };
  struct Row {
    Kind kind;
    double value, factor;    ///< g [m]; mu of `rub`, the force of `given`, the bound on the force of `push` (0: none)
    std::size_t begin, end;  ///< of entries
  };

  /// The gradient of a row changes with x by -size b (b . dx), as for the distance to a surface whose cells rotate.
  struct Bend {
    std::size_t row;
    double size;             ///< [m]
    std::size_t begin, end;  ///< range of the entries of b [1/m], stored apart from those of rows
  };

  void clear() { rows_.clear(), entries_.clear(), bends_.clear(), bend_entries_.clear(); }
  void begin(Kind kind, double value, double factor = 0) {
    rows_.push_back({kind, value, factor, entries_.size(), entries_.size()});
  }
  void add(Index row, const Vec3& gradient) { entries_.push_back({row, gradient}), ++rows_.back().end; }
  /// Of the last row.
  void bend(double size) { bends_.push_back({rows_.size() - 1, size, bend_entries_.size(), bend_entries_.size()}); }
  void addToBend(Index row, const Vec3& b) { bend_entries_.push_back({row, b}), ++bends_.back().end; }
  const std::vector<Bend>& bends() const { return bends_; }
  std::span<const Entry> entriesOf(const Bend& bend) const { return {bend_entries_.data() + bend.begin, bend.end - bend.begin}; }
  const std::vector<Row>& rows() const { return rows_; }
  std::span<const Entry> entriesOf(const Row& row) const { return {entries_.data() + row.begin, row.end - row.begin}; }
  /// The same rows as in `other`, at another place or with other values.
  bool hasGradientsOf(const LagrangianRows& other) const {
    const auto alike = [](const Row& a, const Row& b) { return a.kind == b.kind && a.factor == b.factor && a.end == b.end; };
    return std::equal(rows_.begin(), rows_.end(), other.rows_.begin(), other.rows_.end(), alike) && entries_ == other.entries_;
  }

 private:
  std::vector<Row> rows_;
  std::vector<Entry> entries_, bend_entries_;
  std::vector<Bend> bends_;
};

/// A role of a component whose conditions are enforced at the end of a step by constraint forces. An integrator that knows
/// the matrix A of its step finds them: A c = dt J^T l, with the gradients J (condition_forces.h).
class LagrangianConstraint {
 public:
  virtual ~LagrangianConstraint() = default;
  virtual std::vector<State*> constrainedStates() const = 0;
  /// Called when a step to t_end [s] starts at x: fixes the set of conditions for this step.
  virtual void constrainedStepBegins(ConstRows /*x*/, double /*t_end*/) {}
  /// Appends the conditions at x. Their number is constant during a step.
  virtual void addConditions(ConstRows x, ConstRows x_start, LagrangianRows& rows) const = 0;
  /// Receives the forces l of its rows in the step just completed [N].
  virtual void takeForces(std::span<const double> /*forces*/) {}
  /// Tolerances of the conditions at the end of a step [m]: up to `held` is silent, up to `kept` prints a warning.
  struct Tolerance {
    double held = 0, kept = 0;
  };
  virtual Tolerance tolerance() const { return {}; }
};

/// The tolerance of each row, with the rows of a constraint up to its `ends`; empty without rows. `kept`: the larger one.
inline void findTolerances(const std::vector<LagrangianConstraint*>& constraints, const std::vector<std::size_t>& ends, bool kept,
                           std::vector<double>& of_rows) {
  of_rows.clear();
  for (std::size_t i = 0, begin = 0; i < ends.size(); begin = ends[i++]) {
    const LagrangianConstraint::Tolerance tolerance = constraints[i]->tolerance();
    const double most = kept ? std::max(tolerance.kept, tolerance.held) : tolerance.held;
    if (most > 0 || !of_rows.empty()) of_rows.resize(begin, 0), of_rows.resize(ends[i], most);
  }
}

/// The role of an integrator that computes constraint forces.
class FindsMultipliers {
 public:
  virtual ~FindsMultipliers() = default;
};

}  // namespace stroma
