// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <span>
#include <vector>

#include "framework/mechanics/state.h"

namespace stroma {

/// Scalar conditions g(x) as rows: the value at x and the gradient, on all rows of a system.
class LagrangianRows {
 public:
  enum class Kind : unsigned char {
    equal,  ///< g = 0
    push,   ///< g >= 0, force >= 0, one of them zero; with a bound on the force, g < 0 where the force has reached it
    given,  ///< the force is known
    rub     ///< Coulomb's friction of the last `push` before it: g, a way of sliding since the start of the step, is
            ///< zero, or the force of all its `rub` rows has mu times that of the `push`, against the sliding
  };
  struct Entry {
    Index row;
    Vec3 gradient;
    bool operator==(const Entry&) const = default;
  };
  struct Row {
    Kind kind;
    double value, factor;    ///< g [m]; mu of what rubs, the force of what is given, the most that pushes (0: no bound)
    std::size_t begin, end;  ///< of entries
  };

  /// How the gradient of a row turns with x: by -size b (b . dx). Of a distance to a surface whose cells turn.
  struct Bend {
    std::size_t row;
    double size;             ///< [m]
    std::size_t begin, end;  ///< of entries of b [1/m], which are apart from those of rows
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

/// A role beside others: its conditions hold at the end of a step by constraint forces. An integrator that knows the
/// matrix A of its step solves for them: A c = dt J^T l, J the gradients (condition_forces.h).
class LagrangianConstraint {
 public:
  virtual ~LagrangianConstraint() = default;
  virtual std::vector<State*> constrainedStates() const = 0;
  /// A step to t_end [s] starts at x: chooses the conditions for this step.
  virtual void constrainedStepBegins(ConstRows /*x*/, double /*t_end*/) {}
  /// Appends the conditions at x, always as many in a step.
  virtual void addConditions(ConstRows x, ConstRows x_start, LagrangianRows& rows) const = 0;
  /// The forces l of its rows in the step that has been made [N].
  virtual void takeForces(std::span<const double> /*forces*/) {}
  /// Tolerances of its conditions at the end of a step [m]: up to `held` silently, up to `kept` with a warning.
  struct Tolerance {
    double held = 0, kept = 0;
  };
  virtual Tolerance tolerance() const { return {}; }
};

/// The tolerance of each row, those of a constraint up to its `ends`; empty without any. `kept`: the one with a warning.
inline void findTolerances(const std::vector<LagrangianConstraint*>& constraints, const std::vector<std::size_t>& ends, bool kept,
                           std::vector<double>& of_rows) {
  of_rows.clear();
  for (std::size_t i = 0, begin = 0; i < ends.size(); begin = ends[i++]) {
    const LagrangianConstraint::Tolerance tolerance = constraints[i]->tolerance();
    const double most = kept ? std::max(tolerance.kept, tolerance.held) : tolerance.held;
    if (most > 0 || !of_rows.empty()) of_rows.resize(begin, 0), of_rows.resize(ends[i], most);
  }
}

/// The role of an integrator that finds them.
class FindsMultipliers {
 public:
  virtual ~FindsMultipliers() = default;
};

}  // namespace stroma
