// SPDX-License-Identifier: LGPL-2.1-or-later
// Materials that are components: their stresses against the formulas of their page, on one cell of each kind; where a field finds
// its material, and what it says when there is none.
#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>

#include "tests/support/field_derivatives.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

const std::string type = "HyperelasticityFEMForceField";
const std::string tetrahedron = "<TetrahedronSetTopologyContainer position='0 0 0 1 0 0 0 1 0 0 0 1' tetrahedra='0 1 2 3'/>";
const std::string cube =
    "<HexahedronSetTopologyContainer position='0 0 0 1 0 0 1 1 0 0 1 0 0 0 1 1 0 1 1 1 1 0 1 1' hexahedra='0 1 2 3 4 5 6 7'/>";

std::string sceneOf(const std::string& cells, const std::string& parts) {
  return "<Node name='root' dt='0.01'><EulerImplicitSolver/><CGLinearSolver/>" + cells +
         "<MechanicalObject/><UniformMass totalMass='1'/>" + parts + "</Node>";
}
std::string field(const std::string& attributes = "") { return "<" + type + " " + attributes + "/>"; }

struct MaterialCase {
  std::string element;
  std::function<Mat3(const Mat3& c)> stress;  ///< S of C
};

const double mu = 2e4 / 2.6, lambda = 2e4 * 0.3 / (1.3 * 0.4);
double logJ(const Mat3& c) { return std::log(c.determinant()) / 2; }
double secondInvariant(const Mat3& c) { return (c.trace() * c.trace() - (c * c).trace()) / 2; }

std::vector<MaterialCase> materialCases() {
  const Mat3 one = Mat3::Identity();
  return {{"<NeoHookeanMaterial youngModulus='2e4' poissonRatio='0.3'/>",
           [=](const Mat3& c) -> Mat3 { return mu * (one - c.inverse()) + lambda * logJ(c) * c.inverse(); }},
          {"<StVenantKirchhoffMaterial youngModulus='2e4' poissonRatio='0.3'/>",
           [=](const Mat3& c) -> Mat3 { return lambda / 2 * (c - one).trace() * one + mu * (c - one); }},
          {"<MooneyRivlinMaterial mu10='2000' mu01='1500' bulkModulus='3e4'/>",
           [=](const Mat3& c) -> Mat3 {
             const double l = logJ(c);
             return 4000 * std::exp(-2 * l / 3) * (one - c.trace() / 3 * c.inverse()) +
                    3000 * std::exp(-4 * l / 3) * (c.trace() * one - c - 2. / 3 * secondInvariant(c) * c.inverse()) +
                    3e4 * l * c.inverse();
           }},
          {"<OgdenMaterial mu='4000' alpha='3.5' kappa='3e4'/>",
           [=](const Mat3& c) -> Mat3 {
             const Eigen::SelfAdjointEigenSolver<Mat3> solver(c);
             const Vec3 powers = solver.eigenvalues().array().pow(3.5 / 2 - 1);
             const Mat3 power = solver.eigenvectors() * powers.asDiagonal() * solver.eigenvectors().transpose();
             return 4000 / 3.5 * std::exp(-3.5 / 3 * logJ(c)) * (power - (power * c).trace() / 3 * c.inverse()) +
                    3e4 * logJ(c) * c.inverse();
           }},
          {"<IncompressibleMooneyRivlinMaterial mu10='2000' mu01='1500'/>",
           [=](const Mat3& c) -> Mat3 { return 4000 * one + 3000 * (c.trace() * one - c); }}};
}

/// P of a cell that is deformed by F everywhere: f_i = -P e_i / 6 of the tetrahedron, P e_i on each side of the cube.
Mat3 firstStress(FieldUnderTest& t, const Mat3& f) {
  t.rest();
  for (Index i = 0; i < t.x.count(); ++i) t.x[i] = f * Vec3(t.x[i]);
  const Vector force = t.force();
  Mat3 p = Mat3::Zero();
  for (int i = 0; i < 3; ++i)
    for (Index n = 0; n < t.x.count(); ++n)
      if (t.field().state().rest_position[n][i] == 1) p.col(i) -= (t.x.count() == 4 ? 6 : 1) * Vec3(force[n]);
  return p;
}

