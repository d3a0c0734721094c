// SPDX-License-Identifier: LGPL-2.1-or-later
// Statics at the edge of double precision. The same slender beam over twelve decades of stiffness, of size, of load and
// of distance from the origin has, in its own units, the same shape: a run converges to it, or says which residual
// round-off allows. Neither a false alarm nor a false success.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/support/scene_fixture.h"

using namespace stroma;
using namespace stroma::test;

namespace {

struct Case {
  double young = 1e6;    ///< [Pa]
  double length = 1;     ///< [m]
  double strain = 1e-4;  ///< of the order of that at the wall [-]
  double away = 0;       ///< from the origin [m]
};

struct Answer {
  StepReport report;
  double tip = 0;  ///< deflection over length over `strain`: a number of the beam's shape alone
};

Answer answerOf(const Case& beam, const std::string& field, const std::string& attributes) {
  constexpr double slenderness = 20;
  const double across = beam.length / slenderness, area = across * across;
  // the strain at the wall under a force F at the tip is 6 F L / (E b h^2)
  const double force = beam.strain * beam.young * area * across / (6 * beam.length);
  const bool cubes = field.starts_with("Hexahedron");
  Simulation simulation = simulationFromText(fmt::format(
      R"(<Node name="root" dt="1" gravity="0 0 0"><StaticSolver/><SparseLDLSolver/>
  <RegularGridTopology name="grid" n="41 3 3" min="{0} {0} {0}" max="{1} {2} {2}"/>
  <MechanicalObject/>
  <BoxROI name="wall" box="{3} {3} {3}  {4} {2} {2}"/><FixedProjectiveConstraint indices="@wall.indices"/>
  <ConstantForceField indices="368" forces="0 {5} 0"/>
  <Node name="cells"><TetrahedronSetTopologyContainer name="tets"/>
    <Hexa2TetraTopologicalMapping input="@../grid" output="@tets"/>
    <{6} topology="{7}" youngModulus="{8}" poissonRatio="0.3" {9}/></Node></Node>)",
      beam.away, beam.away + beam.length, beam.away + across, beam.away - across, beam.away + 1e-3 * beam.length, force,
      field, cubes ? "@../grid" : "@tets", beam.young, attributes));
  Answer answer;
  answer.report = simulation.step();
  const State& body = *simulation.states().front();
  answer.tip = (body.x()[368][1] - body.rest_position[368][1]) / beam.length / beam.strain;
  return answer;
}

const std::vector<std::pair<std::string, std::string>> fields{
    {"TetrahedronFEMForceField", "method='polar'"},
    {"HexahedronFEMForceField", "method='polar'"},
    {"TetrahedronHyperelasticityFEMForceField", "materialName='StableNeoHookean'"},
    {"HexahedronHyperelasticityFEMForceField", "materialName='NeoHookean'"}};

void expectRight(const Case& beam, const std::string& field, const std::string& attributes, double right) {
  SCOPED_TRACE(fmt::format("{}: E {:g}, L {:g}, strain {:g}, {:g} away", field, beam.young, beam.length, beam.strain,
                           beam.away));
  const Answer answer = answerOf(beam, field, attributes);
  EXPECT_FALSE(answer.report.diverged) << answer.report.reason;
  // displacements of strain times length, on a grid of one rounding of the coordinates, and the beam's own flexibility
  const double grid = 2.2e-16 * (beam.away + beam.length) / (beam.strain * beam.length);
  if (answer.report.newton_converged) {
    EXPECT_NEAR(answer.tip, right, (1e-3 + 1e2 * grid) * right) << grid;
    EXPECT_LT(1e2 * grid, 1) << "this load cannot be told from round-off";
  } else {
    EXPECT_NE(answer.report.reason.find("round-off of positions"), std::string::npos) << answer.report.reason;
    EXPECT_GT(grid, 1e-8) << "a false alarm: " << answer.report.reason;
  }
}

}  // namespace

TEST(RoundOff, StaticsIsRightOverTwelveDecadesOrSaysWhatRoundOffAllows) {
  for (const auto& [field, attributes] : fields) {
    const Answer reference = answerOf({}, field, attributes);
    ASSERT_TRUE(reference.report.newton_converged) << field << ": " << reference.report.reason;
    ASSERT_GT(reference.tip, 1);
    for (const double young : {1e-2, 1e2, 1e4, 1e8, 1e10})
      expectRight({.young = young}, field, attributes, reference.tip);
    for (const double length : {1e-6, 1e-4, 1e-2, 1e2, 1e4, 1e6})
      expectRight({.length = length}, field, attributes, reference.tip);
    for (const double strain : {1e-12, 1e-11, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5})
      expectRight({.strain = strain}, field, attributes, reference.tip);
    for (const double away : {1e-3, 1., 1e1, 1e2, 1e3, 1e4, 1e6, 1e9})
      for (const double strain : {1e-4, 1e-7})
        expectRight({.strain = strain, .away = away}, field, attributes, reference.tip);
  }
}
