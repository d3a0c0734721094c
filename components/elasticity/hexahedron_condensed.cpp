// SPDX-License-Identifier: LGPL-2.1-or-later
// Hexahedra with incompatible modes.
#include "components/elasticity/hexahedron_condensed.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "components/elasticity/hexahedron_incompatible.h"
#include "components/elasticity/hexahedron_kernels.h"

namespace stroma::hexahedron {
namespace {

/// Sets K of a cell. Cells of one shape and material have the same: it is condensed once for the first few hundred kinds.
class SetCondensed {
 public:
  void operator()(const HexahedronShapes& shapes, const RestShape& shape, const Lame& law, CondensedCells::Rest<double>& rest,
                  CondensedCells::Tangent<double>& tangent) {
    tangent.axes = shape.frame;
    rest.modes = shape.modes;
    setUpper(toEigen(meanEdges(rest.modes)).inverse(), rest.inverse_edges);
    const Key key = keyOf(shape.modes, law);
    if (const auto known = known_.find(key); known != known_.end()) {
      std::copy(known->second.begin(), known->second.end(), rest.k);
      return;
    }
    const IncompatibleModes::Condensed k = IncompatibleModes(shape.modes, law, shapes.variant().mean_dilatation).condensed();
    double* to = rest.k;
    for (int i = 0; i < CondensedCells::numbers; ++i)
      for (int j = i; j < CondensedCells::numbers; ++j) *to++ = (k(i, j) + k(j, i)) / 2;
    if (known_.size() < most) std::copy(rest.k, to, known_[key].begin());
  }

 private:
  static constexpr std::size_t most = 500;
  using Key = std::array<double, CondensedCells::numbers + 2>;
  /// Modes rounded to 1e-12 of the size, and the law.
  static Key keyOf(const Modes<double>& modes, const Lame& law) {
    const double step = std::exp2(std::ilogb(std::sqrt(dot(modes, modes))) - 39);
    Key key{};
    auto to = key.begin();
    forEachMode(modes, modes, [&](const V3<double>& v, const V3<double>&) {
      for (const double number : {v.x, v.y, v.z}) *to++ = step * std::nearbyint(number / step) + 0.;  // no -0
    });
    *to++ = law.lambda, *to = law.mu;
    return key;
  }

  std::map<Key, std::array<double, CondensedCells::numbers*(CondensedCells::numbers + 1) / 2>> known_;
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
