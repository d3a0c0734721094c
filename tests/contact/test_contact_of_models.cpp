// SPDX-License-Identifier: LGPL-2.1-or-later
// Contacts of whole surfaces from SOFA's collision models: CollisionResponse with response="BarrierContact" and alike.
#include <cmath>

#include "framework/simulation/simulation.h"
#include "tests/contact/contact_scenes.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

std::string models(const std::string& attributes = "") {
  return fmt::format("<TriangleCollisionModel name=\"t\" {0}/><LineCollisionModel name=\"l\" {0}/><PointCollisionModel name=\"p\" {0}/>",
                     attributes);
}

const std::string method = "<MinProximityIntersection name=\"method\" alarmDistance=\"0.02\" contactDistance=\"0.005\"/>";
std::string response(const std::string& name, const std::string& more = "") {
  return fmt::format("<CollisionPipeline name=\"pipeline\"/>{}<CollisionResponse name=\"response\" {} {}/>", method,
                     name.empty() ? "" : "response=\"" + name + "\"", more);
}

/// A square of two triangles at a height, which nothing moves.
std::string sheet(const std::string& models, double z = 0) {
  return fmt::format("<Node name=\"sheet\"><MeshTopology name=\"mesh\" position=\"-1 -1 {0}  1 -1 {0}  1 1 {0}  -1 1 {0}\" "
                     "triangles=\"0 1 2  0 2 3\"/><MechanicalObject name=\"dofs\"/>{1}</Node>", z, models);
}
/// A plate, 0.1 m wide and 4 mm thick, above it.
std::string plate(const std::string& name, const Vec3& at, double speed, const std::string& more) {
  const Body body = boxOf(at, at + Vec3(0.1, 0.1, 0.004), {2, 2, 1});
  std::string velocity;
  for (std::size_t i = 0; i < body.points.size(); ++i) velocity += fmt::format("0 0 {}  ", -speed);
  return bodyNode(name, body, more, "velocity=\"" + velocity + "\"", 1e5, 0.3);
}
/// `moved`: below an integrator.
std::string scene(const std::string& moved, const std::string& rest, double gravity = 0,
                  const std::string& solver = "<EulerImplicitSolver name=\"solver\"/>") {
  return fmt::format("<Node name=\"root\" dt=\"0.01\" gravity=\"0 0 {}\"><Node name=\"m\">{}<SparseLDLSolver/>{}</Node>{}</Node>", -gravity,
                     solver, moved, rest);
}

double lowestOf(const Simulation& simulation) {
  double lowest = 1e300;
  const Rows x = simulation.systems()[0]->x;
  for (Index i = 0; i < x.count; ++i) lowest = std::min(lowest, x[i].z());
  return lowest;
}
std::string run(Simulation& simulation, int steps) {
  for (int i = 0; i < steps; ++i)
    if (const StepReport report = simulation.step(); report.diverged || !report.constraints_converged)
      return fmt::format("step {}: {}{}", i, report.reason, report.constraint_reason);
  return {};
}

/// At 20 m/s a step is 0.2 m long, and the plate 4 mm thick.
TEST(ContactOfModels, FastPlatesPassThroughAndDoNot) {
  const std::string still_sheet = sheet(models("simulated=\"false\" moving=\"false\""));
  for (const std::string passes : {"PenalityContactForceField", "FrictionContactConstraint"}) {
    Simulation simulation = simulationFromText(scene(plate("a", {0, 0, 0.1}, 20, models()), response(passes) + still_sheet));
    EXPECT_EQ(run(simulation, 5), "") << passes;
    EXPECT_LT(lowestOf(simulation), -0.5) << passes;
  }
  Simulation simulation = simulationFromText(scene(plate("a", {0, 0, 0.1}, 20, models()), response("BarrierContact") + still_sheet));
  for (int i = 0; i < 30; ++i) {
    expectCleanStep(simulation, i, false);
    EXPECT_GT(lowestOf(simulation), 0) << i;
  }
}

std::uint64_t hashAfter(const std::string& text, int steps) {
  Simulation simulation = simulationFromText(text);
  EXPECT_EQ(run(simulation, steps), "");
  return simulation.stateHash();
}

