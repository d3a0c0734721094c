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
  template <int rows, int columns>
  using Few = Eigen::Matrix<double, rows, columns, 0, rows < 0 ? most : rows, columns < 0 ? most : columns>;
  using Own = Few<-1, 1>;                              ///< a_xi, a_eta, a_zeta, b
  using Corners = Eigen::Matrix<double, 21, 1>;        ///< numbers of Modes
  using Condensed = Eigen::Matrix<double, 21, 21>;     ///< K [N/m]
  using Strain = Eigen::Matrix<double, 6, 1>;          ///< xx yy zz 2xy 2yz 2zx
  using OfCorners = Eigen::Matrix<double, 6, 21>;      ///< B
  using OfOwn = Few<6, -1>;                            ///< G

  IncompatibleModes(const Modes<double>& rest, const Lame& material, bool mean_dilatation)
      : law_(material), count_(mean_dilatation ? 12 : 9) {
    const Mat3 centre = toEigen(M3<double>{rest.xi, rest.eta, rest.zeta}) / 8;
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
    const PointValues<double> change = atPoints(u);
    Few<-1, -1> k = Few<-1, -1>::Zero(count_, count_);
    Own force = Own::Zero(count_);
    for (int p = 0; p < 8; ++p) {
      const OfOwn g = ofOwn(p), stress = std::abs(determinants_[p]) * stressOf(g);
      const Mat3 h = toEigen(Columns<double>(change, p).matrix()) / 8 * gradients_[p];
      k.noalias() += g.transpose() * stress;
      force.noalias() -= stress.transpose() * strainOfGradient(h);
    }
    return k.ldlt().solve(force);
  }
  /// K of the corners; zero without stiffness.
  Condensed condensed() const {
    Condensed uu = Condensed::Zero();
    if (!(law_.mu > 0)) return uu;
    Few<-1, 21> au = Few<-1, 21>::Zero(count_, 21);
    Few<-1, -1> aa = Few<-1, -1>::Zero(count_, count_);
    OfCorners b[8];
    findOfCorners(b);
    for (int p = 0; p < 8; ++p) {
      const double weight = std::abs(determinants_[p]);
      const OfOwn g = ofOwn(p), stress = weight * stressOf(g);
      const OfCorners of_corners = weight * stressOf(b[p]);
      uu.noalias() += b[p].transpose() * of_corners;
      au.noalias() += stress.transpose() * b[p];
      aa.noalias() += g.transpose() * stress;
    }
    uu.noalias() -= au.transpose() * aa.ldlt().solve(au);
    return uu;
  }

 private:
  double factor(int p, int q) const {
    const double place = (p >> q & 1) ? gauss : -gauss;
    return -2 * place * centre_determinant_ / determinants_[p];
  }
  /// Of b_q.
  double swelling(int p, int q) const {
    const auto sign = [p](int axis) { return (p >> axis % 3 & 1) ? gauss : -gauss; };
    return sign(q + 1) * sign(q + 2) * centre_determinant_ / determinants_[p];
  }
  static Strain strainOfGradient(const Mat3& h) {
    Strain strain;
    strain << h(0, 0), h(1, 1), h(2, 2), h(0, 1) + h(1, 0), h(1, 2) + h(2, 1), h(2, 0) + h(0, 2);
    return strain;
  }
  template <class Strains>
  Strains stressOf(const Strains& strains) const {
    Strains stress = law_.mu * strains;
    stress.template topRows<3>() *= 2;
    stress.template topRows<3>().rowwise() += law_.lambda * strains.template topRows<3>().colwise().sum();
    return stress;
  }
  OfOwn ofOwn(int p) const {
    OfOwn g(6, count_);
    for (int i = 0; i < 9; ++i) g.col(i) = strainOfGradient(factor(p, i / 3) * Vec3::Unit(i % 3) * centre_gradients_.row(i / 3));
    for (int q = 9; q < count_; ++q) g.col(q) = swelling(p, q - 9) * strainOfGradient(Mat3::Identity());
    return g;
  }
  void findOfCorners(OfCorners (&b)[8]) const {
    for (int mode = 0; mode < 7; ++mode) {
      Modes<double> one{};  // its x alone: the derivatives of the mode
      V3<double>* const of[7] = {&one.xi, &one.eta, &one.zeta, &one.xi_eta, &one.eta_zeta, &one.zeta_xi, &one.all};
      of[mode]->x = 1;
      const PointValues<double> derivatives = atPoints(one);
      for (int p = 0; p < 8; ++p) {
        const Columns<double> c(derivatives, p);
        const Eigen::RowVector3d gradient = Eigen::RowVector3d(c.d[0].x, c.d[1].x, c.d[2].x) / 8 * gradients_[p];
        for (int axis = 0; axis < 3; ++axis) b[p].col(3 * mode + axis) = strainOfGradient(Vec3::Unit(axis) * gradient);
      }
    }
  }

  Lame law_;
  int count_;  ///< of modes
  Mat3 centre_gradients_, gradients_[8];  ///< J_c^-1 and J^-1 [1/m]
  double centre_determinant_, determinants_[8];
};

}  // namespace stroma::hexahedron
