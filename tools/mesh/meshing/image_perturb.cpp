// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/mesh/meshing/image_mesh.h"
#include "tools/mesh/meshing/mesh_stages.h"

namespace stroma::meshing {

template void perturb(ImageComplex&, const ImageDomain&, double);

}  // namespace stroma::meshing
