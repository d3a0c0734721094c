// SPDX-License-Identifier: LGPL-2.1-or-later
// Penalty forces of collision models: their formula, what has contacts and what has not, momentum, the watch.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <sstream>

#include "framework/simulation/simulation.h"
#include "tests/support/field_under_test.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

std::string collisionScene(const std::string& bodies, const std::string& method, const std::string& gravity = "0 0 0",
                           const std::string& response = "<CollisionResponse name=\"response\"/>") {
  return fmt::format("<Node name=\"root\" dt=\"0.01\" gravity=\"{}\"><CollisionPipeline/>{}{}{}</Node>", gravity, response,
                     method, bodies);
}
const std::string near_half = "<MinProximityIntersection alarmDistance=\"1\" contactDistance=\"0.5\"/>";

/// A body that moves; of one node for each position.
std::string moved(const std::string& name, const std::string& position, const std::string& more,
                  const std::string& velocity = "") {
  return fmt::format(
      "<Node name=\"{}\"><EulerImplicitSolver/><CGLinearSolver iterations=\"100\" tolerance=\"1e-14\"/><MechanicalObject "
      "name=\"dofs\" position=\"{}\" {}/><UniformMass totalMass=\"2\"/>{}</Node>",
      name, position, velocity.empty() ? "" : "velocity=\"" + velocity + "\"", more);
}

std::string still(const std::string& mesh, const std::string& models) {
  return "<Node name=\"floor\"><MeshTopology " + mesh + "/><MechanicalObject/>" + models + "</Node>";
}
const std::string plate = "position=\"-1 0 -2  2 0 -1  0 0 2\" triangles=\"0 1 2\" edges=\"0 1\"";

/// The force on the first node of what moves, and how many contacts push.
struct Pushed {
  Vec3 force;
  int contacts;
};
Pushed pushed(const std::string& scene) {
  bool acts = false;  // where nothing may meet it acts on nothing
  const Simulation simulation = simulationFromText(scene);
  for (const auto& system : simulation.systems())
    for (const ForceField* field : system->forceFields()) acts = acts || field->type() == "CollisionResponse";
  if (!acts) return {Vec3::Zero(), 0};
  FieldUnderTest t(scene, "CollisionResponse");
  const Vector f = t.force();
  int contacts = 0;
  std::istringstream(t.field().data().find("contacts")->print()) >> contacts;
  return {f[0], contacts};
}

/// k = k1 k2/d, d with skins and radii; n from one surface to the other.
TEST(CollisionResponse, HasItsFormula) {
  const std::string point = "<PointCollisionModel contactStiffness=\"30\" contactDistance=\"0.1\"/>";
  const std::string top = "<TriangleCollisionModel simulated=\"0\" contactStiffness=\"4\" contactDistance=\"0.05\"/>";
  const double d = 0.5 + 0.1 + 0.05, k = 30 * 4 / d;
  for (const double height : {0.2, 0.64, -0.3}) {
    const Pushed found = pushed(collisionScene(moved("a", fmt::format("0.1 {} 0.2", height), point) + still(plate, top), near_half));
    EXPECT_EQ(found.contacts, 1);
    EXPECT_NEAR((found.force - Vec3(0, (height > 0 ? 1 : -1) * k * (d - std::abs(height)), 0)).norm(), 0, 1e-10) << height;
  }
  const Pushed out = pushed(collisionScene(moved("a", "0.1 0.66 0.2", point) + still(plate, top), near_half));
  EXPECT_EQ(out.contacts, 0);
  const std::string sphere = "<SphereCollisionModel radius=\"0.3\" contactStiffness=\"30\"/>";
  const double with_radius = 0.5 + 0.3 + 0.05;
  const Pushed ball = pushed(collisionScene(moved("a", "0.1 0.7 0.2", sphere) + still(plate, top), near_half));
  EXPECT_NEAR(ball.force.y(), 30 * 4 / with_radius * (with_radius - 0.7), 1e-10);
}

