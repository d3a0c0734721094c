// SPDX-License-Identifier: LGPL-2.1-or-later
// Cavities against closed forms: pressure and volume do not depend on the time step, and stay within their bounds.
#include <Eigen/Geometry>
#include <array>
#include <map>

#include "tests/lagrangian/lagrangian_scenes.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

using namespace lagrangian;

/// A box on springs: the pressure that a growth takes gives that growth; it bears on the area of each side.
TEST(Cavities, ACavityUnderPressure) {
  const std::string cube = "0 0 0  1 0 0  1 1 0  0 1 0  0 0 1  1 0 1  1 1 1  0 1 1";
  const std::string faces = "0 2 1  0 3 2  4 5 6  4 6 7  0 1 5  0 5 4  3 7 6  3 6 2  0 4 7  0 7 3  1 2 6  1 6 5";
  const auto cavity = [&](const char* type, double value, double dt) {
    return sceneOf(fmt::format("<MechanicalObject position=\"{}\"/><UniformMass totalMass=\"1\"/><RestShapeSpringsForceField "
                               "stiffness=\"100\"/><SurfacePressureConstraint triangles=\"{}\" valueType=\"{}\" value=\"{}\"/>",
                               cube, faces, type, value),
                   dt, "0 0 0", "<EulerImplicitSolver rayleighMass=\"20\"/>");
  };
  double growth = 0;
  for (const double dt : {0.002, 0.02}) {
    Simulation simulation = simulationFromText(cavity("pressure", 40, dt));
    run(simulation, int(std::lround(3 / dt)));
    growth = numbersOf(simulation, "SurfacePressureConstraint", "volumeGrowth").at(0);
    // each node bears a third of what acts on its triangles
    std::istringstream list(faces);
    std::vector<Vec3> forces(8, Vec3::Zero());
    for (Index a, b, c; list >> a >> b >> c;) {
      const Vec3 p = at(simulation, a), area = 0.5 * (at(simulation, b) - p).cross(at(simulation, c) - p);
      for (const Index node : {a, b, c}) forces[std::size_t(node)] += 40 * area / 3;
    }
    for (Index node = 0; node < 8; ++node)
      EXPECT_LT(
          (100 * (at(simulation, node) - simulation.states()[0]->rest_position[std::size_t(node)]) - forces[std::size_t(node)])
              .norm(),
          1e-6)
          << node;
    EXPECT_GT(growth, 0.5);
  }
  Simulation simulation = simulationFromText(cavity("volumeGrowth", growth, 0.01));
  run(simulation, 300);
  EXPECT_NEAR(numbersOf(simulation, "SurfacePressureConstraint", "cavityVolume").at(0), 1 + growth, 1e-10);
  EXPECT_NEAR(numbersOf(simulation, "SurfacePressureConstraint", "pressure").at(0), 40, 1e-5);
}

/// A box of quads on springs stays a cube, whichever corner a quad begins with: each corner bears a quarter of three sides, so that
/// p L^2/4 = k (L - 1)/2 for the edge L. A side that is cut in two triangles would bear a third on some corners and a sixth on others.
TEST(Cavities, QuadsBearAlikeOnTheirCorners) {
  constexpr double pressure = 40, k = 100;
  const double edge = k / pressure - std::sqrt(k * k / (pressure * pressure) - 2 * k / pressure);
  const std::string cube = "0 0 0  1 0 0  1 1 0  0 1 0  0 0 1  1 0 1  1 1 1  0 1 1";
  for (const char* quads : {"0 3 2 1  4 5 6 7  0 1 5 4  3 7 6 2  0 4 7 3  1 2 6 5", "3 2 1 0  4 5 6 7  4 0 1 5  2 3 7 6  0 4 7 3  2 6 5 1"})
    for (const char* type : {"pressure", "volumeGrowth"}) {
      SCOPED_TRACE(fmt::format("{} {}", type, quads));
      Simulation simulation = simulationFromText(
          sceneOf(fmt::format("<MechanicalObject position=\"{}\"/><UniformMass totalMass=\"1\"/><RestShapeSpringsForceField "
                              "stiffness=\"{}\"/><SurfacePressureConstraint quads=\"{}\" valueType=\"{}\" value=\"{:.17g}\"/>",
                              cube, k, quads, type, type[0] == 'p' ? pressure : edge * edge * edge - 1),
                  0.02, "0 0 0", "<EulerImplicitSolver rayleighMass=\"20\"/>"));
      run(simulation, 150);
      for (Index node = 0; node < 8; ++node) {
        const Vec3 start = simulation.states()[0]->rest_position[std::size_t(node)];
        EXPECT_LT((at(simulation, node) - Vec3::Constant(0.5) - edge * (start - Vec3::Constant(0.5))).norm(), 1e-6) << node;
      }
      EXPECT_NEAR(numberOf(simulation, "SurfacePressureConstraint", "pressure"), pressure, 1e-5);
      EXPECT_NEAR(numberOf(simulation, "SurfacePressureConstraint", "cavityVolume"), edge * edge * edge, 1e-6);
    }
}

