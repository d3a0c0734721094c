// SPDX-License-Identifier: LGPL-2.1-or-later
// Pressures that nodes report on faces of four corners, against closed forms. A quad is cut in two for the geometry of contact; what
// its corners stand for must not depend on which way. Cells are numbered at random, so that it is cut either way.
#include <Eigen/Geometry>

#include "components/contact/contact_surfaces.h"
#include "components/contact/contact_terms.h"
#include "framework/simulation/simulation.h"
#include "tests/contact/published_meshes.h"

namespace stroma::test {
namespace STROMA_TEST_FILE {

/// The same cells, whose upper and lower face begin at any of their corners.
HexahedralMesh turnedAtRandom(HexahedralMesh mesh) {
  std::mt19937 random(5);
  for (std::array<int, 8>& cell : mesh.cells) {
    const std::array<int, 8> was = cell;
    const std::size_t by = std::uniform_int_distribution<std::size_t>(0, 3)(random);
    for (std::size_t k = 0; k < 4; ++k) cell[k] = was[(k + by) % 4], cell[k + 4] = was[4 + (k + by) % 4];
  }
  return mesh;
}

/// The integral of the bilinear function of a corner over a flat quad, by Gauss points that are exact for it.
double integralOf(const std::array<Vec3, 4>& corners, std::size_t corner) {
  const double xi[4] = {-1, 1, 1, -1}, eta[4] = {-1, -1, 1, 1}, at = 1 / std::sqrt(3.0);
  double sum = 0;
  for (std::size_t p = 0; p < 4; ++p) {
    const double u = at * xi[p], v = at * eta[p];
    Vec3 along_u = Vec3::Zero(), along_v = Vec3::Zero();
    for (std::size_t k = 0; k < 4; ++k)
      along_u += 0.25 * xi[k] * (1 + eta[k] * v) * corners[k], along_v += 0.25 * eta[k] * (1 + xi[k] * u) * corners[k];
    sum += 0.25 * (1 + xi[corner] * u) * (1 + eta[corner] * v) * along_u.cross(along_v).norm();
  }
  return sum;
}

TEST(Pressures, CornersOfQuadsStandForTheirBilinearFunctions) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> off(-0.25, 0.25);
  constexpr int n = 4;
  Mesh mesh;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) mesh.position.emplace_back(i + off(random), j + off(random), 0.2 * i);
  for (Vec3& p : mesh.position) p.z() = 0.2 * p.x() - 0.1 * p.y();  // flat, and not across an axis
  std::vector<double> expected(mesh.position.size(), 0);
  for (Index j = 0; j < n; ++j)
    for (Index i = 0; i < n; ++i) {
      const Index at = i + (n + 1) * j;
      const std::array<Index, 4> around{at, at + 1, at + n + 2, at + n + 1};
      const std::size_t by = std::uniform_int_distribution<std::size_t>(0, 3)(random);
      Quad quad{};
      std::array<Vec3, 4> corners;
      for (std::size_t k = 0; k < 4; ++k) quad[k] = around[(k + by) % 4], corners[k] = mesh.position[std::size_t(quad[k])];
      for (std::size_t k = 0; k < 4; ++k) expected[std::size_t(quad[k])] += integralOf(corners, k);
      mesh.quads.push_back(quad);
    }
  contact::Surfaces surfaces;
  surfaces.addObstacle(mesh, mesh.position);
  surfaces.finish();
  double sum = 0, all = 0;
  for (std::size_t f = 0; f < surfaces.faces.size(); ++f) {
    all += surfaces.area[f];
    for (const double part : surfaces.corner_area[f]) {
      EXPECT_GT(part, 0);
      sum += part;
    }
  }
  EXPECT_NEAR(sum, all, 1e-12 * all);
  ASSERT_EQ(surfaces.rows.size(), mesh.position.size());
  for (std::size_t v = 0; v < surfaces.rows.size(); ++v)
    for (std::size_t i = 0; i < mesh.position.size(); ++i)
      if (surfaces.rest[v] == mesh.position[i]) {
        EXPECT_NEAR(surfaces.vertex_area[v], expected[i], 1e-12) << "node " << i;
      }
}

