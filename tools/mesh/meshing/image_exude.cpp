// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/mesh/meshing/image_mesh.h"
#include "tools/mesh/meshing/mesh_stages.h"

namespace stroma::meshing {

template void exude(ImageComplex&, double);

}  // namespace stroma::meshing
