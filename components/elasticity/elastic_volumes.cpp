// SPDX-License-Identifier: LGPL-2.1-or-later
// The volumes that a mean dilatation resists (hexahedron_law.h, nodal_dilatation.h): theta = 1/V sum w tr(eps), so that the
// stiffness has a term K/V b b^T with
//
//   b_i = sum w R g_i = R dV_0/dX_i,   V_0(X) the volume at rest of a hexahedron; R turns it as the method does
//
// for each hexahedron, and for each node a between tetrahedra of one bulk modulus with V_a = sum_e V_e/4 and
// b_i = sum_e 1/4 R_e dV_e/dX_i. B that is updated, polarOf, incompatible modes and Green's strain have others, which are left out.
#include <array>
#include <map>

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
  const bool has_others = update_b_ || update_volume_ || incompatible_ || polar_of_ != PolarOf::gradient;
  if (!variant_.mean_dilatation || has_others || variant_.method == ElasticMethod::green || variant_.method == ElasticMethod::nodal) return;
  const std::vector<Vec3>& rest = state().rest_position;
  const ConstRows own = state().x();
  const Index first = state().firstRow();
  if (elements_->kind().type == CellType::hexahedron) {
    std::array<Vec3, 8> gradients;
    for (std::size_t cell = 0; cell < mesh_->hexahedra.size(); ++cell) {
      const auto& corners = mesh_->hexahedra[cell];
      const double volume = turnedVolume(*elements_, cell, corners, rest, own, gradients);
      for (std::size_t a = 0; a < 8; ++a) terms.rows.push_back(first + corners[a]), terms.gradients.push_back(gradients[a]);
      terms.finish(lame(cell).bulk() / volume, lame(cell).mu / volume);
    }
  } else if (elements_->kind().type == CellType::tetrahedron) {
    struct Around {
      double volume = 0, shear = 0, bulk = 0;
      std::map<Index, Vec3> gradients;
    };
    std::map<std::pair<Index, double>, Around> nodes;
    std::array<Vec3, 4> gradients;
    for (std::size_t cell = 0; cell < mesh_->tetrahedra.size(); ++cell) {
      const auto& corners = mesh_->tetrahedra[cell];
      const double volume = turnedVolume(*elements_, cell, corners, rest, own, gradients) / 4;
      for (const Index node : corners) {
        Around& around = nodes[{node, lame(cell).bulk()}];
        around.volume += volume, around.shear += volume * lame(cell).mu, around.bulk = lame(cell).bulk();
        for (std::size_t a = 0; a < 4; ++a) around.gradients.try_emplace(corners[a], Vec3::Zero()).first->second += gradients[a] / 4;
      }
    }
    for (const auto& [key, around] : nodes) {
      for (const auto& [node, gradient] : around.gradients) terms.rows.push_back(first + node), terms.gradients.push_back(gradient);
      terms.finish(around.bulk / around.volume, around.shear / (around.volume * around.volume));
    }
  }
}

}  // namespace stroma