/// Some triangles, lines and points that drift together, each node its own way, and pass through another such body.
std::string drifting(const std::string& name, double at, double speed, unsigned seed) {
  std::mt19937 numbers(seed);
  std::uniform_real_distribution<double> any(-1, 1);
  std::string places, ways, triangles;
  for (int i = 0; i < 12; ++i) {
    places += fmt::format("{} {} {}  ", at + 0.5 * any(numbers), any(numbers), any(numbers));
    ways += fmt::format("{} {} {}  ", speed + 0.2 * any(numbers), 0.2 * any(numbers), 0.2 * any(numbers));
    if (i >= 2) triangles += fmt::format("{} {} {}  ", i - 2, i - 1, i);
  }
  return moved(name, places,
               fmt::format("<MeshTopology triangles=\"{}\"/><TriangleCollisionModel contactStiffness=\"0.1\"/><LineCollisionModel "
                           "contactStiffness=\"0.1\"/><PointCollisionModel contactStiffness=\"0.1\"/>", triangles),
               ways);
}

/// What is not looked at has no contact: in each step there are those that a search finds which knows nothing of the steps before.
TEST(CollisionResponse, FindsWhatAFirstSearchFinds) {
  for (const std::string type : {"MinProximityIntersection", "NewProximityIntersection", "LocalMinDistance"}) {
    const std::string scene = collisionScene(drifting("a", -1.5, 1, 1) + drifting("b", 1.5, -1, 2) + drifting("c", 20, -0.5, 3),
                                             "<" + type + " alarmDistance=\"0.2\" contactDistance=\"0.1\"/>");
    const auto found = [](Simulation& simulation) {
      EXPECT_FALSE(simulation.step().failed());
      std::vector<Component*> components;
      simulation.root().collect(components);
      for (const Component* component : components)
        if (component->type() == "CollisionResponse")
          return component->data().find("pairs")->print() + " " + component->data().find("gaps")->print();
      return std::string();
    };
    Simulation simulation = simulationFromText(scene);
    int none = 0;
    for (int step = 0; step < 300; ++step) {
      Simulation first = simulationFromText(scene);
      for (std::size_t s = 0; s < first.systems().size(); ++s)
        copy(simulation.systems()[s]->x, first.systems()[s]->x), copy(simulation.systems()[s]->v, first.systems()[s]->v);
      const std::string now = found(simulation);
      ASSERT_EQ(now, found(first)) << type << ", step " << step;
      none += now == " ";
    }
    EXPECT_GT(none, 50) << type;
    EXPECT_LT(none, 250) << type;
  }
}

/// A surface of nothing meets nothing.
TEST(CollisionResponse, ASurfaceMayBeEmpty) {
  const std::string none = "<MeshTopology edges=\"0 1\"/><TriangleCollisionModel/><PointCollisionModel/>";
  EXPECT_EQ(pushed(collisionScene(moved("a", "0.1 3 0.2  1 3 0.2", none) + still(plate, "<TriangleCollisionModel/>"),
                                  "<NewProximityIntersection alarmDistance=\"1\" contactDistance=\"0.5\"/>")).contacts, 0);
}

/// What meets: points lie over triangles, not beside them; lines cross; corners of triangles belong to one of them.
TEST(CollisionResponse, HasTheContactsOfTheMethod) {
  const std::string point = "<PointCollisionModel/>", top = "<TriangleCollisionModel simulated=\"0\"/>";
  const auto contactsOf = [](const std::string& scene) { return pushed(scene).contacts; };
  EXPECT_EQ(contactsOf(collisionScene(moved("a", "0 0.2 2.1", point) + still(plate, top), near_half)), 0) << "beside";
  EXPECT_EQ(contactsOf(collisionScene(moved("a", "0.5 0.2 -1.5", point) + still(plate, "<LineCollisionModel simulated=\"0\"/>"),
                                      near_half)), 1);
  EXPECT_EQ(contactsOf(collisionScene(moved("a", "-1 0.2 -2.1", point) + still(plate, "<PointCollisionModel simulated=\"0\"/>"),
                                      near_half)), 1);
  const std::string line = moved("a", "0.5 0.2 -3  0.5 0.2 0",
                                 "<EdgeSetTopologyContainer position=\"0.5 0.2 -3  0.5 0.2 0\" edges=\"0 1\"/><LineCollisionModel/>");
  EXPECT_EQ(contactsOf(collisionScene(line + still(plate, "<LineCollisionModel simulated=\"0\"/>"), near_half)), 1);
  const std::string no_lines = "<MinProximityIntersection alarmDistance=\"1\" contactDistance=\"0.5\" useLineLine=\"0\"/>";
  EXPECT_EQ(contactsOf(collisionScene(line + still(plate, "<LineCollisionModel simulated=\"0\"/>"), no_lines)), 0);
  // two triangles that share an edge, over one: four corners
  const std::string positions = "0 0.2 0  0.3 0.2 0  0.3 0.2 0.3  0 0.2 0.3";
  const std::string sheet = moved("a", positions,
                                  "<MeshTopology position=\"" + positions + "\" triangles=\"0 1 2  0 2 3\"/><TriangleCollisionModel/>");
  const std::string all = "<NewProximityIntersection alarmDistance=\"1\" contactDistance=\"0.5\"/>";
  EXPECT_EQ(contactsOf(collisionScene(sheet + still(plate, top), all)), 4);
  EXPECT_EQ(contactsOf(collisionScene(sheet + still(plate, top), near_half)), 0) << "triangles do not meet triangles there";
}

