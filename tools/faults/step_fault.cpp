// SPDX-License-Identifier: LGPL-2.1-or-later
// Which element to look at first where a step has failed.
#include "framework/simulation/system_report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "framework/mechanics/state_topology.h"
#include "framework/mesh/cell_lists.h"
#include "framework/simulation/integrator.h"

namespace stroma {
namespace {

/// Two rows of a state that a field ties, and their distances [m].
struct TiedPair {
  Index a = 0, b = 0;
  double rest = 0, now = 0;
  /// How many times as far or near, as a logarithm; infinite where that is no number.
  double change() const {
    const double size = std::abs(std::log(now / rest));
    return std::isfinite(size) ? size : std::numeric_limits<double>::infinity();
  }
};

/// The pair that has changed most. Nodes at one place at rest say nothing.
TiedPair mostChanged(const ForceField& field, const System& system, ConstRows x) {
  const State& state = field.state();
  BlockPattern pattern(system.allRows());
  field.addPattern(pattern);
  const Index first = state.firstRow();
  TiedPair worst{0, 0, 1, 1};
  for (Index a = 0; a < state.size(); ++a)
    for (const Index column : pattern.columns(first + a)) {
      const Index b = column - first;
      if (b <= a || b >= state.size() || state.kindOf(a) != RowKind::place || state.kindOf(b) != RowKind::place) continue;
      const TiedPair pair{a, b, (state.rest_position[std::size_t(b)] - state.rest_position[std::size_t(a)]).norm(),
                    (x[first + b] - x[first + a]).norm()};
      if (pair.rest > 0 && pair.change() > worst.change()) worst = pair;
    }
  return worst;
}

/// The cell of most dimensions with both nodes, or the nodes.
std::string describeCellOf(const State& state, Index a, Index b) {
  std::string text = fmt::format("nodes {} and {}", a, b);
  const Topology* const topology = topologyOf(state);
  if (!topology) return text;
  const auto look = [&](const CellKind& kind, const auto& cells) {
    const auto has = [](const auto& cell, Index node) { return std::find(cell.begin(), cell.end(), node) != cell.end(); };
    for (std::size_t c = 0; c < cells.size(); ++c)
      if (has(cells[c], a) && has(cells[c], b)) {
        text = fmt::format("{} {} (nodes {}): nodes {} and {}", kind.singular, c, fmt::join(cells[c], " "), a, b);
        return;
      }
  };
  forEachCellList(look, topology->mesh());
  return text;
}

std::string describeTies(const ForceField& field, const System& system, ConstRows x) {
  constexpr double little = 1e-6;
  const TiedPair pair = mostChanged(field, system, x);
  if (!(pair.change() > little)) return {};
  const Index rows = field.state().rows_per_node;
  return fmt::format("{} are {:.3g} m apart, at rest {:.3g} m", describeCellOf(field.state(), pair.a / rows, pair.b / rows), pair.now,
                     pair.rest);
}

/// The node that a field acts on and that is farthest from its rest, for fields that tie none to another.
std::string describeFarthest(const ForceField& field, const System& system) {
  const State& state = field.state();
  BlockPattern pattern(system.allRows());
  field.addPattern(pattern);
  double most = 0;
  Index farthest = -1;
  for (Index i = 0; i < state.size(); ++i) {
    if (pattern.columns(state.firstRow() + i).empty() || state.kindOf(i) == RowKind::turn) continue;
    const double way = (Vec3(system.x[state.firstRow() + i]) - state.rest_position[std::size_t(i)]).norm();
    if (!(way <= most)) most = way, farthest = i / state.rows_per_node;  // a NaN is the farthest
    if (way != way) break;
  }
  return farthest < 0 ? "" : fmt::format("node {} is {:.3g} from its rest", farthest, most);
}

}  // namespace

std::string worstElementOf(const ForceField& field, const System& system, ConstRows x) {
  std::string own = field.worstElement(x);
  const ForceTraits traits = field.traits();
  return own.empty() && (traits.has_rest_shape || traits.forces_balance) ? describeTies(field, system, x) : own;
}

std::string whereAndWhy(const System& system, const StepContext& context, const std::string& cause, const std::string& when) {
  std::string text = fmt::format("step {} (from t = {:.6g} s, dt = {:.6g} s), {}: {}", context.index, context.t, context.dt,
                                 system.integrator().path(), cause);
  std::set<const State*> told;
  const auto tell = [&](const ForceField& field, const std::string& worst) {
    if (worst.empty()) return;
    text += fmt::format("; worst of {}{}: {}", field.path(), when, worst);
    told.insert(&field.state());
  };
  for (const ForceField* field : system.forceFields()) tell(*field, worstElementOf(*field, system, system.x));
  for (const ForceField* field : system.forceFields()) {  // what a load acts on says something where nothing else does
    if (told.contains(&field->state())) continue;
    const std::string ties = describeTies(*field, system, system.x);
    tell(*field, ties.empty() ? describeFarthest(*field, system) : ties);
  }
  return text;
}

}  // namespace stroma
