// SPDX-License-Identifier: LGPL-2.1-or-later
// What holds for every projective constraint of the factory, on points and on frames, also of a mesh that has lost cells: one
// symmetric projection that keeps to what the constraint says, a matrix whose rows are those of it, velocities that change in free
// directions alone, motion that is there when it says so, and the same bits with two threads.
#include <fmt/format.h>

#include <map>
#include <set>

#include "framework/algebra/parallel.h"
#include "tests/support/folder_fixture.h"
#include "tests/support/manual_examples.h"
#include "tests/support/random_rows.h"
#include "tests/support/scene_text.h"
#include "tools/session/session.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

enum class Carved { no, follows, refused };
struct Case {
  std::string name, scene, type = {};  ///< of the constraint
  Carved carved = Carved::no;          ///< what it does where the other end of the block loses cells
};
std::ostream& operator<<(std::ostream& out, const Case& c) { return out << c.name; }

/// A block of cells; nodes 6, 13, 20 ... are its far end.
std::string block(const std::string& constraint) {
  return "<Node name=\"root\" dt=\"0.01\" gravity=\"1 -9 2\"><EulerImplicitSolver/><SparseLDLSolver/><RegularGridTopology name=\"g\" "
         "n=\"7 4 4\" min=\"0 0 0\" max=\"6 3 3\"/><MechanicalObject name=\"s\"/><UniformMass totalMass=\"11\"/>"
         "<HexahedronFEMForceField youngModulus=\"300\" poissonRatio=\"0.3\"/>" + constraint + "</Node>";
}
/// Four frames in a row, which springs join.
std::string frames(const std::string& constraint) {
  return "<Node name=\"root\" dt=\"0.01\" gravity=\"1 -9 2\"><EulerImplicitSolver/><SparseLDLSolver/><MechanicalObject name=\"s\" "
         "template=\"Rigid3\" position=\"0 0 0  0.1 0.2 0.3 0.9   1 0.5 0  -0.4 0.1 0 0.8   2 0 1  0 0 0 1   3 0 0  0 0.3 0 0.9\"/>"
         "<UniformMass totalMass=\"3\" inertia=\"0.1 0.2 0.3\"/><RestShapeSpringsForceField stiffness=\"20\" "
         "angularStiffness=\"5\"/><SpringForceField springsIndices1=\"0 1 2\" springsIndices2=\"1 2 3\" lengths=\"1 1 1\" "
         "stiffness=\"20\"/>" + constraint + "</Node>";
}

/// Four numbers, each on a spring.
std::string numbers(const std::string& constraint) {
  return "<Node name=\"root\" dt=\"0.01\"><EulerImplicitSolver/><SparseLDLSolver/><MechanicalObject name=\"s\" template=\"Vec1\" "
         "position=\"0.5 0 -1 2\" velocity=\"1 2 3 4\"/><UniformMass totalMass=\"3\"/><RestShapeSpringsForceField stiffness=\"20\"/>" +
         constraint + "</Node>";
}