/// What is imposed follows key times, until a program says otherwise.
TEST(Cavities, AVolumeFollowsKeyTimes) {
  const auto cavity = [](const std::string& value) {
    return sceneOf(R"(<MechanicalObject position="0 0 0  1 0 0  1 1 0  0 1 0  0 0 1  1 0 1  1 1 1  0 1 1"/><UniformMass totalMass="1"/>
      <RestShapeSpringsForceField stiffness="100"/>
      <SurfacePressureConstraint quads="0 3 2 1  4 5 6 7  0 1 5 4  3 7 6 2  0 4 7 3  1 2 6 5" valueType="volumeGrowth" )" + value + "/>",
                   0.01, "0 0 0", "<EulerImplicitSolver rayleighMass=\"20\"/>");
  };
  Simulation simulation = simulationFromText(cavity(R"(keyTimes="0 0.1 0.2" value="0 0.2 0.1")"));
  const auto volume = [&] { return numberOf(simulation, "SurfacePressureConstraint", "cavityVolume"); };
  run(simulation, 5);
  EXPECT_NEAR(volume(), 1.1, 1e-10);
  run(simulation, 10);
  EXPECT_NEAR(volume(), 1.15, 1e-10);
  run(simulation, 15);
  EXPECT_NEAR(volume(), 1.1, 1e-10) << "after the last";
  simulation.setAttribute("/SurfacePressureConstraint", "value", "0.05");
  simulation.setAttribute("/SurfacePressureConstraint", "maxVolumeGrowth", "1");  // all that is written is read again
  run(simulation, 5);
  EXPECT_NEAR(volume(), 1.05, 1e-10) << "one number is that of all times";
  simulation.setAttribute("/SurfacePressureConstraint", "value", "0 0.1");
  EXPECT_THROW(simulation.step(), std::exception) << "two numbers for three times";
  expectContains(problemsOf(cavity(R"(keyTimes="0 1" value="0 1 2")")), "value");
  expectContains(problemsOf(cavity(R"(keyTimes="0 1" value="0 1" valueIndex="1")")), "keyTimes and valueIndex are given together");
  expectContains(problemsOf(cavity(R"(keyTimes="1 0" value="0 1")")), "keyTimes");
}

/// A closed surface: points and triangles, wound outwards.
struct Surface {
  std::vector<Vec3> points;
  std::vector<std::array<int, 3>> triangles;
  std::string positions() const {
    std::string text;
    for (const Vec3& p : points) text += fmt::format("{:.17g} {:.17g} {:.17g}  ", p.x(), p.y(), p.z());
    return text;
  }
  std::string faces() const {
    std::string text;
    for (const auto& t : triangles) text += fmt::format("{} {} {}  ", t[0], t[1], t[2]);
    return text;
  }
};