/// A search that asks for forces at one place with the shares of another one gets these, above planes too.
TEST(Pressures, SharesAreThoseOfWhereTheyWereWeighed) {
  Mesh mesh;
  mesh.position = {Vec3(0, 0, 0.5), Vec3(1, 0, 0.5), Vec3(0, 1, 0.5)};
  mesh.triangles = {{0, 1, 2}};
  contact::BarrierLaw law;
  law.range = 2, law.stiffness = 1;
  law.surfaces.addObstacle(mesh, mesh.position);
  law.surfaces.rows = {0, 1, 2};
  law.surfaces.finish();
  law.planes.push_back({Vec3::UnitZ(), 0});
  law.compile();
  std::vector<Vec3> tilted = mesh.position;
  tilted[2] = Vec3(0, 0.6, 1.3);
  const auto expectShares = [&](const std::vector<Vec3>& weighed, double share) {
    law.weigh(weighed);
    int count = 0;
    for (const contact::Touch& touch : law.touches(tilted))
      if (touch.of_surface) {
        EXPECT_NEAR(touch.share, share, 1e-12);
        ++count;
      }
    EXPECT_EQ(count, 3);
  };
  expectShares(mesh.position, 0.5 / 3);
  expectShares(tilted, 0.6 * 0.5 / 3);
}

/// The edge of a tall box between a floor and a wall: its sides are three times as large as its bottom. Where the two change places as
/// the nearest one, forces that took the share of one side for both would become three times as large at once.
TEST(Pressures, SharesDoNotJumpBetweenAFloorAndAWall) {
  const auto forces = [](double lift) {
    const Body box = boxOf(Vec3(0.05, -0.05, 0.05 + lift), Vec3(0.15, 0.05, 0.35 + lift));
    return FieldUnderTest(contactScene(bodyNode("a", box,
                                                "<BarrierContact topology=\"@mesh\" contactDistance=\"0.2\" stiffness=\"1e4\" "
                                                "boxes=\"-1 -1 -1 1 1 0  -1 -1 -1 0 1 1\"/>")),
                          "BarrierContact")
        .force();
  };
  const Vector below = forces(-1e-7), above = forces(1e-7);
  EXPECT_GT(dot(below, below), 0);
  EXPECT_LT(relativeDifference(below, above), 1e-4);
}

constexpr double young = 1e6, range = 1e-3, pressure = 1e4;

/// 1 x 1 x 0.5 in n x n cells, nu = 0. The top of what begins above 0 goes down by `way`; the bottom of the other one is held.
std::string block(const std::string& name, int n, double bottom, double way) {
  const std::vector<double> x = evenly(0, 1, n);
  const HexahedralMesh mesh = turnedAtRandom(brickOf(x, x, evenly(bottom, bottom + 0.5, std::max(2, n / 2))));
  const double end = bottom == 0 ? 0 : bottom + 0.5;
  const std::string nodes = mesh.where([end](const Vec3& p) { return std::abs(p.z() - end) < 1e-9; });
  const std::string held =
      bottom == 0 ? fmt::format("<FixedProjectiveConstraint indices=\"{}\"/>", nodes)
                  : fmt::format("<LinearMovementProjectiveConstraint indices=\"{}\" keyTimes=\"0 1\" movements=\"0 0 0  0 0 {}\"/>",
                                nodes, -way);
  return fmt::format(
      "<Node name=\"{}\">{}<MechanicalObject name=\"dofs\"/><UniformMass totalMass=\"1e-6\"/>"
      "<HexahedronFEMForceField youngModulus=\"{}\" poissonRatio=\"0\" method=\"small\"/>"
      "<PartialFixedProjectiveConstraint fixAll=\"true\" fixedDirections=\"1 1 0\"/>{}</Node>",
      name, mesh.topology(), young, held);
}

/// Of the component "contact", whichever it is.
std::vector<double> outputsOf(const Simulation& simulation, const char* name) {
  std::vector<Component*> all;
  simulation.root().collect(all);
  std::vector<double> values;
  for (const Component* component : all)
    if (component->name() == "contact") {
      std::istringstream text(component->data().find(name)->print());
      for (double value = 0; text >> value;) values.push_back(value);
    }
  return values;
}

/// The least and the largest pressure on the face at z = 0.5, and all of its area.
std::array<double, 3> pressuresOf(const std::string& scene) {
  Simulation simulation = simulationFromText(contactScene(scene, 1, Vec3::Zero(), "<StaticSolver/>"));
  expectCleanStep(simulation, 1);
  const std::vector<double> pressures = outputsOf(simulation, "pressures"), areas = outputsOf(simulation, "contactAreas");
  const State& state = *simulation.states().front();
  std::array<double, 3> found{1e300, 0, 0};
  for (std::size_t i = 0; i < state.rest_position.size(); ++i)
    if (std::abs(state.rest_position[i].z() - 0.5) < 1e-9)
      found = {std::min(found[0], pressures.at(i)), std::max(found[1], pressures.at(i)), found[2] + areas.at(i)};
  return found;
}

