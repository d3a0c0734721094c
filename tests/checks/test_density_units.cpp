// SPDX-License-Identifier: LGPL-2.1-or-later
// A density with a unit that the cells do not have: a sheet of 1 m^2 and 1 mm of 1000 kg/m^3 has a mass of 1 kg, and a rod of 1 m
// and a radius of 1 cm of pi/10 kg.
#include "framework/mechanics/mass.h"
#include "tests/checks/units_fixture.h"
#include "tests/support/scene_fixture.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

class DensityUnits : public UnitsFixture {
 protected:
  double massOf(const std::string& xml) {
    Session session;
    return session.loadText(xml, (folder_ / "scene.xml").string()).systems().at(0)->masses().at(0)->totalMass();
  }
};

std::string sheet(const std::string& density, const std::string& mass = "DiagonalMass") {
  return "<Node dt='0.01' gravity='0 0 0'><EulerImplicitSolver/><CGLinearSolver iterations='50' tolerance='1e-9'/>"
         "<MechanicalObject position='0 0 0  1 0 0  1 1 0  0 1 0'/>"
         "<MeshTopology name='m' position='0 0 0  1 0 0  1 1 0  0 1 0' triangles='0 1 2  0 2 3'/><" +
         mass + " name='mass' massDensity='" + density + "'/>"
         "<TriangularFEMForceField name='fem' youngModulus='1 MPa' poissonRatio='0.3' thickness='1 mm'/></Node>";
}

std::string rod(const std::string& density) {
  return "<Node dt='0.01' gravity='0 0 0'><EulerImplicitSolver/><SparseLDLSolver/><MeshTopology name='m' edges='0 1  1 2'/>"
         "<MechanicalObject template='Rigid3' position='0 0 0  0 0 0 1   0.5 0 0  0 0 0 1   1 0 0  0 0 0 1'/>"
         "<DiagonalMass massDensity='" + density +
         "'/><BeamFEMForceField name='fem' youngModulus='1e7' poissonRatio='0.3' radius='0.01'/></Node>";
}

TEST_F(DensityUnits, OfASheet) {
  for (const char* mass : {"DiagonalMass", "MeshMatrixMass"}) {
    const std::string error = errorOf(sheet("1000 kg/m^3", mass));
    expectContains(error, "massDensity is written as a mass per volume, and the cells of /m are areas");
    expectContains(error, "massDensity=\"1 kg/m^2\" for the thickness of 0.001 m of /fem");
    EXPECT_NEAR(massOf(sheet("1 kg/m^2", mass)), 1, 1e-12);
    EXPECT_NEAR(massOf(sheet("0.1 g/cm^2", mass)), 1, 1e-12);
  }
  expectContains(errorOf(sheet("3 kg/m")), "a mass per length");
  EXPECT_NEAR(massOf(sheet("2")), 2, 1e-12) << "without a unit it is per area";
  expectContains(errorOf(sheet("1 kg")), "kg/m^2");
}

TEST_F(DensityUnits, OfARod) {
  expectContains(errorOf(rod("1000 kg/m^3")), "massDensity=\"0.314159 kg/m\" for the radius of 0.01 m of /fem");
  EXPECT_NEAR(massOf(rod("0.314159 kg/m")), 0.314159, 1e-12);
}

TEST_F(DensityUnits, OfAVolume) {
  const auto block = [](const std::string& density) {
    return "<Node dt='0.01' gravity='0 0 0'><EulerExplicitSolver/><RegularGridTopology name='m' n='2 2 2' min='0 0 0' max='1 1 2'/>"
           "<MechanicalObject/><DiagonalMass massDensity='" + density + "'/>"
           "<HexahedronFEMForceField youngModulus='1 MPa' poissonRatio='0.3'/></Node>";
  };
  EXPECT_NEAR(massOf(block("1 g/cm^3")), 2000, 1e-9);
  expectContains(errorOf(block("1000 kg/m^2")), "a mass per area, and the cells of /m are volumes (expected a mass per volume");
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
