// SPDX-License-Identifier: LGPL-2.1-or-later
// Forces from outside: a user's hand, a device, a program. They come and go between steps.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "framework/scene/types.h"

namespace stroma {

/// A ball that pushes what is inside it outwards.
struct Ball {
  Vec3 centre = Vec3::Zero();  ///< [m]
  double radius = 0;           ///< [m], more than 0
  bool operator==(const Ball& other) const { return centre == other.centre && radius == other.radius; }
};

/// What acts on nodes of one state: a force, a pull towards targets, or both,
///   f_i = force + stiffness (target_i - x_i) - damping v_i
/// A node that is pulled by a mouse is one node with a target; a handle is several. Nodes are rows of the state: of a frame
/// its centre, or its orientation, which is turned by a torque in the place of the force, towards the rotation vector that
/// is its target, by stiffness times the rotation vector that leads there [N m/rad].
///
/// Or a ball, which pushes every place of the state that is inside it, d_i = |x_i - centre| < radius:
///   f_i = (stiffness (radius - d_i) - damping v_i . n_i) n_i,   n_i = (x_i - centre) / d_i
/// with n_i along x where d_i = 0: a place in the centre leaves it one way or another. Which places are inside is found
/// in each evaluation of the forces. Nodes and targets are then empty, and the force is zero.
struct Input {
  std::string state;            ///< path of the state
  std::vector<Index> nodes;     ///< of the state; empty with a ball
  Vec3 force = Vec3::Zero();    ///< on each node [N]
  std::vector<Vec3> targets{};  ///< [m], one per node; empty: no pull
  double stiffness = 0;         ///< [N/m]
  double damping = 0;           ///< [N s/m]
  std::optional<Ball> ball{};   ///< in the place of nodes

  /// Whether only forces and targets, or the place and the size of a ball, differ from those of `other`: the derivatives
  /// of the force are then what they were, or, with a ball, follow with the next evaluation of the forces as they do
  /// when nodes move.
  bool hasDerivativesOf(const Input& other) const {
    return state == other.state && nodes == other.nodes && stiffness == other.stiffness && damping == other.damping &&
           ball.has_value() == other.ball.has_value();
  }
};

class State;
/// Throws ComponentError with a sentence: nodes that `state` does not have, or numbers that make no force.
void checkInput(const Input& input, const State& state);

}  // namespace stroma