/// Distances, skins of one and of several thicknesses, friction, an obstacle.
TEST(ContactOfModels, HaveTheBitsOfTheSameByHand) {
  const auto ofBoth = [](const std::string& of_a, const std::string& of_sheet, const std::string& contact) {
    return scene(plate("a", {0, 0, 0.02}, 1, of_a) + plate("b", {0.02, 0.01, 0.04}, 1, of_a), sheet(of_sheet) + contact, 9.81);
  };
  struct Case {
    std::string of_a, of_sheet, parameters, by_hand;
  };
  const std::string still = "simulated=\"false\" moving=\"false\"";
  for (const Case& each : {Case{models(), models(still), "mu=0.3", "friction=\"0.3\""},
                           Case{models("contactDistance=\"0.001\""), models(still + " proximity=\"0.001\""), "", "thickness=\"0.002\""},
                           Case{models("proximity=\"0.001\""), models(still), "stiffness=5e3",
                                "radii=\"0.001 0.001 0\" stiffness=\"5e3\""}})
    for (const std::string type : {"BarrierContact", "ConstraintContact", "PenaltyContact"}) {
      if (type == "ConstraintContact" && each.parameters == "stiffness=5e3") continue;
      const std::string parameters = each.parameters.empty() ? "" : "responseParams=\"" + each.parameters + "\"";
      const std::uint64_t from_models = hashAfter(ofBoth(each.of_a, each.of_sheet, response(type, parameters)), 12);
      const std::string contact =
          fmt::format("<{} mstate=\"@m/a/dofs\" topology=\"@m/a/mesh\" other=\"@m/b/dofs @sheet/dofs\" contactDistance=\"0.005\" "
                      "selfContact=\"false\" {}/>", type, each.by_hand);
      const std::uint64_t by_hand = hashAfter(ofBoth("", "", contact), 12);
      EXPECT_EQ(from_models, by_hand) << type << " " << each.by_hand;
      const std::uint64_t without = hashAfter(ofBoth("", "", ""), 12);
      EXPECT_NE(from_models, without);
    }
}

/// What has a group in common passes through each other; the rest does not.
TEST(ContactOfModels, GroupsExcludePairs) {
  const std::string plates = plate("a", {0, 0, 0.05}, 0, models("group=\"1\"")) + plate("b", {0, 0, 0.1}, 3, models("group=\"1\""));
  Simulation simulation = simulationFromText(scene(plates, response("BarrierContact") + sheet(models("simulated=\"false\""))));
  EXPECT_EQ(run(simulation, 2), "");
  const Rows x = simulation.systems()[0]->x;
  EXPECT_LT(x[x.count - 1].z(), 0.05);  // of b
  EXPECT_EQ(run(simulation, 10), "");
  EXPECT_GT(lowestOf(simulation), 0);
}

/// Balls of 2 cm rest on a sheet and on a plane at the gap of their weight: the barrier's pressure on 2 pi R contactDistance.
TEST(ContactOfModels, BallsRestAtTheGapOfTheirWeight) {
  constexpr double radius = 0.02, range = 0.005, stiffness = 1e4, mass = 0.05, gravity = 9.81;
  const double part = mass * gravity / (2 * M_PI * radius * range) / stiffness;
  double low = 1e-9, high = 1;
  for (int i = 0; i < 100; ++i) {
    const double r = 0.5 * (low + high);
    (2 * (r - 1) * std::log(r) + (r - 1) * (r - 1) / r > part ? low : high) = r;
  }
  const std::string balls = fmt::format("<Node name=\"balls\"><MechanicalObject name=\"dofs\" position=\"0.3 0.2 {}  -0.3 -0.4 {}\"/>"
                                        "<UniformMass vertexMass=\"{}\"/><SphereCollisionModel radius=\"{}\"/></Node>",
                                        radius + 0.004, radius + 0.004, mass, radius);
  const std::string damped = "<EulerImplicitSolver newtonIterations=\"60\" newtonTolerance=\"1e-9\" rayleighMass=\"20\"/>";
  for (const std::string floor : {sheet(models("simulated=\"false\"")), std::string()}) {
    const std::string contact =
        floor.empty() ? "<BarrierContact mstate=\"@m/balls/dofs\" contactDistance=\"0.005\" stiffness=\"1e4\" planes=\"0 0 1 0\"/>"
                      : response("BarrierContact", "responseParams=\"stiffness=1e4\"");
    Simulation simulation = simulationFromText(scene(balls, contact + floor, gravity, damped));
    for (int i = 0; i < 150; ++i) expectCleanStep(simulation, i);
    for (Index node = 0; node < 2; ++node) EXPECT_NEAR(simulation.systems()[0]->x[node].z(), radius + low * range, 1e-5 * range) << floor;
  }
}

