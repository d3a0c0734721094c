// SPDX-License-Identifier: LGPL-2.1-or-later
// The compiled plan as data: what runs, how often, and what was skipped and why. Lines for people and JSON for programs
// are made of it.
#pragma once
#include <string>
#include <utility>
#include <vector>

#include "framework/simulation/simulation.h"
#include "tools/units/unit_system.h"

namespace stroma {

/// How often something of the plan is done.
enum class PlanWhen {
  once,             ///< before the first step
  each_evaluation,  ///< of the forces: one or more of them per step
  each_step,
  after_each_step,
  skipped,  ///< never; the sentence says why
  held,     ///< nothing to do by itself: a state, a mass or a constraint that others use
};

struct PlanItem {
  std::string kind;        ///< "force", "mapping", "held nodes", ...
  std::string path, type;  ///< of the component; empty for what belongs to none
  PlanWhen when = PlanWhen::held;
  std::string says;                                     ///< the rest of the line, with the reason of what is skipped
  std::vector<std::pair<std::string, double>> figures;  ///< "nodes", 402; "mass", 0.08
  std::string note;  ///< of a component that the scene does not write: why it is there

  std::string line() const;  ///< "force /organ/fem: each evaluation; linear"
};

/// What one integrator moves.
struct SystemPlan {
  std::string integrator;                  ///< its path
  Index nodes = 0, independent_nodes = 0;  ///< in one vector; those that no mapping places
  std::vector<PlanItem> items;             ///< in the order of the lines
  std::vector<std::string> lines() const;
};

struct Plan {
  double dt = 0, start_time = 0;  ///< in its unit of time
  UnitSystem units;               ///< that the numbers of the scene are in
  std::vector<SystemPlan> systems;
  std::vector<PlanItem> meshes, observers;
  std::vector<std::string> without_effect;  ///< accepted and left out: drawing, plug-ins, scheduling
  std::vector<std::string> lines() const;
};

/// How a linear solver that chooses says that it solves, and why: its output `choice`. Empty: it does not choose.
std::string choiceOf(const LinearSolver& solver);
/// The word for it: "each evaluation".
std::string wordFor(PlanWhen when);
SystemPlan planOf(const System& system);
Plan planOf(const Simulation& simulation);

}  // namespace stroma
