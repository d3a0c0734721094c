// SPDX-License-Identifier: LGPL-2.1-or-later
// Hooke's law at the Gauss points of a hexahedron.
//
// Mean dilatation (Nagtegaal, Parks and Rice 1974; the B-bar of Hughes 1980): the volume change is one number an
// element,
//   theta = 1/V sum w tr(eps),   sigma = K theta I + 2 mu dev(eps),   K = lambda + 2/3 mu,   V = sum w
// at every Gauss point, so that a nearly incompressible element does not lock. V and w are those at rest; with B and V
// updated a point counts with (w w_0)^1/2. For St. Venant-Kirchhoff it is the mean of tr(E), a measure of volume while
// strains are small. In the constants below: lambda becomes -2/3 mu, the local part of dev, and `bulk` = K/V acts on
// sum w tr(eps).
#pragma once
#include "components/elasticity/hexahedron_modes.h"

namespace stroma::hexahedron {

/// Hooke's law at the Gauss points: of the strain there.
template <class T>
struct LocalDilatation {
  T lambda, mu;  ///< [Pa]
};
/// The same with the mean dilatation.
template <class T>
struct MeanDilatation {
  T lambda, mu;  ///< -2/3 mu and mu [Pa]
  T root[8];     ///< w^1/2 of the Gauss points [m^3/2]
  T bulk;        ///< K/V [Pa/m^3]
};

/// tr(sum d_i (x) g_i)
template <class T>
T traceOf(const V3<T> (&d)[3], const Gradients<T>& g) {
  return stroma::dot(d[0], g.g1) + (stroma::dot(d[1], g.g2) + stroma::dot(d[2], g.g3));
}
/// -K/V sum w tr(eps) for the differences d at the Gauss points, zero where there is no mean.
template <class T>
T meanPressure(const LocalDilatation<T>&, const PointValues<T>&, const Gradients<T> (&)[8]) {
  return T(0.);
}
template <class T>
T meanPressure(const MeanDilatation<T>& law, const PointValues<T>& d, const Gradients<T> (&g)[8]) {
  T sum(0.);
  for (int p = 0; p < 8; ++p) sum = fma(law.root[p], traceOf(Columns<T>(d, p).d, g[p]), sum);
  return -law.bulk * sum;
}
/// -sigma, all times w^1/2, of a strain times w^1/2 at Gauss point p.
template <class T>
S3<T> stressAt(const LocalDilatation<T>& law, int, const S3<T>& strain, T factor, T) {
  return restoringStress(strain, factor * law.lambda, factor * law.mu);
}
template <class T>
S3<T> stressAt(const MeanDilatation<T>& law, int p, const S3<T>& strain, T factor, T mean_pressure) {
  S3<T> s = restoringStress(strain, factor * law.lambda, factor * law.mu);
  const T pressure = factor * mean_pressure * law.root[p];
  s.xx += pressure, s.yy += pressure, s.zz += pressure;
  return s;
}

/// -factor B^T D B of modes, with the gradients g of each Gauss point: the warped tangent, and the whole of a linear
/// element.
template <class T>
Modes<T> stiffnessProduct(const Gradients<T> (&g)[8], const auto& law, T factor, const Modes<T>& modes) {
  const PointValues<T> d = atPoints(modes);
  const T pressure = meanPressure(law, d, g);
  PointValues<T> forces;
  for (int p = 0; p < 8; ++p)
    addStress(stressAt(law, p, strainOf(Columns<T>(d, p).d, g[p]), factor, pressure), g[p], p, forces);
  return fromPoints(forces);
}

/// The stored energy of the differences d at the Gauss points.
template <class T>
T elementEnergy(const Gradients<T> (&g)[8], const auto& law, const PointValues<T>& d) {
  T sum(0.);
  for (int p = 0; p < 8; ++p) sum += storedEnergy(strainOf(Columns<T>(d, p).d, g[p]), law.lambda, law.mu);
  if constexpr (requires { law.bulk; }) {
    const T pressure = meanPressure(law, d, g);
    sum += T(0.5) * pressure * pressure / select(law.bulk == T(0.), T(1.), law.bulk);
  }
  return sum;
}

}  // namespace stroma::hexahedron
