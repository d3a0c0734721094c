// SPDX-License-Identifier: LGPL-2.1-or-later
// Mappings that are not linear, or of other rows than points: Jacobian, its transpose and geometric stiffness against
// differences of what apply() and applyJT() do.
#include <fmt/format.h>

#include <numbers>

#include "framework/mechanics/frames.h"
#include "tests/mappings/mapping_scenes.h"
#include "tests/support/manual_examples.h"
#include "tests/support/random_rows.h"
#include "tests/support/scene_fixture.h"
#include "tests/support/scene_text.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// Two rods that are out, one in the other, with points on them.
std::string pushedRods(const std::string& child) {
  return "<Node name=\"root\" gravity=\"0 0 0\"><EulerImplicitSolver/><SparseLDLSolver/><WireRestShape name=\"outer\" length=\"2\" "
         "straightLength=\"2\" densityOfBeams=\"1\" numEdgesCollis=\"4\" radius=\"0.02\" youngModulus=\"1e6\" massDensity=\"1\"/>"
         "<WireRestShape name=\"inner\" length=\"3\" straightLength=\"2\" spireDiameter=\"0.8\" spireHeight=\"0.1\" densityOfBeams=\"1 2\" "
         "numEdgesCollis=\"5 4\" radius=\"0.01\" radiusExtremity=\"0.01\" youngModulus=\"1e6\" youngModulusExtremity=\"1e6\" "
         "massDensity=\"1\" massDensityExtremity=\"1\"/><RegularGridTopology n=\"14 1 1\" min=\"0 0 0\" max=\"1 0 0\"/>"
         "<MechanicalObject name=\"frames\" template=\"Rigid3\"/><WireBeamInterpolation name=\"a\" WireRestShape=\"@outer\"/>"
         "<AdaptiveBeamForceFieldAndMass interpolation=\"@a\"/><WireBeamInterpolation name=\"b\" WireRestShape=\"@inner\"/>"
         "<AdaptiveBeamForceFieldAndMass interpolation=\"@b\"/><InterventionalRadiologyController name=\"push\" instruments=\"@a @b\" "
         "xtip=\"1.6 2.5\" rotationInstrument=\"0.3 0.2\" startingPos=\"0.1 0.2 0  0.1 0.2 0.3 0.9\"/><Node name=\"child\">" +
         child + "</Node></Node>";
}

struct Case {
  std::string name, scene, type = {};  ///< of the mapping
};
std::ostream& operator<<(std::ostream& out, const Case& c) { return out << c.name; }

