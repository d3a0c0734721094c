// SPDX-License-Identifier: LGPL-2.1-or-later
// The quadratic tetrahedra of a mesh: their shapes at rest and now, and kernels by groups that are compiled apart.
#pragma once
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/LU>

#include "components/elasticity/elastic_kernels.h"
#include "components/elasticity/quadratic_tetrahedron_models.h"
#include "framework/fem/eigen_matrix.h"
#include "framework/fem/isotropic.h"
#include "framework/mesh/mesh.h"
#include "framework/scene/diagnostics.h"

namespace stroma::quadratic_tetrahedron {

class Shapes {
 public:
  /// Throws ComponentError for a cell that is flat or folded at a point. Both are kept by reference.
  Shapes(const Mesh& mesh, const std::vector<Vec3>& rest) : mesh_(&mesh), rest_(&rest) {
    for (std::size_t e = 0; e < mesh.quadratic_tetrahedra.size(); ++e) {
      const PointValues<double> j = atRest(e);
      const double size = std::sqrt(squaredNorm(j.matrix(0))), tiny = 1e-12 * size * size * size;
      double low = std::numeric_limits<double>::infinity(), high = -low;
      for (int p = 0; p < points; ++p) {
        const double value = determinant(j, p);
        low = std::min(low, value), high = std::max(high, value);
      }
      if (!(low > tiny || high < -tiny))
        throw ComponentError(
            fmt::format(
                "{} is flat or folded at rest: six times its volume goes from {:.3g} to {:.3g} m^3 at its points",
                describe(e), low, high),
            "a volume, and nodes of edges near the middle between corners");
    }
  }
  const Mesh& mesh() const { return *mesh_; }
  const std::vector<Vec3>& positions() const { return *rest_; }
  std::string describe(std::size_t e) const {
    return fmt::format("quadratic tetrahedron {} (nodes {})", e, fmt::join(mesh_->quadratic_tetrahedra[e], " "));
  }
  PointValues<double> atRest(std::size_t e) const {
    return of(e, [&](Index n) -> Vec3 { return (*rest_)[n]; });
  }
  PointValues<double> now(std::size_t e, ConstRows x) const {
    return of(e, [&](Index n) -> Vec3 { return x[n]; });
  }
  /// The volume of point p [m^3].
  static double weight(const PointValues<double>& rest, int p) { return std::abs(determinant(rest, p)) / 24; }
  static double determinant(const PointValues<double>& j, int p) {
    return stroma::dot(j.d[p][0], cross(j.d[p][1], j.d[p][2]));
  }

  /// `share`: of its stiffness that the cell counts, zero for padding.
  void set(std::size_t e, Lame lame, bool mean, double share, RestGradients<double>& rest, auto& t) const {
    const PointValues<double> j = atRest(e);
    double volume = 0;
    for (int p = 0; p < points; ++p) {
      const M3<double> g = fromEigen(toEigen(j.matrix(p)).inverse().transpose());
      rest.g[p] = {g.c0, g.c1, g.c2};
      t.root[p] = std::sqrt(weight(j, p));
      t.g[p] = scaledBy(rest.g[p], t.root[p]);
      if constexpr (requires { t.rotation; }) t.rotation[p] = identity<double>();
      volume += weight(j, p);
    }
    t.lambda = share * (mean ? -2. / 3 * lame.mu : lame.lambda), t.mu = share * lame.mu;
    t.bulk = mean ? share * lame.bulk() / volume : 0;
  }

 private:
  PointValues<double> of(std::size_t e, auto&& position) const {
    V3<double> x[nodes];
    for (std::size_t a = 0; a < nodes; ++a) x[a] = vectorOf(position(mesh_->quadratic_tetrahedra[e][a]));
    return atPoints(x);
  }
  const Mesh* mesh_;
  const std::vector<Vec3>* rest_;
};

/// What kernels are made of.
struct Elements {
  const Shapes& shapes;
  const ElasticVariant& variant;
  Index first_row;  ///< row of node 0
  const std::function<Lame(std::size_t)>& lame;
};

/// method = large, polar, svd (Rotation): quadratic_tetrahedron_rotated.cpp.
template <class Rotation>
std::unique_ptr<ElementKernels> rotatedKernels(const Elements& elements);

template <class Model>
std::unique_ptr<ElementKernels> kernelsOf(const Elements& elements) {
  const Mesh& mesh = elements.shapes.mesh();
  StorageOf<Model> storage;
  storage.build(mesh.quadratic_tetrahedra, elements.shapes.positions(), elements.first_row,
                [&](std::size_t e, bool padding, auto& rest, auto& tangent) {
                  elements.shapes.set(e, elements.lame(e), elements.variant.mean_dilatation,
                                      padding ? 0 : 1 / mesh.overlap, rest, tangent);
                });
  return std::make_unique<ModelKernels<Model>>(std::move(storage));
}

}  // namespace stroma::quadratic_tetrahedron