/// 10 kPa at each node, at rims and corners too.
TEST(Pressures, AreEvenBetweenBlocks) {
  for (const std::string method : {"BarrierContact", "PenaltyContact", "ConstraintContact"})
    for (const int n : {3, 6}) {
      SCOPED_TRACE(fmt::format("{} {}", method, n));
      // under a tenth of kappa, young/10; constraint forces keep all of it
      const double gap = method == "BarrierContact" ? 0.8285 * range : method == "PenaltyContact" ? 0.9 * range : range;
      const auto [least, most, area] = pressuresOf(
          block("a", n, 0, 0) + block("b", n, 0.5 + gap, 0.01) +
          fmt::format("<{} name=\"contact\" mstate=\"@a/dofs\" topology=\"@a/mesh\" other=\"@b/dofs\" contactDistance=\"{}\" "
                      "selfContact=\"0\"/>",
                      method, range));
      EXPECT_NEAR(least, pressure, 2e-3 * pressure);
      EXPECT_NEAR(most, pressure, 2e-3 * pressure);
      EXPECT_NEAR(area, 1, 1e-6);
    }
}

TEST(Pressures, AreEvenBelowAPlane) {
  const double gap = 0.8285 * range, way = 0.005;
  const auto [least, most, area] =
      pressuresOf(block("a", 5, 0, 0) + fmt::format("<BarrierContact name=\"contact\" mstate=\"@a/dofs\" topology=\"@a/mesh\" "
                                                    "contactDistance=\"{}\" planes=\"0 0 -1 {}\" keyTimes=\"0 1\" "
                                                    "movements=\"0 0 0  0 0 {}\"/>",
                                                    range, -0.5 - 1.01 * range, -way - 1.01 * range + gap));
  EXPECT_NEAR(least, pressure, 2e-3 * pressure);
  EXPECT_NEAR(most, pressure, 2e-3 * pressure);
  EXPECT_NEAR(area, 1, 1e-6);
}

/// Two blocks of 3 x 3 and 2 x 2 cells press each other by 10 kPa. The upper one becomes wider where it is soft, so that its rim sticks
/// out and is pushed by the rim of the lower one alone, along it and askance. There a node's force over its face is within a quarter of
/// the pressure, as meshes that do not match spread it.
TEST(Pressures, AreThoseOfTheFaceWhereARimSticksOut) {
  constexpr double nu = 0.3;
  const auto held = [](const HexahedralMesh& mesh, int axis, double at, const char* directions) {
    return fmt::format("<PartialFixedProjectiveConstraint indices=\"{}\" fixedDirections=\"{}\"/>",
                       mesh.where([&](const Vec3& p) { return std::abs(p[axis] - at) < 1e-9; }), directions);
  };
  const auto body = [&](const char* name, int n, double bottom, double top, const std::string& load) {
    const HexahedralMesh mesh = brickOf(evenly(0, 1, n), evenly(0, 1, n), evenly(bottom, top, n));
    return fmt::format("<Node name=\"{}\">{}<MechanicalObject name=\"dofs\"/><UniformMass totalMass=\"1e-6\"/>"
                       "<HexahedronFEMForceField youngModulus=\"{}\" poissonRatio=\"{}\" method=\"small\"/>{}{}{}</Node>",
                       name, mesh.topology(), young, nu, held(mesh, 0, 0, "1 0 0"), held(mesh, 1, 0, "0 1 0"),
                       load.empty() ? held(mesh, 2, bottom, "0 0 1") : load);
  };
  const double bottom = 0.943 * range, top = bottom + 0.5;
  std::string indices, forces;  // on the upper face
  for (int i = 0; i < 16; ++i) {
    const auto part = [](int k) { return k == 0 || k == 3 ? 1. / 6 : 1. / 3; };
    indices += fmt::format("{} ", 48 + i), forces += fmt::format("0 0 {}  ", -pressure * part(i % 4) * part(i / 4));
  }
  const std::string load = fmt::format("<ConstantForceField indices=\"{}\" forces=\"{}\"/>", indices, forces);
  Simulation simulation = simulationFromText(contactScene(
      body("a", 3, bottom, top, load) + body("b", 2, -0.5, 0, "") +
          fmt::format("<BarrierContact name=\"contact\" mstate=\"@a/dofs\" other=\"@b/dofs\" contactDistance=\"{}\" stiffness=\"1e6\" "
                      "selfContact=\"0\"/>",
                      range),
      1, Vec3::Zero(), "<StaticSolver relative_residual_tolerance_threshold=\"1e-8\"/>"));
  expectCleanStep(simulation, 1);
  const std::vector<double> pressures = outputsOf(simulation, "pressures");
  for (std::size_t i = 0; i < 16; ++i) EXPECT_NEAR(pressures.at(i), pressure, 0.25 * pressure) << "node " << i;
}

