// SPDX-License-Identifier: LGPL-2.1-or-later
// Kernels of hyperelastic_volume.h. With r = v/V = s sum_q det j_q, s = 1/(512 V) (hexahedron_volume.h),
//   f = -k V U' s sum_q cof j_q,   df = -k V (U' s sum_q dcof j_q + U'' s^2 (sum_q cof j_q : dj_q) sum_q cof j_q)
#include "components/hyperelasticity/hyperelastic_volume.h"

#include "components/hyperelasticity/hexahedron_volume.h"
#include "components/hyperelasticity/hyperelastic_hexahedron.h"
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
  static void force(const Rest<T>& rest, Tangent<T>& t, const V3<T> (&x)[8], V3<T> (&f)[8]) {
    const HexahedronVolume<T> v(x);
    const Curve<T> u = U::at(rest.per_volume * v.value());
    t.first = rest.weight * u.first * rest.per_volume;
    t.second = rest.weight * u.second * rest.per_volume * rest.per_volume;
    v.gradient(t.first, f);
  }
  template <class T>
  static T energy(const Rest<T>& rest, const Tangent<T>&, const V3<T> (&x)[8]) {
    return -rest.weight * U::at(rest.per_volume * HexahedronVolume<T>(x).value()).value;
  }
  template <class T>
  static void product(const Rest<T>&, const Tangent<T>& t, T factor, const V3<T> (&x)[8], const V3<T> (&dx)[8],
                      V3<T> (&df)[8]) {
    const HexahedronVolume<T> v(x), d(dx);
    v.gradientChange(d, factor * t.first, factor * t.second * v.change(d), df);
  }
};

template <class U>
std::unique_ptr<ElementKernels> methodOf(const Cells& cells, const HyperelasticLaw& law) {
  StorageOf<MeanVolume<U>> storage;
  storage.build(cells.mesh->hexahedra, *cells.rest, cells.first_row,
                [&](std::size_t cell, bool padding, auto& rest, auto&) {
                  const double volume = HexahedronVolume<double>(restPoints(cells, cell)).value();
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