/// A type with what it needs for points, and for frames, and what it takes of them.
enum class Takes { both, points, frames };
struct Recipe {
  std::string type, of_points, of_frames;
  Takes takes = Takes::both;
  Carved carved = Carved::follows;
};
std::vector<Recipe> recipes() {
  const std::string some = "indices=\"6 20\" ", two = "indices=\"1 3\" ", keys = "keyTimes=\"0 1 2\" ";
  const std::string moved = "movements=\"0 0 0  0 1 0  1 1 0\"", turned = "movements=\"0 0 0 0 0 0  0 1 0 0.3 0 0.2  1 1 0 0.3 1 0\"";
  const std::string affine = "beginConstraintTime=\"0\" endConstraintTime=\"1\" rotation=\"0 -1 0  1 0 0  0 0 1\" translation=\"0 0 0.5\"";
  const std::string corners =
      "cornerPoints=\"0 0 0  6 0 0  6 3 0  0 3 0  0 0 3  6 0 3  6 3 3  0 3 3\" cornerMovements=\"0 0 0  0.1 0 0  0.1 0.1 0  0 0.1 0  "
      "0 0 0.1  0.1 0 0.1  0.1 0.1 0  0 0 0.1\" endConstraintTime=\"1\"";
  return {{"FixedProjectiveConstraint", some, two},
          {"PartialFixedProjectiveConstraint", some + "fixedDirections=\"1 0 1\"", two + "fixedDirections=\"1 0 1 0 1 1\""},
          {"FixedPlaneProjectiveConstraint", "direction=\"1 0 0\" dmin=\"5.5\" dmax=\"6.5\"",
           "direction=\"1 0 0\" dmin=\"1.5\" dmax=\"2.5\"", Takes::points},
          {"FixedTranslationProjectiveConstraint", some, two},
          {"FixedRotationProjectiveConstraint", some + "FixedXRotation=\"true\"", two + "FixedXRotation=\"true\" FixedZRotation=\"true\"",
           Takes::frames},
          {"LinearMovementProjectiveConstraint", some + keys + moved, two + keys + turned},
          {"PartialLinearMovementProjectiveConstraint", some + keys + moved + " movedDirections=\"1 0 1\"",
           two + keys + turned + " movedDirections=\"1 0 1 0 0 1\""},
          {"LinearVelocityProjectiveConstraint", some + keys + "velocities=\"0 0 0  0 1 0  0 0 0\"",
           two + keys + "velocities=\"0 0 0 0 0 0  0 1 0 0.3 0 0.2  0 0 0 0 0 0\""},
          {"AffineMovementProjectiveConstraint", some + affine, two + affine},
          {"DirectionProjectiveConstraint", some + "direction=\"1 1 0\"", two + "direction=\"1 1 0\"", Takes::points},
          {"ProjectToPointProjectiveConstraint", some + "point=\"6 0 0\"", two + "point=\"1 0.5 0\"", Takes::points},
          {"ProjectToLineProjectiveConstraint", some + "origin=\"6 0 0\" direction=\"0 1 1\"", two + "origin=\"1 0 0\" direction=\"1 1 0\"",
           Takes::points},
          {"ProjectToPlaneProjectiveConstraint", some + "origin=\"6 0 0\" normal=\"1 0 0\"", two + "origin=\"1 0 0\" normal=\"0 1 1\"",
           Takes::points},
          {"ParabolicProjectiveConstraint", "indices=\"6\" P1=\"6 0 0\" P2=\"6.4 0.3 0\" P3=\"7 0 0\" BeginTime=\"0\" EndTime=\"1\"",
           "indices=\"3\" P1=\"3 0 0\" P2=\"3.4 0.3 0\" P3=\"4 0 0\" BeginTime=\"0\" EndTime=\"1\"", Takes::points},
          {"HermiteSplineProjectiveConstraint", "indices=\"6\" X0=\"6 0 0\" dX0=\"0 1 0\" X1=\"6 0 1\" dX1=\"0 0 1\" EndTime=\"2\"",
           "indices=\"3\" X0=\"3 0 0\" dX0=\"0 1 0\" X1=\"3 0 1\" dX1=\"0 0 1\" EndTime=\"2\"", Takes::points},
          {"LinearRelationProjectiveConstraint", "indices=\"6 13 20\" coefficients=\"1 -2 1\"",
           "indices=\"1 2 3\" coefficients=\"1 -2 1\""},
          {"OscillatorProjectiveConstraint", "oscillators=\"6  6 0 0  0 0.1 0  6.28 0\"",
           "oscillators=\"3  3 0 0 0 0.3 0 0.9  0 0.1 0 0 0 0.1  6.28 0\"", Takes::both, Carved::refused},
          {"AttachProjectiveConstraint", "object1=\"@s\" object2=\"@s\" indices1=\"6\" indices2=\"13\"",
           "object1=\"@s\" object2=\"@s\" indices1=\"1\" indices2=\"3\""},
          {"PatchTestMovementProjectiveConstraint",
           "indices=\"6 27 90 111\" " + corners, two + corners, Takes::points}};
}

std::string element(const Recipe& recipe, const std::string& attributes) {
  return "<" + recipe.type + " name=\"tested\" " + attributes + "/>";
}