Surface icosahedron() {
  const double t = (1 + std::sqrt(5)) / 2;
  Surface s;
  for (const double a : {-1., 1.})
    for (const double b : {-t, t}) s.points.insert(s.points.end(), {Vec3(0, a, b), Vec3(a, b, 0), Vec3(b, 0, a)});
  for (int i = 0; i < 12; ++i)
    for (int j = i + 1; j < 12; ++j)
      for (int k = j + 1; k < 12; ++k) {
        const auto far = [&](int a, int b) { return (s.points[std::size_t(a)] - s.points[std::size_t(b)]).norm() > 2.1; };
        if (far(i, j) || far(j, k) || far(k, i)) continue;
        const Vec3 &a = s.points[std::size_t(i)], &b = s.points[std::size_t(j)], &c = s.points[std::size_t(k)];
        s.triangles.push_back(a.dot(b.cross(c)) > 0 ? std::array{i, j, k} : std::array{i, k, j});
      }
  return s;
}

/// Each triangle as four, all points on the sphere of this radius.
Surface sphere(int levels, double radius) {
  Surface s = icosahedron();
  for (int level = 0; level < levels; ++level) {
    std::map<std::array<int, 2>, int> middles;
    const auto middle = [&](int a, int b) {
      const auto [found, is_new] = middles.emplace(std::array{std::min(a, b), std::max(a, b)}, int(s.points.size()));
      if (is_new) s.points.push_back(0.5 * (s.points[std::size_t(a)] + s.points[std::size_t(b)]));
      return found->second;
    };
    std::vector<std::array<int, 3>> finer;
    for (const auto& t : s.triangles) {
      const int a = middle(t[0], t[1]), b = middle(t[1], t[2]), c = middle(t[2], t[0]);
      finer.insert(finer.end(), {{t[0], a, c}, {a, t[1], b}, {c, b, t[2]}, {a, b, c}});
    }
    s.triangles = finer;
  }
  for (Vec3& p : s.points) p *= radius / p.norm();
  return s;
}

/// An icosahedron of springs, by virtual work: p dV = dU, so p 3 c a^2 = 30 k (a - a_0), V = c a^3. Exact, whatever the size.
TEST(Cavities, AnIcosahedronOfSprings) {
  const Surface s = icosahedron();
  constexpr double a0 = 2, a = 2.2, k = 50;
  const double c = 5 * (3 + std::sqrt(5)) / 12, pressure = 10 * k * (a - a0) / (c * a * a),
               growth = c * (a * a * a - a0 * a0 * a0);
  std::string first, second;
  for (int i = 0; i < 12; ++i)
    for (int j = i + 1; j < 12; ++j)
      if ((s.points[std::size_t(i)] - s.points[std::size_t(j)]).norm() < 2.1)
        first += fmt::format("{} ", i), second += fmt::format("{} ", j);
  for (const double dt : {1e-1, 1e-2, 1e-3, 1e-4})
    for (const char* type : {"pressure", "volumeGrowth"}) {
      SCOPED_TRACE(fmt::format("{}, dt {}", type, dt));
      Simulation simulation = simulationFromText(sceneOf(
          fmt::format(
              "<MechanicalObject position=\"{}\"/><UniformMass vertexMass=\"0.001\"/><SpringForceField springsIndices1=\"{}\" "
              "springsIndices2=\"{}\" lengths=\"{}\" stiffness=\"{}\" damping=\"0\"/><SurfacePressureConstraint triangles=\"{}\" "
              "valueType=\"{}\" value=\"{:.17g}\"/>",
              s.positions(), first, second, a0, k, s.faces(), type, type[0] == 'p' ? pressure : growth),
          dt, "0 0 0", "<EulerImplicitSolver rayleighMass=\"600\"/>"));
      run(simulation, std::max(60, int(std::lround(0.15 / dt))));
      EXPECT_NEAR(numberOf(simulation, "SurfacePressureConstraint", "pressure"), pressure, 1e-7 * pressure);
      EXPECT_NEAR(numberOf(simulation, "SurfacePressureConstraint", "volumeGrowth"), growth, 1e-7 * growth);
      EXPECT_NEAR(numberOf(simulation, "SurfacePressureConstraint", "cavityVolume"), c * a * a * a, 1e-6);
      EXPECT_NEAR(at(simulation, 0).norm(), a / a0 * s.points[0].norm(), 1e-7);
    }
}

