// SPDX-License-Identifier: LGPL-2.1-or-later
// Kernels of hyperelastic_volume.h. The volume of a trilinear hexahedron is the sum of det J over its 2x2x2 points,
// exactly: it needs the nodes alone. With j = 8 J (hexahedron.h) and r = v/V = s sum_q det j_q, s = 1/(512 V),
//   f = -k V U' s sum_q cof j_q,   df = -k V (U' s sum_q dcof j_q + U'' s^2 (sum_q cof j_q : dj_q) sum_q cof j_q)
// brought to the nodes by the transpose of what gave the j_q.
#include "components/hyperelasticity/hyperelastic_volume.h"

#include "components/hyperelasticity/hyperelastic_hexahedron.h"
#include "framework/fem/eigen_matrix.h"
#include "framework/fem/hexahedron.h"
#include "framework/fem/model_kernels.h"
#include "framework/scene/factory.h"

using namespace stroma;
using namespace stroma::hyperelastic;

namespace {

/// U(r), U' and U''.
template <class T>
struct Curve {
  T value, first, second;
};
struct HalfLogSquared {
  template <class T>
  static Curve<T> at(T r) {
    const T l = log(r), inverse = T(1.) / r;
    return {T(0.5) * l * l, l * inverse, (T(1.) - l) * inverse * inverse};
  }
};
struct HalfSquare {
  template <class T>
  static Curve<T> at(T r) {
    const T change = r - T(1.);
    return {T(0.5) * change * change, change, T(1.)};
  }
};
struct LogIntegral {
  template <class T>
  static Curve<T> at(T r) {
    const T l = log(r);
    return {fma(r, l - T(1.), T(1.)), l, T(1.) / r};
  }
};

template <class U>
struct MeanVolume : EightNodes {
  template <class T>
  struct Rest {
    T per_volume;  ///< s, negative where the rest shape is left-handed [1/m^3]
    T weight;      ///< -k V [J]
  };
  template <class T>
  struct Tangent {
    T first, second;  ///< -k V U' s and -k V U'' s^2
  };

  template <class T>
  static M3<T> cofactorAt(const Points<T>& j, int p) {
    return cofactor(hexahedron::Columns<T>(j, p).matrix());
  }
  template <class T>
  static T ratio(const Rest<T>& rest, const Points<T>& j) {
    T sum(0.);
    for (int p = 0; p < 8; ++p) sum += stroma::dot(hexahedron::Columns<T>(j, p).d[0], cofactorAt(j, p).c0);
    return rest.per_volume * sum;
  }

  template <class T>
  static void force(const Rest<T>& rest, Tangent<T>& t, const V3<T> (&x)[8], V3<T> (&f)[8]) {
    const Points<T> j = hexahedron::atPoints(hexahedron::modesOf(x));
    const Curve<T> u = U::at(ratio(rest, j));
    t.first = rest.weight * u.first * rest.per_volume;
    t.second = rest.weight * u.second * rest.per_volume * rest.per_volume;
    Points<T> forces;
    for (int p = 0; p < 8; ++p) {
      const M3<T> c = cofactorAt(j, p) * t.first;
      hexahedron::addColumns(c.c0, c.c1, c.c2, p, forces);
    }
    hexahedron::nodesOf(hexahedron::fromPoints(forces), f);
  }
  template <class T>
  static T energy(const Rest<T>& rest, const Tangent<T>&, const V3<T> (&x)[8]) {
    return -rest.weight * U::at(ratio(rest, hexahedron::atPoints(hexahedron::modesOf(x)))).value;
  }
  template <class T>
  static void product(const Rest<T>&, const Tangent<T>& t, T factor, const V3<T> (&x)[8], const V3<T> (&dx)[8],
                      V3<T> (&df)[8]) {
    const Points<T> j = hexahedron::atPoints(hexahedron::modesOf(x)),
                    dj = hexahedron::atPoints(hexahedron::modesOf(dx));
    T change(0.);
    for (int p = 0; p < 8; ++p) change += hyperelastic::dot(cofactorAt(j, p), hexahedron::Columns<T>(dj, p).matrix());
    const T first = factor * t.first, along = factor * t.second * change;
    Points<T> forces;
    for (int p = 0; p < 8; ++p) {
      const M3<T> now = hexahedron::Columns<T>(j, p).matrix(), moved = hexahedron::Columns<T>(dj, p).matrix();
      const M3<T> c = cofactorDifferential(now, moved) * first + cofactor(now) * along;
      hexahedron::addColumns(c.c0, c.c1, c.c2, p, forces);
    }
    hexahedron::nodesOf(hexahedron::fromPoints(forces), df);
  }
};

template <class U>
std::unique_ptr<ElementKernels> methodOf(const Cells& cells, const HyperelasticLaw& law) {
  StorageOf<MeanVolume<U>> storage;
  storage.build(cells.mesh->hexahedra, *cells.rest, cells.first_row,
                [&](std::size_t cell, bool padding, auto& rest, auto&) {
                  const auto j = restPoints(cells, cell);
                  rest.per_volume = 1;
                  const double volume = MeanVolume<U>::ratio(rest, j);
                  rest.per_volume = 1 / volume;
                  const double k = cells.parameters(cell)[law.volume_parameter];
                  rest.weight = padding ? 0 : -k * std::abs(volume) / (512 * cells.mesh->overlap);
                });
  return std::make_unique<ModelKernels<MeanVolume<U>>>(std::move(storage));
}

std::unique_ptr<ElementKernels> hexahedra(const Cells& cells, const HyperelasticLaw& law) {
  if (law.volume == VolumePart::half_square) return methodOf<HalfSquare>(cells, law);
  if (law.volume == VolumePart::log_integral) return methodOf<LogIntegral>(cells, law);
  return methodOf<HalfLogSquared>(cells, law);
}

}  // namespace

STROMA_COMPONENT(mean_volume) {
  if (!meanVolumeKernels().hexahedra) meanVolumeKernels().hexahedra = hexahedra;
}
