// SPDX-License-Identifier: LGPL-2.1-or-later
// The kernels of tetrahedra, by groups that are compiled apart: element loops take a compiler long.
#pragma once
#include "components/elasticity/elastic_kernels.h"
#include "components/elasticity/fan_kernels.h"
#include "components/elasticity/tetrahedron_shapes.h"

namespace stroma::tetrahedron {

/// What kernels are made of.
struct Elements {
  const TetrahedronShapes& shapes;
  Index first_row;  ///< row of node 0
  const LameOf& lame;
};

/// method = large, polar, svd (Rotation): tetrahedron_large.cpp, _polar.cpp and _svd.cpp.
template <class Rotation>
std::unique_ptr<ElementKernels> rotatedKernels(const ElasticVariant& variant, const Elements& elements);
/// The same with dilatation = mean: nodal_dilatation.cpp.
template <class Rotation>
std::unique_ptr<ElementKernels> averagedKernels(const ElasticVariant& variant, const Elements& elements);

/// The elements of `fans`, whose `element` are cells of the mesh.
template <class Storage>
[[gnu::noinline]] void fillFans(Storage& storage, const std::vector<Fan>& fans, const TetrahedronShapes& shapes,
                                const LameOf& lame) {
  storage.fill([&](std::size_t f, bool padding, auto& rest, auto& tangent) {
    for (int i = 0; i < fan_size; ++i) {
      const Index e = fans[f].element[i];
      Tetrahedron nodes;
      for (int a = 0; a < 4; ++a) nodes[a] = fans[f].nodes[corner(i, a)];
      shapes.set(std::size_t(e >= 0 ? e : fans[f].element[0]), nodes, padding || e < 0, lame, rest.of[i],
                 tangent.of[i]);
    }
  });
}
template <class Storage>
Storage fanStorage(const std::vector<Fan>& fans, const Elements& elements) {
  Storage storage;
  storage.arrange(nodesOf(fans), elements.shapes.positions(), elements.first_row);
  fillFans(storage, fans, elements.shapes, elements.lame);
  return storage;
}
template <class Single>
std::unique_ptr<ElementKernels> kernelsOf(const Elements& elements) {
  using Storage = StorageOf<FanOf<Single>>;
  std::vector<Fan> fans = gatherFans(elements.shapes.mesh().tetrahedra, elements.shapes.positions().size());
  Storage storage = fanStorage<Storage>(fans, elements);
  auto fill = [fans = std::move(fans), &shapes = elements.shapes, lame = elements.lame](Storage& stored) {
    fillFans(stored, fans, shapes, lame);
  };
  if constexpr (requires { Single::turns; })
    return std::make_unique<FanKernels<Single>>(std::move(storage), std::move(fill));
  else
    return std::make_unique<ModelKernels<FanOf<Single>>>(std::move(storage), std::move(fill));
}

}  // namespace stroma::tetrahedron
