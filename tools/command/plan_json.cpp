// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/command/plan_json.h"

#include "framework/algebra/parallel.h"
#include "tools/plan/plan.h"

namespace stroma::command {
namespace {

Json toJson(const PlanItem& item) {
  Json json{{"kind", item.kind}, {"path", item.path}, {"type", item.type}, {"when", wordFor(item.when)}};
  json["says"] = item.says;
  if (!item.note.empty()) json["note"] = item.note;
  for (const auto& [name, value] : item.figures) json[name] = value;
  return json;
}

Json toJson(const std::vector<PlanItem>& items) {
  Json list = Json::array();
  for (const PlanItem& item : items) list.push_back(toJson(item));
  return list;
}

}  // namespace

Json planJson(Session& session) {
  const Plan plan = planOf(session.simulation());
  Json systems = Json::array();
  for (const SystemPlan& system : plan.systems)
    systems.push_back({{"integrator", system.integrator},
                       {"nodes", system.nodes},
                       {"independent_nodes", system.independent_nodes},
                       {"items", toJson(system.items)}});
  return {{"scene", session.sceneFile()},
          {"units", plan.units.isKnown() ? Json(plan.units.name) : Json()},
          {"dt", plan.dt},
          {"start_time", plan.start_time},
          {"systems", std::move(systems)},
          {"meshes", toJson(plan.meshes)},
          {"observers", toJson(plan.observers)},
          {"without_effect", plan.without_effect},
          {"modules_opened", session.modules().opened()},
          {"modules_not_opened", session.modules().notOpened()},
          {"instructions", instructionLevel()},
          {"threads", threads()}};
}

}  // namespace stroma::command
