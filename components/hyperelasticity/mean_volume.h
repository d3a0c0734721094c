// SPDX-License-Identifier: LGPL-2.1-or-later
// Kernels of hyperelastic_volume.h. With r = v/V = s sum_q det j_q, s = 1 / sum_q det j_q at rest (cell_volume.h),
//   f = -k V U' s sum_q cof j_q,   df = -k V (U' s sum_q dcof j_q + U'' s^2 (sum_q cof j_q : dj_q) sum_q cof j_q)
// The first part of df has the signs of the pressure and of a form without a sign; the second is stable where U'' > 0.
#pragma once
#include "components/hyperelasticity/cell_volume.h"
#include "components/hyperelasticity/hyperelastic_volume.h"
#include "framework/fem/eigen_matrix.h"
#include "framework/fem/model_kernels.h"

namespace stroma::hyperelastic {

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

/// Products, which read the derivatives of U in the tangent and not U.
template <class Cell>
struct VolumeProducts {
  static constexpr int nodes = Cell::nodes;
  static constexpr bool reads_position = true;
  using Products = VolumeProducts;
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
  static void product(const Rest<T>&, const Tangent<T>& t, T factor, const V3<T> (&x)[nodes], const V3<T> (&dx)[nodes],
                      V3<T> (&df)[nodes]) {
    const CellVolume<Cell, T> v(x), d(dx);
    v.gradientChange(d, factor * t.first, factor * t.second * v.change(d), df);
  }
};

/// `definite`: df is its stable part.
template <class U, class Cell, bool definite>
struct MeanVolume : VolumeProducts<Cell> {
  using VolumeProducts<Cell>::nodes;
  template <class T>
  using Rest = typename VolumeProducts<Cell>::template Rest<T>;
  template <class T>
  using Tangent = typename VolumeProducts<Cell>::template Tangent<T>;

  template <class T>
  static void force(const Rest<T>& rest, Tangent<T>& t, const V3<T> (&x)[nodes], V3<T> (&f)[nodes]) {
    const CellVolume<Cell, T> v(x);
    const Curve<T> u = U::at(rest.per_volume * v.value());
    const T first = rest.weight * u.first * rest.per_volume;
    t.first = definite ? T(0.) : first;
    t.second = rest.weight * (definite ? maximum(u.second, T(0.)) : u.second) * rest.per_volume * rest.per_volume;
    v.gradient(first, f);
  }
  template <class T>
  static T energy(const Rest<T>& rest, const Tangent<T>&, const V3<T> (&x)[nodes]) {
    return -rest.weight * U::at(rest.per_volume * CellVolume<Cell, T>(x).value()).value;
  }
};

template <class Cell>
std::unique_ptr<ElementKernels> meanVolumeOf(const Cells& cells, const HyperelasticLaw& law, bool definite) {
  using Storage = StorageOf<VolumeProducts<Cell>>;
  const auto fill = [cells, parameter = law.volume_parameter](Storage& stored) {
    const auto& list = Cell::listOf(*cells.mesh);
    stored.fill([&](std::size_t cell, bool padding, auto& rest, auto&) {
      V3<double> x[Cell::nodes];
      for (std::size_t a = 0; a < Cell::nodes; ++a) x[a] = vectorOf((*cells.rest)[list[cell][a]]);
      const double volume = CellVolume<Cell, double>(x).value();
      rest.per_volume = 1 / volume;
      const double k = cells.parameters(cell)[parameter];
      rest.weight = padding ? 0 : -k * std::abs(volume) / (Cell::scale * cells.mesh->overlap);
    });
  };
  Storage storage;
  storage.arrange(Cell::listOf(*cells.mesh), *cells.rest, cells.first_row);
  fill(storage);
  const auto methodOf = [&]<class U, bool stable>(U, std::bool_constant<stable>) -> std::unique_ptr<ElementKernels> {
    return std::make_unique<ModelKernels<MeanVolume<U, Cell, stable>>>(std::move(storage), fill);
  };
  const auto ofVolume = [&](auto stable) {
    if (law.volume == VolumePart::half_square) return methodOf(HalfSquare(), stable);
    if (law.volume == VolumePart::log_integral) return methodOf(LogIntegral(), stable);
    return methodOf(HalfLogSquared(), stable);
  };
  return definite ? ofVolume(std::true_type()) : ofVolume(std::false_type());
}

}  // namespace stroma::hyperelastic