/// A thin sphere under pressure: p = 2 s t / r with s = E / (1 - nu) (r / r_0 - 1), the thickness that of the start and the
/// stress on the area of the start. Finer meshes come nearer.
TEST(Cavities, AThinSphereUnderPressure) {
  constexpr double young = 1e5, nu = 0.3, thickness = 1e-3, radius = 0.1, stretch = 1.02;
  const double pressure = 2 * thickness * young / (1 - nu) * (stretch - 1) / (radius * stretch * stretch);
  double last = 1;
  for (const int level : {1, 2}) {
    const Surface s = sphere(level, radius);
    double volume = 0;
    for (const auto& t : s.triangles)
      volume += s.points[std::size_t(t[0])].dot(s.points[std::size_t(t[1])].cross(s.points[std::size_t(t[2])])) / 6;
    Simulation simulation = simulationFromText(sceneOf(
        fmt::format("<MeshTopology position=\"{}\" triangles=\"{}\"/><MechanicalObject/><UniformMass totalMass=\"0.001\"/>"
                    "<TriangularFEMForceField youngModulus=\"{}\" poissonRatio=\"{}\" thickness=\"{}\" method=\"large\"/>"
                    "<SurfacePressureConstraint valueType=\"volumeGrowth\" value=\"{:.17g}\"/>",
                    s.positions(), s.faces(), young, nu, thickness, volume * (std::pow(stretch, 3) - 1)),
        0.1, "0 0 0", "<EulerImplicitSolver rayleighMass=\"1\"/>"));
    run(simulation, 60);
    const double error = std::abs(numberOf(simulation, "SurfacePressureConstraint", "pressure") / pressure - 1);
    EXPECT_LT(error, level == 1 ? 0.2 : 0.06);
    EXPECT_LT(error, 0.5 * last);
    last = error;
  }
}

/// A cavity of a millimetre beside a cable of a metre: both conditions hold, however different their numbers are.
TEST(Cavities, ASmallCavityAndALongCableHoldTogether) {
  for (const double size : {1.0, 1e-3, 1e-5}) {
    SCOPED_TRACE(size);
    Surface s = icosahedron();
    for (Vec3& p : s.points) p *= size;
    s.points.push_back(Vec3(1, 0, 0));
    const double growth = 0.1 * 5 * (3 + std::sqrt(5)) / 12 * 8 * size * size * size;
    Simulation simulation = simulationFromText(sceneOf(
        fmt::format(
            "<MechanicalObject position=\"{}\"/><UniformMass vertexMass=\"1\"/><RestShapeSpringsForceField stiffness=\"100\"/>"
            "<SurfacePressureConstraint triangles=\"{}\" valueType=\"volumeGrowth\" value=\"{:.17g}\"/>"
            "<CableConstraint indices=\"12\" pullPoint=\"-1 0 0\" value=\"0.1\"/>",
            s.positions(), s.faces(), growth),
        0.01, "0 0 0"));
    run(simulation, 3);
    EXPECT_NEAR(numberOf(simulation, "SurfacePressureConstraint", "volumeGrowth"), growth, 1e-9 * growth);
    EXPECT_NEAR(numberOf(simulation, "CableConstraint", "displacement"), 0.1, 1e-12);
  }
}

