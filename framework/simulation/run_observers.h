// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <vector>

#include "framework/scene/diagnostics.h"
#include "framework/simulation/observer.h"
#include "framework/simulation/snapshots.h"

namespace stroma {

/// The observers of a run. Simulation documents when they are called.
class RunObservers {
 public:
  explicit RunObservers(const Simulation& simulation, const Systems& systems);
  RunObservers(const RunObservers&) = delete;

  const std::vector<Observer*>& all() const { return observers_; }
  void collect(Node& root);
  void compile(Diagnostics& diagnostics);
  /// Single watched nodes are kept up to date, except passively mapped ones.
  void watchFollowers();
  void clear() { observers_.clear(); }
  /// Replaces the observers by those of other systems, none of which has begun.
  void replaceBy(std::vector<Observer*> observers) { observers_ = std::move(observers), watchFollowers(); }
  void add(Observer& observer);
  void remove(Observer& observer);

  void checkOutputs() const;
  void computeOnDemand(bool on) { on_demand_ = on; }
  void begin();
  /// Called after a successful step; the time of observers is measured separately.
  void afterStep(const StepContext& context);
  void end();

 private:
  template <class Tell>
  void tellAll(Tell&& tell);

  const Simulation& simulation_;
  const Systems& systems_;
  std::vector<Observer*> observers_;
  bool begun_ = false;
  bool on_demand_ = false;
  bool watches_followers_ = false;  ///< an observer watches single nodes of passive mappings
};

}  // namespace stroma
