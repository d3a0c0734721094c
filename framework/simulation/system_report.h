// SPDX-License-Identifier: LGPL-2.1-or-later
// Messages about a system: where its state or a step went wrong.
#pragma once
#include <string>
#include <vector>

#include "framework/simulation/system.h"

namespace stroma {

/// Detects invalid states.
class FaultWatch {
 public:
  /// `system` outlives this.
  explicit FaultWatch(const System& system) : system_(system) {}
  /// Empty, or a sentence: prescribed motions put a node at places without a common point, or x or v is not finite (with
  /// the state, the node and the component to suspect), or an elastic body is more than a million times its size at rest
  /// (a hundred times where elements have grown as much) and larger than at `before` [m]. It will not come back, and
  /// long before it overflows nothing about it means anything. Nodes that nothing acts on are looked at when they have been
  /// placed since the last look.
  std::string firstFault(ConstRows before);

 private:
  std::string firstNonFinite(ConstRows x, ConstRows v) const;
  std::string firstBurst(ConstRows before) const;

  const System& system_;
  double burst_size_ = -1;   ///< of the smallest elastic body [m]; -1: not looked up yet
  long placings_seen_ = -1;  ///< MappingChain::passivePlacings() of the last look that found nothing
};

/// ForceField::worstElement() at x. Of a field with a rest shape that names none, the two tied nodes whose distance has changed most.
std::string worstElementOf(const ForceField& field, const System& system, ConstRows x);
/// The sentence of a step that failed: which, of what, why, and the worst elements at the system's positions.
std::string whereAndWhy(const System& system, const StepContext& context, const std::string& cause, const std::string& when);
/// A sentence for every elastic body that is more than ten times its size at rest.
std::vector<std::string> grownBodies(const System& system);
/// Throws ComponentError when a mass or a force field has a Rayleigh factor and `method` (a sentence's subject) has no
/// damping: it would be ignored.
void refuseRayleighFactors(const System& system, const std::string& method);

}  // namespace stroma
