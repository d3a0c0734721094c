// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/mesh/meshing/mesh_stages.h"
#include "tools/mesh/meshing/surface_mesh.h"

namespace stroma::meshing {

template void exude(SurfaceComplex&, double);

}  // namespace stroma::meshing
