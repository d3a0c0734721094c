// SPDX-License-Identifier: LGPL-2.1-or-later
// The tetrahedra of a mesh: their shapes at rest and now, and what models keep of them.
#pragma once
#include <fmt/format.h>

#include <Eigen/LU>

#include "components/elasticity/lame_of.h"
#include "components/elasticity/rotation_methods.h"
#include "components/elasticity/tetrahedron_models.h"
#include "framework/fem/eigen_matrix.h"
#include "framework/mesh/mesh.h"
#include "framework/scene/diagnostics.h"

namespace stroma::tetrahedron {

class TetrahedronShapes {
 public:
  /// Throws ComponentError for a cell without a volume. Both are kept by reference.
  TetrahedronShapes(const Mesh& mesh, const std::vector<Vec3>& rest, elastic::Update update)
      : mesh_(&mesh), rest_(&rest), update_(update) {
    for (std::size_t e = 0; e < mesh.tetrahedra.size(); ++e) {
      const Mat3 edges = restEdges(mesh.tetrahedra[e]);
      const double longest = edges.colwise().norm().maxCoeff();
      if (!(std::abs(edges.determinant()) > 1e-12 * longest * longest * longest))
        throw ComponentError(describe(e) + " is flat at rest", "a volume");
    }
  }
  const Mesh& mesh() const { return *mesh_; }
  const std::vector<Vec3>& positions() const { return *rest_; }
  std::string describe(std::size_t e) const {
    const auto& t = mesh_->tetrahedra[e];
    return fmt::format("tetrahedron {} (nodes {} {} {} {})", e, t[0], t[1], t[2], t[3]);
  }

  [[gnu::noinline]] Mat3 restEdges(const Tetrahedron& t) const {
    return edgesOf(t, [&](Index n) -> Vec3 { return (*rest_)[n]; });
  }
  Mat3 deformationGradient(std::size_t e, ConstRows x) const {
    const Tetrahedron& t = mesh_->tetrahedra[e];
    return edgesOf(t, [&](Index n) -> Vec3 { return x[n]; }) * restEdges(t).inverse();
  }
  /// The frame in which the rest shape is stored: first edge on x, second in the xy plane. Columns are its axes.
  [[gnu::always_inline]] Mat3 restFrame(std::size_t e) const {
    const Mat3 edges = restEdges(mesh_->tetrahedra[e]);
    return toEigen(rotation::gramSchmidt(fromEigen(edges / edges.norm())));
  }
  /// The volume [m^3]; cells that cover the body twice share it.
  double weight(const Mat3& edges) const { return std::abs(edges.determinant()) / (6 * mesh_->overlap); }
  /// Cell e with its vertices in the order of `nodes`, in the frame that the order of the cell gives: method large
  /// depends on it. Inlined into the loop that fills a storage, as restFrame() is: rounding depends on what the compiler
  /// sees together.
  [[gnu::always_inline]] void set(std::size_t e, const Tetrahedron& nodes, bool padding, const LameOf& lame, auto& rest,
                                  auto& tangent) const {
    const Mat3 axes = restFrame(e), edges = restEdges(nodes), inverse = edges.inverse();
    const M3<double> own = fromEigen((inverse * axes).transpose()), world = fromEigen(inverse.transpose());
    const double volume = padding ? 0 : weight(edges);  // a padding lane has no stiffness
    const Lame constants = lame(e);
    if constexpr (requires { rest.root; }) rest.root = std::sqrt(constants.mu * volume);
    if constexpr (requires { rest.g; }) rest.g = {own.c0, own.c1, own.c2};
    if constexpr (requires { rest.edges; }) {
      const M3<double> local = fromEigen(axes.transpose() * edges);
      rest.edges[0] = local.c0, rest.edges[1] = local.c1, rest.edges[2] = local.c2;
    }
    if constexpr (requires { rest.inverse_six_volume; }) rest.inverse_six_volume = 1 / edges.determinant();
    if constexpr (requires { rest.of_volume; })
      rest.of_volume = update_ == elastic::Update::strain_displacement_and_volume ? rest.inverse_six_volume : 0;
    setTangent(tangent, {world.c0, world.c1, world.c2}, constants, volume);
  }

 private:
  static Mat3 edgesOf(const Tetrahedron& t, auto&& position) {
    const Vec3 a = position(t[0]);
    Mat3 edges;
    edges << position(t[1]) - a, position(t[2]) - a, position(t[3]) - a;
    return edges;
  }

  const Mesh* mesh_;
  const std::vector<Vec3>* rest_;
  elastic::Update update_;
};

}  // namespace stroma::tetrahedron
