// SPDX-License-Identifier: LGPL-2.1-or-later
// States of frames and of numbers as scenes write them: what is read, held, loaded, selected, written and read again.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <sstream>

#include "framework/mechanics/frames.h"
#include "framework/simulation/state_file.h"
#include "tests/support/folder_fixture.h"
#include "tests/support/scene_text.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

std::string scene(const std::string& object,
                  const std::string& more = "<UniformMass totalMass=\"2\" inertia=\"0.1 0.2 0.25\"/>",
                  const std::string& integrator = "<EulerImplicitSolver/><SparseLDLSolver/>") {
  return "<Node name=\"root\" dt=\"0.01\" gravity=\"0 -10 0\">" + integrator + "<MechanicalObject name=\"dofs\" " +
         object + "/>" + more + "</Node>";
}
const System& systemOf(const Simulation& simulation) { return *simulation.systems()[0]; }

TEST(Frames, SevenNumbersAreACentreAndAQuaternion) {
  const Simulation simulation =
      simulationFromText(scene("template=\"Rigid3d\" position=\"1 2 3  0 0 0.6 0.8   4 5 6  0 0 -0.6 -0.8\" "
                               "velocity=\"1 0 0  0 2 0  0 1 0  0 0 3\""));
  const System& system = systemOf(simulation);
  EXPECT_EQ(system.allRows(), 4);
  EXPECT_EQ(Vec3(system.x[2]), Vec3(4, 5, 6));
  for (const Index row : {1, 3})
    EXPECT_LT(orientationIn(system.x, row).angularDistance(Quaternion(0.8, 0, 0, 0.6)), 1e-15);
  EXPECT_EQ(Vec3(system.v[3]), Vec3(0, 0, 3));
  const State& state = *simulation.states()[0];
  EXPECT_EQ(state.nodes(), 2);
  const std::string text = state.data().find("position")->print();
  EXPECT_EQ(text.substr(0, 6), "1 2 3 ") << text;
  EXPECT_EQ(std::count(text.begin(), text.end(), ' '), 13) << text;
}

TEST(Frames, HalfATurnKeepsAllItsDigits) {
  const Simulation simulation = simulationFromText(scene("template=\"Rigid3\" position=\"0 0 0  0.6 0.8 0 1e-9\""));
  EXPECT_NEAR(systemOf(simulation).x.rows().data[7], 1e-9, 1e-15);
}

TEST(Frames, ScaleAndRotationActOnBoth) {
  const Simulation simulation = simulationFromText(
      scene("template=\"Rigid3\" position=\"1 0 0  0 0 0 1\" scale=\"2\" rotation=\"0 0 90\" translation=\"0 0 5\""));
  const System& system = systemOf(simulation);
  EXPECT_LT((system.x[0] - Vec3(0, 2, 5)).norm(), 1e-15);
  EXPECT_LT((orientationIn(system.x, 1) * Vec3::UnitX() - Vec3::UnitY()).norm(), 1e-15);
}

TEST(Frames, SayWhatIsWrong) {
  expectContains(problemsOf(scene("template=\"Rigid3\" position=\"1 2 3 0 0 0\"")),
                 "7 numbers for each node of type Rigid3");
  expectContains(problemsOf(scene("template=\"Rigid3\" position=\"1 2 3 0 0 0 0\"")), "which is not an orientation");
  expectContains(problemsOf(scene("template=\"Rigid4\" position=\"1 2 3\"")), "nodes of type Rigid4 do not exist");
  expectContains(problemsOf(scene("position=\"1 2 3 0 0 0 1\"")), "template=\"Rigid3\"");
  expectContains(
      problemsOf(scene("template=\"Rigid3\" position=\"0 0 0 0 0 0 1\"", "<UniformMass vertexMass=\"1 2\"/>")),
      "vertexMass has 2 numbers");
  expectContains(problemsOf(scene("template=\"Rigid3\" position=\"0 0 0 0 0 0 1\"",
                                  "<UniformMass totalMass=\"1\" inertia=\"1 2 -1\"/>")),
                 "three positive ones");
}