/// Where the example of a manual page is not enough: other attributes and kinds of rows, frames that are turned, cells that are
/// stretched, or no example.
std::vector<Case> recipes() {
  const std::string points = "<MechanicalObject name=\"dofs\" position=\"0.1 0.2 -0.3  0.5 0 0  0 0.4 0.2\"/>";
  const std::string numbers =
      "<MeshTopology edges=\"0 1  1 2  2 3  0 3\"/><MechanicalObject name=\"dofs\" template=\"Vec1\"/>";
  std::vector<Case> all{
      {"Rigid", underFrames(points + "<RigidMapping index=\"1\"/>")},
      {"RigidOfEach",
       underFrames(points + "<RigidMapping rigidIndexPerPoint=\"2 0 1\" globalToLocalCoords=\"true\"/>")},
      {"RigidToFrames", underFrames("<MechanicalObject name=\"dofs\" template=\"Rigid3\" position=\"0.3 0 0  0 0.2 0 "
                                    "0.9   0 0.2 0.1  0.5 0 0 0.8\"/>"
                                    "<RigidRigidMapping rigidIndexPerPoint=\"0 2\"/>")},
      {"RigidSharedOut", underFrames(points + "<RigidMapping repartition=\"1 0 2\"/>")},
      {"Skinning", underFrames(points + "<SkinningMapping nbRef=\"3\"/>")},
      {"LineSetSkinning",
       "<Node name=\"root\" gravity=\"0 0 0\"><EulerImplicitSolver/><SparseLDLSolver/><MeshTopology position=\"0 0 0  1 0.5 0  2 0 1\" "
       "lines=\"0 1  1 2\"/>" + frames + "<Node name=\"child\">" + points + "<LineSetSkinningMapping/></Node></Node>"},
      {"BeamLinear", underFrames(points + "<BeamLinearMapping/>")},
      {"SkinningByHand",
       underFrames(points + "<SkinningMapping nbRef=\"2\" indices=\"0 1  1 2  2 0\" weight=\"1 3  1 1  0.2 0.8\"/>")},
      {"Centres", underFrames("<MechanicalObject name=\"dofs\" position=\"0 0 0  0 0 0  0 0 0\"/><IdentityMapping/>")},
      {"SameFrames", underFrames("<MechanicalObject name=\"dofs\" template=\"Rigid3\" position=\"0 0 0 0 0 0 1  0 0 0 "
                                 "0 0 0 1  0 0 0 0 0 0 1\"/><IdentityMapping/>")},
      {"SomeFrames", underFrames("<MechanicalObject name=\"dofs\" template=\"Rigid3\" position=\"0 0 0 0 0 0 1  0 0 0 "
                                 "0 0 0 1\"/><SubsetMapping indices=\"2 0\"/>")}};
  for (const bool with_root : {false, true})
    all.push_back(
        {with_root ? "ArticulatedOnAFrame" : "Articulated",
         std::string(
             "<Node name=\"root\" gravity=\"0 0 0\"><EulerImplicitSolver/><SparseLDLSolver/><Node name=\"base\">"
             "<MechanicalObject name=\"dofs\" template=\"Rigid3\" position=\"0.3 0 0.1  0.1 0.2 0.3 "
             "0.9\"/><UniformMass totalMass=\"1\"/>"
             "</Node><MechanicalObject name=\"angles\" template=\"Vec1\" position=\"0.4 -0.3 0.2 0.7\"/><UniformMass "
             "totalMass=\"1\"/>"
             "<Node name=\"child\"><MechanicalObject name=\"frames\" template=\"Rigid3\" position=\"0 0 0  0 0 0 1   1 "
             "0 0  0 0 0 1   "
             "2 0 0  0 0 0 1  1 1 0  0 0 0 1\"/><ArticulatedSystemMapping input1=\"@../angles\" output=\"@frames\" ") +
             (with_root ? "input2=\"@../base/dofs\"" : "") +
             "/><Node name=\"a\"><ArticulationCenter parentIndex=\"0\" childIndex=\"1\" posOnParent=\"0.5 0 0\" "
             "posOnChild=\"-0.5 0.1 0\"/>"
             "<Articulation rotation=\"true\" rotationAxis=\"0 0 1\" articulationIndex=\"0\"/></Node>"
             "<Node name=\"b\"><ArticulationCenter parentIndex=\"1\" childIndex=\"2\" posOnParent=\"0.5 0 0\" "
             "posOnChild=\"-0.5 0 0\"/>"
             "<Node name=\"x\"><Articulation rotation=\"true\" rotationAxis=\"0 1 0\" articulationIndex=\"1\"/></Node>"
             "<Node name=\"y\"><Articulation translation=\"true\" rotationAxis=\"1 0 1\" "
             "articulationIndex=\"2\"/></Node>"
             "<Node name=\"z\"><Articulation rotation=\"true\" rotationAxis=\"1 0 0\" "
             "articulationIndex=\"3\"/></Node></Node>"
             "<Node name=\"c\"><ArticulationCenter parentIndex=\"1\" childIndex=\"3\" posOnParent=\"0 0.5 0\" "
             "posOnChild=\"0 -0.5 0\"/>"
             "<Articulation rotation=\"true\" rotationAxis=\"1 0 0\" articulationIndex=\"3\"/></Node></Node></Node>"});
  all.push_back(
      {"DistanceMulti", "<Node name=\"root\" gravity=\"0 0 0\"><EulerImplicitSolver/><SparseLDLSolver/><Node name=\"a\">" + frames +
                            "</Node><Node name=\"b\"><MechanicalObject name=\"dofs\" position=\"0 1 0.2  1 1 1\"/><UniformMass "
                            "totalMass=\"1\"/></Node><Node name=\"child\"><MeshTopology edges=\"0 1  1 2\"/><MechanicalObject "
                            "name=\"lengths\" template=\"Vec1\"/><DistanceMultiMapping geometricStiffness=\"Exact\" "
                            "input=\"@../a/frames @../b/dofs\" indexPairs=\"0 1  1 0  1 1\"/></Node></Node>"});
  all.push_back({"DistanceToPlane", underFrames("<MechanicalObject name=\"dofs\" template=\"Vec1\"/><DistanceToPlaneMapping "
                                                "planeNormal=\"1 2 -2\" planePoint=\"0 1 0\"/>")});
  all.push_back({"Tubular", underFrames("<MechanicalObject name=\"dofs\"/><TubularMapping nbPointsOnEachCircle=\"3\" "
                                        "radius=\"0.2\" peak=\"-1\"/>")});
  all.push_back(
      {"Mesh2Point",
       underPoints("<Node name=\"mesh\"><MeshTopology name=\"net\" position=\"0 0 0  1 0.2 0  1.5 1 0.3  0 1 1\" "
                   "tetrahedra=\"0 1 2 3\"/></Node><Mesh2PointTopologicalMapping input=\"@mesh/net\" pointBaryCoords=\"0.1 0.2 0.3\" "
                   "tetraBaryCoords=\"0.1 0.3 0.2\"/><MechanicalObject name=\"dofs\"/><Mesh2PointMechanicalMapping/>")});
  all.push_back({"EmbeddedFramesInATetrahedron", embeddedFrames("tetrahedra=\"0 1 2 3\"", "0 0 0  1 0 0  0 1 0  0 0 1",
                                                                 "0.1 0 0  0.3 1.2 0.2  -0.8 0.4 0.1  0.2 -0.1 0.7")});
  all.push_back({"EmbeddedFramesInAHexahedron",
                 embeddedFrames("hexahedra=\"0 1 2 3 4 5 6 7\"", rest_cube,
                                "0 0.1 0  0.3 1.2 0  -0.6 1.4 0.1  -0.9 0.2 0  0 0 0.8  0.2 1.1 1  -0.5 1.5 1.2  -0.8 0.3 0.9")});
  all.push_back({"CenterOfMass", underFrames("<MechanicalObject name=\"dofs\"/><CenterOfMassMapping/>")});
  all.push_back(
      {"IdentityMulti", "<Node name=\"root\" gravity=\"0 0 0\"><EulerImplicitSolver/><SparseLDLSolver/><Node name=\"a\">" + frames +
                            "</Node><Node name=\"b\"><MechanicalObject name=\"dofs\" position=\"0 1 0.2  1 1 1\"/><UniformMass "
                            "totalMass=\"1\"/></Node><Node name=\"child\"><MechanicalObject name=\"all\"/><IdentityMultiMapping "
                            "input=\"@../a/frames @../b/dofs\"/></Node></Node>"});
  all.push_back(
      {"CosseratNone",
       "<Node name=\"root\" gravity=\"0 0 0\"><EulerImplicitSolver/><SparseLDLSolver/><Node name=\"base\">" + frames +
           "</Node><Node name=\"strains\"><MechanicalObject name=\"k\" position=\"0.3 1 -2  0 0 0  -4 3 5\"/><UniformMass "
           "totalMass=\"1\"/><Node name=\"child\"><MechanicalObject name=\"rod\" template=\"Rigid3\" position=\"0 0 0 0 0 0 1  "
           "0 0 0 0 0 0 1  0 0 0 0 0 0 1  0 0 0 0 0 0 1\"/><DiscreteCosseratMapping input1=\"@../k\" "
           "input2=\"@../../base/frames\" baseIndex=\"1\" curv_abs_input=\"0 0.4 0.5 0.9\" "
           "curv_abs_output=\"0 0.15 0.4 0.8\"/></Node></Node></Node>"});
  all.push_back(
      {"CosseratThatStretchesNone",
       "<Node name=\"root\" gravity=\"0 0 0\"><EulerImplicitSolver/><SparseLDLSolver/><Node name=\"base\">" + frames +
           "</Node><Node name=\"strains\"><MechanicalObject name=\"k\" template=\"Vec6\" position=\"0.3 1 -2 0.1 0.2 -0.1  "
           "0 0 0 0.3 0 0  -4 3 5 0 -0.3 0.2\"/><UniformMass totalMass=\"1\"/><Node name=\"child\"><MechanicalObject name=\"rod\" "
           "template=\"Rigid3\" position=\"0 0 0 0 0 0 1  0 0 0 0 0 0 1  0 0 0 0 0 0 1  0 0 0 0 0 0 1\"/><DiscreteCosseratMapping "
           "input1=\"@../k\" input2=\"@../../base/frames\" baseIndex=\"1\" curv_abs_input=\"0 0.4 0.5 0.9\" "
           "curv_abs_output=\"0 0.15 0.4 0.8\"/></Node></Node></Node>"});
  for (const std::string place : {"index=\"1\"", "index=\"0\" indexFromEnd=\"true\" geometricStiffness=\"None\""})
    all.push_back({place.starts_with("index=\"1") ? "DeformableOnFrame" : "DeformableOnFrameNone",
                   "<Node name=\"root\" gravity=\"0 0 0\"><EulerImplicitSolver/><SparseLDLSolver/><Node name=\"a\">" + frames +
                       "</Node><MechanicalObject name=\"local\" position=\"0.1 0.2 -0.3  0.5 0 0  0 0.4 0.2\"/><UniformMass "
                       "totalMass=\"1\"/><Node name=\"child\"><MechanicalObject name=\"dofs\"/><DeformableOnRigidFrameMapping " +
                       place + " input1=\"@../local\" input2=\"@../a/frames\"/></Node></Node>"});
  all.push_back({"AdaptiveBeam", pushedRods("<MechanicalObject name=\"dofs\" position=\"2.9 0.1 0  2 0 0.2  1.5 0 0\"/>"
                                            "<AdaptiveBeamMapping interpolation=\"@../b\"/>")});
  all.push_back({"MultiAdaptiveBeam", pushedRods("<MultiAdaptiveBeamTopologicalMapping ircontroller=\"@../push\"/><MechanicalObject "
                                                 "name=\"dofs\"/><MultiAdaptiveBeamMapping ircontroller=\"@../push\"/>")});
  for (const std::string word : {"Exact", "None", "Stabilized"}) {
    const std::string geometric = " geometricStiffness=\"" + word + "\"";
    const std::string cells =
        "<MeshTopology triangles=\"0 1 2  1 3 2\" tetrahedra=\"0 1 2 3\"/><MechanicalObject name=\"dofs\" "
        "template=\"Vec1\"/>";
    all.push_back({"Area" + word, underPoints(cells + "<AreaMapping" + geometric + "/>")});
    all.push_back({"Volume" + word, underPoints(cells + "<VolumeMapping" + geometric + "/>")});
    all.push_back({"Square" + word,
                   "<Node name=\"root\" gravity=\"0 0 0\"><EulerImplicitSolver/><SparseLDLSolver/><MechanicalObject "
                   "name=\"x\" template=\"Vec1\" position=\"1 -2 0.5\"/><UniformMass totalMass=\"1\"/><Node "
                   "name=\"child\"><MechanicalObject name=\"dofs\" template=\"Vec1\"/><SquareMapping" +
                       geometric + "/></Node></Node>"});
    all.push_back({"Distance" + word, underPoints(numbers + "<DistanceMapping" + geometric + "/>")});
    all.push_back({"SquareDistance" + word, underPoints(numbers + "<SquareDistanceMapping" + geometric + "/>")});
    all.push_back(
        {"FromTarget" + word, underPoints("<MechanicalObject name=\"dofs\" template=\"Vec1\"/><DistanceFromTarget "
                                          "indices=\"1 3\" targetPositions=\"2 2 2  -1 0 0.5\"" +
                                          geometric + "/>")});
  }
  return all;
}

