// SPDX-License-Identifier: LGPL-2.1-or-later
// Viscous bodies under test: a series, cells that are driven by hand, and meshes with a past.
#pragma once
#include <cmath>
#include <string>
#include <vector>

#include "framework/mechanics/history.h"
#include "tests/hyperelasticity/law_cases.h"

namespace stroma::test {

// the liver of Marchesseau et al. 2010
inline constexpr double g0 = 770, alpha[2] = {0.235, 0.333}, tau[2] = {0.27, 0.03};
const std::string prony = " viscous=\"true\" ParameterAlpha=\"0.235 0.333\" ParameterTau=\"0.27 0.03\"";
inline const std::string law = "materialName=\"StVenantKirchhoff\" ParameterSet=\"770 3000\"";
inline const std::vector<std::string> updates{"backward", "exponential"};
inline std::string update(const std::string& word) { return " viscousUpdate=\"" + word + "\""; }

inline const std::string hexahedral = "HexahedronHyperelasticityFEMForceField";
inline const std::string& typeOf(bool cube) { return cube ? hexahedral : tetrahedral; }

/// One element with edges 1 along the axes, driven by hand.
inline std::string oneCell(const std::string& attributes, bool cube = false) {
  const std::string cell =
      cube ? "<HexahedronSetTopologyContainer position=\"0 0 0 1 0 0 1 1 0 0 1 0 0 0 1 1 0 1 1 1 1 0 1 1\" "
             "hexahedra=\"0 1 2 3 4 5 6 7\"/>"
           : "<TetrahedronSetTopologyContainer position=\"0 0 0 1 0 0 0 1 0 0 0 1\" tetrahedra=\"0 1 2 3\"/>";
  return "<Node name=\"root\" dt=\"0.01\"><EulerImplicitSolver/><CGLinearSolver/>" + cell +
         "<MechanicalObject/><UniformMass totalMass=\"1\"/><" + typeOf(cube) + " " + attributes + "/></Node>";
}
/// A block of distorted hexahedra.
inline std::string block(const std::string& attributes) {
  std::string scene = hexahedraScene("", false);
  const auto at = scene.find("<HexahedronFEMForceField");
  return scene.replace(at, scene.find("/>", at) + 2 - at, "<" + hexahedral + " " + attributes + "/>");
}

class Driven {
 public:
  explicit Driven(const std::string& attributes, bool cube = false) : t_(oneCell(attributes, cube), typeOf(cube)) {
    t_.field().reset();
  }
  void startAt(const Mat3& f) { place(f); }
  /// P at the end of a step to `time` that ends with F: of the tetrahedron -6 (f_1 f_2 f_3), of the cube the force on
  /// its faces x_i = 1.
  Mat3 step(double time, const Mat3& f) {
    t_.field().setTime(time);
    place(f);
    const Vector force = t_.forceAt(t_.system().x);
    dynamic_cast<History&>(t_.field()).stepEnded(time);
    Mat3 p = Mat3::Zero();
    for (int i = 0; i < 3; ++i)
      if (force.count() == 4)
        p.col(i) = -6 * Vec3(force[i + 1]);
      else
        for (Index n = 0; n < 8; ++n)
          if (t_.field().state().rest_position[n][i] == 1) p.col(i) -= Vec3(force[n]);
    return p;
  }
  /// S_12 / shear in simple shear, where S_12 of St Venant-Kirchhoff is mu times the shear.
  double shearModulus(double time, double shear, double unit = 1) {
    Mat3 f = Mat3::Identity();
    f(0, 1) = shear;
    return (f.inverse() * step(time, f))(0, 1) / unit;
  }

 private:
  void place(const Mat3& f) {
    t_.rest();
    for (Index i = 0; i < t_.x.count(); ++i) t_.system().x[i] = f * Vec3(t_.x[i]);
  }
  FieldUnderTest t_;
};

inline double modulus(double t) {
  double g = g0;
  for (int i = 0; i < 2; ++i) g -= g0 * alpha[i] * -std::expm1(-t / tau[i]);
  return g;
}

/// A mesh of the repository with a past.
inline void giveHistory(FieldUnderTest& t) {
  History& history = dynamic_cast<History&>(t.field());
  for (int n = 1; n <= 3; ++n) {
    t.field().setTime(0.02 * n);
    t.deform(0.02, unsigned(n));
    copy(t.x, t.system().x);
    history.stepEnded(0.02 * n);
  }
  t.field().setTime(0.08);
  t.deform(0.02, 9);
}

/// Product, matrix and differences of the force `f` agree; with the history held there is a potential, and no resultant.
inline void expectConsistentDerivatives(FieldUnderTest& t, const Vector& f) {
  const double step = 1e-6 * t.typicalEdge();
  if (t.field().traits().exact_tangent) {
    EXPECT_LT(relativeDifference(t.product(t.direction), t.differenceOfForces(step)), 1e-6);
  }
  expectMatrixOfProducts(t);
  expectForceAndProductInOnePass(t);
  expectForceOfEnergy(t, f);
  expectNoResultant(t, f);
}

}  // namespace stroma::test
