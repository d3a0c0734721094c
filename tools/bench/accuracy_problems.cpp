// SPDX-License-Identifier: LGPL-2.1-or-later
// References of CalculiX are made by accuracy_references.py; it says how.
//
//   torsion of a cylinder, incompressible Mooney-Rivlin:  M = pi tau a^4 (c1 + c2),  tau the angle per length
//   (Rivlin 1949, Phil. Trans. R. Soc. A 242, 173-195); of the bar here tau = 1/40 mm, a = 10 mm, c1 + c2 = 5 kPa
#include "tools/bench/accuracy_problems.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

namespace stroma::bench {
namespace {

/// Mean displacement along an axis of the nodes that `where` chooses at rest.
template <class Where>
double meanDisplacement(const Simulation& simulation, int axis, Where&& where) {
  const State& state = *simulation.states().at(0);
  double sum = 0;
  int count = 0;
  for (Index i = 0; i < state.size(); ++i)
    if (const Vec3& rest = state.rest_position[std::size_t(i)]; where(rest))
      sum += state.x()[i][axis] - rest[axis], ++count;
  return sum / count;
}

double beamEnd(const Simulation& simulation) {
  return meanDisplacement(simulation, 1, [](const Vec3& p) { return p.x() > 0.2 - 1e-9; });
}
double cookCorner(const Simulation& simulation) {
  return meanDisplacement(simulation, 1, [](const Vec3& p) { return p.x() > 48 - 1e-6 && p.y() > 60 - 1e-6; });
}
double cubeBulge(const Simulation& simulation) {
  return meanDisplacement(simulation, 0, [](const Vec3& p) {
    return p.x() > 80 - 1e-6 && std::abs(p.y() - 40) < 1e-6 && std::abs(p.z() - 40) < 1e-6;
  });
}

/// Of the forces that hold the lower end, about the axis.
double barTorque(const Simulation& simulation) {
  const System& system = *simulation.systems().at(0);
  const State& state = *simulation.states().at(0);
  Vector v(system.allRows()), force(system.allRows());
  for (ForceField* field : system.forceFields()) field->addForce(system.x, v, force);
  double torque = 0;
  for (Index i = 0; i < state.size(); ++i)
    if (state.rest_position[std::size_t(i)].z() < 1e-6)
      torque += Vec3(system.x[i]).cross(Vec3(force[state.firstRow() + i])).z();
  return std::abs(torque);
}

std::vector<std::string> beamMesh(int cells) {
  return {fmt::format("/beam/grid.n={} {} {}", 10 * cells + 1, cells + 1, cells + 1)};
}
std::vector<std::string> cubeMesh(int cells) {
  return {fmt::format("/grid.n={0} {0} {0}", cells + 1)};
}
std::vector<std::string> barMesh(int cells) {
  return {fmt::format("/grid.n={0} {0} {1}", cells + 1, 2 * cells + 1)};
}
/// n x n cells of a plate, one across its thickness.
std::vector<std::string> cookMesh(int n) {
  std::string position, cells;
  const auto node = [n](int i, int j, int k) { return (k * (n + 1) + j) * (n + 1) + i; };
  for (int k = 0; k < 2; ++k)
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= n; ++i) {
        const double s = double(i) / n, low = 44 * s, high = 44 + 16 * s;
        position += fmt::format("{} {} {} ", 48 * s, low + (high - low) * j / n, k);
        if (k > 0 || i == n || j == n) continue;
        for (int a : {0, 1})
          cells += fmt::format("{} {} {} {} ", node(i, j, a), node(i + 1, j, a), node(i + 1, j + 1, a), node(i, j + 1, a));
      }
  return {"/mesh.position=" + position, "/mesh.hexahedra=" + cells};
}

Problem beam() {
  Problem problem{"beam", "deflection of a cantilever bent to 30 % of its length [m]", "CalculiX 2.20, 1620 C3D20R"};
  problem.reference = -0.0604762, problem.uncertainty = 0.00045;
  problem.mesh = beamMesh, problem.measure = beamEnd;
  const auto tetrahedra = [&](const char* name, std::vector<std::string> settings, const char* cutting) {
    for (std::string& setting : settings) setting = "/beam/cells/fem." + setting;
    settings.push_back(std::string("/beam/cells/cut.cutting=") + cutting);
    problem.ways.push_back({name, "benchmarks/cantilever.xml", settings, {1, 2, 3, 4, 6}});
  };
  tetrahedra("small", {"method=small", "tangent=warped"}, "five");
  tetrahedra("large", {"method=large", "tangent=warped"}, "five");
  tetrahedra("large, exact tangent (L U)", {"method=large"}, "five");
  tetrahedra("large, B", {"method=large", "tangent=warped", "updateStiffnessMatrix=true"}, "five");
  tetrahedra("svd", {"method=svd"}, "five");
  tetrahedra("svd, warped tangent", {"method=svd", "tangent=warped"}, "five");
  tetrahedra("polar", {"method=polar", "tangent=warped"}, "five");
  tetrahedra("polar, B", {"method=polar", "tangent=warped", "updateStiffnessMatrix=true"}, "five");
  tetrahedra("svd, ten tetrahedra per cell", {"method=svd"}, "ten");
  tetrahedra("svd, six tetrahedra per cell", {"method=svd"}, "six");
  const auto hexahedra = [&](const char* name, const char* method) {
    problem.ways.push_back({name, "benchmarks/cantilever_hexahedra.xml", {std::string("/beam/fem.method=") + method},
                            {1, 2, 3, 4, 6}});
  };
  hexahedra("hexahedra, svd", "svd");
  hexahedra("hexahedra, green", "green");
  problem.ways.push_back({"quadratic tetrahedra, svd", "benchmarks/cantilever_quadratic.xml", {}, {1, 2, 3}});
  return problem;
}

Problem pressedCube() {
  Problem problem{"cube", "bulge in the middle of a side of a pressed cube, nu = 0.499 [mm]", "CalculiX 2.20, 1728 C3D20R"};
  problem.reference = 2.90177, problem.uncertainty = 0.0067;
  problem.mesh = cubeMesh, problem.measure = cubeBulge;
  for (const char* dilatation : {"mean", "local"})
    problem.ways.push_back({std::string("hexahedra, dilatation ") + dilatation, "benchmarks/pressed_cube.xml",
                            {std::string("/fem.dilatation=") + dilatation}, {2, 4, 8, 12}});
  return problem;
}

Problem cook() {
  Problem problem{"cook", "upper corner of Cook's membrane, nu = 0.4999 [mm]", "CalculiX 2.20, 1152 C3D20R"};
  problem.reference = 11.3862, problem.uncertainty = 0.0047;
  problem.mesh = cookMesh, problem.measure = cookCorner;
  for (const char* dilatation : {"mean", "local"})
    problem.ways.push_back({std::string("hexahedra, dilatation ") + dilatation, "benchmarks/cook.xml",
                            {std::string("/fem.dilatation=") + dilatation}, {2, 4, 8, 16, 32}});
  return problem;
}

Problem twistedBar() {
  Problem problem{"twist", "torque of a round bar turned by one radian [mN mm]", "closed form (Rivlin 1949)"};
  problem.reference = std::numbers::pi / 40 * 1e4 * 5;
  problem.mesh = barMesh, problem.measure = barTorque;
  for (const char* dilatation : {"mean", "local"})
    problem.ways.push_back({std::string("hexahedra, dilatation ") + dilatation, "benchmarks/twisted_bar.xml",
                            {std::string("/fem.dilatation=") + dilatation}, {2, 4, 6, 8}});
  return problem;
}

}  // namespace

std::vector<Problem> staticProblems() { return {beam(), pressedCube(), cook(), twistedBar()}; }

}  // namespace stroma::bench
