// SPDX-License-Identifier: LGPL-2.1-or-later
// Numbers that carry their gradient and Hessian by nine variables, and the energies of all laws written with them from
// the formulas of the literature: F, not J and invariants, is what is differentiated. Their arithmetic is loops over numbers:
// tests are compiled without optimisation, where an expression of matrices takes ten times as long.
#pragma once
#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

namespace stroma::test {

struct Dual {
  double v = 0;
  std::array<double, 9> g{};
  std::array<double, 81> h{};  ///< shape (9, 9)
  Dual(double value = 0) : v(value) {}  // NOLINT: a number is a dual without derivatives
  static Dual variable(double value, int index) {
    Dual d(value);
    d.g[std::size_t(index)] = 1;
    return d;
  }
  /// f(this), from f, f', f''.
  Dual chain(double f, double f1, double f2) const {
    Dual out(f);
    const double *from = g.data(), *second = h.data();
    double *first = out.g.data(), *to = out.h.data();
    for (int j = 0, n = 0; j < 9; ++j) {
      first[j] = f1 * from[j];
      for (int i = 0; i < 9; ++i, ++n) to[n] = f1 * second[n] + f2 * from[i] * from[j];
    }
    return out;
  }
};
inline Dual operator+(const Dual& a, const Dual& b) {
  Dual out(a.v + b.v);
  const double *ag = a.g.data(), *ah = a.h.data(), *bg = b.g.data(), *bh = b.h.data();
  double *g = out.g.data(), *h = out.h.data();
  for (int i = 0; i < 9; ++i) g[i] = ag[i] + bg[i];
  for (int i = 0; i < 81; ++i) h[i] = ah[i] + bh[i];
  return out;
}
inline Dual operator-(const Dual& a) { return a.chain(-a.v, -1, 0); }
inline Dual operator-(const Dual& a, const Dual& b) { return a + (-b); }
inline Dual operator*(const Dual& a, const Dual& b) {
  Dual out(a.v * b.v);
  const double *ag = a.g.data(), *ah = a.h.data(), *bg = b.g.data(), *bh = b.h.data();
  double *g = out.g.data(), *h = out.h.data();
  for (int j = 0, n = 0; j < 9; ++j) {
    g[j] = a.v * bg[j] + b.v * ag[j];
    for (int i = 0; i < 9; ++i, ++n) h[n] = a.v * bh[n] + b.v * ah[n] + ag[i] * bg[j] + bg[i] * ag[j];
  }
  return out;
}
inline Dual pow(const Dual& a, double e) {
  return a.chain(std::pow(a.v, e), e * std::pow(a.v, e - 1), e * (e - 1) * std::pow(a.v, e - 2));
}
inline Dual operator/(const Dual& a, const Dual& b) { return a * pow(b, -1); }
inline Dual exp(const Dual& a) { return a.chain(std::exp(a.v), std::exp(a.v), std::exp(a.v)); }
inline Dual log(const Dual& a) { return a.chain(std::log(a.v), 1 / a.v, -1 / (a.v * a.v)); }
inline Dual sqrt(const Dual& a) { return pow(a, 0.5); }
inline Dual cos(const Dual& a) { return a.chain(std::cos(a.v), -std::sin(a.v), -std::cos(a.v)); }
inline Dual acos(const Dual& a) {
  const double s = 1 - a.v * a.v;
  return a.chain(std::acos(a.v), -1 / std::sqrt(s), -a.v / (s * std::sqrt(s)));
}

/// Plain numbers through the same formulas.
using DualMatrix = std::array<std::array<Dual, 3>, 3>;

inline DualMatrix variables(const Eigen::Matrix3d& f) {
  DualMatrix d;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) d[i][j] = Dual::variable(f(i, j), 3 * i + j);
  return d;
}

