// SPDX-License-Identifier: LGPL-2.1-or-later
// References of CalculiX are made by accuracy_references.py; it says how.
//
//   torsion of a cylinder, incompressible Mooney-Rivlin:  M = pi tau a^4 (c1 + c2),  tau the angle per length
//   (Rivlin 1949, Phil. Trans. R. Soc. A 242, 173-195); of the bar here tau = 1/40 mm, a = 10 mm, c1 + c2 = 5 kPa
//
//   a thick ball of incompressible neo-Hookean rubber, radii a and b, whose inside is stretched by l:
//   p = mu/2 (g(m) - g(l)),  g(s) = 4/s + 1/s^4,  m^3 - 1 = (a/b)^3 (l^3 - 1)   (Green and Zerna 1968, section 3.10)
//
//   a block drawn to l times its height by a nominal stress P, its sides free and s times as wide, J = l s^2:
//   dW/ds = 0, P = dW/dl of W = c1 (J^-2/3 (l^2 + 2 s^2) - 3) + k0/2 (ln J)^2
//
//   a beam under its own weight q, clamped at x = 0:  u = q/24EI (6 L^2 x^2 - 4 L x^3 + x^4) + q/kGA (L x - x^2/2), so that
//   u(L/2) / u(L) = (17/384 + 3 s/8) / (1/8 + s/2), s = EI / kGA L^2 = (h/L)^2 / 5 for nu = 0 (Timoshenko 1921)
//
//   S. Land et al., "Verification of cardiac mechanics software: benchmark problems and solutions for testing active and passive
//   material behaviour", Proc. R. Soc. A 471, 20150641, 2015: of their problems 1 and 2 the middle of what the codes found
//
//   a column at the time T_v:  U = 1 - sum 2/k^2 exp(-k^2 T_v),  k = pi/2, 3 pi/2, 5 pi/2, ...   (Terzaghi 1923)
#include "tools/bench/accuracy_problems.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "tools/bench/accuracy_meshes.h"
#include "tools/bench/accuracy_quantities.h"

