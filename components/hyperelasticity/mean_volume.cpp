// SPDX-License-Identifier: LGPL-2.1-or-later
// The mean dilatation of hexahedra.
#include "components/hyperelasticity/mean_volume.h"
#include "framework/scene/factory.h"

using namespace stroma;
using namespace stroma::hyperelastic;

STROMA_COMPONENT(mean_volume) {
  if (!meanVolumeKernels().hexahedra) meanVolumeKernels().hexahedra = meanVolumeOf<HexahedronPoints>;
}
