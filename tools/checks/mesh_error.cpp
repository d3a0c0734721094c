// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/checks/mesh_error.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <numeric>
#include <span>

#include "framework/mesh/cell_kind.h"

namespace stroma {
namespace {

/// The deviator xx yy zz, then xy yz zx times the root of 2: |.|^2 is that of the tensor. Then the trace times the root of
/// K/(2 mu), so that mu |.|^2 is the energy.
using Strain = Eigen::Matrix<double, 7, 1>;

double changeOf(const Mat3& f, const Mat3& c, VolumeChange::Of of) {
  switch (of) {
    case VolumeChange::Of::stretch:
      return Eigen::SelfAdjointEigenSolver<Mat3>(c, Eigen::EigenvaluesOnly).eigenvalues().cwiseMax(0).cwiseSqrt().sum() - 3;
    case VolumeChange::Of::displacement: return f.trace() - 3;
    case VolumeChange::Of::volume: return f.determinant() - 1;
    default: return (c.trace() - 3) / 2;
  }
}

/// Of (F^T F - 1) / 2.
Strain strainOf(const Mat3& f, double bulk, VolumeChange::Of of) {
  const Mat3 c = f.transpose() * f;
  const double third = c.trace() / 3, root = std::sqrt(0.5);
  Strain e;
  e << (c(0, 0) - third) / 2, (c(1, 1) - third) / 2, (c(2, 2) - third) / 2, root * c(0, 1), root * c(1, 2),
      root * c(2, 0), std::sqrt(bulk) * changeOf(f, c, of);
  return e;
}

const CellKind& kindOf(const Tetrahedron&) { return cell_kinds::tetrahedron; }
const CellKind& kindOf(const Hexahedron&) { return cell_kinds::hexahedron; }
const CellKind& kindOf(const Triangle&) { return cell_kinds::triangle; }
const CellKind& kindOf(const Prism&) { return cell_kinds::prism; }
const CellKind& kindOf(const Pyramid&) { return cell_kinds::pyramid; }
const CellKind& kindOf(const QuadraticTetrahedron&) { return cell_kinds::quadratic_tetrahedron; }

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
  if constexpr (std::tuple_size_v<Cell> == 3) {
    addNormal(before);
    addNormal(after);
  }
  return {after * before.inverse(), std::abs(before.determinant())};
}

/// Cells of one modulus: their strains at centres, of quadratic ones at four points, and the continuous strain made of them.
/// Nodes are renumbered.
template <class Cell>
class Recovery {
 public:
  Recovery(std::vector<Cell> cells, std::vector<double> modulus, double bulk, VolumeChange change, const std::vector<Vec3>& rest,
           const std::vector<Vec3>& now)
      : cells_(std::move(cells)), modulus_(std::move(modulus)), bulk_(bulk), change_(change) {
    takeNodes(rest, now);
    const std::vector<LocalPoint> samples = samplePoints();
    place_.reserve(cells_.size() * samples.size());
    strain_.reserve(place_.capacity());
    size_.reserve(place_.capacity());
    for (const Cell& cell : cells_) {
      for (const LocalPoint& xi : samples) {
        std::array<double, std::tuple_size_v<Cell>> shapes;
        kindOf(cell).shapes(xi, shapes.data());
        Vec3 place = Vec3::Zero();
        for (std::size_t a = 0; a < cell.size(); ++a) place += shapes[a] * rest_[std::size_t(cell[a])];
        place_.push_back(place);
        const auto [f, size] = deformationAt(cell, xi, rest_, now_);
        strain_.push_back(strainOf(f, bulk_, change_.of)), size_.push_back(size);
      }
    }
    samples_ = samples.size();
    if (change_.is_mean)
      for (std::size_t c = 0; c < cells_.size(); ++c) {
        mean_.push_back(meanChange(cells_[c]));
        for (std::size_t k = 0; k < samples_; ++k) strain_[samples_ * c + k][6] = mean_[c];
      }
    fitAll();
  }

  StrainError error() const {
    StrainError sum;
    for (std::size_t c = 0; c < cells_.size(); ++c)
      for (const QuadraturePoint& point : kindOf(Cell()).rule(degree).points) addAt(c, point, sum);
    return sum;
  }

