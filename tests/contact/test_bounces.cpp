// SPDX-License-Identifier: LGPL-2.1-or-later
// Bounces by rules that damp nothing keep the energy that a body came with, however long the steps are for the contact. Where several
// contacts begin at once, or a body tumbles, they give none.
#include "tests/contact/contact_scenes.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// The surface of a box of 0.2 m that a frame carries.
const std::string skin =
    "<Node name=\"skin\"><MeshTopology position=\"-0.1 -0.1 -0.1  0.1 -0.1 -0.1  0.1 0.1 -0.1  -0.1 0.1 -0.1  -0.1 -0.1 0.1  0.1 -0.1 "
    "0.1  0.1 0.1 0.1  -0.1 0.1 0.1\" quads=\"0 3 2 1  4 5 6 7  0 1 5 4  1 2 6 5  2 3 7 6  3 0 4 7\"/><MechanicalObject "
    "name=\"dofs\"/><RigidMapping/></Node></Node>";

/// A rigid box of 0.2 m and 1 kg that only goes up and down, `height` above z = 0.
std::string boxNode(const std::string& name, double x, double height) {
  return fmt::format(
      "<Node name=\"{}\"><MechanicalObject name=\"frame\" template=\"Rigid3\" position=\"{} 0 {} 0 0 0 1\"/><UniformMass "
      "totalMass=\"1\" inertia=\"0.01 0.01 0.01\"/><PartialFixedProjectiveConstraint indices=\"0\" fixedDirections=\"1 1 0 1 1 1\"/>"
      "{}",
      name, x, height + 0.1, skin);
}

struct Flight {
  std::vector<double> energies;  ///< after each bounce, the first before any [J]
  bool flies = false;
};

std::string fall(const std::string& rule, double dt, const std::vector<double>& heights) {
  constexpr double g = 9.81;
  std::string boxes;
  for (std::size_t i = 0; i < heights.size(); ++i) boxes += boxNode(fmt::format("box{}", i), double(i), heights[i]);
  const std::string other = heights.size() > 1 ? "other=\"@box1/skin/dofs\"" : "";
  return contactScene(
      boxes + fmt::format("<BarrierContact mstate=\"@box0/skin/dofs\" {} planes=\"0 0 1 0\" contactDistance=\"1e-3\" stiffness=\"1e7\" "
                          "selfContact=\"0\"/>",
                          other),
      dt, Vec3(0, 0, -g), rule);
}

/// The boxes fall on the plane z = 0 for 4 s; flights of each.
std::vector<Flight> flights(const std::string& rule, double dt, const std::vector<double>& heights) {
  constexpr double g = 9.81, range = 1e-3;
  Simulation simulation = simulationFromText(fall(rule, dt, heights));
  std::vector<const State*> frames;
  for (const State* state : simulation.states())
    if (state->name() == "frame") frames.push_back(state);
  std::vector<Flight> all(frames.size());
  for (int i = 1; i * dt <= 4; ++i) {
    expectCleanStep(simulation, i);
    if (::testing::Test::HasFatalFailure()) return all;
    for (std::size_t b = 0; b < frames.size(); ++b) {
      const double height = frames[b]->x()[0].z() - 0.1, speed = frames[b]->v()[0].z();
      const bool flew = std::exchange(all[b].flies, height > range);
      if (all[b].flies && !flew) all[b].energies.push_back(g * height + 0.5 * speed * speed);
    }
  }
  return all;
}

void expectAllKeep(const Flight& flight, double least = 0.99) {
  const std::vector<double>& energies = flight.energies;
  ASSERT_GE(energies.size(), 2u) << "it bounces";
  for (std::size_t i = 1; i < energies.size(); ++i) {
    EXPECT_LE(energies[i], 1.001 * energies[i - 1] + 1e-6) << "bounce " << i;
    EXPECT_GE(energies[i], least * energies[i - 1]) << "bounce " << i;
  }
}

TEST(Bounces, KeepTheirEnergy) {
  for (const std::string rule : {"TrapezoidalRuleSolver", "NewmarkImplicitSolver"})
    for (const double dt : {1e-4, 5e-4, 1e-3, 2e-3}) {
      SCOPED_TRACE(fmt::format("{}, {} s", rule, dt));
      const auto all = flights(fmt::format("<{} newtonIterations=\"60\" newtonTolerance=\"1e-9\"/>", rule), dt, {0.2});
      ASSERT_EQ(all.size(), 1u);
      expectAllKeep(all[0]);
    }
}