/// Those that may be placed after the linear solve.
const std::set<std::string> after_the_solve = {
    "FixedProjectiveConstraint",          "FixedTranslationProjectiveConstraint", "AffineMovementProjectiveConstraint",
    "ProjectToPointProjectiveConstraint", "ProjectToLineProjectiveConstraint",    "ProjectToPlaneProjectiveConstraint",
    "ParabolicProjectiveConstraint",      "HermiteSplineProjectiveConstraint",    "OscillatorProjectiveConstraint",
    "AttachProjectiveConstraint",         "DirectionProjectiveConstraint",        "PatchTestMovementProjectiveConstraint"};

/// The recipes, and what has a scene on its manual page that is enough. No module is opened here: each test is a process.
std::vector<Case> cases() {
  std::vector<Case> all;
  for (const Recipe& recipe : recipes()) {
    const std::string& type = recipe.type;
    if (after_the_solve.count(type))
      all.push_back({type + "AfterTheSolve", block(element(recipe, recipe.of_points + " inMatrix=\"false\"")), type, recipe.carved});
    if (recipe.takes != Takes::frames) all.push_back({type, block(element(recipe, recipe.of_points)), type, recipe.carved});
    if (recipe.takes != Takes::points) all.push_back({type + "OfFrames", frames(element(recipe, recipe.of_frames)), type});
  }
  for (const auto& [type, attributes] : std::vector<std::pair<std::string, std::string>>{
           {"FixedProjectiveConstraint", "indices=\"1 3\""},
           {"LinearMovementProjectiveConstraint", "indices=\"0 2\" keyTimes=\"0 1\" movements=\"0 2\" outside=\"hold\""},
           {"LinearVelocityProjectiveConstraint", "indices=\"1\" keyTimes=\"0 1\" velocities=\"1 3\""},
           {"LinearRelationProjectiveConstraint", "indices=\"1 2 3\" coefficients=\"1 -2 1\""}})
    all.push_back({type + "OfNumbers", numbers("<" + type + " name=\"tested\" " + attributes + "/>"), type});
  for (const char* type : {"ReadState", "InterventionalRadiologyController"}) all.push_back({type, "", type});
  return all;
}
std::string sceneOf(const Case& c) { return c.scene.empty() ? exampleIn(modules().manual(c.type)) : c.scene; }
std::vector<Case> carvedCases() {
  std::vector<Case> all = cases();
  std::erase_if(all, [](const Case& c) { return c.carved == Carved::no; });
  return all;
}

TEST(ProjectiveConstraints, AreAllHere) {
  modules().openAll();
  const std::vector<Case> all = cases();
  std::set<std::string> after;
  for (const ComponentEntry* entry : factory().entries()) {
    const auto component = factory().make(entry->type);
    if (entry->module.empty() || !dynamic_cast<ProjectiveConstraint*>(component.get())) continue;
    EXPECT_TRUE(std::any_of(all.begin(), all.end(), [entry](const Case& c) { return c.type == entry->type; }))
        << entry->type << " is registered as a projective constraint, and nothing tests it: write a recipe here";
    if (component->data().find("inMatrix")) after.insert(entry->type);
  }
  EXPECT_EQ(after, after_the_solve);
}

const ProjectiveConstraint* constraintIn(const System& system, const std::string& type) {
  for (const ProjectiveConstraint* constraint : system.constraints().all())
    if (constraint->type() == type) return constraint;
  return nullptr;
}
System& systemWith(const Simulation& simulation, const std::string& type) {
  for (const auto& system : simulation.systems())
    if (constraintIn(*system, type)) return *system;
  throw std::runtime_error("no system has a " + type);
}

Vector projected(const System& system, const Vector& rows) {
  Vector out(rows.count());
  copy(rows, out);
  system.constraints().project(out);
  return out;
}

