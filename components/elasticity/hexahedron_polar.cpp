// SPDX-License-Identifier: LGPL-2.1-or-later
// Hexahedra with method = polar.
#include "components/elasticity/hexahedron_rotated.h"

namespace stroma::hexahedron {
namespace {

/// polarOf = edges, as in SOFA: R = polar(mean edges now) polar(mean edges at rest)^T, which is the polar factor of F for cubes
/// alone. A mirrored cell counts with its third edge turned round, now and at rest.
struct PolarOfEdges {
  template <class T>
  static M3<T> of(const M3<T>& now, const M3<T>& then) {
    const T side = select(dot(then.c0, cross(then.c1, then.c2)) < T(0.), T(-1.), T(1.));
    const M3<T> q = rotation::Polar::of(M3<T>{now.c0, now.c1, now.c2 * side});
    const M3<T> p = rotation::Polar::of(M3<T>{then.c0, then.c1, then.c2 * side});
    return {fma(p.c0.x, q.c0, fma(p.c1.x, q.c1, q.c2 * p.c2.x)), fma(p.c0.y, q.c0, fma(p.c1.y, q.c1, q.c2 * p.c2.y)),
            fma(p.c0.z, q.c0, fma(p.c1.z, q.c1, q.c2 * p.c2.z))};
  }
};

}  // namespace

std::unique_ptr<ElementKernels> edgePolarKernels(const Elements& elements) {
  if (elements.shapes.useBoxes()) return kernelsOf<BoxCorotational<PolarOfEdges>>(elements);
  return kernelsOf<PointCorotational<LocalDilatation, PolarOfEdges, Update::none>>(elements);
}

}  // namespace stroma::hexahedron

template std::unique_ptr<stroma::ElementKernels> stroma::hexahedron::rotatedKernels<stroma::rotation::Polar>(
    const Elements& elements);
