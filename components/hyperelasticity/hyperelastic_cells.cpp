// SPDX-License-Identifier: LGPL-2.1-or-later
// The cells of a hyperelastic field: which shapes it refuses, what it says of a cell, and the fields of cells.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "components/hyperelasticity/hyperelastic_force_field.h"
#include "framework/mesh/cell_kind.h"

namespace stroma {
namespace {

/// Gradients of shape functions (columns, in the order of the cell) at the integration points.
using Gradients = Eigen::Matrix<double, 3, Eigen::Dynamic>;

/// Those along xi, eta and zeta of the hexahedron at the kernels' point p, where xi goes fastest.
Gradients localGradients(int p) {
  constexpr int node_of_point[8] = {0, 1, 3, 2, 4, 5, 7, 6};
  std::array<LocalPoint, 8> slopes;
  cell_kinds::hexahedron.gradients(cell_kinds::hexahedron.rule(2).points[node_of_point[p]].xi, slopes.data());
  Gradients local(3, 8);
  for (int a = 0; a < 8; ++a) local.col(a) = Vec3(slopes[a].data());
  return local;
}
/// dx/d(xi, eta, zeta) at a point.
Mat3 edgesOf(const std::vector<Vec3>& corner, const Gradients& local) {
  Mat3 j = Mat3::Zero();
  for (std::size_t a = 0; a < corner.size(); ++a) j += corner[a] * local.col(Eigen::Index(a)).transpose();
  return j;
}

std::vector<Gradients> gradientsOf(const std::vector<Vec3>& corner) {
  std::vector<Gradients> result;
  if (corner.size() == 4) {
    Mat3 edges;
    edges << corner[1] - corner[0], corner[2] - corner[0], corner[3] - corner[0];
    const Mat3 g = edges.inverse().transpose();
    Gradients all(3, 4);
    all << -g.rowwise().sum(), g;
    return {all};
  }
  for (int p = 0; p < 8; ++p) {
    const Gradients local = localGradients(p);
    result.push_back(edgesOf(corner, local).inverse().transpose() * local);
  }
  return result;
}

template <class Nodes, class Position>
std::vector<Vec3> cornersOf(const Nodes& nodes, Position&& position) {
  std::vector<Vec3> corner;
  corner.reserve(std::size(nodes));
  for (Index n : nodes) corner.push_back(position(n));
  return corner;
}

}  // namespace

void HyperelasticForceField::checkShapes() const {
  for (std::size_t cell = 0; cell < cellCount(); ++cell) {
    const auto rest = [&](Index n) -> Vec3 { return state().rest_position[n]; };
    const std::vector<Vec3> corner =
        hexahedra ? cornersOf(mesh_->hexahedra[cell], rest) : cornersOf(mesh_->tetrahedra[cell], rest);
    double longest = 0;
    for (const Vec3& c : corner) longest = std::max(longest, (c - corner[0]).norm());
    for (const Gradients& g : gradientsOf(corner)) {
      Mat3 f = Mat3::Zero();
      for (std::size_t a = 0; a < corner.size(); ++a) f += corner[a] * g.col(Eigen::Index(a)).transpose();
      if (!(g.norm() < 1e12 / longest) || !(std::abs(f.trace() - 3) < 1e-3))
        throw ComponentError(describe(cell) + " is flat at rest", "a volume");
    }
  }
}

void HyperelasticForceField::chooseDilatation() {
  mean_dilatation_ = dilatation_ == Dilatation::mean;
  if (mean_dilatation_) checkMeanDilatation();
  if (dilatation_ != Dilatation::automatic) return;
  constexpr double from = 0.4, nearly_incompressible = 0.45;
  double largest = -1;
  for (std::size_t set = 0; set * law_.parameters.size() < values_.size(); ++set) {
    const hyperelastic::HyperelasticLaw::Moduli moduli = law_.moduliAtRest(parametersIn(values_, set));
    largest = std::max(largest, (3 * moduli.bulk - 2 * moduli.shear) / (6 * moduli.bulk + 2 * moduli.shear));
  }
  if (largest < from) return;
  try {
    checkMeanDilatation();
    mean_dilatation_ = true;
  } catch (const ComponentError& error) {
    if (largest > nearly_incompressible)
      warn(fmt::format("{}, so that the cells lock at Poisson's ratio {:.4g}: a body is far too stiff in bending",
                       error.what(), largest),
           hexahedra ? "a law with a part in J alone" : "hexahedra");
  }
}

std::string HyperelasticForceField::choice() const {
  if (dilatation_ != Dilatation::automatic || !hexahedra) return {};
  return mean_dilatation_ ? "mean dilatation" : "local dilatation";
}

void HyperelasticForceField::checkMeanDilatation() const {
  const std::string expected = "dilatation=\"local\"";
  if (!hexahedra)
    throw ComponentError("the mean dilatation of a hyperelastic law exists for hexahedra", expected,
                         "HexahedronHyperelasticityFEMForceField, or TetrahedronFEMForceField for small strains");
  if (law_.volume == hyperelastic::VolumePart::none)
    throw ComponentError(
        fmt::format("the energy of {} has no part in J alone that a mean could replace", law_.name), expected,
        law_.name == "StVenantKirchhoff" ? "HexahedronFEMForceField with method=\"green\", whose mean is that of tr(E)"
                                         : "");
  if (series_.terms() > 0 && series_.part == PronyPart::all)
    throw ComponentError("viscosity relaxes the stress of a point, and the mean dilatation has one for all points",
                         expected, "viscousPart=\"deviatoric\", which leaves the volume elastic");
  for (std::size_t cell = 0; cell < cellCount(); ++cell) {
    const std::vector<Vec3> corner =
        cornersOf(mesh_->hexahedra[cell], [&](Index n) -> Vec3 { return state().rest_position[n]; });
    const double first = edgesOf(corner, localGradients(0)).determinant();
    for (int p = 1; p < 8; ++p)
      if (edgesOf(corner, localGradients(p)).determinant() * first <= 0)
        throw ComponentError(describe(cell) + " is folded at rest: its points have volumes of both signs",
                             "a hexahedron with one volume, or " + expected);
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
  return hexahedra ? fmt::format("hexahedron {} (nodes {})", cell, fmt::join(mesh_->hexahedra[cell], " "))
                   : fmt::format("tetrahedron {} (nodes {})", cell, fmt::join(mesh_->tetrahedra[cell], " "));
}

std::vector<Mat3> HyperelasticForceField::deformations(std::size_t cell, ConstRows x) const {
  const auto rest = [&](Index n) -> Vec3 { return state().rest_position[n]; };
  const auto now = [&](Index n) -> Vec3 { return x[n]; };
  const auto both = [&](const auto& nodes) {
    const std::vector<Vec3> corner = cornersOf(nodes, now);
    std::vector<Mat3> result;
    for (const Gradients& g : gradientsOf(cornersOf(nodes, rest))) {
      result.push_back(Mat3::Zero());
      for (std::size_t a = 0; a < corner.size(); ++a) result.back() += corner[a] * g.col(Eigen::Index(a)).transpose();
    }
    return result;
  };
  return hexahedra ? both(mesh_->hexahedra[cell]) : both(mesh_->tetrahedra[cell]);
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
  const std::string text = fmt::format("{}: J = {:.3g}", describe(cell), j);
  return fault_.empty() ? text : text + "; " + fault_;
}

/// P of F, both in the material's axes.
Mat3 HyperelasticForceField::stress(std::size_t cell, std::size_t point, const Mat3& f) const {
  if (!viscous_) return law_.stress(parameters(cell), f);
  const Mat3 relaxed = f * viscous_->stress(cell, point, f);
  if (!volumeIsApart()) return relaxed;
  return relaxed + law_.stress(parameters(cell), f) - law_.stress(parametersIn(local_values_, cell), f);
}

void HyperelasticForceField::cellField(const std::string& name, ConstRows x, std::vector<double>& out) const {
  const ConstRows own = ownRows(x);
  out.assign(name == "strain" ? 6 * cellCount() : cellCount(), 0.);
  for (std::size_t cell = 0; cell < cellCount(); ++cell) {
    if (name == "J") {
      out[cell] = smallestJacobian(cell, own);
      continue;
    }
    const std::vector<Mat3> points = deformations(cell, own);
    Mat3 mean = Mat3::Zero();  // of E or of Cauchy's stress P F^T / J
    for (std::size_t p = 0; p < points.size(); ++p) {
      const Mat3 &f = points[p], local = f * axes(cell);
      mean += name == "strain" ? Mat3((f.transpose() * f - Mat3::Identity()) / 2)
                               : Mat3(stress(cell, p, local) * local.transpose() / f.determinant());
    }
    mean /= double(points.size());
    if (name == "strain") {
      const double v[6] = {mean(0, 0), mean(1, 1), mean(2, 2), mean(0, 1), mean(1, 2), mean(2, 0)};
      std::copy(v, v + 6, out.begin() + std::ptrdiff_t(6 * cell));
    } else {
      out[cell] = std::sqrt(1.5) * (mean - mean.trace() / 3 * Mat3::Identity()).norm();
    }
  }
}

}  // namespace stroma
