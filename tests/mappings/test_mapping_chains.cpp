// SPDX-License-Identifier: LGPL-2.1-or-later
// Chains of mappings with springs at their last level: the force on the independent nodes against the energy, and its stiffness, as a
// product and assembled, against differences of the force. The contract of a single mapping is in test_mapping_contract.cpp.
#include <fmt/format.h>

#include <string>

#include "tests/support/random_rows.h"
#include "tests/support/scene_text.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

struct Chain {
  const char* name;
  const char* scene;  ///< in a root node with an integrator and a direct solver
};
std::ostream& operator<<(std::ostream& out, const Chain& chain) { return out << chain.name; }

// Frames are rotated at the start, springs are under tension and pressure.
constexpr const char* frames_frames_points = R"(
  <Node name="bodies"><MechanicalObject name="dofs" template="Rigid3" position="0 0 0  0.1 0.2 0.3 0.9   1 0.5 0  -0.4 0.1 0 0.8"/>
  <UniformMass totalMass="3" inertia="0.1 0.2 0.3"/>
  <Node name="tools"><MechanicalObject name="dofs" template="Rigid3" position="0.3 0 0  0 0.2 0 0.9   0 0.2 0.1  0.5 0 0 0.8"/>
  <RigidMapping rigidIndexPerPoint="0 1"/>
  <Node name="tips"><MechanicalObject name="dofs" position="0.1 0.2 -0.3  0.5 0 0  0 0.4 0.2"/>
  <RigidMapping rigidIndexPerPoint="0 0 1"/>
  <SpringForceField spring="0 2 80 0 0.4  1 2 50 0 1.5"/><RestShapeSpringsForceField stiffness="30"/></Node></Node></Node>)";

constexpr const char* hinges_frames_points = R"(
  <Node name="arm"><MechanicalObject name="angles" template="Vec1" position="0.4 -0.3 0.2"/><UniformMass totalMass="1"/>
  <Node name="links"><MechanicalObject name="dofs" template="Rigid3" position="0 0 0  0 0 0 1   1 0 0  0 0 0 1   2 0 0  0 0 0 1"/>
  <ArticulatedSystemMapping input1="@../angles" output="@dofs"/>
  <Node name="a"><ArticulationCenter parentIndex="0" childIndex="1" posOnParent="0.5 0 0" posOnChild="-0.5 0.1 0"/>
  <Articulation rotation="true" rotationAxis="0 0 1" articulationIndex="0"/></Node>
  <Node name="b"><ArticulationCenter parentIndex="1" childIndex="2" posOnParent="0.5 0 0" posOnChild="-0.5 0 0"/>
  <Node name="x"><Articulation rotation="true" rotationAxis="0 1 0" articulationIndex="1"/></Node>
  <Node name="y"><Articulation translation="true" rotationAxis="1 0 1" articulationIndex="2"/></Node></Node>
  <Node name="tips"><MechanicalObject name="dofs" position="0.1 0.2 -0.3  0.5 0 0.1"/><RigidMapping rigidIndexPerPoint="1 2"/>
  <SpringForceField spring="0 1 80 0 0.4"/><RestShapeSpringsForceField stiffness="30 10" points="0 1"/>
  <ConstantForceField forces="3 -2 5  1 4 -2"/></Node></Node></Node>)";

constexpr const char* tetrahedra_frames_points = R"(
  <Node name="body"><MeshTopology position="0 0 0  1 0 0  0 1 0  0 0 1  1 1 1" tetrahedra="0 1 2 3  1 2 3 4"/>
  <MechanicalObject name="dofs" position="0.1 0 0  0.3 1.2 0.2  -0.8 0.4 0.1  0.2 -0.1 0.7  0.4 1 1.2"
    rest_position="0 0 0  1 0 0  0 1 0  0 0 1  1 1 1"/><UniformMass totalMass="1"/>
  <Node name="probe"><MechanicalObject name="dofs" template="Rigid3" position="0.2 0.3 0.1  0.1 0.2 0.3 0.9   0.5 0.4 0.3  0 0 0 1"/>
  <BarycentricMapping useRestPosition="true"/>
  <Node name="tips"><MechanicalObject name="dofs" position="0.1 0.2 -0.3  0.5 0 0.1"/><RigidMapping rigidIndexPerPoint="0 1"/>
  <SpringForceField spring="0 1 80 0 0.4"/><ConstantForceField forces="3 -2 5  1 4 -2"/></Node></Node></Node>)";

constexpr const char* states_nodes_distances = R"(
  <Node name="rigid"><MechanicalObject name="dofs" template="Rigid3" position="0 0 0  0.1 0.2 0.3 0.9"/><UniformMass totalMass="1"/>
  <Node name="end"><MechanicalObject name="dofs" position="1 0 0  0 1 0.2"/><RigidMapping/></Node></Node>
  <Node name="free"><MechanicalObject name="dofs" position="1 1 0  0.5 2 1"/><UniformMass totalMass="1"/></Node>
  <Node name="both"><MechanicalObject name="dofs" position="1 0 0  1 1 0  0.5 2 1  0 1 0.2"/>
  <SubsetMultiMapping input="@../rigid/end/dofs @../free/dofs" indexPairs="0 0  1 0  1 1  0 1"/>
  <Node name="lengths"><MeshTopology edges="0 1  1 2  2 3  0 2"/><MechanicalObject name="dofs" template="Vec1"/>
  <DistanceMapping restLengths="0.5 2 1 1" geometricStiffness="Exact"/><RestShapeSpringsForceField stiffness="100"/></Node></Node>)";

