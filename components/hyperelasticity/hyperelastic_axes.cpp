// SPDX-License-Identifier: LGPL-2.1-or-later
// The axes of a hyperelastic field's material, from AnisotropyDirections: of all cells, one per cell, or one per node.
// A fibre has no sense, a and -a are the same: the mean of a cell's corners is the axis m that is closest to theirs,
// the largest eigenvector of sum a (x) a. Fibres and sheets are averaged apart and made orthogonal then.
#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "components/hyperelasticity/hyperelastic_force_field.h"

namespace stroma {
namespace {

/// Refuses a vector that is no direction; `whose` is "the fibre of tetrahedron 5 ...".
Vec3 direction(const Vec3& v, const std::string& whose) {
  if (v.allFinite() && v.norm() > 0) return v.normalized();
  throw ComponentError(fmt::format("{} is {} {} {}", whose, v[0], v[1], v[2]), "a vector with a length");
}

/// Columns: fibre, sheet made orthogonal to it, normal. Directions of length 1.
Mat3 frameOf(const Vec3& fibre, const Vec3& sheet, const std::string& place) {
  const Vec3 normal = fibre.cross(sheet);
  if (!(normal.norm() > 1e-6))
    throw ComponentError(
        fmt::format("fibre and sheet of {} are parallel ({:.3g} {:.3g} {:.3g})", place, fibre[0], fibre[1], fibre[2]),
        "two directions of a plane");
  Mat3 axes;
  axes.col(0) = fibre, axes.col(2) = normal.normalized();
  axes.col(1) = axes.col(2).cross(axes.col(0));
  return axes;
}

/// Any direction across a fibre, for laws without sheets.
Vec3 across(const Vec3& fibre) {
  Index least = 0;
  fibre.cwiseAbs().minCoeff(&least);
  return Vec3::Unit(least);
}

/// The axis closest to those of `corner`; `what` are "fibres".
template <class Nodes>
Vec3 meanAxis(const std::vector<Vec3>& corner, std::size_t first, std::size_t each, const Nodes& nodes,
              const std::string& what, const std::string& place) {
  Mat3 sum = Mat3::Zero();
  for (const Index n : nodes) {
    const Vec3& a = corner[std::size_t(n) * each + first];
    sum += a * a.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(sum);
  if (!(solver.eigenvalues()[1] < 0.99 * solver.eigenvalues()[2]))
    throw ComponentError(fmt::format("the {} at the corners of {} have no mean: they cross", what, place),
                         "directions that change little over a cell, or one per cell");
  return solver.eigenvectors().col(2);
}

}  // namespace

/// How AnisotropyDirections are counted: `each` a cell or a node, or for all.
HyperelasticForceField::DirectionCount HyperelasticForceField::countDirections() {
  using Place = DirectionCount::Place;
  const std::size_t n = directions_.size(), cells = cellCount(), nodes = std::size_t(mesh_->nodes());
  const bool frames = law_.directions == 3;
  std::vector<DirectionCount> fitting;
  for (const Place place : {Place::all, Place::cell, Place::node})
    for (const std::size_t each : frames ? std::vector<std::size_t>{2, 3} : std::vector<std::size_t>{1})
      if (n == each * (place == Place::all ? 1 : place == Place::cell ? cells : nodes))
        fitting.push_back({place, each});
  if (fitting.empty()) {
    const std::string expected =
        frames ? fmt::format("2 or 3 (fibre, sheet, normal), {} or {} (for each cell), or {} or {} (for each node)",
                             2 * cells, 3 * cells, 2 * nodes, 3 * nodes)
               : fmt::format("1, {} (one per cell) or {} (one per node)", cells, nodes);
    throw ComponentError(fmt::format("AnisotropyDirections of {} has {} vectors", law_.name, n), expected,
                         frames && n == 0 ? "AnisotropyDirections=\"1 0 0  0 1 0\" for axes x, y, z" : "");
  }
  if (fitting[0].place == Place::cell && fitting.back().place == Place::node)
    warn(fmt::format("{} AnisotropyDirections fit the {} cells and the {} nodes: they are taken for those of the cells",
                     n, cells, nodes));
  return fitting[0];
}

void HyperelasticForceField::readDirections() {
  axes_ = {Mat3::Identity()};
  if (law_.directions == 0) {
    if (!directions_.empty())
      throw ComponentError(fmt::format("{} is isotropic", law_.name), "no AnisotropyDirections",
                           "Costa or TransverselyIsotropic");
    return;
  }
  using Place = DirectionCount::Place;
  const auto [place, each] = countDirections();
  const auto nameOf = [&, where = place](std::size_t i) {
    return where == Place::all ? "all cells" : where == Place::cell ? describe(i) : fmt::format("node {}", i);
  };
  std::vector<Vec3> given = directions_;
  for (std::size_t i = 0; i < given.size(); ++i)
    given[i] = direction(given[i], (i % each == 0   ? "the fibre of "
                                    : i % each == 1 ? "the sheet of "
                                                    : "the normal of ") +
                                       nameOf(i / each));
  const bool sheets = each > 1;
  if (place != Place::node) {
    axes_.clear();
    for (std::size_t i = 0; i < given.size(); i += each)
      axes_.push_back(frameOf(given[i], sheets ? given[i + 1] : across(given[i]), nameOf(i / each)));
    return;
  }
  const auto averaged = [&](std::size_t cell, const auto& nodes) {
    const Vec3 fibre = meanAxis(given, 0, each, nodes, "fibres", describe(cell));
    const Vec3 sheet = sheets ? meanAxis(given, 1, each, nodes, "sheets", describe(cell)) : across(fibre);
    return frameOf(fibre, sheet, describe(cell));
  };
  axes_.resize(cellCount());
  for (std::size_t cell = 0; cell < axes_.size(); ++cell) axes_[cell] = averaged(cell, nodesOf(cell));
}

}  // namespace stroma
