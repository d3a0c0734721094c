// SPDX-License-Identifier: LGPL-2.1-or-later
// The hexahedra of a mesh: their shapes at rest and now, and what models keep of them.
#pragma once
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/LU>

#include "components/elasticity/elastic_variant.h"
#include "components/elasticity/hexahedron_boxes.h"
#include "components/elasticity/hexahedron_green.h"
#include "components/elasticity/hexahedron_points.h"
#include "components/elasticity/rotation_methods.h"
#include "framework/fem/eigen_matrix.h"
#include "framework/fem/isotropic.h"
#include "framework/mesh/mesh.h"
#include "framework/scene/diagnostics.h"

namespace stroma::hexahedron {

/// Shapes that differ from a box by less than this part of their edges are boxes.
inline constexpr double box_tolerance = 1e-12;

struct RestShape {
  M3<double> frame;          ///< axes of the mean edges in world axes
  Modes<double> modes;       ///< in the frame
  double low = 0, high = 0;  ///< smallest and largest det J_0 at the Gauss points
  bool box = false;
};

/// 512 det J of Gauss point p from J made of modes.
inline double determinantAt(const PointValues<double>& j, int p) {
  const Columns<double> c(j, p);
  return stroma::dot(c.d[0], cross(c.d[1], c.d[2]));
}

/// As PointRest::inverse_edges.
inline void setUpper(const Mat3& matrix, double (&to)[6]) {
  const int row[6] = {0, 0, 1, 0, 1, 2}, column[6] = {0, 1, 1, 2, 2, 2};
  for (int i = 0; i < 6; ++i) to[i] = matrix(row[i], column[i]);
}

class HexahedronShapes {
 public:
  /// Looks at the rest shapes; throws ComponentError for a cell without a volume. All are kept by reference.
  HexahedronShapes(const Mesh& mesh, const std::vector<Vec3>& rest, const ElasticVariant& variant)
      : mesh_(&mesh), rest_(&rest), variant_(variant) {
    for (std::size_t e = 0; e < mesh.hexahedra.size(); ++e) {
      const RestShape shape = atRest(e);
      const double size = std::sqrt(squaredNorm(meanEdges(shape.modes))) / 8;
      const double tiny = 1e-12 * size * size * size;
      if (!(shape.low > tiny || shape.high < -tiny))
        throw ComponentError(
            fmt::format("{} is flat or folded at rest: its volume ratio goes from {:.3g} to {:.3g}", describe(e),
                        shape.low / (size * size * size), shape.high / (size * size * size)),
            "a volume whose corners are all on the right side");
      (shape.box ? boxes_ : others_).push_back(Index(e));
    }
  }
  const Mesh& mesh() const { return *mesh_; }
  const std::vector<Vec3>& positions() const { return *rest_; }
  const ElasticVariant& variant() const { return variant_; }
  /// Cells that are boxes, and all others, in their order.
  const std::vector<Index>& boxes() const { return boxes_; }
  const std::vector<Index>& others() const { return others_; }
  std::string describe(std::size_t e) const {
    return fmt::format("hexahedron {} (nodes {})", e, fmt::join(mesh_->hexahedra[e], " "));
  }

  Modes<double> now(std::size_t e, ConstRows x) const {
    V3<double> corner[8];
    for (int a = 0; a < 8; ++a) corner[a] = vectorOf(x[mesh_->hexahedra[e][a]]);
    return modesOf(corner);
  }
  RestShape atRest(std::size_t e) const {
    V3<double> corner[8];
    for (int a = 0; a < 8; ++a) corner[a] = vectorOf((*rest_)[mesh_->hexahedra[e][a]]);
    const Modes<double> world = modesOf(corner);
    const double size = std::sqrt(squaredNorm(meanEdges(world)));
    RestShape shape;
    shape.frame = rotation::gramSchmidt(meanEdges(world) * (1 / size));
    shape.modes = rotatedBack(shape.frame, world);
    Modes<double> rest_of_box = shape.modes;
    rest_of_box.xi.x = rest_of_box.eta.y = rest_of_box.zeta.z = 0;
    shape.box = dot(rest_of_box, rest_of_box) < box_tolerance * box_tolerance * size * size;
    // the lower triangle of the mean edges is zero up to rounding: make it zero
    shape.modes.xi.y = shape.modes.xi.z = shape.modes.eta.z = 0;
    const PointValues<double> j = atPoints(shape.modes);
    shape.low = std::numeric_limits<double>::infinity(), shape.high = -shape.low;
    for (int p = 0; p < 8; ++p) {
      const double value = determinantAt(j, p) / 512;
      shape.low = std::min(shape.low, value), shape.high = std::max(shape.high, value);
    }
    return shape;
  }

