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

/// polarOf = nodes, as in SOFA's CorotationalFEMForceField: the polar factor of sum (x_a - c)(X_a - C)^T, which of a parallelepiped
/// at rest is twice that of its mean edges.
struct PolarOfNodes {
  template <class T>
  static M3<T> of(const M3<T>& now, const M3<T>& then) {
    return rotation::Polar::of(
        M3<T>{fma(then.c0.x, now.c0, fma(then.c1.x, now.c1, now.c2 * then.c2.x)),
              fma(then.c0.y, now.c0, fma(then.c1.y, now.c1, now.c2 * then.c2.y)),
              fma(then.c0.z, now.c0, fma(then.c1.z, now.c1, now.c2 * then.c2.z))});
  }
};

template <class Rotation>
std::unique_ptr<ElementKernels> kernelsOfEdges(const Elements& elements) {
  if (elements.shapes.useBoxes()) return kernelsOf<BoxCorotational<Rotation>>(elements);
  return kernelsOf<PointCorotational<LocalDilatation, Rotation, Update::none>>(elements);
}

}  // namespace

std::unique_ptr<ElementKernels> polarKernels(PolarOf what, const Elements& elements) {
  return what == PolarOf::nodes ? kernelsOfEdges<PolarOfNodes>(elements) : kernelsOfEdges<PolarOfEdges>(elements);
}

}  // namespace stroma::hexahedron

template std::unique_ptr<stroma::ElementKernels> stroma::hexahedron::rotatedKernels<stroma::rotation::Polar>(
    const Elements& elements);
