// SPDX-License-Identifier: LGPL-2.1-or-later
// The compiled plan as data: what runs, how often, and what is skipped and why. Text and JSON output are generated from
// it.
#pragma once
#include <string>
#include <utility>
#include <vector>

#include "framework/simulation/simulation.h"
#include "tools/units/unit_system.h"

namespace stroma {

/// How often an item of the plan runs.
enum class PlanWhen {
  once,             ///< before the first step
  each_evaluation,  ///< of the forces: one or more per step
  each_step,
  after_each_step,
  skipped,  ///< never; the text says why
  held,     ///< does not run itself: a state, a mass or a constraint used by others
};

struct PlanItem {
  std::string kind;        ///< "force", "mapping", "held nodes", ...
  std::string path, type;  ///< of the component; empty for what belongs to none
  PlanWhen when = PlanWhen::held;
  std::string says;                                     ///< the rest of the line, with the reason if it is skipped
  std::vector<std::pair<std::string, double>> figures;  ///< "nodes", 402; "mass", 0.08
  std::string note;  ///< for a component that is not in the scene: why it was created

  std::string line() const;  ///< "force /organ/fem: each evaluation; linear"
};

/// The bodies moved by one integrator.
struct SystemPlan {
  std::string integrator;                  ///< its path
  Index nodes = 0, independent_nodes = 0;  ///< in one vector; nodes that are not mapped
  std::vector<PlanItem> items;             ///< in the order of the lines
  std::vector<std::string> lines() const;
};

struct Plan {
  double dt = 0, start_time = 0;  ///< in the scene's unit of time
  UnitSystem units;               ///< of the numbers in the scene
  std::vector<SystemPlan> systems;
  std::vector<PlanItem> meshes, observers;
  std::vector<std::string> without_effect;  ///< accepted and ignored: drawing, plug-ins, scheduling
  std::vector<std::string> lines() const;
};

/// How and why an automatic linear solver has chosen its method: its output `choice`. Empty: it does not choose.
std::string choiceOf(const LinearSolver& solver);
/// The word for it: "each evaluation".
std::string wordFor(PlanWhen when);
SystemPlan planOf(const System& system);
Plan planOf(const Simulation& simulation);

}  // namespace stroma
