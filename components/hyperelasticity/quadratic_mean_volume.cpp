// SPDX-License-Identifier: LGPL-2.1-or-later
// The mean dilatation of quadratic tetrahedra.
#include "components/hyperelasticity/mean_volume.h"
#include "framework/scene/factory.h"

using namespace stroma;
using namespace stroma::hyperelastic;

STROMA_COMPONENT(quadratic_mean_volume) {
  if (!meanVolumeKernels().quadratic_tetrahedra)
    meanVolumeKernels().quadratic_tetrahedra = meanVolumeOf<QuadraticPoints>;
}