/// Two bodies, each with an integrator, at an angle: force, product and matrix belong together.
TEST(CollisionResponse, ForceProductAndMatrixBelongTogether) {
  const std::string mesh = "position=\"0 0 0  1 0.1 0  0.2 0 1\" triangles=\"0 1 2\"";
  FieldUnderTest t(collisionScene(moved("a", "0.4 0.3 0.3", "<SphereCollisionModel radius=\"0.1\"/>") +
                                      moved("b", "0 0 0  1 0.1 0  0.2 0 1",
                                            "<MeshTopology " + mesh + "/><TriangleCollisionModel/>"),
                                  near_half),
                   "CollisionResponse");
  const Vector f = t.force();
  ASSERT_GT(dot(f, f), 1);
  Vec3 sum = Vec3::Zero();
  for (Index i = 0; i < f.count(); ++i) sum += f[i];
  EXPECT_LT(sum.norm(), 1e-12);
  BlockMatrix k = t.matrix();
  Vector assembled(t.x.count());
  k.multiply(t.direction, assembled);
  EXPECT_LT(relativeDifference(assembled, t.product(t.direction)), 1e-12);
  EXPECT_LT(relativeDifference(t.differenceOfForces(1e-6), t.product(t.direction)), 1e-6);
  expectSymmetricProducts(t);
  const double step = 1e-6;
  Vector up(t.x.count()), down(t.x.count());
  copy(t.x, up), copy(t.x, down);
  axpy(step, t.direction, up), axpy(-step, t.direction, down);
  EXPECT_NEAR((t.field().energy(up) - t.field().energy(down)) / (2 * step), -dot(f, t.direction), 1e-6);
}

/// A ball comes to rest where its weight is k times what it has gone in.
TEST(CollisionResponse, ABallRestsOnAFloor) {
  const std::string ball = "<SphereCollisionModel radius=\"0.3\" contactStiffness=\"100\"/><UniformVelocityDampingForceField "
                           "dampingCoefficient=\"20\"/>";
  Simulation simulation = simulationFromText(collisionScene(
      moved("a", "0 0.9 0", ball) + still(plate, "<TriangleCollisionModel simulated=\"0\" contactStiffness=\"10\"/>"), near_half,
      "0 -10 0"));
  for (int i = 0; i < 500; ++i) ASSERT_FALSE(simulation.step().failed());
  EXPECT_NEAR(simulation.states()[0]->x()[0].y(), 0.8 - 2 * 10 / (100 * 10 / 0.8), 1e-6);
}

/// Two bodies of an integrator each fly into each other: what they have together stays.
TEST(CollisionResponse, MomentumIsKept) {
  const std::string sphere = "<SphereCollisionModel radius=\"0.5\" contactStiffness=\"100\"/>";
  Simulation simulation = simulationFromText(collisionScene(
      moved("a", "0 0 0", sphere, "1 0 0") + moved("b", "2 0.3 0", sphere, "-3 0 0"),
      "<MinProximityIntersection alarmDistance=\"0.5\" contactDistance=\"0.1\"/>"));
  ASSERT_EQ(simulation.systems().size(), 1u) << "they may meet";
  for (int i = 0; i < 100; ++i) ASSERT_FALSE(simulation.step().failed());
  const Vec3 a = simulation.states()[0]->v()[0], b = simulation.states()[1]->v()[0];
  EXPECT_NEAR((a + b - Vec3(-2, 0, 0)).norm(), 0, 1e-9);
  EXPECT_LT(a.x(), -0.5) << "they met";
}

