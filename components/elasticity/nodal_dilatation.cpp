// SPDX-License-Identifier: LGPL-2.1-or-later
// Tetrahedra with method = large, polar or svd and dilatation = mean.
#include "components/elasticity/tetrahedron_rotated.h"

namespace stroma::tetrahedron {

template std::unique_ptr<ElementKernels> averagedKernels<rotation::Qr>(const ElasticVariant&, const Elements&);
template std::unique_ptr<ElementKernels> averagedKernels<rotation::Polar>(const ElasticVariant&, const Elements&);
template std::unique_ptr<ElementKernels> averagedKernels<rotation::Svd>(const ElasticVariant&, const Elements&);

}  // namespace stroma::tetrahedron