/// Balls of one state meet each other if asked to. They are as far apart as their radii, and linear momentum is kept.
TEST(ContactOfModels, BallsMeetEachOther) {
  for (const std::string type : {"BarrierContact", "ConstraintContact"})
    for (const bool self : {false, true}) {
      const std::string balls =
          fmt::format("<Node name=\"balls\"><MechanicalObject name=\"dofs\" position=\"0 0 0  0.08 0.003 0\" velocity=\"2 0 0  0 0 0\"/>"
                      "<UniformMass vertexMass=\"0.1\"/><SphereCollisionModel listRadius=\"0.02 0.03\" selfCollision=\"{}\"/></Node>"
                      "<Node name=\"c\"><MechanicalObject name=\"dofs\" position=\"0 9 0\"/><UniformMass vertexMass=\"1\"/>"
                      "<PointCollisionModel/></Node>", self);
      const std::string parameters = type == "BarrierContact" ? "responseParams=\"stiffness=1e6\"" : "";
      Simulation simulation = simulationFromText(scene(balls, response(type, parameters)));
      double least = 1;
      const auto& system = *simulation.systems()[0];
      for (int i = 0; i < 10; ++i) {
        expectCleanStep(simulation, i, false);
        least = std::min(least, (system.x[0] - system.x[1]).norm());
      }
      EXPECT_EQ(least > 0.05, self) << type;
      EXPECT_NEAR((system.v[0] + system.v[1] - Vec3(2, 0, 0)).norm(), 0, 1e-7) << type;
    }
}

/// Balls leave holes in the surface of a body, so they do not replace it unless a response names them as its models.
TEST(ContactOfModels, BallsDoNotReplaceASurface) {
  const auto byHand = [](const std::string& in_plate, const std::string& in_sheet = "", const std::string& first = "a/dofs") {
    const std::string contact = fmt::format("<BarrierContact name=\"contact\" mstate=\"@m/{}\" other=\"@sheet/dofs\" "
                                            "contactDistance=\"0.005\" stiffness=\"1e4\"/>", first);
    return scene(plate("a", {0, 0, 0.02}, 1, in_plate), sheet(in_sheet) + contact, 9.81);
  };
  const auto fromModels = [](const std::string& in_plate) {
    return scene(plate("a", {0, 0, 0.02}, 1, in_plate), sheet(models("simulated=\"false\"")) + response("BarrierContact"), 9.81);
  };
  const std::string ball = "<SphereCollisionModel name=\"balls\" radius=\"0.001\"/>";
  const std::string inactive = "<SphereCollisionModel name=\"balls\" radius=\"0.001\" active=\"false\"/>";
  EXPECT_EQ(hashAfter(byHand(inactive, inactive), 12), hashAfter(byHand(""), 12));
  EXPECT_EQ(hashAfter(fromModels(models() + inactive), 12), hashAfter(fromModels(models()), 12));
  expectContains(problemsOf(byHand(ball)), "/m/a/dofs has the surface of /m/a/mesh and a SphereCollisionModel");
  expectContains(problemsOf(byHand("", ball)), "/sheet/dofs has the surface of /sheet/mesh and a SphereCollisionModel");
  // balls that were asked for: on a mapped state of their own, or as the only model of a response
  const std::string child = "<Node name=\"child\"><MechanicalObject name=\"dofs\"/>" + ball + "<IdentityMapping/></Node>";
  EXPECT_EQ(problemsOf(byHand(child, "", "a/child/dofs")), "");
  EXPECT_EQ(problemsOf(fromModels(ball)), "");
}

/// A surface that is mapped from a frame in another branch of the scene moves, and falls on a sheet.
TEST(ContactOfModels, MappedBodiesMayBeInAnotherBranch) {
  const std::string tool = "<Node name=\"tool\"><MechanicalObject name=\"frame\" template=\"Rigid3\" position=\"0 0 0.05 0 0 0 1\"/>"
                           "<UniformMass totalMass=\"0.02\" inertia=\"2e-6 2e-6 2e-6\"/></Node>";
  const std::string skin =
      "<Node name=\"skin\"><MeshTopology name=\"mesh\" position=\"-0.01 -0.01 0  0.01 -0.01 0  0 0.01 0  0 0 0.01\" "
      "triangles=\"0 2 1  0 1 3  1 2 3  2 0 3\"/><MechanicalObject name=\"dofs\"/><RigidMapping input=\"@/m/tool/frame\" "
      "output=\"@dofs\"/><TriangleCollisionModel/></Node>";
  const std::string more = "responseParams=\"stiffness=1e4\"";
  Simulation simulation =
      simulationFromText(scene(tool, skin + response("BarrierContact", more) + sheet(models("simulated=\"false\"")), 9.81));
  for (int i = 0; i < 40; ++i) expectCleanStep(simulation, i, false);
  const double height = simulation.systems()[0]->x[0].z();  // of the frame
  EXPECT_GT(height, 0);
  EXPECT_LT(height, 0.04);
}