TEST(Cavities, ACavityStaysWithinItsBounds) {
  const Surface s = icosahedron();
  const double v0 = 5 * (3 + std::sqrt(5)) / 12 * 8;
  // what a growth takes, from the cavity itself without bounds
  const auto found = [&](const std::string& attributes) {
    Simulation simulation = simulationFromText(sceneOf(
        fmt::format(
            "<MechanicalObject position=\"{}\"/><UniformMass vertexMass=\"1\"/><RestShapeSpringsForceField stiffness=\"100\"/>"
            "<SurfacePressureConstraint triangles=\"{}\" {}/>",
            s.positions(), s.faces(), attributes),
        0.05, "0 0 0", "<EulerImplicitSolver rayleighMass=\"15\"/>"));
    run(simulation, 150);
    return std::array{numberOf(simulation, "SurfacePressureConstraint", "pressure"),
                      numberOf(simulation, "SurfacePressureConstraint", "volumeGrowth")};
  };
  const double growth = 0.2 * v0, pressure = found(fmt::format("valueType=\"volumeGrowth\" value=\"{}\"", growth))[0];
  EXPECT_GT(pressure, 1);
  for (const std::string& attributes :
       {fmt::format("value=\"{}\" maxPressure=\"{:.17g}\"", 2 * pressure, pressure),
        fmt::format("value=\"0\" minPressure=\"{:.17g}\"", pressure),
        fmt::format("value=\"{}\" maxVolumeGrowth=\"{:.17g}\"", 2 * pressure, growth),
        fmt::format("value=\"0\" minVolumeGrowth=\"{:.17g}\"", growth),
        fmt::format("value=\"{:.17g}\" maxPressureVariation=\"{:.17g}\"", pressure, pressure / 10),
        fmt::format("valueType=\"volumeGrowth\" value=\"{}\" maxVolumeGrowth=\"{:.17g}\"", 2 * growth, growth),
        fmt::format("valueType=\"volumeGrowth\" value=\"{}\" maxPressure=\"{:.17g}\"", 2 * growth, pressure),
        fmt::format("valueType=\"volumeGrowth\" value=\"0\" minPressure=\"{:.17g}\" maxPressure=\"{}\"", pressure,
                    2 * pressure),
        fmt::format("valueType=\"volumeGrowth\" value=\"{:.17g}\" maxVolumeGrowthVariation=\"{:.17g}\"", growth,
                    growth / 10)}) {
    SCOPED_TRACE(attributes);
    const auto [p, v] = found(attributes);
    EXPECT_NEAR(p, pressure, 1e-6 * pressure);
    EXPECT_NEAR(v, growth, 1e-6 * growth);
  }
}

/// A plate is no cavity: under a pressure each corner of a triangle bears a third of p A n, wherever the plate is.
TEST(Cavities, APlateBearsAPressureWhereverItIs) {
  for (const Vec3& place : {Vec3(0, 0, 0), Vec3(30, -20, 10)}) {
    const auto p = [&](double x, double y) { return fmt::format("{} {} {}  ", place.x() + x, place.y() + y, place.z()); };
    Simulation simulation = simulationFromText(
        sceneOf("<MechanicalObject position=\"" + p(0, 0) + p(2, 0) + p(0, 1) +
                    "\"/><UniformMass vertexMass=\"1\"/><SurfacePressureConstraint triangles=\"0 1 2\" value=\"6\"/>",
                0.01, "0 0 0"));
    run(simulation, 1);
    for (Index node = 0; node < 3; ++node)
      EXPECT_LT((simulation.states()[0]->v()[node] - Vec3(0, 0, 0.01 * 6 * 1 / 3)).norm(), 1e-12) << node;
  }
}

/// The equation of a step holds with the directions that forces have at its end. One round after another takes some 28 solves here.
TEST(Cavities, FewSolvesFindTheDirectionsOfAPressure) {
  Simulation simulation = simulationFromText(sceneOf(
      R"(<MechanicalObject name="dofs" position="0 0 0  1 0 0  0 1 0  0 0 1"/><UniformMass totalMass="4"/>
  <RestShapeSpringsForceField stiffness="100"/><SurfacePressureConstraint triangles="0 2 1  0 1 3  0 3 2  1 2 3" valueType="pressure"
  value="60"/>)",
      0.2, "0 0 0"));
  for (int i = 0; i < 5; ++i) {
    const Vec3 before = at(simulation, 1), velocity = simulation.states()[0]->v()[1];
    const StepReport report = simulation.step();
    ASSERT_FALSE(report.failed()) << report.reason;
    EXPECT_LE(report.linear_iterations, 14);
    const Vec3 a = at(simulation, 0), b = at(simulation, 1), c = at(simulation, 2), d = at(simulation, 3);
    const Vec3 wanted = 60. / 6 * (c - a).cross(d - a) - 100 * (b - Vec3(1, 0, 0));  // V = (b - a) . ((c - a) x (d - a)) / 6
    EXPECT_LT(((b - before) / 0.2 - velocity - 0.2 * wanted).norm(), 1e-10) << i;
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
