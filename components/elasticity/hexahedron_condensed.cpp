// SPDX-License-Identifier: LGPL-2.1-or-later
// Hexahedra with incompatible modes.
#include "components/elasticity/hexahedron_condensed.h"

#include "components/elasticity/hexahedron_incompatible.h"
#include "components/elasticity/hexahedron_kernels.h"

namespace stroma::hexahedron {
namespace {

/// Sets K of a cell.
struct SetCondensed {
  void operator()(const HexahedronShapes& shapes, const RestShape& shape, const Lame& law, CondensedCells::Rest<double>& rest,
                  CondensedCells::Tangent<double>& tangent) const {
    tangent.axes = shape.frame;
    rest.modes = shape.modes;
    setUpper(toEigen(meanEdges(rest.modes)).inverse(), rest.inverse_edges);
    const IncompatibleModes::Condensed k = IncompatibleModes(shape.modes, law, shapes.variant().mean_dilatation).condensed();
    double* to = rest.k;
    for (int i = 0; i < CondensedCells::numbers; ++i)
      for (int j = i; j < CondensedCells::numbers; ++j) *to++ = (k(i, j) + k(j, i)) / 2;
  }
};

template <class Cells, class Set>
std::unique_ptr<ElementKernels> kernelsOfCells(const Elements& elements) {
  const ElasticVariant& variant = elements.shapes.variant();
  if (variant.method == ElasticMethod::small) return kernelsOf<ModalLinear<Cells>, Set>(elements);
  return makeRotated(variant, [&]<class Rotation>() -> std::unique_ptr<ElementKernels> {
    if (variant.exact_tangent) return kernelsOf<ExactModalCorotational<Cells, Rotation>, Set>(elements);
    return kernelsOf<ModalCorotational<Cells, Rotation>, Set>(elements);
  });
}

}  // namespace

std::unique_ptr<ElementKernels> incompatibleKernels(const Elements& elements) {
  if (elements.boxes) return kernelsOfCells<IncompatibleBoxes, SetByShapes>(elements);
  return kernelsOfCells<CondensedCells, SetCondensed>(elements);
}

}  // namespace stroma::hexahedron