/// A ball that starts in a sheet is refused, or pushed out to the gap.
TEST(ContactOfModels, BallsMayStartInOthers) {
  const std::string ball = "<Node name=\"ball\"><MechanicalObject name=\"dofs\" position=\"0.3 0.2 0.012\"/>"
                           "<UniformMass vertexMass=\"0.1\"/><SphereCollisionModel radius=\"0.02\"/></Node>";
  const auto sceneOf = [&](const std::string& more) {
    return scene(ball, response("BarrierContact", "responseParams=\"stiffness=1e5" + more + "\"") + sheet(models("simulated=\"false\"")));
  };
  expectContains(problemsOf(sceneOf("")), "0 of /m/ball/dofs is 0.008 m inside an obstacle");
  Simulation simulation = simulationFromText(sceneOf("&resolveStart=true"));
  EXPECT_NEAR(simulation.systems()[0]->x[0].z(), 0.02 + 0.98 * 0.005, 1e-4);
  expectCleanStep(simulation, 0);
}

TEST(ContactOfModels, WhatCannotBeCarriedOverIsNamed) {
  const auto problems = [](const std::string& of_a, const std::string& of_sheet, const std::string& more = "",
                           const std::string& besides = "") {
    return problemsOf(scene(plate("a", {0, 0, 0.1}, 0, of_a) + besides, response("BarrierContact", more) + sheet(of_sheet)));
  };
  const std::string still = models("simulated=\"false\"");
  expectContains(problems("", ""), "no two collision models of the scene may meet");
  expectContains(problems(models("group=\"1\""), models("group=\"1\"")), "no two collision models of the scene may meet");
  expectContains(problems("<TriangleCollisionModel name=\"t\" group=\"1\"/><PointCollisionModel name=\"p\"/>", models("group=\"1\"")),
                 "/m/a/t and /sheet/p have no contact, but others of /m/a/dofs and /sheet/dofs do");
  expectContains(problems(models() + "<SphereCollisionModel radius=\"0.1\"/>", still), "/m/a/dofs has spheres and other models");
  expectContains(problems("<TriangleCollisionModel name=\"t\" contactDistance=\"1e-3\"/><PointCollisionModel name=\"p\"/>", still),
                 "/m/a/t and /m/a/p have two contactDistances");
  expectContains(problems(models("contactResponse=\"FrictionContactConstraint\""), still), "/m/a/t has the contactResponse");
  expectContains(problems(models(), still, "rules=\"* * FrictionContactConstraint\""), "there are rules");
  expectContains(problems(models(), still, "responseParams=\"mu=0.3&stifness=2\""), "responseParams has \"stifness=2\"");
  expectContains(problems(models(), still, "responseParams=\"mu=0.3&stifness=2\""), "stiffness");
  expectContains(problems(models(), still, "responseParams=\"mu=-1\""), "-1 is outside the range of friction");
  expectContains(problems(models(), still, "responseParams=\"mu=1&friction=2\""), "twice");
  expectContains(problems(models(), still, "responseParams=\"contactDistance=1\""), "follows from /method");
  const std::string mine = "<BarrierContact name=\"mine\" mstate=\"@a/dofs\" planes=\"0 0 1 -1\"/>";
  expectContains(problems(models(), still, "", mine), "/m/mine besides");
  const std::string tool = "<Node name=\"tool\"><MechanicalObject name=\"frame\" template=\"Rigid3\" position=\"0 0 1 0 0 0 1\"/>"
                           "<SphereCollisionModel name=\"tip\" radius=\"0.1\"/></Node>";
  expectContains(problems(models(), "", "", tool), "/m/tool/tip is on /m/tool/frame, which has frames");
  const std::string of_model = plate("a", {0, 0, 0.1}, 0, models("contactResponse=\"BarrierContact\""));
  expectContains(problemsOf(scene(of_model, response("PenalityContactForceField") + sheet(still))), "not a response of single contacts");
}

/// What has no meaning is told, and what is more than SOFA's models.
TEST(ContactOfModels, DifferencesAreTold) {
  const auto told = [](const std::string& response, const std::string& of_a, const std::string& of_sheet) {
    Simulation simulation = simulationFromText(scene(plate("a", {0, 0, 0.1}, 0, of_a), response + sheet(of_sheet)));
    return simulation.diagnostics().text();
  };
  const std::string still = models("simulated=\"false\"");
  expectContains(told(response("BarrierContact"), models("contactStiffness=\"30\""), still), "no use for /m/a/t.contactStiffness");
  expectContains(told(response("BarrierContact", "explicitBetween=\"true\""), models(), still), "no use for /response.explicitBetween");
  expectContains(told(response("BarrierContact"), "<LineCollisionModel name=\"l\"/>", still), "not only the lines and points of /m/a/l");
  expectContains(told(response(""), models(), still), "response=\"BarrierContact\" excludes it");
  EXPECT_EQ(told(response("PenalityContactForceField"), models(), still).find("BarrierContact"), std::string::npos);
  EXPECT_EQ(told(response("BarrierContact"), models(), still).find("models"), std::string::npos);
  expectContains(told("<CollisionPipeline/>" + method, models(), still), "there is no CollisionResponse: the run ends");
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
