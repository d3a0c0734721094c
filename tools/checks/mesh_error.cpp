// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/checks/mesh_error.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <span>

#include "framework/mechanics/open_choices.h"
#include "framework/mechanics/state_positions.h"
#include "framework/mechanics/state_topology.h"
#include "framework/mesh/cell_kind.h"
#include "tools/checks/cells_across.h"
#include "tools/units/unit_system.h"

namespace stroma {
namespace {

/// The deviator xx yy zz, then xy yz zx times the root of 2: |.|^2 is that of the tensor. Then the trace times the root of
/// K/(2 mu), so that mu |.|^2 is the energy.
using Strain = Eigen::Matrix<double, 7, 1>;
using Fit = Eigen::Matrix<double, 7, 4>;  ///< of 1, x, y, z

/// Of (F^T F - 1) / 2.
Strain strainOf(const Mat3& f, double bulk) {
  const Mat3 c = f.transpose() * f;
  const double third = c.trace() / 3, root = std::sqrt(0.5);
  Strain e;
  e << (c(0, 0) - third) / 2, (c(1, 1) - third) / 2, (c(2, 2) - third) / 2, root * c(0, 1), root * c(1, 2),
      root * c(2, 0), std::sqrt(bulk) * (c.trace() - 3) / 2;
  return e;
}

const CellKind& kindOf(const Tetrahedron&) { return cell_kinds::tetrahedron; }
const CellKind& kindOf(const Hexahedron&) { return cell_kinds::hexahedron; }
const CellKind& kindOf(const Triangle&) { return cell_kinds::triangle; }

/// The third of a surface's axes, across which it keeps its thickness.
void addNormal(Mat3& tangents) { tangents.col(2) = tangents.col(0).cross(tangents.col(1)).normalized(); }

/// F at xi, and det dX/dxi.
template <class Cell>
std::pair<Mat3, double> deformationAt(const Cell& cell, const LocalPoint& xi, const std::vector<Vec3>& rest,
                                      const std::vector<Vec3>& now) {
  std::array<LocalPoint, std::tuple_size_v<Cell>> slopes{};
  kindOf(cell).gradients(xi, slopes.data());
  Mat3 before = Mat3::Zero(), after = Mat3::Zero();
  for (std::size_t a = 0; a < cell.size(); ++a) {
    const Vec3 slope(slopes[a][0], slopes[a][1], slopes[a][2]);
    before += rest[std::size_t(cell[a])] * slope.transpose();
    after += now[std::size_t(cell[a])] * slope.transpose();
  }
  if constexpr (std::tuple_size_v<Cell> == 3) addNormal(before), addNormal(after);
  return {after * before.inverse(), std::abs(before.determinant())};
}

/// Cells of one modulus: their strains at centres, and the continuous strain made of them. Nodes are numbered anew.
template <class Cell>
class Recovery {
 public:
  Recovery(std::vector<Cell> cells, std::vector<double> modulus, double bulk, const std::vector<Vec3>& rest,
           const std::vector<Vec3>& now)
      : cells_(std::move(cells)), modulus_(std::move(modulus)), bulk_(bulk) {
    takeNodes(rest, now);
    const LocalPoint middle = is_flat                          ? LocalPoint{1. / 3, 1. / 3, 0}
                              : std::tuple_size_v<Cell> == 4 ? LocalPoint{0.25, 0.25, 0.25}
                                                             : LocalPoint{0, 0, 0};
    centre_.reserve(cells_.size()), strain_.reserve(cells_.size()), size_.reserve(cells_.size());
    for (const Cell& cell : cells_) {
      Vec3 centre = Vec3::Zero();
      for (const Index n : cell) centre += rest_[std::size_t(n)] / double(cell.size());
      centre_.push_back(centre);
      const auto [f, size] = deformationAt(cell, middle, rest_, now_);
      strain_.push_back(strainOf(f, bulk_)), size_.push_back(size);
    }
    fitAll();
  }

  StrainError error() const {
    StrainError sum;
    for (std::size_t c = 0; c < cells_.size(); ++c)
      for (const LocalPoint& xi : points()) addAt(c, xi, sum);
    return sum;
  }

 private:
  static constexpr bool is_flat = std::tuple_size_v<Cell> == 3;
  static constexpr bool has_one_strain = std::tuple_size_v<Cell> != 8;

