// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/checks/beam_masses.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "framework/simulation/integrator.h"

namespace stroma {
namespace {

struct Chains {
  std::size_t beams = 0, ends = 0, free_ends = 0;  ///< ends: nodes of one beam
};

Chains chainsOf(const System& system, const ForceField& field) {
  const State& state = field.state();
  const Index first = state.firstRow(), per_node = state.rows_per_node;
  BlockPattern pattern(system.allRows());
  field.addPattern(pattern);
  Chains chains;
  for (Index node = 0; node < state.nodes(); ++node) {
    std::set<Index> neighbours;
    for (const Index column : pattern.columns(first + node * per_node))
      if (const Index other = (column - first) / per_node; other != node) neighbours.insert(other);
    chains.beams += neighbours.size();
    if (neighbours.size() != 1) continue;
    ++chains.ends;
    if (system.constraints().projectorOf(first + node * per_node) < 0) ++chains.free_ends;
  }
  chains.beams /= 2;
  return chains;
}

/// Of `n` beams with equal masses at n + 1 nodes, over that with shares by length. The modal mass of a uniform beam is M/4 where its
/// free ends move by 1. Of equal masses it is M (n/4 + e/2)/(n + 1), e the number of free ends.
double frequencyRatio(double n, double e) { return std::sqrt((n + 1) / (n + 2 * e)); }

/// Whether it is a UniformMass that turns with its frames: in SOFA's dialect it does not.
bool isUniform(const Mass& mass, const State& state) {
  const Data* turns = mass.data().find("turns");
  return mass.type() == "UniformMass" && &mass.state() == &state && turns && turns->print() == "true";
}

}  // namespace

void noteEqualMassesOfBeams(const Simulation& simulation, Diagnostics& diagnostics) {
  for (const auto& system : simulation.systems()) {
    if (!system->integrator().movesInTime()) continue;
    for (const ForceField* field : system->forceFields()) {
      if (field->type() != "BeamFEMForceField") continue;
      const auto mass = std::ranges::find_if(system->masses(), [&](const Mass* each) { return isUniform(*each, field->state()); });
      if (mass == system->masses().end()) continue;
      const Chains chains = chainsOf(*system, *field);
      if (chains.free_ends == 0) continue;
      const double count = double(chains.ends) / 2, percent = 100 * (1 - frequencyRatio(double(chains.beams) / count,
                                                                                       double(chains.free_ends) / count));
      diagnostics.note(field->where(), field->path(),
                       fmt::format("{} gives free ends of beams as much mass as nodes between two beams: natural frequencies are about "
                                   "{:.0f} % too low. AdaptiveBeamForceFieldAndMass has the mass of its beams",
                                   (*mass)->path(), percent));
    }
  }
}

}  // namespace stroma
