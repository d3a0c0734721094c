// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "components/hyperelasticity/hyperelastic_tensors.h"
#include "framework/fem/hexahedron.h"

namespace stroma::hyperelastic {

/// The volume v of a trilinear hexahedron is the sum of det J over its 2x2x2 points, exactly. With j = 8 J
/// (hexahedron.h), the numbers here are of 512 v = sum_q det j_q, whose derivatives are brought to the nodes by the
/// transpose of what gave the j_q.
template <class T>
struct HexahedronVolume {
  using Points = hexahedron::PointValues<T>;
  Points j;

  explicit HexahedronVolume(const Points& points) : j(points) {}
  explicit HexahedronVolume(const V3<T> (&x)[8]) : j(hexahedron::atPoints(hexahedron::modesOf(x))) {}
  M3<T> cofactorAt(int p) const { return cofactor(hexahedron::Columns<T>(j, p).matrix()); }
  /// 512 v
  T value() const {
    T sum(0.);
    for (int p = 0; p < 8; ++p) sum += stroma::dot(hexahedron::Columns<T>(j, p).d[0], cofactorAt(p).c0);
    return sum;
  }
  /// sum cof j : dj, of nodes that move by those of d.
  T change(const HexahedronVolume& d) const {
    T sum(0.);
    for (int p = 0; p < 8; ++p) sum += hyperelastic::dot(cofactorAt(p), hexahedron::Columns<T>(d.j, p).matrix());
    return sum;
  }
  /// f = factor sum cof j, at the nodes.
  void gradient(T factor, V3<T> (&f)[8]) const {
    Points all;
    for (int p = 0; p < 8; ++p) {
      const M3<T> c = cofactorAt(p) * factor;
      hexahedron::addColumns(c.c0, c.c1, c.c2, p, all);
    }
    hexahedron::nodesOf(hexahedron::fromPoints(all), f);
  }
  /// f = factor times the change of gradient(1) for nodes that move by those of d, + along gradient(1).
  void gradientChange(const HexahedronVolume& d, T factor, T along, V3<T> (&f)[8]) const {
    Points all;
    for (int p = 0; p < 8; ++p) {
      const M3<T> now = hexahedron::Columns<T>(j, p).matrix(), moved = hexahedron::Columns<T>(d.j, p).matrix();
      const M3<T> c = cofactorDifferential(now, moved) * factor + cofactor(now) * along;
      hexahedron::addColumns(c.c0, c.c1, c.c2, p, all);
    }
    hexahedron::nodesOf(hexahedron::fromPoints(all), f);
  }
};

}  // namespace stroma::hyperelastic