  /// Exact for the square of a linear difference in a tetrahedron or triangle; those of a hexahedron's own quadrature.
  static const std::vector<LocalPoint>& points() {
    constexpr double a = 0.5854101966249685, b = 0.1381966011250105, g = 0.5773502691896258;
    static const std::vector<LocalPoint> triangle{{1. / 6, 1. / 6, 0}, {2. / 3, 1. / 6, 0}, {1. / 6, 2. / 3, 0}};
    static const std::vector<LocalPoint> tetrahedron{{b, b, b}, {a, b, b}, {b, a, b}, {b, b, a}};
    static const std::vector<LocalPoint> hexahedron = [] {
      std::vector<LocalPoint> all;
      for (int i = 0; i < 8; ++i) all.push_back({i & 1 ? g : -g, i & 2 ? g : -g, i & 4 ? g : -g});
      return all;
    }();
    return is_flat ? triangle : std::tuple_size_v<Cell> == 4 ? tetrahedron : hexahedron;
  }
  static constexpr double weight = is_flat ? 1. / 6 : std::tuple_size_v<Cell> == 4 ? 1. / 24 : 1;

  void addAt(std::size_t c, const LocalPoint& xi, StrainError& sum) const {
    const Cell& cell = cells_[c];
    std::array<double, std::tuple_size_v<Cell>> shapes;
    kindOf(cell).shapes(xi, shapes.data());
    Strain own = strain_[c];
    double size = size_[c];
    if constexpr (!has_one_strain) {
      const auto [f, its_size] = deformationAt(cell, xi, rest_, now_);
      own = strainOf(f, bulk_), size = its_size;
    }
    Strain recovered = Strain::Zero();
    for (std::size_t a = 0; a < cell.size(); ++a) recovered += shapes[a] * at_node_[std::size_t(cell[a])];
    sum.error += modulus_[c] * weight * size * (recovered - own).squaredNorm();
    sum.strain += modulus_[c] * weight * size * own.squaredNorm();
    sum.largest = std::max(sum.largest, own.squaredNorm());
  }

  /// Nodes keep their order. Cells around them are counted first, and then put in rows.
  void takeNodes(const std::vector<Vec3>& rest, const std::vector<Vec3>& now) {
    std::vector<Index> number(rest.size(), -1);
    for (const Cell& cell : cells_)
      for (const Index n : cell) number[std::size_t(n)] = 0;
    for (std::size_t n = 0; n < rest.size(); ++n)
      if (number[n] == 0) number[n] = Index(rest_.size()), rest_.push_back(rest[n]), now_.push_back(now[n]);
    first_around_.assign(rest_.size() + 1, 0);
    for (Cell& cell : cells_)
      for (Index& n : cell) n = number[std::size_t(n)], ++first_around_[std::size_t(n) + 1];
    std::partial_sum(first_around_.begin(), first_around_.end(), first_around_.begin());
    around_.resize(first_around_.back());
    std::vector<std::size_t> next(first_around_.begin(), first_around_.end() - 1);
    for (std::size_t c = 0; c < cells_.size(); ++c)
      for (const Index n : cells_[c]) around_[next[std::size_t(n)]++] = c;
  }

  std::span<const std::size_t> around(std::size_t node) const {
    return std::span(around_).subspan(first_around_[node], first_around_[node + 1] - first_around_[node]);
  }

  /// The linear fit to the cells around a node, in coordinates from it; nothing where they do not determine one.
  std::optional<Fit> fitAt(std::size_t node) const {
    constexpr std::size_t fewest = is_flat ? 5 : 8;
    const std::span<const std::size_t> cells = around(node);
    if (cells.size() < fewest) return {};
    double size = 0;
    for (const std::size_t c : cells) size = std::max(size, (centre_[c] - rest_[node]).norm());
    Eigen::Matrix4d squares = Eigen::Matrix4d::Zero();
    Fit right = Fit::Zero();
    for (const std::size_t c : cells) {
      Eigen::Vector4d p;
      p << 1, (centre_[c] - rest_[node]) / size;
      squares += p * p.transpose();
      right += strain_[c] * p.transpose();
    }
    squares /= double(cells.size()), right /= double(cells.size());
    if constexpr (is_flat) {  // no slope across the surface
      const Vec3 normal = Eigen::SelfAdjointEigenSolver<Mat3>(squares.bottomRightCorner<3, 3>()).eigenvectors().col(0);
      squares.bottomRightCorner<3, 3>() += normal * normal.transpose();
    }
    const Eigen::LDLT<Eigen::Matrix4d> factors(squares);
    if (!(factors.vectorD().minCoeff() > 0.01)) return {};
    Fit fit = factors.solve(right.transpose()).transpose();
    fit.rightCols<3>() /= size;
    return fit;
  }