/// Of every mapping that the factory knows the recipes, or else the example on its manual page.
std::vector<Case> cases() {
  modules().openAll();
  std::vector<Case> all = recipes();
  const std::size_t by_hand = all.size();
  for (const ComponentEntry* entry : factory().entries()) {
    const std::string& type = entry->type;
    const bool is_of_tests = entry->module.empty();
    if (is_of_tests || !dynamic_cast<Mapping*>(factory().make(type).get())) continue;
    const auto isIn = [&type](const std::string& scene) {
      return scene.find("<" + type + " ") != std::string::npos || scene.find("<" + type + "/>") != std::string::npos;
    };
    bool has_recipe = false;
    for (std::size_t i = 0; i < by_hand; ++i)
      if (isIn(all[i].scene)) all[i].type = type, has_recipe = true;
    const std::string example = exampleIn(modules().manual(type));
    if (!has_recipe) all.push_back({type, isIn(example) ? example : "", type});
  }
  return all;
}

class MappingContract : public testing::TestWithParam<Case> {
 protected:
  void SetUp() override {
    ASSERT_FALSE(GetParam().type.empty()) << "the recipe " << GetParam().name << " has no mapping that the factory knows";
    ASSERT_FALSE(GetParam().scene.empty()) << GetParam().type << " is registered as a mapping, and nothing tests it: write an example "
                                           << "of it on its manual page, or a recipe here";
  }
};