TEST(Frames, TheMassOfSOFAIsRead) {
  for (const char* mass : {"<UniformMass vertexMass=\"2 1 0.1 0 0 0 0.2 0 0 0 0.3\"/>",
                           "<UniformMass vertexMass=\"2 1 [0.1 0 0,0 0.2 0,0 0 0.3]\"/>",
                           "<UniformMass totalMass=\"2\" inertia=\"0.2 0.4 0.6\"/>",
                           "<UniformMass totalMass=\"2\" inertia=\"0.2 0 0 0 0.4 0 0 0 0.6\"/>",
                           "<DiagonalMass vertexMass=\"2\" inertia=\"0.2 0.4 0.6\"/>"}) {
    const Simulation simulation =
        simulationFromText(scene("template=\"Rigid3\" position=\"0 0 0  0 0 0 1\" velocity=\"1 0 0  1 2 3\"", mass));
    EXPECT_NEAR(systemOf(simulation).kineticEnergy(), 0.5 * (2 + 0.2 + 0.4 * 4 + 0.6 * 9), 1e-14) << mass;
  }
}

TEST(Frames, AreHeldInPart) {
  const std::string two = "template=\"Rigid3\" position=\"0 0 0  0 0 0 1  1 0 0  0 0 0 1\"",
                    mass = "<UniformMass totalMass=\"2\" inertia=\"1 1 1\"/>",
                    torque = "<ConstantForceField indices=\"0\" forces=\"1 2 3 4 5 6\"/>";
  const auto after = [&](const std::string& constraint) {
    Simulation simulation = simulationFromText(scene(two, mass + torque + constraint));
    EXPECT_FALSE(simulation.step().diverged);
    return std::pair(Vec3(systemOf(simulation).v[0]), Vec3(systemOf(simulation).v[1]));
  };
  const auto [v, w] = after("");
  EXPECT_LT((v - 0.01 * Vec3(1, 2 - 10, 3)).norm(), 1e-14);
  EXPECT_LT((w - 0.01 * Vec3(4, 5, 6)).norm(), 1e-14);
  const auto held = after("<FixedProjectiveConstraint indices=\"0\"/>");
  EXPECT_EQ(held.first.norm() + held.second.norm(), 0);
  const auto turns = after("<FixedTranslationProjectiveConstraint indices=\"0\"/>");
  EXPECT_EQ(turns.first.norm(), 0);
  EXPECT_LT((turns.second - w).norm(), 1e-14);
  const auto partly = after("<PartialFixedProjectiveConstraint indices=\"0\" fixedDirections=\"0 1 0 1 0 1\"/>");
  EXPECT_LT((partly.first - Vec3(v.x(), 0, v.z())).norm(), 1e-14);
  EXPECT_LT((partly.second - Vec3(0, w.y(), 0)).norm(), 1e-14);
}

TEST(Frames, AreSelectedByTheirCentres) {
  const Simulation simulation = simulationFromText(
      scene("template=\"Rigid3\" position=\"0 0 0  0 0 0 1  1 0 0  0 0 0 1\"",
            "<UniformMass totalMass=\"2\" inertia=\"1 1 1\"/>"
            "<BoxROI name=\"box\" box=\"0.5 -1 -1 2 1 1\"/><FixedProjectiveConstraint indices=\"@box.indices\"/>"));
  EXPECT_EQ(systemOf(simulation).constraints().projectorOf(1), -1);
  EXPECT_GE(systemOf(simulation).constraints().projectorOf(3), 0);
}

TEST(Frames, SpringsTurnThemBack) {
  // J th'' = -k th about one axis
  Simulation simulation = simulationFromText(
      "<Node name=\"root\" dt=\"0.001\" gravity=\"0 0 0\"><TrapezoidalRuleSolver/><SparseLDLSolver/>"
      "<MechanicalObject template=\"Rigid3\" position=\"0.1 0 0  0 0 0.19866933 0.98006658\" rest_position=\"0 0 0  0 "
      "0 0 1\"/>"
      "<UniformMass totalMass=\"2\" inertia=\"0.1 0.2 0.25\"/><RestShapeSpringsForceField stiffness=\"8\" "
      "angularStiffness=\"4\"/></Node>");
  const double start = systemOf(simulation).potentialEnergy(systemOf(simulation).x);
  EXPECT_NEAR(start, 0.5 * 8 * 0.01 + 0.5 * 4 * 0.16, 1e-8);
  for (int i = 0; i < 500; ++i) ASSERT_FALSE(simulation.step().diverged);
  const System& system = systemOf(simulation);
  EXPECT_NEAR(rotationVector(orientationIn(system.x, 1)).z(), 0.4 * std::cos(std::sqrt(4 / 0.25) * 0.5), 2e-5);
  EXPECT_NEAR(system.x[0][0], 0.1 * std::cos(std::sqrt(8 / 2.) * 0.5), 2e-5);
  EXPECT_NEAR(system.potentialEnergy(system.x) + system.kineticEnergy(), start, 1e-6 * start);
}