  void fitAll() {
    std::vector<std::optional<Fit>> fits(rest_.size());
    for (std::size_t n = 0; n < rest_.size(); ++n) fits[n] = fitAt(n);
    for (std::size_t n = 0; n < rest_.size(); ++n)
      at_node_.push_back(fits[n] ? Strain(fits[n]->col(0)) : beside(n, fits));
  }

  /// What the fits around say of a node without one; where there are none, the mean of its cells.
  Strain beside(std::size_t node, const std::vector<std::optional<Fit>>& fits) const {
    Strain sum = Strain::Zero(), mean = Strain::Zero();
    int count = 0;
    const std::span<const std::size_t> cells = around(node);
    for (const std::size_t c : cells) {
      mean += strain_[c] / double(cells.size());
      for (const Index other : cells_[c]) {
        if (!fits[std::size_t(other)]) continue;
        Eigen::Vector4d p;
        p << 1, rest_[node] - rest_[std::size_t(other)];
        sum += *fits[std::size_t(other)] * p, ++count;
      }
    }
    return count > 0 ? Strain(sum / count) : mean;
  }

  std::vector<Cell> cells_;
  std::vector<double> modulus_;
  double bulk_;
  std::vector<Vec3> rest_, now_, centre_;
  std::vector<Strain> strain_;  ///< of each cell at its centre
  std::vector<double> size_;    ///< det dX/dxi there
  std::vector<std::size_t> first_around_, around_;  ///< cells around each node, in rows
  std::vector<Strain> at_node_;
};

/// Cells with moduli within 1.5 of each other are one material.
template <class Cell>
StrainError estimate(const std::vector<Cell>& cells, const std::vector<Vec3>& rest, const std::vector<Vec3>& now,
                     const std::vector<double>& modulus, double bulk) {
  std::map<long, std::pair<std::vector<Cell>, std::vector<double>>> materials;
  for (std::size_t c = 0; c < cells.size(); ++c) {
    const double own = modulus.size() == cells.size() ? modulus[c] : 1;
    if (!(own > 0)) continue;
    auto& [its_cells, moduli] = materials[std::lround(std::log(own) / std::log(1.5))];
    its_cells.push_back(cells[c]), moduli.push_back(own);
  }
  StrainError sum;
  for (auto& [material, its] : materials) {
    const StrainError part = Recovery<Cell>(std::move(its.first), std::move(its.second), bulk, rest, now).error();
    sum.error += part.error, sum.strain += part.strain;
    sum.largest = std::max(sum.largest, part.largest);
  }
  return sum;
}

/// A list with a value per cell, or empty.
std::vector<double> listOf(const ForceField& field, const char* name, std::size_t cells) {
  const Data* data = field.data().find(name);
  if (!data) return {};
  const auto* list = std::get_if<std::vector<double>*>(&data->pointer());
  return list && (*list)->size() == cells ? **list : std::vector<double>();
}

std::vector<double> modulusOf(const ForceField& field, std::size_t cells) {
  std::vector<double> modulus = listOf(field, "youngModulus", cells);
  const std::vector<double> factor = listOf(field, "localStiffnessFactor", cells);
  if (modulus.empty()) return factor;
  for (std::size_t c = 0; c < factor.size(); ++c) modulus[c] *= factor[c];
  return modulus;
}

/// Of triangles with stiffness in their plane; they have no stress for exporters.
bool isMembrane(const ForceField& field) {
  return field.type().find("Triang") != std::string::npos && field.type().find("FEM") != std::string::npos;
}

/// K/(2 mu) of a field whose volume change is that of each point, or what stands for it in plane stress; zero where it is a
/// mean, or not known.
double bulkOf(const ForceField& field) {
  const Data *data = field.data().find("poissonRatio"), *dilatation = field.data().find("dilatation");
  const bool is_membrane = isMembrane(field);
  const auto* list = data && (dilatation || is_membrane) ? std::get_if<std::vector<double>*>(&data->pointer()) : nullptr;
  if (!list || (*list)->empty()) return 0;
  if (is_membrane) {
    const double nu = *std::max_element((*list)->begin(), (*list)->end());
    return (1 + 2 * nu) / (3 * (1 - nu));
  }
  const auto* open = dynamic_cast<const OpenChoices*>(&field);
  if (dilatation->print() == "mean" || (open && open->choice().find("mean") != std::string::npos)) return 0;
  const double nu = *std::max_element((*list)->begin(), (*list)->end());
  return (1 + nu) / (3 * (1 - 2 * nu));
}

/// The cells of a mesh that a field is made of.
template <class Visit>
void visitCells(const ForceField& field, Visit&& visit) {
  const CellKind* kind = kindOfLaw(field);
  const bool is_membrane = isMembrane(field);
  for (const Topology* topology : topologiesOf(field.state())) {
    const Mesh& mesh = topology->mesh();
    if (mesh.overlap != 1 || std::size_t(mesh.nodes()) > field.state().rest_position.size()) continue;
    if (is_membrane && !mesh.triangles.empty()) return visit(mesh.triangles);
    if (is_membrane) continue;
    if (!kind) continue;
    if (kind->type == CellType::tetrahedron && !mesh.tetrahedra.empty()) return visit(mesh.tetrahedra);
    if (kind->type == CellType::hexahedron && !mesh.hexahedra.empty()) return visit(mesh.hexahedra);
  }
}

}  // namespace

StrainError strainError(const std::vector<Tetrahedron>& cells, const std::vector<Vec3>& rest,
                        const std::vector<Vec3>& now, const std::vector<double>& modulus, double bulk) {
  return estimate(cells, rest, now, modulus, bulk);
}
StrainError strainError(const std::vector<Hexahedron>& cells, const std::vector<Vec3>& rest,
                        const std::vector<Vec3>& now, const std::vector<double>& modulus, double bulk) {
  return estimate(cells, rest, now, modulus, bulk);
}

StrainError strainError(const std::vector<Triangle>& cells, const std::vector<Vec3>& rest,
                        const std::vector<Vec3>& now, const std::vector<double>& modulus, double bulk) {
  return estimate(cells, rest, now, modulus, bulk);
}

std::optional<StrainError> meshErrorOf(const ForceField& field, ConstRows x) {
  if (!isMembrane(field) && !kindOfLaw(field)) return {};
  const std::vector<Vec3>& rest = field.state().rest_position;
  const std::vector<Vec3> now = positionsOf(field.state(), x);
  if (now == rest) return {};
  constexpr double round_off = 1e-10;  // strains of rounded positions
  std::optional<StrainError> found;
  visitCells(field, [&](const auto& cells) {
    const StrainError error = strainError(cells, rest, now, modulusOf(field, cells.size()), bulkOf(field));
    if (std::isfinite(error.error) && error.largest > round_off * round_off) found = error;
  });
  return found;
}

std::vector<std::string> meshErrors(const Simulation& simulation) {
  constexpr double limit = 0.03;
  simulation.complete();
  const UnitSystem units = unitsOf(simulation.scene());
  std::vector<std::string> sentences;
  for (const auto& system : simulation.systems()) {
    double error = 0, all = 0, greatest = 0;
    const ForceField* worst = nullptr;
    for (const ForceField* field : system->forceFields()) {
      const auto own = meshErrorOf(*field, system->x);
      const double energy = own ? std::abs(field->energy(system->x)) : 0;
      if (!own || !std::isfinite(energy)) continue;
      all += energy, error += own->share() * energy;
      if (own->share() * energy > greatest) greatest = own->share() * energy, worst = field;
    }
    if (!worst || error <= limit * all) continue;
    bool tetrahedra = false;
    visitCells(*worst, [&tetrahedra](const auto& cells) { tetrahedra = cells.front().size() == 4; });
    sentences.push_back(fmt::format(
        "{} at t = {:.6g}{}: by the jumps of the strain between cells the mesh is too coarse for this "
        "deformation: some "
        "{:.0f} % too stiff. Finer cells{} are closer",
        worst->path(), simulation.time(), units.behind("s"), 100 * error / all,
        tetrahedra ? ", quadratic tetrahedra or hexahedra" : ""));
  }
  return sentences;
}

}  // namespace stroma
