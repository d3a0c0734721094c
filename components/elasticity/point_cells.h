// SPDX-License-Identifier: LGPL-2.1-or-later
// The cells of one shape of a mesh (point_models.h): how they are at rest and now, and their kernels. Beside what models need,
// a shape S has
//   kind, of(mesh)                  its kind of cell, and their list
//   name                            "prism", for messages
//   volumeAt(determinant, p)        the volume of point p
//   turns_as_one                    where it is there: no points turn by themselves
//   mean_from                       the Poisson's ratio from which the volume change is a mean by default
//   product, green, exact, assembly nanoseconds, as ElasticElements::Nanoseconds
#pragma once
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/LU>

#include "components/elasticity/elastic_kernels.h"
#include "components/elasticity/point_elements.h"
#include "components/elasticity/point_models.h"
#include "framework/fem/eigen_matrix.h"
#include "framework/mesh/mesh.h"
#include "framework/scene/diagnostics.h"

namespace stroma {

/// Positions and list are kept by reference.
template <class S>
class PointShapes {
 public:
  using Values = typename S::template PointValues<double>;
  /// Throws ComponentError for a cell that is flat or folded at a point.
  PointShapes(const Mesh& mesh, const std::vector<Vec3>& rest) : mesh_(&mesh), rest_(&rest) {
    for (std::size_t e = 0; e < S::of(mesh).size(); ++e) {
      const Values j = atRest(e);
      const double size = std::sqrt(squaredNorm(j.matrix(0))), tiny = 1e-12 * size * size * size;
      double low = std::numeric_limits<double>::infinity(), high = -low;
      for (int p = 0; p < S::points; ++p) {
        const double value = determinant(j, p);
        low = std::min(low, value), high = std::max(high, value);
      }
      if (!(low > tiny || high < -tiny)) S::refuse(describe(e), low, high, size);
    }
  }
  const Mesh& mesh() const { return *mesh_; }
  const std::vector<Vec3>& positions() const { return *rest_; }
  std::string describe(std::size_t e) const {
    return fmt::format("{} {} (nodes {})", S::name, e, fmt::join(S::of(*mesh_)[e], " "));
  }
  Values atRest(std::size_t e) const {
    return of(e, [&](Index n) -> Vec3 { return (*rest_)[n]; });
  }
  Values now(std::size_t e, ConstRows x) const {
    return of(e, [&](Index n) -> Vec3 { return x[n]; });
  }
  /// The volume of point p [m^3].
  static double weight(const Values& rest, int p) { return S::volumeAt(std::abs(determinant(rest, p)), p); }
  static double determinant(const Values& j, int p) { return dot(j.d[p][0], cross(j.d[p][1], j.d[p][2])); }
  /// X_a - C of the nodes, the matrix of which is polarOf = nodes.
  std::array<Vec3, S::nodes> places(std::size_t e) const {
    std::array<Vec3, S::nodes> places;
    Vec3 centre = Vec3::Zero();
    for (std::size_t a = 0; a < S::nodes; ++a) centre += places[a] = (*rest_)[S::of(*mesh_)[e][a]];
    for (Vec3& place : places) place -= centre / S::nodes;
    return places;
  }

  /// `share`: of its stiffness that the cell counts, zero for padding.
  void set(std::size_t e, const ElasticVariant& variant, Lame lame, double share, auto& rest, auto& t) const {
    const Values j = atRest(e);
    const bool mean = variant.mean_dilatation;
    double volume = 0;
    for (int p = 0; p < S::points; ++p) {
      const M3<double> g = fromEigen(toEigen(j.matrix(p)).inverse().transpose());
      rest.g[p] = {g.c0, g.c1, g.c2};
      t.root[p] = std::sqrt(weight(j, p));
      t.g[p] = elastic::scaledBy(rest.g[p], t.root[p]);
      if constexpr (requires { t.rotation; }) t.rotation[p] = identity<double>();
      volume += weight(j, p);
    }
    if constexpr (requires { rest.place; }) {
      const auto from = places(e);
      for (std::size_t a = 0; a < S::nodes; ++a) rest.place[a] = vectorOf(from[a]);
    }
    t.lambda = share * (mean ? -2. / 3 * lame.mu : lame.lambda), t.mu = share * lame.mu;
    t.bulk = mean ? share * lame.bulk() / volume : 0;
  }

 private:
  Values of(std::size_t e, auto&& position) const {
    V3<double> x[S::nodes];
    for (std::size_t a = 0; a < S::nodes; ++a) x[a] = vectorOf(position(S::of(*mesh_)[e][a]));
    return S::atPoints(x);
  }
  const Mesh* mesh_;
  const std::vector<Vec3>* rest_;
};

/// What kernels are made of.
template <class S>
struct PointElementsOf {
  const PointShapes<S>& shapes;
  const ElasticVariant& variant;
  Index first_row;  ///< row of node 0
  const LameOf& lame;
};

/// method = large, polar, svd (Rotation), compiled apart: point_rotated.h.
template <class S, class Rotation>
std::unique_ptr<ElementKernels> rotatedKernels(const PointElementsOf<S>& elements);

template <class Model, class S>
std::unique_ptr<ElementKernels> kernelsOf(const PointElementsOf<S>& elements) {
  using Storage = StorageOf<Model>;
  const PointShapes<S>& shapes = elements.shapes;
  const auto fill = [&shapes, variant = elements.variant, lame = elements.lame](Storage& stored) {
    stored.fill([&](std::size_t e, bool padding, auto& rest, auto& tangent) {
      shapes.set(e, variant, lame(e), padding ? 0 : 1 / shapes.mesh().overlap, rest, tangent);
    });
  };
  Storage storage;
  storage.arrange(S::of(shapes.mesh()), shapes.positions(), elements.first_row);
  fill(storage);
  return std::make_unique<ModelKernels<Model>>(std::move(storage), fill);
}

template <class S>
class PointCells final : public PointElements<PointCells<S>> {
  using PointElements<PointCells<S>>::variant_;