constexpr const char* beams_points_lengths = R"(
  <Node name="rod"><MeshTopology edges="0 1  1 2"/><MechanicalObject name="dofs" template="Rigid3"
    position="0 0 0  0.1 0.2 0.3 0.9   1 0.5 0  -0.4 0.1 0 0.8   2 0 1  0 0 0 1"/><UniformMass totalMass="1"/>
  <Node name="skin"><MechanicalObject name="dofs" position="0.1 0.2 -0.3  0.5 0 0.1  1.4 0.1 0.2"/><SkinningMapping nbRef="3"/>
  <Node name="tips"><MechanicalObject name="dofs"/><SubsetMapping indices="2 0"/>
  <Node name="squares"><MeshTopology edges="0 1"/><MechanicalObject name="dofs" template="Vec1"/>
  <SquareDistanceMapping geometricStiffness="Exact"/><RestShapeSpringsForceField stiffness="100"/></Node></Node></Node></Node>)";

struct UnderTest {
  Simulation simulation;
  System& system;
  explicit UnderTest(const char* content)
      : simulation(simulationFromText(fmt::format(
            R"(<Node name="root" gravity="0 0 0"><EulerImplicitSolver/><SparseLDLSolver/>{}</Node>)", content))),
        system(*simulation.systems()[0]) {}

  Vector at(double s, const Vector& d) const {
    Vector x(system.allRows());
    copy(system.x, x);
    system.motion().advance(s, system.independent(d), system.independent(x));
    for (const Mapping* mapping : system.actors().mappings) mapping->apply(x);
    return x;
  }
  /// On the independent rows.
  Vector force(double s, const Vector& d) const {
    const Vector x = at(s, d), still(system.allRows());
    Vector f(system.allRows());
    system.computeForce(x, still, f);
    Vector independent(system.independentRows());
    copy(system.independent(f), independent);
    return independent;
  }
  double energy(double s, const Vector& d) const { return system.elasticEnergy(at(s, d)); }
};

class MappingChains : public testing::TestWithParam<Chain> {};

TEST_P(MappingChains, AreTwoMappingsOrMore) {
  const UnderTest t(GetParam().scene);
  EXPECT_GE(t.system.actors().mappings.size(), 2u);
  EXPECT_TRUE(t.system.actors().passive_mappings.empty());
}

/// dE/ds = -f.d along any movement d of the independent nodes.
TEST_P(MappingChains, ForcesAreTheGradientOfTheEnergy) {
  const UnderTest t(GetParam().scene);
  for (unsigned seed = 1; seed <= 3; ++seed) {
    const Vector d = randomRows(t.system, seed), f = t.force(0, d);
    const double power = dot(f, t.system.independent(d)), h = 1e-5;
    EXPECT_GT(norm(f), 1);
    EXPECT_NEAR((t.energy(-h, d) - t.energy(h, d)) / (2 * h), power, 1e-8 * norm(f));
  }
}

/// The derivative of the force, less the skew part 1/2 [torque] of the rows that turn.
TEST_P(MappingChains, StiffnessIsTheDerivativeOfTheForce) {
  const UnderTest t(GetParam().scene);
  System& system = t.system;
  const Vector d = randomRows(system, 6), other = randomRows(system, 8);
  MatrixFactors factors;
  factors.stiffness = 1;
  for (const double h : {1e-4, 1e-5}) {
    const Vector plus = t.force(h, d), minus = t.force(-h, d), here = t.force(0, d);
    Vector product(system.independentRows()), assembled(system.independentRows()), of_other(system.independentRows());
    MechanicalMatrix& matrix = system.matrix().withFactors(factors);
    matrix.multiply(system.independent(d), product);
    matrix.multiply(system.independent(other), of_other);
    matrix.assemble().multiply(system.independent(d), assembled);
    const double size = norm(product);
    EXPECT_GT(size, 10);
    EXPECT_LT(distance(product, assembled), 1e-12 * size);
    EXPECT_NEAR(dot(system.independent(other), product), dot(system.independent(d), of_other), 1e-12 * size);
    for (Index i = 0; i < system.independentRows(); ++i) {
      Vec3 difference = (plus[i] - minus[i]) / (2 * h);
      if (system.motion().kindOf(i) == RowKind::turn) difference -= 0.5 * Vec3(d[i]).cross(Vec3(here[i]));
      EXPECT_LT((difference - product[i]).norm(), 1e-7 * size) << "row " << i << ", step " << h;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Mappings, MappingChains,
                         testing::Values(Chain{"FramesFramesPoints", frames_frames_points},
                                         Chain{"HingesFramesPoints", hinges_frames_points},
                                         Chain{"TetrahedraFramesPoints", tetrahedra_frames_points},
                                         Chain{"StatesNodesDistances", states_nodes_distances},
                                         Chain{"FramesPointsPointsSquares", beams_points_lengths}),
                         [](const auto& values) { return values.param.name; });

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