/// What energies are written in: J, C, its invariants and eigenvalues (these must differ).
struct Strain {
  Dual j, i1, i2;
  DualMatrix c;
  explicit Strain(const DualMatrix& f) {
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t k = 0; k < 3; ++k) c[i][k] = f[0][i] * f[0][k] + f[1][i] * f[1][k] + f[2][i] * f[2][k];
    j = determinant(f);
    i1 = trace(c);
    i2 = 0.5 * (i1 * i1 - trace(product(c, c)));
  }
  static Dual determinant(const DualMatrix& m) {
    return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
           m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
  }
  static Dual trace(const DualMatrix& m) { return m[0][0] + m[1][1] + m[2][2]; }
  static DualMatrix product(const DualMatrix& a, const DualMatrix& b) {
    DualMatrix out;
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t k = 0; k < 3; ++k) out[i][k] = a[i][0] * b[0][k] + a[i][1] * b[1][k] + a[i][2] * b[2][k];
    return out;
  }
  /// Cardano's formula.
  std::array<Dual, 3> eigenvalues() const {
    const Dual mean = i1 / 3;
    DualMatrix d = c;
    for (std::size_t i = 0; i < 3; ++i) d[i][i] = d[i][i] - mean;
    const Dual p = sqrt(trace(product(d, d)) / 6);
    const Dual angle = acos(determinant(d) / (2 * p * p * p)) / 3;
    std::array<Dual, 3> out;
    for (int k = 0; k < 3; ++k) out[k] = mean + 2 * p * cos(angle + 2 * M_PI / 3 * k);
    return out;
  }
};