/// One symmetric projection, which is not the whole, and has in it what this constraint says.
void expectProjection(const System& system, const ProjectiveConstraint& constraint, double t) {
  const Vector q = randomRows(system.independentRows(), 3), other = randomRows(system.independentRows(), 4), p = projected(system, q);
  EXPECT_LT(farthest(p, projected(system, p)), 1e-14) << "what is free stays";
  const Data* in_matrix = constraint.data().find("inMatrix");
  if (in_matrix && in_matrix->print() == "false") {
    EXPECT_EQ(farthest(p, q), 0) << "free in the matrix";
    return;
  }
  EXPECT_GT(farthest(p, q), 1e-3) << "something is held";
  EXPECT_NEAR(dot(other, p), dot(projected(system, other), q), 1e-12);
  std::vector<NodeProjector> own;
  constraint.addProjectors(t, own);
  EXPECT_TRUE(norm(p) > 1e-3 || Index(own.size()) == system.independentRows()) << "and not all";
  for (const NodeProjector& held : own) {
    EXPECT_LT((held.projector * held.projector - held.projector).norm(), 1e-14) << "row " << held.row;
    EXPECT_LT((held.projector - held.projector.transpose()).norm(), 1e-15) << "row " << held.row;
    EXPECT_LT((held.projector * Vec3(p[held.row]) - Vec3(p[held.row])).norm(), 1e-14) << "row " << held.row;
  }
  std::vector<Tie> ties;
  constraint.addTies(ties);
  for (const Tie& tie : ties) EXPECT_LT((p[tie.a] - p[tie.b]).norm(), 1e-14) << "rows " << tie.a << " and " << tie.b;
  LinearRelations relations;
  constraint.addRelations(relations);
  for (Index r = 0; r < relations.count(); ++r) {
    double sum = 0;
    for (const auto* term = relations.begin(r); term != relations.end(r); ++term) sum += term->coefficients.dot(p[term->row]);
    EXPECT_NEAR(sum, 0, 1e-13) << "relation " << r;
  }
}

/// Free directions go to free ones, as the products do, and held ones to held ones.
void expectRowsOfTheMatrix(System& system) {
  MechanicalMatrix& matrix = system.matrix().withFactors({.mass = 2, .stiffness = -0.01});
  const Vector q = randomRows(system.independentRows(), 5), p = projected(system, q);
  Vector held(q.count()), by_product(q.count()), assembled(q.count()), of_held(q.count());
  copy(q, held);
  axpy(-1, p, held);
  matrix.multiply(p, by_product);
  const BlockMatrix& blocks = matrix.assemble();
  blocks.multiply(p, assembled);
  blocks.multiply(held, of_held);
  const double size = norm(by_product) + norm(of_held);
  EXPECT_EQ(norm(by_product) > 0, norm(p) > 0);
  EXPECT_LT(farthest(by_product, assembled), 1e-12 * size);
  EXPECT_LT(farthest(assembled, projected(system, assembled)), 1e-12 * size) << "of free directions";
  EXPECT_LT(norm(projected(system, of_held)), 1e-12 * size) << "of held directions";
  EXPECT_EQ(dot(held, of_held) > 0, norm(held) > 0) << "the matrix is regular";
  Vector all(q.count());
  blocks.multiply(q, all);
  axpy(-1, assembled, all);
  EXPECT_LT(farthest(all, of_held), 1e-12 * size);
}

/// A step changes velocities in free directions alone, or has what is moved where its motion is.
void expectMotion(Simulation& simulation, System& system, const ProjectiveConstraint& constraint) {
  Vector x(system.allRows()), v(system.allRows());
  copy(system.v, v);
  ASSERT_FALSE(simulation.step().diverged);
  const double t = simulation.time();
  std::vector<NodeProjector> own;
  constraint.addProjectors(t, own);
  if (!constraint.prescribesMotion() && !constraint.projectsVelocity())
    for (const NodeProjector& held : own) {
      const Vec3 change = system.v[held.row] - v[held.row];
      EXPECT_LT((held.projector * change - change).norm(), 1e-12) << "row " << held.row;
    }
  if (!constraint.prescribesMotion() || !constraint.activeIn(t - 0.01, t)) return;
  copy(system.x, x);
  copy(system.v, v);
  constraint.prescribe(t, x, v);
  EXPECT_LT(farthest(x, system.x), 1e-12) << "places";
  EXPECT_LT(farthest(v, system.v), 1e-10) << "velocities";
}

void expectContract(Simulation& simulation, const std::string& type) {
  System& system = systemWith(simulation, type);
  const ProjectiveConstraint& constraint = *constraintIn(system, type);
  expectMotion(simulation, system, constraint);
  if (!constraint.activeIn(simulation.time() - 0.01, simulation.time())) return;
  expectProjection(system, constraint, simulation.time());
  expectRowsOfTheMatrix(system);
}

