// SPDX-License-Identifier: LGPL-2.1-or-later
// The types of Mesh_3 for a segmented image.
#pragma once
#include <CGAL/Labeled_mesh_domain_3.h>

#include "tools/mesh/meshing/cgal_mesh.h"

namespace stroma::meshing {

using ImageDomain = CGAL::Labeled_mesh_domain_3<Kernel>;
using ImageTriangulation = CGAL::Mesh_triangulation_3<ImageDomain, CGAL::Default, CGAL::Sequential_tag>::type;
using ImageComplex = CGAL::Mesh_complex_3_in_triangulation_3<ImageTriangulation>;
using ImageCriteria = CGAL::Mesh_criteria_3<ImageTriangulation>;

extern template void refine(ImageComplex&, const ImageDomain&, const ImageCriteria&);
extern template void perturb(ImageComplex&, const ImageDomain&, double);
extern template void exude(ImageComplex&, double);

}  // namespace stroma::meshing
