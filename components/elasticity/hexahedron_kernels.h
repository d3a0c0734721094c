// SPDX-License-Identifier: LGPL-2.1-or-later
// The kernels of hexahedra, by groups that are compiled apart: element loops take a compiler long.
#pragma once
#include "components/elasticity/elastic_kernels.h"
#include "components/elasticity/hexahedron_shapes.h"
#include "components/elasticity/lame_of.h"

namespace stroma::hexahedron {

/// What kernels are made of: cells of a mesh.
struct Elements {
  const HexahedronShapes& shapes;
  Index first_row;  ///< row of node 0
  const LameOf& lame;
  bool boxes;                                 ///< all of them are, and their models are wanted
  const std::vector<Index>* chosen = nullptr;  ///< which of the mesh, kept by the shapes; null: all
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

/// How HexahedronShapes sets the numbers of a cell. Kernels with other numbers bring a function of their own.
struct SetByShapes {
  void operator()(const HexahedronShapes& shapes, const RestShape& shape, const Lame& constants, auto& rest, auto& tangent) const {
    shapes.set(shape, constants, rest, tangent);
  }
};
/// `Set` is made anew for each filling, so that it can remember what it has found.
template <class Set, class Storage>
[[gnu::noinline]] void fillCells(Storage& storage, const HexahedronShapes& shapes, const LameOf& lame, const std::vector<Index>* chosen) {
  // cells that cover the body twice share its stiffness; a padding lane has none
  const double overlap = shapes.mesh().overlap;
  Set set;
  storage.fill([&](std::size_t i, bool padding, auto& rest, auto& tangent) {
    const std::size_t e = chosen ? std::size_t((*chosen)[i]) : i;
    const double share = padding ? 0 : 1 / overlap;
    const Lame own = lame(e), constants{own.lambda * share, own.mu * share};
    set(shapes, shapes.atRest(e), constants, rest, tangent);
  });
}
template <class Model, class Set = SetByShapes>
std::unique_ptr<ElementKernels> kernelsOf(const Elements& elements) {
  using Storage = StorageOf<Model>;
  const HexahedronShapes& shapes = elements.shapes;
  const std::vector<Index>* const chosen = elements.chosen;
  Storage storage;
  if (chosen) {
    std::vector<Hexahedron> cells;
    cells.reserve(chosen->size());
    for (const Index e : *chosen) cells.push_back(shapes.mesh().hexahedra[std::size_t(e)]);
    storage.arrange(cells, shapes.positions(), elements.first_row);
  } else {
    storage.arrange(shapes.mesh().hexahedra, shapes.positions(), elements.first_row);
  }
  fillCells<Set>(storage, shapes, elements.lame, chosen);
  return std::make_unique<ModelKernels<Model>>(std::move(storage), [&shapes, lame = elements.lame, chosen](Storage& stored) {
    fillCells<Set>(stored, shapes, lame, chosen);
  });
}

}  // namespace stroma::hexahedron
