// SPDX-License-Identifier: LGPL-2.1-or-later
// Hexahedra with method = polar.
#include "components/elasticity/hexahedron_rotated.h"

namespace stroma::hexahedron {
namespace {

/// polarOf = edges, as in SOFA: R = polar(mean edges now) polar(mean edges at rest)^T, which is the polar factor of F for cubes
/// alone. Nothing is flipped: of a cell that has turned inside out R is a reflection.
struct PolarOfEdges {
  template <class T>
  static M3<T> of(const M3<T>& now, const M3<T>& then) {
    const M3<T> q = rotation::orthogonalFactor(now), p = rotation::orthogonalFactor(then);
    return {fma(p.c0.x, q.c0, fma(p.c1.x, q.c1, q.c2 * p.c2.x)), fma(p.c0.y, q.c0, fma(p.c1.y, q.c1, q.c2 * p.c2.y)),
            fma(p.c0.z, q.c0, fma(p.c1.z, q.c1, q.c2 * p.c2.z))};
  }
};

/// polarOf = nodes, as in SOFA's CorotationalFEMForceField: the polar factor of sum (x_a - c)(X_a - C)^T, which of a parallelepiped
/// at rest is twice that of its mean edges. A reflection where the cell is inside out, but the nearest rotation for method = svd.
template <bool nearest>
struct PolarOfNodes {
  template <class T>
  static M3<T> of(const M3<T>& now, const M3<T>& then) {
    const M3<T> sum{fma(then.c0.x, now.c0, fma(then.c1.x, now.c1, now.c2 * then.c2.x)),
                    fma(then.c0.y, now.c0, fma(then.c1.y, now.c1, now.c2 * then.c2.y)),
                    fma(then.c0.z, now.c0, fma(then.c1.z, now.c1, now.c2 * then.c2.z))};
    return nearest ? rotation::nearest(sum) : rotation::orthogonalFactor(sum);
  }
};

template <class Rotation>
std::unique_ptr<ElementKernels> kernelsOfEdges(const Elements& elements) {
  if (elements.boxes) return kernelsOf<ModalCorotational<Boxes, Rotation>>(elements);
  return kernelsOf<PointCorotational<LocalDilatation, Rotation, Update::none>>(elements);
}

}  // namespace

std::unique_ptr<ElementKernels> polarKernels(PolarOf what, bool nearest, const Elements& elements) {
  if (what == PolarOf::edges) return kernelsOfEdges<PolarOfEdges>(elements);
  return nearest ? kernelsOfEdges<PolarOfNodes<true>>(elements) : kernelsOfEdges<PolarOfNodes<false>>(elements);
}

}  // namespace stroma::hexahedron

template std::unique_ptr<stroma::ElementKernels> stroma::hexahedron::rotatedKernels<stroma::rotation::Polar>(
    const Elements& elements);
