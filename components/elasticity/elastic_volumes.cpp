// SPDX-License-Identifier: LGPL-2.1-or-later
// The volumes that a mean dilatation resists (hexahedron_law.h, nodal_dilatation.h): theta = 1/V sum w tr(eps), so that the
// stiffness has a term K/V b b^T with
//
//   b_i = sum w R g_i = R dV_0/dX_i,   V_0(X) the volume at rest of a hexahedron; R turns it as the method does
//
// for each hexahedron, and for each node a between tetrahedra of one bulk modulus with V_a = sum_e V_e/4 and
// b_i = sum_e 1/4 R_e dV_e/dX_i. B that is updated, polarOf, incompatible modes and Green's strain have others, which are left out.
#include <algorithm>
#include <array>
#include <tuple>
#include <utility>

#include "components/elasticity/elastic_force_field.h"
#include "framework/fem/hexahedron.h"

namespace stroma {
namespace {

/// Returns the volume of a tetrahedron, positive, and its gradients.
double volumeOf(const std::array<Vec3, 4>& x, std::array<Vec3, 4>& gradients) {
  const Vec3 a = x[1] - x[0], b = x[2] - x[0], c = x[3] - x[0];
  const double volume = a.dot(b.cross(c)) / 6, sign = volume < 0 ? -1. / 6 : 1. / 6;
  gradients = {Vec3::Zero(), sign * b.cross(c), sign * c.cross(a), sign * a.cross(b)};
  gradients[0] = -(gradients[1] + gradients[2] + gradients[3]);
  return std::abs(volume);
}

/// The same of a trilinear hexahedron, in VTK's order of nodes: 2x2x2 Gauss points integrate its volume exactly.
double volumeOf(const std::array<Vec3, 8>& x, std::array<Vec3, 8>& gradients) {
  const double place = 1 / std::sqrt(3.);
  const auto sign = [](int bit) { return bit & 1 ? 1. : -1.; };
  double volume = 0;
  gradients.fill(Vec3::Zero());
  for (int p = 0; p < 8; ++p) {
    const double at[3] = {sign(p) * place, sign(p >> 1) * place, sign(p >> 2) * place};
    std::array<Vec3, 8> slopes;
    Mat3 j = Mat3::Zero();
    for (int a = 0; a < 8; ++a) {
      const double s[3] = {sign(a ^ a >> 1), sign(a >> 1), sign(a >> 2)};
      const double f[3] = {1 + s[0] * at[0], 1 + s[1] * at[1], 1 + s[2] * at[2]};
      slopes[std::size_t(a)] = Vec3(s[0] * f[1] * f[2], s[1] * f[2] * f[0], s[2] * f[0] * f[1]) / 8;
      j += x[std::size_t(a)] * slopes[std::size_t(a)].transpose();
    }
    Mat3 cofactor;
    cofactor << j.col(1).cross(j.col(2)), j.col(2).cross(j.col(0)), j.col(0).cross(j.col(1));
    volume += j.determinant();
    for (std::size_t a = 0; a < 8; ++a) gradients[a] += cofactor * slopes[a];
  }
  if (volume < 0)
    for (Vec3& gradient : gradients) gradient = -gradient;
  return std::abs(volume);
}

/// Volume and gradients of a cell at rest, turned by the rotation of its first point.
template <std::size_t nodes>
double turnedVolume(const ElasticElements& elements, std::size_t cell, const std::array<Index, nodes>& corners,
                    const std::vector<Vec3>& rest, ConstRows x, std::array<Vec3, nodes>& gradients) {
  std::array<Vec3, nodes> places;
  for (std::size_t a = 0; a < nodes; ++a) places[a] = rest[std::size_t(corners[a])];
  const double volume = volumeOf(places, gradients);
  Mat3 rotation = Mat3::Identity();
  bool is_first = true;
  const auto take = [&](const Mat3&, const Mat3& carrier, double) {
    if (is_first) rotation = carrier;
    is_first = false;
  };
  elements.forEachPoint(cell, x, std::ref(take));
  for (Vec3& gradient : gradients) gradient = rotation * gradient;
  return volume;
}

}  // namespace

void ElasticForceField::addVolumeTerms(VolumeTerms& terms) const {
  constexpr double worth = 20;  // K / mu; of softer cells solvers need to know nothing
  const bool has_others = update_b_ || update_volume_ || incompatible_ || polar_of_ != PolarOf::gradient;
  if (!variant_.mean_dilatation || has_others || variant_.method == ElasticMethod::green || variant_.method == ElasticMethod::nodal) return;
  if (std::ranges::none_of(constants_, [](const Lame& each) { return each.bulk() > worth * each.mu; })) return;
  if (elements_->kind().type == CellType::hexahedron) addVolumesOfHexahedra(terms);
  if (elements_->kind().type == CellType::tetrahedron) addVolumesOfNodes(terms);
}

void ElasticForceField::addVolumesOfHexahedra(VolumeTerms& terms) const {
  const Index first = state().firstRow();
  std::array<Vec3, 8> gradients;
  for (std::size_t cell = 0; cell < mesh_->hexahedra.size(); ++cell) {
    const auto& corners = mesh_->hexahedra[cell];
    const double volume = turnedVolume(*elements_, cell, corners, state().rest_position, state().x(), gradients);
    for (std::size_t a = 0; a < 8; ++a) terms.rows.push_back(first + corners[a]), terms.gradients.push_back(gradients[a]);
    terms.finish(lame(cell).bulk() / volume, lame(cell).mu / volume);
  }
}

/// Tetrahedra of one bulk modulus around a node share a term.
void ElasticForceField::addVolumesOfNodes(VolumeTerms& terms) const {
  struct Corner {
    Index node;  ///< whose average it is
    double bulk;
    std::size_t cell;
    bool operator<(const Corner& other) const { return std::tie(node, bulk, cell) < std::tie(other.node, other.bulk, other.cell); }
  };
  std::vector<double> volumes(mesh_->tetrahedra.size());
  std::vector<std::array<Vec3, 4>> gradients(volumes.size());
  std::vector<Corner> corners;
  for (std::size_t cell = 0; cell < volumes.size(); ++cell) {
    volumes[cell] = turnedVolume(*elements_, cell, mesh_->tetrahedra[cell], state().rest_position, state().x(), gradients[cell]) / 4;
    for (const Index node : mesh_->tetrahedra[cell]) corners.push_back({node, lame(cell).bulk(), cell});
  }
  std::sort(corners.begin(), corners.end());
  std::vector<std::pair<Index, Vec3>> parts;
  for (auto first = corners.begin(), end = first; first != corners.end(); first = end) {
    double volume = 0, shear = 0;
    parts.clear();
    for (end = first; end != corners.end() && end->node == first->node && end->bulk == first->bulk; ++end) {
      volume += volumes[end->cell], shear += volumes[end->cell] * lame(end->cell).mu;
      for (std::size_t a = 0; a < 4; ++a) parts.emplace_back(mesh_->tetrahedra[end->cell][a], gradients[end->cell][a] / 4);
    }
    std::ranges::stable_sort(parts, {}, &std::pair<Index, Vec3>::first);
    for (const auto& [node, gradient] : parts) {
      const Index row = state().firstRow() + node;
      if (Index(terms.rows.size()) > terms.start.back() && terms.rows.back() == row)
        terms.gradients.back() += gradient;
      else
        terms.rows.push_back(row), terms.gradients.push_back(gradient);
    }
    terms.finish(first->bulk / volume, shear / (volume * volume));
  }
}

}  // namespace stroma
