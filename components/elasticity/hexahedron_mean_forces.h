// SPDX-License-Identifier: LGPL-2.1-or-later
// The force and energy loops of rotated hexahedra with dilatation = mean, which both tangents share: STROMA_MEAN_FORCES is
// empty in the source that has them, and extern in the other.
#pragma once
#include "components/elasticity/hexahedron_points.h"

namespace stroma {

#define STROMA_MEAN_FORCES_OF(Rotation)                                                            \
  STROMA_MEAN_FORCES template struct ForceLoops<                                                   \
      hexahedron::PointCorotational<hexahedron::MeanDilatation, Rotation, elastic::Update::none>>; \
  STROMA_MEAN_FORCES template struct ForceLoops<                                                   \
      hexahedron::PointCorotational<hexahedron::MeanDilatation, Rotation, elastic::Update::strain_displacement>>
STROMA_MEAN_FORCES_OF(rotation::Qr);
STROMA_MEAN_FORCES_OF(rotation::Polar);
STROMA_MEAN_FORCES_OF(rotation::Svd);
#undef STROMA_MEAN_FORCES_OF

}  // namespace stroma
