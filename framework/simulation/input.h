// SPDX-License-Identifier: LGPL-2.1-or-later
// External forces: a user's hand, a device, a program. They begin and end between steps.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "framework/scene/types.h"

namespace stroma {

/// A ball that pushes nodes inside it outwards.
struct Ball {
  Vec3 centre = Vec3::Zero();  ///< [m]
  double radius = 0;           ///< [m], positive
  bool operator==(const Ball& other) const { return centre == other.centre && radius == other.radius; }
};

/// An external action on nodes of one state: a force, a pull towards targets, or both,
///   f_i = force + stiffness (target_i - x_i) - damping v_i
/// A mouse pulls one node towards a target; a handle pulls several. Nodes are rows of the state: for a frame the centre or
/// the orientation. An orientation takes a torque instead of a force, and a rotation vector as its target: the torque is
/// stiffness [N m/rad] times the rotation vector that leads to it.
///
/// Or a ball that pushes every point of the state inside it, d_i = |x_i - centre| < radius:
///   f_i = (stiffness (radius - d_i) - damping v_i . n_i) n_i,   n_i = (x_i - centre) / d_i
/// with n_i along x if d_i = 0, so that a point at the centre leaves it too. Points inside are found in each evaluation of
/// the forces. Nodes and targets are then empty, and the force is zero.
struct Input {
  std::string state;            ///< path of the state
  std::vector<Index> nodes;     ///< of the state; empty with a ball
  Vec3 force = Vec3::Zero();    ///< on each node [N]
  std::vector<Vec3> targets{};  ///< [m], one per node; empty: no pull
  double stiffness = 0;         ///< [N/m]
  double damping = 0;           ///< [N s/m]
  std::optional<Ball> ball{};   ///< instead of nodes

  /// Whether only forces and targets, or the centre and radius of a ball, differ from those of `other`. The derivatives of
  /// the force are then unchanged or, with a ball, are updated by the next evaluation of the forces, as when nodes
  /// move.
  bool hasDerivativesOf(const Input& other) const {
    return state == other.state && nodes == other.nodes && stiffness == other.stiffness && damping == other.damping &&
           ball.has_value() == other.ball.has_value();
  }
};

class State;
/// Throws ComponentError for nodes that `state` does not have, and for numbers that define no force.
void checkInput(const Input& input, const State& state);

}  // namespace stroma