/// Pressures times their areas are the normal forces of nodes, which add up to that on the body and to a quarter of `force`.
void expectSum(const Simulation& simulation, double force) {
  const std::vector<double> pressures = outputsOf(simulation, "pressures"), areas = outputsOf(simulation, "contactAreas"),
                            forces = outputsOf(simulation, "contactForces"), wrenches = outputsOf(simulation, "wrenches");
  double sum = 0, of_pressures = 0;
  for (std::size_t i = 0; i < pressures.size(); ++i)
    sum += forces.at(3 * i + 2), of_pressures += pressures[i] * areas.at(i);
  EXPECT_NEAR(sum, wrenches.at(2), 1e-9 * force);
  EXPECT_NEAR(of_pressures, -sum, 0.01 * force);
  EXPECT_NEAR(-4 * sum, force, 0.05 * force);
}

/// Hertz: p0 (1 - r^2/a^2)^1/2 below a rigid sphere. The bonded layer of height H shows a half-space pressed by more than D
/// (Dimitriadis and others 2002, as in test_closed_forms.cpp), which is F; a^3 = 3 F R/(4 E*), p0 = 3 F/(2 pi a^2). What touches are
/// nodes: the radius is about a quarter of a cell larger and p0 less. The curve of that radius is met everywhere.
void expectHertz(const std::string& contact, double start, double end, double h) {
  constexpr double soft = 1e4, nu = 0.3, radius = 0.01, depth = 2e-4, height = 0.01414;
  const double reduced = soft / (1 - nu * nu), chi = std::sqrt(radius * depth) / height;
  const double of_layer = (1.2876 - 1.4678 * nu + 1.3442 * nu * nu) / (1 - nu), first = 2 * of_layer / M_PI * chi;
  const double force = 4. / 3 * reduced * std::sqrt(radius) * std::pow(depth, 1.5) * (1 + first + first * first);
  const double a = std::cbrt(3 * force * radius / (4 * reduced)), most = 3 * force / (2 * M_PI * a * a);
  const std::vector<double> x = gradedUpTo(h, 0.0018, 1.7, 0.016);
  HexahedralMesh mesh = turnedAtRandom(brickOf(x, x, downFrom(0, gradedUpTo(h, 0.0015, 1.7, height))));
  const auto held = [&](int axis, const char* directions) {
    return fmt::format("<PartialFixedProjectiveConstraint indices=\"{}\" fixedDirections=\"{}\"/>",
                       mesh.where([axis](const Vec3& p) { return std::abs(p[axis]) < 1e-12; }), directions);
  };
  Simulation simulation = simulationFromText(contactScene(
      mesh.topology() + "<MechanicalObject name=\"dofs\"/><UniformMass totalMass=\"1\"/>" + held(0, "1 0 0") + held(1, "0 1 0") +
          fmt::format("<HexahedronFEMForceField youngModulus=\"{}\" poissonRatio=\"{}\"/><FixedProjectiveConstraint indices=\"{}\"/>"
                      "<{} keyTimes=\"0 1\" movements=\"0 0 0  0 0 {}\"/>",
                      soft, nu, mesh.where([](const Vec3& p) { return p.z() < -0.99 * 0.01414; }), contact, end - depth - start),
      1, Vec3::Zero(), "<StaticSolver relative_residual_tolerance_threshold=\"1e-6\"/>"));
  expectCleanStep(simulation, 1);
  const std::vector<double> pressures = outputsOf(simulation, "pressures");
  const auto nodeAt = [&](const Vec3& at) {
    return std::size_t(std::stoi(mesh.where([&](const Vec3& p) { return (p - at).norm() < 1e-12; })));
  };
  // a node has the mean of the cells around it, whose middle is a tenth too low at this size
  constexpr double too_low = 0.1;
  EXPECT_NEAR(pressures.at(nodeAt(Vec3::Zero())) / most, 1, too_low);
  const auto hertz = [&](double r) { return std::sqrt(std::max(0.0, 1 - r * r / (a * a))); };
  int inside = 0;
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    const Vec3& p = mesh.points[i];
    const double r = std::hypot(p.x(), p.y());
    if (p.z() < -1e-12 || r > 0.9 * a) continue;
    ++inside;
    EXPECT_LT(pressures.at(i) / most, hertz(std::max(0.0, r - h))) << "r/a " << r / a;
    EXPECT_GT(pressures.at(i) / most, hertz(r + h) - too_low) << "r/a " << r / a;
    // faces around the sphere are cut into triangles at random, which moves their middle by an amount of order h^2
    const double cut = 0.02 * std::pow(h / 2.5e-4, 2);
    EXPECT_NEAR(pressures.at(i) / most, pressures.at(nodeAt({p.y(), p.x(), p.z()})) / most, cut) << "r/a " << r / a;
  }
  EXPECT_GT(inside, 0.5 * M_PI / 4 * std::pow(0.9 * a / h, 2));
  expectSum(simulation, force);
}

