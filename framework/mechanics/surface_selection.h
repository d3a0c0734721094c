// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <vector>

#include "framework/mechanics/state.h"
#include "framework/mesh/area_vectors.h"
#include "framework/mesh/mesh.h"

namespace stroma {

/// The faces that a surface load acts on, as attributes of its component: the listed triangles, quads and quadratic
/// triangles; without lists all of the mesh but those between two of its volume cells, or the boundary of these when it
/// lists no faces, that lie in a box of the rest shape.
class SurfaceSelection {
 public:
  /// Declares triangleIndices, quadIndices, quadraticTriangleIndices, min and max.
  void declare(DataTable& table);
  /// By nodes of the state, at least one. Throws ComponentError.
  std::vector<Face> faces(const Component& load, const Mesh& mesh, const State& state) const;

 private:
  std::vector<Face> listed(const Component& load, const Mesh& mesh) const;
  std::vector<Face> inBox(const Component& load, const Mesh& mesh, const State& state) const;

  std::vector<int> triangle_indices_, quad_indices_, quadratic_indices_;
  Vec3 low_ = Vec3::Zero(), high_ = Vec3::Zero();
};

}  // namespace stroma
