// SPDX-License-Identifier: LGPL-2.1-or-later
// Linear tetrahedra in the forms standard and projected, for all laws.
#include "components/hyperelasticity/fan_law.h"

#include "components/hyperelasticity/point_kernels.h"
#include "framework/scene/factory.h"

using namespace stroma;
using namespace stroma::hyperelastic;

namespace {

template <class Tangent>
std::unique_ptr<ElementKernels> fansOfForm(const PointFunctions& law, const Cells& cells) {
  if (law.anisotropic) return std::make_unique<FanLaw<Tangent, MaterialFrame>>(law, cells);
  return std::make_unique<FanLaw<Tangent, TriangularFrame>>(law, cells);
}
std::unique_ptr<ElementKernels> fanLaw(const HyperelasticLaw& law, const Cells& cells) {
  const PointFunctions& functions = *law.at_point(cells.form);
  return cells.form == Form::standard ? fansOfForm<StandardTangent>(functions, cells)
                                      : fansOfForm<ProjectedTangent>(functions, cells);
}

}  // namespace

STROMA_COMPONENT(fan_law) {
  if (!pointKernels().tetrahedra) pointKernels().tetrahedra = fanLaw;
}
