// SPDX-License-Identifier: LGPL-2.1-or-later
// Trilinear hexahedra of a hyperelastic law with 2x2x2 Gauss points: at each F = sum J_i (x) g_i over the derivatives
// J_i along the axes (hexahedron.h), forces -w P g_i on them, w the point's volume. Gradients are those of 8 u_m
// against 8 X_m, in the material's axes.
#pragma once
#include "components/hyperelasticity/hyperelastic_tetrahedron.h"
#include "framework/fem/hexahedron.h"

namespace stroma::hyperelastic {

constexpr int gauss_points = 8;

/// What elements of eight nodes share.
struct EightNodes {
  static constexpr int nodes = 8;
  static constexpr bool reads_position = true;
  template <class T>
  using Points = hexahedron::PointValues<T>;
};

template <class Form>
struct Hexahedron : EightNodes {
  template <class T>
  struct Rest {
    elastic::Gradients<T> g[gauss_points];  ///< [1/m]
    T weight[gauss_points];                 ///< minus the point's volume [m^3]
    typename Form::template Parameters<T> parameters;
  };
  template <class T>
  struct Tangent {
    typename Form::template Tangent<T> at[gauss_points];
  };

  template <class T>
  static M3<T> deformation(const Rest<T>& rest, const Points<T>& j, int p) {
    return elastic::outerSum(hexahedron::Columns<T>(j, p).d, rest.g[p]);
  }
  template <class T>
  static void add(const Rest<T>& rest, const M3<T>& stress, int p, Points<T>& forces) {
    const elastic::Gradients<T>& g = rest.g[p];
    hexahedron::addColumns(stress * g.g1, stress * g.g2, stress * g.g3, p, forces);
  }

  template <class T>
  static void force(const Rest<T>& rest, Tangent<T>& t, const V3<T> (&x)[8], V3<T> (&f)[8]) {
    const Points<T> j = hexahedron::atPoints(hexahedron::modesOf(x));
    Points<T> forces;
    for (int p = 0; p < gauss_points; ++p)
      add(rest, Form::stress(rest.parameters, rest.weight[p], deformation(rest, j, p), t.at[p]), p, forces);
    hexahedron::nodesOf(hexahedron::fromPoints(forces), f);
  }
  template <class T>
  static T energy(const Rest<T>& rest, const Tangent<T>&, const V3<T> (&x)[8]) {
    const Points<T> j = hexahedron::atPoints(hexahedron::modesOf(x));
    T sum(0.);
    for (int p = 0; p < gauss_points; ++p)
      sum -= rest.weight[p] * Form::energy(rest.parameters, deformation(rest, j, p));
    return sum;
  }
  template <class T>
  static void product(const Rest<T>& rest, const Tangent<T>& t, T factor, const V3<T> (&x)[8], const V3<T> (&dx)[8],
                      V3<T> (&df)[8]) {
    const Points<T> j = hexahedron::atPoints(hexahedron::modesOf(x)),
                    dj = hexahedron::atPoints(hexahedron::modesOf(dx));
    Points<T> forces;
    for (int p = 0; p < gauss_points; ++p) {
      const M3<T> f = deformation(rest, j, p), change = deformation(rest, dj, p) * factor;
      add(rest, Form::differential(rest.parameters, rest.weight[p], t.at[p], f, change), p, forces);
    }
    hexahedron::nodesOf(hexahedron::fromPoints(forces), df);
  }
};

/// The derivatives along the axes at the Gauss points, at rest.
inline hexahedron::PointValues<double> restPoints(const Cells& cells, std::size_t cell) {
  const stroma::Hexahedron& order = cells.mesh->hexahedra[cell];
  V3<double> x[8];
  for (std::size_t a = 0; a < 8; ++a) x[a] = vectorOf((*cells.rest)[order[a]]);
  return hexahedron::atPoints(hexahedron::modesOf(x));
}

template <class Form>
StorageOf<Hexahedron<Form>> hexahedronStorage(const Cells& cells) {
  StorageOf<Hexahedron<Form>> storage;
  storage.build(cells.mesh->hexahedra, *cells.rest, cells.first_row,
                [&](std::size_t cell, bool padding, auto& rest, auto&) {
                  const auto j = restPoints(cells, cell);
                  const Mat3 axes = Form::Law::Set::anisotropic ? cells.axes(cell) : Mat3(Mat3::Identity());
                  for (int p = 0; p < gauss_points; ++p) {
                    const Mat3 edges = toEigen(hexahedron::Columns<double>(j, p).matrix());
                    const M3<double> g = fromEigen(axes.transpose() * edges.inverse().transpose());
                    rest.g[p] = {g.c0, g.c1, g.c2};
                    rest.weight[p] = padding ? 0 : -std::abs(edges.determinant()) / (512 * cells.mesh->overlap);
                  }
                  rest.parameters = parametersOf<typename Form::Law>(cells.parameters(cell));
                });
  return storage;
}

}  // namespace stroma::hyperelastic
