// SPDX-License-Identifier: LGPL-2.1-or-later
// Incompatible modes of a hexahedron of any shape. Beside what its corners do, the displacement in a cell has the modes
// 1 - xi^2, 1 - eta^2 and 1 - zeta^2 with a vector a_q each (Wilson et al. 1973). Nothing holds these nine numbers but the cell
// itself, so they are where its energy is least. Their displacement gradient is
//   H = (det J_c / det J) sum_q -2 xi_q a_q (x) c_q,   c_q the gradient of xi_q at the centre,
// with J_c = J at the centre: it has no mean over the cell, so that constant strains are held as before (Taylor, Beresford and
// Wilson 1976). Simo and Rifai's enhanced strains (1990) with these nine functions are the same. With B of the modes u of the corners
// and G of a,
//   K_uu = sum w B^T D B,  K_au = sum w G^T D B,  K_aa = sum w G^T D G,   a = -K_aa^-1 K_au u,   K = K_uu - K_au^T K_aa^-1 K_au.
// With dilatation = mean there are three more, (det J_c / det J) b_q I with the functions eta zeta, zeta xi and xi eta (Simo, Armero
// and Taylor 1993): they take the volume change that the nine leave to the corners, which locks near nu = 1/2.
#pragma once
#include <Eigen/Cholesky>
#include <Eigen/LU>

#include <memory>

#include "components/elasticity/hexahedron_modes.h"
#include "framework/fem/eigen_matrix.h"
#include "framework/fem/element_kernels.h"
#include "framework/fem/hexahedron.h"
#include "framework/fem/isotropic.h"

namespace stroma::hexahedron {

struct Elements;
/// Cells with incompatible modes, methods small, large, polar and svd: hexahedron_condensed.cpp.
std::unique_ptr<ElementKernels> incompatibleKernels(const Elements& elements);

/// In the frame of the rest shape `modes`. Vectors of modes in the order of Modes, x y z of each.
class IncompatibleModes {
 public:
  static constexpr int most = 12;
  using Own = Eigen::Matrix<double, -1, 1, 0, most, 1>;  ///< a_xi, a_eta, a_zeta, b
  using Condensed = Eigen::Matrix<double, 21, 21>;       ///< K [N/m]

  IncompatibleModes(const Modes<double>& rest, const Lame& material, bool mean_dilatation)
      : law_(material), count_(mean_dilatation ? 12 : 9) {
    const Mat3 centre = toEigen(meanEdges(rest)) / 8;
    const PointValues<double> points = atPoints(rest);
    centre_gradients_ = centre.inverse(), centre_determinant_ = centre.determinant();
    for (int p = 0; p < 8; ++p) {
      const Mat3 j = toEigen(Columns<double>(points, p).matrix()) / 8;
      gradients_[p] = j.inverse(), determinants_[p] = j.determinant();
    }
  }

  /// H of a at Gauss point p.
  Mat3 gradient(const Own& a, int p) const {
    Mat3 h = Mat3::Zero();
    for (int q = 0; q < 3; ++q) h += factor(p, q) * a.segment<3>(3 * q) * centre_gradients_.row(q);
    for (int q = 9; q < count_; ++q) h += a[q] * swelling(p, q - 9) * Mat3::Identity();
    return h;
  }
  /// a where the corners have the modes u; zero in a cell without stiffness.
  Own settled(const Modes<double>& u) const {
    if (!(law_.mu > 0)) return Own::Zero(count_);
    Eigen::Matrix<double, 21, 1> corners;
    int i = 0;
    forEachMode(u, u, [&](const V3<double>& v, const V3<double>&) { corners.segment<3>(3 * i++) << v.x, v.y, v.z; });
    const Whole k = whole();
    return own(k).ldlt().solve(-couplings(k) * corners);
  }
  /// K of the corners; zero without stiffness.
  Condensed condensed() const {
    if (!(law_.mu > 0)) return Condensed::Zero();
    const Whole k = whole();
    const Coupling au = couplings(k);
    return k.topLeftCorner<21, 21>() - au.transpose() * own(k).ldlt().solve(au);
  }

 private:
  /// K of the corners' modes, a and b before anything is condensed, lower triangle; the last three stay zero where there are nine.
  using Whole = Eigen::Matrix<double, 21 + most, 21 + most>;
  using Coupling = Eigen::Matrix<double, -1, 21, 0, most, 21>;
  using Square = Eigen::Matrix<double, -1, -1, 0, most, most>;

  Coupling couplings(const Whole& k) const { return k.block(21, 0, count_, 21); }
  Square own(const Whole& k) const { return k.block(21, 21, count_, count_).selfadjointView<Eigen::Lower>(); }

  /// Displacement gradients v (x) g and w (x) h do the work v . (lambda g h^T + mu (h g^T + (g . h) I)) w, and with a swelling s I it is
  /// (3 lambda + 2 mu) s (v . g).
  Whole whole() const {
    Whole k = Whole::Zero();
    const double bulk = 3 * law_.lambda + 2 * law_.mu;
    for (int p = 0; p < 8; ++p) {
      const double weight = std::abs(determinants_[p]);
      Vec3 g[10];
      findGradients(p, g);
      for (int i = 0; i < 10; ++i)
        for (int j = 0; j <= i; ++j) {
          const double both = weight * law_.mu * g[i].dot(g[j]);
          auto block = k.block<3, 3>(3 * i, 3 * j);
          block += weight * (law_.lambda * g[i] * g[j].transpose() + law_.mu * g[j] * g[i].transpose());
          block.diagonal().array() += both;
        }
      for (int q = 9; q < count_; ++q) {
        const double stress = weight * bulk * swelling(p, q - 9);
        for (int i = 0; i < 10; ++i) k.block<1, 3>(21 + q, 3 * i) += stress * g[i].transpose();
        for (int r = 9; r <= q; ++r) k(21 + q, 21 + r) += 3 * stress * swelling(p, r - 9);
      }
    }
    k.triangularView<Eigen::StrictlyUpper>() = k.transpose();
    return k;
  }
  /// The gradients of the seven modes of corners at Gauss point p, and those that a is multiplied with.
  void findGradients(int p, Vec3 (&g)[10]) const {
    const double x = sign(p, 0), y = sign(p, 1), z = sign(p, 2);
    const Vec3 along_axes[7] = {Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ(), {y, x, 0}, {0, z, y}, {z, 0, x}, {y * z, z * x, x * y}};
    for (int m = 0; m < 7; ++m) g[m] = gradients_[p].transpose() * along_axes[m] / 8;
    for (int q = 0; q < 3; ++q) g[7 + q] = factor(p, q) * centre_gradients_.row(q).transpose();
  }
  static double sign(int p, int axis) { return (p >> axis & 1) ? gauss : -gauss; }
  double factor(int p, int q) const { return -2 * sign(p, q) * centre_determinant_ / determinants_[p]; }
  /// Of b_q.
  double swelling(int p, int q) const {
    return sign(p, (q + 1) % 3) * sign(p, (q + 2) % 3) * centre_determinant_ / determinants_[p];
  }

  Lame law_;
  int count_;  ///< of modes
  Mat3 centre_gradients_, gradients_[8];  ///< J_c^-1 and J^-1 [1/m]
  double centre_determinant_, determinants_[8];
};

}  // namespace stroma::hexahedron
