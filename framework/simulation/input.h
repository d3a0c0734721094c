// SPDX-License-Identifier: LGPL-2.1-or-later
// Forces from outside: a user's hand, a device, a program. They come and go between steps.
#pragma once
#include <string>
#include <vector>

#include "framework/scene/types.h"

namespace stroma {

/// What acts on nodes of one state: a force, a pull towards targets, or both,
///   f_i = force + stiffness (target_i - x_i) - damping v_i
/// A node that is pulled by a mouse is one node with a target; a handle is several.
struct Input {
  std::string state;            ///< path of the state
  std::vector<Index> nodes;     ///< of the state
  Vec3 force = Vec3::Zero();    ///< on each node [N]
  std::vector<Vec3> targets{};  ///< [m], one per node; empty: no pull
  double stiffness = 0;         ///< [N/m]
  double damping = 0;           ///< [N s/m]

  /// Whether the derivatives of the force are those of `other`: at most forces and targets differ.
  bool hasDerivativesOf(const Input& other) const {
    return state == other.state && nodes == other.nodes && stiffness == other.stiffness && damping == other.damping;
  }
};

class State;
/// Throws ComponentError with a sentence: nodes that `state` does not have, or numbers that make no force.
void checkInput(const Input& input, const State& state);

}  // namespace stroma