/// A strip that is folded over meets itself with selfCollision; what is near at rest does not push.
TEST(CollisionResponse, AModelMeetsItself) {
  std::string rest, now, edges;
  for (int i = 0; i < 6; ++i) {
    rest += fmt::format("{} 0 0  ", i);
    now += i < 3 ? fmt::format("{} 0 0  ", i) : fmt::format("{} 0.3 0  ", 5.3 - i);
    if (i > 0) edges += fmt::format("{} {}  ", i - 1, i);
  }
  for (const bool folded : {true, false})
    for (const int self : {0, 1}) {
      SCOPED_TRACE(fmt::format("folded {}, selfCollision {}", folded, self));
      const std::string models = fmt::format("<EdgeSetTopologyContainer position=\"{0}\" edges=\"{1}\"/><PointCollisionModel "
                                             "selfCollision=\"{2}\"/><LineCollisionModel selfCollision=\"{2}\"/>",
                                             now, edges, self);
      std::string strip = moved("a", now, models);
      if (folded) strip.replace(strip.find("position="), 0, "rest_position=\"" + rest + "\" ");
      Simulation simulation = simulationFromText(collisionScene(strip, near_half));
      ASSERT_FALSE(simulation.step().failed());
      double fastest = 0;
      for (Index i = 0; i < 6; ++i) fastest = std::max(fastest, simulation.states()[0]->v()[i].norm());
      EXPECT_EQ(fastest > 0, folded && self == 1);
    }
}

/// Where the distance of a contact is zero the stiffness is k1 k2, as SOFA's: a point that has gone through is led back.
TEST(CollisionResponse, HasAStiffnessAlsoWithoutADistance) {
  std::string point = moved("a", "0.1 0.1 0.2", "<PointCollisionModel contactStiffness=\"30\"/>", "0 -40 0");
  point.replace(point.find("<EulerImplicitSolver/>"), 22, "<EulerImplicitSolver newtonIterations=\"20\"/>");
  Simulation simulation = simulationFromText(
      collisionScene(point + still(plate, "<TriangleCollisionModel simulated=\"0\" contactStiffness=\"4\"/>"),
                     "<MinProximityIntersection alarmDistance=\"1\" contactDistance=\"0\"/>"));
  ASSERT_FALSE(simulation.step().failed());
  // m v' = m v + h k (depth at the end of the step): 0.1 + h v'
  const double h = 0.01, k = 120, m = 2, after = simulation.states()[0]->v()[0].y();
  EXPECT_NEAR(m * (after + 40), -h * k * (0.1 + h * after), 1e-9);
  EXPECT_GT(after, -40);
}

/// A matrix keeps its pattern as long as the same nodes meet.
TEST(CollisionResponse, ThePatternChangesWithTheContacts) {
  Simulation simulation = simulationFromText(collisionScene(
      moved("a", "0.1 1.95 0.2", "<PointCollisionModel contactStiffness=\"30\"/>", "0 -1 0") +
          still(plate, "<TriangleCollisionModel simulated=\"0\" contactStiffness=\"4\"/>"),
      near_half));
  const ForceField* field = nullptr;
  for (const ForceField* each : simulation.systems()[0]->forceFields())
    if (each->type() == "CollisionResponse") field = each;
  ASSERT_TRUE(field);
  const auto run = [&](int steps) {
    for (int i = 0; i < steps; ++i) ASSERT_FALSE(simulation.step().failed());
  };
  run(1);
  const long before = field->patternRevision();
  run(80);
  EXPECT_EQ(field->patternRevision(), before) << "nothing is near";
  run(20);
  const long near = field->patternRevision();
  EXPECT_GT(near, before);
  run(20);
  EXPECT_EQ(field->patternRevision(), near) << "the same point meets the same triangle";
}

TEST(CollisionResponse, ParametersThatNothingReadsAreSaid) {
  const auto with = [](const std::string& parameters) {
    return problemsOf(collisionScene(moved("a", "0.1 2 0.2", "<PointCollisionModel/>") +
                                         still(plate, "<TriangleCollisionModel simulated=\"0\"/>"),
                                     near_half, "0 0 0",
                                     "<CollisionResponse response=\"FrictionContactConstraint\" responseParams=\"" + parameters +
                                         "\"/>"));
  };
  EXPECT_EQ(with("mu=0.3"), "");
  EXPECT_EQ(with("mu=0.3&amp;tol=1e-3"), "");
  expectContains(with("mu=much"), "responseParams has \"mu=much\"");
  expectContains(with("0.3"), "responseParams has \"0.3\"");
  expectContains(with("friction=0.3"), "which is not a parameter");
  expectContains(with("mu=-1"), "mu is -1");
}