/// By its rule m (beta/gamma - 1/2) (v1 - v0)^2 gets lost in a step: 2 to 4 % in a bounce with beta 0.3025 and gamma 0.6.
TEST(Bounces, LoseWhatNewmarksRuleDamps) {
  for (const double dt : {5e-4, 1e-3, 2e-3}) {
    SCOPED_TRACE(fmt::format("{} s", dt));
    const auto all =
        flights("<NewmarkImplicitSolver gamma=\"0.6\" beta=\"0.3025\" newtonIterations=\"60\" newtonTolerance=\"1e-9\"/>", dt, {0.2});
    ASSERT_EQ(all.size(), 1u);
    expectAllKeep(all[0], 0.93);
  }
}

/// A rigid box of 0.2 m and 1 kg with its centre at `place`, that moves at `velocity`; turned about y by `angle`.
std::string movingBox(int number, const Vec3& place, const Vec3& velocity, const std::string& held, double angle = 0) {
  const std::string hold =
      held.empty() ? "" : fmt::format("<PartialFixedProjectiveConstraint indices=\"0\" fixedDirections=\"{}\"/>", held);
  return fmt::format(
             "<Node name=\"box{}\"><MechanicalObject name=\"frame\" template=\"Rigid3\" position=\"{} {} {} 0 {} 0 {}\" "
             "velocity=\"{} {} {} 0 0 0\"/><UniformMass totalMass=\"1\" inertia=\"{} {} {}\"/>{}",
             number, place.x(), place.y(), place.z(), std::sin(angle / 2), std::cos(angle / 2), velocity.x(), velocity.y(), velocity.z(),
             0.02 / 3, 0.02 / 3, 0.02 / 3, hold) +
         skin;
}

std::string contactOf(int box, const std::string& more) {
  return fmt::format("<BarrierContact name=\"of{}\" mstate=\"@box{}/skin/dofs\" {} contactDistance=\"1e-3\" stiffness=\"1e7\" "
                     "selfContact=\"0\"/>",
                     box, box, more);
}

struct Course {
  double start = 0, most = 0, end = 0;  ///< energy of motion and height above `rest`, while it lasts [J]
  std::string doubts;                   ///< of the contacts where it ends
};

/// `rest`: m z of all boxes where nothing can fall any more.
Course courseOf(const std::string& boxes, double dt, double gravity, double lasts, double rest) {
  const std::string rule = "<TrapezoidalRuleSolver newtonIterations=\"60\" newtonTolerance=\"1e-9\"/>";
  Simulation simulation = simulationFromText(contactScene(boxes, dt, Vec3(0, 0, -gravity), rule));
  const auto energy = [&] {
    double sum = -gravity * rest;
    for (const State* state : simulation.states())
      if (state->name() == "frame")
        sum += 0.5 * state->v()[0].squaredNorm() + 0.5 * 0.02 / 3 * state->v()[1].squaredNorm() + gravity * state->x()[0].z();
    return sum;
  };
  Course course{energy(), 0, 0, {}};
  for (int i = 1; i * dt <= lasts; ++i) {
    expectCleanStep(simulation, i, false);
    if (::testing::Test::HasFatalFailure()) return course;
    course.end = energy(), course.most = std::max(course.most, course.end);
  }
  const System& system = *simulation.systems().at(0);
  for (const ForceField* field : system.forceFields()) course.doubts += field->doubt(system.x);
  return course;
}

const std::string upright = "1 1 0 1 1 1", along = "0 1 1 1 1 1";

/// The upper one hits the lower one, which is on its way up from the plane.
TEST(Bounces, OfTwoBodiesKeepTheirEnergy) {
  for (const double dt : {1e-3, 2e-3}) {
    SCOPED_TRACE(fmt::format("{} s", dt));
    const std::string boxes = movingBox(0, {0, 0, 0.2}, {0, 0, 0}, upright) + movingBox(1, {0, 0, 0.45}, {0, 0, 0}, upright) +
                              contactOf(0, "other=\"@box1/skin/dofs\" planes=\"0 0 1 0\"");
    const Course course = courseOf(boxes, dt, 9.81, 1, 0.4);
    EXPECT_LE(course.most, 1.001 * course.start);
    EXPECT_GE(course.end, 0.995 * course.start);
    EXPECT_EQ(course.doubts, "");
  }
}

