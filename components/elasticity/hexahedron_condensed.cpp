// SPDX-License-Identifier: LGPL-2.1-or-later
// Hexahedra with incompatible modes.
#include "components/elasticity/hexahedron_condensed.h"

#include "components/elasticity/hexahedron_incompatible.h"
#include "components/elasticity/hexahedron_kernels.h"

namespace stroma::hexahedron {
namespace {

void set(const RestShape& shape, const Lame& law, bool mean, BoxRest<double>& rest, IncompatibleBoxes::Tangent<double>& tangent) {
  const double edges[3] = {shape.modes.xi.x, shape.modes.eta.y, shape.modes.zeta.z};
  for (int i = 0; i < 3; ++i) rest.edges[i] = edges[i], tangent.stiffness.inverse[i] = 8 / edges[i];
  tangent.axes = shape.frame;
  const double share = std::abs(shape.low) / 8;
  IncompatibleBox<double>& s = tangent.stiffness;
  s.lambda = law.lambda * share, s.mu = law.mu * share;
  s.varying = mean ? -2. / 3 * s.mu : s.lambda;
  s.plane = law.mu > 0 ? share * 2 * law.lambda * law.mu / (law.lambda + 2 * law.mu) : 0;
}
void set(const RestShape& shape, const Lame& law, bool mean, CondensedCells::Rest<double>& rest,
         CondensedCells::Tangent<double>& tangent) {
  tangent.axes = shape.frame;
  rest.modes = shape.modes;
  const Mat3 inverse = toEigen(meanEdges(rest.modes)).inverse();
  const int row[6] = {0, 0, 1, 0, 1, 2}, column[6] = {0, 1, 1, 2, 2, 2};
  for (int i = 0; i < 6; ++i) rest.inverse_edges[i] = inverse(row[i], column[i]);
  const IncompatibleModes::Condensed k = IncompatibleModes(shape.modes, law, mean).condensed();
  double* to = rest.k;
  for (int i = 0; i < CondensedCells::numbers; ++i)
    for (int j = i; j < CondensedCells::numbers; ++j) *to++ = (k(i, j) + k(j, i)) / 2;
}

template <class Storage>
void fill(Storage& storage, const HexahedronShapes& shapes, const LameOf& lame) {
  const double overlap = shapes.mesh().overlap;  // as in fillCells()
  storage.fill([&](std::size_t e, bool padding, auto& rest, auto& tangent) {
    const double share = padding ? 0 : 1 / overlap;
    const Lame own = lame(e);
    set(shapes.atRest(e), Lame{own.lambda * share, own.mu * share}, shapes.variant().mean_dilatation, rest, tangent);
  });
}
template <class Model>
std::unique_ptr<ElementKernels> condensedKernels(const Elements& elements) {
  using Storage = StorageOf<Model>;
  const HexahedronShapes& shapes = elements.shapes;
  Storage storage;
  storage.arrange(shapes.mesh().hexahedra, shapes.positions(), elements.first_row);
  fill(storage, shapes, elements.lame);
  return std::make_unique<ModelKernels<Model>>(std::move(storage),
                                               [&shapes, lame = elements.lame](Storage& stored) { fill(stored, shapes, lame); });
}
template <class Cells>
std::unique_ptr<ElementKernels> kernelsOfCells(const Elements& elements) {
  const ElasticVariant& variant = elements.shapes.variant();
  if (variant.method == ElasticMethod::small) return condensedKernels<Condensed<Cells>>(elements);
  return makeRotated(variant, [&]<class Rotation>() -> std::unique_ptr<ElementKernels> {
    if (variant.exact_tangent) return condensedKernels<ExactCondensed<Cells, Rotation>>(elements);
    return condensedKernels<CondensedCorotational<Cells, Rotation>>(elements);
  });
}

}  // namespace

std::unique_ptr<ElementKernels> incompatibleKernels(const Elements& elements) {
  bool are_boxes = true;
  for (std::size_t e = 0; are_boxes && e < elements.shapes.mesh().hexahedra.size(); ++e) are_boxes = elements.shapes.atRest(e).box;
  if (are_boxes) return kernelsOfCells<IncompatibleBoxes>(elements);
  return kernelsOfCells<CondensedCells>(elements);
}

}  // namespace stroma::hexahedron
