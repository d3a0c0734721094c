// SPDX-License-Identifier: LGPL-2.1-or-later
// Tetrahedra of ten nodes as a shape of point_models.h and point_cells.h: the four points of
// framework/fem/quadratic_tetrahedron.h.
#pragma once
#include "components/elasticity/point_cells.h"
#include "framework/fem/quadratic_tetrahedron.h"

namespace stroma::quadratic_tetrahedron {

struct Shape {
  static constexpr int nodes = quadratic_tetrahedron::nodes, points = quadratic_tetrahedron::points;
  static constexpr const CellKind& kind = cell_kinds::quadratic_tetrahedron;
  static constexpr std::string_view name = "quadratic tetrahedron";
  static constexpr double mean_from = 0.45;  ///< the table of errors is in docs/validation.md
  static constexpr double product = 48, green = 79, exact = 113, assembly = 1000;
  static const std::vector<QuadraticTetrahedron>& of(const Mesh& mesh) { return mesh.quadratic_tetrahedra; }
  static double volumeAt(double determinant, int) { return determinant / 24; }
  [[noreturn]] static void refuse(const std::string& cell, double low, double high, double) {
    throw ComponentError(
        fmt::format("{} is flat or folded at rest: six times its volume goes from {:.3g} to {:.3g} m^3 at its points", cell, low, high),
        "a volume, and nodes of edges near the middle between corners");
  }

  template <class T>
  using PointValues = quadratic_tetrahedron::PointValues<T>;
  template <class T>
  static PointValues<T> atPoints(const V3<T> (&x)[nodes]) {
    return quadratic_tetrahedron::atPoints(x);
  }
  template <class T>
  static void nodesOf(const PointValues<T>& forces, V3<T> (&f)[nodes]) {
    quadratic_tetrahedron::nodesOf(forces, f);
  }
  template <class T>
  static V3<T> nodeGradient(const Gradients<T>& g, int a, int p) {
    return quadratic_tetrahedron::nodeGradient(g, a, p);
  }
};

using Models = PointModels<Shape>;
template <class T>
using RestGradients = Models::RestGradients<T>;
template <class T>
using Tangent = Models::PointTangent<T>;
template <class Rotation>
using Corotational = Models::Corotational<Rotation>;

}  // namespace stroma::quadratic_tetrahedron