TEST(HyperelasticMaterials, StressesOfTheirFormulas) {
  const std::vector<Mat3> deformations{Mat3::Identity(), Vec3(1.3, 0.9, 1.05).asDiagonal(),
                                       (Mat3() << 1.2, 0.3, -0.1, -0.2, 0.9, 0.25, 0.15, -0.3, 1.1).finished()};
  for (const MaterialCase& material : materialCases())
    for (const std::string& cells : {tetrahedron, cube})
      for (const std::string form : {"dilatation='local'", "dilatation='local' projectedTangent='true'", "dilatation='auto'"}) {
        SCOPED_TRACE(material.element + form);
        FieldUnderTest t(sceneOf(cells, material.element + field(form)), type);
        for (const Mat3& f : deformations) {
          const Mat3 expected = f * material.stress(f.transpose() * f);
          EXPECT_LT((firstStress(t, f) - expected).norm(), 1e-10 * (expected.norm() + 1)) << f;
        }
      }
}

TEST(HyperelasticMaterials, ForcesFollowTheEnergyAndTangentsTheForces) {
  for (const MaterialCase& material : materialCases())
    for (const bool quadratic : {false, true}) {
      SCOPED_TRACE(material.element);
      const std::string local = "dilatation='local'";
      std::string scene = quadratic ? quadraticScene(local, type) : sceneOf(cube, material.element + field(local));
      if (quadratic) scene.insert(scene.find("<" + type), material.element);
      FieldUnderTest t(scene, type);
      t.deform(0.01);
      const double step = 1e-6 * t.typicalEdge();
      const Vector f = t.force();
      expectForceOfEnergy(t, f);
      EXPECT_LT(relativeDifference(t.product(t.direction), t.differenceOfForces(step)), 1e-6);
      expectMatrixOfProducts(t);
      expectSymmetricProducts(t);
    }
}

/// The one that is linked, that of the node, or the nearest above.
TEST(HyperelasticMaterials, AFieldFindsItsMaterial) {
  const std::string soft = "<NeoHookeanMaterial name='soft' youngModulus='1e3' poissonRatio='0.3'/>";
  const std::string stiff = "<NeoHookeanMaterial name='stiff' youngModulus='1e4' poissonRatio='0.3'/>";
  const auto stretched = [](const std::string& parts) {
    FieldUnderTest t(sceneOf(tetrahedron, parts), type);
    return firstStress(t, Vec3(1.1, 1, 1).asDiagonal())(0, 0);
  };
  const double of_soft = stretched(soft + field()), of_stiff = stretched(field() + stiff);
  EXPECT_NEAR(of_stiff, 10 * of_soft, 1e-10 * of_stiff);
  EXPECT_EQ(stretched(soft + field("material='@stiff'") + stiff), of_stiff);
  EXPECT_EQ(stretched(stiff + "<Node name='below'>" + field() + "</Node>"), of_stiff);
  EXPECT_EQ(stretched(stiff + "<Node name='below'>" + soft + field() + "</Node>"), of_soft);
  EXPECT_EQ(stretched("<Node name='beside'>" + soft + "</Node>" + field("material='@beside/soft'")), of_soft);
}

/// In a run too, with what steps have left behind: here the strains of a viscous part.
TEST(HyperelasticMaterials, AFieldFollowsItsMaterialInARun) {
  const std::string viscous =
      field("viscous='true' ParameterAlpha='0.5' ParameterTau='0.1'") + "<FixedProjectiveConstraint indices='0 1 2'/>";
  const auto started = [&](const std::string& young) {
    return simulationFromText(sceneOf(tetrahedron, "<NeoHookeanMaterial name='tissue' youngModulus='" + young +
                                                       "' poissonRatio='0.3'/>" + viscous));
  };
  Simulation stiff = started("1e4"), changed = started("1e3");
  changed.setAttribute("/tissue", "youngModulus", "1e4");
  for (int i = 0; i < 5; ++i) stiff.step(), changed.step();
  EXPECT_EQ(changed.stateHash(), stiff.stateHash());
  stiff.setAttribute("/tissue", "youngModulus", "1e4");  // nothing is new, and nothing is forgotten
  for (int i = 0; i < 5; ++i) stiff.step(), changed.step();
  EXPECT_EQ(changed.stateHash(), stiff.stateHash());
  EXPECT_THROW(stiff.setAttribute("/tissue", "poissonRatio", "0.5"), ComponentError);
  for (int i = 0; i < 5; ++i) stiff.step(), changed.step();
  EXPECT_EQ(changed.stateHash(), stiff.stateHash()) << "the old value stays";
  changed.setAttribute("/tissue", "youngModulus", "2e3");
  stiff.step(), changed.step();
  EXPECT_NE(changed.stateHash(), stiff.stateHash());
}