/// Numbers move along one direction: statics of them is not singular.
TEST(Numbers, HaveOneDirectionEach) {
  for (const std::string type : {"Vec1", "Vec2", "Vec6"}) {
    const int count = type[3] - '0';
    std::string position, force;
    for (int i = 0; i < 2 * count; ++i) position += fmt::format("{} ", i), force += "3 ";
    Simulation simulation = simulationFromText(
        scene("template=\"" + type + "\" position=\"" + position + "\"",
              "<RestShapeSpringsForceField stiffness=\"6\"/><ConstantForceField forces=\"" + force + "\"/>",
              "<StaticSolver/><SparseLDLSolver/>"));
    const StepReport report = simulation.step();
    ASSERT_FALSE(report.diverged) << report.reason;
    EXPECT_TRUE(report.newton_converged);
    EXPECT_EQ(simulation.states()[0]->nodes(), 2);
    for (Index i = 0; i < 2 * count; ++i) {
      EXPECT_NEAR(systemOf(simulation).x[i][0], i + 0.5, 1e-12) << type;
      EXPECT_EQ(systemOf(simulation).x[i][1], 0);
    }
  }
}

class FramesInFiles : public FolderTest {};

TEST_F(FramesInFiles, AreWrittenAndReadAgain) {
  const std::string file = this->file("frames.state");
  const std::string object =
      "template=\"Rigid3\" position=\"1 0 0  0 0 0 1  0 1 0  0 0 0 1\" velocity=\"1 0 0  1 2 3   0 0 0  0 -9 0\"";
  const std::string mass = "<UniformMass totalMass=\"2\" inertia=\"0.1 0.2 0.25\"/>";
  std::vector<Vector> recorded;
  const auto note = [&](const Simulation& simulation) {
    recorded.emplace_back(4);
    copy(systemOf(simulation).x, recorded.back());
  };
  {
    Simulation simulation = simulationFromText(
        scene(object, mass + "<WriteState filename=\"" + file + "\" writeV=\"true\" writeX0=\"true\"/>"));
    simulation.begin();
    note(simulation);
    for (int i = 0; i < 40; ++i) {
      ASSERT_FALSE(simulation.step().diverged);
      note(simulation);
    }
    simulation.end();
  }
  std::ifstream stream(file);
  std::string line;
  while (std::getline(stream, line) && line.find("X=") == line.npos) {
  }
  EXPECT_EQ(std::count(line.begin(), line.end(), ' '), 2 + 14) << line;
  Simulation replay = simulationFromText(scene(object, mass + "<ReadState filename=\"" + file + "\"/>"));
  double turned = 0;
  for (std::size_t i = 1; i <= 40; ++i) {
    ASSERT_FALSE(replay.step().diverged);
    for (std::size_t k = 0; k < 16; ++k)
      EXPECT_NEAR(systemOf(replay).x.rows().data[k], recorded[i].rows().data[k], 1e-14) << i;
    turned = std::max(turned, orientationIn(recorded[i], 3).angularDistance(Quaternion::Identity()));
  }
  EXPECT_GT(turned, 3) << "more than any hemisphere";
}

/// The quaternions in the lines of a file, which have `before` words before each and `each` numbers of a frame.
std::vector<Quaternion> quaternionsIn(const std::string& file, const std::string& label) {
  std::vector<Quaternion> found;
  std::ifstream stream(file);
  for (std::string line; std::getline(stream, line);) {
    std::istringstream words(line);
    std::string first;
    double x, y, z, q[4];
    if (words >> first && first != "#" && (label.empty() || first == label) && words >> x >> y >> z >> q[0] >> q[1] >> q[2] >> q[3])
      found.emplace_back(q);
  }
  return found;
}

