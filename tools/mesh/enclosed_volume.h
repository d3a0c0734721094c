// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <optional>
#include <vector>

#include "framework/scene/types.h"

namespace stroma {

/// What a surface of triangles encloses.
struct Enclosed {
  double volume = 0;  ///< hollows taken off, in the unit of the positions cubed
  double area = 0;
  int shells = 0;  ///< connected surfaces
};

/// Whatever way the triangles are turned: every shell counts with its size, and one that lies inside an odd number of
/// others is a hollow. Nodes in one place are one. None when an edge has not exactly two triangles or a shell has only
/// one side. Shells that cut each other are not looked for. Time: shells times triangles.
std::optional<Enclosed> enclosedBy(const std::vector<Vec3>& position, const std::vector<Triangle>& triangles);

}  // namespace stroma