 private:
  static constexpr bool is_flat = std::tuple_size_v<Cell> == 3, is_quadratic = std::tuple_size_v<Cell> == 10;
  static constexpr bool has_one_strain = is_flat || std::tuple_size_v<Cell> == 4;
  static constexpr int terms = is_quadratic ? 10 : 4;
  static constexpr int degree = is_quadratic ? 4 : 2;  ///< of the square of what is compared
  using Terms = Eigen::Matrix<double, terms, 1>;
  struct Fit {
    Eigen::Matrix<double, 7, terms> of;
    double size;  ///< [m]
    Strain at(const Vec3& from_node) const { return of * termsAt(from_node / size); }
  };
  /// 1, x, y, z, and the products of two.
  static Terms termsAt(const Vec3& p) {
    Terms t;
    t.template head<4>() << 1, p;
    if constexpr (is_quadratic) t.template tail<6>() << p.cwiseProduct(p), p[0] * p[1], p[1] * p[2], p[2] * p[0];
    return t;
  }

  /// Where strains are better than elsewhere: the centre, the mean of a linear cell's nodes; four points of a quadratic one.
  static std::vector<LocalPoint> samplePoints() {
    const CellKind& kind = kindOf(Cell());
    std::vector<LocalPoint> points;
    if constexpr (is_quadratic) {
      for (const QuadraturePoint& point : kind.rule(2).points) points.push_back(point.xi);
    } else {
      points.emplace_back();
      for (const LocalPoint& node : kind.reference)
        for (std::size_t k = 0; k < 3; ++k) points[0][k] += node[k] / kind.nodes;
    }
    return points;
  }

  /// By the points of the cells' own quadrature.
  double meanChange(const Cell& cell) const {
    double sum = 0, all = 0;
    for (const QuadraturePoint& point : kindOf(cell).rule(std::tuple_size_v<Cell> == 5 ? 1 : 2).points) {
      const auto [f, size] = deformationAt(cell, point.xi, rest_, now_);
      sum += point.weight * size * strainOf(f, bulk_, change_.of)[6], all += point.weight * size;
    }
    return sum / all;
  }

  void addAt(std::size_t c, const QuadraturePoint& point, StrainError& sum) const {
    const Cell& cell = cells_[c];
    const LocalPoint& xi = point.xi;
    std::array<double, std::tuple_size_v<Cell>> shapes;
    kindOf(cell).shapes(xi, shapes.data());
    Strain own = strain_[c];
    double size = size_[c];
    if constexpr (!has_one_strain) {
      const auto [f, its_size] = deformationAt(cell, xi, rest_, now_);
      own = strainOf(f, bulk_, change_.of), size = its_size;
    }
    if (change_.is_mean) own[6] = mean_[c];
    Strain recovered = Strain::Zero();
    for (std::size_t a = 0; a < cell.size(); ++a) recovered += shapes[a] * at_node_[std::size_t(cell[a])];
    const double weight = modulus_[c] * point.weight * size;
    sum.error += weight * (recovered - own).squaredNorm();
    sum.strain += weight * own.squaredNorm();
    sum.continuous += weight * recovered.squaredNorm(), sum.common += weight * recovered.dot(own);
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
      for (const Index n : cells_[c]) around_[next[std::size_t(n)]++] = std::uint32_t(c);
  }

  std::span<const std::uint32_t> around(std::size_t node) const {
    return std::span(around_).subspan(first_around_[node], first_around_[node + 1] - first_around_[node]);
  }

  /// The fit to the samples in the cells around a node; nothing where they do not determine one.
  std::optional<Fit> fitAt(std::size_t node) const {
    constexpr std::size_t fewest = is_flat ? 5 : 2 * terms;
    constexpr double least = is_quadratic ? 1e-4 : 0.01;
    const std::span<const std::uint32_t> cells = around(node);
    std::vector<std::size_t> samples;
    samples.reserve(samples_ * cells.size());
    for (const std::size_t c : cells)
      for (std::size_t k = 0; k < samples_; ++k) samples.push_back(samples_ * c + k);
    if (samples.size() < fewest) return {};
    Fit fit{{}, 0};
    for (const std::size_t s : samples) fit.size = std::max(fit.size, (place_[s] - rest_[node]).norm());
    Eigen::Matrix<double, terms, terms> squares = Eigen::Matrix<double, terms, terms>::Zero();
    Eigen::Matrix<double, 7, terms> right = Eigen::Matrix<double, 7, terms>::Zero();
    for (const std::size_t s : samples) {
      const Terms p = termsAt((place_[s] - rest_[node]) / fit.size);
      squares += p * p.transpose() / double(samples.size());
      right += strain_[s] * p.transpose() / double(samples.size());
    }
    if constexpr (is_flat) {  // no slope across the surface
      const Mat3 slopes = squares.template bottomRightCorner<3, 3>();
      const Vec3 normal = Eigen::SelfAdjointEigenSolver<Mat3>(slopes).eigenvectors().col(0);
      squares.template bottomRightCorner<3, 3>() += normal * normal.transpose();
    }
    const Eigen::LDLT<Eigen::Matrix<double, terms, terms>> factors(squares);
    if (!(factors.vectorD().minCoeff() > least)) return {};
    fit.of = factors.solve(right.transpose()).transpose();
    return fit;
  }