/// Without a viscous part the shape alone decides: from one place on, a run with a new value is one that began with it there.
TEST(HyperelasticMaterials, ANewValueIsThatOfARunThatBeganWithIt) {
  const auto started = [&](const std::string& young) {
    const std::string material = "<NeoHookeanMaterial name='tissue' youngModulus='" + young + "' poissonRatio='0.3'/>";
    return simulationFromText(sceneOf(tetrahedron, material + field() + "<FixedProjectiveConstraint indices='0 1 2'/>"));
  };
  Simulation changed = started("1e4"), soft = started("2e3");
  for (int i = 0; i < 5; ++i) changed.step();
  const System &from = *changed.systems()[0], &to = *soft.systems()[0];
  const auto take = [](ConstRows values, Rows out) { std::copy_n(values.data, values.doubles(), out.data); };
  take(from.x, soft.systems()[0]->x), take(from.v, soft.systems()[0]->v);
  changed.setAttribute("/tissue", "youngModulus", "2e3");
  for (int i = 0; i < 5; ++i) changed.step(), soft.step();
  double most = 0, moved = 0;
  for (Index row = 0; row < from.independentRows(); ++row) {
    most = std::max(most, (Vec3(from.x[row]) - Vec3(to.x[row])).norm());
    moved = std::max(moved, Vec3(from.v[row]).norm());
  }
  EXPECT_GT(moved, 1e-3);
  EXPECT_LT(most, 1e-14);
}

void expectRefused(const std::string& scene, const std::vector<std::string>& words) {
  const std::string problems = problemsOf(scene);
  for (const std::string& word : words) EXPECT_NE(problems.find(word), std::string::npos) << word << ": " << problems;
}

TEST(HyperelasticMaterials, WhatDoesNotFitIsRefused) {
  const std::string material = "<NeoHookeanMaterial youngModulus='1e3' poissonRatio='0.3'/>";
  const auto with = [](const std::string& element) { return sceneOf(tetrahedron, element + field()); };
  expectRefused(sceneOf(tetrahedron, field()),
                {"there is no material in this node or above", "NeoHookeanMaterial, StVenantKirchhoffMaterial"});
  expectRefused(sceneOf(tetrahedron, material + material + field()), {"NeoHookeanMaterial"});
  expectRefused(sceneOf(tetrahedron, material + field("material='@/nothing'")), {"nothing"});
  expectRefused(sceneOf(tetrahedron, "<PlaneForceField name='other'/>" + field("material='@other'")), {"hyperelastic material"});
  expectRefused(sceneOf(tetrahedron, material + field("template='Vec3,Triangle'")),
                {"template 'Vec3,Triangle' is none that", "Vec3,Tetrahedron, Vec3,Hexahedron, Vec3,QuadraticTetrahedron"});
  expectRefused(sceneOf(tetrahedron, material + field("template='Vec3,Hexahedron'")), {"holds no hexahedra"});
  expectRefused(sceneOf("<MeshTopology position='0 0 0 1 0 0 0 1 0' triangles='0 1 2'/>", material + field()),
                {"holds no tetrahedra and no hexahedra and no quadraticTetrahedra"});
  expectRefused(sceneOf("<MeshTopology position='0 0 0 1 0 0 1 1 0 0 1 0 0 0 1 1 0 1 1 1 1 0 1 1  2 0 0 2 1 0 2 0 1' "
                        "hexahedra='0 1 2 3 4 5 6 7' tetrahedra='1 8 9 10'/>",
                        material + field()),
                {"one force field for each kind of cell", "template=\"Vec3,Tetrahedron\""});
  expectRefused(with("<NeoHookeanMaterial youngModulus='1e3' poissonRatio='0.5'/>"), {"poissonRatio", "(-1, 0.5)"});
  expectRefused(with("<MooneyRivlinMaterial mu10='5' mu01='-5' bulkModulus='10'/>"), {"mu10 + mu01 is not above 0"});
  expectRefused(with("<MooneyRivlinMaterial mu10='5' mu01='5' bulkModulus='0'/>"), {"bulkModulus"});
  expectRefused(with("<OgdenMaterial mu='5' alpha='0' kappa='10'/>"), {"alpha is 0"});
  expectRefused(with("<NeoHookeanMaterial template='Rigid3' youngModulus='1e3' poissonRatio='0.3'/>"), {"template 'Rigid3'"});
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