class ConstraintFiles : public WorkingFolderTest {
 protected:
  void SetUp() override {
    WorkingFolderTest::SetUp();
    writeExampleFiles(folder_ / "meshes");
  }
};
class ProjectiveConstraintContract : public ConstraintFiles, public testing::WithParamInterface<Case> {};
class CarvedConstraintContract : public testing::TestWithParam<Case> {};

TEST_P(ProjectiveConstraintContract, HoldsInSteps) {
  Simulation simulation = simulationFromText(sceneOf(GetParam()));
  for (int step = 0; step < 3; ++step) expectContract(simulation, GetParam().type);
}

/// Projectors by the places at rest.
std::map<std::array<long, 3>, Mat3> heldPlaces(const Simulation& simulation, const std::string& type) {
  const System& system = systemWith(simulation, type);
  const ProjectiveConstraint& constraint = *constraintIn(system, type);
  std::vector<NodeProjector> own;
  constraint.addProjectors(simulation.time(), own);
  std::map<std::array<long, 3>, Mat3> places;
  for (const NodeProjector& held : own) {
    const Vec3& rest = constraint.state().rest_position[std::size_t(held.row - constraint.state().firstRow())];
    places[{std::lround(rest.x()), std::lround(rest.y()), std::lround(rest.z())}] = held.projector;
  }
  return places;
}

TEST_P(CarvedConstraintContract, HoldsOfAMeshThatHasLostCells) {
  std::string scene = GetParam().scene;
  scene.insert(scene.rfind("</Node>"), "<CarvingRegion box=\"0 -9 -9 0.9 9 9\" begin=\"0.01\" end=\"0.01\"/>");
  Session session;
  session.loadText(scene, "scene.xml");
  session.followMeshChanges();
  ASSERT_EQ(session.run({.steps = 1}).end, RunEnd::done);
  const auto before = heldPlaces(session.simulation(), GetParam().type);
  const RunReport report = session.run({.steps = 2});
  if (GetParam().carved == Carved::refused) {
    EXPECT_EQ(report.end, RunEnd::mesh_refused);
    expectContains(report.reason, "/tested.");
    return;
  }
  ASSERT_EQ(report.end, RunEnd::done) << report.reason;
  ASSERT_TRUE(session.simulation().hasChangedMeshes());
  const auto after = heldPlaces(session.simulation(), GetParam().type);
  EXPECT_EQ(after.size(), before.size());
  for (const auto& [place, projector] : before) EXPECT_TRUE(after.count(place) && (after.at(place) - projector).norm() < 1e-12);
  expectContract(session.simulation(), GetParam().type);
}

TEST_F(ConstraintFiles, GiveTheSameBitsWithTwoThreads) {
  for (const Case& each : cases()) {
    std::uint64_t hashes[2] = {};
    for (const int threads : {1, 2}) {
      setThreads(threads);
      Simulation simulation = simulationFromText(sceneOf(each));
      for (int step = 0; step < 2; ++step) simulation.step();
      hashes[threads - 1] = simulation.stateHash();
    }
    setThreads(1);
    EXPECT_EQ(hashes[0], hashes[1]) << each.name;
  }
}

INSTANTIATE_TEST_SUITE_P(Constraints, ProjectiveConstraintContract, testing::ValuesIn(cases()),
                         [](const auto& values) { return values.param.name; });
INSTANTIATE_TEST_SUITE_P(Constraints, CarvedConstraintContract, testing::ValuesIn(carvedCases()),
                         [](const auto& values) { return values.param.name; });

/// What takes no points, or no frames, says so.
TEST(ProjectiveConstraints, RefuseWhatTheyDoNotTake) {
  int refused = 0;
  for (const Recipe& recipe : recipes()) {
    if (recipe.takes == Takes::both) continue;
    const std::string problems = recipe.takes == Takes::points ? problemsOf(frames(element(recipe, recipe.of_frames)))
                                                               : problemsOf(block(element(recipe, recipe.of_points)));
    expectContains(problems, "/tested: ");
    expectContains(problems, recipe.takes == Takes::points ? "has rigid frames" : "a state of template Rigid3");
    ++refused;
  }
  EXPECT_EQ(refused, 9);
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