const Mapping* mappingIn(const System& system, const std::string& type) {
  for (const auto* list : {&system.actors().mappings, &system.actors().passive_mappings})
    for (const Mapping* mapping : *list)
      if (mapping->type() == type) return mapping;
  return nullptr;
}

struct UnderTest {
  Simulation simulation;
  System& system;
  const Mapping& mapping;
  explicit UnderTest(const Case& c)
      : simulation(simulationFromText(c.scene)), system(systemWith(c.type)), mapping(*mappingIn(system, c.type)) {}

  System& systemWith(const std::string& type) const {
    for (const auto& each : simulation.systems())
      if (mappingIn(*each, type)) return *each;
    throw std::runtime_error("no system has a " + type);
  }
  /// Positions a step along d from those of the scene, with the child where the mapping has it.
  Vector movedBy(double s, const Vector& d) const {
    Vector x(system.allRows());
    copy(system.x, x);
    system.motion().advance(s, system.independent(d), system.independent(x));
    mapping.apply(x);
    return x;
  }
};

TEST_P(MappingContract, JacobianIsTheDerivative) {
  UnderTest t(GetParam());
  const State& child = t.mapping.output();
  Vector d = randomRows(t.system, 3);
  const double h = 1e-5;
  Vector after = t.movedBy(h, d), before = t.movedBy(-h, d);
  t.system.motion().difference(after, before);
  t.mapping.apply(t.system.x);
  Vector by_blocks(t.system.allRows());
  std::vector<JacobianBlock> blocks;
  t.mapping.addJacobian(blocks);
  for (const JacobianBlock& block : blocks) by_blocks[block.child] += block.block * d[block.parent];
  t.mapping.applyJ(d);
  double size = 0;
  for (Index i = child.firstRow(); i < child.firstRow() + child.size(); ++i) {
    size += d[i].norm();
    EXPECT_LT((before[i] / (2 * h) - d[i]).norm(), 1e-8) << "row " << i;
    EXPECT_LT((by_blocks[i] - d[i]).norm(), 1e-13);
  }
  EXPECT_GT(size, 0.1);
}

