// SPDX-License-Identifier: LGPL-2.1-or-later
// Fung's orthotropic exponential: W = c/2 (exp(Q) - 1) + k0/2 (ln J)^2,
//   Q = (sum_ab N_ab E_aa E_bb + 4 (G12 E12^2 + G23 E23^2 + G31 E31^2))/c,   E = (J^-2/3 C - Id)/2
// in the axes 1, 2, 3 = fibre, sheet, normal of AnisotropyDirections. N is the stiffness of Hooke's orthotropic law,
//   N^-1 = 1/E1 -v12/E1 -v31/E3
//               1/E2    -v23/E2
//                       1/E3
// so that small changes of shape meet the moduli E and G; those of volume meet k0. Infinite at J = 0. Names and order
// are those of FEBio's "Fung orthotropic". Source: Y. C. Fung, K. Fronek, P. Patitucci, "Pseudoelasticity of arteries
// and the choice of its mathematical expression", American Journal of Physiology 237 (1979) H620-H631; G. A.
// Ateshian, K. D. Costa, "A frame-invariant formulation of Fung elasticity", Journal of Biomechanics 42 (2009) 781-785.
#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "components/hyperelasticity/hyperelastic_kernels.h"

using namespace stroma;
using namespace stroma::hyperelastic;

namespace {

/// A of Hooke's orthotropic law [Pa], in the material's axes.
template <class T>
struct OrthotropicStiffness {
  T n11, n22, n33, n12, n23, n31, g12, g23, g31;
  /// A : E
  S3<T> times(const S3<T>& e) const {
    const T two(2.);
    return {stroma::fma(n11, e.xx, stroma::fma(n12, e.yy, n31 * e.zz)),
            stroma::fma(n12, e.xx, stroma::fma(n22, e.yy, n23 * e.zz)),
            stroma::fma(n31, e.xx, stroma::fma(n23, e.yy, n33 * e.zz)),
            two * g12 * e.xy,
            two * g23 * e.yz,
            two * g31 * e.zx};
  }
};

/// J, q = E : A : E and l = Id : A : E of Green's strain E. With s = J^-2/3 the strain of the change of shape is
/// s E + (s - 1)/2 Id, which keeps its digits where it is small.
struct OrthotropicStrain {
  static constexpr bool anisotropic = true;
  template <class T>
  struct Point : VolumePoint<T> {
    OrthotropicStiffness<T> stiffness;
    S3<T> of_strain;     ///< A : E = dq/dC
    S3<T> of_half_unit;  ///< A : Id/2 = dl/dC
    T q, l;
    template <class Parameters>
    Point(const M3<T>& deformation, const Parameters& parameters)
        : VolumePoint<T>(deformation), stiffness(parameters.stiffness) {
      const T half(0.5);
      S3<T> e = metric(deformation) * half;
      e.xx -= half, e.yy -= half, e.zz -= half;
      of_strain = stiffness.times(e), of_half_unit = stiffness.times(unit<T>() * half);
      q = dot(of_strain, e), l = of_strain.xx + of_strain.yy + of_strain.zz;
    }
    auto invariants() const { return std::tie(this->j, q, l); }
  };
  template <class T>
  static S3<T> secondStress(const Point<T>& p, const auto& w) {
    return p.of_strain * (2. * w.b) + p.of_half_unit * (2. * w.c);
  }
  template <class T>
  static M3<T> stress(const Point<T>& p, const auto& w) {
    return timesSymmetric(p.f, secondStress(p, w)) + scaled(w.a, p.cof);
  }
  template <class T>
  static M3<T> differential(const Point<T>& p, const auto& w, const M3<T>& df) {
    const S3<T> dc = metricDifferential(p.f, df);
    const T dq = dot(p.of_strain, dc), dl = dot(p.of_half_unit, dc), dj = dot(p.cof, df);
    const T dquadratic = w.ab * dj + (w.bb * dq + w.bc * dl), dlinear = w.ac * dj + (w.bc * dq + w.cc * dl);
    const T dvolume = w.aa * dj + (w.ab * dq + w.ac * dl);
    const S3<T> ds = p.of_strain * (2. * dquadratic) + p.of_half_unit * (2. * dlinear) + p.stiffness.times(dc) * w.b;
    return (timesSymmetric(df, secondStress(p, w)) + timesSymmetric(p.f, ds)) +
           (scaled(w.a, cofactorDifferential(p.f, df)) + scaled(dvolume, p.cof));
  }
  template <class T>
  static void gradients(const Point<T>& p, S3<T> (&a)[3]) {
    a[0] = p.of_strain, a[1] = p.of_half_unit;
  }
  /// 2 psi_q A: dS = 2 psi_q A : dE, doubled shear halves.
  template <class T>
  static void curvature(const Point<T>& p, const auto& w, Elasticity<T>& d) {
    const T twice = 2. * w.b;
    for (int k = 0; k < 6; ++k) {
      S3<T> e;
      T* const entry[6] = {&e.xx, &e.yy, &e.zz, &e.xy, &e.yz, &e.zx};
      *entry[k] = T(k < 3 ? 1. : 0.5);
      T column[6];
      list(p.stiffness.times(e), column);
      for (int i = 0; i < 6; ++i) d.d[i][k] += twice * column[i];
    }
  }
};

struct FungOrthotropic {
  using Set = OrthotropicStrain;
  template <class T>
  struct Parameters {
    OrthotropicStiffness<T> stiffness;
    T sum;  ///< Id : A : Id
    T c, k0;
  };
  static Parameters<double> read(Values values);
  static auto energy(const auto& J, const auto& q, const auto& l, const auto& p) {
    const auto L = log(J);
    const auto s = exp((-2. / 3) * L);
    const auto change = s - 1.;
    const auto of_shape = s * s * q + s * change * l + (0.25 * p.sum) * (change * change);
    return 0.5 * p.c * (exp((1. / p.c) * of_shape) - 1.) + 0.5 * p.k0 * (L * L);
  }
};

// ---- parameters: E1 E2 E3 G12 G23 G31 v12 v23 v31 c k0 ----

/// N^-1
Mat3 compliance(Values p) {
  const double s12 = -p[6] / p[0], s23 = -p[7] / p[1], s31 = -p[8] / p[2];
  Mat3 s;
  s << 1 / p[0], s12, s31, s12, 1 / p[1], s23, s31, s23, 1 / p[2];
  return s;
}

FungOrthotropic::Parameters<double> FungOrthotropic::read(Values p) {
  const Mat3 n = compliance(p).inverse();
  return {{n(0, 0), n(1, 1), n(2, 2), n(0, 1), n(1, 2), n(0, 2), p[3], p[4], p[5]}, n.sum(), p[9], p[10]};
}

std::string check(Values p) {
  if (Eigen::LLT<Mat3>(compliance(p)).info() == Eigen::Success) return {};
  return fmt::format(
      "v12 = {}, v23 = {} and v31 = {} of FungOrthotropic make a change of shape without a resistance: the matrix of "
      "1/E1, 1/E2, 1/E3 and -v12/E1, -v23/E2, -v31/E3 is not positive definite",
      p[6], p[7], p[8]);
}

}  // namespace

STROMA_COMPONENT(fung_orthotropic) {
  HyperelasticLaw law = withBulkModulus(
      lawOf<FungOrthotropic>("FungOrthotropic",
                             "c/2 (exp(Q) - 1) + k0/2 (ln J)^2, Q = E : A : E/c of E = (J^-2/3 C - Id)/2",
                             {{"E1", "Pa", "Young's modulus along the fibre", true},
                              {"E2", "Pa", "along the sheet", true},
                              {"E3", "Pa", "along the normal", true},
                              {"G12", "Pa", "shear modulus between fibre and sheet", true},
                              {"G23", "Pa", "between sheet and normal", true},
                              {"G31", "Pa", "between normal and fibre", true},
                              {"v12", "-", "Poisson's ratio: contraction of the sheet under tension of the fibre"},
                              {"v23", "-", "contraction of the normal under tension of the sheet"},
                              {"v31", "-", "contraction of the fibre under tension of the normal"},
                              {"c", "Pa", "factor of the exponential: the larger, the later it stiffens", true}}),
      nullptr);
  law.directions = 3;
  law.check = check;
  offerHyperelasticLaw(law);
}
