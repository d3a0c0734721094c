// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "components/hyperelasticity/hyperelastic_tensors.h"
#include "framework/fem/hexahedron.h"
#include "framework/fem/quadratic_tetrahedron.h"
#include "framework/mesh/mesh.h"

namespace stroma::hyperelastic {

/// For CellVolume and PointLaw: 8 J at 2x2x2 points (hexahedron.h).
struct HexahedronPoints {
  static constexpr int nodes = 8, points = 8;
  static constexpr double scale = 512;  ///< a point has det J over it of the volume
  static const auto& listOf(const Mesh& mesh) { return mesh.hexahedra; }
  template <class T>
  using Values = hexahedron::PointValues<T>;
  template <class T>
  static Values<T> at(const V3<T> (&x)[nodes]) {
    return hexahedron::atPoints(hexahedron::modesOf(x));
  }
  template <class T>
  static M3<T> matrix(const Values<T>& j, int p) {
    return hexahedron::Columns<T>(j, p).matrix();
  }
  template <class T>
  static void add(const M3<T>& c, int p, Values<T>& all) {
    hexahedron::addColumns(c.c0, c.c1, c.c2, p, all);
  }
  template <class T>
  static void toNodes(const Values<T>& all, V3<T> (&f)[nodes]) {
    hexahedron::nodesOf(hexahedron::fromPoints(all), f);
  }
};
/// J at four points (quadratic_tetrahedron.h).
struct QuadraticPoints {
  static constexpr int nodes = quadratic_tetrahedron::nodes, points = quadratic_tetrahedron::points;
  static constexpr double scale = 24;
  static const auto& listOf(const Mesh& mesh) { return mesh.quadratic_tetrahedra; }
  template <class T>
  using Values = quadratic_tetrahedron::PointValues<T>;
  template <class T>
  static Values<T> at(const V3<T> (&x)[nodes]) {
    return quadratic_tetrahedron::atPoints(x);
  }
  template <class T>
  static M3<T> matrix(const Values<T>& j, int p) {
    return j.matrix(p);
  }
  template <class T>
  static void add(const M3<T>& c, int p, Values<T>& all) {
    all.d[p][0] = c.c0, all.d[p][1] = c.c1, all.d[p][2] = c.c2;
  }
  template <class T>
  static void toNodes(const Values<T>& all, V3<T> (&f)[nodes]) {
    quadratic_tetrahedron::nodesOf(all, f);
  }
  template <class T>
  static V3<T> nodeGradient(const elastic::Gradients<T>& g, int a, int p) {
    return quadratic_tetrahedron::nodeGradient(g, a, p);
  }
};

/// The volume of a cell by points of equal weight: of a trilinear hexahedron sum_q det j_q / 512 with j = 8 J, exactly;
/// of a quadratic tetrahedron sum_q det J_q / 24. The numbers here are of the sum alone; its derivatives are brought to
/// the nodes by the transpose of what gave the j_q.
template <class Cell, class T>
struct CellVolume {
  static constexpr int nodes = Cell::nodes, points = Cell::points;
  using Points = typename Cell::template Values<T>;
  Points j;

  explicit CellVolume(const Points& values) : j(values) {}
  explicit CellVolume(const V3<T> (&x)[nodes]) : j(Cell::at(x)) {}
  M3<T> cofactorAt(int p) const { return cofactor(Cell::matrix(j, p)); }
  /// sum_q det j_q
  T value() const {
    T sum(0.);
    for (int p = 0; p < points; ++p) sum += stroma::dot(Cell::matrix(j, p).c0, cofactorAt(p).c0);
    return sum;
  }
  /// sum cof j : dj, of nodes that move by those of d.
  T change(const CellVolume& d) const {
    T sum(0.);
    for (int p = 0; p < points; ++p) sum += hyperelastic::dot(cofactorAt(p), Cell::matrix(d.j, p));
    return sum;
  }
  /// f = factor sum cof j, at the nodes.
  void gradient(T factor, V3<T> (&f)[nodes]) const {
    Points all;
    for (int p = 0; p < points; ++p) Cell::add(cofactorAt(p) * factor, p, all);
    Cell::toNodes(all, f);
  }
  /// f = factor times the change of gradient(1) for nodes that move by those of d, + along gradient(1).
  void gradientChange(const CellVolume& d, T factor, T along, V3<T> (&f)[nodes]) const {
    Points all;
    for (int p = 0; p < points; ++p) {
      const M3<T> now = Cell::matrix(j, p), moved = Cell::matrix(d.j, p);
      Cell::add(cofactorDifferential(now, moved) * factor + cofactor(now) * along, p, all);
    }
    Cell::toNodes(all, f);
  }
};
template <class T>
using HexahedronVolume = CellVolume<HexahedronPoints, T>;

}  // namespace stroma::hyperelastic
