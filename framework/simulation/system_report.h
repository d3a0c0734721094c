// SPDX-License-Identifier: LGPL-2.1-or-later
// Describes where the state of a system, or a step, went wrong.
#pragma once
#include <string>
#include <vector>

#include "framework/simulation/system.h"

namespace stroma {

/// Detects states that are not a valid result.
class FaultWatch {
 public:
  /// `system` must outlive this object.
  explicit FaultWatch(const System& system) : system_(system) {}
  /// Empty, or a sentence: prescribed motions of a node conflict, or x or v is not finite (with the state, the node and the
  /// suspected component), or an elastic body is more than a million times its size at rest (a hundred times if elements
  /// have grown as much) and larger than at `before` [m]. Such a body does not recover, and its state is meaningless long
  /// before it overflows. Nodes that nothing acts on are checked if they have been updated since
  /// the last check.
  std::string firstFault(ConstRows before);

 private:
  std::string firstNonFinite(ConstRows x, ConstRows v) const;
  std::string firstBurst(ConstRows before) const;

  const System& system_;
  double burst_size_ = -1;   ///< of the smallest elastic body [m]; -1: not computed yet
  long placings_seen_ = -1;  ///< MappingChain::passivePlacings() of the last check that found nothing
};

/// ForceField::worstElement() at x. For a field with a rest shape that names none: the two connected nodes whose distance has changed most.
std::string worstElementOf(const ForceField& field, const System& system, ConstRows x);
/// The message of a failed step: which step, of which system, why, and the worst elements at the system's positions.
std::string whereAndWhy(const System& system, const StepContext& context, const std::string& cause, const std::string& when);
/// A sentence for every elastic body that is more than ten times its size at rest.
std::vector<std::string> grownBodies(const System& system);
/// Throws ComponentError if a mass or a force field has a Rayleigh factor that `method` (the subject of the message) would
/// ignore.
void refuseRayleighFactors(const System& system, const std::string& method);

}  // namespace stroma