  /// Fits are large: only those that nodes without one ask for are kept.
  void fitAll() {
    std::vector<std::size_t> without;
    at_node_.assign(rest_.size(), Strain::Zero());
    for (std::size_t n = 0; n < rest_.size(); ++n) {
      if (const std::optional<Fit> fit = fitAt(n)) at_node_[n] = fit->of.col(0);
      else without.push_back(n);
    }
    std::map<Index, std::optional<Fit>> fits;
    for (const std::size_t n : without)
      for (const std::size_t c : around(n))
        for (const Index other : cells_[c])
          if (const auto [place, is_new] = fits.try_emplace(other); is_new) place->second = fitAt(std::size_t(other));
    for (const std::size_t n : without) at_node_[n] = beside(n, fits);
  }

  /// What the fits around say of a node without one; where there are none, the mean of its cells.
  Strain beside(std::size_t node, const std::map<Index, std::optional<Fit>>& fits) const {
    Strain sum = Strain::Zero(), mean = Strain::Zero();
    int count = 0;
    const std::span<const std::uint32_t> cells = around(node);
    for (const std::size_t c : cells) {
      for (std::size_t k = 0; k < samples_; ++k) mean += strain_[samples_ * c + k] / double(samples_ * cells.size());
      for (const Index other : cells_[c]) {
        const std::optional<Fit>& fit = fits.at(other);
        if (!fit) continue;
        sum += fit->at(rest_[node] - rest_[std::size_t(other)]), ++count;
      }
    }
    return count > 0 ? Strain(sum / count) : mean;
  }

  std::vector<Cell> cells_;
  std::vector<double> modulus_;
  double bulk_;
  VolumeChange change_;
  std::vector<double> mean_;  ///< of cells, where they have one
  std::vector<Vec3> rest_, now_;
  std::size_t samples_ = 1;                         ///< in each cell
  std::vector<Vec3> place_;                         ///< of them, shape (cells * samples_)
  std::vector<Strain> strain_;                      ///< the same
  std::vector<double> size_;                        ///< det dX/dxi there
  std::vector<std::size_t> first_around_;            ///< of each node in the next
  std::vector<std::uint32_t> around_;                ///< cells around each node, in rows
  std::vector<Strain> at_node_;
};

/// Cells with moduli within 1.5 of each other are one material.
template <class Cell>
StrainError estimate(const std::vector<Cell>& cells, const std::vector<Vec3>& rest, const std::vector<Vec3>& now,
                     const std::vector<double>& modulus, double bulk, VolumeChange change) {
  std::map<long, std::pair<std::vector<Cell>, std::vector<double>>> materials;
  for (std::size_t c = 0; c < cells.size(); ++c) {
    const double own = modulus.size() == cells.size() ? modulus[c] : 1;
    if (!(own > 0)) continue;
    auto& [its_cells, moduli] = materials[std::lround(std::log(own) / std::log(1.5))];
    its_cells.push_back(cells[c]), moduli.push_back(own);
  }
  StrainError sum;
  for (auto& [material, its] : materials) {
    const StrainError part = Recovery<Cell>(std::move(its.first), std::move(its.second), bulk, change, rest, now).error();
    sum.error += part.error, sum.strain += part.strain;
    sum.continuous += part.continuous, sum.common += part.common;
    sum.largest = std::max(sum.largest, part.largest);
  }
  return sum;
}

}  // namespace

template <class Cell>
StrainError strainError(const std::vector<Cell>& cells, const std::vector<Vec3>& rest, const std::vector<Vec3>& now,
                        const std::vector<double>& modulus, double bulk, VolumeChange change) {
  return estimate(cells, rest, now, modulus, bulk, change);
}
using Places = std::vector<Vec3>;
using Moduli = std::vector<double>;
template StrainError strainError(const std::vector<Tetrahedron>&, const Places&, const Places&, const Moduli&, double, VolumeChange);
template StrainError strainError(const std::vector<Hexahedron>&, const Places&, const Places&, const Moduli&, double, VolumeChange);
template StrainError strainError(const std::vector<Triangle>&, const Places&, const Places&, const Moduli&, double, VolumeChange);
template StrainError strainError(const std::vector<Prism>&, const Places&, const Places&, const Moduli&, double, VolumeChange);
template StrainError strainError(const std::vector<Pyramid>&, const Places&, const Places&, const Moduli&, double, VolumeChange);
template StrainError strainError(const std::vector<QuadraticTetrahedron>&, const Places&, const Places&, const Moduli&, double,
                                 VolumeChange);

}  // namespace stroma
