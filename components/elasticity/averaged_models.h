// SPDX-License-Identifier: LGPL-2.1-or-later
// What nodal_dilatation.h needs of elements: methods without their volume change, that change apart, and the cells that
// share averages.
#pragma once
#include <algorithm>

#include "components/elasticity/nodal_patches.h"
#include "components/elasticity/tetrahedron_models.h"
#include "framework/fem/fan_model.h"

namespace stroma::tetrahedron {

/// What a product reads: as Tangent, with -2/3 for the ratio lambda/mu; `weight` = V_0 / (mu V_0)^1/2, which makes V_0
/// tr(eps) of the trace of a strain times (mu V_0)^1/2; and that V_0 tr(eps) [m^3] at the last force.
template <class T>
struct AveragedTangent {
  Gradients<T> g;
  T ratio, weight, volume_change;
};
inline void setTangent(AveragedTangent<double>& t, const Gradients<double>& g, Lame lame, double volume) {
  Tangent<double> own;
  setTangent(own, g, lame, volume);
  t = {own.g, -2. / 3, lame.mu > 0 ? std::sqrt(volume / lame.mu) : 0, 0};
}

/// A model (Linear, Corotational) without its volume change.
template <class Single>
struct Deviatoric : Single {
  template <class T>
  using Rest = typename Single::template Rest<T>;
  template <class T>
  using Tangent = AveragedTangent<T>;
  template <class T>
  static void force(const Rest<T>& rest, AveragedTangent<T>& t, const V3<T> (&x)[4], V3<T> (&f)[4]) {
    V3<T> none[4];
    forceAndProduct(rest, t, T(0.), x, none, f);
  }
  /// volume_change is then that of the strain at x and of factor dx.
  template <class T>
  static void forceAndProduct(const Rest<T>& rest, AveragedTangent<T>& t, T factor, const V3<T> (&x)[4],
                              const V3<T> (&dx)[4], V3<T> (&f)[4]) {
    const S3<T> own = Single::strain(rest, t, x), both = own + strainOf(Edges(dx).e, t.g) * factor;
    t.volume_change = t.weight * (both.xx + both.yy + both.zz);
    nodalForces(restoringStress(both, t.ratio, T(1.)), t.g, f);
  }
};

/// What the exact tangent reads: g_i [1/m] at the last force, -2/3 mu V_0 and mu V_0 [J], V_0 [m^3], and of the last
/// force V_0 tr(eps) [m^3] and -V_0 p_e [J], which acts on dg.
template <class T>
struct ExactAveragedTangent {
  Gradients<T> g;
  T lambda, mu, weight, volume_change, pressure;
};
inline void setTangent(ExactAveragedTangent<double>& t, const Gradients<double>& g, Lame lame, double volume) {
  t = {g, -2. / 3 * lame.mu * volume, lame.mu * volume, volume, 0, 0};
}

/// ExactCorotational (tetrahedron_models.h) without its volume change: dR and dg are differentiated at the x of the last
/// force, under the pressure of the last force too.
template <class Rotation, Update update>
struct ExactDeviatoric : Model {
  static constexpr bool reads_position = true;
  template <class T>
  using Rest = RestOf<update, T>;
  template <class T>
  using Tangent = ExactAveragedTangent<T>;
  template <class T>
  static void force(const Rest<T>& rest, ExactAveragedTangent<T>& t, const V3<T> (&x)[4], V3<T> (&f)[4]) {
    const auto k = kinematics<Rotation, update>(rest, x);
    const S3<T> strain = strainOfKinematics<update>(k.d, k.g, T(1.));
    t.g = k.g;
    t.volume_change = t.weight * (strain.xx + strain.yy + strain.zz);
    nodalForces(restoringStress(strain, t.lambda, t.mu), k.g, f);
  }
  template <class T>
  static T energy(const Rest<T>& rest, const ExactAveragedTangent<T>& t, const V3<T> (&x)[4]) {
    const auto k = kinematics<Rotation, update>(rest, x);
    return storedEnergy(strainOfKinematics<update>(k.d, k.g, T(1.)), t.lambda, t.mu);
  }
  /// df = factor times the derivative of the force with p_e held; returns the derivative of V_0 tr(eps), without factor.
  template <class T>
  static T productAndVolumeChange(const Rest<T>& rest, const ExactAveragedTangent<T>& t, T factor, const V3<T> (&x)[4],
                                  const V3<T> (&dx)[4], V3<T> (&df)[4]) {
    const Variation<T> v = variation<Rotation, update>(rest, x, dx);
    const T lambda = factor * t.lambda, mu = factor * t.mu, pressure = factor * t.pressure;
    S3<T> held = restoringStress(v.strain, lambda, mu);
    held.xx += pressure, held.yy += pressure, held.zz += pressure;
    V3<T> from_strain[4], from_gradients[4];
    nodalForces(restoringStress(v.dstrain, lambda, mu), v.g, from_strain);
    nodalForces(held, v.dg, from_gradients);
    for (int a = 0; a < 4; ++a) df[a] = from_strain[a] + from_gradients[a];
    return t.weight * (v.dstrain.xx + v.dstrain.yy + v.dstrain.zz);
  }
  template <class T>
  static void product(const Rest<T>& rest, const ExactAveragedTangent<T>& t, T factor, const V3<T> (&x)[4],
                      const V3<T> (&dx)[4], V3<T> (&df)[4]) {
    productApart(rest, t, factor, x, dx, df);
  }
  /// Called and not inlined: for what is not done in each product. noipa: as in model_kernels.h.
  template <class T>
  [[gnu::noipa, gnu::flatten]] static T productApart(const Rest<T>& rest, const Tangent<T>& t, const T& factor,
                                                     const V3<T> (&x)[4], const V3<T> (&dx)[4], V3<T> (&df)[4]) {
    return productAndVolumeChange(rest, t, factor, x, dx, df);
  }
};

/// The cells of one material: everything that the averages do not share with other materials. `Storage`: of fans of one of
/// the models above.
template <class Storage>
struct AveragedCells {
  Storage storage;
  std::vector<Fan> fans;           ///< in the order of the storage's elements; Fan::element indexes `cells`
  std::vector<Tetrahedron> cells;  ///< rows of their nodes
  std::vector<Index> rows;         ///< rows of the nodes of all cells, ascending
  std::vector<double> share;       ///< V_a [m^3], shape of rows
  std::vector<double> factor;      ///< c_a = K/V_a [Pa/m^3], shape of rows
  NodalPatches patches;            ///< over `rows`, made when a matrix is asked for

  /// `volume`: V_e [m^3] of each cell.
  void average(double bulk, const std::vector<double>& volume) {
    for (const Tetrahedron& cell : cells) rows.insert(rows.end(), cell.begin(), cell.end());
    std::sort(rows.begin(), rows.end());
    rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
    share.assign(rows.size(), 0.);
    for (std::size_t e = 0; e < cells.size(); ++e)
      for (Index row : cells[e])
        share[std::size_t(std::lower_bound(rows.begin(), rows.end(), row) - rows.begin())] += volume[e] / 4;
    setBulk(bulk);
  }
  void setBulk(double bulk) {
    factor.clear();
    for (double v : share) factor.push_back(v > 0 ? bulk / v : 0);
  }
};

}  // namespace stroma::tetrahedron