TEST_P(MappingContract, ForcesAreTheTranspose) {
  UnderTest t(GetParam());
  Vector v = randomRows(t.system, 4), f = randomRows(t.system, 5);
  const State& child = t.mapping.output();
  for (Index i = 0; i < t.system.independentRows(); ++i) f[i].setZero();
  t.mapping.applyJ(v);
  double power = 0, pulled = 0;
  for (Index i = child.firstRow(); i < child.firstRow() + child.size(); ++i) power += f[i].dot(v[i]);
  t.mapping.applyJT(f);
  for (Index i = 0; i < t.system.independentRows(); ++i) pulled += f[i].dot(v[i]);
  EXPECT_NEAR(pulled, power, 1e-12);
}

/// The derivative of J^T f, less the skew part 1/2 [torque] of turns, as it is left out of stiffnesses that act on the child
/// too; assembled, as a product, and symmetric.
TEST_P(MappingContract, GeometricStiffnessIsTheDerivativeOfForces) {
  UnderTest t(GetParam());
  if (t.mapping.isLinear()) return;
  const State& child = t.mapping.output();
  const bool none = GetParam().name.ends_with("None"), stabilized = GetParam().name.ends_with("Stabilized");
  const Vector d = randomRows(t.system, 6);
  Vector f = randomRows(t.system, 7);
  for (Index i = 0; i < t.system.independentRows(); ++i) f[i].setZero();
  for (Index i = child.firstRow(); i < child.firstRow() + child.size(); ++i) {
    if (stabilized) f[i][0] = -std::abs(f[i][0]);  // tensions are what it keeps
  }
  const double h = 1e-5;
  const auto pulled = [&](double s) {
    const Vector x = t.movedBy(s, d);
    Vector all(t.system.allRows());
    copy(f, all);
    t.mapping.applyJT(all);
    return all;
  };
  const Vector plus = pulled(h), minus = pulled(-h);
  t.mapping.apply(t.system.x);
  // what the child's own stiffness leaves out: 1/2 dw x torque
  Vector along(t.system.allRows()), left_out(t.system.allRows());
  copy(d, along);
  t.mapping.applyJ(along);
  for (Index i = child.firstRow(); i < child.firstRow() + child.size(); ++i)
    if (t.system.motion().kindOf(i) == RowKind::turn) left_out[i] = 0.5 * Vec3(along[i]).cross(Vec3(f[i]));
  t.mapping.applyJT(left_out);
  Vector here(t.system.allRows()), product(t.system.allRows());
  copy(f, here);
  t.mapping.applyJT(here);
  t.mapping.addGeometricProduct(f, d, 1, product);
  BlockPattern pattern(t.system.allRows());
  t.mapping.addGeometricPattern(pattern);
  BlockMatrix matrix(std::move(pattern));
  t.mapping.addGeometricStiffness(f, 1, matrix);
  Vector assembled(t.system.allRows()), symmetric(t.system.allRows());
  matrix.multiply(d, assembled);
  double size = 0;
  for (Index i = 0; i < t.system.independentRows(); ++i) {
    Vec3 difference = (plus[i] - minus[i]) / (2 * h) + left_out[i];
    if (t.system.motion().kindOf(i) == RowKind::turn) difference -= 0.5 * Vec3(d[i]).cross(Vec3(here[i]));
    EXPECT_LT((assembled[i] - product[i]).norm(), 1e-12);
    if (!none) EXPECT_LT((difference - product[i]).norm(), 1e-8) << "row " << i;
    size += product[i].norm();
  }
  EXPECT_EQ(size > 1e-3, !none);
  const Vector other = randomRows(t.system, 8);
  t.mapping.addGeometricProduct(f, other, 1, symmetric);
  EXPECT_NEAR(dot(other, product), dot(d, symmetric), 1e-12);
}

