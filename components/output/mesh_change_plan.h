// SPDX-License-Identifier: LGPL-2.1-or-later
// What components share that change a mesh while a scene runs.
#pragma once
#include <string>

#include "framework/simulation/mesh_changer.h"
#include "framework/simulation/observer.h"
#include "framework/simulation/step_guard.h"

namespace stroma {

/// Plans changes, and refuses a step that would have to make one where whoever steps makes none.
class MeshChangePlan : public Observer, public StepGuard, public MeshChanger {
 public:
  void declare(DataTable& table) override;
  void init() override;
  void afterStep(const Simulation&, const StepContext&) override {}
  std::string refusal(const StepContext& context) override;

 protected:
  /// The mesh: that of the link, else the last of the node that has cells, or of the nearest node above.
  const Topology& topology() const { return *topology_; }
  /// Of the cells that make up the mesh: as its container is called, else those of the highest dimension.
  const CellKind& mainKind() const;
  /// When what is due at t was planned for [s].
  virtual double plannedAt(double t) const { return t; }

  bool keeps_points_ = false;

 private:
  Link<Topology> link_{"topology"};
  const Topology* topology_ = nullptr;
};

}  // namespace stroma
