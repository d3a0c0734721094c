// SPDX-License-Identifier: LGPL-2.1-or-later
// The kernels of hexahedra, by groups that are compiled apart: element loops take a compiler long.
#pragma once
#include "components/elasticity/elastic_kernels.h"
#include "components/elasticity/hexahedron_shapes.h"
#include "components/elasticity/lame_of.h"

namespace stroma::hexahedron {

/// What kernels are made of.
struct Elements {
  const HexahedronShapes& shapes;
  Index first_row;  ///< row of node 0
  const LameOf& lame;
};

/// method = large, polar, svd (Rotation) but for a mean dilatation of shapes that are no boxes: hexahedron_large.cpp,
/// _polar.cpp and _svd.cpp.
template <class Rotation>
std::unique_ptr<ElementKernels> rotatedKernels(const Elements& elements);
/// Another polarOf than the gradient: hexahedron_polar.cpp. With `nearest` (method = svd) nodes give rotations alone.
std::unique_ptr<ElementKernels> polarKernels(PolarOf what, bool nearest, const Elements& elements);
/// dilatation = mean of shapes that are no boxes with any rotation, or none: hexahedron_mean.cpp.
std::unique_ptr<ElementKernels> meanKernels(const Elements& elements);
/// The same with the exact tangent of a rotation: hexahedron_mean_exact.cpp.
std::unique_ptr<ElementKernels> exactMeanKernels(const Elements& elements);

template <class Storage>
[[gnu::noinline]] void fillCells(Storage& storage, const HexahedronShapes& shapes, const LameOf& lame) {
  // cells that cover the body twice share its stiffness; a padding lane has none
  const double overlap = shapes.mesh().overlap;
  storage.fill([&](std::size_t e, bool padding, auto& rest, auto& tangent) {
    const double share = padding ? 0 : 1 / overlap;
    const Lame own = lame(e), constants{own.lambda * share, own.mu * share};
    shapes.set(shapes.atRest(e), constants, rest, tangent);
  });
}
template <class Model>
std::unique_ptr<ElementKernels> kernelsOf(const Elements& elements) {
  using Storage = StorageOf<Model>;
  const HexahedronShapes& shapes = elements.shapes;
  Storage storage;
  storage.arrange(shapes.mesh().hexahedra, shapes.positions(), elements.first_row);
  fillCells(storage, shapes, elements.lame);
  return std::make_unique<ModelKernels<Model>>(
      std::move(storage), [&shapes, lame = elements.lame](Storage& stored) { fillCells(stored, shapes, lame); });
}

}  // namespace stroma::hexahedron