TEST(CollisionResponse, WordsOfRulesAreChecked) {
  const auto with = [](const std::string& rules, const std::string& of_model = "") {
    return problemsOf(collisionScene(moved("a", "0.1 2 0.2", "<PointCollisionModel contactResponse=\"" + of_model + "\"/>") +
                                         still(plate, "<TriangleCollisionModel simulated=\"0\"/>"),
                                     near_half, "0 0 0", "<CollisionResponse rules=\"" + rules + "\"/>"));
  };
  EXPECT_EQ(with("* 3 FrictionContactConstraint?mu=0.3"), "");
  expectContains(with("* 3"), "rules has 2 words");
  expectContains(with("* 3 Glue"), "rules has \"Glue\", which is not a response");
  expectContains(with("* 3 FrictionContactConstraint?mu=much"), "mu=much");
  expectContains(with("", "Glue"), "contactResponse has \"Glue\", which is not a response");
}

TEST(CollisionResponse, ASurfaceWithoutAMeshIsRefused) {
  for (const char* model : {"<TriangleCollisionModel/>", "<LineCollisionModel/>"})
    expectContains(problemsOf(collisionScene(moved("a", "0.1 2 0.2", model), near_half)), "there is no mesh for this surface");
  EXPECT_EQ(problemsOf(collisionScene(moved("a", "0.1 2 0.2", "<TriangleCollisionModel active=\"0\"/>"), near_half)), "");
}

TEST(CollisionPipeline, ModelsThatMeetNobodyAreTold) {
  const auto told = [](const std::string& method, const std::string& model) {
    return simulationFromText(collisionScene(moved("a", "0.1 2 0.2", "<PointCollisionModel/>") + still(plate, model), method))
        .scene()
        .diagnostics.text();
  };
  const std::string top = "<TriangleCollisionModel name=\"top\" simulated=\"0\"/>", sentence = "bodies pass through each other";
  expectContains(told("<DiscreteIntersection name=\"method\"/>", top), "do not meet by /method, nor do any others: " + sentence);
  expectContains(told("", top), "do not meet by DiscreteIntersection, which there is without another");
  EXPECT_EQ(told(near_half, top).find(sentence), std::string::npos);
  EXPECT_EQ(told("<DiscreteIntersection/>", "").find(sentence), std::string::npos) << "one model, which nobody could meet";
}

/// Two balls meet, and neither meets the floor.
TEST(CollisionPipeline, BodiesThatDoNotMeetAreToldWhereOthersDo) {
  const std::string ball = "<SphereCollisionModel name=\"ball\" radius=\"0.1\"/>";
  const std::string bodies = moved("a", "0.1 2 0.2", ball) + moved("b", "0.1 3 0.2", ball) +
                             still(plate, "<TriangleCollisionModel name=\"top\" simulated=\"0\"/>");
  const auto told = [&](const std::string& method) {
    return simulationFromText(collisionScene(bodies, method)).scene().diagnostics.text();
  };
  expectContains(told("<DiscreteIntersection name=\"method\"/>"), "these bodies pass through each other");
  EXPECT_EQ(told(near_half).find("pass through"), std::string::npos);
}

/// Cones of normals leave what bends inwards to triangles: where a surface of faces meets by lines and points alone, that is told.
TEST(CollisionPipeline, LinesWithoutTrianglesWithinConesAreTold) {
  const auto told = [](const std::string& method, const std::string& models) {
    return simulationFromText(collisionScene(moved("a", "0.1 2 0.2", "<PointCollisionModel/>") + still(plate, models),
                                             "<" + method + " name=\"method\" alarmDistance=\"1\" contactDistance=\"0.5\"/>"))
        .scene()
        .diagnostics.text();
  };
  const std::string lines = "<LineCollisionModel name=\"rim\" simulated=\"0\"/><PointCollisionModel simulated=\"0\"/>";
  const std::string sentence = "meet by /method without triangles: where";
  expectContains(told("LocalMinDistance", lines), sentence);
  expectContains(told("LocalMinDistance", lines), "/rim is hollow or bends inwards");
  EXPECT_EQ(told("LocalMinDistance", lines + "<TriangleCollisionModel simulated=\"0\"/>").find(sentence), std::string::npos);
  EXPECT_EQ(told("LocalMinDistance filterIntersection=\"0\"", lines).find(sentence), std::string::npos);
  EXPECT_EQ(told("MinProximityIntersection", lines).find(sentence), std::string::npos);
  EXPECT_EQ(told("LocalMinDistance", "<PointCollisionModel simulated=\"0\"/>").find(sentence), std::string::npos);
}