/// A stack in long steps loses most of its energy, and says how much.
TEST(Bounces, ThatLoseEnergySayHowMuch) {
  std::string boxes;
  for (int i = 0; i < 3; ++i) boxes += movingBox(i, {0, 0, 0.3 + i * 0.2015}, {0, 0, 0}, upright);
  boxes += contactOf(0, "other=\"@box1/skin/dofs\" planes=\"0 0 1 0\"") + contactOf(1, "other=\"@box2/skin/dofs\"");
  const Course course = courseOf(boxes, 5e-3, 9.81, 0.6, 0.9);
  ASSERT_LT(course.end, 0.8 * course.start);
  double told = 0;
  for (std::size_t at = 0; (at = course.doubts.find("contacts did not give back all that they took: ", at)) != std::string::npos; ++at)
    told += std::stod(course.doubts.substr(at + 47));
  EXPECT_NEAR(told, course.start - course.end, 0.05 * course.start) << course.doubts;
}

TEST(Bounces, OfAStackNeverGain) {
  for (const double dt : {1e-3, 2e-3, 5e-3})
    for (const double gap : {1.5e-3, 1e-2}) {
      SCOPED_TRACE(fmt::format("{} s, {} m", dt, gap));
      std::string boxes;
      for (int i = 0; i < 3; ++i) boxes += movingBox(i, {0, 0, 0.3 + i * (0.2 + gap)}, {0, 0, 0}, upright);
      boxes += contactOf(0, "other=\"@box1/skin/dofs\" planes=\"0 0 1 0\"") + contactOf(1, "other=\"@box2/skin/dofs\"");
      const Course course = courseOf(boxes, dt, 9.81, 0.6, 0.9);
      EXPECT_LE(course.most, 1.001 * course.start);
    }
}

/// Two contacts begin within a step, and what one gives depends on the other.
TEST(Bounces, OfABoxBetweenABoxAndAWallNeverGain) {
  const std::string boxes = movingBox(0, {-0.5, 0, 0}, {1, 0, 0}, along) + movingBox(1, {0, 0, 0}, {0, 0, 0}, along) +
                            contactOf(0, "other=\"@box1/skin/dofs\" planes=\"-1 0 0 -0.1012\"");
  const Course course = courseOf(boxes, 2e-3, 0, 0.45, 0);
  EXPECT_LE(course.most, 1.001 * course.start);
  EXPECT_GE(course.end, 0.1 * course.start) << "they part";
}

/// Contacts of a body that turns do their work along arcs.
TEST(Bounces, OfATumblingBoxNeverGain) {
  for (const std::string friction : {"", "friction=\"0.3\""})
    for (const double dt : {1e-3, 4e-3})
      for (const double angle : {0.05, 0.3}) {
        SCOPED_TRACE(fmt::format("{} s, {} rad {}", dt, angle, friction));
        const std::string box = movingBox(0, {0, 0, 0.3}, {0, 0, 0}, "", angle) + contactOf(0, "planes=\"0 0 1 0\" " + friction);
        const Course course = courseOf(box, dt, 9.81, 1, 0.1);
        EXPECT_LE(course.most, 1.001 * course.start);
      }
}

/// Accounts of bounces that are under way are in a checkpoint.
TEST(Bounces, GoOnFromACheckpoint) {
  const std::string text =
      fall("<TrapezoidalRuleSolver newtonIterations=\"60\" newtonTolerance=\"1e-9\"/>", 1e-4, {0.01, 0.012});
  Simulation whole = simulationFromText(text);
  const auto placesOf = [](const Simulation& simulation) {
    std::vector<Vec3> all;
    for (const State* state : simulation.states()) all.push_back(state->x()[0]), all.push_back(state->v()[0]);
    return all;
  };
  int step = 0;
  for (const int until : {440, 455, 470, 485, 500, 515, 800}) {  // they come down at step 430 and 460
    for (; step < until; ++step) expectCleanStep(whole, step);
    Simulation rest = simulationFromText(text);
    rest.restore(whole.checkpoint());
    for (; step < until + 15; ++step) expectCleanStep(whole, step), expectCleanStep(rest, step);
    EXPECT_EQ(placesOf(rest), placesOf(whole)) << "step " << until;
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
