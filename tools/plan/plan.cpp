// SPDX-License-Identifier: LGPL-2.1-or-later
// The compiled plan of a scene: its systems, what observers cost, what the scene did not need; and the plan in lines.
#include <fmt/format.h>

#include "framework/mesh/topology.h"
#include "tools/plan/plan.h"

namespace stroma {
namespace {

PlanItem itemOf(const Observer& observer) {
  return {"observer", observer.path(), observer.type(), PlanWhen::after_each_step, observer.describe(), {}, {}};
}

/// Its nodes and its cells: those of volumes, else faces, else edges.
std::vector<std::pair<std::string, double>> sizes(const Mesh& mesh) {
  std::vector<std::pair<std::string, double>> all{{"nodes", double(mesh.nodes())}};
  const auto add = [&all](const char* word, std::size_t count) {
    if (count > 0) all.emplace_back(word, double(count));
    return count > 0;
  };
  const bool tetrahedra = add("tetrahedra", mesh.tetrahedra.size()),
             hexahedra = add("hexahedra", mesh.hexahedra.size()), prisms = add("prisms", mesh.prisms.size()),
             pyramids = add("pyramids", mesh.pyramids.size()),
             quadratic = add("quadratic tetrahedra", mesh.quadratic_tetrahedra.size());
  if (tetrahedra || hexahedra || prisms || pyramids || quadratic) return all;
  const bool triangles = add("triangles", mesh.triangles.size()), quads = add("quads", mesh.quads.size()),
             curved = add("quadratic triangles", mesh.quadratic_triangles.size());
  if (!triangles && !quads && !curved) add("edges", mesh.edges.size());
  return all;
}

PlanItem itemOf(const Topology& topology) {
  const auto figures = sizes(topology.mesh());
  std::string says;
  for (const auto& [word, count] : figures) says += fmt::format("{}{} {}", says.empty() ? "" : ", ", count, word);
  return {"mesh",
          topology.path(),
          topology.type(),
          PlanWhen::once,
          fmt::format("{}; tables derived from its cells: {}", says, topology.mesh().derivedTables()),
          figures,
          {}};
}

}  // namespace

std::string wordFor(PlanWhen when) {
  switch (when) {
    case PlanWhen::once:
      return "once";
    case PlanWhen::each_evaluation:
      return "each evaluation";
    case PlanWhen::each_step:
      return "each step";
    case PlanWhen::after_each_step:
      return "after each step";
    case PlanWhen::skipped:
      return "skipped";
    case PlanWhen::held:
      break;
  }
  return "held";
}

std::string PlanItem::line() const {
  std::string text = kind;
  if (!path.empty()) text += " " + path;
  if (!note.empty()) text += ", " + note;
  return says.empty() ? text : text + ": " + says;
}

std::vector<std::string> SystemPlan::lines() const {
  std::vector<std::string> lines{fmt::format("system of {}: {} nodes in one vector, {} of them independent", integrator,
                                             nodes, independent_nodes)};
  for (const PlanItem& item : items) lines.push_back("  " + item.line());
  return lines;
}

std::vector<std::string> Plan::lines() const {
  const std::string second = units.behind("s");
  std::vector<std::string> lines{fmt::format("time step {:.6g}{} from t = {:.6g}{}", dt, second, start_time, second)};
  if (systems.empty()) lines.push_back("no integrator: nothing moves");
  for (const SystemPlan& system : systems)
    for (std::string& line : system.lines()) lines.push_back(std::move(line));
  for (const PlanItem& mesh : meshes) lines.push_back(mesh.line());
  lines.push_back(observers.empty() ? "observers: none, so no energies, stresses or files are computed"
                                    : "observers, after each step:");
  for (const PlanItem& observer : observers)
    lines.push_back(fmt::format("  {} ({}) {}", observer.path, observer.type, observer.says));
  if (without_effect.empty()) return lines;
  std::string line = "accepted without effect (drawing, plug-ins, scheduling):";
  for (const std::string& name : without_effect) line += " " + name;
  lines.push_back(line);
  return lines;
}

Plan planOf(const Simulation& simulation) {
  Plan plan;
  plan.dt = simulation.dt();
  plan.start_time = simulation.root().root_time;
  plan.without_effect = simulation.scene().no_effect;
  plan.units = unitsOf(simulation.scene());
  for (const auto& system : simulation.systems()) {
    plan.systems.push_back(planOf(*system));
    for (PlanItem& item : plan.systems.back().items) item.says = plan.units.sentence(item.says);
  }
  std::vector<Topology*> topologies;
  simulation.root().collect(topologies);
  for (const Topology* topology : topologies) plan.meshes.push_back(itemOf(*topology));
  for (const Observer* observer : simulation.observers()) {
    plan.observers.push_back(itemOf(*observer));
    plan.observers.back().says = plan.units.sentence(plan.observers.back().says);
  }
  return plan;
}

}  // namespace stroma