/// The energy density of a law; F in the axes of its fibres.
inline Dual referenceEnergy(const std::string& law, const std::vector<double>& p, const DualMatrix& f) {
  const Strain s(f);
  const Dual &J = s.j, &I1 = s.i1, &I2 = s.i2;
  if (law == "StVenantKirchhoff") {
    DualMatrix e = s.c;
    for (std::size_t i = 0; i < 3; ++i) e[i][i] = e[i][i] - 1;
    for (auto& row : e)
      for (Dual& v : row) v = 0.5 * v;
    const Dual trace = Strain::trace(e);
    return 0.5 * p[1] * trace * trace + p[0] * Strain::trace(Strain::product(e, e));
  }
  if (law == "StableNeoHookean") {
    const double a = 1 + p[0] / (p[1] + p[0]);
    return 0.5 * p[0] * (I1 - 3) + 0.5 * (p[0] + p[1]) * ((J - a) * (J - a) - (1 - a) * (1 - a));
  }
  const Dual L = log(J), i1 = pow(J, -2. / 3) * I1, i2 = pow(J, -4. / 3) * I2;
  if (law == "NeoHookean") return 0.5 * p[0] * (I1 - 3) - p[0] * L + 0.5 * p[1] * L * L;
  if (law == "MooneyRivlin") return p[0] * (i1 - 3) + p[1] * (i2 - 3) + 0.5 * p[2] * L * L;
  if (law == "VerondaWestman")
    return p[0] * (exp(p[1] * (i1 - 3)) - 1) - 0.5 * p[0] * p[1] * (i2 - 3) + 0.5 * p[2] * L * L;
  if (law == "ArrudaBoyce") {
    const double c[5] = {0.5, 1. / 160, 11. / 67200, 19. / 3584000, 519. / 2759680000.};
    Dual sum = 0.5 * p[1] * L * L;
    for (int n = 1; n <= 5; ++n) sum = sum + p[0] * c[n - 1] * (pow(i1, n) - std::pow(3, n));
    return sum;
  }
  if (law == "Ogden") {
    const auto c = s.eigenvalues();
    Dual sum = 0.5 * p.back() * L * L;
    for (std::size_t k = 0; k + 1 < p.size(); k += 2)
      for (const Dual& value : c)
        sum = sum + p[k] / (p[k + 1] * p[k + 1]) * (pow(pow(J, -2. / 3) * value, 0.5 * p[k + 1]) - 1);
    return sum;
  }
  if (law == "Costa") {
    const auto square = [&](std::size_t i, std::size_t k) {
      const Dual e = 0.5 * (s.c[i][k] - (i == k ? 1 : 0));
      return e * e;
    };
    const Dual q = p[2] * square(0, 0) + p[4] * square(1, 1) + p[7] * square(2, 2) + 2 * p[3] * square(0, 1) +
                   2 * p[5] * square(0, 2) + 2 * p[6] * square(1, 2);
    return 0.5 * p[0] * (exp(pow(J, -4. / 3) * q) - 1) + p[1] * (J * L - J + 1);
  }
  if (law == "TransverselyIsotropic") {
    const Dual stretch = pow(J, -2. / 3) * s.c[0][0] - 1;
    const Dual fibres = stretch.v > 0 ? p[2] / (2 * p[3]) * (exp(p[3] * stretch * stretch) - 1) : Dual(0);
    return 0.5 * p[0] * (I1 - 3) - p[0] * L + 0.5 * p[1] * L * L + fibres;
  }
  if (law == "Yeoh") {
    Dual sum = 0.5 * p.back() * L * L, power = 1;
    for (std::size_t k = 0; k + 1 < p.size(); ++k) power = power * (i1 - 3), sum = sum + p[k] * power;
    return sum;
  }
  if (law == "Hencky") {
    Dual sum = 0.5 * p[1] * L * L;
    for (const Dual& value : s.eigenvalues()) sum = sum + 0.25 * p[0] * log(value) * log(value);
    return sum;
  }
  if (law == "OgdenUnconstrained") {
    const auto c = s.eigenvalues();
    Dual sum = 0.5 * p.back() * (J - 1) * (J - 1);
    for (std::size_t k = 0; k + 1 < p.size(); k += 2) {
      const double factor = p[k] / (p[k + 1] * p[k + 1]);
      for (const Dual& value : c) sum = sum + factor * (pow(value, 0.5 * p[k + 1]) - 1);
      sum = sum - factor * p[k + 1] * L;
    }
    return sum;
  }
  if (law == "FungOrthotropic") {
    Eigen::Matrix3d compliance;
    compliance << 1 / p[0], -p[6] / p[0], -p[8] / p[2], -p[6] / p[0], 1 / p[1], -p[7] / p[1], -p[8] / p[2],
        -p[7] / p[1], 1 / p[2];
    const Eigen::Matrix3d n = compliance.inverse();
    const auto e = [&](std::size_t i, std::size_t k) { return 0.5 * (pow(J, -2. / 3) * s.c[i][k] - (i == k ? 1 : 0)); };
    Dual q = 4 * p[3] * e(0, 1) * e(0, 1) + 4 * p[4] * e(1, 2) * e(1, 2) + 4 * p[5] * e(2, 0) * e(2, 0);
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t k = 0; k < 3; ++k) q = q + n(Eigen::Index(i), Eigen::Index(k)) * e(i, i) * e(k, k);
    return 0.5 * p[9] * (exp(q / p[9]) - 1) + 0.5 * p[10] * L * L;
  }
  if (law == "TransverselyIsotropicMooneyRivlin") {
    const Dual stretch = pow(J, -1. / 3) * sqrt(s.c[0][0]);
    const double l = stretch.v, end = p[5];
    Dual fibres = 0;
    const auto toe = [&](double x) {
      return p[2] * (std::exp(-p[3]) * (std::expint(p[3] * x) - std::expint(p[3])) - std::log(x));
    };
    if (l > 1 && l < end) {
      const double g = std::exp(p[3] * (l - 1)), force = p[2] * (g - 1) / l;
      fibres = stretch.chain(toe(l), force, (p[2] * p[3] * g - force) / l);
    } else if (l >= end) {
      const double c6 = p[2] * (std::exp(p[3] * (end - 1)) - 1) - p[4] * end;
      fibres = toe(end) + p[4] * (stretch - end) + c6 * log(stretch / end);
    }
    return p[0] * (i1 - 3) + p[1] * (i2 - 3) + fibres + 0.5 * p[6] * L * L;
  }
  throw std::invalid_argument("no formula of " + law);
}

}  // namespace stroma::test
