// SPDX-License-Identifier: LGPL-2.1-or-later
// The compiled plan in words: what a step does, what observers cost, what the scene did not need.
#include <fmt/format.h>

#include "framework/mesh/topology.h"
#include "framework/simulation/simulation.h"

namespace stroma {
namespace {

void explainObservers(const std::vector<Observer*>& observers, std::vector<std::string>& lines) {
  if (observers.empty()) {
    lines.push_back("observers: none, so energies, stresses and files are not computed");
    return;
  }
  lines.push_back("observers, after each step:");
  for (const Observer* observer : observers)
    lines.push_back(fmt::format("  {} ({}) {}", observer->path(), observer->type(), observer->describe()));
}

void explainTopologies(const Node& root, std::vector<std::string>& lines) {
  std::vector<Topology*> topologies;
  root.collect(topologies);
  for (const Topology* topology : topologies)
    lines.push_back(fmt::format("mesh {}: {} nodes; tables derived from its cells: {}", topology->path(),
                                topology->mesh().nodes(), topology->mesh().derivedTables()));
}

void explainIgnored(const std::vector<std::string>& ignored, std::vector<std::string>& lines) {
  if (ignored.empty()) return;
  std::string line = "accepted without effect (drawing, plug-ins, scheduling):";
  for (const std::string& name : ignored) line += " " + name;
  lines.push_back(line);
}

}  // namespace

std::vector<std::string> Simulation::explain() const {
  std::vector<std::string> lines;
  lines.push_back(fmt::format("time step {:.6g} s from t = {:.6g} s", dt(), root().root_time));
  if (systems_.empty()) lines.push_back("no integrator: nothing moves");
  for (const auto& system : systems_)
    for (std::string& line : stroma::explain(*system)) lines.push_back(std::move(line));
  explainTopologies(root(), lines);
  explainObservers(observers_, lines);
  explainIgnored(scene_.no_effect, lines);
  return lines;
}

}  // namespace stroma
