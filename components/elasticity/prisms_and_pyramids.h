// SPDX-License-Identifier: LGPL-2.1-or-later
// Prisms and pyramids as shapes of point_models.h and point_cells.h: any kind of cell of the table with any of its rules.
// Prisms have six points, three of the triangle at two heights: with one of the triangle a twist has no stiffness. Pyramids have
// four: the gradients are the same all along a ray from the top, so that one point a ray is exact.
#pragma once
#include "components/elasticity/elastic_elements.h"
#include "components/elasticity/point_cells.h"

namespace stroma {

/// What CellKind has, as constants: `rule` is one of cell_tables.
template <const CellKind& of_kind, const auto& rule>
struct TabledShape {
  static constexpr const CellKind& kind = of_kind;
  static constexpr int nodes = of_kind.nodes, points = int(rule.size());
  static constexpr std::string_view name = of_kind.singular;
  static constexpr double mean_from = 0.4;

  /// dN_a/dxi, [point][node].
  static constexpr auto slopes = [] {
    std::array<std::array<LocalPoint, std::size_t(nodes)>, std::size_t(points)> table{};
    for (std::size_t p = 0; p < table.size(); ++p) of_kind.gradients(rule[p].xi, table[p].data());
    return table;
  }();
  static double volumeAt(double determinant, int p) { return determinant * rule[std::size_t(p)].weight; }
  [[noreturn]] static void refuse(const std::string& cell, double low, double high, double size) {
    throw ComponentError(fmt::format("{} is flat or folded at rest: its volume ratio goes from {:.3g} to {:.3g}", cell,
                                     low / (size * size * size), high / (size * size * size)),
                         "a volume whose corners are all on the right side");
  }

  template <class T>
  struct PointValues {
    V3<T> d[points][3];
    M3<T> matrix(int p) const { return {d[p][0], d[p][1], d[p][2]}; }
  };
  template <class T>
  static PointValues<T> atPoints(const V3<T> (&x)[nodes]) {
    PointValues<T> out;
    forEachSlope([&](int p, int a, int i, double slope) { out.d[p][i] = fma(T(slope), x[a], out.d[p][i]); });
    return out;
  }
  template <class T>
  static void nodesOf(const PointValues<T>& forces, V3<T> (&f)[nodes]) {
    for (V3<T>& force : f) force = {T(0.), T(0.), T(0.)};
    forEachSlope([&](int p, int a, int i, double slope) { f[a] = fma(T(slope), forces.d[p][i], f[a]); });
  }
  template <class T>
  static V3<T> nodeGradient(const elastic::Gradients<T>& g, int a, int p) {
    const LocalPoint& c = slopes[std::size_t(p)][std::size_t(a)];
    return fma(T(c[0]), g.g1, fma(T(c[1]), g.g2, g.g3 * T(c[2])));
  }

 private:
  template <class Use>
  static void forEachSlope(Use&& use) {
    for (int p = 0; p < points; ++p)
      for (int a = 0; a < nodes; ++a)
        for (int i = 0; i < 3; ++i)
          if (const double slope = slopes[std::size_t(p)][std::size_t(a)][std::size_t(i)]; slope != 0) use(p, a, i, slope);
  }
};

struct PrismShape : TabledShape<cell_kinds::prism, cell_tables::prism_6> {
  static constexpr double product = 28, green = 50, exact = 110, assembly = 500;
  static const std::vector<Prism>& of(const Mesh& mesh) { return mesh.prisms; }
  static std::unique_ptr<ElementKernels> polarKernels(const PointElementsOf<PrismShape>& elements);
};
/// SOFA's two points, for what it knows: small strains and one rotation for all points.
struct ReducedPrismShape : TabledShape<cell_kinds::prism, cell_tables::prism_2> {
  static constexpr bool turns_as_one = true;
  static constexpr double product = 12, green = 20, exact = 40, assembly = 250;
  static const std::vector<Prism>& of(const Mesh& mesh) { return mesh.prisms; }
  static std::unique_ptr<ElementKernels> polarKernels(const PointElementsOf<ReducedPrismShape>& elements);
};
struct PyramidShape : TabledShape<cell_kinds::pyramid, cell_tables::pyramid_4> {
  static constexpr double product = 16, green = 30, exact = 70, assembly = 350;
  static const std::vector<Pyramid>& of(const Mesh& mesh) { return mesh.pyramids; }
  static std::unique_ptr<ElementKernels> polarKernels(const PointElementsOf<PyramidShape>& elements);
};

/// The polar factor as it is, a reflection where the cell is inside out.
struct Factor {
  template <class T>
  static M3<T> of(const M3<T>& sum) {
    return rotation::orthogonalFactor(sum);
  }
};

/// polarOf = nodes, for the polarKernels of a shape.
template <class S>
std::unique_ptr<ElementKernels> kernelsOfOneRotation(const PointElementsOf<S>& elements) {
  using Models = elastic::PointModels<S>;
  if (elements.variant.method == ElasticMethod::svd) return kernelsOf<typename Models::template OneRotation<rotation::Svd>>(elements);
  return kernelsOf<typename Models::template OneRotation<Factor>>(elements);
}

}  // namespace stroma