/// A sphere that spins: q(t) = exp(w t) q(0), on the side of the numbers in the scene, through w = 0 many times.
TEST_F(FramesInFiles, TheSignFollowsTheMotion) {
  const Vec3 spin(3, -14, 8);  // 16.4 rad/s: 5 turns
  const Quaternion start(-0.8, 0, 0, -0.6), arm(-0.6, 0, 0.8, 0);
  for (const char* integrator : {"<EulerImplicitSolver/><SparseLDLSolver/>", "<EulerExplicitSolver/>", "<RungeKutta4Solver/>"}) {
    Simulation simulation = simulationFromText(scene(
        "template=\"Rigid3\" position=\"1 0 0  0 0 -0.6 -0.8\" velocity=\"0 0 0  3 -14 8\"",
        "<UniformMass totalMass=\"2\" inertia=\"0.1 0.1 0.1\"/><WriteState filename=\"" + file("all.state") +
            "\"/><WriteState filename=\"" + file("some.state") + "\" period=\"0.07\"/><Monitor fileName=\"" + file("m") +
            "\" indices=\"0\" ExportPositions=\"true\"/><Node name=\"child\"><MechanicalObject name=\"dofs\" template=\"Rigid3\" "
            "position=\"0 0 0  0 0.8 0 -0.6\"/><RigidRigidMapping/><WriteState filename=\"" + file("child.state") + "\"/></Node>",
        integrator));
    simulation.begin();
    for (int i = 0; i < 210; ++i) ASSERT_FALSE(simulation.step().diverged);
    simulation.end();
    const auto expect = [&](const std::string& name, const char* label, int period, const Quaternion& first) {
      const std::vector<Quaternion> found = quaternionsIn(file(name), label);
      ASSERT_EQ(found.size(), 210u / period + 1) << name;
      for (std::size_t i = 0; i < found.size(); ++i)
        EXPECT_LT((found[i].coeffs() - (turnedBy(0.01 * double(i) * period * spin) * first).coeffs()).norm(), 1e-11)
            << integrator << " " << name << " " << i;
    };
    expect("all.state", "X=", 1, start);
    expect("some.state", "X=", 7, start);
    expect("m_x.txt", "", 1, start);
    expect("child.state", "X=", 1, start * arm);
    const Vector last = [&] { Vector copied(2); copy(systemOf(simulation).x.rows().head(2), copied); return copied; }();
    simulation.reset();
    EXPECT_LT((orientationIn(systemOf(simulation).x, 1).coeffs() - start.coeffs()).norm(), 1e-15) << "a reset has the sign of the scene";
    for (int i = 0; i < 210; ++i) ASSERT_FALSE(simulation.step().diverged);
    EXPECT_TRUE(std::equal(last.rows().data, last.rows().data + last.rows().doubles(), systemOf(simulation).x.rows().data));
  }
}

TEST_F(FramesInFiles, AreTurnedAndMovedAsTheyAreRead) {
  const std::string file = this->file("frames.state");
  std::ofstream(file) << "T= 0\n  X= 1 0 0 0 0 0 1\n  V= 1 0 0 2 0 0\nT= 0.01\n  X= 1 2 0 0.6 0 0 0.8\n  V= 1 0 0 2 0 0\n";
  Simulation replay = simulationFromText(
      scene("template=\"Rigid3\" position=\"0 0 0 0 0 0 1\"",
            "<UniformMass totalMass=\"2\" inertia=\"0.1 0.2 0.25\"/><ReadState filename=\"" + file +
                "\" scalePos=\"2\" rotation=\"0 0 90\" translation=\"0 0 5\"/>"));
  ASSERT_FALSE(replay.step().diverged);
  const System& system = systemOf(replay);
  EXPECT_LT((system.x[0] - Vec3(-4, 2, 5)).norm(), 1e-14);
  const Quaternion turn(Eigen::AngleAxisd(std::acos(0.) , Vec3::UnitZ()));
  EXPECT_LT(orientationIn(system.x, 1).angularDistance(turn * Quaternion(0.8, 0.6, 0, 0)), 1e-7);
  EXPECT_LT((system.v[0] - Vec3(0, 2, 0)).norm(), 1e-14);
  EXPECT_LT((system.v[1] - Vec3(0, 2, 0)).norm(), 1e-14) << "a turn has no size";
}

/// Every digit of a quaternion is in a checkpoint, of either sign of its numbers.
TEST(FramesInCheckpoints, GoOnToTheBit) {
  Simulation simulation = simulationFromText(
      scene("template=\"Rigid3\" position=\"0 0 0  0.1 -0.7 0.3 0.4   1 0 0  0 0 0 1\" velocity=\"0 0 0 3 -9 1  1 0 0 0 0 2\"",
            "<UniformMass totalMass=\"2\" inertia=\"0.1 0.2 0.25\"/><Node name=\"child\"><MechanicalObject "
            "template=\"Rigid3\" position=\"0.1 0 0  0.5 0 0 0.8\"/><RigidRigidMapping/><RestShapeSpringsForceField/></Node>"));
  for (int i = 0; i < 60; ++i) ASSERT_FALSE(simulation.step().diverged);
  const Archive middle = simulation.checkpoint();
  for (int i = 0; i < 60; ++i) ASSERT_FALSE(simulation.step().diverged);
  const auto end = simulation.stateHash();
  simulation.restore(middle.readable());
  for (int i = 0; i < 60; ++i) ASSERT_FALSE(simulation.step().diverged);
  EXPECT_EQ(simulation.stateHash(), end);
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
