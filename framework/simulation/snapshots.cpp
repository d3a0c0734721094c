// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/simulation/snapshots.h"

#include "framework/simulation/integrator.h"

namespace stroma {

void complete(const Systems& systems) {
  for (const auto& system : systems) {
    StateOwner* const owner = system->integrator().stateOwner();
    if (owner) owner->complete(*system);
    if (system->actors().passive_mappings.empty()) continue;
    if (owner)  // it left mapped rows behind with all others
      system->applyMappings();
    else
      system->mappingChain().placePassive(system->x, system->v);
  }
}

void Snapshots::compile(const Systems& systems) {
  for (const auto& system : systems) {
    good_.emplace_back(system->allRows());
    start_.emplace_back(system->allRows());
    start_.back().take(*system);
  }
}

void Snapshots::takeGood(const Systems& systems) { for (std::size_t i = 0; i < systems.size(); ++i) good_[i].take(*systems[i]); }

void Snapshots::putGoodBack(const Systems& systems, std::size_t count) const {
  for (std::size_t i = 0; i < count; ++i) good_[i].putBack(*systems[i]);
}

void Snapshots::putStartBack(const Systems& systems) const {
  for (std::size_t i = 0; i < systems.size(); ++i) start_[i].putBack(*systems[i]);
}

}  // namespace stroma