 public:
  using Nanoseconds = ElasticElements::Nanoseconds;
  Index count(const Mesh& mesh) const override { return Index(S::of(mesh).size()); }
  const CellKind& kind() const override { return S::kind; }
  double meanDilatationFrom() const override { return S::mean_from; }
  bool rotationHasPotential() const override { return true; }
  bool updatesStrainDisplacement() const override { return false; }
  bool usePolarOf(PolarOf what) override {
    if constexpr (requires { S::polarKernels; })
      of_nodes_ = what == PolarOf::nodes;
    return of_nodes_;
  }
  std::unique_ptr<ElementKernels> make(Index first_row, const LameOf& lame) const override {
    return withOwnMatrix(variant_, makeMethod({*shapes_, variant_, first_row, lame}));
  }
  std::string describe(std::size_t e) const override { return shapes_->describe(e); }
  Nanoseconds cost() const override {
    const double lanes = 8. / pack_lanes;
    const bool green = variant_.method == ElasticMethod::green;
    return {(green ? S::green : variant_.exact_tangent ? S::exact : S::product) * lanes, S::assembly};
  }

  // ---- for PointElements ----
  void bindShapes(const Mesh& mesh, const std::vector<Vec3>& rest) {
    if (turns_as_one && variant_.method != ElasticMethod::small && !of_nodes_)
      throw ComponentError("the points of a reduced integration do not turn one by one", "method=\"small\" or polarOf=\"nodes\"");
    shapes_ = std::make_unique<PointShapes<S>>(mesh, rest);
  }
  template <class Use>
  void forEachJacobian(std::size_t e, ConstRows x, Use&& use) const {
    const auto now = shapes_->now(e, x), rest = shapes_->atRest(e);
    for (int p = 0; p < S::points; ++p) use(shapes_->determinant(now, p) / shapes_->determinant(rest, p));
  }
  template <class Use>
  void forEachStrain(std::size_t e, ConstRows x, Use&& use) const {
    const auto now = shapes_->now(e, x), rest = shapes_->atRest(e);
    for (int p = 0; p < S::points; ++p) {
      const Mat3 f = toEigen(now.matrix(p)) * toEigen(rest.matrix(p)).inverse();
      const M3<double> r = rotationOf(fromEigen(of_nodes_ ? ofNodes(e, x) : f));
      use(strainOf(f, r), variant_.method == ElasticMethod::green ? f : toEigen(r), shapes_->weight(rest, p));
    }
  }

 private:
  static constexpr bool turns_as_one = requires { S::turns_as_one; };
  Mat3 ofNodes(std::size_t e, ConstRows x) const {
    Mat3 sum = Mat3::Zero();
    const auto places = shapes_->places(e);
    for (std::size_t a = 0; a < S::nodes; ++a) sum += x[S::of(shapes_->mesh())[e][a]] * places[a].transpose();
    return sum;
  }
  M3<double> rotationOf(const M3<double>& f) const {
    switch (variant_.method) {
      case ElasticMethod::large:
        return rotation::Qr::of(f);
      case ElasticMethod::polar:
        return rotation::Polar::of(f);
      case ElasticMethod::svd:
        return rotation::Svd::of(f);
      default:
        return fromEigen(Mat3::Identity());
    }
  }
  Mat3 strainOf(const Mat3& f, const M3<double>& r) const {
    if (variant_.method == ElasticMethod::small) return (f + f.transpose()) / 2 - Mat3::Identity();
    if (variant_.method == ElasticMethod::green) return (f.transpose() * f - Mat3::Identity()) / 2;
    return toEigen(rotation::stretch(r, fromEigen(f))) - Mat3::Identity();
  }
  std::unique_ptr<ElementKernels> makeMethod(const PointElementsOf<S>& elements) const {
    using Models = elastic::PointModels<S>;
    if (variant_.method == ElasticMethod::small) return kernelsOf<typename Models::Linear>(elements);
    if constexpr (turns_as_one) {
      return S::polarKernels(elements);
    } else {
      if (variant_.method == ElasticMethod::green)
        return kernelsOf<elastic::GreenModel<typename Models::GreenShape, true>>(elements);
      if constexpr (requires { S::polarKernels; })
        if (of_nodes_) return S::polarKernels(elements);
      return makeRotated(variant_, [&]<class Rotation>() { return rotatedKernels<S, Rotation>(elements); });
    }
  }

  std::unique_ptr<PointShapes<S>> shapes_;
  bool of_nodes_ = false;
};

}  // namespace stroma