TEST(CollisionResponse, OneAnswers) {
  expectContains(problemsOf(collisionScene(moved("a", "0.1 2 0.2", "<PointCollisionModel/>"), near_half, "0 0 0",
                                           "<CollisionResponse/><CollisionResponse/>")),
                 "the scene has 2 of these");
}

TEST(CollisionResponse, WithoutAPipelineNothingIsFound) {
  const std::string scene = "<Node name=\"root\" dt=\"0.01\" gravity=\"0 0 0\"><CollisionResponse/>" + near_half +
                            moved("a", "0.1 0.2 0.2", "<PointCollisionModel/>") +
                            still(plate, "<TriangleCollisionModel simulated=\"0\"/>") + "</Node>";
  Simulation simulation = simulationFromText(scene);
  ASSERT_FALSE(simulation.step().failed());
  EXPECT_EQ(simulation.states()[0]->v()[0].norm(), 0);
}

/// Another response does not act, and the pipeline says so where something would touch.
TEST(CollisionResponse, OtherResponsesLeaveAWatch) {
  Simulation simulation = simulationFromText(
      collisionScene(moved("a", "0.1 0.2 0.2", "<PointCollisionModel/>") + still(plate, "<TriangleCollisionModel simulated=\"0\"/>"),
                     near_half, "0 0 0", "<CollisionResponse response=\"StickContactForceField\"/>"));
  const StepReport report = simulation.step();
  EXPECT_TRUE(report.diverged);
  expectContains(report.reason, "0.2 m apart");
  expectContains(report.reason, "no response StickContactForceField");
}

/// A point between two plates that are nearer to each other than two contact distances, and another one whose two ends are held
/// apart.
StepReport squeezed(const std::string& tolerated, const std::string& more) {
  const auto wall = [](const std::string& name, double y) {
    return fmt::format("<Node name='{0}'><MeshTopology position='-1 {1} -2  2 {1} -1  0 {1} 2' triangles='{2}'/><MechanicalObject/>"
                       "<TriangleCollisionModel moving='false' simulated='false'/></Node>",
                       name, y, y < 0 ? "0 2 1" : "0 1 2");
  };
  Simulation simulation = simulationFromText(fmt::format(
      "<Node name='root' dt='0.01' gravity='0 0 0'><CollisionPipeline/><CollisionResponse response='FrictionContactConstraint' {}/>"
      "<MinProximityIntersection alarmDistance='0.02' contactDistance='0.01'/>{}{}<Node name='bodies'><EulerImplicitSolver/>"
      "<SparseLDLSolver/><Node name='a'><MechanicalObject name='dofs' position='0 0 0  5 0 0'/><UniformMass totalMass='1'/>"
      "<PointCollisionModel/></Node>{}</Node></Node>",
      tolerated, wall("floor", -0.006), wall("ceiling", 0.006), more));
  return simulation.step();
}

TEST(CollisionResponse, ToleratesErrorsOfItsOwnContactsAlone) {
  const StepReport refused = squeezed("", "");
  EXPECT_FALSE(refused.constraints_converged);
  const StepReport kept = squeezed("toleratedError='0.01'", "");
  EXPECT_TRUE(kept.constraints_converged) << kept.constraint_reason;
  EXPECT_EQ(kept.constraint_reason, refused.constraint_reason) << "what is kept is told";
  const std::string held =
      "<Node name='p'><MechanicalObject name='dofs' position='5 0.002 0  5 -0.002 0'/><UniformMass totalMass='1'/>"
      "<FixedProjectiveConstraint fixAll='true'/></Node><BilateralLagrangianConstraint name='ends' object1='@a/dofs' "
      "object2='@p/dofs' first_point='1 1' second_point='0 1'/>";
  const StepReport other = squeezed("toleratedError='0.01'", held);
  EXPECT_FALSE(other.constraints_converged) << "a tie is off by less than what contacts may be";
  EXPECT_NE(other.constraint_reason.find("/ends"), std::string::npos) << other.constraint_reason;
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