constexpr double hertz_radius = 0.01, hertz_gap = 3e-5;

TEST(Pressures, BelowASphereAreThoseOfHertz) {
  expectHertz(fmt::format("BarrierContact name=\"contact\" contactDistance=\"{}\" stiffness=\"1e5\" selfContact=\"0\" "
                          "spheres=\"0 0 {} {}\"",
                          hertz_gap, hertz_radius + 1.01 * hertz_gap, hertz_radius),
              1.01 * hertz_gap, 0.95 * hertz_gap, 2.5e-4);
}

/// The gap that is kept is a part of the sphere.
TEST(Pressures, BelowASphereThatIsKeptAwayAreThoseOfHertz) {
  expectHertz(fmt::format("ConstraintContact name=\"contact\" contactDistance=\"{}\" spheres=\"0 0 {} {}\"", hertz_gap,
                          hertz_radius + 0.01 * hertz_gap, hertz_radius - hertz_gap),
              0.01 * hertz_gap, 0, 5e-4);
}

/// A block on a floor that is tilted by 1 in 2: its nodes stick with mu = 0.505, slide with 0.49, and are at the gap that is kept.
TEST(Pressures, NodesOfConstraintContactSayWhetherTheySlide) {
  constexpr double g = 9.81, mass = 2;
  const double c = 1 / std::sqrt(1.25), s = 0.5 * c;
  // at 8 mm/s a step of 1e-4 s slides by less than the tolerated error of a thousandth of the gap
  for (const auto& [mu, dt] : {std::pair{0.505, 0.01}, {0.49, 0.01}, {0.49, 1e-4}}) {
    SCOPED_TRACE(fmt::format("mu {} dt {}", mu, dt));
    const std::vector<double> ticks = evenly(0, 0.1, 2);
    const HexahedralMesh low = brickOf(ticks, ticks, evenly(range, range + 0.1, 2));
    std::string speed;
    for (int i = 0; dt < 0.01 && i < 27; ++i) speed += "0.008 0 0  ";
    Simulation simulation = simulationFromText(contactScene(
        low.topology() +
            fmt::format("<MechanicalObject name=\"dofs\" velocity=\"{}\"/><UniformMass totalMass=\"{}\"/><HexahedronFEMForceField "
                        "youngModulus=\"{}\" poissonRatio=\"0\"/><ConstraintContact name=\"contact\" contactDistance=\"{}\" "
                        "friction=\"{}\" planes=\"0 0 1 0\"/>",
                        speed, mass, young, range, mu),
        dt, g * Vec3(s, 0, -c), "<EulerImplicitSolver rayleighStiffness=\"0.01\"/>"));
    for (int step = 0; step < (dt < 0.01 ? 40 : 60); ++step) expectCleanStep(simulation, step);
    const std::vector<double> states = outputsOf(simulation, "contactStates"), gaps = outputsOf(simulation, "gaps"),
                              pressures = outputsOf(simulation, "pressures"), areas = outputsOf(simulation, "contactAreas");
    const State& state = *simulation.states().front();
    double weight = 0, area = 0;
    for (std::size_t i = 0; i < state.rest_position.size(); ++i) {
      const bool is_below = state.rest_position[i].z() < 1.5 * range;
      EXPECT_EQ(states.at(i), !is_below ? 0 : mu > 0.5 ? 1 : 2) << "node " << i;
      EXPECT_NEAR(gaps.at(i), is_below ? range : 2 * range, 1e-3 * range) << "node " << i;
      weight += pressures.at(i) * areas.at(i), area += areas.at(i);
    }
    EXPECT_NEAR(area, 0.1 * 0.1, 1e-4) << "the lower face, which is strained a little";
    if (dt == 0.01) EXPECT_NEAR(weight, mass * g * c, 0.01 * mass * g * c);
  }
}

}  // namespace STROMA_TEST_FILE
}  // namespace stroma::test