namespace stroma::bench {
namespace {

constexpr double organ_reference = -0.1028129625, leg_reference = -0.0005855339;  // of CalculiX, on the scenes' own meshes

/// The hexahedra of `scene` with a mean change of volume, and with one at each point.
void addDilatations(Problem& problem, const std::string& scene, const std::vector<int>& sizes, int steps = 1) {
  for (const std::string dilatation : {"mean", "local"})
    problem.ways.push_back({"hexahedra, dilatation " + dilatation, scene, {"/fem.dilatation=" + dilatation}, sizes, steps});
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
  tetrahedra("polar, exact tangent (L U)", {"method=polar"}, "five");
  tetrahedra("polar, B", {"method=polar", "tangent=warped", "updateStiffnessMatrix=true"}, "five");
  tetrahedra("svd, ten tetrahedra per cell", {"method=svd"}, "ten");
  tetrahedra("svd, six tetrahedra per cell", {"method=svd"}, "six");
  const auto hexahedra = [&](const char* name, std::vector<std::string> settings) {
    for (std::string& setting : settings) setting = "/beam/fem." + setting;
    problem.ways.push_back({name, "benchmarks/cantilever_hexahedra.xml", settings, {1, 2, 3, 4, 6}});
  };
  hexahedra("hexahedra, svd", {"method=svd"});
  hexahedra("hexahedra, svd, warped tangent", {"method=svd", "tangent=warped"});
  hexahedra("hexahedra, green", {"method=green"});
  problem.ways.push_back({"quadratic tetrahedra, svd", "benchmarks/cantilever_quadratic.xml", {}, {1, 2, 3}});
  return problem;
}

Problem pressedCube() {
  Problem problem{"cube", "bulge in the middle of a side of a pressed cube, nu = 0.499 [mm]", "CalculiX 2.20, 1728 C3D20R"};
  problem.reference = 2.90177, problem.uncertainty = 0.0067;
  problem.mesh = cubeMesh, problem.measure = cubeBulge;
  addDilatations(problem, "benchmarks/pressed_cube.xml", {2, 4, 8, 12});
  return problem;
}

Problem cook() {
  Problem problem{"cook", "upper corner of Cook's membrane, nu = 0.4999 [mm]", "CalculiX 2.20, 1152 C3D20R"};
  problem.reference = 11.3862, problem.uncertainty = 0.0047;
  problem.mesh = cookMesh, problem.measure = cookCorner;
  addDilatations(problem, "benchmarks/cook.xml", {2, 4, 8, 16, 32});
  return problem;
}

Problem twistedBar() {
  Problem problem{"twist", "torque of a round bar turned by one radian [mN mm]", "closed form (Rivlin 1949)"};
  problem.reference = std::numbers::pi / 40 * 1e4 * 5;
  problem.mesh = barMesh, problem.measure = barTorque;
  addDilatations(problem, "benchmarks/twisted_bar.xml", {2, 4, 6, 8});
  return problem;
}

/// What a scene has for its cells, and what may stand there instead.
std::string rubber(const char* c1, const char* k0) {
  return fmt::format(R"(<HexahedronHyperelasticityFEMForceField name="fem" materialName="MooneyRivlin" c1="{}" c2="0" k0="{}"/>)",
                     c1, k0);
}
const std::string rubber_of_cube = rubber("2.484989993", "2483.333333"), rubber_of_block = rubber("2.5", "2498.3333333");

std::string hooke(const char* method, const char* young, const char* poisson) {
  return fmt::format(R"(<HexahedronFEMForceField name="fem" method="{}" youngModulus="{}" poissonRatio="{}"/>)", method, young,
                     poisson);
}
/// Six tetrahedra to a cell of the grid, with this force field.
std::string tetrahedra(const std::string& field) {
  return R"(<Node name="cells"><TetrahedronSetTopologyContainer name="tetrahedra"/>)"
         R"(<Hexa2TetraTopologicalMapping name="cut" input="@../grid" output="@tetrahedra" cutting="six"/>)"
         "<" + field + R"( name="fem" mstate="@../dofs" topology="@tetrahedra"/></Node>)";
}

Problem block() {
  Problem problem{"block", "way of the top of a block of rubber drawn to 1.5 of its height, nu = 0.499 [mm]", "closed form"};
  problem.reference = 20;
  problem.mesh = blockMesh, problem.measure = blockTop;
  const std::string load = "<SurfaceTractionForceField ";
  const auto add = [&](const char* name, const std::string& field, const std::string& loaded = "") {
    problem.ways.push_back({name, "benchmarks/block.xml", {}, {1, 2, 4}, 1, {{rubber_of_block, field}, {load, load + loaded}}});
  };
  add("hexahedra, dilatation mean", rubber_of_block);
  problem.ways.push_back({"hexahedra, dilatation local", "benchmarks/block.xml", {"/fem.dilatation=local"}, {1, 2, 4}});
  add("tetrahedra", tetrahedra(R"(TetrahedronHyperelasticityFEMForceField materialName="MooneyRivlin" )"
                               R"(c1="2.5" c2="0" k0="2498.3333333")"), R"(topology="@cells/tetrahedra" )");
  for (const char* method : {"small", "large", "svd"}) add(method, hooke(method, "14.99", "0.499"));
  return problem;
}

Problem chamber() {
  Problem problem{"chamber", "growth of the inner radius of a thick ball, blown up as a ventricle [mm]",
                  "closed form (Green and Zerna 1968)"};
  problem.reference = 3, problem.uncertainty = 0.0005;  // the bulk modulus is 5000 times that of shear, not infinite
  problem.mesh = chamberMesh, problem.measure = chamberGrowth;
  addDilatations(problem, "benchmarks/chamber.xml", {1, 2, 4, 6});
  return problem;
}

const std::string muscle = R"(materialName="Costa" a="2" k0="200" bff="8" bss="2" bnn="2" bsn="2" bfs="4" bfn="4" )"
                           R"(AnisotropyDirections="1 0 0  0 1 0")";

/// Land et al.'s problem 1: z of the end between 4.14 and 4.20 mm, 1 mm at rest.
Problem muscleBar() {
  Problem problem{"muscle", "way of the end of a bar of heart muscle that a pressure bends [mm]", "Land et al. 2015, problem 1"};
  problem.reference = 3.17, problem.uncertainty = 0.03 / 3.17;
  problem.mesh = muscleMesh, problem.measure = muscleEnd;
  addDilatations(problem, "benchmarks/muscle_bar.xml", {2, 4, 6});
  problem.ways.push_back({"tetrahedra", "benchmarks/muscle_bar.xml", {}, {2, 4, 6}, 1,
                          {{"<HexahedronHyperelasticityFEMForceField name=\"fem\" " + muscle + "/>",
                            tetrahedra("TetrahedronHyperelasticityFEMForceField " + muscle)}}});
  return problem;
}

/// Land et al.'s problem 2: the inner side of the apex between z = -26.9 and -26.4 mm (as read from figure 6), -17 mm at rest.
Problem ventricle() {
  Problem problem{"ventricle", "way of the apex of a ventricle that is inflated [mm]", "Land et al. 2015, problem 2"};
  problem.reference = 9.65, problem.uncertainty = 0.25 / 9.65;
  problem.mesh = ventricleMesh, problem.measure = ventricleApex;
  addDilatations(problem, "benchmarks/ventricle.xml", {1, 2, 4, 6}, 5);
  return problem;
}

/// What has no modulus has a shape all the same.
Problem memoryBeam() {
  Problem problem{"memory", "deflection of the middle of a beam under its own weight, as a share of that of its end",
                  "closed form (Timoshenko 1921)"};
  constexpr double shear = 0.01 / 5;  // of ten heights
  problem.reference = (17. / 384 + 3 * shear / 8) / (1. / 8 + shear / 2);
  problem.mesh = memoryMesh, problem.measure = middleOverEnd;
  const std::string memory = R"(<ShapeMemoryForceField name="memory" stiffness="500"/>)";
  const auto add = [&](const char* name, std::vector<std::string> settings, std::vector<int> sizes) {
    problem.ways.push_back({name, "benchmarks/memory_beam.xml", std::move(settings), std::move(sizes)});
  };
  add("shape memory", {}, {1, 2, 4});
  add("shape memory, contour", {"/memory.nodes=contour"}, {1, 2, 4});
  add("shape memory, triangles", {"/memory.frame=triangle"}, {1, 2, 4});
  add("shape memory, no reaction", {"/memory.reaction=false"}, {1});  // finer ones find no equilibrium
  problem.ways.push_back({"hexahedra, svd", "benchmarks/memory_beam.xml", {}, {1, 2, 4}, 1, {{memory, hooke("svd", "1e6", "0")}}});
  return problem;
}

double consolidation(double time) {
  double degree = 1;
  for (int m = 0; m < 200; ++m) {
    const double k = std::numbers::pi * (m + 0.5);
    degree -= 2 / (k * k) * std::exp(-k * k * time);
  }
  return degree;
}

Problem column() {
  constexpr double time = 0.1;
  Problem problem{"column", "degree of consolidation of a wet column at T_v = 0.1", "closed form (Terzaghi 1923)"};
  problem.reference = consolidation(time);
  problem.mesh = columnMesh, problem.measure = columnDegree;
  for (const bool is_tetrahedra : {false, true}) {
    const std::string cells = is_tetrahedra ? "tetrahedra" : "hexahedra";
    const std::string scene = is_tetrahedra ? "benchmarks/column_tetrahedra.xml" : "benchmarks/column.xml";
    const std::string fluid = is_tetrahedra ? "/column/cells/fluid." : "/column/fluid.";
    for (const int steps : {10, 40, 160})
      problem.ways.push_back({fmt::format("{}, {} steps", cells, steps), scene, {fmt::format("dt={}", time / steps)},
                              {5, 10, 20, 40}, steps});
    // a fluid that is less stiff than its tissue: this coupling bears no other
    problem.ways.push_back({fmt::format("{}, semi-implicit, 40", cells), scene,
                            {fmt::format("dt={}", time / 40), fluid + "coupling=semi_implicit", fluid + "limitModulus=900",
                             fluid + "biotModulus=700", fluid + "permeability=0.00214285714286"},
                            {5, 10, 20, 40}, 40});
  }
  return problem;
}

Problem leg() {
  Problem problem{"leg", "dent under the strap of a leg of bone and soft tissue, linear [m]", "CalculiX 2.20, C3D4 of the same mesh"};
  problem.reference = leg_reference, problem.uncertainty = 1e-5;
  problem.mesh = ownMesh, problem.measure = legDent;
  const std::string condensed = R"(<CondensedStaticSolver name="solver"/>)";
  const std::string statics = R"(<StaticSolver name="solver"/>)";
  const auto add = [&](const char* name, const std::string& solvers) {
    problem.ways.push_back({name, "benchmarks/condensed_leg.xml", {}, {0}, 1, {{condensed, solvers}}});
  };
  add("condensed", condensed);
  add("whole, SparseLDLSolver", statics + "<SparseLDLSolver/>");
  add("whole, CGLinearSolver", statics + R"(<CGLinearSolver iterations="5000" tolerance="1e-10"/>)");
  add("whole, solver chosen", statics);
  return problem;
}

Problem organ() {
  Problem problem{"organ", "way of the end of an organ that is pulled aside [m]",
                  "CalculiX 2.20, St. Venant-Kirchhoff, C3D4 of the same mesh"};
  problem.reference = organ_reference, problem.uncertainty = 1e-5;
  problem.mesh = ownMesh, problem.measure = organTip;
  const std::string law = R"(<TetrahedronHyperelasticityFEMForceField name="fem" materialName="StVenantKirchhoff" )"
                          R"(youngModulus="10000" poissonRatio="0.45"/>)";
  const auto add = [&](const std::string& name, const std::string& field) {
    problem.ways.push_back({name, "benchmarks/pulled_organ.xml", {}, {0}, 1, {{law, field}}});
  };
  add("St. Venant-Kirchhoff", law);
  problem.ways.push_back({"neo-Hookean", "benchmarks/pulled_organ.xml", {"/organ/fem.materialName=NeoHookean"}, {0}});
  for (const char* method : {"small", "large", "polar", "svd"})
    add(method, fmt::format(R"(<TetrahedronFEMForceField name="fem" method="{}" youngModulus="10000" poissonRatio="0.45"/>)",
                            method));
  return problem;
}

/// The cube of Kerdok et al. 2003 that Nesme et al. 2005 compare with, pressed by 18.25 %.
Problem truthCube(const std::string& file) {
  Problem problem{"beads", "mean distance of the truth cube's beads under 18.25 %, of its edge of 80 mm [mm]",
                  "what was measured (Kerdok et al. 2003)"};
  problem.size = 80;
  problem.mesh = cubeMesh;
  if (file.empty()) {
    problem.left_out = "its measured beads are not here: --beads FILE";
    return problem;
  }
  problem.measure = [beads = readBeads(file)](const Simulation& simulation) { return beadDistance(simulation, beads); };
  const auto add = [&](const char* name, const std::string& field, std::vector<std::string> settings = {}) {
    settings.push_back("/plate.movements=0 0 0  0 0 -14.6");
    problem.ways.push_back({name, "benchmarks/pressed_cube.xml", std::move(settings), {2, 4, 8, 12}, 1,
                            {{rubber_of_cube, field}}});
  };
  add("hexahedra, dilatation mean", rubber_of_cube);
  add("hexahedra, dilatation local", rubber_of_cube, {"/fem.dilatation=local"});
  add("hexahedra, svd", hooke("svd", "14.9", "0.499"));
  add("hexahedra, small", hooke("small", "14.9", "0.499"));
  add("tetrahedra, svd", tetrahedra(R"(TetrahedronFEMForceField method="svd" youngModulus="14.9" poissonRatio="0.499")"));
  return problem;
}

}  // namespace

std::vector<Problem> staticProblems(const std::string& beads) {
  return {beam(),    pressedCube(), truthCube(beads), block(),  cook(), twistedBar(), chamber(),
          ventricle(), muscleBar(),   column(),         organ(), leg(),  memoryBeam()};
}

}  // namespace stroma::bench
