// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Mesh_polyhedron_3.h>

#include "tools/mesh/mesh_generator.h"

namespace stroma::meshing {

using Surface = CGAL::Mesh_polyhedron_3<CGAL::Exact_predicates_inexact_constructions_kernel>::type;

/// Two triangles at each edge, turned outward, and none that cuts another; throws ComponentError.
Surface checkedSurface(const std::vector<Vec3>& position, const std::vector<Triangle>& triangles);

}  // namespace stroma::meshing
