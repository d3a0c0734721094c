// SPDX-License-Identifier: LGPL-2.1-or-later
// The cells of a hyperelastic field: which shapes it refuses, what it says of a cell, and the fields of cells.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "components/hyperelasticity/hyperelastic_force_field.h"
#include "framework/mesh/cell_lists.h"

namespace stroma {
namespace {

/// Gradients of shape functions (columns, in the order of the cell) at the integration points.
using Gradients = Eigen::Matrix<double, 3, Eigen::Dynamic>;

/// Those along xi, eta and zeta at the kernels' points: of a hexahedron xi goes fastest.
std::vector<Gradients> localGradients(const CellKind& kind) {
  constexpr int node_of_point[8] = {0, 1, 3, 2, 4, 5, 7, 6};
  const auto points = kind.rule(2).points;
  std::vector<Gradients> result;
  for (std::size_t p = 0; p < points.size(); ++p) {
    std::array<LocalPoint, most_cell_nodes> slopes;
    kind.gradients(points[kind.type == CellType::hexahedron ? std::size_t(node_of_point[p]) : p].xi, slopes.data());
    result.emplace_back(3, kind.nodes);
    for (int a = 0; a < kind.nodes; ++a) result.back().col(a) = Vec3(slopes[std::size_t(a)].data());
  }
  return result;
}
/// dx/d(xi, eta, zeta) at a point.
Mat3 edgesOf(const std::vector<Vec3>& corner, const Gradients& local) {
  Mat3 j = Mat3::Zero();
  for (std::size_t a = 0; a < corner.size(); ++a) j += corner[a] * local.col(Eigen::Index(a)).transpose();
  return j;
}

std::vector<Gradients> gradientsOf(const CellKind& kind, const std::vector<Vec3>& corner) {
  std::vector<Gradients> result;
  if (kind.affine) {
    Mat3 edges;
    edges << corner[1] - corner[0], corner[2] - corner[0], corner[3] - corner[0];
    const Mat3 g = edges.inverse().transpose();
    Gradients all(3, 4);
    all << -g.rowwise().sum(), g;
    return {all};
  }
  for (const Gradients& local : localGradients(kind))
    result.push_back(edgesOf(corner, local).inverse().transpose() * local);
  return result;
}

}  // namespace

std::span<const Index> HyperelasticForceField::nodesOf(std::size_t cell) const {
  std::span<const Index> nodes;
  forEachCellList(
      [&](const CellKind& of, const auto& cells) {
        if (of.type == kind->type) nodes = cells[cell];
      },
      *mesh_);
  return nodes;
}

std::vector<Vec3> HyperelasticForceField::restCorners(std::size_t cell) const {
  std::vector<Vec3> corner;
  for (const Index n : nodesOf(cell)) corner.push_back(state().rest_position[n]);
  return corner;
}

void HyperelasticForceField::checkShapes() const {
  for (std::size_t cell = 0; cell < cellCount(); ++cell) {
    const std::vector<Vec3> corner = restCorners(cell);
    double longest = 0;
    for (const Vec3& c : corner) longest = std::max(longest, (c - corner[0]).norm());
    for (const Gradients& g : gradientsOf(*kind, corner)) {
      Mat3 f = Mat3::Zero();
      for (std::size_t a = 0; a < corner.size(); ++a) f += corner[a] * g.col(Eigen::Index(a)).transpose();
      if (!(g.norm() < 1e12 / longest) || !(std::abs(f.trace() - 3) < 1e-3))
        throw ComponentError(describe(cell) + " is flat at rest", "a volume");
    }
  }
}

double HyperelasticForceField::largestPoissonRatio() const {
  double largest = -1;
  for (std::size_t set = 0; set * law_.parameters.size() < values_.size(); ++set) {
    const hyperelastic::HyperelasticLaw::Moduli moduli = law_.moduliAtRest(parametersIn(values_, set));
    largest = std::max(largest, (3 * moduli.bulk - 2 * moduli.shear) / (6 * moduli.bulk + 2 * moduli.shear));
  }
  return largest;
}

/// Poisson's ratio comes back from the moduli of the law with round-off: one that was written as the limit is not below it.
void HyperelasticForceField::chooseDilatation() {
  constexpr double round_off = 1e-9, nearly_half = 0.485;
  const double largest = largestPoissonRatio();
  stiff_in_volume_ = largest < nearly_half ? "" : fmt::format("its Poisson's ratio at small strains is {:.6g}", largest);
  mean_dilatation_ = dilatation_ == Dilatation::mean;
  if (mean_dilatation_) checkMeanDilatation();
  if (dilatation_ != Dilatation::automatic) return;
  const double from = kind->type == CellType::quadratic_tetrahedron ? 0.45 : 0.4,
               nearly_incompressible = std::max(from, 0.45);
  if (largest < from - round_off) return;
  try {
    checkMeanDilatation();
    mean_dilatation_ = true;
  } catch (const ComponentError& error) {
    if (largest > nearly_incompressible + round_off)
      warn(fmt::format("{}, so that the cells lock at Poisson's ratio {:.4g}: a body is far too stiff in bending",
                       error.what(), largest),
           !error.suggestion.empty()  ? error.suggestion
           : kernels().mean_volume ? "a law with a part in J alone"
                                   : "hexahedra");
  }
}

std::string HyperelasticForceField::choice() const {
  if (dilatation_ != Dilatation::automatic || !kernels().mean_volume) return {};
  return mean_dilatation_ ? "mean dilatation" : "local dilatation";
}

void HyperelasticForceField::checkMeanDilatation() const {
  const std::string expected = "dilatation=\"local\"";
  if (!kernels().mean_volume)
    throw ComponentError("the mean dilatation of a hyperelastic law exists for hexahedra and quadratic tetrahedra",
                         expected,
                         "HexahedronHyperelasticityFEMForceField, or TetrahedronFEMForceField for small strains");
  if (law_.volume == hyperelastic::VolumePart::none)
    throw ComponentError(
        fmt::format("the energy of {} has no part in J alone that a mean could replace", law_.name), expected,
        law_.name == "StVenantKirchhoff" ? "HexahedronFEMForceField with method=\"green\", whose mean is that of tr(E)"
                                         : "");
  if (series_.terms() > 0 && series_.part == PronyPart::all)
    throw ComponentError("viscosity relaxes the stress of a point, and the mean dilatation has one for all points",
                         expected, "viscousPart=\"deviatoric\", which leaves the volume elastic");
  if (made_.mean_dilatation) return;  // the shapes have been looked at
  const std::vector<Gradients> local = localGradients(*kind);
  for (std::size_t cell = 0; cell < cellCount(); ++cell) {
    const std::vector<Vec3> corner = restCorners(cell);
    const double first = edgesOf(corner, local[0]).determinant();
    for (const Gradients& at_point : local)
      if (edgesOf(corner, at_point).determinant() * first <= 0)
        throw ComponentError(describe(cell) + " is folded at rest: its points have volumes of both signs",
                             fmt::format("a {} with one volume, or {}", kind->singular, expected));
  }
}

/// Without k U(J) the law must resist changes of shape alone: no stress under any dilation.
void HyperelasticForceField::checkViscousPart() const {
  if (series_.terms() == 0 || series_.part == PronyPart::all) return;
  const std::vector<double> values = law_.volume == hyperelastic::VolumePart::none ? values_ : withoutVolume();
  for (std::size_t set = 0; set * law_.parameters.size() < values.size(); ++set) {
    const hyperelastic::Values local = parametersIn(values, set);
    const Mat3 dilated = law_.stress(local, 1.1 * Mat3::Identity());
    if (dilated.norm() < 1e-9 * law_.moduliAtRest(local).shear) continue;
    throw ComponentError(
        fmt::format("viscousPart=\"deviatoric\" relaxes what resists a change of shape alone, and the energy of {} has "
                    "no such part beside that of the volume",
                    law_.name),
        "viscousPart=\"all\", or a law of J^-2/3 C: MooneyRivlin, VerondaWestman, ArrudaBoyce, Yeoh, Ogden, "
        "FungOrthotropic, TransverselyIsotropicMooneyRivlin");
  }
}

std::string HyperelasticForceField::describe(std::size_t cell) const {
  return fmt::format("{} {} (nodes {})", kind->singular, cell, fmt::join(nodesOf(cell), " "));
}

std::vector<Mat3> HyperelasticForceField::deformations(std::size_t cell, ConstRows x) const {
  const std::span<const Index> nodes = nodesOf(cell);
  std::vector<Mat3> result;
  for (const Gradients& g : gradientsOf(*kind, restCorners(cell))) {
    result.push_back(Mat3::Zero());
    for (std::size_t a = 0; a < nodes.size(); ++a)
      result.back() += Vec3(x[nodes[a]]) * g.col(Eigen::Index(a)).transpose();
  }
  return result;
}

double HyperelasticForceField::smallestJacobian(std::size_t cell, ConstRows x) const {
  double smallest = std::numeric_limits<double>::infinity();
  for (const Mat3& f : deformations(cell, x)) {
    const double j = f.determinant();
    if (!(j >= smallest)) smallest = j;
  }
  return smallest;
}

std::size_t HyperelasticForceField::worstCell(ConstRows x, double& jacobian) const {
  jacobian = std::numeric_limits<double>::infinity();
  std::size_t worst = 0;
  for (std::size_t cell = 0; cell < cellCount(); ++cell) {
    const double j = smallestJacobian(cell, x);
    if (!(j >= jacobian)) jacobian = j, worst = cell;  // a NaN is the worst
    if (jacobian != jacobian) break;
  }
  return worst;
}

std::string HyperelasticForceField::worstElement(ConstRows x) const {
  double j = 0;
  const std::size_t cell = worstCell(ownRows(x), j);
  if (std::isnan(j) && !fault_.empty()) return fault_;
  std::string text = fmt::format("{}: J = {:.3g}", describe(cell), j);
  if (j <= 0 && mean_dilatation_ && !law_.infinite_at_zero)
    text += fmt::format(
        "; with dilatation=\"mean\" the bulk stiffness acts on the volume of a whole cell, and {} lets single points turn "
        "inside out: dilatation=\"local\" resists that, a law with ln J refuses it",
        law_.name);
  return fault_.empty() ? text : text + "; " + fault_;
}

/// P of F, both in the material's axes.
Mat3 HyperelasticForceField::stress(std::size_t cell, std::size_t point, const Mat3& f) const {
  if (!viscous_) return law_.stress(parameters(cell), f);
  const Mat3 relaxed = f * viscous_->stress(cell, point, f);
  if (!volumeIsApart()) return relaxed;
  return relaxed + law_.stress(parameters(cell), f) - law_.stress(parametersIn(local_values_, cell), f);
}

/// E, the mean of the points.
Mat3 HyperelasticForceField::meanStrain(std::size_t cell, ConstRows x) const {
  const std::vector<Mat3> points = deformations(cell, x);
  Mat3 sum = Mat3::Zero();
  for (const Mat3& f : points) sum += (f.transpose() * f - Mat3::Identity()) / 2;
  return sum / double(points.size());
}

/// Cauchy's stress P F^T / J, the mean of the points. Where dilatation is mean, k U'(J) is that of the mean J.
Mat3 HyperelasticForceField::meanStress(std::size_t cell, ConstRows x) const {
  const std::vector<Mat3> points = deformations(cell, x);
  // a flat cell has no area for its force: that of a cell of a millionth
  const auto ofSome = [](double j) { return std::abs(j) < 1e-6 ? 1e-6 : j; };
  const auto withoutVolume = [&](std::size_t p, const Mat3& f) {
    return viscous_ ? Mat3(f * viscous_->stress(cell, p, f)) : law_.stress(parametersIn(local_values_, cell), f);
  };
  Mat3 sum = Mat3::Zero();
  for (std::size_t p = 0; p < points.size(); ++p) {
    const Mat3 f = points[p] * axes(cell);
    sum += (mean_dilatation_ ? withoutVolume(p, f) : stress(cell, p, f)) * f.transpose() / ofSome(points[p].determinant());
  }
  sum /= double(points.size());
  if (!mean_dilatation_) return sum;
  const double j = ofSome(volumeRatio(cell, points));
  const Mat3 dilation = std::cbrt(j) * Mat3::Identity();
  const Mat3 whole = law_.stress(parameters(cell), dilation), local = law_.stress(parametersIn(local_values_, cell), dilation);
  return sum + (whole - local) * dilation / j;
}

/// The volume of a cell over that at rest.
double HyperelasticForceField::volumeRatio(std::size_t cell, const std::vector<Mat3>& points) const {
  const std::vector<Vec3> corner = restCorners(cell);
  const std::vector<Gradients> local = localGradients(*kind);
  double now = 0, at_rest = 0;
  for (std::size_t p = 0; p < points.size(); ++p) {
    const double volume = edgesOf(corner, local[p]).determinant();
    now += volume * points[p].determinant();
    at_rest += volume;
  }
  return now / at_rest;
}

std::vector<std::string> HyperelasticForceField::cellFields() const {
  return {"vonMises", "J", "strain", "stress", "principalStress", "principalStrain"};
}

ForceField::CellFieldShape HyperelasticForceField::cellFieldShape(const std::string& name) const {
  const bool tensor = name == "strain" || name == "stress", principal = name.starts_with("principal");
  return {kind, std::size_t(tensor ? 6 : principal ? 3 : 1)};
}

void HyperelasticForceField::cellField(const std::string& name, ConstRows x, std::vector<double>& out) const {
  const ConstRows own = ownRows(x);
  const std::size_t width = cellFieldShape(name).width;
  const bool of_strain = name == "strain" || name == "principalStrain";
  out.assign(width * cellCount(), 0.);
  for (std::size_t cell = 0; cell < cellCount(); ++cell) {
    double* to = out.data() + width * cell;
    if (name == "J") {
      *to = smallestJacobian(cell, own);
      continue;
    }
    const Mat3 mean = of_strain ? meanStrain(cell, own) : meanStress(cell, own);
    if (width == 6) {
      const double v[6] = {mean(0, 0), mean(1, 1), mean(2, 2), mean(0, 1), mean(1, 2), mean(2, 0)};
      std::copy(v, v + 6, to);
    } else if (width == 3) {
      const Vec3 values = mean.selfadjointView<Eigen::Lower>().eigenvalues();
      std::reverse_copy(values.data(), values.data() + 3, to);
    } else {
      *to = std::sqrt(1.5) * (mean - mean.trace() / 3 * Mat3::Identity()).norm();
    }
  }
}

}  // namespace stroma