  void set(const RestShape& shape, const Lame& constants, BoxRest<double>& rest, Boxes::Tangent<double>& tangent) const {
    setBox(shape, constants, rest, tangent);
  }
  void set(const RestShape& shape, const Lame& constants, BoxRest<double>& rest, IncompatibleBoxes::Tangent<double>& tangent) const {
    setBox(shape, constants, rest, tangent);
    const double share = std::abs(shape.low) / 8, lambda = constants.lambda, mu = constants.mu;
    tangent.stiffness.plane = mu > 0 ? share * 2 * lambda * mu / (lambda + 2 * mu) : 0;
  }
  void set(const RestShape& shape, const Lame& constants, BoxRest<double>&, BoxShape::Tangent<double>& tangent) const {
    const double edges[3] = {shape.modes.xi.x, shape.modes.eta.y, shape.modes.zeta.z}, weight = std::abs(shape.low);
    for (int i = 0; i < 3; ++i) tangent.gradient[i] = std::sqrt(weight) / edges[i];
    tangent.inverse_weight = 1 / weight;
    setGreen(shape, constants, tangent);
  }
  /// In the frame of the mean edges, but world axes for method small, which turns nothing.
  void set(const RestShape& shape, const Lame& constants, PointRest<double>& rest, auto& tangent) const {
    if constexpr (requires { tangent.law; })
      setLaw(shape, constants, tangent.law);
    else
      setGreen(shape, constants, tangent);
    const bool turned = variant_.method != ElasticMethod::small;
    rest.modes = turned ? shape.modes : rotated(shape.frame, shape.modes);
    setUpper(toEigen(meanEdges(rest.modes)).inverse(), rest.inverse_edges);
    const PointValues<double> j = atPoints(rest.modes);
    for (int p = 0; p < 8; ++p) {
      const M3<double> columns = Columns<double>(j, p).matrix(), n = cofactor(columns);
      rest.inverse_determinant[p] = variant_.update == Update::strain_displacement ? 0 : 1 / determinantAt(j, p);
      const double weight = std::abs(determinantAt(j, p)) / 512;
      rest.scale[p] = std::copysign(1 / (512 * std::sqrt(weight)), determinantAt(j, p));
      rest.g[p] = {n.c0 * rest.scale[p], n.c1 * rest.scale[p], n.c2 * rest.scale[p]};
      if constexpr (requires { tangent.g; })
        tangent.g[p] = turned ? elastic::rotated(shape.frame, rest.g[p]) : rest.g[p];
    }
  }

 private:
  void setBox(const RestShape& shape, const Lame& constants, BoxRest<double>& rest, auto& tangent) const {
    const double edges[3] = {shape.modes.xi.x, shape.modes.eta.y, shape.modes.zeta.z};
    for (int i = 0; i < 3; ++i) rest.edges[i] = edges[i], tangent.stiffness.inverse[i] = 8 / edges[i];
    tangent.axes = shape.frame;
    const double share = std::abs(shape.low) / 8;
    auto& s = tangent.stiffness;
    s.lambda = constants.lambda * share, s.mu = constants.mu * share;
    s.varying = variant_.mean_dilatation ? -2. / 3 * s.mu : s.lambda;
  }
  static void setLaw(const RestShape&, const Lame& constants, LocalDilatation<double>& law) {
    law = {constants.lambda, constants.mu};
  }
  static void setLaw(const RestShape& shape, const Lame& constants, MeanDilatation<double>& law) {
    law.lambda = -2. / 3 * constants.mu, law.mu = constants.mu;
    law.bulk = constants.bulk() / volume(shape);
    const PointValues<double> j = atPoints(shape.modes);
    for (int p = 0; p < 8; ++p) law.root[p] = std::sqrt(std::abs(determinantAt(j, p)) / 512);
  }
  void setGreen(const RestShape& shape, const Lame& constants, auto& tangent) const {
    const bool mean = variant_.mean_dilatation;
    tangent.lambda = mean ? -2. / 3 * constants.mu : constants.lambda, tangent.mu = constants.mu;
    tangent.bulk = mean ? constants.bulk() / volume(shape) : 0;
  }

  static double volume(const RestShape& shape) {
    const PointValues<double> j = atPoints(shape.modes);
    double sum = 0;
    for (int p = 0; p < 8; ++p) sum += std::abs(determinantAt(j, p)) / 512;
    return sum;
  }

  const Mesh* mesh_;
  const std::vector<Vec3>* rest_;
  ElasticVariant variant_;
  std::vector<Index> boxes_, others_;
};

}  // namespace stroma::hexahedron