/// What the velocity of the child changes by along the way, where that of the parents does not.
TEST_P(MappingContract, CurvatureIsTheChangeOfVelocities) {
  UnderTest t(GetParam());
  if (t.mapping.isLinear()) return;
  const State& child = t.mapping.output();
  const Vector v = randomRows(t.system, 9);
  const double h = 1e-5;
  const auto velocities = [&](double s) {
    t.movedBy(s, v);
    Vector all(t.system.allRows());
    copy(v, all);
    t.mapping.applyJ(all);
    return all;
  };
  const Vector plus = velocities(h), minus = velocities(-h), now = velocities(0);
  Vector a(t.system.allRows());
  t.mapping.addCurvature(now, a);
  double size = 0;
  for (Index i = 0; i < t.system.allRows(); ++i) {
    const bool of_child = i >= child.firstRow() && i < child.firstRow() + child.size();
    const Vec3 difference = of_child ? Vec3((plus[i] - minus[i]) / (2 * h)) : Vec3(Vec3::Zero());
    EXPECT_LT((difference - a[i]).norm(), 1e-8) << "row " << i;
    size += a[i].norm();
  }
  EXPECT_GT(size, 0.1);
}

INSTANTIATE_TEST_SUITE_P(Mappings, MappingContract, testing::ValuesIn(cases()),
                         [](const auto& values) { return values.param.name; });

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
