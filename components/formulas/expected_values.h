// SPDX-License-Identifier: LGPL-2.1-or-later
// What Expect compares: numbers of nodes, and the momentum of a scene.
#pragma once
#include <string>
#include <vector>

#include "framework/simulation/system.h"

namespace stroma::expect {

/// A number, what it is called, and where its node is at rest.
struct Value {
  double number;
  std::string name;
  Vec3 place = Vec3::Zero();
};

/// Which numbers a scene asks for.
struct Chosen {
  const std::string& of;          ///< as the scene names them
  int axis;                       ///< 0: all, 1 to 3: x to z, 4: norm
  const std::vector<int>& nodes;  ///< empty: all
};

/// Appends the components of v that `axis` asks for.
void appendVector(const Vec3& v, int axis, const std::string& name, const Vec3& place, std::vector<Value>& out);
/// `name`: displacement, position, velocity, orientation or angularVelocity.
std::vector<Value> nodeValues(const State& state, const std::string& name, const Chosen& chosen);
/// Of all masses, about the origin. Mapped nodes must be up to date.
std::vector<Value> momentumOf(const std::vector<std::unique_ptr<System>>& systems, bool angular, const Chosen& chosen);
/// Throws ComponentError if a mass is on numbers: they may be angles or lengths along any axis.
void checkMomentum(const std::vector<std::unique_ptr<System>>& systems);

}  // namespace stroma::expect
